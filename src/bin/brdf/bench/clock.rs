//! Run times: passes that take turns, so that what disturbs the machine disturbs all of them.

use std::time::{Duration, Instant};

/// How long to measure.
#[derive(Clone, Copy)]
pub(super) struct Budget {
    /// The least time of a pass.
    pub(super) pass: Duration,
    /// Passes of each task.
    pub(super) rounds: usize,
}

impl Budget {
    /// A full measurement, or one that only shows that everything runs.
    pub(super) fn new(quick: bool) -> Self {
        let (micros, rounds) = if quick { (200, 3) } else { (2500, 11) };
        Budget { pass: Duration::from_micros(micros), rounds }
    }
}

/// Something to time.
pub(super) struct Task<'a> {
    run: Box<dyn FnMut() + 'a>,
    /// The evaluations of a run.
    evaluations: f64,
}

impl<'a> Task<'a> {
    pub(super) fn new(evaluations: usize, run: impl FnMut() + 'a) -> Self {
        Task { run: Box::new(run), evaluations: evaluations as f64 }
    }
}

/// The times of a task in nanoseconds an evaluation, ascending.
pub(super) struct Times(Vec<f64>);

impl Times {
    pub(super) fn new(mut times: Vec<f64>) -> Self {
        times.sort_by(f64::total_cmp);
        Times(times)
    }

    pub(super) fn median(&self) -> f64 {
        self.0.get(self.0.len() / 2).copied().unwrap_or(f64::NAN)
    }

    /// For what a machine can do at best.
    pub(super) fn least(&self) -> f64 {
        self.0.first().copied().unwrap_or(f64::NAN)
    }
}

/// Times every task, round by round.
pub(super) fn measure(tasks: &mut [Task<'_>], budget: Budget) -> Vec<Times> {
    let pass = |task: &mut Task<'_>, runs: u32| {
        let start = Instant::now();
        for _ in 0..runs {
            (task.run)();
        }
        start.elapsed()
    };
    let mut calibrated = Vec::with_capacity(tasks.len());
    for task in &mut *tasks {
        pass(task, 1);
        let mut runs = 1;
        loop {
            let elapsed = pass(task, runs);
            if elapsed >= budget.pass || runs >= 1 << 24 {
                break;
            }
            let wanted = budget.pass.as_secs_f64() / elapsed.as_secs_f64().max(1e-7);
            runs = (f64::from(runs) * (1.1 * wanted).clamp(1.2, 64.0)).ceil() as u32;
        }
        calibrated.push((runs, Vec::with_capacity(budget.rounds)));
    }
    for _ in 0..budget.rounds {
        for (task, (runs, times)) in tasks.iter_mut().zip(&mut calibrated) {
            times.push(pass(task, *runs).as_nanos() as f64 / (f64::from(*runs) * task.evaluations));
        }
    }
    calibrated.into_iter().map(|(_, times)| Times::new(times)).collect()
}
