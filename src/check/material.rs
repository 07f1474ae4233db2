//! Materials under judgement: any point of their surface, any of the numbers that they take.

use super::family::{Family, Parameter, Scale};
use super::subject::{Pair, Subject};
use crate::frame::Vector;
use crate::material::built_in;
use crate::material::finish::{Body, Flakes};
use crate::material::{Finish, Material, Part, Point};
use crate::real::Real;
use core::f64::consts::{PI, TAU};
use std::sync::{Arc, OnceLock};

/// A material as a [`Family`]: its parameters are the point of the surface and, of a built-in material, its own numbers.
///
/// The surface is the unit sphere, `u` running around it and `v` from the lower pole to the upper one; `occlusion` is how hidden the
/// point is and `distance` how far the viewer. Where the material has flakes, `footprint` is the width of what a pixel covers, from
/// .05 and of twelve spacings: below, single flakes are mirrors that no cubature resolves. A material that is the same everywhere has none of them.
///
/// f is [`Spot::reflected`](crate::material::Spot::reflected) over the cosine of the light with the *surface's* normal. Reliefs are left
/// out: parts about normals of their own are no BRDFs of the surface, and each is judged about its own.
///
/// ```
/// use brdf::check::{Family, MaterialFamily};
///
/// let patina = MaterialFamily::built_in("patina").unwrap();
/// let names: Vec<_> = patina.parameters().iter().map(|parameter| &*parameter.name).collect();
/// assert!(names.starts_with(&["u", "v", "occlusion"]) && names.contains(&"extent"));
/// ```
pub struct MaterialFamily {
    name: String,
    parameters: Vec<Parameter>,
    /// How many of them are the point's.
    of_point: usize,
    source: Source,
    has_relief: bool,
    fault: OnceLock<String>,
}

enum Source {
    Fixed(Arc<Material>),
    /// The name of a built-in material.
    BuiltIn(&'static str),
}

impl MaterialFamily {
    /// The points of a material.
    pub fn new(name: impl Into<String>, material: &Material) -> Self {
        let parameters = of_point(material);
        MaterialFamily {
            name: name.into(),
            of_point: parameters.len(),
            parameters,
            has_relief: has_relief(material),
            source: Source::Fixed(Arc::new(flat(material))),
            fault: OnceLock::new(),
        }
    }

    /// The points of the built-in material of this name, and its numbers within their ranges.
    pub fn built_in(name: &str) -> Option<Self> {
        let mut named = built_in::by_name(name)?;
        let material = named.material().ok()?;
        let mut parameters = of_point(&material);
        let of_point = parameters.len();
        parameters.extend(named.parameters().into_iter().map(|number| Parameter {
            name: number.name.to_owned(),
            low: *number.range.start(),
            // As far as the narrowest footprint sees many flakes.
            high: if number.name == "spacing" { NARROWEST / SPACINGS } else { *number.range.end() },
            default: *number.value,
            scale: Scale::Linear,
        }));
        Some(MaterialFamily {
            name: named.name.to_owned(),
            of_point,
            parameters,
            has_relief: has_relief(&material),
            source: Source::BuiltIn(named.name),
            fault: OnceLock::new(),
        })
    }

    /// Why a member could not be made, if one could not: numbers that make no material. What was measured of it is NaN.
    pub fn error(&self) -> Option<&str> {
        self.fault.get().map(String::as_str)
    }

    /// f of pairs of directions on an adapter, three numbers a pair.
    ///
    /// # Errors
    /// Where the values make no material, where it has no twin, and what the adapter refuses.
    #[cfg(feature = "gpu")]
    pub fn evaluate_on(
        &self,
        gpu: &crate::gpu::Gpu,
        values: &[f64],
        pairs: &[(Vector<f32>, Vector<f32>)],
    ) -> Result<Vec<f32>, String> {
        let material = self.material(values).ok_or_else(|| self.error().unwrap_or_default().to_owned())?;
        let bytes = match material.images() {
            [] => None,
            images => Some(crate::gpu::texel_bytes(gpu, images).map_err(|error| error.to_string())?),
        };
        let storage: Vec<&[u8]> = bytes.iter().map(Vec::as_slice).collect();
        let twin = crate::wgsl::material(&material).map_err(|error| error.to_string())?;
        let source = crate::wgsl::link(&format!("{ENTRY}\n{twin}")).map_err(|error| error.to_string())?;
        let bindings = bytes.is_some().then_some(TEXELS);
        let kernel =
            crate::gpu::Kernel::new(gpu, &source, "judged_value", bindings).map_err(|error| error.to_string())?;
        let Point { position, tangent, bitangent, uv, uv_per_length, occlusion, distance, footprint } =
            self.point(values).cast::<f32>();
        let vector = |v: Vector<f32>| [v.x, v.y, v.z];
        let rows = pairs.iter().flat_map(|&(wi, wo)| {
            let directions = [position, tangent, bitangent, wi, wo].map(vector).concat();
            directions.into_iter().chain(uv).chain(uv_per_length).chain([occlusion, distance, footprint])
        });
        let reflected = kernel.run_f32(&rows.collect::<Vec<_>>(), &storage).map_err(|error| error.to_string())?;
        let cosines = pairs.iter().flat_map(|(wi, _)| [if wi.z > 0.0 { wi.z } else { 1.0 }; 3]);
        Ok(reflected.into_iter().zip(cosines).map(|(reflected, cosine)| reflected / cosine).collect())
    }

