//! The Fresnel terms of a plan: constants folded, in the number of channels that differ, each as one fraction so that a
//! division can be shared.
//!
//! Cosines are optical, n·cosθ of the medium above (see [`stage`](super::stage)); c is n·VH. With N + iK the index of the
//! interface's own material and A that of the medium above, every formula is the crate's spec with numerator and denominator
//! multiplied by powers of A.

use crate::fresnel::{self, Fit};
use crate::real::Real;

/// The reflectance of `K` channels, each as numerator and denominator.
pub(crate) trait Reflects<const K: usize> {
    /// Of (n·VH)², n·VH and n² − (n·VH)².
    fn reflectance<W: Real<Wide = W>>(&self, half_squared: W, half: W, rest: W) -> [(W, W); K];
}

/// The transmittance of `K` channels.
pub(crate) trait Transmits<const K: usize> {
    /// The product of both directions'; of each, n·cosθ above the interface and below it.
    fn transmittance<W: Real<Wide = W>>(&self, cosines: [(W, W); 2]) -> [W; K];
    /// Of one cosine, not an optical one.
    fn at<W: Real<Wide = W>>(&self, cos: W) -> [W; K];
}

/// A dielectric that is denser than the medium above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Dielectric {
    /// N² − A².
    pub(crate) step: f64,
    /// N².
    pub(crate) square: f64,
    /// A².
    pub(crate) above: f64,
}

impl Dielectric {
    /// None where the fraction's parts would leave the range of f32, or light may be totally reflected.
    pub(crate) fn new(n: f64, n_above: f64) -> Option<Self> {
        let fits = n > n_above && n <= 30.0 * n_above && (0.03..=30.0).contains(&n_above);
        fits.then_some(Dielectric { step: (n - n_above) * (n + n_above), square: n * n, above: n_above * n_above })
    }

    /// The index relative to the medium above.
    pub(crate) fn eta(&self) -> f64 {
        (self.square / self.above).sqrt()
    }

    /// T of one direction as a fraction: 2ck·(P + N²A²S)/(S·P), S = (c+k)², P = (N²c + A²k)².
    #[inline(always)]
    fn fraction<W: Real<Wide = W>>(&self, (above, below): (W, W)) -> (W, W) {
        let (square, n_above) = (W::from_f64(self.square), W::from_f64(self.above));
        let s = (above + below).squared();
        let p = square.mul_add(above, n_above * below).squared();
        let both = W::from_f64(self.square * self.above);
        (W::TWO * (above * below) * both.mul_add(s, p), s * p)
    }
}

impl<const K: usize> Reflects<K> for Dielectric {
    #[inline(always)]
    fn reflectance<W: Real<Wide = W>>(&self, half_squared: W, half: W, rest: W) -> [(W, W); K] {
        // F = E²/2·(P² + q²S²)/(SP)², q = N²c² − A²(A² − c²).
        let (square, above) = (W::from_f64(self.square), W::from_f64(self.above));
        let below = (half_squared + W::from_f64(self.step)).sqrt();
        let s = (half + below).squared();
        let p = square.mul_add(half, above * below).squared();
        let q = square.mul_add(half_squared, -(above * rest));
        let step = W::from_f64(self.step);
        let qs = q * s;
        let (sp, es) = (s * p, W::HALF * step * step);
        [(es * p.mul_add(p, qs * qs), sp * sp); K]
    }
}

impl<const K: usize> Transmits<K> for Dielectric {
    #[inline(always)]
    fn transmittance<W: Real<Wide = W>>(&self, [i, o]: [(W, W); 2]) -> [W; K] {
        let ((i, i_below), (o, o_below)) = (self.fraction(i), self.fraction(o));
        [(i * o) / (i_below * o_below); K]
    }
    #[inline(always)]
    fn at<W: Real<Wide = W>>(&self, cos: W) -> [W; K] {
        let eta = W::from_f64((self.square / self.above).sqrt());
        [fresnel::dielectric_wide::<_, W>(cos, eta).transmittance; K]
    }
}

