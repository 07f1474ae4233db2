//! Diagrams as SVG text: axes with ticks and labels, curves, bands, maps, a legend.

use core::fmt::Write;

/// Okabe & Ito's palette, told apart by every kind of eye: blue, vermilion, green, purple, orange, sky blue.
pub(super) const COLOURS: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];

/// Dashes that tell curves apart without colour.
pub(super) const DASHES: [&str; 4] = ["none", "7 3", "2 3", "9 3 2 3"];

const INK: &str = "#222222";

/// The size of a picture, in pixels.
pub(super) const SIZE: [f64; 2] = [600.0, 420.0];

/// The area between the axes: left, top, right, bottom.
const AREA: [f64; 4] = [72.0, 44.0, 580.0, 362.0];

/// An axis: its label with the unit, its range, its ticks.
pub(super) struct Axis {
    pub(super) label: String,
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) logarithmic: bool,
    pub(super) ticks: Vec<(f64, String)>,
}

impl Axis {
    /// Polar angles from 0° to 90°.
    pub(super) fn degrees(label: &str) -> Self {
        let ticks = (0..=6).map(|i| 15.0 * f64::from(i)).map(|x| (x, format!("{x}°"))).collect();
        Axis { label: label.into(), low: 0.0, high: 90.0, logarithmic: false, ticks }
    }

    /// An even axis with about five round ticks.
    pub(super) fn linear(label: &str, low: f64, high: f64) -> Self {
        let span = if high - low > 0.0 && (high - low).is_finite() { high - low } else { 1.0 };
        let rough = span / 5.0;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|s| *s >= rough).unwrap_or(rough);
        let decimals = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
        let first = (low / step).ceil();
        let ticks = (0..12)
            .map(|i| (first + f64::from(i)) * step)
            .filter(|x| *x <= low + span * 1.000_001)
            .map(|x| (x, format!("{x:.decimals$}")))
            .collect();
        Axis { label: label.into(), low, high: low + span, logarithmic: false, ticks }
    }

    /// A logarithmic axis over whole decades, a tick every so many that there are at most eight.
    pub(super) fn logarithmic(label: &str, low: f64, high: f64) -> Self {
        let low = low.max(1e-300);
        let (from, to) = (low.log10().floor() as i32, high.max(low * 10.0).log10().ceil() as i32);
        let every = ((to - from) / 8 + 1).max(1);
        let ticks = (from..=to).filter(|n| (n - from) % every == 0).map(|n| (10f64.powi(n), power_of_ten(n))).collect();
        Axis { label: label.into(), low: 10f64.powi(from), high: 10f64.powi(to), logarithmic: true, ticks }
    }

    /// Where a value lies between the ends, in [0, 1].
    fn share(&self, value: f64) -> f64 {
        let share = if self.logarithmic {
            (value.max(self.low) / self.low).log10() / (self.high / self.low).log10()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) }
    }
}

/// 10ⁿ as a reader writes it.
pub(super) fn power_of_ten(n: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    match n {
        -2..=3 => format!("{}", 10f64.powi(n)),
        _ => {
            let digits = n.unsigned_abs().to_string();
            let raised: String = digits.chars().filter_map(|c| DIGITS.get(c.to_digit(10)? as usize)).collect();
            format!("10{}{raised}", if n < 0 { "⁻" } else { "" })
        }
    }
}

/// Text for an element or an attribute: escaped, and without the control characters that XML cannot hold.
pub(super) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\n' | '\t' => out.push(c),
            // XML 1.0, production 2.
            c if c < ' ' || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// How a line is drawn.
#[derive(Clone, Copy)]
pub(super) struct Stroke {
    pub(super) colour: &'static str,
    pub(super) dash: &'static str,
    pub(super) width: f64,
}

impl Stroke {
    /// The stroke of the `index`-th curve.
    pub(super) fn of(index: usize) -> Self {
        let pick = |list: &[&'static str]| list.get(index % list.len().max(1)).copied().unwrap_or(INK);
        Stroke { colour: pick(&COLOURS), dash: pick(&DASHES), width: 2.0 }
    }
}

/// A picture in the making.
pub(super) struct Picture {
    body: String,
}

impl Picture {
    /// An empty picture under a title.
    pub(super) fn new(title: &str) -> Self {
        let mut picture = Picture { body: String::new() };
        let [width, height] = SIZE;
        let _ = write!(
            picture.body,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
             role=\"img\" font-family=\"'DejaVu Sans', 'Helvetica Neue', Arial, sans-serif\" font-size=\"12\" fill=\"{INK}\">\n\
             <title>{}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n",
            escape(title)
        );
        // What does not fit on one line is cut: the page has the whole name above.
        let short: String =
            if title.chars().count() > 74 { title.chars().take(73).chain(['…']).collect() } else { title.into() };
        picture.text([SIZE[0] / 2.0, 24.0], "middle", &short, "font-size=\"14\" font-weight=\"bold\"");
        picture
    }

    /// The finished text.
    pub(super) fn finish(mut self) -> String {
        self.body.push_str("</svg>\n");
        self.body
    }

    /// A text whose anchor (`start`, `middle`, `end`) is at a point.
    pub(super) fn text(&mut self, [x, y]: [f64; 2], anchor: &str, text: &str, more: &str) {
        let text = escape(text);
        let _ = writeln!(self.body, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" {more}>{text}</text>");
    }