    /// The point of these values.
    fn point(&self, values: &[f64]) -> Point<f64> {
        let value = |name: &str, otherwise: f64| {
            let index = self.parameters[..self.of_point].iter().position(|parameter| parameter.name == name);
            index.and_then(|index| values.get(index)).copied().unwrap_or(otherwise)
        };
        Point {
            occlusion: value("occlusion", 0.0),
            distance: value("distance", DISTANCE),
            footprint: value("footprint", FOOTPRINT),
            ..point(value("u", 0.0), value("v", 0.5))
        }
    }

    /// The material of these values, its reliefs left out.
    fn material(&self, values: &[f64]) -> Option<Arc<Material>> {
        match &self.source {
            Source::Fixed(material) => Some(Arc::clone(material)),
            Source::BuiltIn(name) => {
                let numbers = self.parameters.iter().zip(values).skip(self.of_point);
                let changes: Vec<_> = numbers.map(|(parameter, value)| (parameter.name.clone(), *value)).collect();
                let made = built_in::with(name, &changes);
                // The first fault is the one that is told.
                made.map(|material| Arc::new(flat(&material))).map_err(|error| self.fault.set(error.to_string())).ok()
            }
        }
    }
}

impl Family for MaterialFamily {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn subject(&self, values: &[f64]) -> Box<dyn Subject + '_> {
        let point = self.point(values);
        let material = self.material(values).filter(|material| {
            let beyond = beyond(&point, material);
            beyond.map(|fault| self.fault.set(format!("{}: {fault}", self.name))).is_none()
        });
        Box::new(MaterialSubject { family: self, material, point })
    }
}

/// A material at a point.
struct MaterialSubject<'a> {
    family: &'a MaterialFamily,
    material: Option<Arc<Material>>,
    point: Point<f64>,
}

/// f of f·cos.
fn over_cosine<R: Real>(reflected: [R; 3], wi: Vector<R>) -> [R; 3] {
    let cosine = R::select(wi.z.gt(R::ZERO), wi.z, R::ONE);
    reflected.map(|reflected| reflected / cosine)
}

impl Subject for MaterialSubject<'_> {
    fn name(&self) -> String {
        self.family.name.clone()
    }

    fn channels(&self) -> usize {
        3
    }

    fn evaluate(&self, wi: Vector<f64>, wo: Vector<f64>, f: &mut [f64]) {
        self.evaluate_many(&[(wi, wo)], f);
    }

    fn evaluate_many(&self, pairs: &[Pair], f: &mut [f64]) {
        let Some(material) = &self.material else { return f.fill(f64::NAN) };
        let spot = material.at(&self.point);
        for (&(wi, wo), f) in pairs.iter().zip(f.chunks_exact_mut(3)) {
            f.copy_from_slice(&over_cosine(spot.reflected(wi, wo), wi));
        }
    }

    fn evaluate_single(&self, wi: Vector<f32>, wo: Vector<f32>, f: &mut [f32]) -> bool {
        self.evaluate_single_many(&[(wi, wo)], f)
    }

    fn evaluate_single_many(&self, pairs: &[(Vector<f32>, Vector<f32>)], f: &mut [f32]) -> bool {
        let Some(material) = &self.material else { return false };
        let point = self.point.cast::<f32>();
        let spot = material.at(&point);
        for (&(wi, wo), f) in pairs.iter().zip(f.chunks_exact_mut(3)) {
            f.copy_from_slice(&over_cosine(spot.reflected(wi, wo), wi));
        }
        true
    }

    fn notes(&self) -> Vec<String> {
        let relief = "judged without its relief: parts about normals of their own are no BRDF of the surface";
        if self.family.has_relief { vec![relief.to_owned()] } else { Vec::new() }
    }
}

