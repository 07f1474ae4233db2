//! The flakes of a cell, dealt to the leaves of the square of its slopes: the tree of [`glint`](super).
//!
//! A node of the tree is a part of the half square (the other half is the same, turned), and its number of flakes goes to
//! its two halves. [`leaf`] descends to one leaf; [`corners`] to four that lie side by side, whose ways down differ only
//! at their ends, and so hashes half as often.

use super::FINEST;
use crate::random::random_words;
use crate::real::Real;

/// From so many flakes on they are dealt by the moments of the binomial law, below by its bits.
const MANY: f64 = 128.0;

/// How many flakes of a cell have facets in one leaf: half of those dealt to it and its opposite.
///
/// * `key`: four random words of the cell. `count`: how many flakes the cell holds, ≥ 0. `resolution`: J, from 1 to [`FINEST`],
///   clamped. `column`, `row`: of the leaf, below 2^J, along the first and the second slope.
///
/// The sum over all leaves is `count`; leaf (i, j) has as many as (2^J−1−i, 2^J−1−j). Up to 128 flakes it is the same
/// to the bit in every precision and in WGSL.
pub fn leaf<R: Real>(key: [u32; 4], count: R, resolution: u32, column: u32, row: u32) -> R {
    let tree = Tree { key, depth: resolution.clamp(1, FINEST) };
    let last = (1u32 << tree.depth) - 1;
    let opposite = column > last / 2;
    let leaf = if opposite { [last.wrapping_sub(column), last.wrapping_sub(row)] } else { [column, row] };
    tree.descended(Node::new(count, 1), 0..tree.steps(), leaf).facets()
}

/// [`leaf`] at (column, row), (column+1, row), (column, row+1) and (column+1, row+1), both below 2^J − 1.
pub(super) fn corners<R: Real>(key: [u32; 4], count: R, resolution: u32, column: u32, row: u32) -> [R; 4] {
    let tree = Tree { key, depth: resolution.clamp(1, FINEST) };
    let last = (1u32 << tree.depth) - 1;
    // Across the fold the four are two and two.
    if column == last / 2 {
        return [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| leaf(key, count, resolution, column + i, row + j));
    }
    let opposite = column > last / 2;
    let folded = |index: u32| if opposite { last.wrapping_sub(index) } else { index };
    let ([a, b], [c, d]) = ([column, column + 1].map(folded), [row, row + 1].map(folded));
    // The steps at which the columns and the rows part: where the highest digit that differs is asked for.
    let digit = |index: u32| tree.depth - 1 - (31 - index.leading_zeros()).min(tree.depth - 1);
    let (by_column, by_row) = ((2 * digit(a ^ b)).saturating_sub(1), 2 * digit(c ^ d));
    let (first, second) = (by_column.min(by_row), by_column.max(by_row));
    let root = tree.descended(Node::new(count, 1), 0..first, [a, c]);
    let one = tree.descended(root, first..second, [a, c]);
    let columns_first = by_column < by_row;
    let two = tree.descended(root, first..second, if columns_first { [b, c] } else { [a, d] });
    let (beside, above) = if columns_first { (two, one) } else { (one, two) };
    [(one, [a, c]), (beside, [b, c]), (above, [a, d]), (two, [b, d])]
        .map(|(node, leaf)| tree.descended(node, second..tree.steps(), leaf).facets())
}

/// The random words of a cell, and J.
struct Tree {
    key: [u32; 4],
    depth: u32,
}

/// The flakes of a node: so many that they are counted by a real number, or whole ones and a part of one that stays together.
#[derive(Clone, Copy)]
struct Node<R> {
    many: R,
    whole: u32,
    rest: R,
    index: u32,
}

impl<R: Real> Node<R> {
    fn new(count: R, index: u32) -> Self {
        if count.to_f64() >= MANY {
            return Node { many: count, whole: 0, rest: R::ZERO, index };
        }
        let whole = count.to_f64() as u32;
        Node { many: R::ZERO, whole, rest: (count - R::from_f64(f64::from(whole))).saturate(), index }
    }

