// Layered stacks. Twin of src/layered/model.rs.
//
// The shader that imports this module supplies its layers:
//
//     fn stack_layer(index: u32) -> layered::Layer
//
// A stack is `count` layers from `first` on, listed from the top. A shader that calls `coupled` supplies its tables too:
//
//     fn coupled_row(index: u32) -> vec4f
//
// `table` is the first of a stack's rows, counted over all stacks. Layout of a table, rows counted from its first:
//
//     0     xyz: ρ²·r/(1-ρ·r), what bounces between base and coat add to the base's albedo; w: the row of E_T, 0: none
//     1     xyz: 1/(pi·mean of m); w: the row of s, which m follows; 0: neither
//     2...  the curves that there are, in the order E_T, s, m: 32 rows each, xyz over the square root of the cosine

import package::absorption::transmittance;
import package::diffuse;
import package::fresnel;
import package::microfacet::{cos_half, facets};
import package::refraction::{cos_t, refract, refract_about};

const microfacet_interface: u32 = 0u;
const diffuse_base: u32 = 1u;

struct Layer {
    // The interface: n + ik and width of a microfacet interface, or albedo and slope deviation of a diffuse base.
    n: vec3f,
    alpha: f32,
    k: vec3f,
    kind: u32,
    albedo: vec3f,
    deviation: f32,
    // The medium under it.
    sigma: vec3f,
    thickness: f32,
}

// The documents' model: f + T·f(below)·a·t with T at V·H, absolute indices, no layer smoother than the one above.
fn elek(first: u32, count: u32, wi: vec3f, wo: vec3f) -> vec3f {
    return vec3f(
        elek_channel(first, count, 0u, wi, wo),
        elek_channel(first, count, 1u, wi, wo),
        elek_channel(first, count, 2u, wi, wo));
}

// One colour channel of elek: channels refract differently where an oxide disperses.
fn elek_channel(first: u32, count: u32, channel: u32, wi: vec3f, wo: vec3f) -> f32 {
    var f = 0.0;
    var weight = 1.0;
    var below_i = wi;
    var below_o = wo;
    var n_above = 1.0;
    var alpha_above = 0.0;
    for (var position = 0u; position < count; position++) {
        let layer = stack_layer(first + position);
        if layer.kind == diffuse_base {
            return f + weight * _diffuse_reflection(layer, channel, below_i, below_o);
        }
        let n = layer.n[channel];
        let alpha = max(layer.alpha, alpha_above);
        let rough = facets(below_i, below_o, alpha);
        let split = _interface_fresnel(cos_half(below_i, below_o), n, layer.k[channel]);
        f += weight * split.reflectance * rough.lobe;

        let eta = n / n_above;
        let next_i = refract(below_i, eta);
        let next_o = refract(below_o, eta);
        if min(next_i.z, next_o.z) <= 0.0 || min(below_i.z, below_o.z) <= 0.0 {
            return f;
        }
        weight *= split.transmittance * internal_reflection(split.transmittance, rough.g)
            * transmittance(layer.sigma[channel], layer.thickness, next_i.z, next_o.z);
        below_i = next_i;
        below_o = next_o;
        n_above = n;
        alpha_above = alpha;
    }
    return f;
}

// Weidlich and Wilkie's model: as elek, with refraction about the half vector, relative indices and own widths.
fn weidlich_wilkie(first: u32, count: u32, wi: vec3f, wo: vec3f) -> vec3f {
    return vec3f(
        weidlich_wilkie_channel(first, count, 0u, wi, wo),
        weidlich_wilkie_channel(first, count, 1u, wi, wo),
        weidlich_wilkie_channel(first, count, 2u, wi, wo));
}

