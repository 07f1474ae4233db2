//! The chart of a family of terms: a colour for each variant, a mark for each way to run it.

use super::super::terms::{Measured, Point, Row, Way};
use super::{Area, Axes, COLOURS, Plane, plane};
use brdf::batch::Level;
use plotters::prelude::*;

type Failed = Box<dyn std::error::Error>;

const WIDTH: u32 = 1600;
const HEIGHT: u32 = 1000;
/// The height of the labels' type.
const TYPE: i32 = 26;

/// The shape of a mark.
#[derive(Clone, Copy)]
enum Mark {
    Circle,
    Square,
    Diamond,
    Triangle,
}

/// The chart of a family. An error of 0 is drawn on the lower edge.
pub(in crate::bench) fn terms(family: &Measured) -> Result<String, Failed> {
    let ways = ways(family);
    let shown = || family.rows.iter().flat_map(|row| row.points.iter()).filter(|point| ways.contains(&point.way));
    let span = |value: fn(&Point) -> f64| {
        let values = || shown().map(value).filter(|value| *value > 0.0);
        (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max))
    };
    let (fastest, slowest) = span(|point| point.ns);
    let (least, most) = span(|point| point.error.max);
    // Room for labels at the right, and for the legend above.
    let x = 0.4 * fastest..(slowest * (slowest / fastest).powf(0.25)).max(8.0 * fastest);
    // The share of the height that the legend takes, at the top.
    let share = f64::from(60 + LINE * (ways.len() as i32 + 1)) / f64::from(HEIGHT - 200);
    let y = 0.2 * least..most * (5.0 * most / least).max(10.0).powf(share / (1.0 - share));
    let floor = 0.3 * least;
    let place = |point: &Point| (point.ns, point.error.max.max(floor));

    // Drawn at twice the size it is shown at: coordinates are whole numbers.
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (WIDTH, HEIGHT)).into_drawing_area();
        area.fill(&WHITE)?;
        let error = format!("largest {} error", family.measure.name());
        let mut chart = plane(
            &area,
            &Axes {
                caption: family.title,
                x,
                y,
                x_name: "time of an evaluation",
                y_name: &error,
                y_label: &|error| format!("{error:.0e}"),
            },
        )?;
        for way in &ways {
            let points = family.rows.iter().filter_map(|row| row.points.iter().find(|point| point.way == *way));
            let front = front(points.map(place).collect());
            chart.draw_series(LineSeries::new(front, BLACK.mix(0.35).stroke_width(3)))?;
        }
        let colour = |row: usize| COLOURS[row % COLOURS.len()];
        for (index, row) in family.rows.iter().enumerate() {
            for point in row.points.iter().filter(|point| ways.contains(&point.way)) {
                let centre = chart.backend_coord(&place(point));
                mark(&area, centre, &ways, &point.way, colour(index))?;
            }
        }
        legend(&area, &chart, &ways)?;
        label(&area, &chart, &family.rows, &ways, &place, &colour)?;
        area.present()?;
    }
    Ok(svg)
}

/// The ways that are drawn, in the order of the legend: of the levels the fastest alone.
fn ways(family: &Measured) -> Vec<Way> {
    let mut ways: Vec<Way> = Vec::new();
    for point in family.rows.iter().flat_map(|row| &row.points) {
        let slower = matches!(point.way, Way::Batch(level) if level != Level::detect());
        if !slower && !ways.contains(&point.way) {
            ways.push(point.way.clone());
        }
    }
    ways
}

/// The points that no other one beats in both time and error, as steps.
fn front(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut front: Vec<(f64, f64)> = Vec::new();
    for point in points {
        match front.last().copied() {
            Some((_, error)) if point.1 >= error => {}
            Some((_, error)) => front.extend([(point.0, error), point]),
            None => front.push(point),
        }
    }
    front
}

fn shape(ways: &[Way], way: &Way) -> (Mark, bool) {
    let adapter = |way: &Way| match way {
        Way::Gpu(name, _) => Some(name.clone()),
        _ => None,
    };
    match way {
        Way::Scalar => (Mark::Circle, true),
        Way::Batch(_) => (Mark::Square, true),
        Way::Threads(..) => (Mark::Diamond, true),
        // The first adapter filled, others not.
        Way::Gpu(name, _) => (Mark::Triangle, ways.iter().find_map(adapter).as_ref() == Some(name)),
    }
}

