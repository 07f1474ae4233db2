// Flakes that glint, conserving energy in every cell. Twin of src/material/glint/, which derives it.

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
    var ratio = footprint / flakes.spacing;
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

// From so many flakes on they are dealt by the moments of the binomial law, below by its bits.
const _many: f32 = 128.0;

// The flakes of a node: so many that they are counted by a real number, or whole ones and a part of one that stays together.
struct _Node {
    many: f32,
    whole: u32,
    rest: f32,
    index: u32,
}

// How many flakes of a cell have facets in one leaf: half of those dealt to it and its opposite. Exact up to 128 flakes.
fn leaf(key: vec4u, count: f32, resolution: u32, column: u32, row: u32) -> f32 {
    let depth = clamp(resolution, 1u, finest);
    let last = (1u << depth) - 1u;
    let opposite = column > last / 2u;
    let i = select(column, last - column, opposite);
    let j = select(row, last - row, opposite);
    return _facets(_descended(_node(count, 1u), key, depth, 0u, 2u * depth - 1u, i, j));
}

// leaf at (column, row), (column+1, row), (column, row+1) and (column+1, row+1). Their ways down differ only at their ends.
fn _corners(key: vec4u, count: f32, depth: u32, column: u32, row: u32) -> vec4f {
    let last = (1u << depth) - 1u;
    // Across the fold the four are two and two.
    if column == last / 2u {
        return vec4f(leaf(key, count, depth, column, row), leaf(key, count, depth, column + 1u, row),
            leaf(key, count, depth, column, row + 1u), leaf(key, count, depth, column + 1u, row + 1u));
    }
    let opposite = column > last / 2u;
    let a = select(column, last - column, opposite);
    let b = select(column + 1u, last - column - 1u, opposite);
    let c = select(row, last - row, opposite);
    let d = select(row + 1u, last - row - 1u, opposite);
    // The steps at which the columns and the rows part: where the highest digit that differs is asked for.
    let by_column = 2u * (depth - 1u - firstLeadingBit(a ^ b)) - 1u;
    let by_row = 2u * (depth - 1u - firstLeadingBit(c ^ d));
    let first = min(by_column, by_row);
    let second = max(by_column, by_row);
    let columns_first = by_column < by_row;
    let root = _descended(_node(count, 1u), key, depth, 0u, first, a, c);
    let one = _descended(root, key, depth, first, second, a, c);
    let two = _descended(root, key, depth, first, second, select(a, b, columns_first), select(d, c, columns_first));
    var beside = one;
    var above = two;
    if columns_first {
        beside = two;
        above = one;
    }
    let steps = 2u * depth - 1u;
    return vec4f(_facets(_descended(one, key, depth, second, steps, a, c)),
        _facets(_descended(beside, key, depth, second, steps, b, c)),
        _facets(_descended(above, key, depth, second, steps, a, d)),
        _facets(_descended(two, key, depth, second, steps, b, d)));
}

fn _node(count: f32, index: u32) -> _Node {
    if count >= _many {
        return _Node(count, 0u, 0.0, index);
    }
    let whole = u32(count);
    return _Node(0.0, whole, clamp(count - f32(whole), 0.0, 1.0), index);
}

// Half of a node's flakes.
fn _facets(node: _Node) -> f32 {
    if node.many >= _many {
        return 0.5 * node.many;
    }
    return 0.5 * (f32(node.whole) + node.rest);
}

// The node that the steps from one to before another lead to, on the way to a leaf.
fn _descended(start: _Node, key: vec4u, depth: u32, from_step: u32, to_step: u32, column: u32, row: u32) -> _Node {
    var node = start;
    for (var step = from_step; step < to_step; step++) {
        let digit = _digit(column, row, depth, step);
        let index = 2u * node.index + digit;
        if node.many >= _many {
            let ones = countOneBits(_bits(key, node.index));
            let uneven = (f32(ones.x + ones.y + ones.z + ones.w) - 64.0) * sqrt(node.many * (1.0 / _many));
            node = _node(max(0.5 * node.many + select(-uneven, uneven, digit == 0u), 0.0), index);
        } else if node.whole > 0u || node.rest > 0.0 {
            let words = _bits(key, node.index);
            let ones = countOneBits(words & _below(node.whole));
            let left = ones.x + ones.y + ones.z + ones.w;
            let goes_left = ((words[node.whole >> 5u] >> (node.whole & 31u)) & 1u) == 1u;
            node.whole = select(node.whole - left, left, digit == 0u);
            node.rest = select(0.0, node.rest, goes_left == (digit == 0u));
            node.index = index;
        } else {
            break;
        }
    }
    return node;
}

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
    let corners = _corners(key, count, resolution, i, j);
    let low = corners.x * (1.0 - u) + corners.y * u;
    let high = corners.z * (1.0 - u) + corners.w * u;
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
