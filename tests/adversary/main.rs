//! A search for the worst input: an evolution strategy over all inputs and parameters that maximises the error in f32, the
//! reciprocity error and the albedo, and that looks for NaN, infinity and negative values outside the terms' domains.
//!
//! An ordinary run is short; `ADVERSARY_GENERATIONS=2000 cargo test --release --features check --test adversary -- --nocapture`
//! digs deeper. What the search has found is kept in [`finds`], with what is now asserted of it.

#[cfg(feature = "check")]
mod energy;
mod finds;
// The table of terms, where they are drawn, and how their errors are counted.
#[path = "../accuracy/inputs.rs"]
#[allow(dead_code)]
mod inputs;
#[path = "../accuracy/meter.rs"]
#[allow(dead_code)]
mod meter;
#[path = "../accuracy/naive.rs"]
#[allow(dead_code)]
mod naive;
mod precision;
mod reciprocity;
mod stacks;
mod strategy;
#[path = "../accuracy/terms.rs"]
#[allow(dead_code)]
mod terms;
mod wild;

use std::sync::Mutex;

/// The generations of each search: `ordinary`, or as many as the environment asks for.
fn generations(ordinary: u32) -> u32 {
    std::env::var("ADVERSARY_GENERATIONS")
        .map_or(ordinary, |text| text.parse().expect("ADVERSARY_GENERATIONS is a number"))
}

/// Applies `f` to each item on as many threads as there are; the results keep the order of the items.
fn in_parallel<T: Send, U: Send>(items: Vec<T>, f: impl Fn(T) -> U + Sync) -> Vec<U> {
    let queue = Mutex::new(items.into_iter().enumerate());
    let found = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let next = queue.lock().expect("no thread panics with the lock").next();
                    let Some((place, item)) = next else { return };
                    let result = f(item);
                    found.lock().expect("no thread panics with the lock").push((place, result));
                }
            });
        }
    });
    let mut found = found.into_inner().expect("no thread panics with the lock");
    found.sort_by_key(|(place, _)| *place);
    found.into_iter().map(|(_, result)| result).collect()
}