/// Any dielectric, by the formula of [`fresnel::dielectric`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AnyDielectric {
    pub(crate) eta: f64,
    pub(crate) n_above: f64,
}

impl<const K: usize> Reflects<K> for AnyDielectric {
    #[inline(always)]
    fn reflectance<W: Real<Wide = W>>(&self, _: W, half: W, _: W) -> [(W, W); K] {
        let cos = half * W::from_f64(1.0 / self.n_above);
        [(fresnel::dielectric_wide::<_, W>(cos, W::from_f64(self.eta)).reflectance, W::ONE); K]
    }
}

impl<const K: usize> Transmits<K> for AnyDielectric {
    #[inline(always)]
    fn transmittance<W: Real<Wide = W>>(&self, cosines: [(W, W); 2]) -> [W; K] {
        let inverse = W::from_f64(1.0 / self.n_above);
        let [(i, _), (o, _)] = cosines;
        let eta = W::from_f64(self.eta);
        let (i, o) =
            (fresnel::dielectric_wide::<_, W>(i * inverse, eta), fresnel::dielectric_wide::<_, W>(o * inverse, eta));
        [i.transmittance * o.transmittance; K]
    }
    #[inline(always)]
    fn at<W: Real<Wide = W>>(&self, cos: W) -> [W; K] {
        [fresnel::dielectric_wide::<_, W>(cos, W::from_f64(self.eta)).transmittance; K]
    }
}

/// A conductor that reflects enough for f32 to hold the difference that its F is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Conductor {
    /// N² − K² − A².
    pub(crate) real: f64,
    /// N·K.
    pub(crate) product: f64,
}

impl Conductor {
    /// The least reflectance at the normal: F loses ½/√F ULP.
    const LEAST: f64 = 0.02;

    /// None for a material whose F would lose digits by this form, or leave the range of f32.
    pub(crate) fn new(n: f64, k: f64, n_above: f64) -> Option<Self> {
        let (eta, kappa) = (n / n_above, k / n_above);
        let real = (eta - 1.0) * (eta + 1.0) - kappa * kappa;
        // |w| ≥ the distance of the real part, real + c², from 0, and ≥ 2ηκ: its root must not cancel.
        let distance = (real.max(-real - 1.0)).max(0.0);
        let steady = distance * distance + (2.0 * eta * kappa).squared() >= 0.01;
        let bright = fresnel::normal_incidence(eta, kappa) >= Self::LEAST;
        let fits = eta <= 100.0 && kappa <= 100.0 && kappa > 0.0 && (0.03..=30.0).contains(&n_above);
        let real = (n - k) * (n + k) - n_above * n_above;
        (steady && bright && fits).then_some(Conductor { real, product: n * k })
    }

    /// The index relative to the medium above, whose index is given.
    pub(crate) fn indices(&self, n_above: f64) -> (f64, f64) {
        indices(self.real, self.product, n_above * n_above)
    }

    /// F as a fraction. With w = (N+iK)² − (A²−c²), l² = (|w| + |Re w|)/2 and p, q the products of l with the real and imaginary
    /// part of √w: Fs = ((p−cl)² + q²)/((p+cl)² + q²), and Fq the same of pc, (A²−c²)l and qc.
    #[inline(always)]
    fn fraction<W: Real<Wide = W>>(&self, half_squared: W, half: W, rest: W) -> (W, W) {
        let product = W::from_f64(self.product);
        let real = half_squared + W::from_f64(self.real);
        let modulus = real.mul_add(real, W::from_f64(4.0 * self.product * self.product)).sqrt();
        let larger = W::HALF * (modulus + real.abs());
        let root = larger.sqrt();
        let below = real.lt(W::ZERO);
        let (p, q) = (W::select(below, product, larger), W::select(below, larger, product));
        let q_squared = q * q;
        let shift = half * root;
        let (difference, sum) = (p - shift, p + shift);
        let pc = p * half;
        let qc = q_squared * half_squared;
        let slant = rest * root;
        let tilted = pc + slant;
        // Half of numerator and denominator of Fq.
        let mean = pc.mul_add(pc, slant.mul_add(slant, qc));
        let numerator = difference.mul_add(difference, q_squared) * mean;
        let denominator = sum.mul_add(sum, q_squared) * tilted.mul_add(tilted, qc);
        (numerator, denominator)
    }
}