// One colour channel of weidlich_wilkie.
fn weidlich_wilkie_channel(first: u32, count: u32, channel: u32, wi: vec3f, wo: vec3f) -> f32 {
    var f = 0.0;
    var weight = 1.0;
    var below_i = wi;
    var below_o = wo;
    var n_above = 1.0;
    for (var position = 0u; position < count; position++) {
        let layer = stack_layer(first + position);
        if layer.kind == diffuse_base {
            return f + weight * _diffuse_reflection(layer, channel, below_i, below_o);
        }
        let eta = layer.n[channel] / n_above;
        let rough = facets(below_i, below_o, layer.alpha);
        let split = _interface_fresnel(cos_half(below_i, below_o), eta, layer.k[channel] / n_above);
        f += weight * split.reflectance * rough.lobe;

        let h = below_i + below_o;
        let squared = dot(h, h);
        let m = h * (1.0 / sqrt(select(1.0, squared, squared > 0.0)));
        let next_i = refract_about(below_i, m, eta);
        let next_o = refract_about(below_o, m, eta);
        if min(next_i.z, next_o.z) <= 0.0 || min(below_i.z, below_o.z) <= 0.0 {
            return f;
        }
        weight *= split.transmittance * internal_reflection(split.transmittance, rough.g)
            * transmittance(layer.sigma[channel], layer.thickness, next_i.z, next_o.z);
        below_i = next_i;
        below_o = next_o;
        n_above = layer.n[channel];
    }
    return f;
}

// The energy-conserving model: Fresnel transmittance of both directions, relative indices, 1/eta² per refraction.
fn conserving(first: u32, count: u32, wi: vec3f, wo: vec3f) -> vec3f {
    return vec3f(
        conserving_channel(first, count, 0u, wi, wo),
        conserving_channel(first, count, 1u, wi, wo),
        conserving_channel(first, count, 2u, wi, wo));
}

// One colour channel of conserving.
fn conserving_channel(first: u32, count: u32, channel: u32, wi: vec3f, wo: vec3f) -> f32 {
    var f = 0.0;
    var weight = 1.0;
    var below_i = wi;
    var below_o = wo;
    var n_above = 1.0;
    for (var position = 0u; position < count; position++) {
        let layer = stack_layer(first + position);
        if layer.kind == diffuse_base {
            return f + weight * _diffuse_reflection(layer, channel, below_i, below_o);
        }
        let eta = layer.n[channel] / n_above;
        let k = layer.k[channel] / n_above;
        let rough = facets(below_i, below_o, layer.alpha);
        f += weight * _interface_fresnel(cos_half(below_i, below_o), eta, k).reflectance * rough.lobe;

        let next_i = refract(below_i, eta);
        let next_o = refract(below_o, eta);
        if min(next_i.z, next_o.z) <= 0.0 || min(below_i.z, below_o.z) <= 0.0 {
            return f;
        }
        weight *= _interface_fresnel(below_i.z, eta, k).transmittance
            * _interface_fresnel(below_o.z, eta, k).transmittance / (eta * eta)
            * transmittance(layer.sigma[channel], layer.thickness, next_i.z, next_o.z);
        below_i = next_i;
        below_o = next_o;
        n_above = layer.n[channel];
    }
    return f;
}

// Conserving with the light that bounces between interfaces, from the stack's table.
fn coupled(first: u32, count: u32, table: u32, wi: vec3f, wo: vec3f) -> vec3f {
    if min(wi.z, wo.z) <= 0.0 {
        return vec3f(0.0, 0.0, 0.0);
    }
    let base = coupled_row(table);
    let closure = coupled_row(table + 1u);
    // What gets to the base and back; negative where that is the product of the interfaces' own transmittances.
    var reaching = vec3f(-1.0, -1.0, -1.0);
    if base.w > 0.0 {
        let transmitted = table + u32(base.w);
        reaching = _curve(transmitted, wi.z) * _curve(transmitted, wo.z);
    }
    let red = _coupled_parts(first, count, 0u, base.x, reaching.x, wi, wo);
    let green = _coupled_parts(first, count, 1u, base.y, reaching.y, wi, wo);
    let blue = _coupled_parts(first, count, 2u, base.z, reaching.z, wi, wo);
    let top = vec3f(red.x, green.x, blue.x);
    let lower = vec3f(red.y, green.y, blue.y);
    if closure.w <= 0.0 {
        return top + lower;
    }
    let scale = table + u32(closure.w);
    let missing = scale + _curve_nodes;
    return top + lower * (_curve(scale, wi.z) * _curve(scale, wo.z))
        + _curve(missing, wi.z) * _curve(missing, wo.z) * closure.xyz;
}

const _curve_nodes: u32 = 32u;

