//! A hierarchy of boxes around triangles, flat, so that WGSL walks the same array.
//!
//! Nodes lie in depth-first order: the first child of an inner node is the next node, the second is named. Halves are split at the
//! median of the longest axis, so the depth is the logarithm of the number of triangles whatever the mesh.

use super::Number;
use super::shape::Ray;

/// Triangles in a leaf, at most.
const LEAF: usize = 4;

/// How far boxes reach beyond their triangles, whose corners are within the unit sphere and rounded to 6e-8: a ray within the outer wall of two
/// triangles is inside the boxes of both.
const MARGIN: f32 = 1e-6;

/// Deeper than any hierarchy of 2³² triangles.
const STACK: usize = 32;

/// A box and what lies in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// The least corner.
    pub low: [f32; 3],
    /// The first triangle of a leaf, or the second child of an inner node.
    pub first: u32,
    /// The greatest corner.
    pub high: [f32; 3],
    /// How many triangles a leaf holds; 0 of an inner node.
    pub count: u32,
}

/// The nodes, the root first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bvh {
    nodes: Vec<Node>,
}

impl Bvh {
    /// A hierarchy of the triangles with these corners, and the order that they must be put into for it.
    pub fn new(triangles: &[[[f32; 3]; 3]]) -> (Self, Vec<usize>) {
        let mut order: Vec<usize> = (0..triangles.len()).collect();
        let mut bvh = Bvh { nodes: Vec::new() };
        if !order.is_empty() {
            bvh.build(triangles, &mut order, 0);
        }
        (bvh, order)
    }

    /// The nodes, in depth-first order.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    fn build(&mut self, triangles: &[[[f32; 3]; 3]], order: &mut [usize], first: usize) {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for corner in order.iter().filter_map(|i| triangles.get(*i)).flatten() {
            for axis in 0..3 {
                low[axis] = low[axis].min(corner[axis]);
                high[axis] = high[axis].max(corner[axis]);
            }
        }
        let place = self.nodes.len();
        let count = order.len();
        let (outer_low, outer_high) = (low.map(|x| x - MARGIN), high.map(|x| x + MARGIN));
        self.nodes.push(Node { low: outer_low, first: first as u32, high: outer_high, count: count as u32 });
        if count <= LEAF {
            return;
        }
        let extent = |axis: usize| high[axis] - low[axis];
        let axis = (1..3).fold(0, |best, axis| if extent(axis) > extent(best) { axis } else { best });
        let centre = |i: &usize| triangles.get(*i).map_or(0.0, |[a, b, c]| a[axis] + b[axis] + c[axis]);
        let (left, _, _) = order.select_nth_unstable_by(count / 2, |a, b| centre(a).total_cmp(&centre(b)));
        let half = left.len();
        let (left, right) = order.split_at_mut(half);
        self.build(triangles, left, first);
        let second = self.nodes.len() as u32;
        if let Some(node) = self.nodes.get_mut(place) {
            (node.first, node.count) = (second, 0);
        }
        self.build(triangles, right, first + half);
    }

    /// Calls `meet` with each triangle whose boxes the ray meets within the distance that it last returned, nearer halves first. `meet`
    /// returns the distance to look within from then on; 0 ends it.
    #[inline]
    pub fn walk<R: Number>(&self, ray: &Ray<R>, within: R, mut meet: impl FnMut(usize, R) -> R) {
        // A ray along a wall would be 0·∞ = NaN from it: within the wall, so nearly along it, it is inside.
        let least = R::from_f64(1e-20);
        let inverse = [ray.direction.x, ray.direction.y, ray.direction.z]
            .map(|x| R::ONE / if least.lt(x.abs()) { x } else { least });
        let origin = [ray.origin.x, ray.origin.y, ray.origin.z];
        // Where a box begins; none where the ray passes it by.
        let enters = |node: &Node, within: R| {
            let (mut near, mut far) = (R::ZERO, within);
            for axis in 0..3 {
                let wall = |x: f32| (R::from_f64(f64::from(x)) - origin[axis]) * inverse[axis];
                let (a, b) = (wall(node.low[axis]), wall(node.high[axis]));
                near = near.max(a.min(b));
                far = far.min(a.max(b) * (R::ONE + R::TWO * R::TWO * R::EPSILON));
            }
            near.le(far).then_some(near)
        };
        let (mut within, mut stack, mut top) = (within, [0u32; STACK], 0);
        let Some(mut node) = self.nodes.first() else { return };
        let mut place = 0usize;
        if enters(node, within).is_none() {
            return;
        }
        loop {
            if node.count > 0 {
                for i in node.first..node.first + node.count {
                    within = meet(i as usize, within);
                }
                if !R::ZERO.lt(within) {
                    return;
                }
            } else {
                let (a, b) = (place + 1, node.first as usize);
                let enter = |i: usize| self.nodes.get(i).and_then(|node| enters(node, within));
                let (next, other) = match (enter(a), enter(b)) {
                    (Some(x), Some(y)) if y.lt(x) => (Some(b), Some(a)),
                    (Some(_), Some(_)) => (Some(a), Some(b)),
                    (Some(_), None) => (Some(a), None),
                    (None, Some(_)) => (Some(b), None),
                    (None, None) => (None, None),
                };
                if let (Some(other), Some(slot)) = (other, stack.get_mut(top)) {
                    *slot = other as u32;
                    top += 1;
                }
                if let Some(next) = next
                    && let Some(child) = self.nodes.get(next)
                {
                    (node, place) = (child, next);
                    continue;
                }
            }
            // What was put off may by now be farther than what was found.
            loop {
                if top == 0 {
                    return;
                }
                top -= 1;
                place = stack[top] as usize;
                match self.nodes.get(place) {
                    Some(next) if enters(next, within).is_some() => {
                        node = next;
                        break;
                    }
                    _ => {}
                }
            }
        }
    }
}
