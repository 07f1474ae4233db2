// The documents' patina. Twin of src/material/patina.rs.

// 1 - smoothstep(extent - transition, extent + transition, value); a sharp edge at transition 0.
fn patina_extent(extent: f32, transition: f32, value: f32) -> f32 {
    let width = 2.0 * transition;
    let sharp = width <= 0.0;
    let t = clamp((value - (extent - transition)) / select(width, 1.0, sharp), 0.0, 1.0);
    let soft = 1.0 - t * t * (3.0 - 2.0 * t);
    return select(soft, select(0.0, 1.0, value <= extent), sharp);
}
