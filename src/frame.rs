//! Directions and the frame they live in.
//!
//! Every BRDF of this crate is evaluated in the local shading frame: the normal is +z, the tangent +x, the bitangent +y.
//! A [`Frame`] carries directions between that frame and the world. Unit length is assumed of directions and never
//! enforced: a formula divides by a length where it needs one.

use crate::real::Real;
use core::ops::{Add, Mul, Neg, Sub};

/// A vector in three dimensions over any [`Real`]: a direction, a normal or a half vector.
///
/// Converts from and to [`glam::Vec3`], [`glam::Vec3A`] and [`glam::DVec3`], which is what the crate's callers use.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct Vector<R> {
    /// Along the tangent.
    pub x: R,
    /// Along the bitangent.
    pub y: R,
    /// Along the normal: the cosine of a local direction.
    pub z: R,
}

impl<R: Real> Vector<R> {
    /// A vector from its components.
    #[inline(always)]
    pub const fn new(x: R, y: R, z: R) -> Self {
        Self { x, y, z }
    }

    /// The local direction with polar angle `theta` from the normal and azimuth `phi` from the tangent, in radians.
    #[cfg(feature = "std")]
    pub fn from_angles(theta: f64, phi: f64) -> Self {
        let (sin_theta, cos_theta) = theta.sin_cos();
        let (sin_phi, cos_phi) = phi.sin_cos();
        Vector::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta).cast()
    }

    /// The scalar product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> R {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// The vector product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Vector::new(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    /// The squared length.
    #[inline(always)]
    pub fn length_squared(self) -> R {
        self.x.squared() + self.y.squared() + self.z.squared()
    }

    /// The squared length of the tangential part, sin²θ of a unit direction without cancellation.
    #[inline(always)]
    pub fn sin_squared(self) -> R {
        self.x.squared() + self.y.squared()
    }

    /// The vector divided by its length; the zero vector stays zero.
    #[inline(always)]
    pub fn normalized(self) -> Self {
        let squared = self.length_squared();
        let inverse = R::ONE / R::select(squared.gt(R::ZERO), squared, R::ONE).sqrt();
        self * inverse
    }

    /// `yes` where the mask is true, else `no`.
    #[inline(always)]
    pub(crate) fn select(mask: R::Mask, yes: Self, no: Self) -> Self {
        let pick = |yes: R, no: R| R::select(mask, yes, no);
        Vector::new(pick(yes.x, no.x), pick(yes.y, no.y), pick(yes.z, no.z))
    }

    /// The same vector in the numbers that terms compute with ([`Real::Wide`]).
    #[inline(always)]
    pub fn widen(self) -> Vector<R::Wide> {
        Vector::new(self.x.widen(), self.y.widen(), self.z.widen())
    }

    /// The same vector over another number type.
    #[inline(always)]
    pub fn cast<S: Real>(self) -> Vector<S> {
        Vector::new(S::from_f64(self.x.to_f64()), S::from_f64(self.y.to_f64()), S::from_f64(self.z.to_f64()))
    }
}

/// The half vector wi + wo, *not* normalised: NH² = hz²/|h|², VH = |h|/2 (for unit directions).
///
/// Everything that a microfacet term asks of the half vector is a ratio of its components, so the square root and the
/// cancellation that come with normalising are both avoided.
#[inline(always)]
pub fn half_vector<R: Real>(wi: Vector<R>, wo: Vector<R>) -> Vector<R> {
    wi + wo
}

/// An orthonormal basis that carries directions between the world and the local shading frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Frame<R> {
    /// The local +x in world space.
    pub tangent: Vector<R>,
    /// The local +y in world space.
    pub bitangent: Vector<R>,
    /// The local +z in world space.
    pub normal: Vector<R>,
}

impl<R: Real> Frame<R> {
    /// A frame around a unit normal, with a tangent of no particular direction.
    ///
    /// Duff et al. 2017, "Building an Orthonormal Basis, Revisited", listing 3. Continuous except across z = 0.
    pub fn from_normal(normal: impl Into<Vector<R>>) -> Self {
        let n = normal.into();
        let sign = R::select(n.z.lt(R::ZERO), -R::ONE, R::ONE);
        let a = -R::ONE / (sign + n.z);
        let b = n.x * n.y * a;
        Frame {
            tangent: Vector::new(R::ONE + sign * n.x * n.x * a, sign * b, -sign * n.x),
            bitangent: Vector::new(b, sign + n.y * n.y * a, -n.y),
            normal: n,
        }
    }

