//! Colour ramps: a colour for each grey value.
//!
//! [`two`] is the documents' listing. A [`Ramp`] has any number of stops and is read in two ways: [`ramp`] goes linearly from one colour to
//! the next (rust, from dark brown to red), [`bands`] holds each colour from its stop to the next, the edges soft or sharp (patina in
//! bands of 0.2). [`aged`] moves a noise through the bands as time goes by.
//!
//! In WGSL the stops are supplied by the embedder, `fn ramp_stop(index: u32) -> vec4f`: the colour and, in w, the position. All ramps of a
//! material lie one after another; a function takes the first stop and their number.

use super::mask;
use crate::real::Real;
use alloc::vec::Vec;
use core::fmt;

/// The ramp between two colours, each channel by its own grey value.
///
/// In plain text: (1 − t)·a + t·b, t in [0, 1]; exactly a at 0 and b at 1.
///
/// Source: Mihaylov 2013, §4.3, listing `colorRamp`.
#[inline]
pub fn two<R: Real, const C: usize>(a: [R; C], b: [R; C], t: [R; C]) -> [R; C] {
    core::array::from_fn(|c| (R::ONE - t[c]) * a[c] + t[c] * b[c])
}

/// The colour of a ramp at a grey value: linear between neighbouring stops, constant before the first and after the last.
///
/// Of stops at one position the ramp jumps from the first to the last, and has the first one's colour there. Continuous elsewhere.
/// Without stops it is 0. Source: Mihaylov 2013, §3.3.2 (five colours).
#[inline]
pub fn ramp<R: Real, const C: usize>(stops: &[Stop<C>], t: R) -> [R; C] {
    through(stops, |low, high| mask::grey(t, low, high))
}

/// The colour of a ramp in bands: each stop's colour from its position on, up to the next.
///
/// * `softness` ≥ 0: the colours of neighbours are blended by [`mask::soft_threshold`] within ± softness of the edge. 0: constant bands, where
///   the edge itself has the lower band's colour.
///
/// The first band has no lower end. Softness at most half the narrowest band's width keeps the colours apart; more blends
/// more than two. Source: Mihaylov 2013, §3.3.2: "each 20 % of the gradient ramp is occupied by one of the pre-selected colors".
#[inline]
pub fn bands<R: Real, const C: usize>(stops: &[Stop<C>], softness: R, t: R) -> [R; C] {
    through(stops, |_, at| mask::soft_threshold(t, at, softness))
}

/// A noise at an age, as the grey value of a ramp with this many bands.
///
/// $$\frac{\text{age}\,(\text{count} - 1) + \text{value}}{\text{count}}$$
///
/// In plain text: (age·(count − 1) + value)/count, value and age clamped to [0, 1]; in [0, 1].
///
/// The documents limit the noise of each age to its own fifth of the ramp, "values from 0.8 to 1.0". With five bands that is what age 0, ¼, ½, ¾, 1
/// give; between, the window slides. A count of 0 counts as 1. Source: Mihaylov 2013, §3.3.2, fig. 24.
#[inline]
pub fn aged<R: Real>(value: R, age: R, count: u32) -> R {
    let count = R::from_f64(f64::from(count.max(1)));
    (age.saturate() * (count - R::ONE) + value.saturate()) / count
}

/// The first colour, replaced by each that follows to the share that its place and that of the stop before it give.
#[inline(always)]
fn through<R: Real, const C: usize>(stops: &[Stop<C>], share: impl Fn(R, R) -> R) -> [R; C] {
    let Some(first) = stops.first() else { return [R::ZERO; C] };
    let number = |x: f32| R::from_f64(f64::from(x));
    let mut colour = first.colour.map(number);
    for (before, stop) in stops.iter().zip(stops.iter().skip(1)) {
        colour = two(colour, stop.colour.map(number), [share(number(before.at), number(stop.at)); C]);
    }
    colour
}

/// One colour of a [`Ramp`] and where it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop<const C: usize> {
    /// The position, a grey value.
    pub at: f32,
    /// The colour there.
    pub colour: [f32; C],
}

/// Colours by grey value: any number of stops in ascending order.
#[derive(Clone, Debug, PartialEq)]
pub struct Ramp<const C: usize> {
    stops: Vec<Stop<C>>,
}

