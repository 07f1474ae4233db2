//! The functions that specialised modules call: the parts of a stage that are worth a name, over a number or over the vector
//! of all channels. Constants come last among the parameters.

use alloc::format;
use alloc::string::String;

/// A function of specialised modules.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Helper {
    pub(super) name: &'static str,
    /// Its text, with `Fn` for its name and `Channels` for the type of what may differ between channels.
    text: &'static str,
}

impl Helper {
    /// Its name over a number or over a vector.
    pub(super) fn full_name(&self, wide: bool) -> String {
        format!("plan_{}{}", self.name, if wide { "_rgb" } else { "" })
    }

    pub(super) fn text(&self, wide: bool) -> String {
        self.text.replace("Fn", &self.full_name(wide)).replace("Channels", if wide { "vec3f" } else { "f32" })
    }
}

/// `Lobe::reflect`, D·G/(4·cosθ·cosθ): without a product that f32 does not hold at grazing.
pub(super) const LOBE: Helper = Helper {
    name: "lobe",
    text: "\
// Beckmann's distribution under V-cavities; edge: VH²/hz.
fn Fn(tan_squared: f32, edge: f32, cos_i: f32, cos_o: f32, inverse_square: f32, scale: f32) -> f32 {
    let exponent = tan_squared * inverse_square;
    let inside = exponent <= exp_limit;
    let power = exp(-select(0.0, exponent, inside));
    let secant = 1.0 + tan_squared;
    let cavity = max(cos_i, cos_o) * max(min(cos_i, cos_o), edge);
    return select(0.0, (secant * secant) * (power * scale) / cavity, inside);
}
",
};

/// `Metal::fraction`.
pub(super) const METAL: Helper = Helper {
    name: "metal",
    text: "\
// F of a conductor with k > n that is bright.
fn Fn(vh_squared: f32, vh: f32, above: f32, half_real: Channels, product_squared: Channels, twice_product: Channels) -> Channels {
    let real = 0.5 * vh_squared + half_real;
    let larger = sqrt(real * real + product_squared) - real;
    let cross = (twice_product * vh) * sqrt(larger);
    let squares = larger * larger + product_squared;
    let s_squared = above - vh_squared;
    let mean_s = larger * vh_squared + squares;
    let mean_q = squares * vh_squared + larger * (s_squared * s_squared);
    return ((mean_s - cross) * mean_q) / ((mean_s + cross) * (cross * s_squared + mean_q));
}
",
};

/// `Conductor::fraction`.
pub(super) const CONDUCTOR: Helper = Helper {
    name: "conductor",
    text: "\
// F of a conductor that reflects enough.
fn Fn(vh_squared: f32, vh: f32, above: f32, offset: Channels, product: Channels, twice_product_squared: Channels) -> Channels {
    let real = vh_squared + offset;
    let larger = 0.5 * (sqrt(real * real + twice_product_squared) + abs(real));
    let root = sqrt(larger);
    let below = real < Channels(0.0);
    let p = select(larger, product, below);
    let q = select(product, larger, below);
    let q_squared = q * q;
    let shift = vh * root;
    let difference = p - shift;
    let sum = p + shift;
    let pc = p * vh;
    let qc = q_squared * vh_squared;
    let slant = (above - vh_squared) * root;
    let tilted = pc + slant;
    let numerator = (difference * difference + q_squared) * (pc * pc + slant * slant + qc);
    return numerator / ((sum * sum + q_squared) * (tilted * tilted + qc));
}
",
};

/// `Dielectric`'s reflectance: E²/2·(1/S² + q²/P²), of one division.
pub(super) const DIELECTRIC: Helper = Helper {
    name: "dielectric",
    text: "\
// F of a denser dielectric; square, above: its index and the one above, squared; step: their difference.
fn Fn(vh_squared: f32, vh: f32, step: f32, square: f32, above: f32) -> f32 {
    let below = sqrt(vh_squared + step);
    let root_s = vh + below;
    let root_p = square * vh + above * below;
    let s = root_s * root_s;
    let p = root_p * root_p;
    let ratio = step / (s * p);
    let rs = ratio * p;
    let rp = ratio * s * (square * vh_squared - above * (above - vh_squared));
    return 0.5 * (rs * rs + rp * rp);
}
",
};

/// `Dielectric::fraction`.
pub(super) const TRANSMITTED: Helper = Helper {
    name: "transmitted",
    text: "\
// T of a denser dielectric, of optical cosines above and below it; square, above_squared: its index and the one above, squared;
// both: their product.
fn Fn(above: f32, below: f32, square: f32, above_squared: f32, both: f32) -> f32 {
    let root_s = above + below;
    let root_p = square * above + above_squared * below;
    let s = root_s * root_s;
    let p = root_p * root_p;
    return 2.0 * (above * below) * (p + both * s) / (s * p);
}
",
};

/// `Fit::transmittance_wide`, but for the polynomial.
pub(super) const STRETCHED: Helper = Helper {
    name: "stretched",
    text: "\
// The variable of a fitted Fresnel term.
fn Fn(cos_i: f32, bend: f32, one_plus_bend: f32) -> f32 {
    return cos_i * one_plus_bend / (cos_i + bend);
}
",
};

/// `Passage::documents`.
pub(super) const INTERNAL: Helper = Helper {
    name: "internal",
    text: "\
// T·t, t = (1-G) + T·G.
fn Fn(transmitted: Channels, cos_i: f32, cos_o: f32, edge: f32) -> Channels {
    let g = min(min(cos_i, cos_o) / edge, 1.0);
    return transmitted * ((1.0 - g) + transmitted * g);
}
",
};

/// `Absorption::absorb`.
pub(super) const ABSORBED: Helper = Helper {
    name: "absorbed",
    text: "\
// What a medium of this optical depth lets through.
fn Fn(path: f32, depth: Channels) -> Channels {
    let exponent = depth * path;
    let inside = exponent <= Channels(exp_limit);
    return select(Channels(0.0), exp(-select(Channels(0.0), exponent, inside)), inside);
}
",
};

/// `Base::oren_nayar`.
pub(super) const BASE: Helper = Helper {
    name: "base",
    text: "\
// f of a rough base; share: its albedo over pi, scaled.
fn Fn(base: diffuse::OrenNayar, albedo: Channels, share: Channels) -> Channels {
    return max(share * (base.direct + albedo * base.interreflection), Channels(0.0));
}
",
};
