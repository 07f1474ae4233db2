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

// A direction refracted about the unit normal of a microfacet; the zero vector on total reflection.
fn refract_about(w: vec3f, m: vec3f, eta: f32) -> vec3f {
    let cos_i = min(dot(w, m), 1.0);
    let transmitted = cos_t(cos_i, eta);
    return select(vec3f(0.0), w / eta + m * (transmitted - cos_i / eta), transmitted > 0.0);
}
