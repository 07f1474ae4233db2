//! Fresnel reflectance fitted to a material once: a polynomial a channel after one shared division.
//!
//! Twin: `wgsl/fresnel_fit.wgsl`. [`Fit`] is re-exported by [`fresnel`].
//!
//! T of a conductor or dielectric is smooth, but bends so sharply at grazing incidence that polynomials in the cosine
//! converge slowly. In t = c(1+b)/(c+b), which stretches grazing angles, they converge fast: each degree gains a factor of
//! 2 to 4 for metals and more for dielectrics. [`Fit::new`] finds the best b and the polynomials whose largest error is the
//! smallest possible, and measures that error.

use crate::fresnel::{self, Fresnel, golden_section};
use crate::layered::{K_RANGE, N_RANGE};
use crate::real::Real;
use alloc::vec::Vec;
use core::fmt;

/// The exact Fresnel equations of one material, fitted: N multiply-adds a channel, one division for all, no root.
///
/// $$t = \frac{c\,(1+b)}{c+b},\quad T \approx t\,P(2t-1),\quad F = 1-T$$
///
/// In plain text: with t = c(1+b)/(c+b), T = t·P(2t−1) clamped to [0, 1], P a polynomial of N coefficients for each of C
/// channels, and F = 1−T. At c = 0: F = 1 and T = 0 exactly, and T keeps its relative accuracy towards it.
///
/// * `C` channels, three for RGB; `N` coefficients, the degree in t: 8 or 12. [`Fit::new`] takes some 10 ms.
/// * Domain: n in [`N_RANGE`], κ in [`K_RANGE`], relative to a transparent medium. Where F has a kink or a step (n ≤ 1, κ ≈ 0:
///   total reflection) there is no fit.
///
/// Largest error of F, and of T, over the built-in metals and dielectrics of 1.33 to 4: ≤ 2.2e-5 at N = 8 and ≤ 6e-7 at N = 12,
/// where Lazányi's uncorrected form (which is Schlick's) is off by up to .24; each fit's own is [`Fit::max_error`]. Over f32
/// evaluation adds one rounding, ≤ 2⁻²⁵; in f32 throughout, as in WGSL, ≤ 5e-7. Cost of three channels relative to
/// [`fresnel::conductor`]: 1/5.3 at N = 8, 1/4.6 at N = 12; Schlick 1/13, Lazányi 1/17 without and 1/1.3 with its correction.
///
/// Source: Remez 1934; Powell 1981, *Approximation Theory and Methods*, §8. It replaces the tables of Elek 2010 and Mihaylov 2013.
///
/// ```
/// use brdf::fresnel::{self, Fit};
///
/// let (n, k) = ([0.213, 1.04, 1.17], [4.05, 2.59, 2.36]);
/// let copper = Fit::<3, 8>::new(n, k)?;
/// let exact = fresnel::conductor(0.3, n[1], k[1]).reflectance;
/// assert!((copper.reflectance(0.3)[1] - exact).abs() <= copper.max_error[1]);
/// # Ok::<(), fresnel::FitError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit<const C: usize, const N: usize> {
    /// The constant b, shared by all channels.
    pub bend: f64,
    /// The coefficients of P for each power of 2t−1, from 0 up, and each channel.
    pub coefficients: [[f64; C]; N],
    /// The largest |F − exact F| of each channel over c in [0, 1], which is that of T: measured, and rounded up by 0.3 %.
    pub max_error: [f64; C],
}

