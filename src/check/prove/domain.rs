//! The box that a proof is about: parameters, the cosines of both directions, and their azimuths.

use super::enclosure::{Bounds, Enclosure};
use crate::check::family::{Parameter, Scale};
use crate::frame::Vector;

/// Which directions a proof is about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Directions {
    /// The least cosine of either direction with the normal, in (0, 1].
    pub least_cosine: f64,
    /// Only `wo` of azimuth 0: every direction, if the BRDF is isotropic.
    pub isotropic: bool,
}

impl Default for Directions {
    /// Cosines from 0.05, 87° from the normal; any azimuth.
    fn default() -> Self {
        Directions { least_cosine: 0.05, isotropic: false }
    }
}

/// An edge of a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The least value.
    pub low: f64,
    /// The largest value.
    pub high: f64,
}

/// A part of a [`Domain`], an edge for each of its axes.
pub type Region = Vec<Edge>;

/// A box: parameters first, then the cosines `cos_i` and `cos_o`, then the azimuths in degrees, `phi_i` and, unless it is
/// fixed at 0, `phi_o`.
#[derive(Clone, Debug, PartialEq)]
pub struct Domain {
    axes: Vec<Parameter>,
    parameters: usize,
    directions: Directions,
}

impl Domain {
    pub(super) fn new(parameters: &[Parameter], directions: Directions) -> Self {
        let axis = |name: &str, low: f64, high: f64| Parameter {
            name: name.to_owned(),
            low,
            high,
            default: low,
            scale: Scale::Linear,
        };
        let mut axes = parameters.to_vec();
        let least = if directions.least_cosine > 0.0 { directions.least_cosine.min(1.0) } else { f64::MIN_POSITIVE };
        axes.extend([axis("cos_i", least, 1.0), axis("cos_o", least, 1.0), axis("phi_i", 0.0, 360.0)]);
        if !directions.isotropic {
            axes.push(axis("phi_o", 0.0, 360.0));
        }
        Domain { axes, parameters: parameters.len(), directions }
    }

    /// The axes of the box, their ranges and names.
    pub fn axes(&self) -> &[Parameter] {
        &self.axes
    }

    /// What it is in words: `roughness in 0.1..1, cos_i in 0.05..1, …`.
    pub fn describe(&self) -> String {
        let whole = self.whole();
        let fixed = if self.directions.isotropic { ", phi_o = 0" } else { "" };
        format!("{}{fixed}", self.describe_region(&whole))
    }

    /// A region in the same words.
    pub fn describe_region(&self, region: &[Edge]) -> String {
        let edge = |(axis, edge): (&Parameter, &Edge)| {
            if edge.low == edge.high {
                format!("{} = {}", axis.name, edge.low)
            } else {
                format!("{} in {}..{}", axis.name, edge.low, edge.high)
            }
        };
        self.axes.iter().zip(region).map(edge).collect::<Vec<_>>().join(", ")
    }

    pub(super) fn whole(&self) -> Region {
        self.axes.iter().map(|axis| Edge { low: axis.low, high: axis.high }).collect()
    }

    /// The number along an axis that halves an edge as it is searched.
    pub(super) fn middle(&self, axis: usize, edge: Edge) -> f64 {
        match self.axes.get(axis).map(|axis| axis.scale) {
            Some(Scale::Switch) => edge.low,
            Some(Scale::Logarithmic) if edge.low > 0.0 => {
                (edge.low.sqrt() * edge.high.sqrt()).clamp(edge.low, edge.high)
            }
            _ => edge.low + 0.5 * (edge.high - edge.low),
        }
    }

    /// The share of an axis that an edge takes.
    pub(super) fn share(&self, axis: usize, edge: Edge) -> f64 {
        let Some(parameter) = self.axes.get(axis) else { return 0.0 };
        let measure = |low: f64, high: f64| match parameter.scale {
            Scale::Logarithmic if parameter.low > 0.0 => high.ln() - low.ln(),
            _ => high - low,
        };
        let whole = measure(parameter.low, parameter.high);
        if whole > 0.0 { measure(edge.low, edge.high) / whole } else { 0.0 }
    }

    /// Both parts of an edge; none of one that is too narrow to be cut.
    pub(super) fn halves(&self, axis: usize, edge: Edge) -> Option<[Edge; 2]> {
        if edge.low >= edge.high {
            return None;
        }
        if self.axes.get(axis)?.scale == Scale::Switch {
            // There is nothing between.
            return Some([Edge { high: edge.low, ..edge }, Edge { low: edge.high, ..edge }]);
        }
        let middle = self.middle(axis, edge);
        let narrow = self.share(axis, edge) < 1e-9 || middle <= edge.low || middle >= edge.high;
        (!narrow).then_some([Edge { high: middle, ..edge }, Edge { low: middle, ..edge }])
    }

    /// Whether a number is one of an axis.
    pub(super) fn holds(&self, axis: usize, value: f64) -> bool {
        self.axes.get(axis).is_some_and(|axis| {
            let switch = axis.scale == Scale::Switch;
            (axis.low..=axis.high).contains(&value) && (!switch || value == axis.low || value == axis.high)
        })
    }

