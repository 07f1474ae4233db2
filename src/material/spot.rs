//! A material at one point: numbers only.

use super::brushed::{Brushed, Shape};
use super::field::Colour;
use super::finish::{Body, Boundary, BrushedMetal, Coat, Encoding, Flakes, Layers, Relief, STEEPEST};
use super::flake::flake_normal;
use super::glint;
pub use super::mirror::Mirror;
use super::mirror::{mirror_of, mirrors, scattered};
use super::parts::{Material, Part};
use super::patina::diffuse_as_printed;
use super::point::Point;
use crate::frame::{Frame, Vector, half_vector};
use crate::layered::model::{Plain, Surface, interface_fresnel, over};
use crate::layered::{ALPHA_RANGE, Interface, K_RANGE, Layer, Medium, Model, N_RANGE, Stack};
use crate::microfacet::{Facets, cos_half, facets};
use crate::real::{Mask, Real};
use crate::sampling::{Sample, View};
use crate::texture::bump;
use crate::texture::image::Image;
use core::ops::RangeInclusive;

mod seen;
use seen::Lobes;
pub use seen::Seen;

/// The most parts of a material.
pub const MOST_PARTS: usize = 4;

/// The most layers of a part.
pub const MOST_LAYERS: usize = 4;

/// A material at one point: what reflects there, and in which shares.
///
/// Directions are local to the surface's shading frame: the normal is +z, the tangent +x. Parts may have normals of their own.
#[derive(Clone, Debug)]
pub struct Spot<'a, R> {
    parts: [Option<Share<'a, R>>; MOST_PARTS],
}

/// What a part has of a spot.
#[derive(Clone, Debug)]
struct Share<'a, R> {
    /// Its share of the surface; the shares add up to 1.
    share: R,
    /// What is left of its reflection.
    reflectivity: [R; 3],
    /// The frame about its own normal, where it has one.
    relief: Option<Frame<R>>,
    body: SpotBody<'a, R>,
}

#[derive(Clone, Debug)]
enum SpotBody<'a, R> {
    Layers(Resolved<R>),
    Brushed { metal: Brushed<R, 3>, turn: (R, R) },
    Whole(&'a Stack<f64, 3>),
}

/// Layers at a point.
#[derive(Clone, Debug)]
struct Resolved<R> {
    model: Model,
    layers: [Layer<R, 3>; MOST_LAYERS],
    count: usize,
    grains: Option<Grains<R>>,
    /// σ of the documents' diffuse term, where there is one.
    scatter: Option<[R; 3]>,
}

/// The share of samples that is drawn from the cosine where the documents' diffuse term is.
const SCATTERED: f64 = 0.5;

impl<R: Real> Resolved<R> {
    fn layers(&self) -> &[Layer<R, 3>] {
        self.layers.get(..self.count).unwrap_or_default()
    }

    fn evaluate(&self, wi: Vector<R>, wo: Vector<R>) -> [R; 3] {
        let mut f = match &self.grains {
            None => over(self.model, self.layers(), &Plain, wi, wo),
            Some(grains) => over(self.model, self.layers(), grains, wi, wo),
        };
        let lit = wi.z.min(wo.z).gt(R::ZERO);
        if let (Some(sigma), Interface::Microfacet { n, k, .. }) = (&self.scatter, self.layers[0].interface) {
            let cos_h = cos_half(wi, wo);
            for c in 0..3 {
                let reflectance = interface_fresnel(cos_h, n[c], k[c]).reflectance;
                let scattered = diffuse_as_printed(sigma[c], reflectance, R::ONE) * R::FRAC_1_PI;
                f[c] = f[c] + R::select(lit, scattered, R::ZERO);
            }
        }
        f
    }

    #[inline(always)]
    fn facing(&self, wo: Vector<R>) -> Lobes<R> {
        let even = R::from_f64(if self.scatter.is_some() { SCATTERED } else { 0.0 });
        Lobes::Layers { view: View::new(self.layers(), self.model, wo), even }
    }
}

