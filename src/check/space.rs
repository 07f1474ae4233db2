//! The box that a family's parameters are searched in: units, corners, even points, round numbers.

use super::family::{Parameter, Scale};
use sobol_burley::sample_4d;

/// Corners of the box that are looked at, at most: 3⁴.
const CORNERS: usize = 81;

/// The box of the parameters, in units of which each runs from 0 to 1.
pub(super) struct Space<'a> {
    pub(super) parameters: &'a [Parameter],
}

impl Space<'_> {
    fn value(parameter: &Parameter, unit: f64) -> f64 {
        let Parameter { low, high, .. } = *parameter;
        let unit = unit.clamp(0.0, 1.0);
        match parameter.scale {
            Scale::Switch => f64::from(u8::from(unit >= 0.5)),
            // The ends exactly.
            _ if unit == 0.0 => low,
            _ if unit == 1.0 => high,
            Scale::Logarithmic if low > 0.0 && high > low => low * (high / low).powf(unit),
            _ => low + (high - low) * unit,
        }
    }

    fn unit(parameter: &Parameter, value: f64) -> f64 {
        let Parameter { low, high, .. } = *parameter;
        if high <= low {
            return 0.0;
        }
        match parameter.scale {
            Scale::Logarithmic if low > 0.0 => ((value / low).ln() / (high / low).ln()).clamp(0.0, 1.0),
            _ => ((value - low) / (high - low)).clamp(0.0, 1.0),
        }
    }

    pub(super) fn values(&self, units: &[f64]) -> Vec<f64> {
        self.parameters.iter().zip(units).map(|(parameter, &unit)| Self::value(parameter, unit)).collect()
    }

    pub(super) fn units(&self, values: &[f64]) -> Vec<f64> {
        self.parameters.iter().zip(values).map(|(parameter, &value)| Self::unit(parameter, value)).collect()
    }

    pub(super) fn defaults(&self) -> Vec<f64> {
        self.parameters.iter().map(|parameter| parameter.default.clamp(parameter.low, parameter.high)).collect()
    }

    /// Minimum, default and maximum of each parameter, in every combination if they are few; else each parameter's alone, and
    /// a choice of combinations.
    pub(super) fn corners(&self, seed: u32) -> Vec<Vec<f64>> {
        let d = self.parameters.len();
        let defaults = self.units(&self.defaults());
        let level = |axis: usize, digit: usize| [defaults[axis], 0.0, 1.0][digit % 3];
        let mut corners: Vec<Vec<f64>> = Vec::new();
        let mut add = |corner: Vec<f64>| {
            if corners.len() < CORNERS && !corners.contains(&corner) {
                corners.push(corner);
            }
        };
        if 3usize.checked_pow(d as u32).is_some_and(|all| all <= CORNERS) {
            for i in 0..3usize.pow(d as u32) {
                add((0..d).map(|axis| level(axis, i / 3usize.pow(axis as u32))).collect());
            }
            return corners;
        }
        for digit in 0..3 {
            add((0..d).map(|axis| level(axis, digit)).collect());
        }
        for axis in 0..d {
            for digit in 1..3 {
                add((0..d).map(|other| level(other, if other == axis { digit } else { 0 })).collect());
            }
        }
        for i in 0..2 * CORNERS {
            add((0..d).map(|axis| level(axis, (3.0 * sobol(i, axis, seed)) as usize)).collect());
        }
        corners
    }
}

/// A coordinate of the Sobol sequence.
pub(super) fn sobol(index: usize, axis: usize, seed: u32) -> f64 {
    f64::from(sample_4d((index & 0xffff) as u32, (axis / 4) as u32, seed ^ 0x51ed)[axis % 4])
}

/// A number to so many significant digits.
pub(super) fn significant(x: f64, digits: i32) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return x;
    }
    let places = digits - 1 - x.abs().log10().floor() as i32;
    format!("{:.*e}", (digits - 1) as usize, x).parse().unwrap_or_else(|_| {
        let scale = 10f64.powi(places);
        (x * scale).round() / scale
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(low: f64, high: f64, scale: Scale) -> Parameter {
        Parameter { name: "p".into(), low, high, default: low, scale }
    }

    #[test]
    fn units_and_values_are_inverse() {
        for parameter in [
            parameter(-1.0, 3.0, Scale::Linear),
            parameter(1e-4, 1.0, Scale::Logarithmic),
            parameter(0.0, 1.0, Scale::Switch),
        ] {
            for unit in [0.0, 0.25, 0.5, 1.0] {
                let value = Space::value(&parameter, unit);
                assert!(value >= parameter.low && value <= parameter.high);
                if parameter.scale != Scale::Switch {
                    assert!((Space::unit(&parameter, value) - unit).abs() < 1e-12, "{parameter:?} {unit} {value}");
                }
            }
        }
    }

    #[test]
    fn corners_are_all_or_a_choice() {
        let parameters: Vec<Parameter> = (0..2).map(|_| parameter(0.0, 1.0, Scale::Linear)).collect();
        // The default is a corner itself: 2² are left.
        assert_eq!(Space { parameters: &parameters }.corners(1).len(), 4);
        let parameters: Vec<Parameter> = (0..12).map(|_| parameter(0.0, 1.0, Scale::Linear)).collect();
        let corners = Space { parameters: &parameters }.corners(1);
        assert!(corners.len() <= CORNERS && corners.len() > 26, "{}", corners.len());
    }

    #[test]
    fn numbers_get_round() {
        assert_eq!([1, 2, 3].map(|digits| significant(0.034_56, digits)), [0.03, 0.035, 0.0346]);
        assert_eq!(significant(-1234.0, 2), -1200.0);
        assert_eq!(significant(0.0, 3), 0.0);
    }
}
