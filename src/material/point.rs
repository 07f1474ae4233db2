//! What a material is told of a point.

use crate::frame::Vector;
use crate::real::Real;

/// A point of a surface, as a material sees it.
///
/// Everything is in the object's own space: what is painted on it stays there when it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point<R> {
    /// Where it is. Solid textures live here.
    pub position: Vector<R>,
    /// The unit direction along the surface in which `uv[0]` grows.
    pub tangent: Vector<R>,
    /// The unit direction along the surface in which `uv[1]` grows.
    pub bitangent: Vector<R>,
    /// The parameters of the surface there, usually in [0, 1].
    pub uv: [R; 2],
    /// How much `uv` grows for a unit of length along the tangent and the bitangent.
    pub uv_per_length: [R; 2],
    /// How hidden the point is, from 0 (open) to 1: ambient occlusion, a map of cavities.
    pub occlusion: R,
    /// How far the viewer is, in the scene's length.
    pub distance: R,
    /// The width of what a pixel covers there.
    pub footprint: R,
}

impl<R: Real> Point<R> {
    /// The same point over another number type.
    pub fn cast<S: Real>(&self) -> Point<S> {
        let one = |x: R| S::from_f64(x.to_f64());
        Point {
            position: self.position.cast(),
            tangent: self.tangent.cast(),
            bitangent: self.bitangent.cast(),
            uv: self.uv.map(one),
            uv_per_length: self.uv_per_length.map(one),
            occlusion: one(self.occlusion),
            distance: one(self.distance),
            footprint: one(self.footprint),
        }
    }

    /// The point that lies these lengths further along the tangent and the bitangent, as if the surface were flat.
    #[cfg(feature = "std")]
    pub(crate) fn shifted(&self, along: R, across: R) -> Self {
        Point {
            position: self.position + self.tangent * along + self.bitangent * across,
            uv: [self.uv[0] + along * self.uv_per_length[0], self.uv[1] + across * self.uv_per_length[1]],
            ..*self
        }
    }
}