impl<const C: usize, const N: usize> Fit<C, N> {
    /// Fits all channels of the relative index n + iκ with the largest error over c in [0, 1] as small as it can be.
    ///
    /// # Errors
    /// Where an index is outside [`N_RANGE`] or [`K_RANGE`], or so close to a kink or step of F that the best fit errs by more
    /// than .05.
    pub fn new(n: [f64; C], k: [f64; C]) -> Result<Self, FitError> {
        for channel in 0..C {
            let (n, k) = (n[channel], k[channel]);
            if !(N_RANGE.contains(&n) && K_RANGE.contains(&k)) {
                return Err(FitError::OutOfRange { channel, n, k });
            }
        }
        let worst = |log_bend: f64| {
            let grid = Grid::new(Real::exp(log_bend), SEARCH);
            (0..C).map(|channel| grid.minimax(N, n[channel], k[channel]).1).fold(0.0, f64::max)
        };
        let (low, high) = BENDS;
        let step = (Real::ln(high) - Real::ln(low)) / SCAN as f64;
        let place = |i: usize| Real::ln(low) + step * i as f64;
        let scan: Vec<f64> = (0..=SCAN).map(|i| worst(place(i))).collect();
        let least = scan.iter().fold(f64::INFINITY, |least, error| least.min(*error));
        // The bottom of every valley that may be the deepest.
        let (mut best, mut bend) = (f64::INFINITY, 1.0);
        for (i, error) in scan.iter().enumerate() {
            let beside = scan[i.saturating_sub(1)].min(scan[(i + 1).min(SCAN)]);
            if *error <= beside && *error <= 2.0 * least {
                let bottom = golden_section(place(i) - step, place(i) + step, 16, worst);
                let error = worst(bottom);
                if error < best {
                    (best, bend) = (error, Real::exp(bottom));
                }
            }
        }
        let grid = Grid::new(bend, FINAL);
        let mut fit = Fit { bend, coefficients: [[0.0; C]; N], max_error: [0.0; C] };
        for channel in 0..C {
            for (row, value) in fit.coefficients.iter_mut().zip(monomials(&grid.minimax(N, n[channel], k[channel]).0)) {
                row[channel] = value;
            }
        }
        fit.max_error = fit.measure(n, k);
        for (channel, max_error) in fit.max_error.into_iter().enumerate() {
            if max_error > LARGEST_ERROR {
                return Err(FitError::NotSmooth { channel, n: n[channel], k: k[channel], max_error });
            }
        }
        Ok(fit)
    }

    /// The largest error of each channel on a grid four times as dense as that of the fit.
    fn measure(&self, n: [f64; C], k: [f64; C]) -> [f64; C] {
        let mut worst = [0.0f64; C];
        let grid = Grid::new(self.bend, 4 * FINAL);
        for channel in 0..C {
            let (n, k) = (n[channel], k[channel]);
            let mut measure = |cos: f64| {
                let exact = fresnel::conductor(cos, n, k).transmittance;
                worst[channel] = worst[channel].max((self.transmittance(cos)[channel] - exact).abs());
            };
            grid.cosines.iter().for_each(|cos| measure(*cos));
            if n < 1.0 {
                // What a small n does between the critical angle and Brewster's may fit between the points.
                let critical = Real::sqrt((1.0 - n) * (1.0 + n));
                measure(1.0 / Real::sqrt(1.0 + n * n));
                let mut share = 1.0;
                while share > f64::EPSILON {
                    measure(critical + (1.0 - critical) * share);
                    share *= 0.97;
                }
            }
        }
        // Between the points of the grid it may be larger by 1 part in 10⁴; both sides round.
        worst.map(|error| 1.003 * error + 8.0 * f64::EPSILON)
    }

    /// The split of arriving power in each channel.
    ///
    /// `cos_i` in [0, 1]: cosine of the angle of incidence. F, T in [0, 1] for any number.
    #[inline]
    pub fn evaluate<R: Real>(&self, cos_i: R) -> [Fresnel<R>; C] {
        let split = |transmittance| Fresnel { reflectance: R::Wide::ONE - transmittance, transmittance };
        self.transmittance_wide(cos_i.widen()).map(|t| split(t).narrow())
    }

    /// The reflected fraction in each channel; `cos_i` in [0, 1].
    #[inline]
    pub fn reflectance<R: Real>(&self, cos_i: R) -> [R; C] {
        self.transmittance_wide(cos_i.widen()).map(|t| R::narrow(R::Wide::ONE - t))
    }

    /// The transmitted fraction in each channel; `cos_i` in [0, 1].
    #[inline]
    pub fn transmittance<R: Real>(&self, cos_i: R) -> [R; C] {
        self.transmittance_wide(cos_i.widen()).map(R::narrow)
    }

    #[inline(always)]
    pub(crate) fn transmittance_wide<W: Real>(&self, c: W) -> [W; C] {
        let b = W::from_f64(self.bend);
        let t = c * (W::ONE + b) / (c + b);
        let u = W::TWO * t - W::ONE;
        // Loops, not closures: what runs over vectors must be inlined whole.
        let mut all = [W::ZERO; C];
        for channel in 0..C {
            let mut sum = W::ZERO;
            for i in (0..N).rev() {
                sum = sum.mul_add(u, W::from_f64(self.coefficients[i][channel]));
            }
            all[channel] = (t * sum).saturate();
        }
        all
    }
}

