// Flakes that glint, conserving energy in every cell. Twin of src/material/glint.rs, which derives it.

import package::random;
import package::real;

struct Flakes {
    // The side of the smallest cell, > 0.
    spacing: f32,
    // How many flakes a cell of that side holds, > 0.
    count: f32,
    // J: the slopes are told apart in 2^J parts each; from 1 to 8, clamped.
    resolution: u32,
    seed: u32,
}

const finest: u32 = 8u;
const _coarsest: u32 = 20u;
const _far: f32 = 1073741824.0;

// What D of a Beckmann interface is multiplied with at a position, for the width that a pixel covers there.
fn factor(h: vec3f, alpha: f32, flakes: Flakes, position: vec3f, footprint: f32) -> f32 {
    let resolution = clamp(flakes.resolution, 1u, finest);
    let side = f32(1u << resolution);
    if !(flakes.spacing > 0.0 && flakes.count > 0.0) {
        return 1.0;
    }
    let inverse = 1.0 / (select(1.0, h.z, h.z > 0.0) * alpha);
    let column = clamp(_rank(h.x * inverse) * side - 0.5, 0.0, side - 1.0);
    let row = clamp(_rank(h.y * inverse) * side - 0.5, 0.0, side - 1.0);
    // The footprint in sides of the finer of the two cells, in [1, 2), and how much finer than it the spacing is.
    var ratio = max(footprint / flakes.spacing, 1.0);
    var finer = 1.0;
    var level = 0u;
    for (; level < _coarsest && ratio >= 2.0; level++) {
        ratio *= 0.5;
        finer *= 0.5;
    }
    let share = clamp(ratio - 1.0, 0.0, 1.0);
    let near = _grain(flakes, resolution, side, column, row, position, level, finer);
    if share <= 0.0 {
        return near;
    }
    let far = _grain(flakes, resolution, side, column, row, position, level + 1u, 0.5 * finer);
    return near * (1.0 - share) + far * share;
}

// How many flakes of a cell have facets in one leaf: half of those dealt to it and its opposite. Exact up to 128 flakes.
fn leaf(key: vec4u, count: f32, resolution: u32, column: u32, row: u32) -> f32 {
    let depth = clamp(resolution, 1u, finest);
    let last = (1u << depth) - 1u;
    let opposite = column > last / 2u;
    let i = select(column, last - column, opposite);
    let j = select(row, last - row, opposite);
    let steps = 2u * depth - 1u;
    var held = count;
    var node = 1u;
    var step = 0u;
    for (; step < steps && held >= _many; step++) {
        let ones = countOneBits(_bits(key, node));
        let uneven = (f32(ones.x + ones.y + ones.z + ones.w) - 64.0) * sqrt(held * (1.0 / _many));
        let digit = _digit(i, j, depth, step);
        held = max(0.5 * held + select(-uneven, uneven, digit == 0u), 0.0);
        node = 2u * node + digit;
    }
    if step == steps {
        return 0.5 * held;
    }
    // Fewer: whole flakes, and what is left of one, which stays together.
    var whole = u32(min(held, _many - 1.0));
    var rest = clamp(held - f32(whole), 0.0, 1.0);
    for (; step < steps && (whole > 0u || rest > 0.0); step++) {
        let words = _bits(key, node);
        let ones = countOneBits(words & _below(whole));
        let left = ones.x + ones.y + ones.z + ones.w;
        let goes_left = ((words[whole >> 5u] >> (whole & 31u)) & 1u) == 1u;
        let digit = _digit(i, j, depth, step);
        whole = select(whole - left, left, digit == 0u);
        rest = select(0.0, rest, goes_left == (digit == 0u));
        node = 2u * node + digit;
    }
    return 0.5 * (f32(whole) + rest);
}

// From so many flakes on they are dealt by the moments of the binomial law, below by its bits.
const _many: f32 = 128.0;

// The side to which a step goes. The first digit of the column is the side that was folded away.
fn _digit(column: u32, row: u32, depth: u32, step: u32) -> u32 {
    let of_row = (step & 1u) == 0u;
    return (select(column, row, of_row) >> (depth - select(2u, 1u, of_row) - step / 2u)) & 1u;
}

// The random bits of a node.
fn _bits(key: vec4u, node: u32) -> vec4u {
    return random::_words(vec4u(key.xyz, key.w + node));
}

// The first bits of four words, fewer than 128.
fn _below(bits: u32) -> vec4u {
    let starts = vec4u(0u, 32u, 64u, 96u);
    let all = vec4u(bits, bits, bits, bits);
    let kept = select(vec4u(0u, 0u, 0u, 0u), all - starts, all > starts);
    let some = (vec4u(1u, 1u, 1u, 1u) << (kept & vec4u(31u, 31u, 31u, 31u))) - vec4u(1u, 1u, 1u, 1u);
    let full = vec4u(0xffffffffu, 0xffffffffu, 0xffffffffu, 0xffffffffu);
    return select(some, full, kept >= vec4u(32u, 32u, 32u, 32u));
}

// The factor at one level of detail.
fn _grain(flakes: Flakes, resolution: u32, side: f32, column: f32, row: f32, position: vec3f, level: u32, finer: f32) -> f32 {
    let count = flakes.count / (finer * finer);
    // No grain is left.
    if count >= 16384.0 * (side * side) {
        return 1.0;
    }
    let key = _cell(position, flakes.spacing, finer, level, flakes.seed);
    let last = (1u << resolution) - 2u;
    let i = min(u32(column), last);
    let j = min(u32(row), last);
    let u = clamp(column - f32(i), 0.0, 1.0);
    let v = clamp(row - f32(j), 0.0, 1.0);
    let low = leaf(key, count, resolution, i, j) * (1.0 - u) + leaf(key, count, resolution, i + 1u, j) * u;
    let high = leaf(key, count, resolution, i, j + 1u) * (1.0 - u) + leaf(key, count, resolution, i + 1u, j + 1u) * u;
    return (low * (1.0 - v) + high * v) / count * (side * side);
}

// The random words of the cell that a position lies in.
fn _cell(position: vec3f, spacing: f32, finer: f32, level: u32, seed: u32) -> vec4u {
    let index = vec3u(vec3i(floor(clamp(position / spacing * finer, vec3f(-_far, -_far, -_far), vec3f(_far, _far, _far)))));
    return random::_words(vec4u(index, seed ^ (level << 27u)));
}

// (1+erf(x))/2.
fn _rank(x: f32) -> f32 {
    let distance = abs(x);
    let square = distance * distance;
    let inside = square <= 87.0;
    let tail = select(0.0, 0.5 * exp(-select(0.0, square, inside)) * real::erfcx(distance), inside);
    return select(1.0 - tail, tail, x < 0.0);
}