impl<const C: usize> Ramp<C> {
    /// A ramp with these stops.
    ///
    /// # Errors
    /// No stops, a number that is not finite, or a position below the one before it.
    pub fn new(stops: impl IntoIterator<Item = Stop<C>>) -> Result<Self, RampError> {
        let stops: Vec<_> = stops.into_iter().collect();
        if stops.is_empty() {
            return Err(RampError::Empty);
        }
        let is_finite = |stop: &Stop<C>| stop.at.is_finite() && stop.colour.iter().all(|x| x.is_finite());
        if let Some(stop) = stops.iter().position(|stop| !is_finite(stop)) {
            return Err(RampError::NotFinite { stop });
        }
        if let Some(stop) = stops.windows(2).position(|pair| matches!(pair, [a, b] if b.at < a.at)) {
            return Err(RampError::Descending { stop: stop + 1 });
        }
        Ok(Ramp { stops })
    }

    /// A ramp of evenly spaced colours, from the first at 0 to the last at 1; what [`ramp`] reads.
    ///
    /// # Errors
    /// As [`Ramp::new`].
    pub fn even(colours: &[[f32; C]]) -> Result<Self, RampError> {
        Self::spaced(colours, colours.len().saturating_sub(1))
    }

    /// A ramp whose colours begin bands of equal width: with five at 0, 0.2, 0.4, 0.6 and 0.8; what [`bands`] reads.
    ///
    /// # Errors
    /// As [`Ramp::new`].
    pub fn banded(colours: &[[f32; C]]) -> Result<Self, RampError> {
        Self::spaced(colours, colours.len())
    }

    fn spaced(colours: &[[f32; C]], steps: usize) -> Result<Self, RampError> {
        let at = |index: usize| (index as f64 / steps.max(1) as f64) as f32;
        Self::new(colours.iter().enumerate().map(|(index, colour)| Stop { at: at(index), colour: *colour }))
    }

    /// The stops in ascending order; at least one.
    pub fn stops(&self) -> &[Stop<C>] {
        &self.stops
    }

    /// The colour at a grey value, linear between stops: [`ramp`].
    #[inline]
    pub fn at<R: Real>(&self, t: R) -> [R; C] {
        ramp(&self.stops, t)
    }

    /// The colour of the band at a grey value: [`bands`].
    #[inline]
    pub fn band<R: Real>(&self, softness: R, t: R) -> [R; C] {
        bands(&self.stops, softness, t)
    }
}

/// Why stops make no ramp. Stops count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RampError {
    /// There is no stop.
    Empty,
    /// The position or the colour of a stop is not a finite number.
    NotFinite {
        /// Which stop.
        stop: usize,
    },
    /// A stop is positioned below the one before it.
    Descending {
        /// Which stop.
        stop: usize,
    },
}

impl fmt::Display for RampError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RampError::Empty => write!(f, "the ramp has no colours: give one at least"),
            RampError::NotFinite { stop } => write!(f, "colour {stop} of the ramp is not finite: give finite numbers"),
            RampError::Descending { stop } => {
                write!(
                    f,
                    "colour {stop} of the ramp is positioned below the one before it: give them in ascending order"
                )
            }
        }
    }
}

