//! Numbers and colours that vary over a surface.
//!
//! A [`Scalar`] or [`Colour`] is an expression over the [`Point`]: what an artist would paint, or wire from noises, ramps and masks. The same
//! expression is evaluated in Rust ([`Scalar::at`]) and written out as WGSL ([`crate::wgsl::material`]).

use super::kubelka_munk;
use super::patina::patina_extent;
use super::point::Point;
use crate::frame::Vector;
use crate::real::Real;
use crate::texture::image::Image;
use crate::texture::{mask, noise, ramp::Ramp, scratch};
use alloc::boxed::Box;
use core::ops::RangeInclusive;

/// A number that varies over a surface.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Scalar {
    /// The same everywhere.
    Constant(f64),
    /// A property of the point itself.
    Of(Property),
    /// Fractal gradient noise at the point's position: about 0, within ±(sum of the octaves' amplitudes).
    Fractal(Noise),
    /// Fractal noise whose octaves are 1 − |noise|: thin bright lines where the noise crosses 0. From 0 to the sum of amplitudes.
    Ridged(Noise),
    /// Straight grooves at the point's position: 0 between them, 1 in the middle of one.
    Scratches(Scratches),
    /// A channel of an image over `uv`.
    Image(Lookup, usize),
    /// `of`·factor + offset.
    Scaled {
        /// What is scaled.
        of: Box<Scalar>,
        /// What it is multiplied by.
        factor: f64,
        /// What is added.
        offset: f64,
    },
    /// The sum of two.
    Sum(Box<Scalar>, Box<Scalar>),
    /// The product of two.
    Product(Box<Scalar>, Box<Scalar>),
    /// From the first to the second as the third goes from 0 to 1; the third is clamped there.
    Mix(Box<Scalar>, Box<Scalar>, Box<Scalar>),
    /// A grey mask: 0 at `black`, 1 at `white`, linear between and constant beyond ([`mask::grey`]).
    Levels {
        /// What is looked at.
        of: Box<Scalar>,
        /// Where the result is 0.
        black: f64,
        /// Where the result is 1.
        white: f64,
    },
    /// A mask: 0 up to `at` − `softness`, 1 from `at` + `softness` on, smooth between ([`mask::soft_threshold`]).
    Threshold {
        /// What is looked at.
        of: Box<Scalar>,
        /// Where the result is ½.
        at: f64,
        /// Half the width of the edge; 0 for a sharp one, which is 0 at `at` itself.
        softness: f64,
    },
    /// How far patina has come ([`patina_extent`]): early where `of` is small.
    Extent {
        /// The map of growth, in [0, 1]: the darker, the earlier.
        of: Box<Scalar>,
        /// How far it has come over the whole surface, from −transition to 1 + transition.
        extent: f64,
        /// Half the width of its edge.
        transition: f64,
    },
}

/// A property of the point itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Property {
    /// The position along x.
    X,
    /// The position along y.
    Y,
    /// The position along z.
    Z,
    /// The first parameter of the surface.
    U,
    /// The second parameter of the surface.
    V,
    /// How hidden the point is, from 0 to 1.
    Occlusion,
    /// How far the viewer is.
    Distance,
}

impl Property {
    /// Every property under the name that material files use.
    pub const ALL: [(&'static str, Property); 7] = [
        ("x", Property::X),
        ("y", Property::Y),
        ("z", Property::Z),
        ("u", Property::U),
        ("v", Property::V),
        ("occlusion", Property::Occlusion),
        ("distance", Property::Distance),
    ];

    fn at<R: Real>(self, point: &Point<R>) -> R {
        match self {
            Property::X => point.position.x,
            Property::Y => point.position.y,
            Property::Z => point.position.z,
            Property::U => point.uv[0],
            Property::V => point.uv[1],
            Property::Occlusion => point.occlusion,
            Property::Distance => point.distance,
        }
    }
}

/// How many cells noise and scratches may have in a unit of length, and how often an image may repeat. Objects are about of size 1, and between
/// 8192 and 16384 the numbers of f32 are 2⁻¹⁰ apart: finer cells would be made of fewer than a thousand of them.
pub const FREQUENCY_RANGE: RangeInclusive<f64> = -1e4..=1e4;

/// Fractal noise in the space of the object (Mihaylov, §4.3: amplitude, frequency, octaves).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Which noise: other seeds, other noises.
    pub seed: u32,
    /// The amplitude of the first octave.
    pub amplitude: f64,
    /// The cells of the first octave in a unit of length along each axis, in [`FREQUENCY_RANGE`]: unequal ones give streaks.
    pub frequency: [f64; 3],
    /// How many octaves are added, at most [`Noise::MOST_OCTAVES`].
    pub octaves: u32,
    /// The amplitude of an octave over that of the one before.
    pub gain: f64,
    /// The frequency of an octave over that of the one before; the last has at most [`Noise::MOST_CELLS`].
    pub lacunarity: f64,
}

