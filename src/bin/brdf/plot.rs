//! `brdf plot`: pictures of terms and of what `brdf check` judges, as SVG.

use crate::check::portrait::Portrait;
use crate::failure::Failure;
use crate::output::Destination;
use brdf::check::output::plots::Plot;
use brdf::fresnel;
use brdf::material::metal;
use clap::{Args, Subcommand};
use plotters::prelude::*;
use serde_json::{Value, json};
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// What `brdf plot` is asked for.
#[derive(Args)]
pub(crate) struct Options {
    #[command(subcommand)]
    picture: Picture,
}

#[derive(Subcommand)]
enum Picture {
    /// Fresnel reflectance against the angle: exact, and what approximations make of it.
    Fresnel(FresnelOptions),
    /// Albedo against the angle, of both marginals, with its error.
    Albedo(SubjectOptions),
    /// f in the plane of incidence as a polar diagram.
    Lobes(SubjectOptions),
    /// Where f(wi, wo) and f(wo, wi) differ.
    Reciprocity(SubjectOptions),
    /// Where f is negative, NaN or infinite.
    Validity(SubjectOptions),
    /// Deviation of single precision and of a GPU from double precision, against the angle.
    Precision(SubjectOptions),
    /// Deviation of single precision against the angle and a parameter.
    Sweep(SubjectOptions),
}

#[derive(Args)]
struct SubjectOptions {
    #[command(flatten)]
    portrait: Portrait,
    /// Radii of lobes in proportion to f, instead of over three decades.
    #[arg(long)]
    linear: bool,
    /// Write here instead of to the standard output.
    #[arg(long, short)]
    output: Option<PathBuf>,
}

#[derive(Args)]
struct FresnelOptions {
    /// A metal of `brdf list`; its red channel is drawn.
    #[arg(long, default_value = "chromium_elek")]
    metal: String,
    /// The index of the dielectric beside it.
    #[arg(long, default_value_t = 1.5, value_parser = positive)]
    n: f64,
    /// Print the points of the curves as JSON instead of a picture.
    #[arg(long)]
    json: bool,
    /// Write here instead of to the standard output.
    #[arg(long, short)]
    output: Option<PathBuf>,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(n) if n > 0.0 && n.is_finite() => Ok(n),
        _ => Err("must be a number greater than 0".to_owned()),
    }
}

pub(crate) fn run(options: &Options) -> Result<ExitCode, Failure> {
    match &options.picture {
        Picture::Fresnel(options) => fresnel_picture(options),
        Picture::Albedo(options) => subject_picture(options, Plot::Albedo),
        Picture::Lobes(options) => subject_picture(options, Plot::Lobes),
        Picture::Reciprocity(options) => subject_picture(options, Plot::Reciprocity),
        Picture::Validity(options) => subject_picture(options, Plot::Validity),
        Picture::Precision(options) => subject_picture(options, Plot::Precision),
        Picture::Sweep(options) => subject_picture(options, Plot::Sweep),
    }
}

fn subject_picture(options: &SubjectOptions, plot: Plot) -> Result<ExitCode, Failure> {
    let (name, figures) = options.portrait.sample()?;
    let picture = plot.draw(&figures, &name, !options.linear);
    let picture = picture.ok_or_else(|| match plot {
        Plot::Sweep => format!("{name}: no parameter to sweep, or no single precision"),
        _ => format!("{name}: there is no single precision to compare"),
    })?;
    put(&options.output, &picture)
}

fn fresnel_picture(options: &FresnelOptions) -> Result<ExitCode, Failure> {
    let metal = metal::by_name(&options.metal)
        .ok_or_else(|| format!("--metal {}: no such metal; see `brdf list`", options.metal))?;
    let panels = panels(metal, options.n);
    let picture = if options.json {
        format!("{:#}\n", as_json(&panels))
    } else {
        picture(&panels).map_err(|error| format!("the picture could not be drawn: {error}"))?
    };
    put(&options.output, &picture)
}

fn put(path: &Option<PathBuf>, picture: &str) -> Result<ExitCode, Failure> {
    match path {
        Some(path) => {
            Destination::write_all(&[(&Destination::new(path)?, picture.to_owned())])?;
        }
        None => io::stdout().lock().write_all(picture.as_bytes())?,
    }
    Ok(ExitCode::SUCCESS)
}

/// A curve: its label, its colour, its reflectance for a cosine.
struct Curve<'a> {
    label: &'static str,
    colour: RGBColor,
    reflectance: Box<dyn Fn(f64) -> f64 + 'a>,
}

// Okabe & Ito's palette, told apart by every kind of eye.
const BLACK_LINE: RGBColor = RGBColor(0, 0, 0);
const ORANGE: RGBColor = RGBColor(213, 94, 0);
const BLUE_LINE: RGBColor = RGBColor(0, 114, 178);
const GREEN_LINE: RGBColor = RGBColor(0, 158, 115);
const PINK: RGBColor = RGBColor(204, 121, 167);

