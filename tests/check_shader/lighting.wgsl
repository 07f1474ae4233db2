#define_import_path engine::lighting

#import engine::{
    mesh_view_bindings::view,
    maths,
    types::{LightingInput, PI as pi},
}
#import engine::absent::{nothing}

@group(0) @binding(1) var environment_map: texture_cube<f32>;
@group(0) @binding(2) var environment_sampler: sampler;

fn D_GGX(roughness: f32, NdotH: f32) -> f32 {
    let oneMinusNdotHSquared = 1.0 - NdotH * NdotH;
    let a = NdotH * roughness;
    let k = roughness / (oneMinusNdotHSquared + a * a);
    let d = k * k * (1.0 / 3.141592653589793);
    return d;
}

#ifdef ENVIRONMENT_MAP
fn ambient(N: vec3<f32>) -> vec3<f32> {
    return textureSampleLevel(environment_map, environment_sampler, N, 0.0).rgb * nothing();
}
#endif

fn visibility(roughness: f32, NdotV: f32, NdotL: f32) -> f32 {
    let a2 = roughness * roughness;
    let lambdaV = NdotL * sqrt((NdotV - a2 * NdotV) * NdotV + a2);
    let lambdaL = NdotV * sqrt((NdotL - a2 * NdotL) * NdotL + a2);
    return maths::half_of(1.0 / (lambdaV + lambdaL));
}

fn lit(input: ptr<function, LightingInput>, L: vec3<f32>) -> vec3<f32> {
    let H = normalize(L + (*input).V);
    let D = D_GGX((*input).roughness, saturate(dot((*input).N, H))) * 3.141592653589793 / pi;
    let V = visibility((*input).roughness, dot((*input).N, (*input).V), dot((*input).N, L));
    return (D * V) * (*input).F0_;
}

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    return view.exposure * vec4<f32>(dpdx(position.xyz), 1.0);
}
