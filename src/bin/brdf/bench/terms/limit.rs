//! How close the exact RGB Torrance–Sparrow batch comes to what the machine allows.

use super::family::PLANNED;
use super::{Measured, Way};
use crate::bench::machine::{Machine, WORK, Work};
use crate::failure::Failure;
use brdf::batch::Level;
use serde_json::{Value, json};
use std::fmt;

/// Six numbers read and three written.
const BYTES: f64 = 4.0 * 9.0;

/// A batch beside its bound.
pub(in crate::bench) struct Limit {
    places: Vec<Place>,
    processor: String,
}

/// A level on some threads.
struct Place {
    way: Way,
    /// The time of an evaluation.
    ns: f64,
    /// Its arithmetic where nothing waits for anything.
    arithmetic_ns: f64,
    /// The numbers in and out at the measured bandwidth, had they come from memory.
    memory_ns: f64,
}

impl Place {
    fn bound(&self) -> f64 {
        self.arithmetic_ns.max(self.memory_ns)
    }
}

/// The limit of the exact whole BRDF, where that was measured; the peaks are measured now.
pub(in crate::bench) fn of(measured: &[Measured], quick: bool) -> Result<Option<Limit>, Failure> {
    if measured.iter().any(|family| family.name == "whole") {
        Ok(against(measured, &Machine::measure(quick)?))
    } else {
        Ok(None)
    }
}

/// The limit of the exact whole BRDF under these peaks.
pub(in crate::bench) fn against(measured: &[Measured], machine: &Machine) -> Option<Limit> {
    let whole = measured.iter().find(|family| family.name == "whole")?;
    let exact = whole.rows.iter().find(|row| row.name == PLANNED)?;
    let place = |way: &Way, ns: f64, level: Level, threads: usize| {
        let peak = machine.peak(level, threads)?;
        let copy = machine.copy[usize::from(threads > 1)];
        Some(Place { way: way.clone(), ns, arithmetic_ns: 1e9 / peak.work, memory_ns: 1e9 * BYTES / copy })
    };
    let places = exact.points.iter().filter_map(|point| match &point.way {
        Way::Batch(level) => place(&point.way, point.ns, *level, 1),
        Way::Threads(level, threads) => place(&point.way, point.ns, *level, *threads),
        _ => None,
    });
    Some(Limit { places: places.collect(), processor: machine.processor.clone() })
}

impl Limit {
    pub(in crate::bench) fn as_json(&self) -> Value {
        let place = |place: &Place| {
            json!({
                "way": place.way.label(), "ns": place.ns, "bound_ns": place.bound(),
                "arithmetic_ns": place.arithmetic_ns, "memory_ns": place.memory_ns,
                "share_of_bound": place.bound() / place.ns,
            })
        };
        json!({
            "subject": "the exact RGB Torrance–Sparrow batch",
            "products": WORK.products, "sums": WORK.sums, "choices": WORK.choices,
            "divides": WORK.divides, "roots": WORK.roots, "bytes": BYTES,
            "places": self.places.iter().map(place).collect::<Vec<_>>(),
        })
    }

    /// A table of Markdown.
    pub(in crate::bench) fn markdown(&self) -> String {
        let mut text = "| | ns | arithmetic | memory | bound | reached |\n\
                        |---|---:|---:|---:|---:|---:|\n"
            .to_owned();
        for place in &self.places {
            let numbers = [place.ns, place.arithmetic_ns, place.memory_ns, place.bound()];
            let numbers = numbers.map(|ns| format!(" {ns:.2} |")).concat();
            text += &format!("| {} |{numbers} {:.0} % |\n", place.way.label(), 100.0 * place.bound() / place.ns);
        }
        text
    }

    /// What the table is of.
    pub(in crate::bench) fn caption() -> String {
        let Work { products, sums, choices, divides, roots } = WORK;
        format!(
            "An evaluation takes {products} products, {sums} sums, {choices} comparisons, selects and minima, {divides} divides and \
             {roots} roots, counted in its machine code, and moves {BYTES} bytes. None can be faster than the larger of two times: \
             that of the same arithmetic with nothing that waits for anything, measured, and that of the bytes at the bandwidth of \
             the memory, had they come from there."
        )
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "the exact RGB Torrance–Sparrow batch and its bound on {}", self.processor)?;
        writeln!(f, "  {}", Self::caption())?;
        write!(f, "  {:38} {:>8} {:>10} {:>8} {:>8}", "ns", "measured", "arithmetic", "memory", "reached")?;
        for place in &self.places {
            let label = place.way.label();
            let Place { ns, arithmetic_ns, memory_ns, .. } = place;
            let share = 100.0 * place.bound() / ns;
            write!(f, "\n  {label:38} {ns:>8.2} {arithmetic_ns:>10.2} {memory_ns:>8.2} {share:>6.0} %")?;
        }
        Ok(())
    }
}