/// A diagram: its title, the range of the reflectance, its curves.
struct Panel<'a> {
    title: String,
    range: std::ops::Range<f64>,
    curves: Vec<Curve<'a>>,
}

/// A dielectric of index `eta`, and a metal.
fn panels(metal: &metal::Metal, eta: f64) -> [Panel<'_>; 2] {
    let f0 = fresnel::normal_incidence(eta, 0.0);
    let dielectric = Panel {
        title: format!("dielectric, n = {eta}"),
        range: 0.0..1.0,
        curves: vec![
            curve("exact", BLACK_LINE, move |c| fresnel::dielectric(c, eta).reflectance),
            curve("Schlick", ORANGE, move |c| fresnel::schlick(c, f0).reflectance),
            curve("Mihaylov eq. 3.6", GREEN_LINE, move |c| fresnel::conductor_approx(c, eta, 0.0)),
        ],
    };
    let (n, k) = (metal.n[0], metal.k[0]);
    let fit = fresnel::lazanyi_fit(n, k);
    let f0 = fresnel::normal_incidence(n, k);
    // The tint that makes F82 exact at its own angle.
    let c = 1.0 / 7.0;
    let tint = fresnel::conductor(c, n, k).reflectance / fresnel::schlick(c, f0).reflectance;
    let low = (0..=90).map(|i| fresnel::conductor(f64::from(i).to_radians().cos(), n, k).reflectance);
    let low = (low.fold(1.0, f64::min) * 10.0 - 0.5).floor() / 10.0;
    let conductor = Panel {
        title: format!("{}, red: n + ik = {n} + {k}i", metal.name),
        range: low.max(0.0)..1.0,
        curves: vec![
            curve("exact", BLACK_LINE, move |c| fresnel::conductor(c, n, k).reflectance),
            curve("Lazányi, uncorrected", ORANGE, move |c| fresnel::lazanyi_uncorrected(c, n, k)),
            curve("Lazányi, corrected", BLUE_LINE, move |c| fresnel::lazanyi(c, n, k, fit.a, fit.exponent)),
            curve("Mihaylov eq. 3.6", GREEN_LINE, move |c| fresnel::conductor_approx(c, n, k)),
            curve("F82-tint", PINK, move |c| fresnel::f82_tint(c, f0, tint)),
        ],
    };
    [dielectric, conductor]
}

fn as_json(panels: &[Panel<'_>]) -> Value {
    let curves = |panel: &Panel<'_>| {
        let curve = |curve: &Curve<'_>| json!({"label": curve.label, "points": curve.points().collect::<Vec<_>>()});
        panel.curves.iter().map(curve).collect::<Vec<_>>()
    };
    let panel = |panel: &Panel<'_>| json!({"title": panel.title, "curves": curves(panel)});
    json!({"version": 1, "x": "degrees", "y": "reflectance", "panels": panels.iter().map(panel).collect::<Vec<_>>()})
}

fn picture(panels: &[Panel<'_>; 2]) -> Result<String, Box<dyn std::error::Error>> {
    // Drawn at twice the size it is shown at: coordinates are whole numbers.
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (1920, 840)).into_drawing_area();
        area.fill(&WHITE)?;
        let (left, right) = area.split_horizontally(960);
        for (area, panel) in [left, right].iter().zip(panels) {
            draw(area, panel)?;
        }
        area.present()?;
    }
    Ok(svg)
}

impl Curve<'_> {
    /// Angles in degrees and reflectances, a quarter of a degree apart.
    fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        (0..=360).map(|i| {
            let degrees = f64::from(i) * 0.25;
            (degrees, (self.reflectance)(degrees.to_radians().cos()))
        })
    }
}

fn curve<'a>(label: &'static str, colour: RGBColor, reflectance: impl Fn(f64) -> f64 + 'a) -> Curve<'a> {
    Curve { label, colour, reflectance: Box::new(reflectance) }
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn draw(area: &Area<'_>, panel: &Panel<'_>) -> Result<(), Box<dyn std::error::Error>> {
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.title, ("sans-serif", 34))
        .margin(24)
        .x_label_area_size(80)
        .y_label_area_size(100)
        .build_cartesian_2d(0.0..90.0, panel.range.clone())?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12))
        .x_labels(10)
        .x_label_formatter(&|degrees| format!("{degrees:.0}°"))
        .y_label_formatter(&|reflectance| format!("{reflectance:.2}"))
        .label_style(("sans-serif", 24))
        .x_desc("angle of incidence")
        .y_desc("reflectance F")
        .draw()?;
    for curve in &panel.curves {
        let style = curve.colour.stroke_width(4);
        chart
            .draw_series(LineSeries::new(curve.points(), style))?
            .label(curve.label)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 36, y)], style));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .legend_area_size(48)
        .margin(20)
        .background_style(WHITE.mix(0.85))
        .label_font(("sans-serif", 26))
        .draw()?;
    Ok(())
}
