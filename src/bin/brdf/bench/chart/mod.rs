//! Error against cost as SVG: both logarithmic, the lower left is better.

mod layered;
mod terms;

pub(super) use layered::layered;
pub(super) use terms::terms;

use plotters::coord::Shift;
use plotters::coord::combinators::LogCoord;
use plotters::prelude::*;
use std::ops::Range;

// Okabe & Ito's palette, told apart by every kind of eye; its yellow, which is lost on white, replaced, and two more.
const COLOURS: [RGBColor; 10] = [
    RGBColor(213, 94, 0),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(0, 0, 0),
    RGBColor(130, 90, 44),
    RGBColor(112, 60, 170),
    RGBColor(120, 120, 120),
];

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Plane<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<LogCoord<f64>, LogCoord<f64>>>;

/// What a chart is of.
struct Axes<'a> {
    caption: &'a str,
    x: Range<f64>,
    y: Range<f64>,
    x_name: &'a str,
    y_name: &'a str,
    y_label: &'a dyn Fn(f64) -> String,
}

/// A logarithmic plane over times in nanoseconds and errors.
fn plane<'a>(area: &Area<'a>, axes: &Axes<'_>) -> Result<Plane<'a>, Box<dyn std::error::Error>> {
    let mut chart = ChartBuilder::on(area)
        .caption(axes.caption, ("sans-serif", 34))
        .margin(24)
        .x_label_area_size(80)
        .y_label_area_size(120)
        .build_cartesian_2d(axes.x.clone().log_scale(), axes.y.clone().log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12))
        .x_label_formatter(&|ns| duration(*ns))
        .y_label_formatter(&|error| (axes.y_label)(*error))
        .label_style(("sans-serif", 24))
        .x_desc(axes.x_name)
        .y_desc(axes.y_name)
        .draw()?;
    Ok(chart)
}

/// A time in the unit that suits it.
fn duration(ns: f64) -> String {
    match ns {
        ns if ns < 0.9995e-3 => format!("{:.0} fs", 1e6 * ns),
        ns if ns < 0.9995 => format!("{:.0} ps", 1e3 * ns),
        ns if ns < 1e3 => format!("{ns:.0} ns"),
        ns if ns < 1e6 => format!("{:.0} µs", ns / 1e3),
        ns if ns < 1e9 => format!("{:.0} ms", ns / 1e6),
        ns => format!("{:.0} s", ns / 1e9),
    }
}
