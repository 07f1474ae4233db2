// Masking-shadowing G and visibility V = G/(4 cos_i cos_o). Twin of src/masking.rs. Both are 0 where a cosine is <= 0.

import package::real;

struct Masking {
    g: f32,
    visibility: f32,
}

// The V-cavities of Torrance and Sparrow; h = wi + wo.
fn v_cavity(cos_i: f32, cos_o: f32, h: vec3f) -> Masking {
    let inside = cos_i > 0.0 && cos_o > 0.0;
    let least = min(cos_i, cos_o);
    let most = select(1.0, max(cos_i, cos_o), inside);
    let length_squared = select(1.0, dot(h, h), inside);
    // NH/VH = 2hz/|h|².
    let edge = length_squared / (2.0 * select(1.0, h.z, inside));
    let visibility = 0.5 / (most * max(2.0 * select(1.0, least, inside), edge));
    return Masking(select(0.0, min(2.0 * least / edge, 1.0), inside), select(0.0, visibility, inside));
}

// Smith's masking for GGX, height-correlated.
fn smith_ggx(wi: vec3f, wo: vec3f, alpha_x: f32, alpha_y: f32) -> Masking {
    return _correlated(wi.z, wo.z, 0.5 * _stretched_length(wi, alpha_x, alpha_y), 0.5 * _stretched_length(wo, alpha_x, alpha_y));
}

fn smith_ggx_separable(wi: vec3f, wo: vec3f, alpha_x: f32, alpha_y: f32) -> Masking {
    return _separable(wi.z, wo.z, projected_area_ggx(wi, alpha_x, alpha_y), projected_area_ggx(wo, alpha_x, alpha_y));
}

// Smith's masking for Beckmann's distribution, height-correlated.
fn smith_beckmann(wi: vec3f, wo: vec3f, alpha_x: f32, alpha_y: f32) -> Masking {
    let i = _beckmann_lambda(wi, alpha_x, alpha_y);
    let o = _beckmann_lambda(wo, alpha_x, alpha_y);
    return _correlated(wi.z, wo.z, 0.5 * i.x + i.y, 0.5 * o.x + o.y);
}

fn smith_beckmann_separable(wi: vec3f, wo: vec3f, alpha_x: f32, alpha_y: f32) -> Masking {
    return _separable(wi.z, wo.z,
        projected_area_beckmann(wi, alpha_x, alpha_y), projected_area_beckmann(wo, alpha_x, alpha_y));
}

// cos·(1+Lambda), the projected area of the microsurface that faces w.
fn projected_area_ggx(w: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {
    return 0.5 * (w.z + _stretched_length(w, alpha_x, alpha_y));
}

// The length of w with its tangential components stretched by the widths: cos·(1+2·Lambda).
fn _stretched_length(w: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {
    let x = alpha_x * w.x;
    let y = alpha_y * w.y;
    return sqrt(w.z * w.z + x * x + y * y);
}

fn projected_area_beckmann(w: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {
    let parts = _beckmann_lambda(w, alpha_x, alpha_y);
    return parts.x + parts.y;
}

// The cosine, at least 0, and cos·Lambda.
fn _beckmann_lambda(w: vec3f, alpha_x: f32, alpha_y: f32) -> vec2f {
    let x = alpha_x * w.x;
    let y = alpha_y * w.y;
    let s = sqrt(x * x + y * y);
    // From a = 7 on Lambda is below the precision.
    let z = max(w.z, 0.0);
    let tilted = z < 7.0 * s;
    let a = select(0.0, z, tilted) / select(1.0, s, tilted);
    let lambda = 0.5 * exp(-(a * a)) * (s * 0.56418958354775628695 - z * real::erfcx(a));
    return vec2f(z, select(0.0, lambda, tilted));
}

// Kelemen & Szirmay-Kalos 2001: V = 1/|wi+wo|².
fn kelemen(cos_i: f32, cos_o: f32, h: vec3f) -> Masking {
    let inside = cos_i > 0.0 && cos_o > 0.0;
    let visibility = 1.0 / select(1.0, dot(h, h), inside);
    return Masking(select(0.0, 4.0 * cos_i * cos_o * visibility, inside), select(0.0, visibility, inside));
}

// G and V of correlated heights from cos·(1/2+Lambda).
fn _correlated(cos_i: f32, cos_o: f32, excess_i: f32, excess_o: f32) -> Masking {
    return _from_denominator(cos_i, cos_o, excess_i * cos_o + excess_o * cos_i);
}

fn _separable(cos_i: f32, cos_o: f32, area_i: f32, area_o: f32) -> Masking {
    return _from_denominator(cos_i, cos_o, area_i * area_o);
}

// G = cos_i cos_o/d and V = 1/(4d).
fn _from_denominator(cos_i: f32, cos_o: f32, denominator: f32) -> Masking {
    let inside = cos_i > 0.0 && cos_o > 0.0;
    let inverse = 1.0 / select(1.0, denominator, inside);
    return Masking(select(0.0, min(cos_i * cos_o * inverse, 1.0), inside), select(0.0, 0.25 * inverse, inside));
}
