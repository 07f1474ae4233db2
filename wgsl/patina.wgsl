// The documents' patina. Twin of src/material/patina.rs.

// 1 - smoothstep(extent - transition, extent + transition, value); a sharp edge at transition 0.
fn patina_extent(extent: f32, transition: f32, value: f32) -> f32 {
    let width = 2.0 * transition;
    let sharp = width <= 0.0;
    let t = clamp((value - (extent - transition)) / select(width, 1.0, sharp), 0.0, 1.0);
    let soft = 1.0 - t * t * (3.0 - 2.0 * t);
    return select(soft, select(0.0, 1.0, value <= extent), sharp);
}

// (1-sigma)(1-F)·NL, the diffuse light as the listing adds it: negative for sigma > 1.
fn diffuse_as_printed(sigma: f32, fresnel: f32, cos_i: f32) -> f32 {
    return (1.0 - sigma) * (1.0 - fresnel) * max(cos_i, 0.0);
}
