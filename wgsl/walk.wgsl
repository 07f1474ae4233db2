// The random walk through a layered stack. Twin of src/walk/.
//
// The shader that imports this module supplies its layers, as for the module layered:
//
//     fn stack_layer(index: u32) -> layered::Layer
//
// Directions at an interface are seen from the side that the walk arrives from: a.z > 0, b.z > 0 for reflection and
// b.z < 0 for transmission.

import package::diffuse;
import package::distribution;
import package::fresnel;
import package::layered;
import package::microfacet::{cos_half, facets};
import package::random::random;
import package::real;
import package::refraction::cos_t;

// A pair of directions at an interface for F = 1 or T = 1: f or f̂, the density of b given a, and a·m.
struct Pair {
    lobe: f32,
    density: f32,
    cos_a: f32,
}

// A direction refracted by a facet, and its cosine to the facet: 0 on total reflection.
struct Refracted {
    direction: vec3f,
    cos_b: f32,
}

// The smallest width: the half vector of a refraction carries no more digits.
const least_alpha: f32 = 1e-3;
// The square root of 2^-23: indices that differ by less reflect less than a rounding error.
const matched_below: f32 = 3.4526698e-4;
const longest: u32 = 4096u;
const roulette_from: u32 = 4u;
const spared: f32 = 0.25;

const both_ways: u32 = 0u;
const reflection_only: u32 = 1u;
const transmission_only: u32 = 2u;

// The f of one walk in one channel, in 1/sr; their mean is the BRDF.
fn sample(first: u32, count: u32, channel: u32, wi: vec3f, wo: vec3f, seed: u32, index: u32) -> f32 {
    if wi.z <= 0.0 || wo.z <= 0.0 || count == 0u {
        return 0.0;
    }
    let top = _interface(first, count, channel, 0u);
    let outside = _absorbed(top.depth_above, wi.z) * _absorbed(top.depth_above, wo.z);
    var sum = outside * _reflection_kernel(top, wo, wi, reflection_only, top.exact_alpha).x;
    if top.count < 2u {
        return sum;
    }
    let last = top.count - 1u;
    let entry = _sample_from(top, wo, transmission_only, random(seed, index, 0u));
    if entry.weight <= 0.0 {
        return sum;
    }
    var weight = entry.weight * outside;
    var direction = entry.direction;
    var depth = top.depth;
    // Medium j lies under interface j-1.
    var medium = 1u;
    for (var step = 1u; step < longest; step++) {
        weight *= _absorbed(depth, direction.z);
        let at = select(medium - 1u, medium, direction.z < 0.0);
        let way = select(both_ways, reflection_only, at == 0u || at == last);
        let here = _interface(first, count, channel, at);
        let numbers = random(seed, index, 2u * step);

        // Next event: a direction that the light refracts into, connected through this interface.
        if at == 1u {
            let light = _sample_from(top, wi, transmission_only, numbers);
            if light.weight > 0.0 {
                let connected = _kernel(here, -direction, -light.direction, way);
                let arriving = weight * light.weight * _absorbed(top.depth, light.direction.z);
                sum += arriving * connected.x * _power_share(light.density, connected.y);
            }
        }

        let next = _sample_from(here, -direction, way, random(seed, index, 2u * step + 1u));
        if next.weight <= 0.0 {
            return sum;
        }
        weight *= next.weight;
        direction = next.direction;
        let downward = direction.z < 0.0;
        medium = select(at, at + 1u, downward);
        if downward {
            depth = here.depth;
        } else if at > 0u {
            depth = _interface(first, count, channel, at - 1u).depth;
        }

        // The same paths found by sampling, weighted against the density of the inner direction.
        if at == 1u && !downward {
            let exit = _kernel(top, wi, -direction, transmission_only);
            sum += weight * _absorbed(top.depth, direction.z) * exit.x * _power_share(next.density, exit.y);
        }

        if step >= roulette_from {
            let q = min(weight / spared, 1.0);
            if numbers.w >= q {
                return sum;
            }
            weight /= q;
        }
    }
    return sum;
}

