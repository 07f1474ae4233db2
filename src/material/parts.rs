//! A material: its parts, what each covers, and the images they read.

use super::field::{Colour, Lookup, Noise, Scalar, Scratches};
use super::finish::{Body, Boundary, Coat, Finish, Flakes, Relief};
use super::point::Point;
use super::spot::{MOST_LAYERS, MOST_PARTS, Spot};
use crate::layered::{Model, Stack, internal_reflectance};
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
    /// What is wrong, and what is allowed.
    pub problem: String,
}

impl fmt::Display for MaterialError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.layer {
            Some(layer) => write!(f, "part[{}].layer[{layer}]: {}", self.part, self.problem),
            None => write!(f, "part[{}]: {}", self.part, self.problem),
        }
    }
}

impl core::error::Error for MaterialError {}

impl Material {
    /// A material of these parts, the ground first, over these images.
    ///
    /// # Errors
    ///
    /// Names the part, the layer and what is wrong: no part or more than four; no layer or more than four; a diffuse base that is
    /// not the last layer; a model without closed form over layers that vary; numbers that are not finite; octaves, layers of scratches, images or channels that
    /// do not exist; `returns` without a diffuse base under one clear coat of a constant index.
    pub fn new(parts: Vec<Part>, images: Vec<Image>) -> Result<Self, MaterialError> {
        let count = parts.len();
        if !(1..=MOST_PARTS).contains(&count) {
            return Err(at(count, None, format!("there are {count} parts, a material has 1 to {MOST_PARTS}")));
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

    fn has_flakes(&self) -> bool {
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

fn at(part: usize, layer: Option<usize>, problem: String) -> MaterialError {
    MaterialError { part, layer, problem }
}

/// The first problem of a part; else r_i of its coat.
fn validate(index: usize, part: &Part, images: &[Image]) -> Result<f64, MaterialError> {
    let mut problem = None;
    part.cover.each(&mut |scalar| problem = problem.take().or_else(|| scalar_problem(scalar, images)));
    let mut of_colours = None;
    part.finish
        .each(&mut |colour| of_colours = of_colours.take().or_else(|| colour_problem(colour, images)), &mut |scalar| {
            problem = problem.take().or_else(|| scalar_problem(scalar, images))
        });
    let of_relief = part.finish.relief.as_ref().and_then(|relief| relief_problem(relief, images));
    if let Some(problem) = problem.or(of_colours).or(of_relief) {
        return Err(at(index, None, problem));
    }
    let Body::Layers(layers) = &part.finish.body else { return Ok(0.0) };
    let (model, coats) = (layers.model, &layers.coats);
    if !Model::CLOSED_FORM.contains(&model) {
        let names = Model::CLOSED_FORM.map(Model::name).join(", ");
        let problem = format!("layers that vary take the models {names}, not {}; a stack takes any", model.name());
        return Err(at(index, None, problem));
    }
    if !(1..=MOST_LAYERS).contains(&coats.len()) {
        return Err(at(index, None, format!("there are {} layers, a part has 1 to {MOST_LAYERS}", coats.len())));
    }
    for (position, coat) in coats.iter().enumerate() {
        let base = matches!(coat.boundary, Boundary::Diffuse { .. });
        if base && position + 1 < coats.len() {
            return Err(at(
                index,
                Some(position),
                "a diffuse base lets nothing through: make it the last layer".into(),
            ));
        }
        let flawed = coat.flakes.as_ref().and_then(|flakes| flakes_problem(flakes, base, images));
        if let Some(problem) = flawed {
            return Err(at(index, Some(position), problem));
        }
    }
    if !layers.returns {
        return Ok(0.0);
    }
    returned(coats).ok_or_else(|| {
        at(index, None, "`returns` needs a diffuse base under one clear dielectric of a constant index".into())
    })
}

/// r_i of the coat over a diffuse base.
fn returned(coats: &[Coat]) -> Option<f64> {
    let [coat, base] = coats else { return None };
    let clear = coat.sigma.constant() == Some([0.0; 3]) || coat.thickness.constant() == Some(0.0);
    match (&coat.boundary, &base.boundary) {
        (Boundary::Microfacet { n, k, .. }, Boundary::Diffuse { .. }) if clear => match (n.constant(), k.constant()) {
            (Some([n, g, b]), Some([0.0, 0.0, 0.0])) if n == g && n == b && n >= 1.0 => {
                Some(internal_reflectance(n, 0.0, 0.0))
            }
            _ => None,
        },
        _ => None,
    }
}

fn scalar_problem(scalar: &Scalar, images: &[Image]) -> Option<String> {
    let finite = |numbers: &[f64]| {
        let bad = numbers.iter().find(|number| !number.is_finite());
        bad.map(|number| format!("a field has the number {number}, numbers are finite"))
    };
    match scalar {
        Scalar::Constant(x) => finite(&[*x]),
        Scalar::Fractal(noise) | Scalar::Ridged(noise) => {
            let Noise { amplitude, frequency: [x, y, z], gain, lacunarity, octaves, .. } = *noise;
            let most = Noise::MOST_OCTAVES;
            let many = !(1..=most).contains(&octaves);
            finite(&[amplitude, x, y, z, gain, lacunarity])
                .or_else(|| many.then(|| format!("a noise has {octaves} octaves, it may have 1 to {most}")))
        }
        Scalar::Scratches(scratches) => {
            let Scratches { frequency: [x, y, z], density, width, layers, .. } = *scratches;
            let most = Scratches::MOST_LAYERS;
            let many = !(1..=most).contains(&layers);
            finite(&[x, y, z, density, width])
                .or_else(|| negative("density", density))
                .or_else(|| negative("width", width))
                .or_else(|| many.then(|| format!("scratches have {layers} layers, they may have 1 to {most}")))
        }
        Scalar::Image(lookup, channel) => {
            let many = *channel > 3;
            lookup_problem(lookup, images)
                .or_else(|| many.then(|| format!("channel {channel} does not exist, channels are 0 to 3")))
        }
        Scalar::Scaled { factor, offset, .. } => finite(&[*factor, *offset]),
        Scalar::Levels { black, white, .. } => finite(&[*black, *white]),
        Scalar::Threshold { at, softness, .. } => finite(&[*at, *softness]).or_else(|| negative("softness", *softness)),
        Scalar::Extent { extent, transition, .. } => {
            finite(&[*extent, *transition]).or_else(|| negative("transition", *transition))
        }
        Scalar::Of(_) | Scalar::Sum(..) | Scalar::Product(..) | Scalar::Mix(..) => None,
    }
}

fn negative(name: &str, number: f64) -> Option<String> {
    (number < 0.0).then(|| format!("{name} is {number}, it is at least 0"))
}

fn colour_problem(colour: &Colour, images: &[Image]) -> Option<String> {
    let finite = |numbers: &[f64]| {
        let bad = numbers.iter().find(|number| !number.is_finite());
        bad.map(|number| format!("a colour has the number {number}, numbers are finite"))
    };
    match colour {
        Colour::Constant(colour) => finite(colour),
        Colour::Bands(_, softness, _) => finite(&[*softness]).or_else(|| negative("softness", *softness)),
        Colour::Image(lookup) => lookup_problem(lookup, images),
        Colour::Film { absorption, scattering, .. } => {
            let all = [*absorption, *scattering].concat();
            finite(&all).or_else(|| {
                all.iter().find(|x| **x < 0.0).map(|x| format!("a film absorbs or scatters {x}, at least 0"))
            })
        }
        Colour::Grey(_) | Colour::Ramp(..) | Colour::Scaled(..) | Colour::Mix(..) => None,
    }
}

fn lookup_problem(lookup: &Lookup, images: &[Image]) -> Option<String> {
    let Lookup { image, repeat } = lookup;
    if *image >= images.len() {
        return Some(format!("image {image} does not exist, the material has {}", images.len()));
    }
    let bad = repeat.iter().find(|number| !number.is_finite());
    bad.map(|number| format!("an image repeats {number} times, numbers are finite"))
}

fn relief_problem(relief: &Relief, images: &[Image]) -> Option<String> {
    match relief {
        Relief::Height { step, .. } => {
            let usable = step.is_finite() && *step > 0.0;
            (!usable).then(|| format!("the step of a height is {step}, it is positive"))
        }
        Relief::Map { normals, strength, .. } => lookup_problem(normals, images).or_else(|| {
            (!strength.is_finite()).then(|| format!("the strength of a normal map is {strength}, it is finite"))
        }),
    }
}

fn flakes_problem(flakes: &Flakes, base: bool, images: &[Image]) -> Option<String> {
    if base {
        return Some("a diffuse base has no flakes".into());
    }
    match flakes {
        Flakes::Glints { spacing, resolution, .. } => {
            let usable = spacing.is_finite() && *spacing > 0.0;
            let most = super::glint::FINEST;
            (!usable).then(|| format!("the spacing of flakes is {spacing}, it is positive")).or_else(|| {
                (*resolution > most).then(|| format!("the resolution of flakes is {resolution}, at most {most}"))
            })
        }
        Flakes::AsPrinted { normals } => lookup_problem(normals, images),
    }
}
