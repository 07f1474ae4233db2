//! A self-adaptive evolution strategy (Schwefel 1981): what climbs towards the worst input.
//!
//! A candidate is a list of genes in [0, 1] and the width of its mutations, which is inherited, mutated and selected like
//! a gene. Each generation the best μ of λ children are the next parents; parents die, so that a lucky rounding error does
//! not hold the search in place. Every number comes from a counter, so that a run can be repeated.

use brdf::walk::random::random_words;

/// Parents, and children of each generation: the ratio of 1 to 7 that self-adaptation wants.
const PARENTS: usize = 5;
const CHILDREN: usize = 35;

/// One search.
#[derive(Clone, Copy)]
pub(crate) struct Search {
    pub(crate) genes: usize,
    pub(crate) generations: u32,
    /// How often the search starts again from anywhere.
    pub(crate) restarts: u32,
    pub(crate) seed: u32,
}

/// The candidate that a search found best.
#[derive(Clone, Debug)]
pub(crate) struct Find {
    pub(crate) fitness: f64,
    pub(crate) genes: Vec<f64>,
    /// How often the fitness was computed.
    pub(crate) evaluations: u64,
}

struct Candidate {
    genes: Vec<f64>,
    width: f64,
    fitness: f64,
}

/// Numbers in [0, 1) by their count.
struct Counter {
    seed: u32,
    restart: u32,
    next: u32,
    left: Vec<f64>,
}

impl Counter {
    fn uniform(&mut self) -> f64 {
        if self.left.is_empty() {
            let words = random_words([self.next, self.restart, self.seed, 0xad7e]);
            self.next += 1;
            // 64 bits to a number: genes near 0 and 1 count.
            let pair = |a: u32, b: u32| (f64::from(a) + f64::from(b) / 4_294_967_296.0) / 4_294_967_296.0;
            self.left.extend([pair(words[0], words[1]), pair(words[2], words[3])]);
        }
        self.left.pop().expect("two were added")
    }

    /// A standard normal deviate (Box & Muller 1958).
    fn normal(&mut self) -> f64 {
        let (u, v) = (self.uniform(), self.uniform());
        (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.uniform() * n as f64) as usize).min(n - 1)
    }
}

impl Search {
    /// Maximises the fitness. NaN counts as infinity: nothing is worse.
    pub(crate) fn run(&self, fitness: impl Fn(&[f64]) -> f64) -> Find {
        let judge = |genes: &[f64]| {
            let fitness = fitness(genes);
            if fitness.is_nan() { f64::INFINITY } else { fitness }
        };
        let mut best = Find { fitness: f64::NEG_INFINITY, genes: Vec::new(), evaluations: 0 };
        for restart in 0..self.restarts {
            let mut counter = Counter { seed: self.seed, restart, next: 0, left: Vec::new() };
            let mut children: Vec<Candidate> = (0..CHILDREN)
                .map(|_| {
                    let genes: Vec<f64> = (0..self.genes).map(|_| counter.uniform()).collect();
                    let fitness = judge(&genes);
                    Candidate { genes, width: 0.2, fitness }
                })
                .collect();
            for generation in 0..=self.generations {
                children.sort_by(|a, b| b.fitness.total_cmp(&a.fitness));
                best.evaluations += CHILDREN as u64;
                if children[0].fitness > best.fitness {
                    (best.fitness, best.genes) = (children[0].fitness, children[0].genes.clone());
                }
                if generation == self.generations || best.fitness == f64::INFINITY {
                    break;
                }
                let parents = &children[..PARENTS];
                let next = (0..CHILDREN).map(|_| self.child(parents, &mut counter, &judge)).collect();
                children = next;
            }
        }
        best
    }

    /// Genes of two parents at random, the mean of their widths, and a mutation of both.
    fn child(&self, parents: &[Candidate], counter: &mut Counter, judge: &impl Fn(&[f64]) -> f64) -> Candidate {
        let (a, b) = (&parents[counter.below(parents.len())], &parents[counter.below(parents.len())]);
        let count = self.genes as f64;
        // Schwefel's rate 1/√(2n) of the common width. The floor is a few roundings of a gene.
        let learned = (counter.normal() / (2.0 * count).sqrt()).exp();
        let width = ((a.width * b.width).sqrt() * learned).clamp(1e-15, 0.5);
        let genes = (0..self.genes)
            .map(|i| {
                let gene = if counter.uniform() < 0.5 { a.genes[i] } else { b.genes[i] };
                // One gene in 20 jumps: to anywhere, or to an end of its range.
                let moved = match (counter.uniform() * 60.0) as u32 {
                    0 => counter.uniform(),
                    1 => 0.0,
                    2 => 1.0,
                    _ => gene + width * counter.normal(),
                };
                moved.clamp(0.0, 1.0)
            })
            .collect::<Vec<_>>();
        Candidate { fitness: judge(&genes), genes, width }
    }
}

#[test]
fn a_smooth_peak_is_climbed_and_a_corner_is_reached() {
    let search = Search { genes: 8, generations: 200, restarts: 2, seed: 1 };
    let peak = search.run(|genes| -genes.iter().enumerate().map(|(i, x)| (x - 0.1 * i as f64).powi(2)).sum::<f64>());
    assert!(peak.fitness > -1e-6, "{peak:?}");
    let corner = search.run(|genes| genes.iter().sum());
    assert_eq!(corner.fitness, 8.0);
    assert_eq!(corner.evaluations, 2 * 201 * CHILDREN as u64);
}

#[test]
fn a_search_repeats_itself_and_stops_at_a_nan() {
    let search = Search { genes: 3, generations: 20, restarts: 2, seed: 7 };
    let wavy = |genes: &[f64]| genes.iter().map(|x| (50.0 * x).sin()).sum();
    assert_eq!(search.run(wavy).genes, search.run(wavy).genes);
    let broken = search.run(|genes| if genes[0] < 0.5 { f64::NAN } else { 0.0 });
    assert_eq!(broken.fitness, f64::INFINITY);
}