/// η and κ of N² − K² − A², N·K and A².
fn indices(real: f64, product: f64, above: f64) -> (f64, f64) {
    let difference = (real + above) / above;
    let sum = (difference * difference + (2.0 * product / above).squared()).sqrt();
    // The larger of the two from the sum, the other from the product: neither cancels.
    let larger = (0.5 * (sum + difference.abs())).sqrt();
    let smaller = product / (above * larger);
    if difference < 0.0 { (smaller, larger) } else { (larger, smaller) }
}

/// A conductor with κ > n that is bright: a metal. The real part of w is negative at every angle, and a few operations go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Metal {
    /// (N² − K² − A²)/2.
    pub(crate) half_real: f64,
    /// N·K.
    pub(crate) product: f64,
}

impl Metal {
    /// The least reflectance at the normal: F loses ½(1 + 1/F) ULP.
    const LEAST: f64 = 0.2;

    /// None where κ ≤ n, or F would lose digits by this form.
    pub(crate) fn new(n: f64, k: f64, n_above: f64) -> Option<Self> {
        let fits = k > n && fresnel::normal_incidence(n / n_above, k / n_above) >= Self::LEAST;
        let Conductor { real, product } = Conductor::new(n, k, n_above)?;
        fits.then_some(Metal { half_real: 0.5 * real, product })
    }

    /// The index relative to the medium above, whose index is given.
    pub(crate) fn indices(&self, n_above: f64) -> (f64, f64) {
        indices(2.0 * self.half_real, self.product, n_above * n_above)
    }

    /// F as a fraction. With L = (|w| − Re w)/2 and x = 2NK·√(c²L): Fs = (B − x)/(B + x), B = c²L + L² + N²K², and Fq the same of
    /// c²(L² + N²K²) + (A²−c²)²L and (A²−c²)x.
    #[inline(always)]
    fn fraction<W: Real<Wide = W>>(&self, half_squared: W, rest: W) -> (W, W) {
        let real = W::HALF.mul_add(half_squared, W::from_f64(self.half_real));
        let product_squared = W::from_f64(self.product * self.product);
        let larger = real.mul_add(real, product_squared).sqrt() - real;
        let cross = W::from_f64(2.0 * self.product) * (half_squared * larger).sqrt();
        let squares = larger.mul_add(larger, product_squared);
        let mean_s = larger.mul_add(half_squared, squares);
        let mean_q = squares.mul_add(half_squared, larger * (rest * rest));
        ((mean_s - cross) * mean_q, (mean_s + cross) * cross.mul_add(rest, mean_q))
    }
}

/// One term for all channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Grey<T>(pub(crate) T);

/// A term for each channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Each<T, const K: usize>(pub(crate) [T; K]);

impl<const K: usize> Reflects<K> for Grey<Metal> {
    #[inline(always)]
    fn reflectance<W: Real<Wide = W>>(&self, half_squared: W, _: W, rest: W) -> [(W, W); K] {
        [self.0.fraction(half_squared, rest); K]
    }
}

impl<const K: usize> Reflects<K> for Each<Metal, K> {
    #[inline(always)]
    fn reflectance<W: Real<Wide = W>>(&self, half_squared: W, _: W, rest: W) -> [(W, W); K] {
        let mut all = [(W::ZERO, W::ONE); K];
        for channel in 0..K {
            all[channel] = self.0[channel].fraction(half_squared, rest);
        }
        all
    }
}

