//! Deterministic inputs: a corner lattice, then a low-discrepancy sequence.

use crate::frame::Vector;

/// How many of the samples come from the corner lattice: one in four.
const CORNER_SHARE: u64 = 4;

/// One sample's source of numbers. Every call of a method takes the next dimension of the sample.
#[derive(Clone, Copy, Debug)]
pub struct Draw {
    index: u64,
    dimension: u32,
    corner: bool,
}

/// Cosines from normal incidence to 1e-7.
const COSINES: [f64; 10] = [1.0, 0.999_999_9, 0.999, 0.707_106_77, 0.5, 0.1, 1e-2, 1e-4, 1e-6, 1e-7];
const RATIOS: [f64; 10] = [1.0, 1.000_000_1, 0.999_999_9, 1.000_29, 1.5, 0.666_666_7, 1.33, 2.42, 4.0, 0.25];
const EXTINCTIONS: [f64; 7] = [0.0, 1e-6, 1e-3, 0.2, 1.0, 4.05, 12.0];
const WIDTHS: [f64; 7] = [1e-4, 1e-3, 0.01, 0.1, 0.3, 0.7, 1.0];
const AZIMUTHS: [f64; 6] = [0.0, 0.5, 1.0, 0.25, 0.05, 0.77];

impl Draw {
    /// The `index`-th sample.
    pub fn new(index: u64) -> Self {
        Draw { index, dimension: 0, corner: index.is_multiple_of(CORNER_SHARE) }
    }

    /// The next number of the Kronecker sequence with the square roots of the primes, in [0, 1).
    pub fn unit(&mut self) -> f64 {
        const PRIMES: [f64; 16] =
            [2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0, 41.0, 43.0, 47.0, 53.0];
        let step = PRIMES[self.dimension as usize % PRIMES.len()].sqrt().fract();
        self.dimension += 1;
        (0.5 + self.index as f64 * step).fract()
    }

    /// A corner from the list, on samples of the lattice.
    fn corner(&mut self, corners: &[f64]) -> Option<f64> {
        self.corner.then(|| corners[self.hash() as usize % corners.len()])
    }

