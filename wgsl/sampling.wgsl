// Directions drawn for the BRDF of a stack, and their density. Twin of src/sampling.rs, which derives the mixture.
//
// The shader that imports this module supplies its layers, as for the module layered:
//
//     fn stack_layer(index: u32) -> layered::Layer
//
// A stack is `count` layers from `first` on, listed from the top. `model` is one of the four constants.

import package::absorption::transmittance;
import package::distribution::beckmann;
import package::fresnel;
import package::layered;
import package::real;
import package::refraction::refract;

struct Sample {
    // Towards the light.
    wi: vec3f,
    // In sr⁻¹; 0 where there is no sample, which counts as 0.
    pdf: f32,
}

// The models of the module layered, as samples know them.
const conserving: u32 = 0u;
const weidlich_wilkie: u32 = 1u;
const elek: u32 = 2u;
const coupled: u32 = 3u;

const frac_pi: f32 = 0.318309886183790672;

// The share of the mixture that follows the safe weights.
const _safe_share: f32 = 0.25;

// The share of coupled's samples that is drawn from the cosine: its closure reflects into every direction.
const _cosine_share: f32 = 0.25;

// The largest f32 below 1.
const _below_one: f32 = 0x1.fffffep-1;

// The weights of a lobe: what it reflects along the mirror direction, and what no direction exceeds; or sums of them.
struct _Weights {
    estimate: f32,
    safe: f32,
}

// What one interface reflects a view to, and where the walk through the layers stands.
struct _Lobe {
    weights: _Weights,
    layer: layered::Layer,
    // Refracted down to the interface, into the medium of index n; least is the smallest index above, 1 included.
    view: vec3f,
    // What the lobe is drawn about: the view, at the top the one outside.
    drawn: vec3f,
    alpha: f32,
    n: f32,
    least: f32,
    top: bool,
    // There is such a lobe.
    exists: bool,
    // What is left at the interface of the view and light along the mirror direction, and of the view and any light.
    mirrored: vec3f,
    most: vec3f,
}

// A direction wi for a view of a stack, drawn about in proportion to f·cos; u are three numbers in [0, 1).
fn sample(first: u32, count: u32, model: u32, wo: vec3f, u: vec3f) -> Sample {
    if wo.z <= 0.0 {
        return Sample(vec3f(0.0, 0.0, 0.0), 0.0);
    }
    let total = _total(first, count, model, wo);
    let even = model == coupled && u.x < _cosine_share;
    var rest = _inside(select(u.x, (u.x - _cosine_share) / (1.0 - _cosine_share), model == coupled));
    var wi = select(vec3f(0.0, 0.0, 0.0), cosine_hemisphere(u.yz), even);
    var pending = !even;
    let passes = _passes_through(first, count);
    for (var channel = 0u; channel < passes && pending; channel++) {
        var lobe = _start(wo);
        for (var position = 0u; position < count; position++) {
            lobe = _descend(lobe, first, position, channel, passes, model, wo);
            if !lobe.exists {
                break;
            }
            let share = _share(total, lobe.weights);
            if rest < share {
                wi = _reflect(lobe, vec3f(rest / share, u.y, u.z));
                pending = false;
                break;
            }
            rest -= share;
        }
    }
    let density = pdf(first, count, model, wi, wo);
    let found = wi.z > 0.0 && density > 0.0;
    return Sample(select(vec3f(0.0, 0.0, 0.0), wi, found), select(0.0, density, found));
}

// The density in sr⁻¹ with which sample draws wi for the view wo.
fn pdf(first: u32, count: u32, model: u32, wi: vec3f, wo: vec3f) -> f32 {
    if min(wi.z, wo.z) <= 0.0 {
        return 0.0;
    }
    var total = _Weights(0.0, 0.0);
    var density = _Weights(0.0, 0.0);
    let passes = _passes_through(first, count);
    for (var channel = 0u; channel < passes; channel++) {
        var lobe = _start(wo);
        for (var position = 0u; position < count; position++) {
            lobe = _descend(lobe, first, position, channel, passes, model, wo);
            if !lobe.exists {
                break;
            }
            total = _plus(total, lobe.weights, 1.0);
            density = _plus(density, lobe.weights, _density(lobe, wi));
        }
    }
    let lobes = _share(total, density);
    return select(lobes, wi.z * frac_pi * _cosine_share + lobes * (1.0 - _cosine_share), model == coupled);
}

// What f·cos/pdf is bounded by, up to the factor WEIGHT_BOUND = 11; under coupled no bound is derived.
fn ceiling(first: u32, count: u32, model: u32, wo: vec3f) -> f32 {
    if wo.z <= 0.0 {
        return 0.0;
    }
    return _total(first, count, model, wo).safe;
}

