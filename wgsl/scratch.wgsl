// Straight scratches: where a surface cuts flat ellipsoids, one in each cell of a lattice. Twin of src/texture/scratch.rs: the same
// ellipsoids to the bit.

import package::random::_words;

// How far each layer is shifted against the one before, in cells.
const _shift: vec3f = vec3f(0.3818359375, 0.6181640625, 0.2353515625);
const _radius: f32 = 0.375;
const _least_width: f32 = 0.0000152587890625;
const _most_layers: u32 = 64u;

// How deep scratches are at a point, in [0, 1]. `density`: the share of cells with a scratch; `width`: half of one's width in cells.
fn scratches(p: vec3f, seed: u32, density: f32, width: f32, layers: u32) -> f32 {
    let w = clamp(width, _least_width, _radius);
    var deepest = 0.0;
    for (var k = 0u; k < min(layers, _most_layers); k++) {
        deepest = max(deepest, _scratch(p + _shift * f32(k), seed + k, density, w));
    }
    return deepest;
}

fn _scratch(p: vec3f, seed: u32, density: f32, width: f32) -> f32 {
    let corner = floor(p);
    let words = _words(vec4u(vec3u(vec3i(corner)), seed));
    // Odd numbers: no normal is 0.
    let n = vec3f(2u * (words.xyz >> vec3u(24u)) + 1u) - 256.0;
    let centre = 0.5 + (vec3f(2u * ((words.xyz >> vec3u(16u)) & vec3u(255u)) + 1u) - 256.0) / 2048.0;
    // Just below a whole number the difference rounds to 1.
    let q = clamp(p - corner, vec3f(0.0), vec3f(1.0)) - centre;
    let across = _product(q, n);
    let off = across * across / _product(n, n);
    let depth = 1.0 - _product(q, q) * (1.0 / (_radius * _radius)) - off / (width * width);
    let drawn = f32(words.w >> 8u) * 0x1p-24;
    return select(0.0, clamp(depth, 0.0, 1.0), drawn < density);
}

// The scalar product, in an order that every compiler keeps closer to than that of `dot`.
fn _product(a: vec3f, b: vec3f) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
