//! The stages that a plan is made of, each one step of one evaluation over any number type.
//!
//! A [`Ray`] walks through them. Its cosines are *optical*: n·cosθ of the medium that it is in, so that refraction about the
//! macro normal leaves the tangential components alone and turns n·cosθ into √(n²cos²θ + Δn²), from the directions given
//! and without a chain of rounding errors. f has no 1/n² then, and the visibility no n²: they cancel.
//!
//! In f32 the exponent of Beckmann's distribution is what loses digits. tan² is carried as a number and what rounding took
//! from it, from the half vector's rounding on; not over f64, whose digits suffice ([`Real::CARRIES`]).

use super::interface::{Reflects, Transmits};
use crate::diffuse;
use crate::frame::Vector;
use crate::real::Real;
use crate::twofold::Twofold;

/// One evaluation on its way down the stack, over `K` channels that share their directions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray<W, const K: usize> {
    /// n·cosθ of both directions in the present medium; both 1 where nothing arrives.
    pub(crate) cos_i: W,
    pub(crate) cos_o: W,
    /// What is left of their squares past the roots'.
    pub(crate) rest: (W, W),
    /// Their sum, n·hz of the half vector.
    pub(crate) h_z: W,
    /// (n·VH)², a quarter of the squared length of the half vector times n².
    pub(crate) half_squared: W,
    /// tan² of the half vector's angle with the normal, and what its rounding took.
    pub(crate) tan: (W, W),
    /// hx²+hy², and what its rounding took.
    pub(crate) across: (W, W),
    /// The share of what the present interface reflects that gets in and out again; 0 where nothing arrives.
    pub(crate) weight: [W; K],
    /// What has been reflected so far.
    pub(crate) f: [W; K],
}

/// Cosines below this count as the horizon: their squares are not normal numbers in f32.
const HORIZON: f64 = 1e-18;

impl<W: Real<Wide = W>, const K: usize> Ray<W, K> {
    /// The ray of two directions above the stack.
    #[inline(always)]
    pub(crate) fn new(wi: Vector<W>, wo: Vector<W>) -> Self {
        let lit = wi.z.gt(W::from_f64(HORIZON)) & wo.z.gt(W::from_f64(HORIZON));
        let (cos_i, cos_o) = (W::select(lit, wi.z, W::ONE), W::select(lit, wo.z, W::ONE));
        let (x, y) = (Twofold::sum(wi.x, wo.x), Twofold::sum(wi.y, wo.y));
        let (xx, yy) = (Twofold::square(x.high), Twofold::square(y.high));
        let across = Twofold::sum(xx.high, yy.high);
        let lost = if W::CARRIES {
            let mixed = x.high.mul_add(x.low, y.high * y.low);
            ((mixed + mixed) + (xx.low + yy.low)) + across.low
        } else {
            W::ZERO
        };
        let mut ray = Ray {
            cos_i,
            cos_o,
            rest: (W::ZERO, W::ZERO),
            h_z: W::ZERO,
            half_squared: W::ZERO,
            tan: (W::ZERO, W::ZERO),
            across: (across.high, lost),
            weight: [W::select(lit, W::ONE, W::ZERO); K],
            f: [W::ZERO; K],
        };
        let h_z = cos_i + cos_o;
        let rounding = if W::CARRIES { ray.sum_lost(h_z) } else { W::ZERO };
        ray.aim(h_z, rounding);
        ray
    }

    /// Nothing, for a start.
    pub(crate) fn dark() -> Self {
        let zero = W::ZERO;
        Ray {
            cos_i: zero,
            cos_o: zero,
            rest: (zero, zero),
            h_z: zero,
            half_squared: zero,
            tan: (zero, zero),
            across: (zero, zero),
            weight: [zero; K],
            f: [zero; K],
        }
    }

    /// Takes the half vector's height, as a number and what its rounding took.
    #[inline(always)]
    fn aim(&mut self, h_z: W, lost: W) {
        let (across, across_lost) = self.across;
        let z_squared = Twofold::square(h_z);
        self.tan = if W::CARRIES {
            let z_lost = (h_z + h_z).mul_add(lost, z_squared.low);
            let inverse = W::ONE / z_squared.high;
            let tan = across * inverse;
            // What is left of the division, and what the parts had lost.
            let rest = tan.remainder(z_squared.high, across) + tan.remainder(z_lost, across_lost);
            (tan, rest * inverse)
        } else {
            (across / z_squared.high, W::ZERO)
        };
        self.h_z = h_z;
        self.half_squared = W::from_f64(0.25) * h_z.mul_add(h_z, across);
    }