    /// A frame around a unit normal whose tangent is the given one made perpendicular to the normal.
    ///
    /// A tangent of zero length or along the normal falls back to [`Frame::from_normal`].
    pub fn from_normal_and_tangent(normal: impl Into<Vector<R>>, tangent: impl Into<Vector<R>>) -> Self {
        let (n, t) = (normal.into(), tangent.into());
        let across = t - n * n.dot(t);
        let usable = across.length_squared().gt(t.length_squared() * R::EPSILON * R::EPSILON);
        let fallback = Self::from_normal(n);
        let tangent = Vector::select(usable, across.normalized(), fallback.tangent);
        Frame { tangent, bitangent: n.cross(tangent), normal: n }
    }

    /// A world-space vector in the local frame.
    #[inline(always)]
    pub fn to_local(&self, world: impl Into<Vector<R>>) -> Vector<R> {
        let w = world.into();
        Vector::new(w.dot(self.tangent), w.dot(self.bitangent), w.dot(self.normal))
    }

    /// A local vector in world space.
    #[inline(always)]
    pub fn to_world(&self, local: impl Into<Vector<R>>) -> Vector<R> {
        let w = local.into();
        self.tangent * w.x + self.bitangent * w.y + self.normal * w.z
    }
}

impl<R: Real> Add for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Vector::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<R: Real> Sub for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Vector::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<R: Real> Mul<R> for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: R) -> Self {
        Vector::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl<R: Real> Neg for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Vector::new(-self.x, -self.y, -self.z)
    }
}

impl<R: Real> From<[R; 3]> for Vector<R> {
    #[inline(always)]
    fn from([x, y, z]: [R; 3]) -> Self {
        Vector { x, y, z }
    }
}

impl<R: Real> From<Vector<R>> for [R; 3] {
    #[inline(always)]
    fn from(v: Vector<R>) -> Self {
        [v.x, v.y, v.z]
    }
}

macro_rules! convert {
    ($real:ty: $($other:ty),+) => {$(
        impl From<$other> for Vector<$real> {
            #[inline(always)]
            fn from(v: $other) -> Self {
                Vector { x: v.x, y: v.y, z: v.z }
            }
        }
        impl From<Vector<$real>> for $other {
            #[inline(always)]
            fn from(v: Vector<$real>) -> Self {
                Self::from([v.x, v.y, v.z])
            }
        }
    )+};
}
convert!(f32: glam::Vec3, glam::Vec3A);
convert!(f64: glam::DVec3);
#[cfg(feature = "mint")]
convert!(f32: mint::Vector3<f32>);
#[cfg(feature = "mint")]
convert!(f64: mint::Vector3<f64>);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_and_round_trip() {
        let normals = [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.6, 0.0, 0.8], [-0.48, 0.6, -0.64], [1.0, 0.0, 0.0]];
        for n in normals {
            for frame in [
                Frame::<f64>::from_normal(n),
                Frame::from_normal_and_tangent(n, [0.3, -0.2, 0.9]),
                Frame::from_normal_and_tangent(n, n),
                Frame::from_normal_and_tangent(n, [0.0; 3]),
            ] {
                let Frame { tangent: t, bitangent: b, normal: n } = frame;
                for (product, want) in
                    [(t.dot(t), 1.0), (b.dot(b), 1.0), (t.dot(b), 0.0), (t.dot(n), 0.0), (b.dot(n), 0.0)]
                {
                    // Three products and their sums, of components that carry up to 3 roundings each.
                    assert!((product - want).abs() < 6.0 * f64::EPSILON, "{frame:?}");
                }
                assert!(t.cross(b).dot(n) > 0.999, "right-handed: {frame:?}");
                let w = Vector::new(0.1, -0.7, 0.3);
                let back = frame.to_local(frame.to_world(w));
                assert!((back - w).length_squared() < 1e-30, "{back:?}");
            }
        }
    }

    #[test]
    fn glam_converts_both_ways() {
        let v = glam::Vec3::new(1.0, 2.0, 3.0);
        assert_eq!(glam::Vec3::from(Vector::<f32>::from(v)), v);
        assert_eq!(Vector::from(glam::DVec3::Z), Vector::new(0.0, 0.0, 1.0));
    }
}
