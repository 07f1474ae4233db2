//! Textures: how the parameters of a material vary over a surface.
//!
//! [`noise`] and [`scratch`] are made of a hash, [`image`] of texels; [`ramp`] makes colours of grey values, [`mask`] decides between two materials,
//! [`bump`] tilts the normal. Each is the documents' (Mihaylov 2013, §3.2–3.3 and §4.2–4.3), as a function of a point and of
//! parameters, with a twin in WGSL.
//!
//! ```
//! use brdf::Vector;
//! use brdf::texture::{mask, noise, ramp};
//!
//! // Rust over iron (M §4.3): a mask and a colour, each of its own noise.
//! let p = Vector::new(0.3, 0.4, 0.866);
//! let height = noise::fractal(p, 1, 0.5, 4.0, 5, 0.5, 2.0);
//! let rust = mask::soft_threshold(0.5 + height, 0.5, 0.05);
//! let grain: f64 = noise::fractal(p, 2, 0.5, 16.0, 4, 0.5, 2.0);
//! let tone = (0.5 + grain).clamp(0.0, 1.0);
//! let colour = ramp::two([0.11, 0.04, 0.02], [0.35, 0.12, 0.04], [tone; 3]);
//! assert!((0.0..=1.0).contains(&rust) && colour[0] > colour[2]);
//! ```

pub mod bump;
pub mod image;
pub mod mask;
pub mod noise;
pub mod ramp;
pub mod scratch;
