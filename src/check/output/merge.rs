//! The shards of one run, put together again.

use super::{OutputError, Run};

impl Run {
    /// The whole run from its shards, in any order: equal to what one process would have reported.
    ///
    /// # Errors
    ///
    /// If the parts are not of one run (other totals, other versions of the program), if one is there twice, or if one is
    /// missing: a farm that lost a job must not pass.
    pub fn merge(parts: Vec<Run>) -> Result<Run, OutputError> {
        let mut parts = parts.into_iter();
        let Some(mut whole) = parts.next() else {
            return Err(OutputError("nothing to merge".into()));
        };
        let mut twins = vec![whole.twins.clone()];
        for part in parts {
            if (&part.tool, part.total) != (&whole.tool, whole.total) {
                return Err(OutputError(format!(
                    "not shards of one run: {} with {} subjects, and {} with {}",
                    whole.tool, whole.total, part.tool, part.total
                )));
            }
            if !twins.contains(&part.twins) {
                twins.push(part.twins);
            }
            whole.entries.extend(part.entries);
        }
        whole.entries.sort_by_key(|entry| entry.index);
        for (at, entry) in whole.entries.iter().enumerate() {
            if entry.index < at {
                return Err(OutputError(format!("{}: in two of the reports; give each shard once", entry.source)));
            }
            if entry.index > at {
                return Err(OutputError(format!(
                    "subject {} of {}: in none of the reports; a shard is missing",
                    at + 1,
                    whole.total
                )));
            }
        }
        if whole.entries.len() != whole.total {
            let (have, total) = (whole.entries.len(), whole.total);
            return Err(OutputError(format!("{have} of {total} subjects are in the reports; a shard is missing")));
        }
        twins.sort();
        whole.twins = twins.join("; ");
        whole.shard = None;
        Ok(whole)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::report;
    use super::super::{Entry, Shard};
    use super::*;
    use crate::check::verdict::Verdict;

    fn whole() -> Run {
        let verdicts = [Verdict::Pass, Verdict::Fail, Verdict::Inconclusive, Verdict::Pass, Verdict::Pass];
        let mut entries: Vec<Entry> = verdicts
            .iter()
            .enumerate()
            .map(|(i, &verdict)| Entry::judged(i, format!("{i}.wgsl"), "WGSL", report(&format!("s{i}"), verdict)))
            .collect();
        entries[3] = Entry::refused(3, "3.wgsl", "WGSL", "torn");
        Run { total: 5, entries, ..Run::new() }
    }

    fn shard(number: usize, of: usize) -> Run {
        let shard = Shard { number, of };
        let mut part = whole();
        part.entries.retain(|entry| shard.holds(entry.index));
        part.shard = Some(shard);
        // By way of a file, as a farm does it.
        Run::from_json(&part.to_json()).expect("our own JSON")
    }

    #[test]
    fn merged_shards_are_the_whole_byte_for_byte() {
        for of in 1..8 {
            let parts = (1..=of).rev().map(|number| shard(number, of)).collect();
            assert_eq!(Run::merge(parts).expect("a whole").to_json(), whole().to_json(), "{of} shards");
        }
    }

    #[test]
    fn lost_doubled_and_foreign_shards_are_refused() {
        let error = |parts| Run::merge(parts).expect_err("no whole").to_string();
        assert!(error(vec![]).contains("nothing"));
        assert!(error(vec![shard(1, 2)]).contains("missing"));
        assert!(error(vec![shard(2, 2)]).contains("missing"));
        assert!(error(vec![shard(1, 3), shard(3, 3)]).contains("missing"));
        assert!(error(vec![shard(1, 2), shard(2, 2), shard(2, 2)]).contains("two"));
        assert!(error(vec![shard(1, 2), Run { total: 6, ..shard(2, 2) }]).contains("not shards of one run"));
        assert!(error(vec![shard(1, 2), Run { tool: "brdf 9".into(), ..shard(2, 2) }]).contains("brdf 9"));
    }
}
