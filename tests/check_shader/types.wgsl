#define_import_path engine::types

const PI: f32 = 3.141592653589793;

struct LightingInput {
    layers: array<mat3x3<f32>, 2>,
    N: vec3<f32>,
    V: vec3<f32>,
    roughness: f32,
    F0_: vec3<f32>,
    diffuse_color: vec3<f32>,
}
