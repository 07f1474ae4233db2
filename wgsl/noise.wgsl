// Gradient noise and the fractal sums of it. Twin of src/texture/noise.rs: the same lattice to the bit.

import package::random::_words;

// 1/1.0363538, the bound of the sum before it, less what rounding takes: 63237/65536.
const _scale: f32 = 0.9649200439453125;
// How far each octave is shifted against the one below, in cells.
const _shift: vec3f = vec3f(0.3818359375, 0.6181640625, 0.2353515625);
const _most_octaves: u32 = 32u;

// Where a point lies in its cell, and the gradients at the cell's corners in order of x, then y, then z.
struct _Cell {
    share: vec3f,
    gradients: array<vec3f, 8>,
}

// The gradients' heights at a point, those of z = 0 and those of z = 1.
struct _Heights {
    low: vec4f,
    high: vec4f,
}

// Gradient noise at a point, in [-1, 1]; 0 at lattice points (Perlin 2002).
fn gradient(p: vec3f, seed: u32) -> f32 {
    let cell = _cell(p, seed);
    let heights = _heights(cell);
    return _mixed(heights.low, heights.high, _fade(cell.share)) * _scale;
}

// The derivatives of gradient along x, y and z.
fn gradient_slope(p: vec3f, seed: u32) -> vec3f {
    let cell = _cell(p, seed);
    let h = _heights(cell);
    let f = _fade(cell.share);
    let across = cell.share * (1.0 - cell.share);
    let d = 30.0 * across * across;
    let g = cell.gradients;
    let x = _mixed(vec4f(g[0].x, g[1].x, g[2].x, g[3].x), vec4f(g[4].x, g[5].x, g[6].x, g[7].x), f);
    let y = _mixed(vec4f(g[0].y, g[1].y, g[2].y, g[3].y), vec4f(g[4].y, g[5].y, g[6].y, g[7].y), f);
    let z = _mixed(vec4f(g[0].z, g[1].z, g[2].z, g[3].z), vec4f(g[4].z, g[5].z, g[6].z, g[7].z), f);
    let along_x = vec4f(h.low.yw, h.high.yw) - vec4f(h.low.xz, h.high.xz);
    let along_y = vec4f(h.low.zw, h.high.zw) - vec4f(h.low.xy, h.high.xy);
    return vec3f(
        x + d.x * _flat_mixed(along_x, f.y, f.z),
        y + d.y * _flat_mixed(along_y, f.x, f.z),
        z + d.z * _flat_mixed(h.high - h.low, f.x, f.y)) * _scale;
}

// The sum of amplitude·gain^k·gradient(p·frequency·lacunarity^k + k·shift, seed + k) over the octaves k; at most 32.
fn fractal(p: vec3f, seed: u32, amplitude: f32, frequency: f32, octaves: u32, gain: f32, lacunarity: f32) -> f32 {
    var sum = 0.0;
    var a = amplitude;
    var f = frequency;
    for (var k = 0u; k < min(octaves, _most_octaves); k++) {
        sum = sum + a * gradient(p * f + _shift * f32(k), seed + k);
        a = a * gain;
        f = f * lacunarity;
    }
    return sum;
}

// The derivatives of fractal along x, y and z.
fn fractal_slope(p: vec3f, seed: u32, amplitude: f32, frequency: f32, octaves: u32, gain: f32, lacunarity: f32) -> vec3f {
    var sum = vec3f(0.0);
    var a = amplitude;
    var f = frequency;
    for (var k = 0u; k < min(octaves, _most_octaves); k++) {
        sum = sum + gradient_slope(p * f + _shift * f32(k), seed + k) * (a * f);
        a = a * gain;
        f = f * lacunarity;
    }
    return sum;
}

// The sum of amplitude·gain^k·(1 - |gradient|): lines where the noise is 0.
fn ridged(p: vec3f, seed: u32, amplitude: f32, frequency: f32, octaves: u32, gain: f32, lacunarity: f32) -> f32 {
    var sum = 0.0;
    var a = amplitude;
    var f = frequency;
    for (var k = 0u; k < min(octaves, _most_octaves); k++) {
        sum = sum + a * (1.0 - abs(gradient(p * f + _shift * f32(k), seed + k)));
        a = a * gain;
        f = f * lacunarity;
    }
    return sum;
}

fn _cell(p: vec3f, seed: u32) -> _Cell {
    let corner = floor(p);
    let at = vec3u(vec3i(corner));
    // Just below a whole number the difference rounds to 1.
    return _Cell(clamp(p - corner, vec3f(0.0), vec3f(1.0)), array<vec3f, 8>(
        _edge(at, seed), _edge(at + vec3u(1u, 0u, 0u), seed),
        _edge(at + vec3u(0u, 1u, 0u), seed), _edge(at + vec3u(1u, 1u, 0u), seed),
        _edge(at + vec3u(0u, 0u, 1u), seed), _edge(at + vec3u(1u, 0u, 1u), seed),
        _edge(at + vec3u(0u, 1u, 1u), seed), _edge(at + vec3u(1u, 1u, 1u), seed)));
}

// The gradient at a lattice point: to one of the twelve edges of a cube.
fn _edge(place: vec3u, seed: u32) -> vec3f {
    let which = ((_words(vec4u(place, seed)).x >> 16u) * 12u) >> 16u;
    let signs = vec2f(1.0 - 2.0 * f32(which & 1u), 1.0 - f32(which & 2u));
    let later = select(vec3f(signs, 0.0), vec3f(signs.x, 0.0, signs.y), which < 8u);
    return select(later, vec3f(0.0, signs), which < 4u);
}

fn _heights(cell: _Cell) -> _Heights {
    let low = cell.share;
    let high = cell.share - 1.0;
    let g = cell.gradients;
    return _Heights(
        vec4f(
            _product(g[0], low), _product(g[1], vec3f(high.x, low.yz)),
            _product(g[2], vec3f(low.x, high.y, low.z)), _product(g[3], vec3f(high.xy, low.z))),
        vec4f(
            _product(g[4], vec3f(low.xy, high.z)), _product(g[5], vec3f(high.x, low.y, high.z)),
            _product(g[6], vec3f(low.x, high.yz)), _product(g[7], high)));
}

// The scalar product, in an order that every compiler keeps closer to than that of `dot`.
fn _product(a: vec3f, b: vec3f) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

fn _fade(t: vec3f) -> vec3f {
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
}

fn _between(a: f32, b: f32, t: f32) -> f32 {
    return a + t * (b - a);
}

fn _flat_mixed(a: vec4f, s: f32, t: f32) -> f32 {
    return _between(_between(a.x, a.y, s), _between(a.z, a.w, s), t);
}

fn _mixed(low: vec4f, high: vec4f, f: vec3f) -> f32 {
    return _between(_flat_mixed(low, f.x, f.y), _flat_mixed(high, f.x, f.y), f.z);
}
