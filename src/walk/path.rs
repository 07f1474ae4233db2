//! One walk: from the viewer down into the stack and back out, with a share of the light at each step.

use super::Technique;
use super::facets::Microsurface;
use super::interface::{Interface, Interfaces, Source, Way, absorbed};
use crate::frame::Vector;
use crate::real::Real;

/// A walk ends here whatever its weight. With roulette a walk that keeps 95 % at each step has a chance of 1e-80 to
/// arrive; only a walk that loses nothing at all does, and the shadowing of its facets alone ends that.
const LONGEST: u32 = 4096;
/// Roulette begins at this step, and spares weights above [`SPARED`].
const ROULETTE_FROM: u32 = 4;
const SPARED: f64 = 0.25;
/// The light that one interface alone reflects, f̂₀^R at the top, and what the media above it absorb.
pub(super) fn first_reflection<R: Real<Mask = bool>, const K: usize>(
    stack: &Interfaces<R, K>,
    facets: Microsurface,
    wi: Vector<R>,
    wo: Vector<R>,
) -> [R; K] {
    if wi.z.le(R::ZERO) || wo.z.le(R::ZERO) {
        return [R::ZERO; K];
    }
    let Some(top) = stack.all.first() else { return [R::ZERO; K] };
    let value = top.exact().kernel(facets, wo, wi, Way::Reflection).value;
    absorbed(absorbed(value, &stack.above, wi.z), &stack.above, wo.z)
}

/// One sample of the light that has passed the top interface: f in sr⁻¹, less [`first_reflection`].
///
/// A path ends with a reflection at some interface k and transmissions up through k−1, …, 0 to the light. It can be found
/// in k+1 ways: for each j ≤ k by sampling from the viewer as far as the arrival at interface j, from the light down
/// through the interfaces above j, and connecting there. With the densities p_L(m) and p_C(m) of its direction in medium
/// m, sampled from the light and from the viewer, p_j/p_(j−1) = p_L(j)/p_C(j): all that the power heuristic needs.
pub(super) fn transmitted<R: Real<Mask = bool>, const K: usize>(
    stack: &Interfaces<R, K>,
    facets: Microsurface,
    technique: Technique,
    wi: Vector<R>,
    wo: Vector<R>,
    source: Source,
) -> [R; K] {
    let mut sum = [R::ZERO; K];
    let interfaces = &stack.all;
    let last = interfaces.len().saturating_sub(1);
    if wi.z.le(R::ZERO) || wo.z.le(R::ZERO) || last == 0 {
        return sum;
    }
    let top = &interfaces[0];
    let Some(entry) = top.sample(facets, wo, Way::Transmission, source.draw(0, 0)) else { return sum };
    let outside = absorbed([R::ONE; K], &stack.above, wi.z);
    let mut weight = product(absorbed(entry.weight, &stack.above, wo.z), outside);
    let mut direction = entry.direction;
    // Medium j lies under interface j−1.
    let mut medium = 1;
    // p_C of the direction that the walk goes in, and 1 + Σ (p_i/p_j)² over the ways i that connect below where it left.
    let (mut density, mut tail) = (R::ZERO, R::ONE);
    for step in 1..LONGEST {
        weight = absorbed(weight, &interfaces[medium - 1].depth, direction.z);
        let upward = direction.z.gt(R::ZERO);
        let at = if upward { medium - 1 } else { medium };
        let a = -direction;
        let way = if at == 0 || at == last { Way::Reflection } else { Way::Both };
        let interface = &interfaces[at];

        let connects = match technique {
            Technique::Sampling => false,
            // Each path once: where its last reflection is.
            Technique::NextEvent => !upward,
            _ => true,
        };
        if at > 0
            && connects
            && let Some(light) = from_light(interfaces, facets, at, wi, source, step)
        {
            let towards = -light.direction;
            let kernel = interface.kernel(facets, a, towards, way);
            let mut rivals = squared_ratio(kernel.density, light.density) * light.tail;
            if upward {
                let known = interface.kernel(facets, towards, a, Way::Transmission).density;
                rivals = rivals + squared_ratio(known, density) * tail;
            }
            let share = if technique == Technique::NextEvent { R::ONE } else { R::ONE / (R::ONE + rivals) };
            add(&mut sum, product(product(weight, light.weight), kernel.value), share);
        }
        if at == 0 && technique != Technique::NextEvent {
            // Up through the top interface into the light: a, the inner direction, as the light would go.
            let exit = top.kernel(facets, wi, a, Way::Transmission);
            let known = match technique {
                Technique::OuterDensity => top.kernel(facets, a, wi, Way::Transmission).density,
                _ => exit.density,
            };
            let rivals = squared_ratio(known, density) * tail;
            let share = if technique == Technique::Sampling { R::ONE } else { R::ONE / (R::ONE + rivals) };
            add(&mut sum, product(weight, exit.value), share);
        }

        let Some(next) = interface.sample(facets, a, way, source.draw(step, 0)) else { return sum };
        weight = product(weight, next.weight);
        direction = next.direction;
        medium = if direction.z.lt(R::ZERO) { at + 1 } else { at };
        tail = if upward && direction.z.gt(R::ZERO) {
            let known = interface.kernel(facets, direction, a, Way::Transmission).density;
            extended(squared_ratio(known, density), tail)
        } else {
            R::ONE
        };
        density = next.density;

        if step >= ROULETTE_FROM {
            // The last number of the light's first draw is not used by a transmission.
            let [.., u] = source.draw::<R>(step, 1);
            if !spin(&mut weight, u) {
                return sum;
            }
        }
    }
    sum
}