fn mark(area: &Area<'_>, (x, y): (i32, i32), ways: &[Way], way: &Way, colour: RGBColor) -> Result<(), Failed> {
    let (shape, filled) = shape(ways, way);
    let style = if filled { colour.mix(0.85).filled() } else { colour.stroke_width(4) };
    let around = |offsets: &[(i32, i32)]| offsets.iter().map(|(dx, dy)| (x + dx, y + dy)).collect::<Vec<_>>();
    let outline = match shape {
        Mark::Circle => {
            area.draw(&Circle::new((x, y), 10, style))?;
            return Ok(());
        }
        Mark::Square => around(&[(-9, -9), (9, -9), (9, 9), (-9, 9)]),
        Mark::Diamond => around(&[(0, -13), (13, 0), (0, 13), (-13, 0)]),
        Mark::Triangle => around(&[(0, -12), (12, 10), (-12, 10)]),
    };
    if filled {
        area.draw(&Polygon::new(outline, style))?;
    } else {
        let closed: Vec<_> = outline.iter().chain(outline.first()).copied().collect();
        area.draw(&PathElement::new(closed, style))?;
    }
    Ok(())
}

/// A box on the picture: left, top, right, bottom.
type Rectangle = (i32, i32, i32, i32);

fn overlap(a: Rectangle, b: Rectangle) -> i32 {
    (a.2.min(b.2) - a.0.max(b.0)).max(0) * (a.3.min(b.3) - a.1.max(b.1)).max(0)
}

/// The width that a text takes at most.
fn width(text: &str) -> i32 {
    text.chars().count() as i32 * TYPE * 11 / 20
}

fn legend(area: &Area<'_>, chart: &Plane<'_>, ways: &[Way]) -> Result<(), Failed> {
    let (left, top, ..) = legend_place(chart, ways);
    let font = ("sans-serif", TYPE).into_font();
    let mut y = top + 20;
    for way in ways {
        mark(area, (left + 20, y), ways, way, RGBColor(90, 90, 90))?;
        area.draw(&Text::new(way.label(), (left + 50, y - TYPE / 2), font.clone()))?;
        y += LINE;
    }
    area.draw(&PathElement::new(vec![(left + 2, y), (left + 38, y)], BLACK.mix(0.35).stroke_width(3)))?;
    area.draw(&Text::new(FRONT, (left + 50, y - TYPE / 2), font))?;
    Ok(())
}

/// The height of a line of the legend.
const LINE: i32 = 36;

const FRONT: &str = "what no variant beats in both, for each way";

/// The box of the legend, at the upper right.
fn legend_place(chart: &Plane<'_>, ways: &[Way]) -> Rectangle {
    let (_, top) = chart.plotting_area().get_base_pixel();
    let widest = ways.iter().map(|way| width(&way.label())).chain([width(FRONT)]).max().unwrap_or(0);
    let right = WIDTH as i32 - 24;
    (right - widest - 50, top, right, top + 40 + LINE * ways.len() as i32)
}

/// Writes each variant's name once, beside one of its marks where it covers no other mark or name.
fn label(
    area: &Area<'_>,
    chart: &Plane<'_>,
    rows: &[Row],
    ways: &[Way],
    place: &dyn Fn(&Point) -> (f64, f64),
    colour: &dyn Fn(usize) -> RGBColor,
) -> Result<(), Failed> {
    let marks = |row: &Row| -> Vec<(i32, i32)> {
        let shown = row.points.iter().filter(|point| ways.contains(&point.way));
        shown.map(|point| chart.backend_coord(&place(point))).collect()
    };
    let mut taken = vec![legend_place(chart, ways)];
    taken.extend(rows.iter().flat_map(&marks).map(|(x, y)| (x - 13, y - 13, x + 13, y + 13)));
    let (columns, lines) = chart.plotting_area().get_pixel_range();
    for (index, row) in rows.iter().enumerate() {
        let (wide, high) = (width(row.name), TYPE + 4);
        let mut best: Option<(i32, Rectangle)> = None;
        for (x, y) in marks(row) {
            for (dx, dy) in [
                (20, -high / 2),
                (-20 - wide, -high / 2),
                (-wide / 2, -18 - high),
                (-wide / 2, 18),
                (14, -10 - high),
                (14, 10),
                (-14 - wide, -10 - high),
                (-14 - wide, 10),
                (-wide / 2, -22 - 2 * high),
                (-wide / 2, 22 + high),
            ] {
                let at = (x + dx, y + dy, x + dx + wide, y + dy + high);
                let inside = (columns.start.max(0), lines.start, columns.end, lines.end);
                let outside = wide * high - overlap(at, inside);
                let cost = 4 * outside + taken.iter().map(|other| overlap(at, *other)).sum::<i32>();
                if best.is_none_or(|(least, _)| cost < least) {
                    best = Some((cost, at));
                }
            }
        }
        if let Some((_, at)) = best {
            let colour = colour(index);
            let style = TextStyle::from(("sans-serif", TYPE).into_font()).color(&colour);
            area.draw(&Text::new(row.name, (at.0, at.1), style))?;
            taken.push(at);
        }
    }
    Ok(())
}
