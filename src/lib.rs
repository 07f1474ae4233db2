//! Reflectance maths that is exact enough to be the reference and fast enough to be the inner loop.
//!
//! # Conventions
//!
//! Stated once, here, and true of every function in the crate and of its WGSL twin:
//!
//! * `f` is a BRDF in sr⁻¹, *without* the cosine. The radiance reflected from one light is `f · cos_i · irradiance⊥`.
//! * Directions are unit vectors that point *away* from the surface: `wi` towards the light, `wo` towards the viewer.
//! * They live in the local shading frame: normal +z, tangent +x ([`frame::Frame`] converts). `wi.z` and `wo.z` are the
//!   cosines; where either is ≤ 0, `f` is 0.
//! * The half vector `h` = wi + wo is *not* normalised ([`frame::half_vector`]).
//! * Indices of refraction are `n + iκ` with κ ≥ 0; a term takes them relative to the medium that the light is in
//!   (`eta` = n_t/n_i), a [`layered::Stack`] takes those of the materials themselves.
//! * `alpha` is the width of a microfacet distribution, Beckmann's slope parameter √2·rms slope (the documents' `m`).
//! * Albedo is ∫ f·cos dω over the hemisphere.
//! * Errors are in ULP, the spacing of the number type at the exact result, for inputs that are exact: each stated bound
//!   is asserted by `tests/accuracy`, which reads it from the documentation and measures it (`docs/accuracy.md`).
//!
//! # Outside the domain
//!
//! No input makes a function panic. Every function states its domain; of finite numbers outside it `tests/adversary` holds:
//!
//! * Directions and half vectors of any length in [1e-20, 1e20], on either side of the horizon; widths in [1e-30, 1e10];
//!   indices n in [1e-30, 1e30], κ in [0, 1e30]; σ, thickness and exponents in [0, 1e30]; cosines and shares in [0, 1]: the
//!   result is finite and ≥ 0 (a component of a vector or a part of a sum may be negative). It is what the formula gives;
//!   only unit directions make it a BRDF. A component of a refracted direction may be ±∞ where it exceeds the number type.
//! * With a direction or half vector at or below the horizon every distribution, masking term and BRDF is 0. Fresnel terms,
//!   refraction, projected areas and [`microfacet::cos_half`] do not ask which side it is on.
//! * Cosines and shares in [−2, 2] give no NaN, but are not clamped: F may exceed 1, T or a diffuse term be negative.
//! * A width or an index of 0 may give NaN where its limit depends on the direction (α at the normal, η = 0); a negative
//!   width of one axis gives a negative D. NaN and infinite arguments may give anything, NaN included.
//!
//! A [`layered::Stack`] refuses parameters outside the stated ranges when it is made.
//!
//! # From a direction to radiance
//!
//! [`real`] and [`frame`] are the numbers and directions; [`fresnel`] ([`fresnel_fit`]), [`distribution`], [`masking`], [`diffuse`],
//! [`refraction`], [`absorption`] and [`phong`] are the terms; [`microfacet`] and [`layered`] are whole BRDFs,
//! [`sampling`] draws directions for them; [`table`] holds F and D as texels; [`texture`] is how their parameters vary over a
//! surface; [`material`] holds measured data. [`wgsl`] holds the WGSL twin of each of these functions under the same name.
#![cfg_attr(not(feature = "std"), no_std)]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("brdf needs floating-point functions: enable the feature `std` (default) or `libm`");

extern crate alloc;

pub mod absorption;
pub mod batch;
#[cfg(feature = "check")]
pub mod check;
pub mod diffuse;
pub mod distribution;
pub mod frame;
pub mod fresnel;
pub mod fresnel_fit;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod interval;
pub mod layered;
pub mod masking;
pub mod material;
pub mod microfacet;
#[cfg(feature = "gpu")]
pub mod parity;
pub mod phong;
pub mod plan;
pub mod random;
pub mod real;
pub mod refraction;
#[cfg(feature = "render")]
pub mod render;
pub mod sampling;
mod series;
#[cfg(feature = "shader")]
pub mod shader;
pub mod single;
pub mod table;
pub mod texture;
mod twofold;
#[cfg(feature = "std")]
pub mod walk;
pub mod wgsl;

pub use frame::{Frame, Vector, half_vector};
pub use real::{Mask, Real};

/// The examples of the README, as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct ReadmeExamples;