    /// A line through points.
    pub(super) fn line(&mut self, points: &[[f64; 2]], stroke: Stroke) {
        if points.len() < 2 {
            return;
        }
        let Stroke { colour, dash, width } = stroke;
        let points = coordinates(points);
        let _ = writeln!(
            self.body,
            "<polyline points=\"{points}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" \
             stroke-dasharray=\"{dash}\" stroke-linejoin=\"round\"/>"
        );
    }

    /// A filled outline.
    pub(super) fn area(&mut self, points: &[[f64; 2]], colour: &str, opacity: f64) {
        let points = coordinates(points);
        let _ = writeln!(self.body, "<polygon points=\"{points}\" fill=\"{colour}\" fill-opacity=\"{opacity}\"/>");
    }

    /// A rectangle between two corners.
    pub(super) fn rectangle(&mut self, [x0, y0]: [f64; 2], [x1, y1]: [f64; 2], colour: &str, more: &str) {
        let (x, y, width, height) = (x0.min(x1), y0.min(y1), (x1 - x0).abs(), (y1 - y0).abs());
        let _ = writeln!(
            self.body,
            "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"{colour}\" {more}/>"
        );
    }

    /// A dot.
    pub(super) fn dot(&mut self, [x, y]: [f64; 2], colour: &str) {
        let _ = writeln!(self.body, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{colour}\"/>");
    }

    /// A legend entry at a point.
    pub(super) fn legend(&mut self, [x, y]: [f64; 2], stroke: Stroke, name: &str) {
        self.line(&[[x, y - 4.0], [x + 28.0, y - 4.0]], stroke);
        self.text([x + 34.0, y], "start", name, "");
    }
}

fn coordinates(points: &[[f64; 2]]) -> String {
    points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ")
}

/// The area between two axes, on which values have places.
pub(super) struct Plane {
    pub(super) x: Axis,
    pub(super) y: Axis,
    /// Left, top, right, bottom.
    pub(super) area: [f64; 4],
}

impl Plane {
    /// Between two axes; `margin` pixels are left free on the right.
    pub(super) fn new(x: Axis, y: Axis, margin: f64) -> Self {
        let [left, top, right, bottom] = AREA;
        Plane { x, y, area: [left, top, right - margin, bottom] }
    }

    /// The place of a pair of values; what lies outside is moved to the edge.
    pub(super) fn at(&self, x: f64, y: f64) -> [f64; 2] {
        let [left, top, right, bottom] = self.area;
        [left + (right - left) * self.x.share(x), bottom - (bottom - top) * self.y.share(y)]
    }

    /// Draws the axes; the grid lies below what is drawn afterwards.
    pub(super) fn draw(&self, picture: &mut Picture) {
        let [left, top, right, bottom] = self.area;
        let grid = Stroke { colour: "#dddddd", dash: "none", width: 1.0 };
        for (value, label) in &self.x.ticks {
            let [x, _] = self.at(*value, self.y.low);
            picture.line(&[[x, top], [x, bottom]], grid);
            picture.text([x, bottom + 17.0], "middle", label, "");
        }
        for (value, label) in &self.y.ticks {
            let [_, y] = self.at(self.x.low, *value);
            picture.line(&[[left, y], [right, y]], grid);
            picture.text([left - 6.0, y + 4.0], "end", label, "");
        }
        self.frame(picture);
        picture.text([0.5 * (left + right), bottom + 40.0], "middle", &self.x.label, "");
        let (x, y) = (18.0, 0.5 * (top + bottom));
        picture.text([x, y], "middle", &self.y.label, &format!("transform=\"rotate(-90 {x} {y})\""));
    }

    /// Draws the outline alone, over what was drawn.
    pub(super) fn frame(&self, picture: &mut Picture) {
        let [left, top, right, bottom] = self.area;
        picture.rectangle([left, top], [right, bottom], "none", "stroke=\"#222222\" stroke-width=\"1\"");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let axis = Axis::linear("albedo", 0.0, 1.1);
        let labels: Vec<&str> = axis.ticks.iter().map(|(_, label)| label.as_str()).collect();
        assert_eq!(labels, ["0.0", "0.5", "1.0"]);
        let axis = Axis::logarithmic("x", 3e-8, 0.5);
        assert!((axis.low, axis.high) == (1e-8, 1.0) && axis.ticks.len() <= 9, "{:?}", axis.ticks);
        for (low, high) in [(0.0, 0.0), (f64::NAN, f64::NAN), (0.0, f64::INFINITY), (-1e300, 1e300), (5.0, 1.0)] {
            assert!(Axis::linear("x", low, high).ticks.len() <= 12);
        }
        assert_eq!([power_of_ten(-12), power_of_ten(-1), power_of_ten(4)], ["10⁻¹²", "0.1", "10⁴"]);
    }

    #[test]
    fn text_is_escaped() {
        assert_eq!(escape("a<b>&\"c\"\u{0}\u{7}'"), "a&lt;b&gt;&amp;&quot;c&quot;\u{fffd}\u{fffd}&#39;");
    }

    #[test]
    fn values_outside_stay_in_the_picture() {
        let plane = Plane::new(Axis::degrees("θ"), Axis::linear("A", 0.0, 1.0), 0.0);
        for value in [f64::NAN, f64::INFINITY, -1e300, 1e9] {
            let [x, y] = plane.at(value, value);
            assert!((0.0..=SIZE[0]).contains(&x) && (0.0..=SIZE[1]).contains(&y), "{value}: {x} {y}");
        }
    }
}
