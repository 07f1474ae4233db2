//! Rust on iron (Mihaylov, §3.3.1 and §4.3).

use super::{BuiltIn, Parameter, by_stage, no_ramp};
use crate::material::field::{Colour, Noise, Scalar};
use crate::material::finish::{Coat, Finish, Relief};
use crate::material::metal;
use crate::material::parts::{Material, MaterialError, Part};
use crate::texture::ramp::Ramp;
use alloc::vec;
use alloc::vec::Vec;

/// Iron with spots of rust: a noise mask over Cook–Torrance iron and an Oren–Nayar rust whose colour and height are noise.
#[derive(Clone, Debug, PartialEq)]
pub struct RustyIron {
    /// How much of the iron has rusted, from 0 (none) to 1 (all).
    pub amount: f64,
    /// Half the width of the mask's edge; 0 is the documents' mask of zeros and ones.
    pub softness: f64,
    /// The α of the iron.
    pub alpha: f64,
    /// The slope deviation of the rust, in radians.
    pub sigma: f64,
    /// The height of the rust's bumps.
    pub height: f64,
    /// The cells of the noise in a unit of length.
    pub frequency: f64,
    /// The colours of the oldest and of the youngest rust, dark brown and red (linear).
    pub colours: [[f32; 3]; 2],
    /// Which noise.
    pub seed: u32,
}

impl Default for RustyIron {
    fn default() -> Self {
        RustyIron {
            amount: 0.5,
            softness: 0.02,
            alpha: 0.2,
            sigma: 0.5,
            height: 0.02,
            frequency: 2.5,
            colours: [[0.035, 0.012, 0.006], [0.42, 0.13, 0.04]],
            seed: 3,
        }
    }
}

impl RustyIron {
    /// The mask: 1 where there is rust (the listing's side of it, erratum 23).
    pub fn mask(&self) -> Scalar {
        let noise = Scalar::Fractal(Noise::new(self.seed, self.frequency).octaves(6)).scaled(0.6, 0.5);
        by_stage(noise.levels(0.0, 1.0), self.amount, self.softness)
    }

    /// The height map: fractal, the input of the colours as well.
    pub fn relief(&self) -> Scalar {
        Scalar::Fractal(Noise::new(self.seed.wrapping_add(1), 3.0 * self.frequency).octaves(6)).scaled(0.6, 0.5)
    }
}

impl BuiltIn for RustyIron {
    fn parameters(&mut self) -> Vec<Parameter<'_>> {
        vec![
            Parameter::new("amount", &mut self.amount, 0.0..=1.0),
            Parameter::new("softness", &mut self.softness, 0.0..=1.0),
            Parameter::new("alpha", &mut self.alpha, 1e-4..=1.0),
            Parameter::new("sigma", &mut self.sigma, 0.0..=1.5),
            Parameter::new("height", &mut self.height, 0.0..=1.0),
            Parameter::new("frequency", &mut self.frequency, 0.01..=100.0),
        ]
    }

    fn material(&self) -> Result<Material, MaterialError> {
        // The name is in the table; a mirror where it is not.
        let (n, k) = metal::by_name("iron").map_or(([1e-3; 3], [1e3; 3]), |iron| (iron.n, iron.k));
        let iron = Finish::layers(vec![Coat::conductor(n, k, self.alpha)]);
        let height = self.relief();
        // Each layer of rust has spots of other ages in it: more noise on top of the height.
        let spots = Scalar::Fractal(Noise::new(self.seed.wrapping_add(2), 9.0 * self.frequency).octaves(3));
        let age = height.clone().plus(spots.scaled(0.25, 0.0)).levels(0.0, 1.0);
        let ramp = Ramp::even(&self.colours).map_err(|error| no_ramp(1, &error))?;
        let colour = Colour::Ramp(ramp, age);
        let relief = Relief::Height { height: height.scaled(self.height, 0.0), step: 0.004 };
        let rust = Finish::layers(vec![Coat::diffuse(colour, self.sigma)]).with_relief(relief);
        let parts =
            vec![Part { cover: Scalar::Constant(1.0), finish: iron }, Part { cover: self.mask(), finish: rust }];
        Material::new(parts, Vec::new())
    }
}
