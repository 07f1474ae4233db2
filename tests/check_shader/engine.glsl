//------------------------------------------------------------------------------
// A PBR engine's BRDFs, in the style of mobile engines.
//------------------------------------------------------------------------------

#define SPECULAR_D_GGX              0
#define BRDF_SPECULAR_D             SPECULAR_D_GGX
#define MEDIUMP_FLT_MAX             65504.0
#define saturateMediump(x)          min(x, MEDIUMP_FLT_MAX)
#define PI                          3.14159265359

precision highp float;

layout(std140) uniform FrameUniforms {
    highp mat4 viewFromWorld;
    highp vec4 lightColorIntensity;
} frameUniforms;
layout(location = 0) in highp vec3 vertex_worldPosition;
uniform mediump sampler2D light_iblDFG;

struct PixelParams {
    vec3  diffuseColor;
    float perceptualRoughness;
    vec3  f0;
    float roughness;
    vec3  dfg;
};

float pow5(float x) {
    float x2 = x * x;
    return x2 * x2 * x;
}

float D_GGX(float roughness, float NoH, const vec3 h) {
    float oneMinusNoHSquared = 1.0 - NoH * NoH;
    float a = NoH * roughness;
    float k = roughness / (oneMinusNoHSquared + a * a);
    float d = k * k * (1.0 / PI);
    return saturateMediump(d);
}

float V_SmithGGXCorrelated(highp float roughness, float NoV, float NoL) {
    float a2 = roughness * roughness;
    float lambdaV = NoL * sqrt((NoV - a2 * NoV) * NoV + a2);
    float lambdaL = NoV * sqrt((NoL - a2 * NoL) * NoL + a2);
    float v = 0.5 / (lambdaV + lambdaL);
    return saturateMediump(v);
}

vec3 F_Schlick(const vec3 f0, float f90, float VoH) {
    return f0 + (f90 - f0) * pow5(1.0 - VoH);
}

vec3 F_Schlick(const vec3 f0, float u) {
    float f = pow5(1.0 - u);
    return f + f0 * (1.0 - f);
}

float distribution(float roughness, float NoH, const vec3 h) {
#if BRDF_SPECULAR_D == SPECULAR_D_GGX
    return D_GGX(roughness, NoH, h);
#endif
}

float Fd_Lambert() {
    return 1.0 / PI;
}

vec3 prefilteredDFG(float perceptualRoughness, float NoV) {
    return textureLod(light_iblDFG, vec2(NoV, perceptualRoughness), 0.0).rgb;
}

vec3 isotropicLobe(const PixelParams pixel, const vec3 h, float NoV, float NoL, float NoH, float LoH) {
    float D = distribution(pixel.roughness, NoH, h);
    float V = V_SmithGGXCorrelated(pixel.roughness, NoV, NoL);
    vec3  F = F_Schlick(pixel.f0, LoH);
    return (D * V) * F;
}