impl<const K: usize> Reflects<K> for Each<Conductor, K> {
    #[inline(always)]
    fn reflectance<W: Real<Wide = W>>(&self, half_squared: W, half: W, rest: W) -> [(W, W); K] {
        let mut all = [(W::ZERO, W::ONE); K];
        for channel in 0..K {
            all[channel] = self.0[channel].fraction(half_squared, half, rest);
        }
        all
    }
}

/// Any conductor, by the formula of [`fresnel::conductor`]; κ = 0 is a dielectric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AnyConductor {
    /// Relative to the medium above.
    pub(crate) eta: f64,
    pub(crate) kappa: f64,
    pub(crate) n_above: f64,
}

impl AnyConductor {
    #[inline(always)]
    fn split<W: Real<Wide = W>>(&self, cos: W) -> fresnel::Fresnel<W> {
        fresnel::conductor_wide::<_, W>(cos, W::from_f64(self.eta), W::from_f64(self.kappa))
    }

    #[inline(always)]
    fn cosine<W: Real<Wide = W>>(&self, optical: W) -> W {
        optical * W::from_f64(1.0 / self.n_above)
    }
}

impl<const K: usize> Reflects<K> for Each<AnyConductor, K> {
    #[inline(always)]
    fn reflectance<W: Real<Wide = W>>(&self, _: W, half: W, _: W) -> [(W, W); K] {
        let mut all = [(W::ZERO, W::ONE); K];
        for channel in 0..K {
            let conductor = &self.0[channel];
            all[channel].0 = conductor.split(conductor.cosine(half)).reflectance;
        }
        all
    }
}

impl<const K: usize> Transmits<K> for Each<AnyConductor, K> {
    #[inline(always)]
    fn transmittance<W: Real<Wide = W>>(&self, [(i, _), (o, _)]: [(W, W); 2]) -> [W; K] {
        let mut all = [W::ZERO; K];
        for channel in 0..K {
            let conductor = &self.0[channel];
            let (i, o) = (conductor.split(conductor.cosine(i)), conductor.split(conductor.cosine(o)));
            all[channel] = i.transmittance * o.transmittance;
        }
        all
    }
    #[inline(always)]
    fn at<W: Real<Wide = W>>(&self, cos: W) -> [W; K] {
        let mut all = [W::ZERO; K];
        for channel in 0..K {
            all[channel] = self.0[channel].split(cos).transmittance;
        }
        all
    }
}

/// The exact term, fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fitted<const K: usize, const N: usize> {
    pub(crate) fit: Fit<K, N>,
    pub(crate) n_above: f64,
}

impl<const K: usize, const N: usize> Reflects<K> for Fitted<K, N> {
    #[inline(always)]
    fn reflectance<W: Real<Wide = W>>(&self, _: W, half: W, _: W) -> [(W, W); K] {
        let transmitted = self.fit.transmittance_wide(half * W::from_f64(1.0 / self.n_above));
        let mut all = [(W::ZERO, W::ONE); K];
        for channel in 0..K {
            all[channel].0 = W::ONE - transmitted[channel];
        }
        all
    }
}

impl<const K: usize, const N: usize> Transmits<K> for Fitted<K, N> {
    #[inline(always)]
    fn transmittance<W: Real<Wide = W>>(&self, [(i, _), (o, _)]: [(W, W); 2]) -> [W; K] {
        let inverse = W::from_f64(1.0 / self.n_above);
        let (i, o) = (self.fit.transmittance_wide(i * inverse), self.fit.transmittance_wide(o * inverse));
        let mut all = [W::ZERO; K];
        for channel in 0..K {
            all[channel] = i[channel] * o[channel];
        }
        all
    }
    #[inline(always)]
    fn at<W: Real<Wide = W>>(&self, cos: W) -> [W; K] {
        self.fit.transmittance_wide(cos)
    }
}