impl<'a, R: Real> Spot<'a, R> {
    #[inline(always)]
    pub(crate) fn new(material: &'a Material, point: &Point<R>) -> Self {
        let mut left = R::ONE;
        let mut parts = [const { None }; MOST_PARTS];
        let described = material.parts().iter().zip(material.returned()).enumerate();
        // From the top: what a part leaves open is for those before it.
        for ((index, (part, returned)), spot) in described.zip(&mut parts).rev() {
            let cover =
                if index == 0 { R::ONE } else { part.cover.at::<R>(point, material.images()).max(R::ZERO).min(R::ONE) };
            let share = left * cover;
            left = left * (R::ONE - cover);
            if share.gt(R::ZERO).any() {
                *spot = Some(Share::new(part, share, *returned, point, material.images()));
            }
        }
        Spot { parts }
    }

    fn shares(&self) -> impl Iterator<Item = &Share<'a, R>> {
        self.parts.iter().flatten()
    }

    /// The reflected radiance for each unit of irradiance perpendicular to `wi`: Σ share·f·cos in sr⁻¹, each part about its own normal.
    ///
    /// 0 where a direction is at or below the horizon of the surface; a part adds nothing where one is below its own.
    pub fn reflected(&self, wi: Vector<R>, wo: Vector<R>) -> [R; 3] {
        let mut sum = [R::ZERO; 3];
        if wi.z.min(wo.z).gt(R::ZERO).any() {
            for part in self.shares() {
                let f_cos = part.reflected(wi, wo);
                for (sum, f_cos) in sum.iter_mut().zip(f_cos) {
                    *sum = *sum + part.share * f_cos;
                }
            }
        }
        sum
    }

    /// The spot seen from a direction, prepared for any number of samples and densities. See [`Seen`].
    #[inline(always)]
    pub fn facing(&self, wo: Vector<R>) -> Seen<'_, 'a, R> {
        let mut lobes = [const { None }; MOST_PARTS];
        for (lobes, part) in lobes.iter_mut().zip(&self.parts) {
            *lobes = part.as_ref().and_then(|part| part.facing(wo));
        }
        Seen { spot: self, wo, lobes }
    }

    /// A direction `wi` for a view, drawn about in proportion to [`Spot::reflected`], and its density. See [`Seen::sample`].
    pub fn sample(&self, wo: Vector<R>, u: [R; 4]) -> Option<Sample<R>> {
        self.facing(wo).sample(u)
    }

    /// The density in sr⁻¹ with which [`Spot::sample`] draws `wi` for the view `wo`. 0 where either is at or below the horizon.
    pub fn pdf(&self, wi: Vector<R>, wo: Vector<R>) -> R {
        self.facing(wo).pdf(wi)
    }

    /// What of a blurred environment a view sees, without sampling it: a lobe for each interface, a cosine for a diffuse base.
    ///
    /// Each interface adds F·T²·a² of the environment in the mirror direction, less what its facets mask and the coats above reflect back down
    /// (fitted, within .06 of the albedo), blurred by its α times the index above it (what refraction widens a lobe by at the normal). A diffuse base adds ρ·T(V)·T̄·a/n² of the irradiance; T̄ is T at 60°, which is within
    /// 1 % of the mean transmittance for n from 1.2 to 2. Under [`Model::Coupled`] and [`Model::Walk`] ρ is what the base and its coats make of it
    /// between them, ρ/(1 − ρ·r_i). Under [`Model::Elek`] only the upper interface reflects the environment, as
    /// the documents have it (Elek 2010, Algorithm 1, lines 28–29). The documents' diffuse term ([`Layers::scatter`]) adds (1 − σ)·(1 − F) of the
    /// irradiance, F at √((1+V_z)/2), the half vector of the view and the normal: within 3 % of the mean over all light for n from 1.5 to 3.
    ///
    /// What this local model cannot do, and [`Spot::reflected`] does: a lobe is round, its width is that of a mean at the normal, and its weight F at
    /// the mirror direction. So the lobe of a brushed metal is blurred by √(α_x·α_y) all around and does not stretch across the grooves; rough lobes
    /// keep their place and width at grazing; flakes do not sparkle; an Oren–Nayar base counts as Lambert's; `weidlich_wilkie` keeps the
    /// books of [`Model::Conserving`]; and of the light that bounces between interfaces only that over a diffuse base is there.
    /// The lobe of a brushed metal keeps all of F, without what its facets mask.
    pub fn mirrored(&self, wo: Vector<R>, visit: &mut impl FnMut(Mirror<R>)) {
        for part in self.shares() {
            part.mirrored(wo, visit);
        }
    }
}