// The part of facet m that w sees under V-cavities: min(1, 2 m_z |w_z|/|w·m|), m of any length.
fn visible_part(w: vec3f, m: vec3f) -> f32 {
    let facing = abs(dot(w, m));
    let usable = facing > 0.0;
    return select(1.0, min(2.0 * m.z * abs(w.z) / select(1.0, facing, usable), 1.0), usable);
}

// A point on the unit circle for turn in [0, 1): the quadrant apart, then a Taylor series to 2e-9 on [-pi/4, pi/4].
fn circle(turn: f32) -> vec2f {
    let quarters = 4.0 * turn;
    let centre = select(select(select(3.5, 2.5, quarters < 3.0), 1.5, quarters < 2.0), 0.5, quarters < 1.0);
    let x = (quarters - centre) * 1.57079632679489662;
    let z = x * x;
    let s = x * (1.0 - z * (1.0 / 6.0) * (1.0 - z * (1.0 / 20.0) * (1.0 - z * (1.0 / 42.0) * (1.0 - z * (1.0 / 72.0)))));
    let c = 1.0 - z * 0.5 * (1.0 - z * (1.0 / 12.0)
        * (1.0 - z * (1.0 / 30.0) * (1.0 - z * (1.0 / 56.0) * (1.0 - z * (1.0 / 90.0)))));
    if quarters < 1.0 {
        return vec2f(c, s);
    } else if quarters < 2.0 {
        return vec2f(-s, c);
    } else if quarters < 3.0 {
        return vec2f(-c, -s);
    }
    return vec2f(s, -c);
}

// A normal drawn from those that w sees (Heitz & d'Eon 2014, algorithm 3): Beckmann under V-cavities.
fn visible_normal(w: vec3f, alpha: f32, u: vec3f) -> vec3f {
    let slope = alpha * sqrt(max(-real::ln_one_plus(-u.x), 0.0));
    let around = circle(u.y);
    let h = vec3f(slope * around.x, slope * around.y, 1.0);
    let m = h * (1.0 / sqrt(dot(h, h)));
    let along = w.z * m.z;
    let across = w.x * m.x + w.y * m.y;
    let here = max(along + across, 0.0);
    let there = max(along - across, 0.0);
    let side = select(-1.0, 1.0, u.z * (here + there) < here);
    return vec3f(side * m.x, side * m.y, m.z);
}

// Reflection from a to b for F = 1.
fn reflection(a: vec3f, b: vec3f, alpha: f32) -> Pair {
    let rough = facets(a, b, alpha);
    let lit = a.z > 0.0 && b.z > 0.0;
    let guarded = vec3f(a.x, a.y, select(1.0, a.z, lit));
    let density = visible_part(guarded, a + b) * rough.d / (4.0 * guarded.z);
    return Pair(rough.lobe, select(0.0, density, lit), cos_half(a, b));
}

// The normal that refracts a to b, ±(n_a a + n_b b), not normalised (Walter et al. 2007, eq. 16).
fn refracting_normal(a: vec3f, b: vec3f, n_a: f32, n_b: f32) -> vec3f {
    let m = a * n_a + b * n_b;
    return m * select(1.0, -1.0, m.z < 0.0);
}

// Transmission from a to b for T = 1, per étendue (Walter et al. 2007, eq. 17 and 21).
fn transmission(a: vec3f, b: vec3f, n_a: f32, n_b: f32, alpha: f32) -> Pair {
    let h = refracting_normal(a, b, n_a, n_b);
    let squared = dot(h, h);
    let unit = h * (1.0 / sqrt(select(1.0, squared, squared > 0.0)));
    let cos_a = dot(a, unit);
    let cos_b = -dot(b, unit);
    let lit = a.z > 0.0 && b.z < 0.0 && cos_a > 0.0 && cos_b > 0.0 && h.z > 0.0;
    let m = vec3f(unit.x, unit.y, select(1.0, unit.z, lit));
    let part_a = visible_part(a, m);
    let part_b = visible_part(b, m);
    let jacobian = cos_b / select(1.0, squared, lit);
    let seen = distribution::beckmann(m, alpha) * cos_a / select(1.0, a.z, lit) * jacobian;
    return Pair(
        select(0.0, seen * max(part_a + part_b - 1.0, 0.0) / select(1.0, -b.z, lit), lit),
        select(0.0, seen * part_a * n_b * n_b, lit),
        select(0.0, cos_a, lit));
}

