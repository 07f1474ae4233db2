//! The interfaces of a stack as a walk meets them: prepared once, evaluated and sampled from either side.

use super::facets::{self, Microsurface};
use super::random::random;
use crate::diffuse;
use crate::frame::Vector;
use crate::fresnel::{self, Fresnel};
use crate::layered;
use crate::real::Real;
use crate::refraction;

/// One interface and the medium under it, over `K` channels that share their directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interface<R, const K: usize> {
    kind: Kind<R, K>,
    /// The real indices of the media above and below.
    n_above: R,
    pub(super) n_below: R,
    /// σ·d of the medium below.
    pub(super) depth: [R; K],
}

#[derive(Clone, Copy, Debug)]
enum Kind<R, const K: usize> {
    /// Relative indices n + iκ, the width that walks take, and the width as given.
    Microfacet {
        n: [R; K],
        k: [R; K],
        alpha: R,
        exact_alpha: R,
    },
    Diffuse {
        albedo: [R; K],
        sigma: R,
    },
}

/// Which ways out of an interface a walk samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    Both,
    Reflection,
    Transmission,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step<R, const K: usize> {
    /// Away from the interface.
    pub(super) direction: Vector<R>,
    /// What the walk's weight is multiplied with.
    pub(super) weight: [R; K],
    /// The density of the direction, with the choice of the way out.
    pub(super) density: R,
}

/// The kernel of a pair of directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kernel<R, const K: usize> {
    /// f̂ per étendue.
    pub(super) value: [R; K],
    /// The density with which the second direction is sampled from the first.
    pub(super) density: R,
}

impl<R: Real, const K: usize> Kernel<R, K> {
    const NONE: Self = Kernel { value: [R::ZERO; K], density: R::ZERO };
}

/// `w` with its z mirrored where the walk is below an interface.
#[inline(always)]
fn seen_from<R: Real>(below: bool, w: Vector<R>) -> Vector<R> {
    if below { Vector::new(w.x, w.y, -w.z) } else { w }
}

impl<R: Real<Mask = bool>, const K: usize> Interface<R, K> {
    /// The interface under a medium of index `n_above`, for the channels from `first` on.
    fn new<const C: usize>(layer: &layered::Layer<R, C>, first: usize, n_above: R) -> Self {
        let pick = |values: &[R; C]| core::array::from_fn(|channel| values[first + channel]);
        let medium = &layer.medium;
        let depth = pick(&medium.sigma).map(|sigma| sigma * medium.thickness);
        match &layer.interface {
            layered::Interface::Microfacet { n, k, alpha } => {
                let mut n_below = n[first];
                // Equal indices over κ > 0 would leave the transmitting normal undefined.
                if matched(n_below, n_above) {
                    n_below = n_above * (R::ONE + R::TWO * R::EPSILON.sqrt());
                }
                let (n, k) = (pick(n).map(|n| n / n_above), pick(k).map(|k| k / n_above));
                let (alpha, exact_alpha) = (alpha.max(least_alpha()), *alpha);
                Interface { kind: Kind::Microfacet { n, k, alpha, exact_alpha }, n_above, n_below, depth }
            }
            layered::Interface::Diffuse { albedo, sigma } => {
                let kind = Kind::Diffuse { albedo: pick(albedo), sigma: *sigma };
                Interface { kind, n_above, n_below: n_above, depth }
            }
        }
    }

    /// The indices on the near and the far side.
    #[inline(always)]
    fn indices(&self, below: bool) -> (R, R) {
        if below { (self.n_below, self.n_above) } else { (self.n_above, self.n_below) }
    }

    /// The Fresnel terms of each channel for a facet met at this cosine. From below they are those of the refracted ray,
    /// since T₂₁ = T₁₂ along it; at and past the critical angle its cosine is 0 and F is 1.
    #[inline]
    fn fresnel(&self, n: &[R; K], k: &[R; K], cos_a: R, below: bool) -> [Fresnel<R>; K] {
        let cos_i = if below { refraction::cos_t(cos_a, self.n_above / self.n_below) } else { cos_a };
        core::array::from_fn(|c| {
            if k[c] == R::ZERO { fresnel::dielectric(cos_i, n[c]) } else { fresnel::conductor(cos_i, n[c], k[c]) }
        })
    }

