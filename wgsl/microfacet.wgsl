// Whole microfacet BRDFs. Twin of src/microfacet.rs.

import package::distribution;
import package::fresnel;
import package::masking;

struct TorranceSparrow {
    f: f32,
    reflectance: f32,
    transmittance: f32,
    d: f32,
    g: f32,
}

// The part that all channels share: the BRDF for F = 1, and its D and G.
struct Facets {
    lobe: f32,
    d: f32,
    g: f32,
}

// F·D·G/(4 cos_i cos_o): Beckmann, V-cavities, exact Fresnel of n + ik.
fn torrance_sparrow(wi: vec3f, wo: vec3f, n: f32, k: f32, alpha: f32) -> TorranceSparrow {
    let split = fresnel::conductor(cos_half(wi, wo), n, k);
    let rough = facets(wi, wo, alpha);
    return TorranceSparrow(split.reflectance * rough.lobe, split.reflectance, split.transmittance, rough.d, rough.g);
}

// V·H = |wi+wo|/2, at most 1.
fn cos_half(wi: vec3f, wo: vec3f) -> f32 {
    let h = wi + wo;
    return min(0.5 * sqrt(dot(h, h)), 1.0);
}

// Beckmann's distribution under V-cavities, without the Fresnel term.
fn facets(wi: vec3f, wo: vec3f, alpha: f32) -> Facets {
    let h = wi + wo;
    let d = select(0.0, distribution::beckmann(h, alpha), wi.z > 0.0 && wo.z > 0.0);
    let shadow = masking::v_cavity(wi.z, wo.z, h);
    return Facets(d * shadow.visibility, d, shadow.g);
}
