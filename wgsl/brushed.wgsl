// Brushed metal: conductors with a width along the tangent and one along the bitangent. Twin of src/material/brushed.rs.

import package::distribution;
import package::fresnel;
import package::masking;
import package::microfacet::cos_half;
import package::real;

// The largest f32 below 1.
const _below_one: f32 = 0x1.fffffep-1;

// D·V of GGX under Smith's masking of correlated heights.
fn ggx(wi: vec3f, wo: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {
    return distribution::ggx_anisotropic(_upper(wi, wo), alpha_x, alpha_y)
        * masking::smith_ggx(wi, wo, alpha_x, alpha_y).visibility;
}

// D·V of Beckmann's distribution under V-cavities.
fn beckmann(wi: vec3f, wo: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {
    let h = _upper(wi, wo);
    return distribution::beckmann_anisotropic(h, alpha_x, alpha_y) * masking::v_cavity(wi.z, wo.z, h).visibility;
}

// F·D·V of a conductor n + ik, by GGX.
fn evaluate_ggx(wi: vec3f, wo: vec3f, n: vec3f, k: vec3f, alpha_x: f32, alpha_y: f32) -> vec3f {
    return _reflectance(wi, wo, n, k) * ggx(wi, wo, alpha_x, alpha_y);
}

// F·D·V of a conductor n + ik, by Beckmann's distribution.
fn evaluate_beckmann(wi: vec3f, wo: vec3f, n: vec3f, k: vec3f, alpha_x: f32, alpha_y: f32) -> vec3f {
    return _reflectance(wi, wo, n, k) * beckmann(wi, wo, alpha_x, alpha_y);
}

// A direction that GGX facets reflect wo to, drawn from the normals that wo sees (Dupuy & Benyoub 2023).
fn reflect_visible_ggx(wo: vec3f, alpha_x: f32, alpha_y: f32, u: vec2f) -> vec3f {
    let stretched = vec3f(alpha_x * wo.x, alpha_y * wo.y, wo.z);
    let square = dot(stretched, stretched);
    let v = stretched * (1.0 / sqrt(select(1.0, square, square > 0.0)));
    // The cap reaches from the pole down to -v.z; fall is the way down to the point.
    let share = _inside(u.y);
    let reach = 1.0 + v.z;
    let fall = share * reach;
    let radius = sqrt(max(fall * (2.0 - fall), 0.0));
    let circle = real::unit_circle(u.x);
    let m = vec3f(alpha_x * (radius * circle.x + v.x), alpha_y * (radius * circle.y + v.y), (1.0 - share) * reach);
    let length_squared = dot(m, m);
    return m * (2.0 * dot(wo, m) / select(1.0, length_squared, length_squared > 0.0)) - wo;
}

// The density with which reflect_visible_ggx draws wi: D/(4·projected area).
fn reflect_visible_ggx_pdf(wi: vec3f, wo: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {
    let area = masking::projected_area_ggx(wo, alpha_x, alpha_y);
    return distribution::ggx_anisotropic(_upper(wi, wo), alpha_x, alpha_y) / (4.0 * select(1.0, area, wo.z > 0.0));
}

// A direction that Beckmann's facets reflect wo to, drawn from the normals that wo sees of V-cavities.
fn reflect_visible_beckmann(wo: vec3f, alpha_x: f32, alpha_y: f32, u: vec3f) -> vec3f {
    let radius = sqrt(max(-real::ln_one_plus(-_inside(u.y)), 0.0));
    let circle = real::unit_circle(u.z);
    let x = alpha_x * radius * circle.x;
    let y = alpha_y * radius * circle.y;
    let across = x * wo.x + y * wo.y;
    let sign = select(-1.0, 1.0, 2.0 * wo.z * _inside(u.x) < wo.z + across);
    let square = x * x + y * y;
    let scale = 1.0 / (1.0 + square);
    let along = 2.0 * (wo.z + sign * across) * scale;
    return vec3f(along * (sign * x) - wo.x, along * (sign * y) - wo.y,
        (wo.z * (1.0 - square) + 2.0 * (sign * across)) * scale);
}

// The density with which reflect_visible_beckmann draws wi, D·G1/(4 cos_o).
fn reflect_visible_beckmann_pdf(wi: vec3f, wo: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {
    let h = _upper(wi, wo);
    let lit = h.z > 0.0;
    let seen = min(h.z / select(1.0, dot(h, h), lit), 1.0 / select(1.0, 4.0 * wo.z, lit));
    return distribution::beckmann_anisotropic(h, alpha_x, alpha_y) * seen;
}

// The half vector; one at the horizon, where D is 0, for directions of which one is not above it.
fn _upper(wi: vec3f, wo: vec3f) -> vec3f {
    let h = wi + wo;
    return vec3f(h.x, h.y, select(0.0, h.z, wi.z > 0.0 && wo.z > 0.0));
}

fn _reflectance(wi: vec3f, wo: vec3f, n: vec3f, k: vec3f) -> vec3f {
    let c = cos_half(wi, wo);
    return vec3f(fresnel::conductor(c, n.x, k.x).reflectance, fresnel::conductor(c, n.y, k.y).reflectance,
        fresnel::conductor(c, n.z, k.z).reflectance);
}

// A number clamped to [0, 1), to the largest below 1.
fn _inside(u: f32) -> f32 {
    return min(clamp(u, 0.0, 1.0), _below_one);
}
