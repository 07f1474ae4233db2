//! Metallic paint (Elek 2010, §4.1).

use super::{BuiltIn, Parameter};
use crate::frame::Vector;
use crate::layered::{Model, Widths};
use crate::material::field::{Lookup, Scalar};
use crate::material::finish::{Body, Coat, Finish, Flakes, Layers};
use crate::material::metal;
use crate::material::parts::{Material, MaterialError, Part};
use crate::random::random;
use crate::texture::bump;
use crate::texture::image::{Filter, Image};
use alloc::vec;
use alloc::vec::Vec;

/// Flakes of chromium under a tinted coat.
///
/// The documents' two layers: the facets of the lower one are flakes.
#[derive(Clone, Debug, PartialEq)]
pub struct CarPaint {
    /// The metal of the flakes, a name of [`metal::METALS`].
    pub metal: &'static str,
    /// How far flakes tilt: the α of all of them together.
    pub flake_alpha: f64,
    /// The index of the coat.
    pub coat_n: f64,
    /// The roughness of the coat.
    pub coat_alpha: f64,
    /// What the coat absorbs, in 1/length.
    pub tint: [f64; 3],
    /// How thick the coat is.
    pub thickness: f64,
    /// The side of the square that one flake has to itself, for an object of radius 1.
    pub spacing: f64,
    /// How the flakes sparkle.
    pub sparkle: Sparkle,
    /// Which flakes.
    pub seed: u32,
}

/// How flakes sparkle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sparkle {
    /// Not at all: their mean.
    Smooth,
    /// One by one, conserving energy at every distance ([`crate::material::glint`]), under the model `conserving`.
    Glints,
    /// By a map of normals that is not filtered, flattened with distance, under the model `elek`: as printed.
    AsPrinted,
}

/// One flake's lobe is 2⁻⁵ of the layer's, per axis.
const RESOLUTION: u32 = 5;

/// How often the documents repeat the map of flake normals over the surface.
const REPEATS: f64 = 1000.0;

/// The side of that map in texels.
const SIDE: u32 = 64;

impl Default for CarPaint {
    fn default() -> Self {
        CarPaint {
            metal: "chromium_elek",
            flake_alpha: 0.25,
            coat_n: 1.5,
            coat_alpha: 0.02,
            tint: [0.1, 1.6, 2.2],
            thickness: 0.5,
            spacing: 0.004,
            sparkle: Sparkle::Glints,
            seed: 1,
        }
    }
}

impl BuiltIn for CarPaint {
    fn parameters(&mut self) -> Vec<Parameter<'_>> {
        let [red, green, blue] = &mut self.tint;
        vec![
            Parameter::new("flake_alpha", &mut self.flake_alpha, 1e-4..=1.0),
            Parameter::new("coat_n", &mut self.coat_n, 1.0..=3.0),
            Parameter::new("coat_alpha", &mut self.coat_alpha, 1e-4..=1.0),
            Parameter::new("tint_r", red, 0.0..=100.0),
            Parameter::new("tint_g", green, 0.0..=100.0),
            Parameter::new("tint_b", blue, 0.0..=100.0),
            Parameter::new("thickness", &mut self.thickness, 0.0..=100.0),
            Parameter::new("spacing", &mut self.spacing, 1e-6..=1.0),
        ]
    }

    fn material(&self) -> Result<Material, MaterialError> {
        // A name that is no metal's is a mirror: a paint without flakes would hide it.
        let (n, k) = metal::by_name(self.metal).map_or(([1e-3; 3], [1e3; 3]), |metal| (metal.n, metal.k));
        let base = Coat::conductor(n, k, self.flake_alpha);
        let mut images = Vec::new();
        let flakes = match self.sparkle {
            Sparkle::Smooth => None,
            Sparkle::Glints => Some(Flakes::Glints { spacing: self.spacing, resolution: RESOLUTION, seed: self.seed }),
            Sparkle::AsPrinted => {
                images.extend(flake_normals(SIDE, self.flake_alpha, self.seed));
                Some(Flakes::AsPrinted { normals: Lookup { image: 0, repeat: [REPEATS; 2] } })
            }
        };
        let coat = Coat::dielectric(self.coat_n, self.coat_alpha).over(self.tint, self.thickness);
        let model = if self.sparkle == Sparkle::AsPrinted { Model::Elek } else { Model::Conserving };
        let coats = vec![coat, Coat { flakes, ..base }];
        let layers = Layers { model, widths: Widths::Own, coats, returns: false, scatter: None };
        let finish = Finish::new(Body::Layers(layers));
        Material::new(vec![Part { cover: Scalar::Constant(1.0), finish }], images)
    }
}

/// A map of flake normals as the documents' fig. 6 shows one: a texel is a flake, whose slopes are Beckmann's of this α.
///
/// `side` texels along each side, at least 1, looked up without filtering. None where no image has so many.
pub fn flake_normals(side: u32, alpha: f64, seed: u32) -> Option<Image> {
    let mut texels = Vec::new();
    for index in 0..side.checked_mul(side)? {
        let [u, v, ..] = random::<f64>(seed, index, 0);
        let slope = alpha * (-(1.0 - u).ln()).max(0.0).sqrt();
        let (sine, cosine) = (core::f64::consts::TAU * v).sin_cos();
        let normal = Vector::new(slope * cosine, slope * sine, 1.0).normalized();
        texels.extend(bump::encode(normal).map(|x: f64| x as f32));
    }
    Some(Image::new(side, side, 3, texels).ok()?.with_filter(Filter::Nearest))
}