// A curve whose nodes are the rows from `start` on, at a cosine: linear in the square root of it.
fn _curve(start: u32, cosine: f32) -> vec3f {
    let place = sqrt(clamp(cosine, 0.0, 1.0)) * f32(_curve_nodes - 1u);
    let node = min(u32(place), _curve_nodes - 2u);
    let share = clamp(place - f32(node), 0.0, 1.0);
    return coupled_row(start + node).xyz * (1.0 - share) + coupled_row(start + node + 1u).xyz * share;
}

// What the first interface reflects (x), and what the layers under it add (y), in one colour channel. `series` is what
// bounces add to the albedo of the base; `reaching` is as in coupled.
fn _coupled_parts(first: u32, count: u32, channel: u32, series: f32, reaching: f32, wi: vec3f, wo: vec3f) -> vec2f {
    // Added to with the factor (1, 0) at the top, (0, 1) under it.
    var f = vec2f(0.0, 0.0);
    var part = vec2f(1.0, 0.0);
    var weight = 1.0;
    var below_i = wi;
    var below_o = wo;
    var n_above = 1.0;
    // The interface above, where there is one: its relative index, and what the media between the two let through.
    var entered = false;
    var mirror = vec2f(1.0, 0.0);
    var absorbed = 1.0;
    for (var position = 0u; position < count; position++) {
        let layer = stack_layer(first + position);
        if layer.kind == diffuse_base {
            let lit = min(below_i.z, below_o.z) > 0.0;
            let reflected = _diffuse_reflection(layer, channel, below_i, below_o)
                + select(0.0, diffuse::lambert(series), lit);
            return f + part * (select(weight, reaching * (1.0 / (n_above * n_above)), reaching >= 0.0) * reflected);
        }
        let n = layer.n[channel];
        let eta = n / n_above;
        let k = layer.k[channel] / n_above;
        let cos_h = cos_half(below_i, below_o);
        let split = _interface_fresnel(cos_h, eta, k);
        var reflected = split.reflectance * facets(below_i, below_o, layer.alpha).lobe;
        if entered {
            // Mirror reflections between the two, without end.
            let back = _interface_fresnel(cos_t(cos_h, 1.0 / mirror.x), mirror.x, mirror.y).reflectance;
            let rest = 1.0 - back * split.reflectance * absorbed;
            reflected = select(0.0, reflected / select(1.0, rest, rest > 0.0), rest > 0.0);
        }
        f += part * (weight * reflected);

        let next_i = refract(below_i, eta);
        let next_o = refract(below_o, eta);
        if position + 1u == count || min(next_i.z, next_o.z) <= 0.0 || min(below_i.z, below_o.z) <= 0.0 {
            return f;
        }
        let depth = transmittance(layer.sigma[channel], layer.thickness, next_i.z, next_o.z);
        weight *= _interface_fresnel(below_i.z, eta, k).transmittance
            * _interface_fresnel(below_o.z, eta, k).transmittance / (eta * eta) * depth;
        // Between equal media there is no interface.
        if abs(n - n_above) < 1e-7 * n_above && all(layer.k == vec3f(0.0, 0.0, 0.0)) {
            absorbed *= depth;
        } else {
            entered = true;
            mirror = vec2f(eta, k);
            absorbed = depth;
            part = vec2f(0.0, 1.0);
        }
        below_i = next_i;
        below_o = next_o;
        n_above = n;
    }
    return f;
}

// The documents' internal reflection: t = (1-G) + T·G.
fn internal_reflection(transmitted: f32, g: f32) -> f32 {
    return (1.0 - g) + transmitted * g;
}

// The exact Fresnel terms, by the dielectric's form where k = 0.
fn _interface_fresnel(cos_i: f32, n: f32, k: f32) -> fresnel::Fresnel {
    if k == 0.0 {
        return fresnel::dielectric(cos_i, n);
    }
    return fresnel::conductor(cos_i, n, k);
}

fn _diffuse_reflection(layer: Layer, channel: u32, wi: vec3f, wo: vec3f) -> f32 {
    let base = diffuse::oren_nayar(wi, wo, layer.deviation);
    let albedo = layer.albedo[channel];
    return max(diffuse::lambert(albedo) * (base.direct + albedo * base.interreflection), 0.0);
}