    /// What rounding took from the two roots that the cosines are, (i_rest/i + o_rest/o)/2, times both.
    #[inline(always)]
    fn roots_lost(&self) -> W {
        W::HALF * self.rest.0.mul_add(self.cos_o, self.rest.1 * self.cos_i)
    }

    /// What rounding took from the sum of the cosines.
    #[inline(always)]
    fn sum_lost(&self, h_z: W) -> W {
        self.cos_i.min(self.cos_o) - (h_z - self.cos_i.max(self.cos_o))
    }

    /// n·VH, at most n.
    #[inline(always)]
    pub(crate) fn half(&self, n: W) -> (W, W) {
        let squared = self.half_squared.min(n * n);
        (squared, squared.sqrt())
    }

    /// True where something still gets to the present interface.
    #[inline(always)]
    pub(crate) fn arrives(&self) -> W::Mask {
        let mut most = W::ZERO;
        for channel in 0..K {
            most = most.max(self.weight[channel]);
        }
        most.gt(W::ZERO)
    }

    /// Ends the ray where it may not go on.
    #[inline(always)]
    fn stop_unless(&mut self, goes_on: W::Mask) {
        for channel in 0..K {
            self.weight[channel] = W::select(goes_on, self.weight[channel], W::ZERO);
        }
    }
}

/// What a rough interface reflects: Beckmann's distribution under V-cavities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lobe {
    /// 1/α².
    pub(crate) inverse_square: f64,
    /// 1/(4πα²), times what f is scaled by.
    pub(crate) scale: f64,
    /// The index of the medium above.
    pub(crate) n_above: f64,
}

impl Lobe {
    /// The lobe of width `alpha` under the index `n_above`. `compressed` where refraction compresses radiance by 1/n².
    pub(crate) fn new(alpha: f64, n_above: f64, compressed: bool) -> Self {
        let inverse_square = 1.0 / (alpha * alpha);
        let scale = 0.25 * core::f64::consts::FRAC_1_PI * inverse_square;
        Lobe { inverse_square, scale: if compressed { scale } else { scale * n_above * n_above }, n_above }
    }

    /// The width.
    pub(crate) fn alpha(&self) -> f64 {
        1.0 / self.inverse_square.sqrt()
    }

    /// Adds what the interface reflects.
    #[inline(always)]
    pub(crate) fn reflect<W: Real<Wide = W>, const K: usize>(&self, ray: &mut Ray<W, K>, fresnel: &impl Reflects<K>) {
        let (tan, lost) = ray.tan;
        let inverse_square = W::from_f64(self.inverse_square);
        let product = Twofold::product(tan, inverse_square);
        let exponent = product.high;
        let inside = exponent.le(W::EXP_LIMIT);
        let mut exponential = (-exponent).exp_within();
        if W::CARRIES {
            let inverse_lost = W::from_f64(self.inverse_square - inverse_square.to_f64());
            let rounding = tan.mul_add(inverse_lost, lost.mul_add(inverse_square, product.low));
            exponential = exponential.remainder(rounding, exponential);
        }
        let secant = W::ONE + tan;
        let d = W::select(inside, (secant * secant) * (exponential * W::from_f64(self.scale)), W::ZERO);

        let (least, most) = (ray.cos_i.min(ray.cos_o), ray.cos_i.max(ray.cos_o));
        let cavity = most * (least * ray.h_z).max(ray.half_squared);
        let visible = d * ray.h_z;
        let n_above = W::from_f64(self.n_above);
        let (half_squared, half) = ray.half(n_above);
        let fractions = fresnel.reflectance(half_squared, half, n_above * n_above - half_squared);
        for channel in 0..K {
            let (numerator, denominator) = fractions[channel];
            ray.f[channel] =
                (ray.weight[channel] * visible).mul_add(numerator / (denominator * cavity), ray.f[channel]);
        }
    }

    /// G, which the documents' models let internal reflection depend on.
    #[inline(always)]
    fn masking<W: Real<Wide = W>, const K: usize>(ray: &Ray<W, K>) -> W {
        (ray.cos_i.min(ray.cos_o) * ray.h_z / ray.half_squared).min(W::ONE)
    }
}

/// The way through an interface, in and out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Passage {
    /// n of the medium below.
    pub(crate) n: f64,
    /// n² − 1.
    pub(crate) excess: f64,
    /// n² of the medium below less that of the one above.
    pub(crate) step: f64,
    /// The index above.
    pub(crate) n_above: f64,
}

impl Passage {
    pub(crate) fn new(n_above: f64, n: f64) -> Self {
        Passage { n, excess: (n - 1.0) * (n + 1.0), step: (n - n_above) * (n + n_above), n_above }
    }

