//! Random numbers without state: a hash of (seed, sample, dimension), the same in Rust and WGSL.
//!
//! Twin: `wgsl/random.wgsl`. Integers only, so that both languages give the same bits. The n-th number of a sample is
//! had without the ones before it, so results depend neither on the order nor on the number of threads.

#[cfg(feature = "render")]
use crate::batch::lanes::{Lanes, WIDEST};
use crate::real::Real;

/// Four numbers in [0, 1) of one sample, multiples of 2⁻²⁴: exact in f32 and in f64.
///
/// * `seed`: the experiment. `sample`: which walk. `dimension`: which group of four numbers of that walk.
///
/// The same in every precision and in WGSL, to the bit.
#[inline]
pub fn random<R: Real>(seed: u32, sample: u32, dimension: u32) -> [R; 4] {
    random_words([sample, dimension, seed, 0]).map(|word| R::from_f64(f64::from(word >> 8) * (1.0 / 16_777_216.0)))
}

/// [`random`] in every lane, each of its own seed and sample: the first of slices that have as many.
#[cfg(feature = "render")]
#[inline(always)]
pub(crate) fn random_in_lanes<L: Lanes>(seeds: &[u32], samples: &[u32], dimension: u32) -> [L; 4] {
    let (seeds, samples) = (&seeds[..L::COUNT], &samples[..L::COUNT]);
    let mut numbers = [[0.0f32; WIDEST]; 4];
    for lane in 0..L::COUNT {
        let words = random_words([samples[lane], dimension, seeds[lane], 0]);
        for i in 0..4 {
            numbers[i][lane] = (words[i] >> 8) as i32 as f32 * (1.0 / 16_777_216.0);
        }
    }
    [L::load(&numbers[0]), L::load(&numbers[1]), L::load(&numbers[2]), L::load(&numbers[3])]
}

/// Four hashed words of four words: every bit of the result depends on every bit of the argument.
///
/// Source: Jarzynski & Olano 2020, "Hash Functions for GPU Rendering", `pcg4d` of the supplement's listing.
#[inline(always)]
pub fn random_words(words: [u32; 4]) -> [u32; 4] {
    let [mut x, mut y, mut z, mut w] = words.map(|v| v.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let round = |x: &mut u32, y: &mut u32, z: &mut u32, w: &mut u32| {
        *x = x.wrapping_add(y.wrapping_mul(*w));
        *y = y.wrapping_add(z.wrapping_mul(*x));
        *z = z.wrapping_add(x.wrapping_mul(*y));
        *w = w.wrapping_add(y.wrapping_mul(*z));
    };
    round(&mut x, &mut y, &mut z, &mut w);
    for v in [&mut x, &mut y, &mut z, &mut w] {
        *v ^= *v >> 16;
    }
    round(&mut x, &mut y, &mut z, &mut w);
    [x, y, z, w]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_uniform_and_uncorrelated() {
        // χ² over 64 × 64 cells for each pair of the eight numbers of two dimensions.
        const CELLS: usize = 64;
        const SAMPLES: u32 = 1 << 18;
        let mut counts = vec![[0u32; CELLS * CELLS]; 28];
        for sample in 0..SAMPLES {
            let mut u = [0.0f64; 8];
            u[..4].copy_from_slice(&random(7, sample, 3));
            u[4..].copy_from_slice(&random(7, sample, 4));
            let cell = u.map(|u| (u * CELLS as f64) as usize);
            let pairs = (0..8).flat_map(|i| (0..i).map(move |j| (i, j)));
            for (count, (i, j)) in counts.iter_mut().zip(pairs) {
                count[cell[i] * CELLS + cell[j]] += 1;
            }
        }
        let expected = f64::from(SAMPLES) / (CELLS * CELLS) as f64;
        for count in &counts {
            let chi: f64 = count.iter().map(|&n| (f64::from(n) - expected).powi(2) / expected).sum();
            // 4095 degrees of freedom, standard deviation √8190 = 90.5; 28 tests at a total of 1e-3: 4.2 deviations.
            assert!((chi - 4095.0).abs() < 4.2 * 90.5, "{chi}");
        }
    }

    #[test]
    fn words_are_those_of_the_published_listing() {
        // The listing run in Python's integers.
        assert_eq!(random_words([0; 4]), [0x0f02_f829, 0x2d56_8769, 0x32b0_c43b, 0xd325_48ea]);
        assert_eq!(random_words([1, 2, 3, 4]), [0x3622_cd16, 0xf114_71d8, 0xe110_9b3f, 0x02b9_4c2f]);
    }

    #[test]
    fn numbers_are_the_same_in_every_precision() {
        for sample in 0..1000 {
            let (single, double): ([f32; 4], [f64; 4]) = (random(1, sample, 3), random(1, sample, 3));
            assert_eq!(single.map(f64::from), double);
            assert!(double.iter().all(|u| (0.0..1.0).contains(u)));
        }
    }
}
