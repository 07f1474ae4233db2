//! Proofs in words.

use super::{Answer, Domain, Edge, Proof};
use core::fmt;

impl fmt::Display for Proof {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.subject)?;
        writeln!(f, "  {:12}  {}", "box", self.domain.describe())?;
        for (property, answer) in [("not negative", &self.sign), ("finite", &self.finite)] {
            write!(f, "  {property:12}  ")?;
            print(f, &self.domain, answer)?;
        }
        write!(f, "  {:12}  {}", "bounded", self.boxes)?;
        f.write_str(if self.boxes == 1 { " box, in exact arithmetic" } else { " boxes, in exact arithmetic" })
    }
}

fn print(f: &mut fmt::Formatter<'_>, domain: &Domain, answer: &Answer) -> fmt::Result {
    match answer {
        Answer::Proved => writeln!(f, "PROVED"),
        Answer::Disproved(witness) => {
            let point: Vec<Edge> = witness.point.iter().map(|x| Edge { low: *x, high: *x }).collect();
            writeln!(f, "DISPROVED {:?} at {}", witness.value, domain.describe_region(&point))?;
            let (i, o) = (witness.wi, witness.wo);
            write!(f, "  {:12}  --at wi={}:{}:{},wo={}:{}:{}", "again", i.x, i.y, i.z, o.x, o.y, o.z)?;
            for (axis, value) in domain.axes().iter().zip(domain.parameters_at(&witness.point)) {
                write!(f, ",{}={value}", axis.name)?;
            }
            writeln!(f)
        }
        Answer::Undecided(rest) => {
            let (share, plural) = (100.0 * rest.share, if rest.count == 1 { "" } else { "es" });
            writeln!(f, "UNDECIDED on {share:.3} % of it; the largest of {} box{plural} left:", rest.count)?;
            for (region, bounds) in &rest.worst {
                let undefined = if bounds.is_total() { "" } else { ", or none" };
                let (low, high) = (bounds.low(), bounds.high());
                writeln!(f, "    {}: {low:.3e} to {high:.3e}{undefined}", domain.describe_region(region))?;
            }
            Ok(())
        }
    }
}
