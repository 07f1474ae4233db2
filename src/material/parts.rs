//! A material: its parts, what each covers, and the images they read.

use super::field::{Colour, Scalar};
use super::finish::{Body, Boundary, Coat, Finish, Relief};
use super::point::Point;
use super::spot::{MOST_PARTS, Spot};
use super::validity::{texels_problem, validate};
use crate::layered::Stack;
use crate::real::Real;
use crate::texture::image::Image;
use alloc::boxed::Box;
use alloc::format;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;
use core::fmt;

/// A finish and where it covers those before it.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// How much of what lies before it this part covers, in [0, 1] and clamped there. Of no effect in the first part.
    pub cover: Scalar,
    /// What it is made of.
    pub finish: Finish,
}

/// A valid material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    parts: Vec<Part>,
    images: Vec<Image>,
    /// r_i of the coat of each part, 0 where its base takes none.
    returned: Vec<f64>,
}

/// Why parts do not make a material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MaterialError {
    /// Which part, counted from 0.
    pub part: usize,
    /// Which layer of it, where one is at fault.
    pub layer: Option<usize>,
    /// Which key of the part or of the layer, as material files name it, where one is at fault.
    pub key: Option<&'static str>,
    /// What is wrong, and what is allowed.
    pub problem: String,
}

impl fmt::Display for MaterialError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "part[{}]", self.part)?;
        if let Some(layer) = self.layer {
            write!(f, ".layer[{layer}]")?;
        }
        if let Some(key) = self.key {
            write!(f, ".{key}")?;
        }
        write!(f, ": {}", self.problem)
    }
}

impl core::error::Error for MaterialError {}

impl Material {
    /// A material of these parts, the ground first, over these images.
    ///
    /// # Errors
    ///
    /// Names the part, the layer, the key and what is wrong: no part or more than four; no layer or more than four; a diffuse base that is
    /// not the last layer; a model without closed form over layers that vary; numbers that are not finite; noise, scratches and
    /// images finer than [`FREQUENCY_RANGE`](super::field::FREQUENCY_RANGE); octaves, layers of scratches,
    /// images or channels that do not exist; more than [`MOST_TEXELS`](crate::texture::image::MOST_TEXELS) texels in all.
    ///
    /// What would create light or have no effect: `returns` without a Lambertian base under one clear coat of a constant index ≥ 1, or under
    /// another model than `conserving`; `scatter` over a diffuse top; a medium under the last layer; a height that is nowhere steep because
    /// it is made of occlusion and distance alone; a step or a strength beyond what slopes are clamped to ([`Relief`]).
    pub fn new(parts: Vec<Part>, images: Vec<Image>) -> Result<Self, MaterialError> {
        let count = parts.len();
        if !(1..=MOST_PARTS).contains(&count) {
            let problem = format!("there are {count} parts, a material has 1 to {MOST_PARTS}");
            return Err(MaterialError { part: count, layer: None, key: None, problem });
        }
        if let Some(problem) = texels_problem(images.iter().map(|image| (image.width(), image.height()))) {
            return Err(MaterialError { part: 0, layer: None, key: None, problem });
        }
        let mut returned = Vec::new();
        for (index, part) in parts.iter().enumerate() {
            returned.push(validate(index, part, &images)?);
        }
        Ok(Material { parts, images, returned })
    }

    /// A material of one finish.
    ///
    /// # Errors
    /// As [`Material::new`].
    pub fn plain(finish: Finish) -> Result<Self, MaterialError> {
        Self::new(vec![Part { cover: Scalar::Constant(1.0), finish }], Vec::new())
    }

    /// The parts, the ground first.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The images that its fields look up.
    pub fn images(&self) -> &[Image] {
        &self.images
    }

    /// What r_i of the coat of each part is, 0 where its base takes none.
    pub(crate) fn returned(&self) -> &[f64] {
        &self.returned
    }

    /// The material at a point.
    pub fn at<R: Real>(&self, point: &Point<R>) -> Spot<'_, R> {
        Spot::new(self, point)
    }

    /// Whether it is the same at every point.
    pub fn is_constant(&self) -> bool {
        self.parts.iter().all(|part| {
            let (mut colours, mut numbers) = (true, true);
            part.finish.each(&mut |colour| colours &= colour.constant().is_some(), &mut |scalar| {
                numbers &= scalar.constant().is_some()
            });
            let even = part.cover.constant().is_some() && part.finish.relief.is_none() && !part.finish.has_flakes();
            colours && numbers && even
        })
    }
}

/// A stack is a material that is the same everywhere.
impl From<Stack<f64, 3>> for Material {
    fn from(stack: Stack<f64, 3>) -> Self {
        let finish = Finish::new(Body::Whole(Box::new(stack)));
        let part = Part { cover: Scalar::Constant(1.0), finish };
        Material { parts: vec![part], images: Vec::new(), returned: vec![0.0] }
    }
}

impl Finish {
    /// Calls `colours` and `scalars` for every field that it is made of.
    pub(crate) fn each(&self, colours: &mut dyn FnMut(&Colour), scalars: &mut dyn FnMut(&Scalar)) {
        self.reflectivity.each(colours, scalars);
        if let Some(Relief::Height { height, .. }) = &self.relief {
            height.each(scalars);
        }
        match &self.body {
            Body::Layers(layers) => {
                for coat in &layers.coats {
                    coat.each(colours, scalars);
                }
                if let Some(sigma) = &layers.scatter {
                    sigma.each(colours, scalars);
                }
            }
            Body::Brushed(metal) => {
                metal.n.each(colours, scalars);
                metal.k.each(colours, scalars);
                [&metal.along, &metal.across, &metal.turn].into_iter().for_each(|field| field.each(scalars));
            }
            Body::Whole(_) => {}
        }
    }

    pub(crate) fn has_flakes(&self) -> bool {
        matches!(&self.body, Body::Layers(layers) if layers.coats.iter().any(|coat| coat.flakes.is_some()))
    }
}

impl Coat {
    fn each(&self, colours: &mut dyn FnMut(&Colour), scalars: &mut dyn FnMut(&Scalar)) {
        match &self.boundary {
            Boundary::Microfacet { n, k, alpha } => {
                n.each(colours, scalars);
                k.each(colours, scalars);
                alpha.each(scalars);
            }
            Boundary::Diffuse { albedo, sigma } => {
                albedo.each(colours, scalars);
                sigma.each(scalars);
            }
        }
        self.sigma.each(colours, scalars);
        self.thickness.each(scalars);
    }
}
