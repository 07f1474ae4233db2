// Phong and Blinn-Phong lobes, normalised. Twin of src/phong.rs. 0 where a cosine is <= 0.

import package::real;

// Beyond this argument exp(-x) is subnormal.
const exp_limit: f32 = 87.0;
const pi: f32 = 3.14159265358979324;

// (n+2)/(2 pi)·max(0, R·V)ⁿ.
fn phong(wi: vec3f, wo: vec3f, exponent: f32) -> f32 {
    // 1 - R·V = |R-V|²/2 with R = (-x, -y, z).
    let difference = vec3f(wi.x + wo.x, wi.y + wo.y, wi.z - wo.z);
    let deficit = 0.5 * dot(difference, difference);
    let lit = wi.z > 0.0 && wo.z > 0.0 && deficit < 1.0;
    let argument = exponent * -real::ln_one_plus(-select(0.0, deficit, lit));
    let inside = lit && argument <= exp_limit;
    let power = exp(-select(0.0, argument, inside));
    return select(0.0, 0.5 * (exponent + 2.0) / pi * power, inside);
}

// (n+2)(n+4)/(8 pi (n+2^(-n/2)))·NHⁿ.
fn blinn_phong(wi: vec3f, wo: vec3f, exponent: f32) -> f32 {
    let lit = wi.z > 0.0 && wo.z > 0.0;
    let h = wi + wo;
    let z = select(1.0, h.z, lit);
    // NHⁿ = exp(-(n/2)·ln(1+tan²)).
    let argument = 0.5 * exponent * real::ln_one_plus(select(0.0, h.x * h.x + h.y * h.y, lit) / (z * z));
    let inside = lit && argument <= exp_limit;
    let power = exp(-select(0.0, argument, inside));
    let denominator = exponent + exp(-(0.3465735902799726547 * exponent));
    return select(0.0, (exponent + 2.0) * (exponent + 4.0) / (8.0 * pi * denominator) * power, inside);
}