    /// The interface with its width as given, for the reflection that no walk samples.
    pub(super) fn exact(&self) -> Self {
        let mut exact = *self;
        if let Kind::Microfacet { alpha, exact_alpha, .. } = &mut exact.kind {
            *alpha = *exact_alpha;
        }
        exact
    }

    /// The kernel f̂ of the directions `a` and `b`, both away from the interface, and the density of `b` given `a`.
    #[inline]
    pub(super) fn kernel(&self, facets: Microsurface, a: Vector<R>, b: Vector<R>, way: Way) -> Kernel<R, K> {
        let below = a.z.lt(R::ZERO);
        let (a, b) = (seen_from(below, a), seen_from(below, b));
        let (n_a, n_b) = self.indices(below);
        let reflects = b.z.gt(R::ZERO);
        match &self.kind {
            Kind::Diffuse { albedo, sigma } => {
                if below || !reflects {
                    return Kernel::NONE;
                }
                let base = diffuse::oren_nayar(a, b, *sigma);
                let scale = R::ONE / (n_a * n_a);
                Kernel { value: albedo.map(|albedo| base.f(albedo) * scale), density: b.z * R::FRAC_1_PI }
            }
            Kind::Microfacet { n, k, alpha, .. } if reflects => {
                let pair = facets.reflection(a, b, *alpha);
                let split = self.fresnel(n, k, pair.cos_a, below);
                let scale = pair.lobe / (n_a * n_a);
                let choice = match way {
                    Way::Both => reflection_chance(&split),
                    Way::Reflection => R::ONE,
                    Way::Transmission => R::ZERO,
                };
                Kernel { value: split.map(|split| split.reflectance * scale), density: choice * pair.density }
            }
            Kind::Microfacet { n, k, alpha, .. } => {
                let pair = facets.transmission(a, b, n_a, n_b, *alpha);
                if pair.density.le(R::ZERO) {
                    return Kernel::NONE;
                }
                let split = self.fresnel(n, k, pair.cos_a, below);
                let choice = match way {
                    Way::Both => R::ONE - reflection_chance(&split),
                    Way::Reflection => R::ZERO,
                    Way::Transmission => R::ONE,
                };
                Kernel { value: split.map(|split| split.transmittance * pair.lobe), density: choice * pair.density }
            }
        }
    }

    /// Samples a direction from `a`; none where the walk ends here.
    #[inline]
    pub(super) fn sample(&self, facets: Microsurface, a: Vector<R>, way: Way, u: [R; 4]) -> Option<Step<R, K>> {
        let below = a.z.lt(R::ZERO);
        let a = seen_from(below, a);
        if a.z.le(R::ZERO) {
            return None;
        }
        let step = match &self.kind {
            Kind::Diffuse { albedo, sigma } => {
                let [x, y] = facets::circle(u[1]);
                let radius = u[0].sqrt();
                let b = Vector::new(radius * x, radius * y, (R::ONE - u[0]).sqrt());
                let base = diffuse::oren_nayar(a, b, *sigma);
                let weight = albedo.map(|albedo| R::PI * base.f(albedo));
                Step { direction: b, weight, density: b.z * R::FRAC_1_PI }
            }
            Kind::Microfacet { n, k, alpha, .. } => {
                let m = facets.normal(a, *alpha, [u[0], u[1], u[2]]);
                let cos_a = a.dot(m);
                if cos_a.le(R::ZERO) {
                    return None;
                }
                let split = self.fresnel(n, k, cos_a, below);
                let chance = reflection_chance(&split);
                let (reflects, choice) = match way {
                    Way::Both if u[3].lt(chance) => (true, chance),
                    Way::Both => (false, R::ONE - chance),
                    Way::Reflection => (true, R::ONE),
                    Way::Transmission => (false, R::ONE),
                };
                let (n_a, n_b) = self.indices(below);
                let b = if reflects {
                    facets::reflected(a, m)
                } else {
                    let (b, cos_b) = facets::refracted(a, m, n_b / n_a);
                    if cos_b.le(R::ZERO) {
                        return None;
                    }
                    b
                };
                if b.z.gt(R::ZERO) != reflects {
                    return None;
                }
                let scale = facets.shadowing(a, b, m, *alpha) / choice;
                let weight = split.map(|s| scale * if reflects { s.reflectance } else { s.transmittance });
                let density = if reflects {
                    facets.reflection(a, b, *alpha).density
                } else {
                    facets.transmission(a, b, n_a, n_b, *alpha).density
                };
                Step { direction: b, weight, density: choice * density }
            }
        };
        let any = step.weight.iter().any(|weight| weight.gt(R::ZERO));
        any.then(|| Step { direction: seen_from(below, step.direction), ..step })
    }
}