impl<'a, R: Real> Share<'a, R> {
    fn new(part: &'a Part, share: R, returned: f64, point: &Point<R>, images: &[Image]) -> Self {
        let finish = &part.finish;
        let relief = finish.relief.as_ref().map(|relief| {
            let tangent = Vector::new(R::ONE, R::ZERO, R::ZERO);
            Frame::from_normal_and_tangent(relief.normal(point, images), tangent)
        });
        let body = match &finish.body {
            Body::Layers(layers) => layered(layers, returned, point, images),
            Body::Brushed(metal) => brushed(metal, point, images),
            Body::Whole(stack) => SpotBody::Whole(stack),
        };
        Share { share, reflectivity: finish.reflectivity.at::<R>(point, images).map(saturated), relief, body }
    }

    fn to_own(&self, w: Vector<R>) -> Vector<R> {
        self.relief.map_or(w, |frame| frame.to_local(w))
    }

    fn to_surface(&self, w: Vector<R>) -> Vector<R> {
        self.relief.map_or(w, |frame| frame.to_world(w))
    }

    fn reflected(&self, wi: Vector<R>, wo: Vector<R>) -> [R; 3] {
        let (wi, wo) = (self.to_own(wi), self.to_own(wo));
        let f = match &self.body {
            SpotBody::Layers(layers) => layers.evaluate(wi, wo),
            SpotBody::Brushed { metal, turn } => metal.evaluate(turned(wi, *turn), turned(wo, *turn)),
            SpotBody::Whole(stack) => stack.evaluate(wi.cast(), wo.cast()).map(R::from_f64),
        };
        let cosine = wi.z.max(R::ZERO);
        core::array::from_fn(|c| f[c] * self.reflectivity[c] * cosine)
    }

    /// What it draws for a view; nothing for one from under its own horizon.
    #[inline(always)]
    fn facing(&self, wo: Vector<R>) -> Option<Lobes<R>> {
        let wo = self.to_own(wo);
        wo.z.gt(R::ZERO).any().then(|| match &self.body {
            SpotBody::Layers(layers) => layers.facing(wo),
            SpotBody::Brushed { metal, turn } => Lobes::Brushed { metal: *metal, turn: *turn, wo: turned(wo, *turn) },
            SpotBody::Whole(stack) => Lobes::Whole(stack.facing(wo.cast::<f64>())),
        })
    }

    fn mirrored(&self, wo: Vector<R>, visit: &mut impl FnMut(Mirror<R>)) {
        let wo = self.to_own(wo);
        let mut found = |mirror: Mirror<R>| {
            let weight = core::array::from_fn(|c| mirror.weight[c] * self.share * self.reflectivity[c]);
            visit(Mirror { direction: self.to_surface(mirror.direction), weight, ..mirror });
        };
        if !wo.z.gt(R::ZERO).any() {
            return;
        }
        match &self.body {
            SpotBody::Layers(layers) => {
                mirrors(layers.layers().iter().copied(), layers.model, [R::ZERO; 3], wo, &mut found);
                if let (Some(sigma), Interface::Microfacet { n, k, .. }) = (&layers.scatter, layers.layers[0].interface)
                {
                    found(scattered(*sigma, n, k, wo));
                }
            }
            SpotBody::Whole(stack) => {
                let again = match stack.model() {
                    Model::Coupled | Model::Walk => stack.bounced().map(R::from_f64),
                    _ => [R::ZERO; 3],
                };
                mirrors(stack.effective_layers().iter().map(Layer::cast), stack.model(), again, wo, &mut found);
            }
            SpotBody::Brushed { metal, .. } => {
                let weight = core::array::from_fn(|c| interface_fresnel(wo.z, metal.n[c], metal.k[c]).reflectance);
                let alpha = (metal.alpha_x * metal.alpha_y).sqrt();
                found(Mirror { direction: mirror_of(wo), alpha, diffuse: false, weight });
            }
        }
    }
}

