//! Materials: from a point of a surface to what it reflects, and the measured data they are made of.
//!
//! [`metal`] holds indices of refraction, [`stack`] the built-in stacks. A [`Material`] is made of parts, each of which covers those
//! before it where its mask says so, in the share that it says. A part's [`Finish`] is made of [fields](field), which vary over the surface.
//! At a [`Point`] the fields become numbers: a [`Spot`], which is evaluated, sampled and looked up in pre-filtered environments.
//!
//! ```text
//! Point ── fields ──► Spot ── (wi, wo) ──► f·cos
//! ```
//!
//! [`built_in`] holds the documents' materials, functions from their parameters to a [`Material`]. The terms that only they need are
//! [`patina`], [`flake`], [`glint`], [`brushed`] and [`kubelka_munk`].
//!
//! # Material files
//!
//! A material as an artist writes it down, in TOML (`description::read_file`, feature `toml`). Either a built-in one with its numbers changed,
//!
//! ```toml
//! material = "patina"
//! parameters = { extent = 0.75 }
//! ```
//!
//! or parts, the ground first:
//!
//! ```toml
//! name = "rusty iron"
//! [[part]]
//! layer = [{ interface = { conductor = { metal = "iron" }, alpha = 0.2 } }]
//! [[part]]
//! cover = { above = 0.5, softness = 0.02, of = { of = { noise = { seed = 3, frequency = 2.5, octaves = 6 } }, scale = 0.6, offset = 0.5 } }
//! relief = { height = { noise = { seed = 4, frequency = 7.5, octaves = 6, amplitude = 0.01 } }, step = 0.004 }
//! [[part.layer]]
//! interface = { diffuse = { albedo = { ramp = [[0.04, 0.01, 0.01], [0.4, 0.1, 0.04]], by = { image = "rust.png" } }, sigma = 0.5 } }
//! ```
//!
//! | key | value |
//! |---|---|
//! | a number (*S*) | `0.5`; `"occlusion"` and the others of [`field::Property::ALL`]; `{ noise = { seed, amplitude, frequency, octaves, gain, lacunarity } }` (frequency a number or three, in [−10⁴, 10⁴]); `{ ridged = … }`; `{ scratches = { seed, frequency, density, width, layers } }`; `{ image = "file", channel = "r", repeat = 2 }` (repeat a number or two, in [−10⁴, 10⁴]); `{ of = S, scale, offset }`; `{ sum = [S, S, …] }`; `{ product = [S, S, …] }`; `{ mix = [S, S], by = S }`, `by` clamped to [0, 1]; `{ levels = [black, white], of = S }`; `{ above = at, softness, of = S }`: 0 up to at − softness, 1 from at + softness on; `{ extent, transition, of = S }` |
//! | a colour (*C*) | a number; `[r, g, b]`; `{ grey = S }`; `{ ramp = [[r, g, b], …], by = S }`, with `at = [0.0, …, 1.0]` where stops are not even; `{ bands = [[r, g, b], …], softness, by = S }`, blended within ± softness of the edges, `at` as in a ramp; `{ image = "file", srgb, repeat }` (srgb = true where absent); `{ colour = C, scale = S }`; `{ mix = [C, C], by = S }`; `{ film = { absorption, scattering, thickness = S, ground = C } }` |
//! | part | `cover = S`; `reflectivity = C`; `relief = { height = S, step }` (step from 1e-5, the height of some place) or `{ normals = { image = … }, encoding = "rgb"` or `"alpha_green", strength }`; and `layer`, `brushed` or `stack` |
//! | part with layers | `layer = [ … ]`, from the top; `model`, `widths`; `returns = true`, over a Lambertian base under one clear dielectric and `conserving`; `scatter = C` in [0, 1], over a dielectric or conductor |
//! | layer | `interface = { dielectric = { n = C }, alpha = S }`, `{ conductor = { metal = "copper" }, alpha = S }` (or `n = C, k = C`), `{ diffuse = { albedo = C, sigma = S } }`; `medium = { sigma = C, thickness = S }`, not under the last; `flakes = { spacing, resolution, seed }` or `{ normals = { image = "file", repeat = 1000 } }` |
//! | brushed part | `brushed = { metal = "chromium", along = S, across = S, turn = S }` (or `n = C, k = C`); turn 0: grooves along u, ¼: along v; whole turns change nothing |
//! | stack part | `stack = { … }`: a stack file's tree, under any model |
//!
//! Images are read by the caller, from beside the file. Whatever is not understood is refused, with the line, the key and what is allowed.

pub mod brushed;
#[cfg(feature = "std")]
pub mod built_in;
#[cfg(feature = "toml")]
pub mod description;
#[cfg(feature = "std")]
pub mod field;
#[cfg(feature = "std")]
pub mod finish;
pub mod flake;
pub mod glint;
pub mod kubelka_munk;
pub mod metal;
#[cfg(feature = "std")]
mod mirror;
#[cfg(feature = "std")]
mod parts;
pub mod patina;
mod point;
#[cfg(feature = "std")]
pub mod spot;
pub mod stack;
#[cfg(feature = "std")]
mod validity;

#[cfg(feature = "std")]
pub use field::{Colour, Scalar};
#[cfg(feature = "std")]
pub use finish::Finish;
#[cfg(feature = "std")]
pub use parts::{Material, MaterialError, Part};
pub use point::Point;
#[cfg(feature = "std")]
pub use spot::{Seen, Spot};
