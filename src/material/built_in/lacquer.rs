//! Coats that one looks through: lacquers, varnish, glaze (Elek 2010, fig. 10).

use super::{BuiltIn, Parameter};
use crate::layered::{Model, Widths};
use crate::material::field::{Noise, Scalar};
use crate::material::finish::{Body, Coat, Finish, Layers};
use crate::material::metal;
use crate::material::parts::{Material, MaterialError};
use alloc::vec;
use alloc::vec::Vec;

/// A lacquer of varying thickness over a metal.
#[derive(Clone, Debug, PartialEq)]
pub struct Lacquer {
    /// The metal under it, a name of [`metal::METALS`].
    pub metal: &'static str,
    /// The α of the metal.
    pub metal_alpha: f64,
    /// The index of the lacquer.
    pub n: f64,
    /// The α of the lacquer.
    pub alpha: f64,
    /// What it absorbs, in 1/length.
    pub tint: [f64; 3],
    /// Its mean thickness.
    pub thickness: f64,
    /// How much the thickness varies, from 0 to 1.
    pub variety: f64,
    /// Which map of thickness.
    pub seed: u32,
}

impl Lacquer {
    /// What an orange lacquer absorbs.
    pub fn orange() -> Self {
        Lacquer {
            metal: "aluminium",
            metal_alpha: 0.3,
            n: 1.5,
            alpha: 0.05,
            tint: [0.05, 0.7, 2.6],
            thickness: 0.6,
            variety: 0.9,
            seed: 13,
        }
    }

    /// What a purple lacquer absorbs.
    pub fn purple() -> Self {
        Lacquer { tint: [0.7, 2.6, 0.35], seed: 17, ..Self::orange() }
    }
}

impl BuiltIn for Lacquer {
    fn parameters(&mut self) -> Vec<Parameter<'_>> {
        vec![
            Parameter::new("metal_alpha", &mut self.metal_alpha, 1e-4..=1.0),
            Parameter::new("n", &mut self.n, 1.0..=3.0),
            Parameter::new("alpha", &mut self.alpha, 1e-4..=1.0),
            Parameter::new("thickness", &mut self.thickness, 0.0..=100.0),
            Parameter::new("variety", &mut self.variety, 0.0..=1.0),
        ]
    }

    fn material(&self) -> Result<Material, MaterialError> {
        // A name of the table; a mirror where it is not.
        let (n, k) = metal::by_name(self.metal).map_or(([1e-3; 3], [1e3; 3]), |metal| (metal.n, metal.k));
        let map = Scalar::Fractal(Noise::new(self.seed, 1.5).octaves(4));
        let thickness = map.scaled(1.5 * self.variety * self.thickness, self.thickness);
        let coat = Coat::dielectric(self.n, self.alpha).over(self.tint, thickness);
        Material::plain(Finish::layers(vec![coat, Coat::conductor(n, k, self.metal_alpha)]))
    }
}

/// Concrete in a blue, transparent varnish.
#[derive(Clone, Debug, PartialEq)]
pub struct Varnish {
    /// The α of the varnish.
    pub alpha: f64,
    /// The thickness of the varnish.
    pub thickness: f64,
    /// The slope deviation of the concrete, in radians.
    pub sigma: f64,
    /// Which concrete.
    pub seed: u32,
}

impl Default for Varnish {
    fn default() -> Self {
        Varnish { alpha: 0.1, thickness: 0.3, sigma: 0.5, seed: 19 }
    }
}

impl BuiltIn for Varnish {
    fn parameters(&mut self) -> Vec<Parameter<'_>> {
        vec![
            Parameter::new("alpha", &mut self.alpha, 1e-4..=1.0),
            Parameter::new("thickness", &mut self.thickness, 0.0..=100.0),
            Parameter::new("sigma", &mut self.sigma, 0.0..=1.5),
        ]
    }

    fn material(&self) -> Result<Material, MaterialError> {
        use crate::material::field::Colour;
        let grain = Scalar::Fractal(Noise::new(self.seed, 8.0).octaves(6)).scaled(0.5, 0.5).levels(0.0, 1.0);
        let concrete = Colour::mix([0.36, 0.35, 0.33], [0.66, 0.64, 0.61], grain);
        let varnish = Coat::dielectric(1.5, self.alpha).over([1.4, 0.7, 0.1], self.thickness);
        Material::plain(Finish::layers(vec![varnish, Coat::diffuse(concrete, self.sigma)]))
    }
}

/// A white ceramic body under a clear glaze, with the light that the glaze sends back.
#[derive(Clone, Debug, PartialEq)]
pub struct Ceramic {
    /// The index of the glaze.
    pub n: f64,
    /// The α of the glaze.
    pub alpha: f64,
    /// The reflectance of the body, before the glaze.
    pub albedo: [f64; 3],
}

impl Default for Ceramic {
    fn default() -> Self {
        Ceramic { n: 1.5, alpha: 0.01, albedo: [0.87, 0.84, 0.78] }
    }
}

impl BuiltIn for Ceramic {
    fn parameters(&mut self) -> Vec<Parameter<'_>> {
        let [red, green, blue] = &mut self.albedo;
        vec![
            Parameter::new("n", &mut self.n, 1.0..=3.0),
            Parameter::new("alpha", &mut self.alpha, 1e-4..=1.0),
            Parameter::new("albedo_r", red, 0.0..=1.0),
            Parameter::new("albedo_g", green, 0.0..=1.0),
            Parameter::new("albedo_b", blue, 0.0..=1.0),
        ]
    }

    fn material(&self) -> Result<Material, MaterialError> {
        let coats = vec![Coat::dielectric(self.n, self.alpha), Coat::diffuse(self.albedo, 0.0)];
        let layers = Layers { model: Model::Conserving, widths: Widths::Own, coats, returns: true, scatter: None };
        Material::plain(Finish::new(Body::Layers(layers)))
    }
}
