//! The chart of layered stacks.

use super::super::layered::{Measured, VARIANTS, label};
use super::{Axes, COLOURS, plane};
use plotters::prelude::*;

/// The range of errors; what lies outside is drawn on the edge.
const FLOOR: f64 = 1e-3;
const CEILING: f64 = 20.0;
/// The longest time, in nanoseconds.
const LONGEST: f64 = 1e9;

/// The chart of all stacks: a point for each model of each, and the walk as a band of lines, whose error falls as 1/√cost.
pub(in crate::bench) fn layered(measured: &[Measured], walks: u32) -> Result<String, Box<dyn std::error::Error>> {
    // Drawn at twice the size it is shown at: coordinates are whole numbers.
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (1600, 1000)).into_drawing_area();
        area.fill(&WHITE)?;
        let rows = || measured.iter().flat_map(|stack| &stack.rows);
        let fastest = rows().map(|row| row.ns).fold(f64::INFINITY, f64::min);
        let mut chart = plane(
            &area,
            &Axes {
                caption: "layered stacks: error of f against the walk, by cost",
                x: 0.5 * fastest..LONGEST,
                y: FLOOR..CEILING,
                x_name: "time of an evaluation, one thread, all channels",
                y_name: "root mean square of f's relative error",
                y_label: &|error| format!("{} %", 100.0 * error),
            },
        )?;
        let mut named = false;
        for stack in measured {
            let (error, ns, _) = stack.walk();
            let once = error * f64::from(walks).sqrt();
            // From one walk to the edge of the chart.
            let most = (once / FLOOR).powi(2).min(LONGEST / ns).max(1.0);
            let line = [1.0, most].map(|walks| (ns * walks, once / walks.sqrt()));
            let series = chart.draw_series(LineSeries::new(line, BLACK.mix(0.3).stroke_width(3)))?;
            if !named {
                let legend = |(x, y)| PathElement::new([(x, y), (x + 36, y)], BLACK.mix(0.3).stroke_width(3));
                series.label("walk, one line for each stack").legend(legend);
                named = true;
            }
        }
        for ((model, widths), colour) in VARIANTS.into_iter().zip(COLOURS) {
            let points = rows().filter(|row| (row.model, row.widths) == (model, widths) && !row.rms.is_nan());
            let dot = move |(x, y): (f64, f64)| Circle::new((x, y), 9, colour.mix(0.85).filled());
            chart
                .draw_series(points.map(|row| dot((row.ns, row.rms.clamp(FLOOR, CEILING)))))?
                .label(label(model, widths))
                .legend(move |(x, y)| Circle::new((x + 18, y), 9, colour.filled()));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .legend_area_size(48)
            .margin(20)
            .background_style(WHITE.mix(0.85))
            .label_font(("sans-serif", 26))
            .draw()?;
        area.present()?;
    }
    Ok(svg)
}
