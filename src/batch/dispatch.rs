//! The choice of vector instructions, made when the program runs. Unsafe here, and in `lanes` and `x86` beside it and nowhere
//! else in the crate, are calls of functions that were compiled for instructions which [`Level`] has found on this processor.
#![allow(unsafe_code)]

use super::Kernel;
use super::lanes::{Lanes, Vectored, load_part, store_part};

/// A set of vector instructions that this processor has.
///
/// There is no way to make a level that it has not: [`Level::available`] and [`Level::detect`] ask the processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Level(Set);

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Set {
    /// SSE2 on x86-64; elsewhere one number at a time, as the compiler makes it.
    Baseline,
    #[cfg(all(feature = "std", target_arch = "x86_64"))]
    Avx2,
    #[cfg(all(feature = "std", target_arch = "x86_64"))]
    Avx512,
}

/// Work that is compiled for each level.
pub(crate) trait Work {
    /// Does it in numbers of the level. `#[inline(always)]`, or it is not compiled for it.
    fn run<L: Lanes>(self);
}

impl Level {
    /// The fastest level of this processor.
    #[inline]
    pub fn detect() -> Self {
        #[cfg(all(feature = "std", target_arch = "x86_64"))]
        {
            if has_avx512() {
                return Level(Set::Avx512);
            }
            if has_avx2() {
                return Level(Set::Avx2);
            }
        }
        Self::BASELINE
    }

    /// What the crate was compiled for, which every processor that it runs on has.
    pub const BASELINE: Level = Level(Set::Baseline);

    /// The levels of this processor, the fastest last.
    pub fn available() -> impl Iterator<Item = Level> {
        #[cfg(all(feature = "std", target_arch = "x86_64"))]
        let more = [(Set::Avx2, has_avx2()), (Set::Avx512, has_avx512())];
        #[cfg(not(all(feature = "std", target_arch = "x86_64")))]
        let more: [(Set, bool); 0] = [];
        core::iter::once(Self::BASELINE).chain(more.into_iter().filter(|(_, has)| *has).map(|(set, _)| Level(set)))
    }

    /// `baseline`, `avx2` (with FMA) or `avx512`.
    pub const fn name(self) -> &'static str {
        match self.0 {
            Set::Baseline => "baseline",
            #[cfg(all(feature = "std", target_arch = "x86_64"))]
            Set::Avx2 => "avx2",
            #[cfg(all(feature = "std", target_arch = "x86_64"))]
            Set::Avx512 => "avx512",
        }
    }

    #[inline]
    pub(crate) fn run(self, work: impl Work) {
        match self.0 {
            Set::Baseline => work.run::<Baseline>(),
            // SAFETY: a Level of these sets is only made where the processor has their instructions.
            #[cfg(all(feature = "std", target_arch = "x86_64"))]
            Set::Avx2 => unsafe { avx2(work) },
            #[cfg(all(feature = "std", target_arch = "x86_64"))]
            Set::Avx512 => unsafe { avx512(work) },
        }
    }
}

/// The numbers of the baseline.
#[cfg(target_arch = "x86_64")]
type Baseline = Vectored<core::arch::x86_64::__m128>;
#[cfg(not(target_arch = "x86_64"))]
type Baseline = crate::single::Single<{ cfg!(all(feature = "std", target_arch = "aarch64")) }>;

#[cfg(all(feature = "std", target_arch = "x86_64"))]
fn has_avx2() -> bool {
    std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma")
}

#[cfg(all(feature = "std", target_arch = "x86_64"))]
fn has_avx512() -> bool {
    has_avx2()
        && std::arch::is_x86_feature_detected!("avx512f")
        && std::arch::is_x86_feature_detected!("avx512vl")
        && std::arch::is_x86_feature_detected!("avx512bw")
        && std::arch::is_x86_feature_detected!("avx512dq")
}

#[cfg(all(feature = "std", target_arch = "x86_64"))]
#[target_feature(enable = "avx2,fma")]
fn avx2(work: impl Work) {
    work.run::<Vectored<core::arch::x86_64::__m256>>();
}

#[cfg(all(feature = "std", target_arch = "x86_64"))]
#[target_feature(enable = "avx2,fma,avx512f,avx512vl,avx512bw,avx512dq")]
fn avx512(work: impl Work) {
    work.run::<Vectored<core::arch::x86_64::__m512>>();
}

/// A kernel over slices of one length.
pub(crate) struct Map<'a, K, const I: usize, const O: usize> {
    pub(crate) kernel: &'a K,
    pub(crate) inputs: [&'a [f32]; I],
    pub(crate) outputs: [&'a mut [f32]; O],
}

impl<K: Kernel<I, O>, const I: usize, const O: usize> Work for Map<'_, K, I, O> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Map { kernel, inputs, outputs } = self;
        let count = inputs.first().map_or(outputs.first().map_or(0, |slice| slice.len()), |slice| slice.len());
        let whole = count - count % L::COUNT;
        for start in (0..whole).step_by(L::COUNT) {
            // Loops over indices and no closures: what runs over vectors must be inlined whole.
            let mut point = [L::ZERO; I];
            for i in 0..I {
                point[i] = L::load(&inputs[i][start..]);
            }
            let results = kernel.evaluate(point);
            for o in 0..O {
                results[o].store(&mut outputs[o][start..]);
            }
        }
        if whole < count {
            // The rest of a vector repeats its last evaluation.
            let mut point = [L::ZERO; I];
            for i in 0..I {
                point[i] = load_part(&inputs[i][whole..]);
            }
            let results = kernel.evaluate(point);
            for o in 0..O {
                store_part(results[o], &mut outputs[o][whole..]);
            }
        }
    }
}
