//! The pictures of a report: albedo, lobes, reciprocity, validity, precision.
//!
//! Each takes the title it stands under and returns SVG that needs nothing else. Colours are told apart by every kind of
//! eye, and curves by their dashes as well.

use super::figures::{BROKEN, Figures, Grid, NEGATIVE, Series};
use super::svg::{Axis, Picture, Plane, SIZE, Stroke, power_of_ten};
use crate::check::energy::Albedo;
use crate::check::report::Report;
use crate::check::subject::Fixed;

/// The kinds of pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plot {
    /// Albedo against θ, both marginals, with the error; red where more leaves than arrives.
    Albedo,
    /// Polar diagram of f in the plane of incidence.
    Lobes,
    /// Relative difference of f(wi, wo) and f(wo, wi).
    Reciprocity,
    /// Where f is negative, NaN or infinite.
    Validity,
    /// Deviation of single precision and of a GPU from double precision, against the angle.
    Precision,
    /// Deviation of single precision against angle and parameter.
    Sweep,
}

impl Plot {
    /// Every kind.
    pub const ALL: [Plot; 6] =
        [Plot::Albedo, Plot::Lobes, Plot::Reciprocity, Plot::Validity, Plot::Precision, Plot::Sweep];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Plot::Albedo => "albedo",
            Plot::Lobes => "lobes",
            Plot::Reciprocity => "reciprocity",
            Plot::Validity => "validity",
            Plot::Precision => "precision",
            Plot::Sweep => "sweep",
        }
    }

    /// The picture as SVG, radii of [`Plot::Lobes`] over three decades if `logarithmic`; nothing where there is nothing to show:
    /// no single precision, no parameter.
    pub fn draw(self, figures: &Figures, subject: &str, logarithmic: bool) -> Option<String> {
        let parameters: Vec<String> =
            figures.parameters.iter().map(|(name, value)| format!("{name}={}", rounded(*value))).collect();
        let member =
            if parameters.is_empty() { subject.to_owned() } else { format!("{subject}, {}", parameters.join(", ")) };
        match self {
            Plot::Albedo => Some(albedo(&figures.albedo, &member)),
            Plot::Lobes => Some(lobes(&figures.lobes, &member, logarithmic)),
            Plot::Reciprocity => Some(reciprocity(&figures.reciprocity, &member)),
            Plot::Validity => Some(validity(&figures.validity, &member)),
            Plot::Precision => (!figures.precision.is_empty()).then(|| precision(&figures.precision, &member)),
            Plot::Sweep => figures.sweep.as_ref().map(|(parameter, grid)| sweep(parameter, grid, subject)),
        }
    }
}

fn rounded(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}

/// The albedo curves of a report that no figures were sampled for; nothing if no albedo was integrated.
pub fn albedo_of_report(report: &Report) -> Option<String> {
    let curve = |fixed: Fixed| {
        let mut row: Vec<&Albedo> = report.albedos.iter().filter(|a| a.fixed == fixed && a.phi == 0.0).collect();
        row.sort_by(|a, b| a.theta.total_cmp(&b.theta));
        let of = |pick: fn(&Albedo) -> f64| row.iter().map(|a| pick(a)).collect();
        Series {
            name: format!("{} fixed", fixed.name()),
            x: of(|a| a.theta),
            y: of(|a| a.peak().1),
            error: of(|a| a.error.get(a.peak().0).copied().unwrap_or(0.0)),
        }
    };
    let curves: Vec<Series> = Fixed::BOTH.map(curve).into_iter().filter(|curve| !curve.x.is_empty()).collect();
    (!curves.is_empty()).then(|| albedo(&curves, &report.subject))
}

