//! Metals that were used: brushed, scratched, dirty (Mihaylov, §3.1.4, §3.2 and §4.2).

use super::{BuiltIn, Parameter};
use crate::material::field::{Colour, Noise, Property, Scalar, Scratches};
use crate::material::finish::{Body, BrushedMetal, Coat, Finish, Relief};
use crate::material::metal;
use crate::material::parts::{Material, MaterialError, Part};
use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

/// A polished metal with scratches: where their mask says so it has a second, rougher BRDF, normals of its own and dirt.
#[derive(Clone, Debug, PartialEq)]
pub struct WornMetal {
    /// The metal, a name of [`metal::METALS`].
    pub metal: &'static str,
    /// The α of the polished part.
    pub alpha: f64,
    /// The α of scratches.
    pub scratched_alpha: f64,
    /// How much of the surface is scratched, from 0 to 1.
    pub amount: f64,
    /// The depth of scratches.
    pub depth: f64,
    /// What dirt takes of the reflection of the deepest places, from 0 to 1.
    pub dirt: f64,
    /// Which scratches.
    pub seed: u32,
}

impl Default for WornMetal {
    fn default() -> Self {
        WornMetal {
            metal: "titanium",
            alpha: 0.08,
            scratched_alpha: 0.4,
            amount: 0.35,
            depth: 0.004,
            dirt: 0.6,
            seed: 5,
        }
    }
}

fn index(name: &str) -> ([f64; 3], [f64; 3]) {
    // Names of the table; a mirror where one is not.
    metal::by_name(name).map_or(([1e-3; 3], [1e3; 3]), |metal| (metal.n, metal.k))
}

impl WornMetal {
    /// How deep scratches are at a point, from 0 to 1: long ones, and short ones over them.
    pub fn scratches(&self) -> Scalar {
        let [long, short] = [(0, 1.1, 0.004, 24), (1, 3.0, 0.008, 12)].map(|(seed, frequency, width, layers)| {
            let scratches = Scratches::new(self.seed.wrapping_add(seed), frequency).layers(layers);
            Scalar::Scratches(Scratches { density: self.amount, width, ..scratches })
        });
        long.plus(short).levels(0.0, 1.0)
    }
}

impl BuiltIn for WornMetal {
    fn parameters(&mut self) -> Vec<Parameter<'_>> {
        vec![
            Parameter::new("alpha", &mut self.alpha, 1e-4..=1.0),
            Parameter::new("scratched_alpha", &mut self.scratched_alpha, 1e-4..=1.0),
            Parameter::new("amount", &mut self.amount, 0.01..=1.0),
            Parameter::new("depth", &mut self.depth, 0.0..=1.0),
            Parameter::new("dirt", &mut self.dirt, 0.0..=1.0),
        ]
    }

    fn material(&self) -> Result<Material, MaterialError> {
        let (n, k) = index(self.metal);
        let deep = self.scratches();
        // The deeper, the more dirt; so in hidden places.
        let dirty = deep.clone().plus(Scalar::Of(Property::Occlusion)).levels(0.0, 1.0);
        let clean = Colour::Grey(dirty.scaled(-self.dirt, 1.0));
        let polished = Finish::layers(vec![Coat::conductor(n, k, self.alpha)]).dimmed(clean.clone());
        let relief = Relief::Height { height: deep.clone().scaled(-self.depth, 0.0), step: 0.002 };
        let scratched =
            Finish::layers(vec![Coat::conductor(n, k, self.scratched_alpha)]).dimmed(clean).with_relief(relief);
        let parts = vec![
            Part { cover: Scalar::Constant(1.0), finish: polished },
            Part { cover: deep.levels(0.0, 0.5), finish: scratched },
        ];
        Material::new(parts, Vec::new())
    }
}

/// Steel with grooves: chromium's index, GGX of two widths.
#[derive(Clone, Debug, PartialEq)]
pub struct BrushedSteel {
    /// The α along the grooves.
    pub along: f64,
    /// The α across the grooves.
    pub across: f64,
    /// The direction of the grooves in turns: 0 along u, which is around the axis of a sphere or torus about z, ¼ along v.
    pub turn: f64,
    /// How much the width differs from groove to groove, from 0 to 1. The streaks are solid noise, drawn out along circles about z or along z
    /// itself: those are the grooves of a cylinder and of a sphere near its equator, towards the poles they become grains, as they are where
    /// grooves run obliquely.
    pub variety: f64,
    /// Which grooves.
    pub seed: u32,
}

impl Default for BrushedSteel {
    fn default() -> Self {
        BrushedSteel { along: 0.08, across: 0.35, turn: 0.25, variety: 0.4, seed: 9 }
    }
}

impl BuiltIn for BrushedSteel {
    fn parameters(&mut self) -> Vec<Parameter<'_>> {
        vec![
            Parameter::new("along", &mut self.along, 1e-4..=1.0),
            Parameter::new("across", &mut self.across, 1e-4..=1.0),
            Parameter::new("turn", &mut self.turn, -1.0..=1.0),
            Parameter::new("variety", &mut self.variety, 0.0..=1.0),
        ]
    }

    fn material(&self) -> Result<Material, MaterialError> {
        let (n, k) = index("chromium");
        // Fine across the grooves and long along them: of grooves around the axis z alone tells one from another, of those along it x and y.
        let (along_v, along_u) = (core::f64::consts::TAU * self.turn).sin_cos();
        let [around, up] = [along_v, along_u].map(|share| (1.0 + 59.0 * share.abs()).round());
        let streaks = Noise { frequency: [around, around, up], ..Noise::new(self.seed, 1.0) }.octaves(3);
        let streaks = Scalar::Fractal(streaks).scaled(self.variety * self.across, self.across);
        let metal = BrushedMetal {
            n: n.into(),
            k: k.into(),
            along: self.along.into(),
            across: streaks,
            turn: self.turn.into(),
        };
        Material::plain(Finish::new(Body::Brushed(Box::new(metal))))
    }
}
