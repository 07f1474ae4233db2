//! One walk: from the viewer down into the stack and back out, with a share of the light at each step.

use super::Technique;
use super::facets::{Microsurface, circle};
use super::interface::{Interfaces, Source, Way, absorbed};
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
    let Some(entry) = top.sample(facets, wo, Way::Transmission, source.draw(0)) else { return sum };
    let outside = absorbed([R::ONE; K], &stack.above, wi.z);
    let mut weight = product(absorbed(entry.weight, &stack.above, wo.z), outside);
    let mut direction = entry.direction;
    // Medium j lies under interface j−1.
    let mut medium = 1;
    for step in 1..LONGEST {
        weight = absorbed(weight, &interfaces[medium - 1].depth, direction.z);
        let at = if direction.z.lt(R::ZERO) { medium } else { medium - 1 };
        let a = -direction;
        let way = if at == 0 || at == last { Way::Reflection } else { Way::Both };
        let interface = &interfaces[at];

        // Next event: a direction u that the light refracts into, connected through this interface.
        if at == 1 && technique != Technique::Sampling {
            let light = top.sample(facets, wi, Way::Transmission, source.draw(2 * step));
            if let Some(light) = light {
                let towards = -light.direction;
                let kernel = interface.kernel(facets, a, towards, way);
                let rival = match technique {
                    Technique::NextEvent => R::ZERO,
                    _ => kernel.density,
                };
                let share = power_share(light.density, rival);
                let arriving = absorbed(product(weight, light.weight), &interfaces[0].depth, light.direction.z);
                add(&mut sum, product(arriving, kernel.value), share);
            }
        }

        let Some(next) = interface.sample(facets, a, way, source.draw(2 * step + 1)) else { return sum };
        weight = product(weight, next.weight);
        direction = next.direction;
        medium = if direction.z.lt(R::ZERO) { at + 1 } else { at };

        // The same paths, found by sampling: up through the top interface into the light.
        if at == 1 && direction.z.gt(R::ZERO) && technique != Technique::NextEvent {
            let inner = -direction;
            let exit = top.kernel(facets, wi, inner, Way::Transmission);
            let rival = match technique {
                Technique::Sampling => R::ZERO,
                Technique::OuterDensity => top.kernel(facets, inner, wi, Way::Transmission).density,
                _ => exit.density,
            };
            let share = power_share(next.density, rival);
            let leaving = absorbed(weight, &interfaces[0].depth, direction.z);
            add(&mut sum, product(leaving, exit.value), share);
        }

        if step >= ROULETTE_FROM {
            // The last number of the light's draw is not used by a transmission.
            let [.., u] = source.draw::<R>(2 * step);
            let survives = spin(&mut weight, u);
            if !survives {
                return sum;
            }
        }
    }
    sum
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
        let Some(next) = interfaces[at].sample(facets, -direction, way, source.draw(2 * step + 1)) else { return lost };
        weight = product(weight, next.weight);
        direction = next.direction;
        medium = if direction.z.lt(R::ZERO) { at + 1 } else { at };
        if medium == 0 {
            return absorbed(weight, &stack.above, direction.z);
        }
        weight = absorbed(weight, &interfaces[medium - 1].depth, direction.z);
        if step >= ROULETTE_FROM {
            let [.., u] = source.draw::<R>(2 * step);
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
    let [u, turn, ..] = source.draw::<R>(0);
    let ([x, y], radius) = (circle(turn), u.sqrt());
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
    for step in 0..LONGEST {
        let down = direction.z.lt(R::ZERO);
        if down && medium == last {
            return weight;
        }
        let at = if down { medium } else { medium - 1 };
        let random = source.draw(2 * step + 1);
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
        if step >= ROULETTE_FROM {
            let [.., u] = source.draw::<R>(2 * step + 2);
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

/// The power heuristic's weight of the technique with density `own` against `rival`; 1 where only `own` is known.
///
/// As a ratio, so that no square overflows. Source: Veach 1997, eq. 9.13 with β = 2.
#[inline(always)]
fn power_share<R: Real<Mask = bool>>(own: R, rival: R) -> R {
    if own.ge(rival) {
        let ratio = rival / if own.gt(R::ZERO) { own } else { R::ONE };
        R::ONE / (R::ONE + ratio * ratio)
    } else {
        let ratio = own / rival;
        ratio * ratio / (R::ONE + ratio * ratio)
    }
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
