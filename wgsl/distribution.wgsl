// Microfacet normal distributions, normalised: the integral of D·cos is 1. Twin of src/distribution.rs.
// h is a local half vector of any length; h.z <= 0 gives 0. Widths in [1e-4, 1].

import package::real;

// Beyond this argument exp(-x) is subnormal.
const exp_limit: f32 = 87.0;
const pi: f32 = 3.14159265358979324;

fn beckmann(h: vec3f, alpha: f32) -> f32 {
    let z = select(1.0, h.z, h.z > 0.0);
    let tan_squared = (h.x * h.x + h.y * h.y) / (z * z);
    let alpha_squared = alpha * alpha;
    let exponent = tan_squared / alpha_squared;
    let inside = h.z > 0.0 && exponent <= exp_limit;
    let power = exp(-select(0.0, exponent, inside));
    return select(0.0, (1.0 + tan_squared) * (1.0 + tan_squared) * power / (pi * alpha_squared), inside);
}

fn beckmann_anisotropic(h: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {
    let z = select(1.0, h.z, h.z > 0.0);
    let x = h.x / (z * alpha_x);
    let y = h.y / (z * alpha_y);
    let exponent = x * x + y * y;
    let inside = h.z > 0.0 && exponent <= exp_limit;
    let inverse_cos_squared = 1.0 + (h.x * h.x + h.y * h.y) / (z * z);
    let power = exp(-select(0.0, exponent, inside));
    return select(0.0, inverse_cos_squared * inverse_cos_squared * power / (pi * alpha_x * alpha_y), inside);
}

fn ggx(h: vec3f, alpha: f32) -> f32 {
    let z = select(1.0, h.z, h.z > 0.0);
    let s = h.x * h.x + h.y * h.y;
    let z_squared = z * z;
    let ratio = alpha * (s + z_squared) / (s + alpha * alpha * z_squared);
    return select(0.0, ratio * ratio / pi, h.z > 0.0);
}

fn ggx_anisotropic(h: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {
    let z = select(1.0, h.z, h.z > 0.0);
    let x = h.x / alpha_x;
    let y = h.y / alpha_y;
    let ratio = (h.x * h.x + h.y * h.y + z * z) / (x * x + y * y + z * z);
    return select(0.0, ratio * ratio / (pi * alpha_x * alpha_y), h.z > 0.0);
}

fn blinn(h: vec3f, alpha: f32) -> f32 {
    let z = select(1.0, h.z, h.z > 0.0);
    let alpha_squared = alpha * alpha;
    let half_exponent = (1.0 - alpha) * (1.0 + alpha) / alpha_squared;
    let exponent = half_exponent * real::ln_one_plus((h.x * h.x + h.y * h.y) / (z * z));
    let inside = h.z > 0.0 && exponent <= exp_limit;
    return select(0.0, exp(-select(0.0, exponent, inside)) / (pi * alpha_squared), inside);
}

fn blinn_anisotropic(h: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {
    let z = select(1.0, h.z, h.z > 0.0);
    let s = h.x * h.x + h.y * h.y;
    let x = h.x / alpha_x;
    let y = h.y / alpha_y;
    // The azimuthal mean of 1/alpha² is (x²+y²)/s.
    let across = s > 0.0;
    let half_exponent = max(select(1.0, (x * x + y * y) / select(1.0, s, across), across) - 1.0, 0.0);
    let exponent = half_exponent * real::ln_one_plus(s / (z * z));
    let inside = h.z > 0.0 && exponent <= exp_limit;
    return select(0.0, exp(-select(0.0, exponent, inside)) / (pi * alpha_x * alpha_y), inside);
}

// The normalisation is a constant of the material: gaussian_normalisation of the Rust crate.
fn gaussian(h: vec3f, alpha: f32, normalisation: f32) -> f32 {
    let z = select(1.0, h.z, h.z > 0.0);
    let angle = real::angle(sqrt(h.x * h.x + h.y * h.y), z) / alpha;
    let exponent = angle * angle;
    let inside = h.z > 0.0 && exponent <= exp_limit;
    return select(0.0, normalisation * exp(-select(0.0, exponent, inside)), inside);
}
