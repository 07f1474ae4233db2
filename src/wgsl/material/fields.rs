//! Fields as WGSL: a statement for each node, in the order in which they are needed.

use crate::material::field::{Colour, Lookup, Noise, Property, Scalar, Scratches};
use crate::texture::image::Image;
use crate::texture::ramp::Ramp;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// A number as WGSL writes it, in all its digits: a shader in double precision has them all.
pub(super) fn literal(x: f64) -> String {
    let most = f64::from(f32::MAX);
    let text = format!("{:?}", x.clamp(-most, most));
    if text.starts_with('-') { format!("({text})") } else { text }
}

pub(super) fn vector([x, y, z]: [f64; 3]) -> String {
    format!("vec3f({}, {}, {})", literal(x), literal(y), literal(z))
}

/// The statements of one function, and what they need outside it.
pub(super) struct Statements<'a> {
    pub(super) images: &'a [Image],
    /// The stops of all ramps, one after another.
    pub(super) stops: &'a mut Vec<[f64; 4]>,
    pub(super) text: String,
    /// How many names were given.
    names: usize,
}

impl<'a> Statements<'a> {
    pub(super) fn new(images: &'a [Image], stops: &'a mut Vec<[f64; 4]>) -> Self {
        Statements { images, stops, text: String::new(), names: 0 }
    }

    /// A name for the value of an expression.
    pub(super) fn named(&mut self, expression: &str) -> String {
        self.names += 1;
        let name = format!("value_{}_", self.names);
        self.text += &format!("    let {name} = {expression};\n");
        name
    }

    /// The expression of a number at `point`.
    pub(super) fn scalar(&mut self, scalar: &Scalar) -> String {
        let expression = match scalar {
            Scalar::Constant(x) => return literal(*x),
            Scalar::Of(property) => return property_of(*property).to_string(),
            Scalar::Fractal(noise) => noise_call("fractal", noise),
            Scalar::Ridged(noise) => noise_call("ridged", noise),
            Scalar::Scratches(Scratches { seed, frequency, density, width, layers }) => {
                let (place, [density, width]) = (in_cells(*frequency), [*density, *width].map(literal));
                format!("brdf::scratch::scratches({place}, {seed}u, {density}, {width}, {layers}u)")
            }
            Scalar::Image(lookup, channel) => {
                let component = ["x", "y", "z", "w"].get(*channel).copied().unwrap_or("w");
                format!("{}.{component}", self.texel(lookup))
            }
            Scalar::Scaled { of, factor, offset } => {
                format!("{} * {} + {}", self.scalar(of), literal(*factor), literal(*offset))
            }
            Scalar::Sum(a, b) => format!("{} + {}", self.scalar(a), self.scalar(b)),
            Scalar::Product(a, b) => format!("{} * {}", self.scalar(a), self.scalar(b)),
            Scalar::Mix(a, b, share) => {
                let (a, b, share) = (self.scalar(a), self.scalar(b), self.share(share));
                format!("{a} * (1.0 - {share}) + {b} * {share}")
            }
            Scalar::Levels { of, black, white } => {
                format!("brdf::mask::grey({}, {}, {})", self.scalar(of), literal(*black), literal(*white))
            }
            Scalar::Threshold { of, at, softness } => {
                format!("brdf::mask::soft_threshold({}, {}, {})", self.scalar(of), literal(*at), literal(*softness))
            }
            Scalar::Extent { of, extent, transition } => {
                let of = self.scalar(of);
                format!("brdf::patina::patina_extent({}, {}, {of})", literal(*extent), literal(*transition))
            }
        };
        self.named(&expression)
    }

    /// The expression of a number clamped to [0, 1].
    fn share(&mut self, scalar: &Scalar) -> String {
        let scalar = self.scalar(scalar);
        self.named(&format!("clamp({scalar}, 0.0, 1.0)"))
    }