/// A path from the light down to an interface.
struct FromLight<R, const K: usize> {
    /// The direction in which it arrives, downwards.
    direction: Vector<R>,
    weight: [R; K],
    /// p_L of that direction.
    density: R,
    /// 1 + Σ (p_i/p_(j−1))² over the ways i < j−1 that connect above the medium in which it arrives.
    tail: R,
}

/// Samples transmissions from the light through all interfaces above `at`.
#[inline]
fn from_light<R: Real<Mask = bool>, const K: usize>(
    interfaces: &[Interface<R, K>],
    facets: Microsurface,
    at: usize,
    wi: Vector<R>,
    source: Source,
    step: u32,
) -> Option<FromLight<R, K>> {
    let mut light = FromLight { direction: -wi, weight: [R::ONE; K], density: R::ZERO, tail: R::ONE };
    for (above, interface) in interfaces[..at].iter().enumerate() {
        let towards = -light.direction;
        let next = interface.sample(facets, towards, Way::Transmission, source.draw(step, above as u32 + 1))?;
        if next.density.le(R::ZERO) {
            return None;
        }
        if above > 0 {
            let sampled = interface.kernel(facets, next.direction, towards, Way::Both).density;
            light.tail = extended(squared_ratio(sampled, light.density), light.tail);
        }
        light.weight = absorbed(product(light.weight, next.weight), &interface.depth, next.direction.z);
        light.density = next.density;
        light.direction = next.direction;
    }
    Some(light)
}

/// One sample of the directional albedo: the weight with which a walk from `wo` leaves the stack. `entry` is what it may
/// do at the top: [`Way::Transmission`] leaves out what the top reflects.
pub(super) fn escaped<R: Real<Mask = bool>, const K: usize>(
    stack: &Interfaces<R, K>,
    facets: Microsurface,
    wo: Vector<R>,
    entry: Way,
    source: Source,
) -> [R; K] {
    let lost = [R::ZERO; K];
    let interfaces = &stack.all;
    if wo.z.le(R::ZERO) || interfaces.is_empty() {
        return lost;
    }
    let last = interfaces.len() - 1;
    let mut weight = absorbed([R::ONE; K], &stack.above, wo.z);
    let mut direction = -wo;
    let mut medium = 0;
    for step in 0..LONGEST {
        let at = if direction.z.lt(R::ZERO) { medium } else { medium - 1 };
        let way = match step {
            _ if at == last => Way::Reflection,
            0 => entry,
            _ => Way::Both,
        };
        let Some(next) = interfaces[at].sample(facets, -direction, way, source.draw(step, 0)) else { return lost };
        weight = product(weight, next.weight);
        direction = next.direction;
        medium = if direction.z.lt(R::ZERO) { at + 1 } else { at };
        if medium == 0 {
            return absorbed(weight, &stack.above, direction.z);
        }
        weight = absorbed(weight, &interfaces[medium - 1].depth, direction.z);
        if step >= ROULETTE_FROM {
            let [.., u] = source.draw::<R>(step, 1);
            if !spin(&mut weight, u) {
                return lost;
            }
        }
    }
    lost
}

/// One sample of the share of light from `wo` that reaches the last interface, whatever that is; 1 where it is the only one.
pub(super) fn arrived<R: Real<Mask = bool>, const K: usize>(
    stack: &Interfaces<R, K>,
    facets: Microsurface,
    wo: Vector<R>,
    source: Source,
) -> [R; K] {
    if wo.z.le(R::ZERO) || stack.all.is_empty() {
        return [R::ZERO; K];
    }
    descend(stack, facets, absorbed([R::ONE; K], &stack.above, wo.z), -wo, 0, source)
}