impl Noise {
    /// What is finer than this is finer than f32 resolves.
    pub const MOST_OCTAVES: u32 = 12;
    /// The cells in a unit of length that the last octave may have: noise is defined as far as 2³¹ cells from the origin.
    pub const MOST_CELLS: f64 = 2_147_483_648.0;

    /// Noise of one octave with `frequency` cells in a unit of length.
    pub const fn new(seed: u32, frequency: f64) -> Self {
        Noise { seed, amplitude: 1.0, frequency: [frequency; 3], octaves: 1, gain: 0.5, lacunarity: 2.0 }
    }

    /// The same with `octaves` octaves.
    pub const fn octaves(self, octaves: u32) -> Self {
        Noise { octaves, ..self }
    }
}

/// Scratches in the space of the object ([`scratch::scratches`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scratches {
    /// Which scratches: other seeds, other places.
    pub seed: u32,
    /// The cells in a unit of length along each axis, in [`FREQUENCY_RANGE`]: a scratch is up to ¾ of a cell long. Unequal ones give scratches
    /// of one direction.
    pub frequency: [f64; 3],
    /// The share of cells with a scratch, in [0, 1].
    pub density: f64,
    /// Half the width of a scratch in cells, at most 3/8.
    pub width: f64,
    /// How many lattices of scratches are laid over one another, at most [`Scratches::MOST_LAYERS`].
    pub layers: u32,
}

impl Scratches {
    /// More would leave nothing to scratch.
    pub const MOST_LAYERS: u32 = 64;

    /// Scratches of one layer, with `frequency` cells in a unit of length, each with one.
    pub const fn new(seed: u32, frequency: f64) -> Self {
        Scratches { seed, frequency: [frequency; 3], density: 1.0, width: 0.01, layers: 1 }
    }

    /// The same with `layers` layers.
    pub const fn layers(self, layers: u32) -> Self {
        Scratches { layers, ..self }
    }
}

/// Where a point lies among cells of which there are `frequency` in a unit of length.
fn in_cells<R: Real>(point: &Point<R>, frequency: [f64; 3]) -> Vector<R> {
    let [x, y, z] = frequency.map(R::from_f64);
    Vector::new(point.position.x * x, point.position.y * y, point.position.z * z)
}

/// Which image of a material is looked up, and how often it repeats over the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lookup {
    /// The index among the material's images.
    pub image: usize,
    /// How often it repeats along u and v, in [`FREQUENCY_RANGE`].
    pub repeat: [f64; 2],
}

impl Lookup {
    pub(crate) fn texel<R: Real>(&self, point: &Point<R>, images: &[Image]) -> [R; 4] {
        let uv = [0, 1].map(|axis: usize| point.uv[axis] * R::from_f64(self.repeat[axis]));
        images.get(self.image).map_or([R::ZERO; 4], |image| image.sample(uv))
    }
}

impl From<f64> for Scalar {
    fn from(x: f64) -> Self {
        Scalar::Constant(x)
    }
}

impl Scalar {
    /// This times `factor`, plus `offset`.
    pub fn scaled(self, factor: f64, offset: f64) -> Self {
        Scalar::Scaled { of: Box::new(self), factor, offset }
    }

    /// The product of this and another.
    pub fn times(self, other: impl Into<Scalar>) -> Self {
        Scalar::Product(Box::new(self), Box::new(other.into()))
    }

    /// The sum of this and another.
    pub fn plus(self, other: impl Into<Scalar>) -> Self {
        Scalar::Sum(Box::new(self), Box::new(other.into()))
    }