// a mirrored by a facet of unit normal m.
fn reflected(a: vec3f, m: vec3f) -> vec3f {
    return m * (2.0 * dot(a, m)) - a;
}

// a refracted by a facet of unit normal m, eta = n_b/n_a.
fn refracted(a: vec3f, m: vec3f, eta: f32) -> Refracted {
    let cos_a = dot(a, m);
    let cos_b = cos_t(cos_a, eta);
    return Refracted(m * (cos_a / eta - cos_b) - a * (1.0 / eta), cos_b);
}

// One interface of a stack and the medium under it, in one channel.
struct _Interface {
    // The number of interfaces of the whole stack, and the optical depth above the first.
    count: u32,
    depth_above: f32,
    kind: u32,
    // Relative to the medium above.
    n: f32,
    k: f32,
    alpha: f32,
    exact_alpha: f32,
    albedo: f32,
    deviation: f32,
    n_above: f32,
    n_below: f32,
    depth: f32,
}

struct _Step {
    direction: vec3f,
    // 0 where the walk ends.
    weight: f32,
    density: f32,
}

// The at-th interface, not counting those between equal indices.
fn _interface(first: u32, count: u32, channel: u32, at: u32) -> _Interface {
    var found = _Interface();
    var n_above = 1.0;
    for (var position = 0u; position < count; position++) {
        let layer: layered::Layer = stack_layer(first + position);
        let microfacets = layer.kind == layered::microfacet_interface;
        let own = layer.n[channel];
        let same = abs(own / n_above - 1.0) < matched_below;
        let depth = layer.sigma[channel] * layer.thickness;
        if microfacets && same && layer.k[channel] == 0.0 && position + 1u < count {
            if found.count == 0u {
                found.depth_above += depth;
            } else if found.count == at + 1u {
                found.depth += depth;
            }
            continue;
        }
        let n_below = select(n_above, select(own, n_above * (1.0 + 2.0 * matched_below), same), microfacets);
        if found.count == at {
            found.kind = layer.kind;
            found.n = own / n_above;
            found.k = layer.k[channel] / n_above;
            found.alpha = max(layer.alpha, least_alpha);
            found.exact_alpha = layer.alpha;
            found.albedo = layer.albedo[channel];
            found.deviation = layer.deviation;
            found.n_above = n_above;
            found.n_below = n_below;
            found.depth = depth;
        }
        found.count += 1u;
        n_above = n_below;
    }
    return found;
}

// f̂ of two directions away from the interface, and the density of b given a.
fn _kernel(here: _Interface, a: vec3f, b: vec3f, way: u32) -> vec2f {
    let below = a.z < 0.0;
    let near = _seen_from(below, a);
    let far = _seen_from(below, b);
    if far.z > 0.0 {
        return _reflection_kernel(here, a, b, way, here.alpha);
    }
    if here.kind == layered::diffuse_base {
        return vec2f(0.0, 0.0);
    }
    let pair = transmission(near, far, _index(here, below), _index(here, !below), here.alpha);
    if pair.density <= 0.0 {
        return vec2f(0.0, 0.0);
    }
    let split = _fresnel_from(here, pair.cos_a, below);
    let chance = select(1.0 - split.reflectance, 1.0, way == transmission_only);
    return vec2f(split.transmittance * pair.lobe, select(chance, 0.0, way == reflection_only) * pair.density);
}

