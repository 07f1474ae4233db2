//! Copper that patina grows on: by extent (Elek 2010, §4.2) and by age (Mihaylov, §3.3.2).

use super::{BuiltIn, Parameter, by_stage, no_ramp};
use crate::layered::{Model, Widths};
use crate::material::field::{Colour, Noise, Property, Scalar};
use crate::material::finish::{Body, Coat, Finish, Layers, Relief};
use crate::material::metal;
use crate::material::parts::{Material, MaterialError, Part};
use crate::texture::ramp::Ramp;
use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

/// Copper under patina, by how far it has grown.
#[derive(Clone, Debug, PartialEq)]
pub struct Patina {
    /// How far it has grown over the whole surface, from −transition to 1 + transition.
    pub extent: f64,
    /// Half the width of its edge.
    pub transition: f64,
    /// The α of clean copper.
    pub alpha: f64,
    /// The α of copper under patina: growth takes the one to the other.
    pub patinated_alpha: f64,
    /// How thick the film is.
    pub thickness: f64,
    /// How much of the surface is left bare by the map of growth alone: how strongly hidden places come first.
    pub hidden_first: f64,
    /// How the film scatters.
    pub scattering: Scattering,
    /// Which noise the map of growth is.
    pub seed: u32,
}

/// How a film of patina scatters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scattering {
    /// Cu₂O over Cu under the model `elek`, with the diffuse term (1 − σ)(1 − F₁) as printed.
    AsPrinted,
    /// Kubelka and Munk's film over tarnished copper, as the base of a coat, with the light that the coat sends back (Saunderson).
    KubelkaMunk,
}

/// What the documents' film absorbs: light green is left ("empirically matched", their values are not printed).
const ABSORBED: [f64; 3] = [0.62, 0.25, 0.42];

/// The dark orange of tarnish, by which the documents modulate the copper.
const TARNISH: [f64; 3] = [0.85, 0.55, 0.35];

/// Absorption and scattering of the film in 1/length: K/S of an opaque film that reflects light green, (1−R)²/(2R) of
/// R = .36, .66, .54.
const FILM: ([f64; 3], [f64; 3]) = ([4.55, 0.70, 1.57], [8.0, 8.0, 8.0]);

/// The index of brochantite, the green sulfate of copper (mineral data: 1.73 to 1.80).
const BROCHANTITE: f64 = 1.77;

impl Default for Patina {
    fn default() -> Self {
        Patina {
            extent: 0.45,
            transition: 0.65,
            alpha: 0.15,
            patinated_alpha: 0.4,
            thickness: 0.5,
            hidden_first: 0.5,
            scattering: Scattering::KubelkaMunk,
            seed: 7,
        }
    }
}

/// A map from 0 to 1 with its mean at ½.
fn cloud(seed: u32, frequency: f64, octaves: u32) -> Scalar {
    Scalar::Fractal(Noise::new(seed, frequency).octaves(octaves)).scaled(0.6, 0.5).levels(0.0, 1.0)
}

impl Patina {
    /// The map of growth: the darker, the earlier; hidden places first.
    pub fn growth(&self) -> Scalar {
        let open = Scalar::Of(Property::Occlusion).scaled(-self.hidden_first, self.hidden_first);
        cloud(self.seed, 2.0, 6).scaled(1.0 - self.hidden_first, 0.0).plus(open)
    }

    /// How far it has grown at a point, from 0 to 1.
    pub fn grown(&self) -> Scalar {
        Scalar::Extent { of: Box::new(self.growth()), extent: self.extent, transition: self.transition }
    }
}