/// The texels of all images, as a shader has them.
#[cfg(feature = "gpu")]
const TEXELS: &str = "
@group(0) @binding(3) var<storage, read> material_texels: array<vec4f>;
fn material_texel(index: u32) -> vec4f { return material_texels[index]; }
";

/// f·cos of a row of numbers.
#[cfg(feature = "gpu")]
const ENTRY: &str = "
fn judged_value(
    position: vec3f, tangent: vec3f, bitangent: vec3f, wi: vec3f, wo: vec3f, uv: vec2f, uv_per_length: vec2f, occlusion: f32,
    distance: f32, footprint: f32,
) -> vec3f {
    material_prepare(Point(position, occlusion, tangent, distance, bitangent, footprint, uv, uv_per_length));
    return material_reflected(wi, wo);
}
";

fn has_relief(material: &Material) -> bool {
    material.parts().iter().any(|part| part.finish.relief.is_some())
}

/// The material without reliefs.
fn flat(material: &Material) -> Material {
    let part = |part: &Part| Part { finish: Finish { relief: None, ..part.finish.clone() }, ..part.clone() };
    // The same parts with less in them: there is nothing to refuse.
    Material::new(material.parts().iter().map(part).collect(), material.images().to_vec())
        .unwrap_or_else(|_| material.clone())
}

/// The viewer's distance from a sphere that fills nine tenths of `brdf render`'s picture.
const DISTANCE: f64 = 5.0;
/// As many flakes as are seen together when the sphere fills a few pixels.
const FOOTPRINT: f64 = 0.5;
/// The narrowest footprint that is judged, and how many spacings of flakes it holds: 144 flakes and more, whose glints merge into lobes that
/// the cubature follows.
const NARROWEST: f64 = 0.05;
const SPACINGS: f64 = 12.0;

/// The parameters of the point that a material may depend on.
fn of_point(material: &Material) -> Vec<Parameter> {
    if material.is_constant() {
        return Vec::new();
    }
    let share =
        |name: &str, default| Parameter { name: name.to_owned(), low: 0.0, high: 1.0, default, scale: Scale::Linear };
    let magnitude = |name: &str, low, high, default| Parameter {
        name: name.to_owned(),
        low,
        high,
        default,
        scale: Scale::Logarithmic,
    };
    let mut parameters = vec![share("u", 0.0), share("v", 0.5), share("occlusion", 0.0)];
    parameters.push(magnitude("distance", 0.5, 50.0, DISTANCE));
    if material.parts().iter().any(|part| part.finish.has_flakes()) {
        let spacing = material.parts().iter().filter_map(|part| spacing(&part.finish)).fold(0.0, f64::max);
        let least = NARROWEST.max(SPACINGS * spacing);
        parameters.push(magnitude("footprint", least, 40.0 * least, FOOTPRINT.max(least)));
    }
    parameters
}

/// What is wrong with a point, if it is none of the surface or is seen too closely.
fn beyond(point: &Point<f64>, material: &Material) -> Option<String> {
    let shares = [("u", point.uv[0]), ("v", point.uv[1]), ("occlusion", point.occlusion)];
    if let Some((name, value)) = shares.iter().find(|(_, value)| !(0.0..=1.0).contains(value)) {
        return Some(format!("{name} is {value:?}, allowed is 0 to 1"));
    }
    let lengths = [("distance", point.distance), ("footprint", point.footprint)];
    if let Some((name, value)) = lengths.iter().find(|(_, value)| !(1e-6..=1e6).contains(value)) {
        return Some(format!("{name} is {value:?}, allowed is 1e-6 to 1e6"));
    }
    let spacing = material.parts().iter().filter_map(|part| spacing(&part.finish)).fold(0.0, f64::max);
    (point.footprint < SPACINGS * spacing).then(|| {
        let footprint = point.footprint;
        format!(
            "a footprint of {footprint} sees single flakes of spacing {spacing}, mirrors that no integral resolves: it is judged \
             from {} on",
            SPACINGS * spacing
        )
    })
}

/// The largest spacing of the flakes of a finish.
fn spacing(finish: &Finish) -> Option<f64> {
    let Body::Layers(layers) = &finish.body else { return None };
    let each = layers.coats.iter().filter_map(|coat| match coat.flakes {
        Some(Flakes::Glints { spacing, .. }) => Some(spacing),
        _ => None,
    });
    each.reduce(f64::max)
}