fn albedo(curves: &[Series], member: &str) -> String {
    let finite = || curves.iter().flat_map(|curve| &curve.y).copied().filter(|y| y.is_finite());
    let highest = finite().fold(0.0, f64::max);
    // Where it is many times what arrives, decades show both that and the rest.
    let y = if highest > 4.0 {
        let lowest = finite().filter(|y| *y > 0.0).fold(1.0, f64::min).max(1e-3);
        Axis::logarithmic("albedo (logarithmic)", lowest, highest * 1.05)
    } else {
        Axis::linear("albedo", 0.0, (highest * 1.08).max(1.2))
    };
    let plane = Plane::new(Axis::degrees("polar angle θ of the fixed direction"), y, 0.0);
    let mut picture = Picture::new(&format!("Albedo of {member}"));
    plane.draw(&mut picture);
    let [_, top, right, _] = plane.area;
    let limit = plane.at(0.0, 1.0);
    picture.rectangle([limit[0], top], [right, limit[1]], "#d00000", "fill-opacity=\"0.12\"");
    picture.line(&[limit, [right, limit[1]]], Stroke { colour: "#a00000", dash: "none", width: 1.0 });
    picture.text([right - 6.0, top + 15.0], "end", "more leaves than arrives", "fill=\"#a00000\"");
    for (index, curve) in curves.iter().enumerate() {
        let stroke = Stroke::of(index);
        let points: Vec<(f64, f64, f64)> = curve
            .x
            .iter()
            .zip(&curve.y)
            .enumerate()
            .filter(|(_, (_, y))| y.is_finite())
            .map(|(i, (&x, &y))| (x, y, curve.error.get(i).copied().filter(|e| e.is_finite()).unwrap_or(0.0)))
            .collect();
        let upper = points.iter().map(|&(x, y, error)| plane.at(x, y + error));
        let lower = points.iter().rev().map(|&(x, y, error)| plane.at(x, y - error));
        picture.area(&upper.chain(lower).collect::<Vec<_>>(), stroke.colour, 0.25);
        // The first lies under the others, and shows where they coincide.
        let stroke = Stroke { width: if index == 0 { 4.5 } else { 2.0 }, ..stroke };
        picture.line(&points.iter().map(|&(x, y, _)| plane.at(x, y)).collect::<Vec<_>>(), stroke);
        for &(x, y, _) in &points {
            picture.dot(plane.at(x, y), stroke.colour);
        }
        let widest = points.iter().map(|point| point.2).fold(0.0, f64::max);
        let name = format!("{} (± {widest:.0e} at most)", curve.name);
        picture.legend([plane.area[0] + 12.0, plane.area[3] - 30.0 + 18.0 * index as f64], stroke, &name);
    }
    plane.frame(&mut picture);
    picture.finish()
}

/// A half disc: the surface below, the light from the left, what is mirrored to the right.
fn lobes(lobes: &[Series], member: &str, logarithmic: bool) -> String {
    const DECADES: i32 = 3;
    let [cx, cy] = [SIZE[0] / 2.0, 345.0];
    let radius = 255.0;
    let finite = lobes.iter().flat_map(|lobe| &lobe.y).copied().filter(|y| y.is_finite());
    let highest = finite.fold(0.0, f64::max);
    let top = if highest > 0.0 { highest } else { 1.0 };
    let share = |f: f64| {
        let share = if logarithmic { 1.0 + (f / top).max(1e-300).log10() / f64::from(DECADES) } else { f / top };
        if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) }
    };
    let place = |degrees: f64, r: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        [cx + radius * r * sin, cy - radius * r * cos]
    };
    let kind = if logarithmic { "logarithmic" } else { "linear" };
    let mut picture = Picture::new(&format!("Lobes of {member}"));
    let grid = Stroke { colour: "#cccccc", dash: "none", width: 1.0 };
    let rings: Vec<f64> = if logarithmic {
        (0..DECADES).map(|n| top * 10f64.powi(-n)).collect()
    } else {
        [1.0, 0.75, 0.5, 0.25].iter().map(|part| top * part).collect()
    };
    for f in &rings {
        let ring: Vec<[f64; 2]> = (-90..=90).step_by(2).map(|d| place(f64::from(d), share(*f))).collect();
        picture.line(&ring, grid);
    }
    for degrees in [-60.0, -30.0, 0.0, 30.0, 60.0] {
        picture.line(&[[cx, cy], place(degrees, 1.0)], grid);
    }
    // On the side that the light does not come from.
    for degrees in [10.0, 30.0, 60.0, 80.0] {
        picture.text(place(degrees, 1.05), "middle", &format!("{degrees}°"), "");
    }
    picture.line(&[place(-90.0, 1.06), place(90.0, 1.06)], Stroke { colour: "#222222", dash: "none", width: 1.5 });
    for (index, lobe) in lobes.iter().enumerate() {
        let stroke = Stroke::of(index);
        let mut run = Vec::new();
        for (&degrees, &f) in lobe.x.iter().zip(&lobe.y) {
            if f.is_finite() {
                run.push(place(degrees, share(f)));
            } else {
                picture.line(&core::mem::take(&mut run), stroke);
            }
        }
        picture.line(&run, stroke);
        // The light, by the angle in the lobe's own name.
        if let Some(theta) = lobe.name.split_once("= ").and_then(|(_, t)| t.trim_end_matches('°').parse::<f64>().ok())
        {
            let shaft = [place(-theta, 1.12), place(-theta, 1.01)];
            picture.line(&shaft, Stroke { dash: "none", width: 3.0, ..stroke });
        }
        picture.legend([20.0, 48.0 + 18.0 * index as f64], stroke, &lobe.name);
    }
    for f in rings {
        let [x, y] = place(90.0, share(f));
        picture.text([x, y + 16.0], "middle", &number(f), "");
    }
    let label =
        format!("f in sr⁻¹ ({kind} radius), in the plane of incidence; light from the left along the short bars");
    picture.text([cx, cy + 42.0], "middle", &label, "");
    picture.finish()
}

