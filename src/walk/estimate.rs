//! Means over many walks: in blocks of fixed size, so that the result does not depend on the number of threads.

use super::interface::Source;
use super::{Estimate, Options};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Walks per block: long enough that a block outweighs its book-keeping, short enough to share out.
const BLOCK: u32 = 1024;

/// Count, mean and sum of squared deviations, by Welford's update (Chan, Golub & LeVeque 1979, eq. 2.1 for the merge).
#[derive(Clone, Copy, Debug)]
struct Moments<const K: usize> {
    count: f64,
    mean: [f64; K],
    squares: [f64; K],
}

impl<const K: usize> Moments<K> {
    const EMPTY: Self = Moments { count: 0.0, mean: [0.0; K], squares: [0.0; K] };

    fn add(&mut self, value: [f64; K]) {
        self.count += 1.0;
        for (c, value) in value.into_iter().enumerate() {
            let off = value - self.mean[c];
            self.mean[c] += off / self.count;
            self.squares[c] += off * (value - self.mean[c]);
        }
    }

    fn merge(&mut self, other: &Self) {
        let count = self.count + other.count;
        for c in 0..K {
            let off = other.mean[c] - self.mean[c];
            self.mean[c] += off * other.count / count;
            self.squares[c] += other.squares[c] + off * off * self.count * other.count / count;
        }
        self.count = count;
    }
}

/// The mean of `walk` over the samples that the options ask for.
pub(super) fn mean<const K: usize>(options: &Options, walk: impl Fn(Source) -> [f64; K] + Sync) -> Estimate<K> {
    let samples = options.samples.max(2);
    let blocks = samples.div_ceil(BLOCK) as usize;
    let run = |block: usize| {
        let first = block as u32 * BLOCK;
        let mut moments = Moments::EMPTY;
        for index in first..first.saturating_add(BLOCK).min(samples) {
            moments.add(walk(Source { seed: options.seed, index }));
        }
        moments
    };
    let threads = match options.threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        some => some,
    };
    let mut whole = Moments::EMPTY;
    if threads.min(blocks) <= 1 {
        (0..blocks).for_each(|block| whole.merge(&run(block)));
    } else {
        let next = AtomicUsize::new(0);
        let done = Mutex::new(vec![None; blocks]);
        std::thread::scope(|scope| {
            for _ in 0..threads.min(blocks) {
                scope.spawn(|| {
                    loop {
                        let block = next.fetch_add(1, Ordering::Relaxed);
                        if block >= blocks {
                            break;
                        }
                        let moments = run(block);
                        // A poisoned lock means that another block panicked, which the scope reports.
                        if let Ok(mut done) = done.lock() {
                            done[block] = Some(moments);
                        }
                    }
                });
            }
        });
        // In order: sums of floats depend on it.
        let done = done.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
        done.iter().flatten().for_each(|moments| whole.merge(moments));
    }
    let variance = whole.squares.map(|squares| squares / (whole.count * (whole.count - 1.0)));
    Estimate { mean: whole.mean, standard_error: variance.map(f64::sqrt), samples }
}
