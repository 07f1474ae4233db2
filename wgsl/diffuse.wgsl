// Lambert and Oren-Nayar. Twin of src/diffuse.rs. Results are 0 where a cosine is <= 0.

import package::real;

// The parts of the Oren-Nayar model: f = albedo/pi·(direct + albedo·interreflection).
struct OrenNayar {
    direct: f32,
    interreflection: f32,
}

const frac_pi: f32 = 0.318309886183790672;

fn lambert(albedo: f32) -> f32 {
    return albedo * frac_pi;
}

// The full model of 1994 with interreflection; sigma is the standard deviation of the slope angle in radians.
fn oren_nayar(wi: vec3f, wo: vec3f, sigma: f32) -> OrenNayar {
    let variance = sigma * sigma;
    let lit = wi.z > 0.0 && wo.z > 0.0;
    let sin_i = sqrt(wi.x * wi.x + wi.y * wi.y);
    let sin_o = sqrt(wo.x * wo.x + wo.y * wo.y);
    let cos_i = select(1.0, wi.z, lit);
    let cos_o = select(1.0, wo.z, lit);

    // The polar angle is the larger where the cosine is the smaller.
    let i_larger = cos_i < cos_o;
    let sin_alpha = select(sin_o, sin_i, i_larger);
    let sin_beta = select(sin_i, sin_o, i_larger);
    let least = min(cos_i, cos_o);
    let most = max(cos_i, cos_o);
    let alpha = real::angle(sin_alpha, least);
    let beta = real::angle(sin_beta, most);

    // The cosine of the azimuth between the directions, times both sines; and alone.
    let across = wi.x * wo.x + wi.y * wo.y;
    let product = sin_i * sin_o;
    let azimuth = clamp(across / select(1.0, product, product > 0.0), -1.0, 1.0);

    let beta_share = beta * (2.0 * frac_pi);
    let angles = alpha * (2.0 * frac_pi) * beta_share;
    let common = variance / (variance + 0.09);
    let c_one = 1.0 - 0.5 * variance / (variance + 0.33);
    let backward = min(azimuth, 0.0) * (sin_beta / most) * (beta_share * beta_share * beta_share);
    let c_two = 0.45 * common * (across / most - backward);
    let half_tangent = (sin_alpha + sin_beta) / (least + most);
    let c_three = 0.125 * common * angles * angles * (1.0 - abs(azimuth)) * half_tangent;
    let second = 0.17 * variance / (variance + 0.13);
    return OrenNayar(
        select(0.0, c_one + c_two + c_three, lit),
        select(0.0, second * (1.0 - azimuth * beta_share * beta_share), lit));
}

// The qualitative model, in sr⁻¹.
fn oren_nayar_qualitative(wi: vec3f, wo: vec3f, sigma: f32, albedo: f32) -> f32 {
    let variance = sigma * sigma;
    let lit = wi.z > 0.0 && wo.z > 0.0;
    let most = select(1.0, max(wi.z, wo.z), lit);
    let across = max(wi.x * wo.x + wi.y * wo.y, 0.0);
    let a = 1.0 - 0.5 * variance / (variance + 0.57);
    let b = 0.45 * variance / (variance + 0.09);
    return select(0.0, albedo * frac_pi * (a + b * across / most), lit);
}
