//! The smallest renderer that shows materials honestly.
//!
//! A [`Scene`] is one [`shape`] of one material before a [`camera`], under [`light`]s and an [`environment`]. It is rendered in two modes:
//! [`realtime`] is the documents' local model, lights and pre-filtered environment at a few points of each pixel (Elek 2010, Alg. 1); [`offline`] a
//! path tracer, whose pixels carry a variance. Both run over f32 and f64 on the CPU's threads and, with the feature `gpu`, as compute kernels
//! with the same texels and the same random numbers ([`gpu`]). The result is a [`film`].
//!
//! The world is right-handed with +z up. Shapes are about the size of a unit sphere around the origin. A pixel is the radiance that arrives, in
//! the units of the lights; nothing is exposed or clipped before a film is written.

pub mod bvh;
pub mod camera;
pub mod environment;
pub mod film;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod light;
pub mod mesh;
mod obj;
pub mod octahedral;
pub mod offline;
pub mod prefilter;
pub mod realtime;
pub mod scene;
pub mod shading;
pub mod shape;
pub mod sources;
pub mod texture;
pub mod torus;

pub use film::Film;
pub use scene::Scene;

use crate::real::Real;

/// The numbers that pictures are computed in: a [`Real`] whose comparisons have one answer.
pub trait Number: Real<Mask = bool> {}
impl<R: Real<Mask = bool>> Number for R {}

/// Told from time to time, by any thread, which part of a picture is done.
pub type Progress<'a> = dyn Fn(f64) + Sync + 'a;