// A direction that Beckmann's facets reflect wo to, drawn from the normals that wo sees of V-cavities.
fn reflect_visible(wo: vec3f, alpha: f32, u: vec3f) -> vec3f {
    // The slopes of m are Gaussian.
    let slope = alpha * sqrt(max(-real::ln_one_plus(-_inside(u.y)), 0.0));
    let circle = real::unit_circle(u.z);
    let x = slope * circle.x;
    let y = slope * circle.y;
    let across = x * wo.x + y * wo.y;
    // V·m/(V·m + V·m') of m = (x, y, 1), whose sum is 2·V.z.
    let sign = select(-1.0, 1.0, 2.0 * wo.z * _inside(u.x) < wo.z + across);
    let square = slope * slope;
    let scale = 1.0 / (1.0 + square);
    let along = 2.0 * (wo.z + sign * across) * scale;
    return vec3f(along * (sign * x) - wo.x, along * (sign * y) - wo.y,
        (wo.z * (1.0 - square) + 2.0 * (sign * across)) * scale);
}

// The density with which reflect_visible draws wi, D·G1/(4 cos_o).
fn reflect_visible_pdf(wi: vec3f, wo: vec3f, alpha: f32) -> f32 {
    let h = wi + wo;
    let lit = wi.z > 0.0 && wo.z > 0.0;
    let seen = min(h.z / select(1.0, dot(h, h), lit), 1.0 / select(1.0, 4.0 * wo.z, lit));
    return select(0.0, beckmann(h, alpha) * seen, lit);
}

// A direction drawn with density cos/pi.
fn cosine_hemisphere(u: vec2f) -> vec3f {
    let square = _inside(u.x);
    return vec3f(sqrt(square) * real::unit_circle(u.y), sqrt(1.0 - square));
}

// A direction drawn with density 1/(2·pi).
fn uniform_hemisphere(u: vec2f) -> vec3f {
    let height = 1.0 - _inside(u.x);
    return vec3f(sqrt((1.0 - height) * (1.0 + height)) * real::unit_circle(u.y), height);
}

// The sums of the weights of all lobes.
fn _total(first: u32, count: u32, model: u32, wo: vec3f) -> _Weights {
    var total = _Weights(0.0, 0.0);
    let passes = _passes_through(first, count);
    for (var channel = 0u; channel < passes; channel++) {
        var lobe = _start(wo);
        for (var position = 0u; position < count; position++) {
            lobe = _descend(lobe, first, position, channel, passes, model, wo);
            if !lobe.exists {
                break;
            }
            total = _plus(total, lobe.weights, 1.0);
        }
    }
    return total;
}

// 3 where an interface that light passes has an index that differs between channels: each channel has its own lobes. Else 1.
fn _passes_through(first: u32, count: u32) -> u32 {
    for (var position = 0u; position + 1u < count; position++) {
        let layer = stack_layer(first + position);
        if layer.kind == layered::microfacet_interface && any(layer.n != layer.n.xxx) {
            return 3u;
        }
    }
    return 1u;
}

// Above the first interface.
fn _start(wo: vec3f) -> _Lobe {
    var lobe: _Lobe;
    lobe.view = wo;
    lobe.n = 1.0;
    lobe.least = 1.0;
    lobe.exists = true;
    lobe.mirrored = vec3f(1.0, 1.0, 1.0);
    lobe.most = vec3f(1.0, 1.0, 1.0);
    return lobe;
}

// The lobe of the interface at a position, from the one above it. All channels in one pass, or the named one of three passes.
fn _descend(above: _Lobe, first: u32, position: u32, channel: u32, passes: u32, model: u32, wo: vec3f) -> _Lobe {
    let about_facets = model == weidlich_wilkie;
    let printed = about_facets || model == elek;
    var lobe = above;
    if position > 0u {
        if above.layer.kind == layered::diffuse_base {
            lobe.exists = false;
            return lobe;
        }
        lobe.n = above.layer.n[channel];
        lobe.least = min(above.least, lobe.n);
        lobe.view = refract(wo, lobe.n);
        if !about_facets && (!_gets_through(wo, lobe.least) || lobe.view.z <= 0.0) {
            lobe.exists = false;
            return lobe;
        }
    }
    let layer = stack_layer(first + position);
    lobe.layer = layer;
    lobe.top = position == 0u || about_facets;
    lobe.drawn = select(lobe.view, wo, lobe.top);
    lobe.alpha = select(layer.alpha, max(layer.alpha, above.alpha), model == elek);
    // The half vector with light at the opposite horizon is the farthest from the view.
    let sine = sqrt(lobe.view.x * lobe.view.x + lobe.view.y * lobe.view.y);
    let widest = lobe.view.z * sqrt(0.5 / (1.0 + sine));
    lobe.weights = _Weights(0.0, 0.0);
    for (var i = 0u; i < 3u; i++) {
        if passes == 3u && i != channel {
            continue;
        }
        if position > 0u {
            // The medium above and what its interface lets through.
            let medium = above.layer;
            lobe.mirrored[i] *= transmittance(medium.sigma[i], medium.thickness, lobe.view.z, lobe.view.z);
            lobe.most[i] *= transmittance(medium.sigma[i], medium.thickness, select(lobe.view.z, 1.0, about_facets), 1.0);
        }
        if layer.kind == layered::diffuse_base {
            let scale = select(1.0 / (lobe.n * lobe.n), 1.0, printed);
            lobe.weights.safe = max(lobe.weights.safe, scale * lobe.most[i] * layer.albedo[i]);
            lobe.weights.estimate = lobe.weights.safe;
        } else {
            let scale = select(1.0, lobe.n * lobe.n, model == elek);
            let divisor = select(lobe.n, 1.0, model == elek);
            let eta = layer.n[i] / divisor;
            let k = layer.k[i] / divisor;
            let split = layered::_interface_fresnel(lobe.view.z, eta, k);
            let end = layered::_interface_fresnel(widest, eta, k).reflectance;
            lobe.weights.estimate = max(lobe.weights.estimate, scale * lobe.mirrored[i] * split.reflectance);
            lobe.weights.safe = max(lobe.weights.safe, scale * lobe.most[i] * max(split.reflectance, end));
            lobe.mirrored[i] *= split.transmittance * split.transmittance;
            lobe.most[i] *= select(split.transmittance, 1.0, printed);
        }
    }
    return lobe;
}