    /// The expression of a colour at `point`.
    pub(super) fn colour(&mut self, colour: &Colour) -> String {
        let expression = match colour {
            Colour::Constant(colour) => return vector(*colour),
            Colour::Grey(grey) => format!("vec3f({})", self.scalar(grey)),
            Colour::Ramp(ramp, by) => {
                let (first, count, by) = (self.ramp(ramp), ramp.stops().len(), self.scalar(by));
                format!("brdf::ramp::ramp({first}u, {count}u, {by})")
            }
            Colour::Bands(ramp, softness, by) => {
                let (first, count, by) = (self.ramp(ramp), ramp.stops().len(), self.scalar(by));
                format!("brdf::ramp::bands({first}u, {count}u, {}, {by})", literal(*softness))
            }
            Colour::Image(lookup) => format!("{}.xyz", self.texel(lookup)),
            Colour::Scaled(colour, factor) => format!("{} * {}", self.colour(colour), self.scalar(factor)),
            Colour::Mix(a, b, share) => {
                let (a, b, share) = (self.colour(a), self.colour(b), self.share(share));
                format!("{a} * (1.0 - {share}) + {b} * {share}")
            }
            Colour::Film { absorption, scattering, thickness, ground } => {
                let (thickness, ground) = (self.scalar(thickness), self.colour(ground));
                let ground = self.named(&format!("clamp({ground}, vec3f(0.0), vec3f(1.0))"));
                let thickness = self.named(&format!("max({thickness}, 0.0)"));
                let channel = |c: usize, component: &str| {
                    let (absorption, scattering) = (literal(absorption[c]), literal(scattering[c]));
                    format!("brdf::kubelka_munk::film({absorption}, {scattering}, {thickness}, {ground}.{component})")
                };
                format!("vec3f({}, {}, {})", channel(0, "x"), channel(1, "y"), channel(2, "z"))
            }
        };
        self.named(&expression)
    }

    /// The expression of a texel.
    pub(super) fn texel(&mut self, lookup: &Lookup) -> String {
        // A material has at most `MOST_TEXELS` in all, which these indices hold.
        let texels = |image: &Image| image.width().saturating_mul(image.height());
        let first = self.images.iter().take(lookup.image).map(texels).fold(0, u32::saturating_add);
        let [u, v] = lookup.repeat.map(literal);
        let Some(image) = self.images.get(lookup.image) else { return "vec4f(0.0, 0.0, 0.0, 0.0)".to_string() };
        let (width, height, function) = (image.width(), image.height(), image.function());
        format!("brdf::image::{function}({first}u, {width}u, {height}u, point.uv * vec2f({u}, {v}))")
    }

    fn ramp(&mut self, ramp: &Ramp<3>) -> usize {
        let first = self.stops.len();
        self.stops.extend(ramp.stops().iter().map(|stop| {
            let [r, g, b] = stop.colour;
            [r, g, b, stop.at].map(f64::from)
        }));
        first
    }
}

/// Where the point lies among cells of which there are `frequency` in a unit of length.
fn in_cells(frequency: [f64; 3]) -> String {
    format!("point.position * {}", vector(frequency))
}

fn noise_call(name: &str, noise: &Noise) -> String {
    let place = in_cells(noise.frequency);
    let [amplitude, gain, lacunarity] = [noise.amplitude, noise.gain, noise.lacunarity].map(literal);
    let (seed, octaves) = (noise.seed, noise.octaves);
    format!("brdf::noise::{name}({place}, {seed}u, {amplitude}, 1.0, {octaves}u, {gain}, {lacunarity})")
}

fn property_of(property: Property) -> &'static str {
    match property {
        Property::X => "point.position.x",
        Property::Y => "point.position.y",
        Property::Z => "point.position.z",
        Property::U => "point.uv.x",
        Property::V => "point.uv.y",
        Property::Occlusion => "point.occlusion",
        Property::Distance => "point.distance",
    }
}