/// A number with three significant digits.
fn number(x: f64) -> String {
    if x == 0.0 || (1e-3..1e4).contains(&x.abs()) {
        format!("{}", format!("{x:.2e}").parse::<f64>().unwrap_or(x))
    } else {
        format!("{x:.1e}")
    }
}

fn reciprocity(grid: &Grid, member: &str) -> String {
    let mut picture = Picture::new(&format!("Reciprocity of {member}"));
    let label = "|f(wi, wo) − f(wo, wi)|, relative";
    map(
        &mut picture,
        grid,
        [Axis::degrees("polar angle θi of wi"), Axis::degrees("polar angle θo of wo")],
        -16.0..0.0,
        label,
    );
    picture.finish()
}

fn sweep(parameter: &str, grid: &Grid, member: &str) -> String {
    let mut picture = Picture::new(&format!("Single precision of {member}"));
    let (low, high) = (grid.y.first().copied().unwrap_or(0.0), grid.y.last().copied().unwrap_or(1.0));
    // Evenly spread values belong to an even axis.
    let even = grid.y.get(1).is_none_or(|second| (second - low) * 2.0 > (high - low) / grid.y.len() as f64);
    let y = if even || low <= 0.0 {
        Axis::linear(parameter, low, high)
    } else {
        Axis { low, high, ..Axis::logarithmic(&format!("{parameter} (logarithmic)"), low, high) }.trimmed()
    };
    map(
        &mut picture,
        grid,
        [Axis::degrees("polar angle θo of wo"), y],
        -8.0..0.0,
        "worst relative deviation of f32 from f64",
    );
    picture.finish()
}

impl Axis {
    /// Without the ticks outside of the range.
    fn trimmed(mut self) -> Self {
        let (low, high) = (self.low * 0.999, self.high * 1.001);
        self.ticks.retain(|(value, _)| (low..=high).contains(value));
        self
    }
}

/// Viridis at five places, even to the eye and to every kind of it.
const RAMP: [[f64; 3]; 5] =
    [[68.0, 1.0, 84.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 201.0, 98.0], [253.0, 231.0, 37.0]];

/// The colour of a cell without a value.
const NOTHING: &str = "#b8b8b8";

