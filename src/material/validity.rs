//! What parts must meet to make a material, and what is said of those that do not.

use super::field::{Colour, FREQUENCY_RANGE, Lookup, Noise, Property, Scalar, Scratches};
use super::finish::{Body, Boundary, Coat, Flakes, Layers, Relief, STEP_RANGE, STRENGTH_RANGE};
use super::parts::{MaterialError, Part};
use super::spot::MOST_LAYERS;
use crate::layered::{Model, internal_reflectance};
use crate::texture::image::{Image, MOST_TEXELS};
use alloc::format;
use alloc::string::String;
use core::ops::RangeInclusive;

/// The first problem of a part; else r_i of its coat, 0 where its base takes none.
pub(super) fn validate(part: usize, of: &Part, images: &[Image]) -> Result<f64, MaterialError> {
    let problem_at = |layer, key, problem: String| MaterialError { part, layer, key, problem };
    let mut problem = None;
    of.cover.each(&mut |scalar| problem = problem.take().or_else(|| scalar_problem(scalar, images)));
    let mut of_colours = None;
    of.finish
        .each(&mut |colour| of_colours = of_colours.take().or_else(|| colour_problem(colour, images)), &mut |scalar| {
            problem = problem.take().or_else(|| scalar_problem(scalar, images))
        });
    if let Some(problem) = problem.or(of_colours) {
        return Err(problem_at(None, None, problem));
    }
    if let Some(problem) = of.finish.relief.as_ref().and_then(|relief| relief_problem(relief, images)) {
        return Err(problem_at(None, Some("relief"), problem));
    }
    let Body::Layers(layers) = &of.finish.body else { return Ok(0.0) };
    let (model, coats) = (layers.model, &layers.coats);
    if !Model::CLOSED_FORM.contains(&model) {
        let names = Model::CLOSED_FORM.map(Model::name).join(", ");
        let problem = format!("layers that vary take the models {names}, not {}; a stack takes any", model.name());
        return Err(problem_at(None, Some("model"), problem));
    }
    if !(1..=MOST_LAYERS).contains(&coats.len()) {
        let problem = format!("there are {} layers, a part has 1 to {MOST_LAYERS}", coats.len());
        return Err(problem_at(None, None, problem));
    }
    for (position, coat) in coats.iter().enumerate() {
        let (base, last) = (matches!(coat.boundary, Boundary::Diffuse { .. }), position + 1 == coats.len());
        if base && !last {
            let problem = "a diffuse base lets nothing through: make it the last layer";
            return Err(problem_at(Some(position), None, problem.into()));
        }
        let flawed = coat.flakes.as_ref().and_then(|flakes| flakes_problem(flakes, base, images));
        if let Some(problem) = flawed {
            return Err(problem_at(Some(position), Some("flakes"), problem));
        }
        if last && !is_clear(coat) {
            let problem =
                "no light comes back through a medium under the last layer: leave it out, or put a layer under it";
            return Err(problem_at(Some(position), Some("medium"), problem.into()));
        }
    }
    let of_diffuse = coats.first().is_some_and(|coat| matches!(coat.boundary, Boundary::Diffuse { .. }));
    if layers.scatter.is_some() && of_diffuse {
        let problem = "the documents' diffuse term is that of a reflecting layer: leave it out, or put a dielectric or conductor on top";
        return Err(problem_at(None, Some("scatter"), problem.into()));
    }
    returned(layers).map_err(|problem| problem_at(None, Some("returns"), problem.into()))
}

/// What is said of more texels than a material may have.
pub(super) fn texels_problem(sizes: impl Iterator<Item = (u32, u32)>) -> Option<String> {
    let texels: u64 = sizes.map(|(width, height)| u64::from(width) * u64::from(height)).fold(0, u64::saturating_add);
    let many = texels > MOST_TEXELS as u64;
    many.then(|| {
        format!("the images have {texels} texels together, a material has at most {MOST_TEXELS}: use smaller ones")
    })
}

/// Whether the medium under an interface absorbs nothing.
fn is_clear(coat: &Coat) -> bool {
    coat.sigma.constant() == Some([0.0; 3]) || coat.thickness.constant() == Some(0.0)
}