/// A point of the unit sphere.
fn point(u: f64, v: f64) -> Point<f64> {
    // The frame stands a little off the poles, where u means nothing; the coordinates are those asked for.
    let (theta, phi) = (PI * (1.0 - v).clamp(1e-3, 1.0 - 1e-3), TAU * u);
    let position = Vector::<f64>::from_angles(theta, phi);
    let tangent = Vector::new(-phi.sin(), phi.cos(), 0.0);
    Point {
        position,
        tangent,
        bitangent: position.cross(tangent),
        uv: [u, v],
        uv_per_length: [1.0 / (TAU * theta.sin()), 1.0 / PI],
        ..Point::default()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Check, Options, Verdict, check_family};
    use super::*;
    use crate::layered::{Interface, Layer, Model, Stack};
    use crate::material::Scalar;
    use crate::material::field::Property;
    use crate::material::finish::Body;

    #[test]
    fn a_stack_is_the_same_everywhere() {
        let stack = Stack::new(Model::Conserving, vec![Layer::new(Interface::diffuse([0.2, 0.5, 0.9], 0.0))]).unwrap();
        let family = MaterialFamily::new("white", &stack.into());
        assert!(family.parameters().is_empty());
        let mut f = [0.0; 3];
        family.subject(&[]).evaluate(Vector::new(0.6, 0.0, 0.8), Vector::new(0.0, 0.0, 1.0), &mut f);
        assert!(f.iter().zip([0.2, 0.5, 0.9]).all(|(f, albedo)| (f - albedo / PI).abs() < 1e-15), "{f:?}");
    }

    #[test]
    fn points_lie_on_the_sphere_as_the_renderer_has_them() {
        for (u, v) in [(0.0, 0.5), (0.25, 0.5), (0.3, 0.9), (0.0, 0.0), (1.0, 1.0)] {
            let point = point(u, v);
            assert!((point.position.length_squared() - 1.0).abs() < 1e-14);
            let normal = point.tangent.cross(point.bitangent);
            assert!((normal - point.position).length_squared() < 1e-28, "the frame is right-handed about the normal");
            assert!(point.uv_per_length.iter().all(|rate| rate.is_finite()));
        }
        assert!(point(0.0, 0.9).position.z > 0.9);
    }

    /// A stack that gains energy, on a cap of the sphere alone.
    #[test]
    fn a_bad_spot_is_found() {
        let stack = |model, layers| Stack::<f64, 3>::new(model, layers).expect("valid");
        let plain = |stack| Finish::new(Body::Whole(Box::new(stack)));
        let report = |model| {
            let cuprite = Interface::conductor([2.83, 3.10, 3.06], [0.083, 0.19, 0.6], 0.1);
            let copper = Interface::conductor([0.213, 1.04, 1.17], [4.05, 2.59, 2.36], 0.3);
            let coated = stack(model, vec![Layer::new(cuprite), Layer::new(copper)]);
            let ground = stack(Model::Conserving, vec![Layer::new(Interface::diffuse([0.5; 3], 0.0))]);
            let cap = Scalar::Threshold { of: Box::new(Scalar::Of(Property::V)), at: 0.8, softness: 0.01 };
            let parts = vec![
                Part { cover: Scalar::Constant(1.0), finish: plain(ground) },
                Part { cover: cap, finish: plain(coated) },
            ];
            let family = MaterialFamily::new("capped", &Material::new(parts, Vec::new()).expect("valid"));
            check_family(&family, &Options { budget: 200_000, ..Options::default() })
        };
        let fine = report(Model::Conserving);
        assert_eq!(fine.verdict(), Verdict::Pass, "{fine}");
        let gains = report(Model::Elek);
        assert_eq!(gains.verdict(), Verdict::Fail, "{gains}");
        let energy = gains.finding(Check::Energy).expect("judged");
        let v = energy.parameters.iter().find(|(name, _)| name == "v").expect("a parameter").1;
        assert!(v > 0.78, "the gain lies above v = .8: {gains}");
    }

    /// The numbers of a built-in material are searched with the point, and only within what it takes.
    #[test]
    fn numbers_reach_the_material() {
        let family = MaterialFamily::built_in("patina").expect("built in");
        let f = |changes: &[(&str, f64)]| {
            let value = |parameter: &Parameter| {
                let change = changes.iter().find(|(name, _)| *name == parameter.name);
                change.map_or(parameter.default, |(_, value)| *value)
            };
            let mut f = [0.0; 3];
            let values: Vec<f64> = family.parameters().iter().map(value).collect();
            family.subject(&values).evaluate(Vector::new(0.6, 0.0, 0.8), Vector::new(0.0, 0.0, 1.0), &mut f);
            f
        };
        assert_ne!(f(&[("extent", 0.0)]), f(&[("extent", 1.0)]));
        assert!(f(&[("extent", 7.0)]).iter().all(|f| f.is_nan()), "it is no number of patina");
        assert!(family.error().is_some_and(|error| error.contains("extent of patina is 7")), "{:?}", family.error());
    }
}