impl<const N: usize> Fit<3, N> {
    /// The rows that `fresnel_fit::Fit` (N = 8) and `fresnel_fit::FineFit` (N = 12) of WGSL hold: the coefficients of a
    /// power in xyz, and b in the first row's w.
    pub fn rows(&self) -> [[f32; 4]; N] {
        core::array::from_fn(|i| {
            let [r, g, b] = self.coefficients[i].map(|x| x as f32);
            [r, g, b, if i == 0 { self.bend as f32 } else { 0.0 }]
        })
    }
}

/// Why an index has no [`Fit`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum FitError {
    /// A number outside [`N_RANGE`] or [`K_RANGE`].
    OutOfRange {
        /// The channel, counted from 0.
        channel: usize,
        /// The real part of its index.
        n: f64,
        /// The imaginary part.
        k: f64,
    },
    /// F has a kink at a critical angle (n < 1, κ ≈ 0) or a step at c = 0 (n = 1, κ = 0), which no polynomial follows.
    NotSmooth {
        /// The channel, counted from 0.
        channel: usize,
        /// The real part of its index.
        n: f64,
        /// The imaginary part.
        k: f64,
        /// The error of the best fit.
        max_error: f64,
    },
}

impl fmt::Display for FitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FitError::OutOfRange { channel, n, k } => {
                write!(f, "channel {channel}: n = {n}, κ = {k}, but n must be in [0.001, 1000] and κ in [0, 1000]")
            }
            FitError::NotSmooth { channel, n, k, max_error } => write!(
                f,
                "channel {channel}: n = {n}, κ = {k} makes F bend too sharply for a polynomial (the best is {max_error:.2} \
                 off); use fresnel::conductor"
            ),
        }
    }
}

impl core::error::Error for FitError {}

/// The error above which a fit is refused: those of smooth indices are far below, those with a kink are .26 and more.
const LARGEST_ERROR: f64 = 0.05;
/// The constants b that are searched, in SCAN steps of equal ratio.
const BENDS: (f64, f64) = (0.02, 4.0);
const SCAN: usize = 48;
/// The points of the grids that b is searched on and the fit is made on.
const SEARCH: usize = 256;
const FINAL: usize = 1024;

/// Chebyshev's extrema in t on (0, 1], and their cosines.
struct Grid {
    t: Vec<f64>,
    cosines: Vec<f64>,
}

impl Grid {
    fn new(bend: f64, points: usize) -> Self {
        // t = sin²(θ/2), θ in equal steps to π.
        let t = |i: usize| (i as f64 / (4 * points) as f64).unit_circle().1.squared();
        let t: Vec<f64> = (1..=points).map(t).collect();
        let cosines = t.iter().map(|t| (t * bend / (1.0 + bend - t)).min(1.0)).collect();
        Grid { t, cosines }
    }

    /// The coefficients of P in Chebyshev polynomials of 2t−1 that make the largest error of t·P on the grid smallest,
    /// and that error: Remez' exchange of all points (Remez 1934; Powell 1981, §8).
    fn minimax(&self, count: usize, n: f64, k: f64) -> (Vec<f64>, f64) {
        let exact: Vec<f64> = self.cosines.iter().map(|c| fresnel::conductor(*c, n, k).transmittance).collect();
        let last = self.t.len() - 1;
        // As many points as coefficients and one, spaced like the extrema of t·T_N.
        let place = |i: usize| ((2 * i + 1) * (last + 1) / (2 * count + 1)).clamp(1, last + 1) - 1;
        let mut points: Vec<usize> = (0..=count).map(place).collect();
        let (mut best, mut least) = (alloc::vec![0.0; count], f64::INFINITY);
        for _ in 0..ROUNDS {
            let Some(coefficients) = self.level(&points, &exact, count) else { break };
            let error = |i: usize| exact[i] - self.t[i] * chebyshev(&coefficients, 2.0 * self.t[i] - 1.0);
            let errors: Vec<f64> = (0..=last).map(error).collect();
            let largest = errors.iter().fold(0.0f64, |largest, e| largest.max(e.abs()));
            let level = points.iter().fold(f64::INFINITY, |level, i| level.min(errors[*i].abs()));
            if largest < least {
                least = largest;
                best = coefficients;
            }
            if largest <= 1.0001 * level + 1e-15 {
                break;
            }
            points = exchange(&errors, count + 1);
            if points.len() != count + 1 {
                break;
            }
        }
        (best, least)
    }