fn colour(share: f64) -> String {
    let t = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) } * 4.0;
    let i = (t as usize).min(3);
    let part = t - i as f64;
    let (a, b) = (RAMP.get(i).unwrap_or(&RAMP[0]), RAMP.get(i + 1).unwrap_or(&RAMP[4]));
    let [r, g, b] = [0, 1, 2].map(|c| (a[c] + (b[c] - a[c]) * part).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// A map of powers of ten, with its key.
fn map(picture: &mut Picture, grid: &Grid, [x, y]: [Axis; 2], range: core::ops::Range<f64>, label: &str) {
    let plane = Plane::new(x, y, 96.0);
    plane.draw(picture);
    let paint = |value: f64| {
        // Where nothing could be compared there is no colour of the ramp.
        let share = (value - range.start) / (range.end - range.start);
        Some(if value.is_nan() { NOTHING.to_owned() } else { colour(share) })
    };
    cells(picture, &plane, grid, paint);
    if grid.values.iter().any(|value| value.is_nan()) {
        let [left, _, _, bottom] = plane.area;
        picture.rectangle([left, bottom + 29.0], [left + 12.0, bottom + 41.0], NOTHING, "");
        picture.text([left + 17.0, bottom + 40.0], "start", "not finite", "font-size=\"11\"");
    }
    plane.frame(picture);
    let [_, top, right, bottom] = plane.area;
    let (left, steps) = (right + 28.0, 64);
    let height = (bottom - top) / f64::from(steps);
    for step in 0..steps {
        let y = bottom - height * f64::from(step);
        let shade = colour((f64::from(step) + 0.5) / f64::from(steps));
        // Half a pixel more, or the seams show.
        picture.rectangle([left, y], [left + 16.0, y - height - 0.5], &shade, "");
    }
    for tick in (range.start as i32..=range.end as i32).step_by(if range.end - range.start > 10.0 { 4 } else { 2 }) {
        let y = bottom - (bottom - top) * (f64::from(tick) - range.start) / (range.end - range.start);
        let below = if f64::from(tick) == range.start { "≤" } else { "" };
        picture.text([left + 22.0, y + 4.0], "start", &format!("{below}{}", power_of_ten(tick)), "");
    }
    let y = 0.5 * (top + bottom);
    let x = right + 18.0;
    picture.text([x, y], "middle", label, &format!("font-size=\"11\" transform=\"rotate(-90 {x} {y})\""));
}

/// The cells of a map, each reaching half way to its neighbours.
fn cells(picture: &mut Picture, plane: &Plane, grid: &Grid, paint: impl Fn(f64) -> Option<String>) {
    let edges = |values: &[f64], low: f64, high: f64| -> Vec<f64> {
        let between = values.windows(2).map(|pair| if let [a, b] = pair { 0.5 * (a + b) } else { low });
        core::iter::once(low).chain(between).chain([high]).collect()
    };
    let xs = edges(&grid.x, plane.x.low, plane.x.high);
    let ys = edges(&grid.y, plane.y.low, plane.y.high);
    for (row, ends) in grid.values.chunks(grid.x.len().max(1)).zip(ys.windows(2)) {
        let mut start = 0;
        while let Some(&value) = row.get(start) {
            // Neighbours of one colour are one rectangle.
            let fill = paint(value);
            let run = row.iter().skip(start).take_while(|other| paint(**other) == fill).count().max(1);
            if let (Some(fill), [y0, y1], Some(&x0), Some(&x1)) = (fill, ends, xs.get(start), xs.get(start + run)) {
                picture.rectangle(plane.at(x0, *y0), plane.at(x1, *y1), &fill, "shape-rendering=\"crispEdges\"");
            }
            start += run;
        }
    }
}

fn validity(grid: &Grid, member: &str) -> String {
    let mut picture = Picture::new(&format!("Negative and non-finite values of {member}"));
    let plane = Plane::new(Axis::degrees("polar angle θi of wi"), Axis::degrees("polar angle θo of wo"), 130.0);
    plane.draw(&mut picture);
    const KINDS: [(&str, &str); 3] = [("#eaf3fa", "fine"), ("#e69f00", "negative"), ("#000000", "NaN or infinite")];
    let kind = |value: f64| {
        let index = if value >= BROKEN { 2 } else { usize::from(value >= NEGATIVE) };
        KINDS.get(index).map(|(fill, _)| (*fill).to_owned())
    };
    cells(&mut picture, &plane, grid, kind);
    plane.frame(&mut picture);
    let [_, top, right, _] = plane.area;
    for (index, (fill, name)) in KINDS.iter().enumerate() {
        let y = top + 8.0 + 22.0 * index as f64;
        picture.rectangle([right + 14.0, y], [right + 28.0, y + 14.0], fill, "stroke=\"#222222\" stroke-width=\"0.5\"");
        picture.text([right + 34.0, y + 12.0], "start", name, "");
    }
    picture.finish()
}

/// Grey and small, on a white rim: a curve may run behind it.
const HALO: &str = "fill=\"#666666\" font-size=\"11\" stroke=\"#ffffff\" stroke-width=\"3\" paint-order=\"stroke\"";

fn precision(curves: &[Series], member: &str) -> String {
    let finite = || curves.iter().flat_map(|curve| &curve.y).copied().filter(|y| *y > 0.0 && y.is_finite());
    let y = Axis::logarithmic(
        "relative deviation from f64",
        finite().fold(1e-8, f64::min).max(1e-9),
        // A decade more than the curves need holds the legend.
        finite().fold(1e-6, f64::max) * 10.0,
    );
    let plane = Plane::new(Axis::degrees("polar angle θo of wo"), y, 0.0);
    let mut picture = Picture::new(&format!("Precision of {member}"));
    plane.draw(&mut picture);
    let rounding = f64::from(f32::EPSILON) * 0.5;
    let [x, y] = plane.at(0.0, rounding);
    picture.line(&[[x, y], plane.at(90.0, rounding)], Stroke { colour: "#666666", dash: "2 3", width: 1.0 });
    picture.text([x + 6.0, y - 4.0], "start", "one rounding of f32", HALO);
    for (index, curve) in curves.iter().enumerate() {
        let stroke = Stroke::of(index);
        let points = curve.x.iter().zip(&curve.y).filter(|(_, y)| y.is_finite());
        picture.line(&points.map(|(&x, &y)| plane.at(x, y)).collect::<Vec<_>>(), stroke);
        picture.legend([plane.area[0] + 12.0, plane.area[1] + 20.0 + 18.0 * index as f64], stroke, &curve.name);
    }
    plane.frame(&mut picture);
    picture.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures() -> Figures {
        let grid = |value| Grid { x: vec![0.0, 45.0, 89.9], y: vec![0.0, 89.9], values: vec![value; 6] };
        let series = |name: &str, y: f64| Series {
            name: name.into(),
            x: vec![0.0, 45.0, 89.9],
            y: vec![0.5, y, 0.1],
            error: vec![0.1; 3],
        };
        Figures {
            parameters: vec![("roughness".into(), 0.25)],
            albedo: vec![series("view fixed", 1.3), series("light fixed", f64::NAN)],
            lobes: vec![series("θi = 30°", 100.0), series("θi = 60°", -1.0)],
            reciprocity: grid(f64::NEG_INFINITY),
            validity: grid(NEGATIVE),
            precision: vec![series("f32, worst", 1e-3)],
            sweep: Some(("alpha & <x>".into(), Grid { y: vec![1e-3, 1.0], ..grid(-4.0) })),
        }
    }

    #[test]
    fn every_picture_is_xml_with_numbers_inside_its_frame() {
        let empty = Figures::default();
        for plot in Plot::ALL {
            for figures in [figures(), empty.clone()] {
                let Some(svg) = plot.draw(&figures, "<a> & b", true) else {
                    assert!(figures == empty, "{plot:?}");
                    continue;
                };
                let document = roxmltree::Document::parse(&svg).unwrap_or_else(|e| panic!("{plot:?}: {e}\n{svg}"));
                assert!(!svg.contains("\"NaN") && !svg.contains("\"inf"), "{svg}");
                let root = document.root_element();
                assert!(root.descendants().any(|n| n.tag_name().name() == "title" && n.text().is_some()));
                for node in root.descendants().filter(|n| n.tag_name().name() == "polyline") {
                    for point in node.attribute("points").expect("points").split(' ') {
                        let (x, y) = point.split_once(',').expect("x,y");
                        let [x, y] = [x, y].map(|c| c.parse::<f64>().expect("a number"));
                        assert!((0.0..=SIZE[0]).contains(&x) && (0.0..=SIZE[1]).contains(&y), "{plot:?} {point}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_exceeds_one_lies_in_the_red_zone() {
        let svg = Plot::Albedo.draw(&figures(), "s", true).expect("a picture");
        let document = roxmltree::Document::parse(&svg).expect("XML");
        let number =
            |node: roxmltree::Node<'_, '_>, name: &str| node.attribute(name).and_then(|x| x.parse::<f64>().ok());
        let zone = document.descendants().find(|n| n.attribute("fill") == Some("#d00000")).expect("a red zone");
        let floor = number(zone, "y").expect("y") + number(zone, "height").expect("height");
        let heights: Vec<f64> = document
            .descendants()
            .filter(|n| n.tag_name().name() == "circle" && n.attribute("fill") == Some("#0072b2"))
            .filter_map(|n| number(n, "cy"))
            .collect();
        assert_eq!(heights.iter().map(|y| *y < floor).collect::<Vec<_>>(), [false, true, false]);
        assert!(svg.contains("roughness=0.25") && svg.contains("polar angle θ of the fixed direction"));
    }

    #[test]
    fn colours_run_from_dark_to_light() {
        assert_eq!((colour(0.0), colour(1.0)), ("#440154".into(), "#fde725".into()));
        assert_eq!((colour(f64::NAN), colour(9.0)), (colour(0.0), colour(1.0)));
    }
}
