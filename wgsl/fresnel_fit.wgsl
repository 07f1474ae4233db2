// Fresnel terms fitted to a material. Twin of src/fresnel_fit.rs, which fits and documents them.

// `Fit::<3, 8>::rows`: the coefficients of the powers of 2t-1 from 0 up in xyz, and the bend b in the first row's w.
struct Fit {
    rows: array<vec4f, 8>,
}

// `Fit::<3, 12>::rows`.
struct FineFit {
    rows: array<vec4f, 12>,
}

struct Split {
    reflectance: vec3f,
    transmittance: vec3f,
}

// The split of power in three channels: T = t·P(2t-1), t = c(1+b)/(c+b); F = 1-T.
fn evaluate(cos_i: f32, fit: Fit) -> Split {
    let t = _stretched(cos_i, fit.rows[0].w);
    let u = 2.0 * t - 1.0;
    var sum = fit.rows[7].xyz;
    sum = sum * u + fit.rows[6].xyz;
    sum = sum * u + fit.rows[5].xyz;
    sum = sum * u + fit.rows[4].xyz;
    sum = sum * u + fit.rows[3].xyz;
    sum = sum * u + fit.rows[2].xyz;
    sum = sum * u + fit.rows[1].xyz;
    sum = sum * u + fit.rows[0].xyz;
    return _split(t, sum);
}

// The same of degree 12.
fn evaluate_fine(cos_i: f32, fit: FineFit) -> Split {
    let t = _stretched(cos_i, fit.rows[0].w);
    let u = 2.0 * t - 1.0;
    var sum = fit.rows[11].xyz;
    sum = sum * u + fit.rows[10].xyz;
    sum = sum * u + fit.rows[9].xyz;
    sum = sum * u + fit.rows[8].xyz;
    sum = sum * u + fit.rows[7].xyz;
    sum = sum * u + fit.rows[6].xyz;
    sum = sum * u + fit.rows[5].xyz;
    sum = sum * u + fit.rows[4].xyz;
    sum = sum * u + fit.rows[3].xyz;
    sum = sum * u + fit.rows[2].xyz;
    sum = sum * u + fit.rows[1].xyz;
    sum = sum * u + fit.rows[0].xyz;
    return _split(t, sum);
}

// t = c(1+b)/(c+b).
fn _stretched(cos_i: f32, bend: f32) -> f32 {
    return cos_i * (1.0 + bend) / (cos_i + bend);
}

fn _split(t: f32, polynomial: vec3f) -> Split {
    let transmittance = clamp(t * polynomial, vec3f(0.0), vec3f(1.0));
    return Split(1.0 - transmittance, transmittance);
}