impl core::error::Error for RampError {}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::string::ToString;
    use alloc::vec;

    const COLOURS: [[f32; 3]; 5] =
        [[0.25, 0.125, 0.0], [0.5, 0.25, 0.125], [0.125, 0.25, 0.25], [0.25, 0.75, 0.5], [0.5, 1.0, 0.75]];

    fn close(got: [f64; 3], want: [f64; 3]) -> bool {
        // A blend of numbers ≤ 1 rounds three times.
        got.iter().zip(want).all(|(got, want)| (got - want).abs() <= 2.0 * f64::EPSILON)
    }

    #[test]
    fn two_colours_are_the_listing() {
        let (a, b) = ([0.1, 0.2, 0.3], [0.9, 0.6, 0.3]);
        assert_eq!(two(a, b, [0.0; 3]), a);
        assert_eq!(two(a, b, [1.0; 3]), b);
        assert!(close(two(a, b, [0.25, 0.5, 0.75]), [0.3, 0.4, 0.3]));
    }

    #[test]
    fn a_ramp_passes_through_its_stops_and_is_linear_between() {
        let ramp = Ramp::even(&COLOURS).expect("a ramp");
        for (i, colour) in COLOURS.iter().enumerate() {
            assert_eq!(ramp.at(i as f64 / 4.0), colour.map(f64::from));
        }
        for i in 0..4 {
            let [a, b] = [COLOURS[i], COLOURS[i + 1]].map(|colour| colour.map(f64::from));
            for share in [0.25, 0.5, 0.625] {
                let want = core::array::from_fn(|c| a[c] + share * (b[c] - a[c]));
                assert!(close(ramp.at((i as f64 + share) / 4.0), want), "{i} {share}");
            }
        }
        assert_eq!(ramp.at(-3.0), COLOURS[0].map(f64::from));
        assert_eq!(ramp.at(f64::INFINITY), COLOURS[4].map(f64::from));
        assert_eq!(ramp.at(f64::NAN), COLOURS[0].map(f64::from));
    }

    #[test]
    fn stops_at_one_place_are_a_jump() {
        let stop = |at: f32, grey: f32| Stop { at, colour: [grey] };
        let ramp = Ramp::new([stop(0.0, 0.0), stop(0.5, 0.25), stop(0.5, 0.75), stop(1.0, 1.0)]).expect("a ramp");
        assert_eq!(ramp.at(0.5f32), [0.25]);
        assert_eq!(ramp.at(0.25f32), [0.125]);
        assert!((ramp.at(0.5f32.next_up())[0] - 0.75).abs() < 1e-6);
        assert_eq!(ramp.at(0.75f32), [0.875]);
    }

    #[test]
    fn bands_are_constant_fifths_with_soft_edges() {
        let ramp = Ramp::banded(&COLOURS).expect("a ramp");
        for i in 0..1000 {
            let t = (f64::from(i) + 0.5) / 1000.0;
            assert_eq!(ramp.band(0.0, t), COLOURS[(5.0 * t) as usize].map(f64::from), "{t}");
        }
        // An edge belongs to the band below; f32 has its own 0.2.
        assert_eq!(ramp.band(0.0, 0.2f32), COLOURS[0]);
        assert_eq!(ramp.band(0.0, 0.2f32.next_up()), COLOURS[1]);
        // At an edge half of each; where the softness ends, one alone.
        let at = f64::from(0.2f32);
        let half = core::array::from_fn(|c| 0.5 * f64::from(COLOURS[0][c] + COLOURS[1][c]));
        assert!(close(ramp.band(0.05, at), half));
        assert_eq!(ramp.band(0.05, at - 0.051), COLOURS[0].map(f64::from));
        assert_eq!(ramp.band(0.05, at + 0.051), COLOURS[1].map(f64::from));
    }

    #[test]
    fn the_softness_leaves_the_mean_of_two_bands() {
        // smoothstep is antisymmetric about the edge: the integral over both bands is that of the sharp ones. By the midpoint
        // rule, exact for the constant parts; the antisymmetric pairs cancel to rounding.
        let ramp = Ramp::banded(&COLOURS[..2]).expect("a ramp");
        for softness in [0.0, 0.1, 0.5] {
            let mean = (0..1000).map(|i| ramp.band(softness, (f64::from(i) + 0.5) / 1000.0)[0]).sum::<f64>() / 1000.0;
            assert!((mean - 0.375).abs() < 1e-12, "{softness}: {mean}");
        }
    }

    #[test]
    fn ages_fill_their_fifths() {
        for band in 0..5 {
            let age = f64::from(band) / 4.0;
            for value in [0.0, 0.25, 1.0] {
                let want = (f64::from(band) + value) / 5.0;
                assert!((aged(value, age, 5) - want).abs() <= f64::EPSILON, "{band} {value}");
            }
        }
        assert_eq!(aged(7.0, -1.0, 5), 0.2);
        assert_eq!(aged(0.5, 1.0, 0), 0.5);
        assert_eq!(aged(f32::NAN, f32::NAN, 3), 0.0);
    }

    #[test]
    fn what_is_no_ramp_is_refused_with_its_place() {
        let stop = |at: f32, grey: f32| Stop { at, colour: [grey] };
        assert_eq!(Ramp::<3>::even(&[]), Err(RampError::Empty));
        let nan = Ramp::new(vec![stop(0.0, 0.0), stop(1.0, f32::NAN)]);
        assert_eq!(nan, Err(RampError::NotFinite { stop: 1 }));
        assert_eq!(Ramp::new([stop(f32::INFINITY, 0.0)]), Err(RampError::NotFinite { stop: 0 }));
        let unsorted = Ramp::new([stop(0.0, 0.0), stop(1.0, 0.0), stop(0.5, 0.0)]);
        assert_eq!(unsorted, Err(RampError::Descending { stop: 2 }));
        for error in [RampError::Empty, RampError::NotFinite { stop: 3 }, RampError::Descending { stop: 2 }] {
            let line = error.to_string();
            assert!(line.contains(": give ") && !line.contains('\n'), "{line}");
        }
        // One colour is a ramp.
        assert_eq!(Ramp::even(&[[0.5]]).expect("one stop").at(0.3f32), [0.5]);
    }
}
