// Tables of F and D, interpolated linearly between texels. Twin of src/table, which makes and documents them.
//
// The shader that imports this module supplies the texels, from a texture (textureLoad) or a storage buffer:
//
//     fn fresnel_texel(column: u32, row: u32) -> vec3f
//     fn distribution_texel(column: u32, row: u32) -> f32
//
// Tables over an angle are as printed; those over a root need none, and err less.

import package::real;

const two_over_pi: f32 = 0.636619772367581343;
const pi: f32 = 3.14159265358979324;

// Of a table of D: its texels over the angle and over the width, the least width, and the rows for each unit of the width (or
// of its fourth root).
struct Shape {
    columns: u32,
    rows: u32,
    least: f32,
    rate: f32,
}

// F in three channels from the row of a material whose entries are equally spaced in the angle of incidence.
fn fresnel_over_angle(cos_i: f32, row: u32, entries: u32) -> vec3f {
    let c = clamp(cos_i, 0.0, 1.0);
    return _fresnel(real::angle(sqrt((1.0 - c) * (1.0 + c)), c) * two_over_pi, row, entries);
}

// The same where the entries are equally spaced in the square root of the cosine.
fn fresnel_over_root(cos_i: f32, row: u32, entries: u32) -> vec3f {
    return _fresnel(sqrt(clamp(cos_i, 0.0, 1.0)), row, entries);
}

fn _fresnel(u: f32, row: u32, entries: u32) -> vec3f {
    let place = u * f32(entries - 1u);
    let cell = min(u32(place), entries - 2u);
    let a = fresnel_texel(cell, row);
    return a + (fresnel_texel(cell + 1u, row) - a) * clamp(place - f32(cell), 0.0, 1.0);
}

// Beckmann's D where the columns are equally spaced in the eighth root of the angle, the rows in the width.
fn beckmann_over_angle(h: vec3f, alpha: f32, shape: Shape) -> f32 {
    let z = select(1.0, h.z, h.z > 0.0);
    let turned = real::angle(sqrt(h.x * h.x + h.y * h.y), z) * two_over_pi;
    let m = min(max(alpha, shape.least), 1.0);
    let d = _distribution(turned, (m - shape.least) * shape.rate, shape);
    return select(0.0, d, h.z > 0.0);
}

// Beckmann's D where the texels are pi·m²·D, the columns equally spaced in the eighth root of sin², the rows in the fourth root
// of the width.
fn beckmann_over_root(h: vec3f, alpha: f32, shape: Shape) -> f32 {
    let z = select(1.0, h.z, h.z > 0.0);
    let s = h.x * h.x + h.y * h.y;
    let m = min(max(alpha, shape.least), 1.0);
    let d = _distribution(s / (s + z * z), sqrt(sqrt(m)) * shape.rate, shape);
    return select(0.0, d * (1.0 / (pi * m * m)), h.z > 0.0);
}

fn _distribution(eighth: f32, row: f32, shape: Shape) -> f32 {
    let column = sqrt(sqrt(sqrt(eighth))) * f32(shape.columns - 1u);
    let i = min(u32(column), shape.columns - 2u);
    let j = min(u32(row), shape.rows - 2u);
    let across = clamp(column - f32(i), 0.0, 1.0);
    let low = _between(distribution_texel(i, j), distribution_texel(i + 1u, j), across);
    let high = _between(distribution_texel(i, j + 1u), distribution_texel(i + 1u, j + 1u), across);
    return _between(low, high, clamp(row - f32(j), 0.0, 1.0));
}

fn _between(a: f32, b: f32, share: f32) -> f32 {
    return a + (b - a) * share;
}