    /// Refracts both directions about the macro normal; `top` are their cosines above the stack. What they were is returned.
    #[inline(always)]
    fn refract<W: Real<Wide = W>, const K: usize>(&self, ray: &mut Ray<W, K>, top: (W, W)) -> (W, W) {
        let before = (ray.cos_i, ray.cos_o);
        let (i, i_squared, i_rest) = self.below(top.0);
        let (o, o_squared, o_rest) = self.below(top.1);
        let goes_on = i_squared.gt(W::ZERO) & o_squared.gt(W::ZERO);
        ray.stop_unless(goes_on);
        let (i, o) = (W::select(goes_on, i, W::ONE), W::select(goes_on, o, W::ONE));
        (ray.cos_i, ray.cos_o) = (i, o);
        let h_z = i + o;
        let lost = if W::CARRIES {
            ray.rest = (W::select(goes_on, i_rest, W::ZERO), W::select(goes_on, o_rest, W::ZERO));
            ray.roots_lost() / (i * o) + ray.sum_lost(h_z)
        } else {
            W::ZERO
        };
        ray.aim(h_z, lost);
        before
    }

    /// n·cosθ below of a direction with this cosine above the stack, its square, and what is left of the square past the root's.
    #[inline(always)]
    fn below<W: Real<Wide = W>>(&self, cos: W) -> (W, W, W) {
        let excess = W::from_f64(self.excess);
        let square = Twofold::square(cos);
        let sum = Twofold::sum(square.high, excess);
        let root = sum.high.max(W::ZERO).sqrt();
        let rest = if W::CARRIES {
            let excess_lost = W::from_f64(self.excess - excess.to_f64());
            root.remainder(root, sum.high) + (sum.low + (square.low + excess_lost))
        } else {
            W::ZERO
        };
        (root, sum.high, rest)
    }

    /// The energy-conserving way: the transmittance of either direction.
    #[inline(always)]
    pub(crate) fn conserve<W: Real<Wide = W>, const K: usize>(
        &self,
        ray: &mut Ray<W, K>,
        top: (W, W),
        fresnel: &impl Transmits<K>,
    ) {
        let (above_i, above_o) = self.refract(ray, top);
        let through = fresnel.transmittance([(above_i, ray.cos_i), (above_o, ray.cos_o)]);
        for channel in 0..K {
            ray.weight[channel] = ray.weight[channel] * through[channel];
        }
    }

    /// What the documents let through: T·t, both at V·H.
    #[inline(always)]
    fn documents<W: Real<Wide = W>, const K: usize>(&self, ray: &mut Ray<W, K>, fresnel: &impl Transmits<K>) {
        let n_above = W::from_f64(self.n_above);
        let (_, half) = ray.half(n_above);
        let g = Lobe::masking(ray);
        let transmitted = fresnel.at(half / n_above);
        for channel in 0..K {
            let t = transmitted[channel];
            ray.weight[channel] = ray.weight[channel] * (t * ((W::ONE - g) + t * g));
        }
    }

    /// The documents' way, refracted about the macro normal.
    #[inline(always)]
    pub(crate) fn elek<W: Real<Wide = W>, const K: usize>(
        &self,
        ray: &mut Ray<W, K>,
        top: (W, W),
        fresnel: &impl Transmits<K>,
    ) {
        self.documents(ray, fresnel);
        self.refract(ray, top);
    }

    /// Weidlich and Wilkie's way, refracted about the half vector: its direction stays, n·VH changes.
    #[inline(always)]
    pub(crate) fn weidlich_wilkie<W: Real<Wide = W>, const K: usize>(
        &self,
        ray: &mut Ray<W, K>,
        fresnel: &impl Transmits<K>,
    ) {
        self.documents(ray, fresnel);
        let n_above = W::from_f64(self.n_above);
        let (squared, half) = ray.half(n_above);
        let below_squared = squared + W::from_f64(self.step);
        let below = below_squared.max(W::ZERO).sqrt();
        let ratio = below / half;
        // m·(n′cosθ′ − n·cosθ), with m = h/(2·n·VH).
        let lift = W::HALF * ray.h_z * (ratio - W::ONE);
        let (i, o) = (ray.cos_i + lift, ray.cos_o + lift);
        let goes_on = below_squared.gt(W::ZERO) & i.gt(W::ZERO) & o.gt(W::ZERO);
        ray.stop_unless(goes_on);
        ray.cos_i = W::select(goes_on, i, W::ONE);
        ray.cos_o = W::select(goes_on, o, W::ONE);
        ray.h_z = W::select(goes_on, ray.h_z * ratio, W::TWO);
        ray.half_squared = W::select(goes_on, below_squared, W::ONE);
    }
}