fn clamped<R: Real>(x: R, range: &RangeInclusive<f64>) -> R {
    x.max(R::from_f64(*range.start())).min(R::from_f64(*range.end()))
}

fn saturated<R: Real>(x: R) -> R {
    x.saturate()
}

/// A direction in the axes along and across the grooves; `turn` is the cosine and sine of the angle of the grooves.
fn turned<R: Real>(w: Vector<R>, (cosine, sine): (R, R)) -> Vector<R> {
    Vector::new(cosine * w.x + sine * w.y, cosine * w.y - sine * w.x, w.z)
}

fn brushed<'a, R: Real>(metal: &BrushedMetal, point: &Point<R>, images: &[Image]) -> SpotBody<'a, R> {
    let index = |field: &Colour, range: &RangeInclusive<f64>| field.at::<R>(point, images).map(|x| clamped(x, range));
    let turn: R = metal.turn.at(point, images);
    SpotBody::Brushed {
        metal: Brushed {
            n: index(&metal.n, &N_RANGE),
            k: index(&metal.k, &K_RANGE),
            alpha_x: clamped(metal.along.at(point, images), &ALPHA_RANGE),
            alpha_y: clamped(metal.across.at(point, images), &ALPHA_RANGE),
            shape: Shape::Ggx,
        },
        turn: (turn - turn.floor()).unit_circle(),
    }
}

fn layered<'a, R: Real>(layers: &Layers, returned: f64, point: &Point<R>, images: &[Image]) -> SpotBody<'a, R> {
    let nothing = Layer::new(Interface::dielectric(R::ONE, R::ONE));
    let mut resolved = [nothing; MOST_LAYERS];
    for (layer, coat) in resolved.iter_mut().zip(&layers.coats) {
        *layer = coat.at(returned, point, images);
    }
    let count = layers.coats.len().min(MOST_LAYERS);
    if let Some(layers_used) = resolved.get_mut(..count) {
        layers.widths.widen(layers_used);
    }
    let flaked = layers.coats.iter().any(|coat| coat.flakes.is_some());
    let grains = flaked.then(|| Grains::new(&layers.coats, point, images));
    let scatter = layers.scatter.as_ref().map(|sigma| sigma.at::<R>(point, images).map(saturated));
    SpotBody::Layers(Resolved { model: layers.model, layers: resolved, count, grains, scatter })
}

impl Coat {
    fn at<R: Real>(&self, returned: f64, point: &Point<R>, images: &[Image]) -> Layer<R, 3> {
        let colour = |field: &Colour| field.at::<R>(point, images);
        let interface = match &self.boundary {
            Boundary::Microfacet { n, k, alpha } => Interface::Microfacet {
                n: colour(n).map(|x| clamped(x, &N_RANGE)),
                k: colour(k).map(|x| clamped(x, &K_RANGE)),
                alpha: clamped(alpha.at(point, images), &ALPHA_RANGE),
            },
            Boundary::Diffuse { albedo, sigma } => Interface::Diffuse {
                albedo: colour(albedo).map(|x| {
                    let albedo = saturated(x);
                    albedo / (R::ONE - albedo * R::from_f64(returned))
                }),
                sigma: clamped(sigma.at(point, images), &(0.0..=core::f64::consts::FRAC_PI_2)),
            },
        };
        let medium = Medium {
            sigma: colour(&self.sigma).map(|x| x.max(R::ZERO)),
            thickness: self.thickness.at::<R>(point, images).max(R::ZERO),
        };
        Layer { interface, medium }
    }
}

