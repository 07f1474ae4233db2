//! `brdf render --gallery DIR`: the documents' figures, with the materials of this crate.

mod figures;
mod panel;

use crate::failure::Failure;
use brdf::render::Film;
use brdf::render::film::Tally;
use figures::FIGURES;
use serde_json::json;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

/// A figure: panels in rows.
pub(crate) struct Figure {
    /// The name of its file, without extension.
    name: &'static str,
    /// Which figure of which document it is, and what its panels are.
    about: &'static str,
    /// Stops by which it is exposed.
    exposure: f64,
    /// Makes the panels, row by row.
    panels: fn() -> Result<Vec<Vec<Film>>, Failure>,
}

/// Pixels between panels.
const GAP: u32 = 4;

/// Writes every figure, or those whose name contains `only`, as PNG into a folder.
pub(crate) fn run(folder: &Path, only: Option<&str>, as_json: bool) -> Result<ExitCode, Failure> {
    let chosen: Vec<&Figure> =
        FIGURES.iter().filter(|figure| only.is_none_or(|only| figure.name.contains(only))).collect();
    if chosen.is_empty() {
        let names = FIGURES.iter().map(|figure| figure.name).collect::<Vec<_>>().join(", ");
        return Err(format!("no figure is called {}; there are {names}", only.unwrap_or_default()).into());
    }
    std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut out = io::stdout().lock();
    let mut reports = Vec::new();
    for figure in chosen {
        let start = Instant::now();
        let film = assembled(&(figure.panels)()?);
        let path = folder.join(figure.name).with_extension("png");
        film.write(&path, figure.exposure)?;
        let seconds = start.elapsed().as_secs_f64();
        if as_json {
            reports.push(json!({"file": path.display().to_string(), "about": figure.about, "seconds": seconds}));
        } else {
            writeln!(out, "{:28} {seconds:6.1} s  {}", format!("{}.png", figure.name), figure.about)?;
        }
    }
    if as_json {
        writeln!(out, "{:#}", serde_json::Value::from(reports))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// One picture of panels in rows, black between them.
fn assembled(rows: &[Vec<Film>]) -> Film {
    let wide = |row: &Vec<Film>| row.iter().map(|film| film.width() + GAP).sum::<u32>().saturating_sub(GAP);
    let high = |row: &Vec<Film>| row.iter().map(Film::height).max().unwrap_or(0);
    let width = rows.iter().map(wide).max().unwrap_or(0);
    let height = rows.iter().map(|row| high(row) + GAP).sum::<u32>().saturating_sub(GAP);
    let mut pixels = vec![Tally::default(); width as usize * height as usize];
    let mut top = 0;
    for row in rows {
        let mut left = 0;
        for film in row {
            for (index, value) in film.mean().iter().enumerate() {
                let (x, y) = (index as u32 % film.width(), index as u32 / film.width());
                let place = ((top + y) * width + left + x) as usize;
                if let Some(pixel) = pixels.get_mut(place) {
                    pixel.add(value.map(f64::from));
                }
            }
            left += film.width() + GAP;
        }
        top += high(row) + GAP;
    }
    Film::new(width, height, &pixels)
}