    /// A mask: 0 up to `at` − `softness`, 1 from `at` + `softness` on.
    pub fn above(self, at: f64, softness: f64) -> Self {
        Scalar::Threshold { of: Box::new(self), at, softness }
    }

    /// A grey mask: 0 at `black`, 1 at `white`.
    pub fn levels(self, black: f64, white: f64) -> Self {
        Scalar::Levels { of: Box::new(self), black, white }
    }

    /// From `first` to `second` as `share` goes from 0 to 1, and no further.
    pub fn mix(first: impl Into<Scalar>, second: impl Into<Scalar>, share: Scalar) -> Self {
        Scalar::Mix(Box::new(first.into()), Box::new(second.into()), Box::new(share))
    }

    /// The number at a point.
    pub fn at<R: Real>(&self, point: &Point<R>, images: &[Image]) -> R {
        let number = R::from_f64;
        match self {
            Scalar::Constant(x) => number(*x),
            Scalar::Of(property) => property.at(point),
            Scalar::Fractal(noise) => {
                let [amplitude, gain, lacunarity] = [noise.amplitude, noise.gain, noise.lacunarity].map(number);
                noise::fractal(
                    in_cells(point, noise.frequency),
                    noise.seed,
                    amplitude,
                    R::ONE,
                    noise.octaves,
                    gain,
                    lacunarity,
                )
            }
            Scalar::Ridged(noise) => {
                let [amplitude, gain, lacunarity] = [noise.amplitude, noise.gain, noise.lacunarity].map(number);
                noise::ridged(
                    in_cells(point, noise.frequency),
                    noise.seed,
                    amplitude,
                    R::ONE,
                    noise.octaves,
                    gain,
                    lacunarity,
                )
            }
            Scalar::Scratches(Scratches { seed, frequency, density, width, layers }) => {
                scratch::scratches(in_cells(point, *frequency), *seed, number(*density), number(*width), *layers)
            }
            Scalar::Image(lookup, channel) => lookup.texel(point, images).get(*channel).copied().unwrap_or(R::ZERO),
            Scalar::Scaled { of, factor, offset } => of.at(point, images) * number(*factor) + number(*offset),
            Scalar::Sum(a, b) => a.at(point, images) + b.at(point, images),
            Scalar::Product(a, b) => a.at(point, images) * b.at(point, images),
            Scalar::Mix(a, b, share) => between(a.at(point, images), b.at(point, images), share.at(point, images)),
            Scalar::Levels { of, black, white } => mask::grey(of.at(point, images), number(*black), number(*white)),
            Scalar::Threshold { of, at, softness } => {
                mask::soft_threshold(of.at(point, images), number(*at), number(*softness))
            }
            Scalar::Extent { of, extent, transition } => {
                patina_extent(number(*extent), number(*transition), of.at(point, images))
            }
        }
    }

    /// The number, where it is the same everywhere.
    pub fn constant(&self) -> Option<f64> {
        match self {
            Scalar::Constant(x) => Some(*x),
            _ => None,
        }
    }

    /// Calls `visit` for this and everything that it is made of.
    pub(crate) fn each(&self, visit: &mut dyn FnMut(&Scalar)) {
        visit(self);
        match self {
            Scalar::Constant(_)
            | Scalar::Of(_)
            | Scalar::Fractal(_)
            | Scalar::Ridged(_)
            | Scalar::Scratches(_)
            | Scalar::Image(..) => {}
            Scalar::Scaled { of, .. }
            | Scalar::Levels { of, .. }
            | Scalar::Threshold { of, .. }
            | Scalar::Extent { of, .. } => of.each(visit),
            Scalar::Sum(a, b) | Scalar::Product(a, b) => [a, b].into_iter().for_each(|part| part.each(visit)),
            Scalar::Mix(a, b, c) => [a, b, c].into_iter().for_each(|part| part.each(visit)),
        }
    }
}

/// From `a` to `b` as `share` goes from 0 to 1; exact at both, and the same beyond them.
#[inline]
fn between<R: Real>(a: R, b: R, share: R) -> R {
    let share = share.saturate();
    a * (R::ONE - share) + b * share
}