impl Relief {
    /// The unit normal at a point, local to the surface's frame. Green of a map is a slope towards growing v, which coordinates that are mirrored have
    /// against the bitangent.
    pub fn normal<R: Real>(&self, point: &Point<R>, images: &[Image]) -> Vector<R> {
        match self {
            Relief::Height { height, step } => {
                let step = R::from_f64(*step);
                let here: R = height.at(point, images);
                let steepest = R::from_f64(STEEPEST);
                let slope =
                    |moved: Point<R>| ((height.at::<R>(&moved, images) - here) / step).max(-steepest).min(steepest);
                bump::normal_from_slopes(slope(point.shifted(step, R::ZERO)), slope(point.shifted(R::ZERO, step)))
            }
            Relief::Map { normals, encoding, strength } => {
                let [r, g, b, a] = normals.texel::<R>(point, images);
                let normal = match encoding {
                    Encoding::Rgb => bump::decode_rgb([r, g, b]),
                    Encoding::AlphaGreen => bump::decode_two_channel(a, g),
                };
                let mirrored = point.uv_per_length[1].lt(R::ZERO);
                let normal = Vector::new(normal.x, R::select(mirrored, -normal.y, normal.y), normal.z);
                bump::scaled(normal, R::from_f64(*strength))
            }
        }
    }
}

/// What the facets of each layer are.
#[derive(Clone, Copy, Debug)]
struct Grains<R>([Grain<R>; MOST_LAYERS]);

#[derive(Clone, Copy, Debug)]
enum Grain<R> {
    Plain,
    Glints { flakes: glint::Flakes<R>, position: Vector<R>, footprint: R },
    Tilted(Frame<R>),
}

impl<R: Real> Grains<R> {
    fn new(coats: &[Coat], point: &Point<R>, images: &[Image]) -> Self {
        let mut grains = [Grain::Plain; MOST_LAYERS];
        for (grain, coat) in grains.iter_mut().zip(coats) {
            *grain = match &coat.flakes {
                None => Grain::Plain,
                Some(Flakes::Glints { spacing, resolution, seed }) => Grain::Glints {
                    flakes: glint::Flakes {
                        spacing: R::from_f64(*spacing),
                        count: R::ONE,
                        resolution: *resolution,
                        seed: *seed,
                    },
                    position: point.position,
                    footprint: point.footprint,
                },
                Some(Flakes::AsPrinted { normals }) => {
                    let [x, y, z, _] = normals.texel::<R>(point, images);
                    let up = Vector::new(R::ZERO, R::ZERO, R::ONE);
                    let normal = flake_normal(up, point.distance, Vector::new(x, y, z));
                    Grain::Tilted(Frame::from_normal_and_tangent(normal, Vector::new(R::ONE, R::ZERO, R::ZERO)))
                }
            };
        }
        Grains(grains)
    }
}

impl<R: Real> Surface<R> for Grains<R> {
    fn facets(
        &self,
        position: usize,
        wi: Vector<R::Wide>,
        wo: Vector<R::Wide>,
        alpha: R::Wide,
    ) -> (R::Wide, Facets<R::Wide>) {
        let facets = |wi, wo| facets::<R::Wide>(wi, wo, alpha);
        let found = match self.0.get(position) {
            None | Some(Grain::Plain) => facets(wi, wo),
            Some(Grain::Glints { flakes, position, footprint }) => {
                let plain = facets(wi, wo);
                let grain =
                    glint::factor(half_vector(wi, wo), alpha, &flakes.cast(), position.widen(), footprint.widen());
                Facets { lobe: plain.lobe * grain, d: plain.d * grain, ..plain }
            }
            Some(Grain::Tilted(frame)) => {
                let frame = Frame {
                    tangent: frame.tangent.widen(),
                    bitangent: frame.bitangent.widen(),
                    normal: frame.normal.widen(),
                };
                let (own_i, own_o) = (frame.to_local(wi), frame.to_local(wo));
                let tilted = facets(own_i, own_o);
                // The cosine of the light is the flake's, f is per cosine of the surface.
                let lit = wi.z.gt(R::Wide::ZERO);
                let factor = own_i.z.max(R::Wide::ZERO) / R::Wide::select(lit, wi.z, R::Wide::ONE);
                Facets { lobe: tilted.lobe * factor, ..tilted }
            }
        };
        (cos_half(wi, wo), found)
    }
}
