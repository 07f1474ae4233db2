// Snell's law. Twin of src/refraction.rs. Refracted directions point away from the surface.

import package::fresnel::refracted_square;

// The cosine of the refracted ray, 0 on total reflection; eta = n_t/n_i.
fn cos_t(cos_i: f32, eta: f32) -> f32 {
    return sqrt(max(refracted_square(cos_i, eta), 0.0)) / eta;
}

// A local direction refracted about the normal; z is 0 on total reflection.
fn refract(w: vec3f, eta: f32) -> vec3f {
    return vec3f(w.x / eta, w.y / eta, cos_t(w.z, eta));
}