    /// wi, wo and the parameters over a region, as a row of arguments.
    pub(super) fn row(&self, region: &[Edge]) -> Vec<Enclosure> {
        let edge = |index: usize| region.get(index).copied().unwrap_or(Edge { low: 0.0, high: 0.0 });
        let at = self.parameters;
        let mut row = direction(edge(at), edge(at + 2));
        row.extend(direction(edge(at + 1), edge(at + 3)));
        row.extend((0..at).map(|index| Enclosure::new(edge(index).low, edge(index).high)));
        row
    }

    /// The parameters' values at a point.
    pub(super) fn parameters_at<'a>(&self, point: &'a [f64]) -> &'a [f64] {
        point.get(..self.parameters).unwrap_or_default()
    }

    /// wi and wo at a point.
    pub(super) fn pair(&self, point: &[f64]) -> [Vector<f64>; 2] {
        let at = |index: usize| point.get(self.parameters + index).copied().unwrap_or(0.0);
        [(at(0), at(2)), (at(1), at(3))].map(|(cosine, degrees)| {
            let sine = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
            let (c, s) = turn(degrees);
            Vector::new(sine * c, sine * s, cosine)
        })
    }
}

/// The direction of a range of cosines and of azimuths.
fn direction(cosine: Edge, azimuth: Edge) -> Vec<Enclosure> {
    let sine = |cosine: f64| ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
    // Four roundings: within 4 ε.
    let sine = Enclosure::of(Bounds::rounded(sine(cosine.high), sine(cosine.low), 0.0), true);
    let x = extent(azimuth, 0.0, |degrees| turn(degrees).0);
    let y = extent(azimuth, 90.0, |degrees| turn(degrees).1);
    vec![sine * x, sine * y, Enclosure::new(cosine.low, cosine.high)]
}

/// The values between two azimuths of a cosine that is 1 at `top`.
fn extent(azimuth: Edge, top: f64, wave: impl Fn(f64) -> f64) -> Enclosure {
    let (a, b) = (wave(azimuth.low), wave(azimuth.high));
    let holds = |at: f64| ((azimuth.low - at) / 360.0).ceil() * 360.0 + at <= azimuth.high;
    let high = if holds(top) { 1.0 } else { a.max(b) };
    let low = if holds(top + 180.0) { -1.0 } else { a.min(b) };
    if azimuth.low == azimuth.high && azimuth.low % 90.0 == 0.0 {
        return Enclosure::new(a, a);
    }
    // The turn is rounded, and so is its cosine: within 3 ε together.
    Enclosure::new((low - 1e-15).max(-1.0), (high + 1e-15).min(1.0))
}

/// The cosine and sine of degrees; exact at the quarters.
fn turn(degrees: f64) -> (f64, f64) {
    let quarters = (degrees / 90.0).round();
    let (s, c) = (degrees - 90.0 * quarters).to_radians().sin_cos();
    match quarters.rem_euclid(4.0) as u8 {
        0 => (c, s),
        1 => (-s, c),
        2 => (-c, -s),
        _ => (s, -c),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_hold_the_directions_of_their_regions() {
        let roughness = Parameter { name: "a".into(), low: 0.01, high: 1.0, default: 0.5, scale: Scale::Logarithmic };
        let domain = Domain::new(&[roughness], Directions { least_cosine: 0.1, isotropic: false });
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1u32 << 24)
        };
        for _ in 0..2000 {
            let mut region = domain.whole();
            let mut point = Vec::new();
            for edge in &mut region {
                let (a, b) = (random(), random());
                let span = edge.high - edge.low;
                *edge = Edge { low: edge.low + a.min(b) * span, high: edge.low + a.max(b) * span };
                point.push(edge.low + random() * (edge.high - edge.low));
            }
            let [wi, wo] = domain.pair(&point);
            let row = domain.row(&region);
            for (x, bounds) in [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z, point[0]].into_iter().zip(row) {
                assert!(bounds.low() <= x && x <= bounds.high(), "{region:?} {point:?}: {x} {bounds:?}");
                assert!(bounds.is_total());
            }
        }
    }

    #[test]
    fn quarters_are_exact() {
        assert_eq!(turn(180.0), (-1.0, -0.0));
        assert_eq!(turn(270.0), (0.0, -1.0));
        assert_eq!(turn(360.0), (1.0, 0.0));
        assert!((turn(60.0).0 - 0.5).abs() < 1e-15);
    }

    #[test]
    fn edges_are_cut_as_they_are_searched() {
        let scale = |scale| Parameter { name: "p".into(), low: 0.01, high: 1.0, default: 1.0, scale };
        let domain = Domain::new(&[scale(Scale::Logarithmic), scale(Scale::Switch)], Directions::default());
        let [first, second] = domain.halves(0, Edge { low: 0.01, high: 1.0 }).unwrap();
        assert!((first.high - 0.1).abs() < 1e-15 && first.high == second.low);
        assert!((domain.share(0, first) - 0.5).abs() < 1e-12);
        let [off, on] = domain.halves(1, Edge { low: 0.01, high: 1.0 }).unwrap();
        assert_eq!((off.high, on.low), (0.01, 1.0));
        assert!(domain.halves(1, on).is_none());
        assert!(domain.describe().starts_with("p in 0.01..1, "), "{}", domain.describe());
    }
}
