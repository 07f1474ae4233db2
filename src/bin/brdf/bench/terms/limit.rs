//! How close the exact RGB Torrance–Sparrow batch comes to what the machine allows.

use super::family::PLANNED;
use super::{Measured, Way};
use crate::bench::machine::Machine;
use crate::failure::Failure;
use brdf::batch::Level;
use serde_json::{Value, json};
use std::fmt;

/// What an evaluation takes, counted by hand.
struct Work {
    divides: f64,
    roots: f64,
    /// Instructions beside them: sums, products, fused or not, comparisons, selects, minima.
    operations: f64,
    /// Read and written.
    bytes: f64,
}

/// The exact RGB Torrance–Sparrow BRDF of a metal as `Plan::evaluate_batch` has it with AVX-512; with AVX2 two more.
///
/// | part | divides | roots | operations |
/// |---|---|---|---|
/// | what is lit: comparisons, selects | 0 | 0 | 5 |
/// | h and what its sums lose | 0 | 0 | 2·6 + 4 |
/// | hx²+hy², hz² and what they lose | 0 | 0 | 16 + 5 |
/// | tan² and what the division leaves | 1 | 0 | 5 |
/// | (V·H)², V·H, 1−(V·H)² and its square | 0 | 1 | 4 + 2 |
/// | exponent and what it loses; exp; D | 0 | 0 | 5 + 14 + 5 |
/// | V-cavity, D·hz, the weight | 0 | 0 | 6 |
/// | a channel: \|w\|, L, √L, x | 0 | 2 | 3 + 2 |
/// | a channel: both means, numerator and denominator, sum | 1 | 0 | 4 + 5 + 2 |
const EXACT: Work = Work {
    divides: 1.0 + 3.0,
    roots: 1.0 + 3.0 * 2.0,
    operations: 5.0 + 16.0 + 21.0 + 5.0 + 6.0 + 24.0 + 6.0 + 3.0 * 16.0,
    // Six numbers in, three out.
    bytes: 4.0 * 9.0,
};

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
    /// The unit that divides and takes roots, busy without a pause.
    divider_ns: f64,
    /// All other operations at the measured peak.
    operations_ns: f64,
    /// The numbers in and out at the measured bandwidth, had they come from memory.
    memory_ns: f64,
}

impl Place {
    fn bound(&self) -> f64 {
        self.divider_ns.max(self.operations_ns).max(self.memory_ns)
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
        Some(Place {
            way: way.clone(),
            ns,
            divider_ns: 1e9 * (EXACT.divides / peak.divides + EXACT.roots / peak.roots),
            operations_ns: 1e9 * EXACT.operations / peak.operations.max(peak.multiply_adds),
            memory_ns: 1e9 * EXACT.bytes / copy,
        })
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
                "divider_ns": place.divider_ns, "operations_ns": place.operations_ns, "memory_ns": place.memory_ns,
                "share_of_bound": place.bound() / place.ns,
            })
        };
        json!({
            "subject": "the exact RGB Torrance–Sparrow batch",
            "divides": EXACT.divides, "roots": EXACT.roots, "operations": EXACT.operations, "bytes": EXACT.bytes,
            "places": self.places.iter().map(place).collect::<Vec<_>>(),
        })
    }

    /// A table of Markdown.
    pub(in crate::bench) fn markdown(&self) -> String {
        let mut text = "| | ns | divides and roots | other operations | memory | bound | reached |\n\
                        |---|---:|---:|---:|---:|---:|---:|\n"
            .to_owned();
        for place in &self.places {
            let numbers = [place.ns, place.divider_ns, place.operations_ns, place.memory_ns, place.bound()];
            let numbers = numbers.map(|ns| format!(" {ns:.2} |")).concat();
            text += &format!("| {} |{numbers} {:.0} % |\n", place.way.label(), 100.0 * place.bound() / place.ns);
        }
        text
    }

    /// What the table is of.
    pub(in crate::bench) fn caption() -> String {
        let Work { divides, roots, operations, bytes } = EXACT;
        format!(
            "An evaluation takes {divides} divides, {roots} roots and {operations} other operations, counted by hand, and \
             moves {bytes} bytes. None can be faster than the largest of three times: the divides and roots, which share a \
             unit, at their measured rates; the other operations at theirs; the bytes at the bandwidth of the memory, had \
             they come from there."
        )
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "the exact RGB Torrance–Sparrow batch and its bound on {}", self.processor)?;
        writeln!(f, "  {}", Self::caption())?;
        write!(
            f,
            "  {:38} {:>8} {:>8} {:>8} {:>8} {:>8}",
            "ns", "measured", "div+sqrt", "others", "memory", "reached"
        )?;
        for place in &self.places {
            let label = place.way.label();
            let Place { ns, divider_ns, operations_ns, memory_ns, .. } = place;
            let share = 100.0 * place.bound() / ns;
            write!(
                f,
                "\n  {label:38} {ns:>8.2} {divider_ns:>8.2} {operations_ns:>8.2} {memory_ns:>8.2} {share:>6.0} %"
            )?;
        }
        Ok(())
    }
}