    /// The coefficients whose error alternates with one magnitude on the given points.
    fn level(&self, points: &[usize], exact: &[f64], count: usize) -> Option<Vec<f64>> {
        let mut sign = 1.0;
        let mut rows = Vec::new();
        for i in points {
            let (t, u) = (self.t[*i], 2.0 * self.t[*i] - 1.0);
            let (mut now, mut next) = (t, t * u);
            let mut row = Vec::new();
            for _ in 0..count {
                row.push(now);
                (now, next) = (next, 2.0 * u * next - now);
            }
            row.extend([sign, exact[*i]]);
            rows.push(row);
            sign = -sign;
        }
        let mut solution = solve(rows)?;
        solution.truncate(count);
        Some(solution)
    }
}

/// The most exchanges; five to eight are usual.
const ROUNDS: usize = 30;

/// The points of the next round: extrema of alternating sign, the largest among them.
fn exchange(errors: &[f64], count: usize) -> Vec<usize> {
    let mut extrema: Vec<usize> = Vec::new();
    for (i, error) in errors.iter().enumerate() {
        match extrema.last_mut() {
            Some(last) if (errors[*last] < 0.0) == (*error < 0.0) => {
                if error.abs() > errors[*last].abs() {
                    *last = i;
                }
            }
            _ => extrema.push(i),
        }
    }
    while extrema.len() > count {
        let size = |place: usize| errors[extrema[place]].abs();
        let end = extrema.len() - 1;
        let smallest = (0..=end).fold(0, |least, place| if size(place) < size(least) { place } else { least });
        if extrema.len() == count + 1 || smallest == 0 || smallest == end {
            extrema.remove(if size(0) < size(end) { 0 } else { end });
        } else {
            // Its neighbours have the same sign: the smaller of them goes too.
            let neighbour = if size(smallest - 1) < size(smallest + 1) { smallest - 1 } else { smallest };
            extrema.drain(neighbour..=neighbour + 1);
        }
    }
    extrema
}

/// Gauss' elimination with pivots; the right-hand side is each row's last number. None where the matrix is singular.
fn solve(mut rows: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let size = rows.len();
    for column in 0..size {
        let pivot = (column..size).max_by(|a, b| rows[*a][column].abs().total_cmp(&rows[*b][column].abs()))?;
        rows.swap(column, pivot);
        let (above, below) = rows.split_at_mut(column + 1);
        let top = &above[column];
        let usable = top[column].abs() > 1e-300;
        if !usable {
            return None;
        }
        for row in below {
            let factor = row[column] / top[column];
            for (value, top) in row.iter_mut().zip(top).skip(column) {
                *value -= factor * top;
            }
        }
    }
    let mut solution = alloc::vec![0.0; size];
    for row in (0..size).rev() {
        let known: f64 = (row + 1..size).map(|column| rows[row][column] * solution[column]).sum();
        solution[row] = (rows[row][size] - known) / rows[row][row];
    }
    Some(solution)
}

/// Σ aᵢTᵢ(u).
fn chebyshev(coefficients: &[f64], u: f64) -> f64 {
    let (mut one, mut two) = (0.0, 0.0);
    for coefficient in coefficients.iter().skip(1).rev() {
        (one, two) = (2.0 * u * one - two + coefficient, one);
    }
    u * one - two + coefficients.first().copied().unwrap_or(0.0)
}

/// The coefficients of powers from those of Chebyshev polynomials.
fn monomials(coefficients: &[f64]) -> Vec<f64> {
    let count = coefficients.len();
    let mut sum = alloc::vec![0.0; count];
    // Tᵢ and Tᵢ₊₁ in powers.
    let (mut now, mut next) = (alloc::vec![0.0; count + 2], alloc::vec![0.0; count + 2]);
    (now[0], next[1]) = (1.0, 1.0);
    for coefficient in coefficients {
        for (sum, power) in sum.iter_mut().zip(&now) {
            *sum += coefficient * power;
        }
        let mut after: Vec<f64> = now.iter().map(|x| -x).collect();
        for i in 0..=count {
            after[i + 1] += 2.0 * next[i];
        }
        (now, next) = (next, after);
    }
    sum
}
