//! What a part of a material is made of, in fields: layers, a brushed metal, or a whole stack.

use super::field::{Colour, Lookup, Scalar};
use crate::layered::{Model, Stack, Widths};
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::ops::RangeInclusive;

/// What a part of a material is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Finish {
    /// What reflects.
    pub body: Body,
    /// Normals of its own, in place of the surface's.
    pub relief: Option<Relief>,
    /// What is left of all that it reflects, each channel in [0, 1]: a specular map, dirt in cavities (Mihaylov, §4.2), tarnish.
    pub reflectivity: Colour,
}

impl Finish {
    /// A finish without relief that nothing dims.
    pub fn new(body: Body) -> Self {
        Finish { body, relief: None, reflectivity: Colour::Constant([1.0; 3]) }
    }

    /// Layers under the model `conserving`.
    pub fn layers(coats: Vec<Coat>) -> Self {
        Self::new(Body::Layers(Layers {
            model: Model::Conserving,
            widths: Widths::Own,
            coats,
            returns: false,
            scatter: None,
        }))
    }

    /// The same with a relief.
    pub fn with_relief(self, relief: Relief) -> Self {
        Finish { relief: Some(relief), ..self }
    }

    /// The same, dimmed.
    pub fn dimmed(self, reflectivity: impl Into<Colour>) -> Self {
        Finish { reflectivity: reflectivity.into(), ..self }
    }
}

/// What reflects.
#[derive(Clone, Debug, PartialEq)]
pub enum Body {
    /// Layers whose parameters vary.
    Layers(Layers),
    /// A metal with grooves along one direction.
    Brushed(Box<BrushedMetal>),
    /// One stack for the whole surface, under any model.
    Whole(Box<Stack<f64, 3>>),
}

/// Layers from the top, under a closed-form model.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// One of [`Model::CLOSED_FORM`].
    pub model: Model,
    /// How wide covered interfaces are taken to be.
    pub widths: Widths,
    /// The layers from the top.
    pub coats: Vec<Coat>,
    /// Whether light that the coat sends back to the diffuse base counts: the base's albedo ρ becomes ρ/(1 − ρ·r_i), the correction of
    /// Saunderson. Exact to .25 % for a Lambertian base under one smooth, clear coat, and at most what arrives under a rough one; taken under the
    /// model `conserving` alone and over a base of σ = 0, as anywhere else it would create light.
    pub returns: bool,
    /// The documents' diffuse term of the upper layer, (1 − σ)(1 − F₁)/π for this σ ([`super::patina::diffuse_as_printed`]; Elek 2010, §4.2),
    /// clamped to [0, 1] at each point: above it the term is negative. It lowers no transmittance, so that a stack with it reflects up to 3.8
    /// times what arrives (erratum 12). Kept because people compare with it. The upper layer is a dielectric or a conductor.
    pub scatter: Option<Colour>,
}

/// A layer: an interface, the medium under it, and what lies in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Coat {
    /// The boundary that light meets.
    pub boundary: Boundary,
    /// The absorption of the medium under it, in 1/length. Under the last layer there is no medium that light comes back from: it is clear.
    pub sigma: Colour,
    /// The thickness of the medium under it: a number, or a thickness map.
    pub thickness: Scalar,
    /// The flakes that the facets of the interface are, if they are.
    pub flakes: Option<Flakes>,
}

impl Coat {
    /// A boundary over a clear medium.
    pub fn new(boundary: Boundary) -> Self {
        Coat { boundary, sigma: Colour::Constant([0.0; 3]), thickness: Scalar::Constant(0.0), flakes: None }
    }

    /// A dielectric over a clear medium.
    pub fn dielectric(n: f64, alpha: impl Into<Scalar>) -> Self {
        Self::new(Boundary::Microfacet { n: n.into(), k: Colour::Constant([0.0; 3]), alpha: alpha.into() })
    }

    /// A conductor.
    pub fn conductor(n: impl Into<Colour>, k: impl Into<Colour>, alpha: impl Into<Scalar>) -> Self {
        Self::new(Boundary::Microfacet { n: n.into(), k: k.into(), alpha: alpha.into() })
    }