    /// A number that walks the lattice without favouring any of its planes (SplitMix64).
    fn hash(&mut self) -> u64 {
        self.dimension += 1;
        let mut z = self.index.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ u64::from(self.dimension) << 32;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) >> 8
    }

    /// Uniform between two numbers, or a corner.
    fn linear(&mut self, low: f64, high: f64, corners: &[f64]) -> f64 {
        let u = self.unit();
        self.corner(corners).unwrap_or(low + (high - low) * u)
    }

    /// Uniform in the logarithm between two numbers, or a corner.
    fn logarithmic(&mut self, low: f64, high: f64, corners: &[f64]) -> f64 {
        let u = self.unit();
        self.corner(corners).unwrap_or(low * (high / low).powf(u))
    }

    /// A cosine in [1e-7, 1].
    pub fn cosine(&mut self) -> f64 {
        self.linear(1e-7, 1.0, &COSINES)
    }
    /// A ratio of indices in [1/4, 4].
    pub fn ratio(&mut self) -> f64 {
        self.logarithmic(0.25, 4.0, &RATIOS)
    }
    /// A cosine and a ratio of indices, in a third of the samples close to the critical angle.
    pub fn cosine_and_ratio(&mut self) -> [f64; 2] {
        let (cosine, ratio, near) = (self.cosine(), self.ratio(), self.unit());
        if ratio < 1.0 && near < 0.33 {
            let critical = (1.0 - ratio * ratio).sqrt();
            // From 1e-7 to 1e-1 off, on either side.
            let offset = 10f64.powf(-7.0 + 6.0 * (near * 100.0).fract());
            let side = if near < 0.165 { 1.0 } else { -1.0 };
            return [(critical + side * offset).clamp(1e-7, 1.0), ratio];
        }
        [cosine, ratio]
    }
    /// The real part of an index in [0.02, 8].
    pub fn index(&mut self) -> f64 {
        self.logarithmic(0.02, 8.0, &[1.0, 1.5, 0.02, 8.0, 0.213, 1.04, 3.84])
    }
    /// The imaginary part of an index in [0, 12].
    pub fn extinction(&mut self) -> f64 {
        self.logarithmic(1e-3, 12.0, &EXTINCTIONS)
    }
    /// The width of a distribution in [1e-4, 1].
    pub fn width(&mut self) -> f64 {
        self.logarithmic(1e-4, 1.0, &WIDTHS)
    }
    /// A number in [0, 1].
    pub fn fraction(&mut self) -> f64 {
        self.linear(0.0, 1.0, &[0.0, 1.0, 0.5, 0.04, 1e-4])
    }
    /// A slope deviation in [0, π/2].
    pub fn deviation(&mut self) -> f64 {
        self.linear(0.0, std::f64::consts::FRAC_PI_2, &[0.0, 0.2, 0.5, 1.0, 1.57])
    }
    /// An exponent of a lobe in [0, 1e5].
    pub fn exponent(&mut self) -> f64 {
        self.logarithmic(0.1, 1e5, &[0.0, 1.0, 10.0, 1e3, 1e5])
    }
    /// A number between two others, on either side of 0.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        self.linear(low, high, &[low, high, 0.5 * (low + high), low + 0.01 * (high - low)])
    }
    /// An absorption coefficient or a thickness, in [0, 20].
    pub fn depth(&mut self) -> f64 {
        self.logarithmic(1e-3, 20.0, &[0.0, 1e-6, 0.5, 3.0, 20.0])
    }
    /// A positive number over six decades.
    pub fn positive(&mut self) -> f64 {
        self.logarithmic(1e-3, 1e3, &[0.0, 1e-6, 1.0, 3.75, 50.0])
    }

    /// A whole number below 2³² that f32 holds exactly.
    pub fn word(&mut self) -> f64 {
        (self.unit() * 16_777_216.0).floor() * if self.corner { 256.0 } else { 1.0 }
    }

    /// A local unit direction above the horizon, from the normal to a cosine of 1e-7.
    pub fn direction(&mut self) -> Vector<f64> {
        let (cosine, azimuth) = (self.cosine(), self.azimuth());
        spherical(cosine, azimuth)
    }

    fn azimuth(&mut self) -> f64 {
        std::f64::consts::TAU * self.linear(0.0, 1.0, &AZIMUTHS)
    }

    /// A half vector of any length whose slope is on the scale of the width: within the lobe or in its tail.
    pub fn half_vector(&mut self, width: f64) -> Vector<f64> {
        let slope = self.logarithmic(1e-3, 8.0, &[0.0, 1e-4, 1.0, 3.0, 6.0]) * width;
        let (azimuth, length) = (self.azimuth(), self.linear(0.05, 2.0, &[1.0, 2.0]));
        let scale = length / (1.0 + slope * slope).sqrt();
        snap(Vector::new(scale * slope * azimuth.cos(), scale * slope * azimuth.sin(), scale))
    }

    /// A pair of directions: independent, equal, mirrored, or mirrored by a microfacet within a lobe of this width.
    pub fn pair(&mut self, width: f64) -> [Vector<f64>; 2] {
        let wi = self.direction();
        let (other, h, kind) = (self.direction(), self.half_vector(width), self.unit());
        let facet = if kind < 0.3 {
            return [wi, other];
        } else if kind < 0.4 {
            return [wi, wi];
        } else if kind < 0.5 {
            Vector::new(0.0, 0.0, 1.0)
        } else {
            h.normalized()
        };
        let wo = facet * (2.0 * wi.dot(facet)) - wi;
        if wo.z >= 1e-7 { [wi, snap(wo)] } else { [wi, other] }
    }
}

/// The unit direction of this cosine and azimuth.
fn spherical(cosine: f64, azimuth: f64) -> Vector<f64> {
    let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
    snap(Vector::new(sine * azimuth.cos(), sine * azimuth.sin(), cosine))
}

/// A vector whose components below 1e-12 are 0: the cosine of π/2 is no direction that a caller means.
fn snap(v: Vector<f64>) -> Vector<f64> {
    let one = |x: f64| if x.abs() < 1e-12 { 0.0 } else { x };
    Vector::new(one(v.x), one(v.y), one(v.z))
}