/// The smallest width that a walk takes: 0 in f64, 1e-3 in f32.
///
/// The normal of a refraction n_a·a + n_b·b, of length about |n_b−n_a|, carries a rounding error of about 2ε: at
/// |n_b−n_a| = .5 in f32 5e-7 of a slope, half a thousandth of this width.
fn least_alpha<R: Real<Mask = bool>>() -> R {
    if R::EPSILON.gt(R::from_f64(1e-10)) { R::from_f64(1e-3) } else { R::ZERO }
}

/// The chance with which a walk takes the reflection: the mean reflectance of its channels.
#[inline(always)]
fn reflection_chance<R: Real, const K: usize>(split: &[Fresnel<R>; K]) -> R {
    let sum = split.iter().fold(R::ZERO, |sum, split| sum + split.reflectance);
    sum / R::from_f64(K as f64)
}

/// Whether two indices differ too little to reflect as much as a rounding error: F < ε/4 for |η−1| < √ε.
#[inline(always)]
fn matched<R: Real<Mask = bool>>(n: R, n_above: R) -> bool {
    (n / n_above - R::ONE).abs().lt(R::EPSILON.sqrt())
}

/// The interfaces of a stack for `K` channels from one on that share their directions, without those between equal media.
#[derive(Clone, Debug)]
pub(super) struct Interfaces<R, const K: usize> {
    pub(super) all: Vec<Interface<R, K>>,
    /// σ·d of the media of index 1 above the first interface.
    pub(super) above: [R; K],
}

impl<R: Real<Mask = bool>, const K: usize> Interfaces<R, K> {
    pub(super) fn new<const C: usize>(layers: &[layered::Layer<R, C>], first: usize) -> Self {
        let mut above = [R::ZERO; K];
        let mut all: Vec<Interface<R, K>> = Vec::with_capacity(layers.len());
        for (position, layer) in layers.iter().enumerate() {
            let n_above = all.last().map_or(R::ONE, |interface| interface.n_below);
            let last = position + 1 == layers.len();
            let absent = match &layer.interface {
                layered::Interface::Microfacet { n, k, .. } => {
                    matched(n[first], n_above) && k[first..first + K].iter().all(|k| *k == R::ZERO)
                }
                layered::Interface::Diffuse { .. } => false,
            };
            let interface = Interface::new(layer, first, n_above);
            if absent && !last {
                let depth = all.last_mut().map_or(&mut above, |interface| &mut interface.depth);
                for (sum, depth) in depth.iter_mut().zip(interface.depth) {
                    *sum = *sum + depth;
                }
            } else {
                all.push(interface);
            }
        }
        Interfaces { all, above }
    }
}

/// exp(−τ/|cos|) of each channel, times a weight.
#[inline]
pub(super) fn absorbed<R: Real<Mask = bool>, const K: usize>(weight: [R; K], depth: &[R; K], cos: R) -> [R; K] {
    let cos = cos.abs();
    core::array::from_fn(|c| {
        if depth[c].le(R::ZERO) {
            weight[c]
        } else if cos.le(R::ZERO) {
            R::ZERO
        } else {
            weight[c] * depth[c].exp_product(R::ONE / cos)
        }
    })
}

/// The random numbers of one walk.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source {
    pub(super) seed: u32,
    pub(super) index: u32,
}

impl Source {
    #[inline(always)]
    pub(super) fn draw<R: Real>(self, dimension: u32) -> [R; 4] {
        random(self.seed, self.index, dimension)
    }
}
