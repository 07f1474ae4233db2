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

    // The polar angle is the larger where the cosine is the smaller; of two rounded to one cosine, where the sine is larger,
    // or the order of the two would show.
    let i_larger = (cos_i < cos_o) | ((cos_i <= cos_o) & (sin_i > sin_o));
    let sin_alpha = select(sin_o, sin_i, i_larger);
    let sin_beta = select(sin_i, sin_o, i_larger);
    let least = min(cos_i, cos_o);
    let most = max(cos_i, cos_o);
    let alpha_share = real::angle(sin_alpha, least) * (2.0 * frac_pi);
    // The smaller polar angle, measured from grazing, where the terms that hold it meet tangents.
    let delta = real::angle(most, sin_beta) * (2.0 * frac_pi);
    let beta_share = 1.0 - delta;

    // The cosine of the azimuth between the directions, times both sines; and alone.
    let across = wi.x * wo.x + wi.y * wo.y;
    let tilted = sin_i * sin_o > 0.0;
    let product = select(1.0, sin_i * sin_o, tilted);
    let azimuth = clamp(across / product, -1.0, 1.0);
    // 1-|cosine| as sin²/(1+|cosine|): at grazing it meets a tangent that would magnify its cancellation.
    let sine = (wi.x * wo.y - wi.y * wo.x) / product;
    let sideways = select(1.0, sine * sine / (1.0 + abs(azimuth)), tilted);

    let ratio = variance / (variance + 0.09);
    let c_one = 1.0 - 0.5 * variance / (variance + 0.33);
    let dent = delta * (3.0 - delta * (3.0 - delta)) - least * least / (1.0 + sin_alpha);
    let c_two = 0.45 * ratio * select(across / most, azimuth * (sin_beta / most) * dent, azimuth < 0.0);
    let angles = alpha_share * beta_share;
    let half_tangent = (sin_alpha + sin_beta) / (least + most);
    let c_three = 0.125 * ratio * angles * angles * sideways * half_tangent;
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
