// Masks: 0 where the ground shows, 1 where the cover does. Twin of src/texture/mask.rs.

// 0 where value <= at, else 1.
fn threshold(value: f32, at: f32) -> f32 {
    return select(0.0, 1.0, value > at);
}

// smoothstep(at - softness, at + softness, value); a sharp edge at softness <= 0.
fn soft_threshold(value: f32, at: f32, softness: f32) -> f32 {
    let sharp = softness <= 0.0;
    let width = 2.0 * select(softness, 0.5, sharp);
    let t = clamp((value - (at - softness)) / width, 0.0, 1.0);
    return select(t * t * (3.0 - 2.0 * t), threshold(value, at), sharp);
}

// 0 at black, 1 at white, linear between; a sharp edge where they are equal.
fn grey(value: f32, black: f32, white: f32) -> f32 {
    let width = white - black;
    let sharp = !(width < 0.0 || width > 0.0);
    let t = clamp((value - black) / select(width, 1.0, sharp), 0.0, 1.0);
    return select(t, threshold(value, black), sharp);
}