    /// Half of its flakes.
    fn facets(self) -> R {
        if self.many.to_f64() >= MANY {
            self.many * R::HALF
        } else {
            (R::from_f64(f64::from(self.whole)) + self.rest) * R::HALF
        }
    }
}

impl Tree {
    /// The rows are told apart by J digits, the columns, of which one half is folded onto the other, by J−1.
    fn steps(&self) -> u32 {
        2 * self.depth - 1
    }

    /// The side to which a step goes: the digits of the row and of the column in turn.
    fn digit(&self, [column, row]: [u32; 2], step: u32) -> u32 {
        let (index, highest) = if step & 1 == 0 { (row, self.depth - 1) } else { (column, self.depth - 2) };
        index >> (highest - step / 2) & 1
    }

    fn descended<R: Real>(&self, mut node: Node<R>, steps: core::ops::Range<u32>, leaf: [u32; 2]) -> Node<R> {
        for step in steps {
            let digit = self.digit(leaf, step);
            let index = 2 * node.index + digit;
            if node.many.to_f64() >= MANY {
                let uneven = R::from_f64(f64::from(self.bits(node.index).count_ones()) - 64.0)
                    * (node.many * R::from_f64(1.0 / MANY)).sqrt();
                let share = R::HALF * node.many + if digit == 0 { uneven } else { -uneven };
                node = Node::new(share.max(R::ZERO), index);
            } else if node.whole > 0 || node.rest.to_f64() > 0.0 {
                let bits = self.bits(node.index);
                let left = (bits & ((1 << node.whole) - 1)).count_ones();
                let stays = (bits >> node.whole & 1 == 1) == (digit == 0);
                node.whole = if digit == 0 { left } else { node.whole - left };
                node.rest = if stays { node.rest } else { R::ZERO };
                node.index = index;
            } else {
                break;
            }
        }
        node
    }

    /// The random bits of a node.
    fn bits(&self, node: u32) -> u128 {
        let [x, y, z, w] = self.key;
        random_words([x, y, z, w.wrapping_add(node)]).iter().rev().fold(0, |bits, word| bits << 32 | u128::from(*word))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_leaves_hold_every_flake() {
        for count in [0.0, 0.3, 1.0, 2.625, 17.0, 64.5, 127.9375, 128.0, 128.5, 1000.25, 65536.0] {
            for resolution in 1..=6 {
                let last = (1u32 << resolution) - 1;
                for cell in 0..20 {
                    let key = random_words([cell, 3, 5, resolution]);
                    let mut sum = 0.0;
                    for (i, j) in (0..=last).flat_map(|i| (0..=last).map(move |j| (i, j))) {
                        let held = leaf(key, count, resolution, i, j);
                        assert!((0.0..=0.5 * count).contains(&held), "{held} of {count}");
                        assert_eq!(held, leaf(key, count, resolution, last - i, last - j));
                        if count <= 128.0 {
                            assert_eq!(
                                f64::from(leaf(key, count as f32, resolution, i, j)),
                                leaf(key, count as f32 as f64, resolution, i, j)
                            );
                        }
                        sum += held;
                    }
                    // Above 128 each of 11 splits rounds twice.
                    let tolerance = if count <= 128.0 { 0.0 } else { 22.0 * f64::EPSILON * count };
                    assert!((sum - count).abs() <= tolerance, "{count} {resolution}: {sum}");
                }
            }
        }
    }

    #[test]
    fn corners_are_leaves() {
        for resolution in 1..=6 {
            let last = (1u32 << resolution) - 1;
            for (cell, count) in [0.7, 1.0, 5.5, 100.0, 300.0, 9999.0].into_iter().enumerate() {
                let key = random_words([cell as u32, 1, 1, resolution]);
                for (i, j) in (0..last).flat_map(|i| (0..last).map(move |j| (i, j))) {
                    let want: [f64; 4] =
                        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(p, q)| leaf(key, count, resolution, i + p, j + q));
                    assert_eq!(corners(key, count, resolution, i, j), want, "{resolution} {count}: {i} {j}");
                }
            }
        }
    }
}