/// r_i of the coat over a diffuse base, where `returns` is asked for, less what [`KEPT`] says.
///
/// Only where nothing can be created: under `conserving`, whose transmittances are those that r_i belongs to, and over Lambert's base. What an
/// Oren–Nayar base reflects is not linear in ρ: with ρ/(1 − ρ·r_i) > 1 as its albedo it sends back up to 2.1 times what arrives.
fn returned(layers: &Layers) -> Result<f64, &'static str> {
    if !layers.returns {
        return Ok(0.0);
    }
    if layers.model != Model::Conserving {
        return Err(
            "goes with the model `conserving` alone, the others keep more light than there is already: leave one of them out",
        );
    }
    let alone = "needs a diffuse base under one clear dielectric of a constant index from 1 to 3";
    let [coat, base] = layers.coats.as_slice() else { return Err(alone) };
    let (Boundary::Microfacet { n, k, .. }, Boundary::Diffuse { sigma, .. }) = (&coat.boundary, &base.boundary) else {
        return Err(alone);
    };
    let (Some([n, g, b]), Some([0.0, 0.0, 0.0])) = (n.constant(), k.constant()) else { return Err(alone) };
    if n != g || n != b || !(1.0..=3.0).contains(&n) || !is_clear(coat) {
        return Err(alone);
    }
    if sigma.constant() != Some(0.0) {
        return Err(
            "needs a Lambertian base, over Oren–Nayar's it would create light: set its sigma to 0, or use a part with `stack` and the model `coupled`",
        );
    }
    Ok((1.0 - (1.0 - internal_reflectance(n, 0.0, 0.0)) / (1.0 - KEPT)).max(0.0))
}

/// What of the returned light a coat keeps. r_i and T are those of a smooth coat, 1 − F at its own normal; a rough one reflects up to .0023 of T
/// more than F (its single scattering at 45°, α = .2, n = 1.5; less for any other α ≤ 1 and n to 3), which a white base would send out beyond what
/// arrives. From n = 6 on it is more than that.
const KEPT: f64 = 0.0025;

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
                .or_else(|| beyond("the frequency of a noise", &noise.frequency))
                .or_else(|| many.then(|| format!("a noise has {octaves} octaves, it may have 1 to {most}")))
                .or_else(|| too_fine(noise))
        }
        Scalar::Scratches(scratches) => {
            let Scratches { frequency: [x, y, z], density, width, layers, .. } = *scratches;
            let most = Scratches::MOST_LAYERS;
            let many = !(1..=most).contains(&layers);
            finite(&[x, y, z, density, width])
                .or_else(|| beyond("the frequency of scratches", &scratches.frequency))
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
    beyond("the repetition of an image", repeat)
}

/// What is said of a number of cells in a unit of length that are too many.
fn beyond(what: &str, frequency: &[f64]) -> Option<String> {
    let (low, high) = (FREQUENCY_RANGE.start(), FREQUENCY_RANGE.end());
    let bad = frequency.iter().find(|number| !FREQUENCY_RANGE.contains(number));
    bad.map(|number| format!("{what} is {number:e}, it must be in [{low}, {high}]"))
}

/// What is said of a noise whose last octave is too fine.
fn too_fine(noise: &Noise) -> Option<String> {
    let Noise { frequency, lacunarity, octaves, .. } = noise;
    let last = frequency.iter().fold(0.0f64, |most, x| most.max(x.abs()))
        * lacunarity.abs().powf(f64::from(octaves.saturating_sub(1)));
    (last > Noise::MOST_CELLS).then(|| {
        let most = Noise::MOST_CELLS;
        format!("the last octave of a noise has {last:e} cells in a unit of length, at most {most}: lower its lacunarity, octaves or frequency")
    })
}

fn relief_problem(relief: &Relief, images: &[Image]) -> Option<String> {
    let outside = |what: &str, number: f64, range: &RangeInclusive<f64>| {
        let (low, high) = (range.start(), range.end());
        (!range.contains(&number)).then(|| format!("the {what} is {number:e}, it must be in [{low:e}, {high:e}]"))
    };
    match relief {
        Relief::Height { height, step } => outside("step of a height", *step, &STEP_RANGE).or_else(|| {
            let mut leaves = Leaves::default();
            height.each(&mut |scalar| leaves.add(scalar));
            leaves.are_flat().then(|| {
                "a step moves neither `occlusion` nor `distance`, a height of them alone has no slope: give it a field of the place".into()
            })
        }),
        Relief::Map { normals, strength, .. } => {
            lookup_problem(normals, images).or_else(|| outside("strength of a normal map", *strength, &STRENGTH_RANGE))
        }
    }
}

/// What a height is made of in the end.
#[derive(Default)]
struct Leaves {
    of_the_place: bool,
    of_the_view: bool,
}

impl Leaves {
    fn add(&mut self, scalar: &Scalar) {
        match scalar {
            Scalar::Of(Property::Occlusion | Property::Distance) => self.of_the_view = true,
            Scalar::Of(_) | Scalar::Fractal(_) | Scalar::Ridged(_) | Scalar::Scratches(_) | Scalar::Image(..) => {
                self.of_the_place = true;
            }
            _ => {}
        }
    }

    /// A constant is flat as well, but says so.
    fn are_flat(&self) -> bool {
        self.of_the_view && !self.of_the_place
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_are_counted_without_overflow() {
        assert_eq!(texels_problem([(1 << 14, 1 << 14)].into_iter()), None);
        for sizes in [[(1 << 14, 1 << 14), (1, 1)], [(u32::MAX, u32::MAX); 2], [(1 << 16, 1 << 15); 2]] {
            let problem = texels_problem(sizes.into_iter()).unwrap_or_default();
            assert!(problem.contains("at most 268435456"), "{sizes:?}: {problem}");
        }
    }
}
