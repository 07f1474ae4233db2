#version 300 es
#extension GL_OES_standard_derivatives : enable
precision mediump float;

#ifndef SQUARED
#define SQUARED 1
#endif

uniform sampler2D u_Map;
uniform float u_RoughnessFactor;
uniform mat4 u_ViewProjection;
in vec3 v_Normal;
in vec2 v_UV;
out vec4 fragColor;

const float M_PI = 3.141592653589793;

float alpha()
{
#if SQUARED != 0
    return u_RoughnessFactor * u_RoughnessFactor;
#else
    return u_RoughnessFactor;
#endif
}

float clampedDot(vec3 x, vec3 y) { return clamp(dot(x, y), 0.0, 1.0); }

float specular(vec3 l, vec3 v)
{
    vec3 n = normalize(v_Normal);
    vec3 h = normalize(l + v);
    float a2 = alpha() * alpha();
    float NdotL = clampedDot(n, l), NdotV = clampedDot(n, v), NdotH = clampedDot(n, h);
    float f = (NdotH * NdotH) * (a2 - 1.0) + 1.0;
    float GGXV = NdotL * sqrt(NdotV * NdotV * (1.0 - a2) + a2);
    float GGXL = NdotV * sqrt(NdotL * NdotL * (1.0 - a2) + a2);
    return a2 / (M_PI * f * f) * 0.5 / (GGXV + GGXL);
}

vec3 textured(vec3 l, vec3 v)
{
    return texture(u_Map, v_UV).rgb * specular(l, v);
}

void main()
{
    fragColor = vec4(textured(normalize(dFdx(v_Normal)), v_Normal), 1.0);
}
