//! A stand-in for `material::{Point, Spot, Material}` of the same names and shapes, until those are here.

use crate::frame::Vector;
use crate::layered::{Interface, Stack};
use crate::layered::model::interface_fresnel;
use crate::real::{Mask, Real};
use crate::sampling::Sample;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point<R> {
    pub position: Vector<R>,
    pub tangent: Vector<R>,
    pub bitangent: Vector<R>,
    pub uv: [R; 2],
    pub uv_per_length: [R; 2],
    pub occlusion: R,
    pub distance: R,
    pub footprint: R,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    stack: Stack<f64, 3>,
}

impl From<Stack<f64, 3>> for Material {
    fn from(stack: Stack<f64, 3>) -> Self {
        Material { stack }
    }
}

impl Material {
    pub fn at<R: Real>(&self, _: &Point<R>) -> Spot<'_, R> {
        Spot { stack: self.stack.cast(), material: self }
    }
    pub fn whole(&self) -> Option<&Stack<f64, 3>> {
        Some(&self.stack)
    }
}

#[derive(Clone, Debug)]
pub struct Spot<'a, R> {
    stack: Stack<R, 3>,
    #[allow(unused)]
    material: &'a Material,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror<R> {
    pub direction: Vector<R>,
    pub alpha: R,
    pub diffuse: bool,
    pub weight: [R; 3],
}

impl<R: Real> Spot<'_, R> {
    pub fn reflected(&self, wi: Vector<R>, wo: Vector<R>) -> [R; 3] {
        self.stack.evaluate(wi, wo).map(|f| f * wi.z.max(R::ZERO))
    }
    pub fn sample(&self, wo: Vector<R>, u: [R; 4]) -> Option<Sample<R>> {
        self.stack.sample(wo, [u[1], u[2], u[3]])
    }
    pub fn pdf(&self, wi: Vector<R>, wo: Vector<R>) -> R {
        self.stack.pdf(wi, wo)
    }
    pub fn mirrored(&self, wo: Vector<R>, visit: &mut impl FnMut(Mirror<R>)) {
        let mut left = [R::ONE; 3];
        for layer in self.stack.layers() {
            match layer.interface {
                Interface::Diffuse { albedo, .. } => {
                    let weight = core::array::from_fn(|c| left[c] * albedo[c]);
                    visit(Mirror { direction: Vector::new(R::ZERO, R::ZERO, R::ONE), alpha: R::ONE, diffuse: true, weight });
                }
                Interface::Microfacet { n, k, alpha } => {
                    let split: [_; 3] = core::array::from_fn(|c| interface_fresnel(wo.z, n[c], k[c]));
                    let weight = core::array::from_fn(|c| left[c] * split[c].reflectance);
                    visit(Mirror { direction: Vector::new(-wo.x, -wo.y, wo.z), alpha, diffuse: false, weight });
                    left = core::array::from_fn(|c| left[c] * split[c].transmittance * split[c].transmittance);
                }
            }
            if !R::ZERO.lt(wo.z).any() {
                return;
            }
        }
    }
}
