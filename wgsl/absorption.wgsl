// Bouguer-Lambert-Beer absorption. Twin of src/absorption.rs.

import package::real;

// exp(-sigma·thickness·(1/cos_i + 1/cos_o)); the cosines are those inside the layer.
fn transmittance(sigma: f32, thickness: f32, cos_i: f32, cos_o: f32) -> f32 {
    let clear = sigma <= 0.0 || thickness <= 0.0;
    let blocked = cos_i <= 0.0 || cos_o <= 0.0;
    let path = 1.0 / select(cos_i, 1.0, blocked) + 1.0 / select(cos_o, 1.0, blocked);
    let depth = select(sigma * thickness, 0.0, clear);
    return select(select(real::exp_product(depth, path), 0.0, blocked), 1.0, clear);
}
