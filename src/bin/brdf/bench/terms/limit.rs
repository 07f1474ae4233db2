//! How close the exact RGB Torrance–Sparrow batch comes to what the machine allows.

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

/// The exact RGB Torrance–Sparrow BRDF as `formula::RoughConductor` has it over `Single<true>`; what depends on the material
/// alone and what three channels share is counted once or not at all, and no transmittance or G is computed.
///
/// | part | divides | roots | operations |
/// |---|---|---|---|
/// | h = wi + wo, its square, V·H = min(√|h|²/2, 1) | 0 | 1 | 3 + 5 + 2 |
/// | c² with its error, s² | 0 | 0 | 2 + 3 |
/// | a channel: g² as an exact sum | 0 | 0 | 4 + 6 + 2 + 1 |
/// | a channel: modulus, the larger and the smaller root, a and b | 1 | 2 | 2 + 3 + 2 + 3 + 1 |
/// | a channel: (a+c)²+b², the difference a−c | 1 | 0 | 5 + 3 + 2 |
/// | a channel: ac, b²c², the sums of Fq | 0 | 0 | 3 + 3 |
/// | a channel: Fs, Fq, F times the lobe | 2 | 0 | 2 + 3 + 3 + 1 |
/// | Beckmann: guards, tan², the exponent | 2 | 0 | 2 + 4 + 2 |
/// | Beckmann: exp (reduction, polynomial of 6, scaling, ends) | 0 | 0 | 5 + 7 + 3 + 4 |
/// | Beckmann: (1+tan²)², the product, selects | 1 | 0 | 2 + 1 + 2 |
/// | V-cavity: guards, edge, visibility, times D | 2 | 0 | 6 + 1 + 3 + 2 |
const EXACT: Work = Work {
    divides: 3.0 * 4.0 + 3.0 + 2.0,
    roots: 1.0 + 3.0 * 2.0,
    operations: 10.0 + 5.0 + 3.0 * (13.0 + 11.0 + 10.0 + 6.0 + 9.0) + 8.0 + 19.0 + 5.0 + 12.0,
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
    let exact = measured.iter().find(|family| family.name == "whole")?.rows.first()?;
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