impl BuiltIn for Patina {
    fn parameters(&mut self) -> Vec<Parameter<'_>> {
        vec![
            Parameter::new("extent", &mut self.extent, -1.0..=2.0),
            Parameter::new("transition", &mut self.transition, 0.0..=1.0),
            Parameter::new("alpha", &mut self.alpha, 1e-4..=1.0),
            Parameter::new("patinated_alpha", &mut self.patinated_alpha, 1e-4..=1.0),
            Parameter::new("thickness", &mut self.thickness, 0.0..=100.0),
            Parameter::new("hidden_first", &mut self.hidden_first, 0.0..=1.0),
        ]
    }

    fn material(&self) -> Result<Material, MaterialError> {
        let (n, k) = index("copper_elek");
        let grown = self.grown();
        let alpha = Scalar::mix(self.alpha, self.patinated_alpha, grown.clone());
        let tarnished = Colour::mix([1.0; 3], TARNISH, grown.clone());
        let copper = Coat::conductor(n, k, alpha);
        let bare = Finish::layers(vec![copper.clone()]).dimmed(tarnished);
        // The documents vary the thickness by a map of its own.
        let thickness = cloud(self.seed.wrapping_add(1), 3.0, 4).scaled(self.thickness, 0.5 * self.thickness);
        let film = match self.scattering {
            Scattering::AsPrinted => {
                let (n, k) = index("cuprite_elek");
                let cuprite = Coat::conductor(n, k, self.patinated_alpha).over(ABSORBED, thickness);
                Layers {
                    model: Model::Elek,
                    widths: Widths::Own,
                    coats: vec![cuprite, copper],
                    returns: false,
                    scatter: Some(Colour::Constant(ABSORBED)),
                }
            }
            Scattering::KubelkaMunk => {
                let (absorption, scattering) = FILM;
                // What tarnished copper reflects at the normal.
                let ground = core::array::from_fn(|c| {
                    crate::fresnel::conductor(1.0, n[c] / BROCHANTITE, k[c] / BROCHANTITE).reflectance * TARNISH[c]
                });
                let ground = Box::new(Colour::Constant(ground));
                let albedo = Colour::Film { absorption, scattering, thickness, ground };
                Layers {
                    model: Model::Conserving,
                    widths: Widths::Own,
                    coats: vec![Coat::dielectric(BROCHANTITE, self.patinated_alpha), Coat::diffuse(albedo, 0.0)],
                    returns: true,
                    scatter: None,
                }
            }
        };
        let parts = vec![
            Part { cover: Scalar::Constant(1.0), finish: bare },
            Part { cover: grown, finish: Finish::new(Body::Layers(film)) },
        ];
        Material::new(parts, Vec::new())
    }
}

fn index(name: &str) -> ([f64; 3], [f64; 3]) {
    // Names of the table; a mirror where one is not.
    metal::by_name(name).map_or(([1e-3; 3], [1e3; 3]), |metal| (metal.n, metal.k))
}

/// Copper by its age: five colours in bands, spots that grow together.
#[derive(Clone, Debug, PartialEq)]
pub struct Timeline {
    /// From 0 (new, bare copper) to 1 (25 years or more, covered everywhere).
    pub age: f64,
    /// How much the colour of a place differs from that of the age.
    pub variety: f64,
    /// The slope deviation of the rough film, in radians.
    pub sigma: f64,
    /// The share of a map of hidden places in the mask; the rest is noise (Mihaylov, fig. 26).
    pub hidden_first: f64,
    /// Half the width of the edges of bands and spots.
    pub softness: f64,
    /// Which noise.
    pub seed: u32,
}

/// The colours of five ages: tarnish, dark brown, red-brown, green, blue-green (Mihaylov, fig. 22 and 24; linear sRGB, read from what
/// the text says).
pub const AGES: [[f32; 3]; 5] =
    [[0.30, 0.13, 0.06], [0.13, 0.06, 0.03], [0.22, 0.10, 0.06], [0.20, 0.36, 0.24], [0.25, 0.50, 0.42]];

impl Default for Timeline {
    fn default() -> Self {
        Timeline { age: 0.6, variety: 0.25, sigma: 0.5, hidden_first: 0.3, softness: 0.05, seed: 11 }
    }
}

impl BuiltIn for Timeline {
    fn parameters(&mut self) -> Vec<Parameter<'_>> {
        vec![
            Parameter::new("age", &mut self.age, 0.0..=1.0),
            Parameter::new("variety", &mut self.variety, 0.0..=1.0),
            Parameter::new("sigma", &mut self.sigma, 0.0..=1.5),
            Parameter::new("hidden_first", &mut self.hidden_first, 0.0..=1.0),
            Parameter::new("softness", &mut self.softness, 0.0..=1.0),
        ]
    }

    fn material(&self) -> Result<Material, MaterialError> {
        let (n, k) = index("copper");
        let bare = Finish::layers(vec![Coat::conductor(n, k, 0.2)]);
        let noise = Scalar::Fractal(Noise::new(self.seed, 3.0).octaves(6));
        let at = noise.clone().scaled(self.variety, self.age);
        let ages = Ramp::banded(&AGES).map_err(|error| no_ramp(1, &error))?;
        let colour = Colour::Bands(ages, self.softness, at);
        let open = 1.0 - self.hidden_first;
        let mask = cloud(self.seed.wrapping_add(1), 2.0, 5)
            .scaled(open, 0.0)
            .plus(Scalar::Of(Property::Occlusion).scaled(self.hidden_first, 0.0));
        // Noise seldom comes near its ends, nor occlusion to 1: what most places have is spread over all ages.
        let cover = by_stage(mask.levels(0.1, 0.6), self.age, self.softness);
        let relief = Relief::Height { height: noise.scaled(0.01, 0.0), step: 0.004 };
        let film = Finish::layers(vec![Coat::diffuse(colour, self.sigma)]).with_relief(relief);
        Material::new(
            vec![Part { cover: Scalar::Constant(1.0), finish: bare }, Part { cover, finish: film }],
            Vec::new(),
        )
    }
}
