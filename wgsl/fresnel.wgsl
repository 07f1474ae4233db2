// Fresnel reflectance and transmittance of unpolarised light. Twin of src/fresnel.rs, which documents each function.

import package::real;

struct Fresnel {
    reflectance: f32,
    transmittance: f32,
}

// Exact dielectric; cos_i in [0, 1], eta = n_t/n_i.
fn dielectric(cos_i: f32, eta: f32) -> Fresnel {
    let c = cos_i;
    let g_squared = refracted_square(c, eta);
    let g = sqrt(max(g_squared, 0.0));
    let matched = c + g <= 0.0;
    let total = g_squared < 0.0;
    // The differences c-g and eta²c-g are quotients that do not cancel: (c-g)(c+g) = 1-eta².
    let one = (eta - 1.0) * (eta + 1.0);
    let eta_squared = eta * eta;
    let sum_s = select((c + g) * (c + g), 1.0, matched);
    let root_p = eta_squared * c + g;
    let sum_p = select(root_p * root_p, 1.0, matched);
    let rs = one / sum_s;
    // (eta²c-g)(eta²c+g), which vanishes at Brewster's angle: for small eta that is close to the critical angle, where
    // sum_p is small, while F is far from 0 and the difference itself exact enough.
    let product = one * (eta_squared * c * c - (1.0 - c) * (1.0 + c));
    let difference = (eta_squared * c - g) * (eta_squared * c + g);
    let rp = select(product, difference, eta < 0.7) / sum_p;
    let transmittance = 2.0 * c * g * (1.0 / sum_s + eta_squared / sum_p);
    return Fresnel(
        select(0.5 * (rs * rs + rp * rp), 1.0, total),
        select(select(transmittance, 1.0, matched), 0.0, total));
}

// cos_i² + eta² - 1, eta² times the squared cosine of the refracted ray; negative on total reflection.
fn refracted_square(cos_i: f32, eta: f32) -> f32 {
    let c = real::product_exact(cos_i, cos_i);
    let e = real::product_exact(eta, eta);
    // Where the sum cancels, the larger square is in [1/2, 1]: both differences are exact there (Sterbenz).
    let sum = (max(c.x, e.x) - 1.0) + min(c.x, e.x);
    let fine = real::sum_exact(c.y, e.y);
    return (sum + fine.x) + fine.y;
}

// Exact conductor with the relative index n + ik; k = 0 is a dielectric.
fn conductor(cos_i: f32, n: f32, k: f32) -> Fresnel {
    let c = cos_i;
    let e_one = (n - 1.0) * (n + 1.0) - k * k;
    // e_one+c², which vanishes at the critical angle of k = 0.
    let re = refracted_square(c, n) - k * k;
    let nk = n * k;
    let modulus = sqrt(re * re + 4.0 * nk * nk);
    let larger = sqrt(0.5 * (modulus + abs(re)));
    let smaller = nk / select(1.0, larger, larger > 0.0);
    let above = re >= 0.0;
    let a = select(smaller, larger, above);
    let b = select(larger, smaller, above);
    let b_squared = b * b;

    let square = (a + c) * (a + c) + b_squared;
    let matched = square <= 0.0;
    let sum = select(square, 1.0, matched);
    // a-c without cancellation: (a-c)(a+c) = e_one+b². Where b >= a the quotient would magnify the rounding of b² at
    // small a+c, and b² drowns what a-c loses.
    let quotient = (e_one + b_squared) / select(1.0, a + c, above && !matched);
    let difference = select(a - c, quotient, above);
    let s_squared = (1.0 - c) * (1.0 + c);
    let ac = a * c;
    let bc_squared = b_squared * c * c;
    let sum_q = (ac + s_squared) * (ac + s_squared) + bc_squared;
    let fs = (difference * difference + b_squared) / sum;
    let fq = ((ac - s_squared) * (ac - s_squared) + bc_squared) / sum_q;
    let ts = 4.0 * ac / sum;
    let tq = 4.0 * ac * s_squared / sum_q;
    return Fresnel(0.5 * fs * (1.0 + fq), select(ts + 0.5 * tq * (1.0 - ts), 1.0, matched));
}

// Mihaylov 2013, eq. 3.6: a conductor with |n+ik|² much larger than 1.
fn conductor_approx(cos_i: f32, n: f32, k: f32) -> f32 {
    let c = cos_i;
    let k_squared = k * k;
    let kc_squared = k_squared * c * c;
    let s = ((n - c) * (n - c) + k_squared) / ((n + c) * (n + c) + k_squared);
    // nc-1 without the rounding of nc: what is left to cancel is small beside s.
    let difference = (n - 1.0) * c - (1.0 - c);
    let p = (difference * difference + kc_squared) / ((n * c + 1.0) * (n * c + 1.0) + kc_squared);
    return 0.5 * (s + p);
}

// ((n-1)²+k²)/((n+1)²+k²).
fn normal_incidence(n: f32, k: f32) -> f32 {
    let k_squared = k * k;
    return ((n - 1.0) * (n - 1.0) + k_squared) / ((n + 1.0) * (n + 1.0) + k_squared);
}

// Schlick 1994, from the reflectance at normal incidence.
fn schlick(cos_i: f32, f0: f32) -> Fresnel {
    let q = 1.0 - cos_i;
    let q_squared = q * q;
    let rest = 1.0 - f0;
    return Fresnel(
        f0 + rest * (q_squared * q_squared * q),
        rest * cos_i * ((1.0 + q) * (1.0 + q_squared) + q_squared * q_squared));
}

// Schlick 1994, from the two indices of a dielectric interface.
fn schlick_from_indices(cos_i: f32, n_i: f32, n_t: f32) -> Fresnel {
    let r = (n_t - n_i) / (n_t + n_i);
    return schlick(cos_i, r * r);
}

// Lazányi & Szirmay-Kalos 2005, eq. 5.
fn lazanyi_uncorrected(cos_i: f32, n: f32, k: f32) -> f32 {
    let q = 1.0 - cos_i;
    let q_squared = q * q;
    let k_squared = k * k;
    return ((n - 1.0) * (n - 1.0) + 4.0 * n * (q_squared * q_squared * q) + k_squared)
        / ((n + 1.0) * (n + 1.0) + k_squared);
}

// Lazányi & Szirmay-Kalos 2005, eq. 6.
fn lazanyi(cos_i: f32, n: f32, k: f32, a: f32, exponent: f32) -> f32 {
    let inside = cos_i < 1.0;
    let power = select(0.0, exp(exponent * real::ln_one_plus(select(0.0, -cos_i, inside))), inside);
    return max(lazanyi_uncorrected(cos_i, n, k) - a * cos_i * power, 0.0);
}

// Schlick's approximation with a tint at 82°.
fn f82_tint(cos_i: f32, f0: f32, tint: f32) -> f32 {
    let q = 1.0 - cos_i;
    let q_squared = q * q;
    // (6/7)⁵ and 1/(1/7·(6/7)⁶).
    let dip = (f0 + (1.0 - f0) * (7776.0 / 16807.0)) * (1.0 - tint) * (823543.0 / 46656.0);
    let base = f0 + (1.0 - f0) * (q_squared * q_squared * q);
    return max(base - dip * cos_i * (q_squared * q_squared * q_squared), 0.0);
}