fn _reflection_kernel(here: _Interface, a: vec3f, b: vec3f, way: u32, alpha: f32) -> vec2f {
    let below = a.z < 0.0;
    let near = _seen_from(below, a);
    let far = _seen_from(below, b);
    let n_a = _index(here, below);
    if here.kind == layered::diffuse_base {
        if below {
            return vec2f(0.0, 0.0);
        }
        return vec2f(_diffuse(here, near, far) / (n_a * n_a), far.z * 0.318309886183790672);
    }
    let pair = reflection(near, far, alpha);
    let split = _fresnel_from(here, pair.cos_a, below);
    let chance = select(split.reflectance, 1.0, way == reflection_only);
    return vec2f(split.reflectance * pair.lobe / (n_a * n_a), select(chance, 0.0, way == transmission_only) * pair.density);
}

fn _sample_from(here: _Interface, w: vec3f, way: u32, u: vec4f) -> _Step {
    let ended = _Step(vec3f(0.0, 0.0, 1.0), 0.0, 0.0);
    let below = w.z < 0.0;
    let a = _seen_from(below, w);
    if a.z <= 0.0 {
        return ended;
    }
    if here.kind == layered::diffuse_base {
        let around = circle(u.y) * sqrt(u.x);
        let b = vec3f(around.x, around.y, sqrt(1.0 - u.x));
        return _Step(b, 3.14159265358979324 * _diffuse(here, a, b), b.z * 0.318309886183790672);
    }
    let m = visible_normal(a, here.alpha, u.xyz);
    let cos_a = dot(a, m);
    if cos_a <= 0.0 {
        return ended;
    }
    let split = _fresnel_from(here, cos_a, below);
    let reflects = way == reflection_only || (way == both_ways && u.w < split.reflectance);
    let choice = select(1.0, select(1.0 - split.reflectance, split.reflectance, reflects), way == both_ways);
    let n_a = _index(here, below);
    let n_b = _index(here, !below);
    let through = refracted(a, m, n_b / n_a);
    if !reflects && through.cos_b <= 0.0 {
        return ended;
    }
    let b = select(through.direction, reflected(a, m), reflects);
    if (b.z > 0.0) != reflects {
        return ended;
    }
    let part_a = visible_part(a, m);
    let part_b = visible_part(b, m);
    let seen = select(max(part_a + part_b - 1.0, 0.0), min(part_a, part_b), reflects) / part_a;
    let kept = select(split.transmittance, split.reflectance, reflects);
    var density = 0.0;
    if reflects {
        density = reflection(a, b, here.alpha).density;
    } else {
        density = transmission(a, b, n_a, n_b, here.alpha).density;
    }
    return _Step(_seen_from(below, b), seen * kept / choice, choice * density);
}

// From below the Fresnel terms are those of the refracted ray; past the critical angle its cosine is 0 and F is 1.
fn _fresnel_from(here: _Interface, cos_a: f32, below: bool) -> fresnel::Fresnel {
    var cos_i = cos_a;
    if below {
        cos_i = cos_t(cos_a, here.n_above / here.n_below);
    }
    if here.k == 0.0 {
        return fresnel::dielectric(cos_i, here.n);
    }
    return fresnel::conductor(cos_i, here.n, here.k);
}

fn _diffuse(here: _Interface, a: vec3f, b: vec3f) -> f32 {
    let base = diffuse::oren_nayar(a, b, here.deviation);
    return max(diffuse::lambert(here.albedo) * (base.direct + here.albedo * base.interreflection), 0.0);
}

fn _index(here: _Interface, below: bool) -> f32 {
    return select(here.n_above, here.n_below, below);
}

fn _seen_from(below: bool, w: vec3f) -> vec3f {
    return vec3f(w.x, w.y, select(w.z, -w.z, below));
}

// exp(-depth/|cos|).
fn _absorbed(depth: f32, cosine: f32) -> f32 {
    if depth <= 0.0 {
        return 1.0;
    }
    if cosine == 0.0 {
        return 0.0;
    }
    return real::exp_product(depth, 1.0 / abs(cosine));
}

// The power heuristic as a ratio, so that no square overflows.
fn _power_share(own: f32, rival: f32) -> f32 {
    if own >= rival {
        let ratio = rival / select(1.0, own, own > 0.0);
        return 1.0 / (1.0 + ratio * ratio);
    }
    let ratio = own / rival;
    return ratio * ratio / (1.0 + ratio * ratio);
}