    /// An Oren–Nayar base.
    pub fn diffuse(albedo: impl Into<Colour>, sigma: impl Into<Scalar>) -> Self {
        Self::new(Boundary::Diffuse { albedo: albedo.into(), sigma: sigma.into() })
    }

    /// The same over an absorbing medium.
    pub fn over(self, sigma: impl Into<Colour>, thickness: impl Into<Scalar>) -> Self {
        Coat { sigma: sigma.into(), thickness: thickness.into(), ..self }
    }

    /// The same with its facets being flakes.
    pub fn with_flakes(self, flakes: Flakes) -> Self {
        Coat { flakes: Some(flakes), ..self }
    }
}

/// The boundary of a layer: [`Interface`](crate::layered::Interface) in fields, clamped to its ranges at each point.
#[derive(Clone, Debug, PartialEq)]
pub enum Boundary {
    /// A rough dielectric or conductor.
    Microfacet {
        /// The real part of the index.
        n: Colour,
        /// The imaginary part of the index.
        k: Colour,
        /// The width of Beckmann's distribution.
        alpha: Scalar,
    },
    /// An opaque Oren–Nayar base.
    Diffuse {
        /// The reflectance of its facets.
        albedo: Colour,
        /// The standard deviation of the slope angle in radians.
        sigma: Scalar,
    },
}

/// Flakes in a layer: its facets, one by one.
#[derive(Clone, Debug, PartialEq)]
pub enum Flakes {
    /// Flakes that conserve energy at every distance ([`super::glint`]).
    Glints {
        /// The side of the square that one flake has to itself, in object space.
        spacing: f64,
        /// How narrow the lobe of one flake is: 2^resolution of them side by side make the layer's. From 1 to [`super::glint::FINEST`].
        resolution: u32,
        /// Which flakes.
        seed: u32,
    },
    /// The documents' flakes: the layer's normal is the surface's plus a texel's, less so with distance
    /// ([`super::flake::flake_normal`]; Elek 2010, §4.1). They conserve nothing and are not reciprocal.
    AsPrinted {
        /// The map of flake normals; the documents repeat it 1000 times and look it up without filtering
        /// ([`Filter::Nearest`](crate::texture::image::Filter)).
        normals: Lookup,
    },
}

/// Over what lengths the slopes of a height may be taken: what is shorter moves no place of size 1 in f32.
pub const STEP_RANGE: RangeInclusive<f64> = 1e-5..=1e6;

/// What the slopes of a normal map may be multiplied by.
pub const STRENGTH_RANGE: RangeInclusive<f64> = -1e6..=1e6;

/// The steepest slope of a relief: a normal 1e-6 above the horizon. f32 squares it with room to spare.
pub const STEEPEST: f64 = 1e6;

/// Normals of a part's own.
#[derive(Clone, Debug, PartialEq)]
pub enum Relief {
    /// The slopes of a height in object space, each clamped to ±[`STEEPEST`].
    Height {
        /// The height. Some of it depends on the place: a step moves the position and uv, and neither the occlusion nor the distance.
        height: Scalar,
        /// Over what length slopes are taken, in [`STEP_RANGE`]: detail finer than this is left out.
        step: f64,
    },
    /// A map of normals (Mihaylov, eq. 4.13–4.14).
    Map {
        /// The image.
        normals: Lookup,
        /// How normals are stored in it.
        encoding: Encoding,
        /// What slopes are multiplied by, in [`STRENGTH_RANGE`].
        strength: f64,
    },
}

/// How a map stores normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// (n + 1)/2 in red, green and blue.
    Rgb,
    /// x in alpha and y in green, z from both (Mihaylov, eq. 4.13).
    AlphaGreen,
}

/// A metal with grooves: GGX of two widths (Mihaylov, §3.1.4).
#[derive(Clone, Debug, PartialEq)]
pub struct BrushedMetal {
    /// The real part of the index.
    pub n: Colour,
    /// The imaginary part of the index.
    pub k: Colour,
    /// The width along the grooves.
    pub along: Scalar,
    /// The width across the grooves.
    pub across: Scalar,
    /// The direction of the grooves, in turns from the tangent: 0 along u, ¼ along v. Any number: whole turns change nothing.
    /// Highlights stretch across the grooves.
    pub turn: Scalar,
}