/// The medium between two interfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Absorption<const K: usize> {
    /// n·σ·d for each channel.
    pub(crate) depth: [f64; K],
}

impl<const K: usize> Absorption<K> {
    /// Takes what both ways absorb.
    #[inline(always)]
    pub(crate) fn absorb<W: Real<Wide = W>>(&self, ray: &mut Ray<W, K>) {
        // 1/cosθi + 1/cosθo, and what its rounding took: up to 87 times as much is lost to the exponential.
        let product = Twofold::product(ray.cos_i, ray.cos_o);
        let inverse = W::ONE / product.high;
        let path = ray.h_z * inverse;
        let lost = if W::CARRIES {
            let sum_low = ray.roots_lost() * inverse + ray.sum_lost(ray.h_z);
            // (o²·i_rest + i²·o_rest)/(2io).
            let squares = ray.rest.0.mul_add(ray.cos_o * ray.cos_o, ray.rest.1 * (ray.cos_i * ray.cos_i));
            let product_low = (W::HALF * inverse).mul_add(squares, product.low);
            (path.remainder(product.high, ray.h_z) + path.remainder(product_low, sum_low)) * inverse
        } else {
            W::ZERO
        };
        for channel in 0..K {
            let depth = W::from_f64(self.depth[channel]);
            let through = if W::CARRIES {
                let depth_lost = W::from_f64(self.depth[channel] - depth.to_f64());
                let through = W::exp_product(depth, path);
                through.remainder(depth.mul_add(lost, depth_lost * path), through)
            } else {
                (-(depth * path)).exp()
            };
            ray.weight[channel] = ray.weight[channel] * through;
        }
    }
}

/// The opaque base of a stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Base<const K: usize> {
    pub(crate) albedo: [f64; K],
    /// The deviation of its slopes; Lambert's at 0.
    pub(crate) sigma: f64,
    /// The index of the medium above.
    pub(crate) n_above: f64,
    /// Whether refraction compresses radiance by 1/n².
    pub(crate) compressed: bool,
}

impl<const K: usize> Base<K> {
    /// What f is multiplied with: 1/n² or 1.
    pub(crate) fn scale(&self) -> f64 {
        if self.compressed { 1.0 / (self.n_above * self.n_above) } else { 1.0 }
    }

    /// Adds what Lambert's base reflects.
    #[inline(always)]
    pub(crate) fn lambert<W: Real<Wide = W>>(&self, ray: &mut Ray<W, K>) {
        for channel in 0..K {
            let f = self.albedo[channel] * self.scale() * core::f64::consts::FRAC_1_PI;
            ray.f[channel] = ray.weight[channel].mul_add(W::from_f64(f), ray.f[channel]);
        }
    }

    /// Adds what Oren and Nayar's base reflects. `wi` and `wo` are the directions above the stack; `about_half` where they
    /// were refracted about the half vector.
    #[inline(always)]
    pub(crate) fn oren_nayar<W: Real<Wide = W>>(
        &self,
        ray: &mut Ray<W, K>,
        wi: Vector<W>,
        wo: Vector<W>,
        about_half: bool,
    ) {
        let inverse = W::from_f64(1.0 / self.n_above);
        let lit = ray.arrives();
        let h = wi + wo;
        let bend = if about_half {
            // m·(n·cosθ − cosθ above the stack), with m = h/|h|.
            let length = W::HALF * W::select(lit, h.length_squared(), W::ONE).sqrt();
            W::HALF * (ray.half_squared.sqrt() - length) / length
        } else {
            W::ZERO
        };
        let wi = below(wi, h, bend, inverse, ray.cos_i, lit);
        let wo = below(wo, h, bend, inverse, ray.cos_o, lit);
        let base = diffuse::oren_nayar_wide::<_, W>(wi, wo, W::from_f64(self.sigma));
        for channel in 0..K {
            let albedo = W::from_f64(self.albedo[channel]);
            let f = base.f(albedo) * W::from_f64(self.scale());
            ray.f[channel] = ray.weight[channel].mul_add(f, ray.f[channel]);
        }
    }
}

/// A direction in the medium above the base, of its cosine there; the normal where nothing arrives.
#[inline(always)]
fn below<W: Real<Wide = W>>(w: Vector<W>, h: Vector<W>, bend: W, inverse: W, cos: W, lit: W::Mask) -> Vector<W> {
    Vector::new(
        W::select(lit, h.x.mul_add(bend, w.x) * inverse, W::ZERO),
        W::select(lit, h.y.mul_add(bend, w.y) * inverse, W::ZERO),
        W::select(lit, cos * inverse, W::ONE),
    )
}