/// One sample of the share of Lambertian light from the last interface that the ones above send back to it.
pub(super) fn returned<R: Real<Mask = bool>, const K: usize>(
    stack: &Interfaces<R, K>,
    facets: Microsurface,
    source: Source,
) -> [R; K] {
    let last = stack.all.len().saturating_sub(1);
    if last == 0 {
        return [R::ZERO; K];
    }
    let [u, turn, ..] = source.draw::<R>(0, 0);
    let ((x, y), radius) = (turn.unit_circle(), u.sqrt());
    let up = Vector::new(radius * x, radius * y, (R::ONE - u).sqrt());
    descend(stack, facets, absorbed([R::ONE; K], &stack.all[last - 1].depth, up.z), up, last, source)
}

/// Follows a walk in `medium` until it reaches the last interface: the weight it arrives with, 0 where it leaves.
fn descend<R: Real<Mask = bool>, const K: usize>(
    stack: &Interfaces<R, K>,
    facets: Microsurface,
    mut weight: [R; K],
    mut direction: Vector<R>,
    mut medium: usize,
    source: Source,
) -> [R; K] {
    let lost = [R::ZERO; K];
    let interfaces = &stack.all;
    let last = interfaces.len() - 1;
    // Step 0 may have started the walk.
    for step in 1..LONGEST {
        let down = direction.z.lt(R::ZERO);
        if down && medium == last {
            return weight;
        }
        let at = if down { medium } else { medium - 1 };
        let random = source.draw(step, 0);
        // What the top reflects never arrives.
        let way = if medium == 0 { Way::Transmission } else { Way::Both };
        let Some(next) = interfaces[at].sample(facets, -direction, way, random) else { return lost };
        weight = product(weight, next.weight);
        direction = next.direction;
        medium = if direction.z.lt(R::ZERO) { at + 1 } else { at };
        if medium == 0 {
            return lost;
        }
        weight = absorbed(weight, &interfaces[medium - 1].depth, direction.z);
        if step > ROULETTE_FROM {
            let [.., u] = source.draw::<R>(step, 1);
            if !spin(&mut weight, u) {
                return lost;
            }
        }
    }
    lost
}

/// Russian roulette: the walk survives with q = min(1, max β/0.25), and is weighted by 1/q.
#[inline(always)]
fn spin<R: Real<Mask = bool>, const K: usize>(weight: &mut [R; K], u: R) -> bool {
    let most = weight.iter().fold(R::ZERO, |most, w| most.max(*w));
    let q = (most / R::from_f64(SPARED)).min(R::ONE);
    let survives = u.lt(q);
    if survives {
        *weight = weight.map(|w| w / q);
    }
    survives
}

/// The root of the largest number that a ratio of squared densities, or a sum of such, may be: 1e9 in f32, 1e75 in f64.
///
/// The product of two of them stays finite. The shares of one path sum to 1 as long as no ratio of densities exceeds this:
/// in f32, where widths are at least 1e-3 ([`Interface::new`]), down to |η−1| = .02 between two rough interfaces.
#[inline(always)]
fn largest_root<R: Real<Mask = bool>>() -> R {
    R::from_f64(if R::EPSILON.gt(R::from_f64(1e-10)) { 1e9 } else { 1e75 })
}

/// (p/q)², at most the square of [`largest_root`]; 0 where p is 0, so that a way that cannot find a path has no say.
#[inline(always)]
fn squared_ratio<R: Real<Mask = bool>>(p: R, q: R) -> R {
    let root = largest_root::<R>();
    if p.le(R::ZERO) {
        R::ZERO
    } else if (p / root).ge(q) {
        root * root
    } else {
        (p / q).squared()
    }
}

/// 1 + `ratio`·`tail`, at most the square of [`largest_root`].
#[inline(always)]
fn extended<R: Real<Mask = bool>>(ratio: R, tail: R) -> R {
    let root = largest_root::<R>();
    (R::ONE + ratio * tail).min(root * root)
}

#[inline(always)]
fn product<R: Real, const K: usize>(a: [R; K], b: [R; K]) -> [R; K] {
    core::array::from_fn(|c| a[c] * b[c])
}

#[inline(always)]
fn add<R: Real, const K: usize>(sum: &mut [R; K], term: [R; K], share: R) {
    for (sum, term) in sum.iter_mut().zip(term) {
        *sum = *sum + term * share;
    }
}