/// A colour, or any three numbers, that vary over a surface.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Colour {
    /// The same everywhere.
    Constant([f64; 3]),
    /// The same number in each channel.
    Grey(Scalar),
    /// The colour of a ramp where the number says.
    Ramp(Ramp<3>, Scalar),
    /// The colour of a ramp's band: constant within each, blended within ± `softness` of the edges.
    Bands(Ramp<3>, f64, Scalar),
    /// The colour of an image over `uv`.
    Image(Lookup),
    /// A colour times a number.
    Scaled(Box<Colour>, Scalar),
    /// From the first to the second as the number goes from 0 to 1; the number is clamped there.
    Mix(Box<Colour>, Box<Colour>, Scalar),
    /// What a film that scatters and absorbs reflects over a ground ([`kubelka_munk::film`]).
    Film {
        /// The absorption in 1/length.
        absorption: [f64; 3],
        /// The scattering in 1/length.
        scattering: [f64; 3],
        /// How thick the film is; nothing where it is below 0.
        thickness: Scalar,
        /// The reflectance of what lies under it, clamped to [0, 1].
        ground: Box<Colour>,
    },
}

impl From<[f64; 3]> for Colour {
    fn from(colour: [f64; 3]) -> Self {
        Colour::Constant(colour)
    }
}

impl From<f64> for Colour {
    fn from(grey: f64) -> Self {
        Colour::Constant([grey; 3])
    }
}

impl Colour {
    /// From `first` to `second` as `share` goes from 0 to 1, and no further.
    pub fn mix(first: impl Into<Colour>, second: impl Into<Colour>, share: Scalar) -> Self {
        Colour::Mix(Box::new(first.into()), Box::new(second.into()), share)
    }

    /// The colour at a point.
    pub fn at<R: Real>(&self, point: &Point<R>, images: &[Image]) -> [R; 3] {
        let number = R::from_f64;
        match self {
            Colour::Constant(colour) => colour.map(number),
            Colour::Grey(grey) => [grey.at(point, images); 3],
            Colour::Ramp(ramp, by) => ramp.at(by.at(point, images)),
            Colour::Bands(ramp, softness, by) => ramp.band(number(*softness), by.at(point, images)),
            Colour::Image(lookup) => {
                let [r, g, b, _] = lookup.texel(point, images);
                [r, g, b]
            }
            Colour::Scaled(colour, factor) => {
                let factor = factor.at(point, images);
                colour.at(point, images).map(|x: R| x * factor)
            }
            Colour::Mix(a, b, share) => {
                let (a, b, share) = (a.at(point, images), b.at(point, images), share.at(point, images));
                core::array::from_fn(|c| between(a[c], b[c], share))
            }
            Colour::Film { absorption, scattering, thickness, ground } => {
                let (thickness, ground): (R, [R; 3]) = (thickness.at(point, images), ground.at(point, images));
                let thickness = thickness.max(R::ZERO);
                core::array::from_fn(|c| {
                    kubelka_munk::film(number(absorption[c]), number(scattering[c]), thickness, ground[c].saturate())
                })
            }
        }
    }

    /// The colour, where it is the same everywhere.
    pub fn constant(&self) -> Option<[f64; 3]> {
        match self {
            Colour::Constant(colour) => Some(*colour),
            Colour::Grey(grey) => grey.constant().map(|grey| [grey; 3]),
            _ => None,
        }
    }

    /// Calls `visit` for this and every colour that it is made of, `scalars` for every number.
    pub(crate) fn each(&self, visit: &mut dyn FnMut(&Colour), scalars: &mut dyn FnMut(&Scalar)) {
        visit(self);
        match self {
            Colour::Constant(_) | Colour::Image(_) => {}
            Colour::Grey(by) | Colour::Ramp(_, by) | Colour::Bands(_, _, by) => by.each(scalars),
            Colour::Scaled(colour, factor) => {
                colour.each(visit, scalars);
                factor.each(scalars);
            }
            Colour::Mix(a, b, share) => {
                a.each(visit, scalars);
                b.each(visit, scalars);
                share.each(scalars);
            }
            Colour::Film { thickness, ground, .. } => {
                thickness.each(scalars);
                ground.each(visit, scalars);
            }
        }
    }
}