// The density of wi outside the stack.
fn _density(lobe: _Lobe, wi: vec3f) -> f32 {
    if lobe.layer.kind == layered::diffuse_base {
        let uniformly = _slanted(lobe);
        return frac_pi * ((1.0 - uniformly) * wi.z + 0.5 * uniformly);
    }
    if lobe.top {
        return reflect_visible_pdf(wi, lobe.drawn, lobe.alpha);
    }
    let spread = _spread(lobe);
    let light = refract(wi, lobe.n);
    if !_gets_through(wi, lobe.least) || light.z <= 0.0 {
        return spread * frac_pi * wi.z;
    }
    let facets = reflect_visible_pdf(light, lobe.view, lobe.alpha) * (wi.z / (lobe.n * lobe.n * light.z));
    return spread * frac_pi * wi.z + (1.0 - spread) * facets;
}

// A direction outside the stack; at or below the horizon where it is lost.
fn _reflect(lobe: _Lobe, u: vec3f) -> vec3f {
    if lobe.layer.kind == layered::diffuse_base {
        if u.x < _slanted(lobe) {
            return uniform_hemisphere(u.yz);
        }
        return cosine_hemisphere(u.yz);
    }
    if lobe.top {
        return reflect_visible(lobe.drawn, lobe.alpha, u);
    }
    let spread = _spread(lobe);
    if u.x < spread {
        return cosine_hemisphere(u.yz);
    }
    let light = reflect_visible(lobe.view, lobe.alpha, vec3f((u.x - spread) / (1.0 - spread), u.y, u.z));
    let x = lobe.n * light.x;
    let y = lobe.n * light.y;
    let square = x * x + y * y;
    let leaves = light.z > 0.0 && square < lobe.least * lobe.least;
    return vec3f(x, y, select(0.0, sqrt(max(1.0 - square, 0.0)), leaves));
}

// The share of a base's samples that is drawn uniformly.
fn _slanted(lobe: _Lobe) -> f32 {
    let variance = lobe.layer.deviation * lobe.layer.deviation;
    return 0.45 * variance / (variance + 0.09) * (lobe.drawn.x * lobe.drawn.x + lobe.drawn.y * lobe.drawn.y);
}

// The share of a lower interface's samples that is drawn from the cosine: about what of its lobe is reflected totally on the
// way up, times the part of the hemisphere that the lobe fills.
fn _spread(lobe: _Lobe) -> f32 {
    let critical = min(lobe.least / lobe.n, 1.0);
    let cosines = lobe.view.z + sqrt(max((1.0 - critical) * (1.0 + critical), 0.0));
    let sine = sqrt(lobe.view.x * lobe.view.x + lobe.view.y * lobe.view.y);
    let scale = 1.0 / (lobe.alpha * select(1.0, cosines, cosines > 0.0));
    let toward = max(critical - sine, 0.0) * scale;
    let away = (critical + sine) * scale;
    let lost = 0.5 * (exp(-(toward * toward)) + exp(-(away * away)));
    let reach = 2.0 * lobe.n * lobe.view.z * lobe.alpha;
    return min(lost * min(reach * reach, 1.0), 0.5);
}

// Whether a direction outside gets through media of which `least` is the smallest index.
fn _gets_through(w: vec3f, least: f32) -> bool {
    return fresnel::refracted_square(w.z, least) > 0.0;
}

fn _plus(sum: _Weights, part: _Weights, factor: f32) -> _Weights {
    return _Weights(sum.estimate + factor * part.estimate, sum.safe + factor * part.safe);
}

// The probability of a part of the mixture, `total` being the sums of both weights.
fn _share(total: _Weights, part: _Weights) -> f32 {
    let estimate = select(0.0, part.estimate / select(1.0, total.estimate, total.estimate > 0.0), total.estimate > 0.0);
    let safe = select(0.0, part.safe / select(1.0, total.safe, total.safe > 0.0), total.safe > 0.0);
    return (1.0 - _safe_share) * estimate + _safe_share * safe;
}

// A number clamped to [0, 1), to the largest below 1.
fn _inside(u: f32) -> f32 {
    return min(clamp(u, 0.0, 1.0), _below_one);
}
