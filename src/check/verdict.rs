//! Verdicts: when a number with an error is a pass, a failure, or neither.

/// The outcome of a check, from the best to the worst.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Verdict {
    /// Within the limit by more than the error.
    Pass,
    /// The error does not allow either answer.
    Inconclusive,
    /// Beyond the limit by more than the error.
    Fail,
}

/// What a limit may be exceeded by before it counts: published fits and tables are no better than this.
pub const TOLERANCE: f64 = 1e-3;

impl Verdict {
    /// Fail if estimate − error > limit + tolerance, pass if estimate + error ≤ limit + tolerance, else inconclusive.
    ///
    /// An estimate or an error that is not a number is inconclusive.
    pub fn of(estimate: f64, error: f64, limit: f64, tolerance: f64) -> Self {
        if estimate - error > limit + tolerance {
            Verdict::Fail
        } else if estimate + error <= limit + tolerance {
            Verdict::Pass
        } else {
            Verdict::Inconclusive
        }
    }

    /// What a process that reports this verdict exits with: 0 plausible, 1 violation, 3 inconclusive (2 is bad input).
    pub const fn exit_code(self) -> u8 {
        match self {
            Verdict::Pass => 0,
            Verdict::Fail => 1,
            Verdict::Inconclusive => 3,
        }
    }

    /// `PASS`, `INCONCLUSIVE` or `FAIL`.
    pub const fn name(self) -> &'static str {
        match self {
            Verdict::Pass => "PASS",
            Verdict::Inconclusive => "INCONCLUSIVE",
            Verdict::Fail => "FAIL",
        }
    }
}

impl core::fmt::Display for Verdict {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule() {
        assert_eq!(Verdict::of(1.0, 1e-4, 1.0, TOLERANCE), Verdict::Pass);
        assert_eq!(Verdict::of(1.0025, 2e-3, 1.0, TOLERANCE), Verdict::Inconclusive);
        assert_eq!(Verdict::of(1.0025, 1e-4, 1.0, TOLERANCE), Verdict::Fail);
        assert_eq!(Verdict::of(f64::NAN, 0.0, 1.0, TOLERANCE), Verdict::Inconclusive);
        assert_eq!(Verdict::of(f64::INFINITY, 0.0, 1.0, TOLERANCE), Verdict::Fail);
        assert!(Verdict::Fail > Verdict::Inconclusive && Verdict::Inconclusive > Verdict::Pass);
    }
}
