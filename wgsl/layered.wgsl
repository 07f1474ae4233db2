// Layered stacks. Twin of src/layered/model.rs.
//
// The shader that imports this module supplies its layers:
//
//     fn stack_layer(index: u32) -> layered::Layer
//
// A stack is `count` layers from `first` on, listed from the top.

import package::absorption::transmittance;
import package::diffuse;
import package::fresnel;
import package::microfacet::{cos_half, facets};
import package::refraction::{refract, refract_about};

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
