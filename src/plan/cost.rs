//! What a plan computes, counted: its stages are run once over numbers that count what is done with them.
//!
//! Stages choose by selects and never branch, so that every evaluation does the same operations.

use super::chain::{Chain, Stage};
use super::stage::Ray;
use crate::frame::Vector;
use crate::real::{Real, Sealed};
use core::cell::Cell;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// Operations of one evaluation, by kind. Operations between constants are not counted, nor loads, stores and changes of sign.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Operations {
    /// Additions, subtractions, multiplications, and multiply-adds where they are one instruction.
    pub sums: u32,
    /// Comparisons, selects, minima and maxima.
    pub choices: u32,
    /// Divisions.
    pub divisions: u32,
    /// Square roots.
    pub roots: u32,
    /// Exponentials.
    pub exponentials: u32,
    /// Arctangents.
    pub angles: u32,
}

impl Operations {
    /// The names of the kinds, in the order of [`Operations::counts`].
    pub const KINDS: [&'static str; 6] = ["sums", "choices", "divisions", "roots", "exponentials", "angles"];

    /// The number of each kind.
    pub const fn counts(self) -> [u32; 6] {
        [self.sums, self.choices, self.divisions, self.roots, self.exponentials, self.angles]
    }

    /// What they cost together, of the cost of one of each kind.
    pub fn cost(self, units: [f64; 6]) -> f64 {
        self.counts().into_iter().zip(units).map(|(count, unit)| f64::from(count) * unit).sum()
    }

    const NONE: Self = Operations { sums: 0, choices: 0, divisions: 0, roots: 0, exponentials: 0, angles: 0 };
}

impl AddAssign for Operations {
    fn add_assign(&mut self, other: Self) {
        self.sums += other.sums;
        self.choices += other.choices;
        self.divisions += other.divisions;
        self.roots += other.roots;
        self.exponentials += other.exponentials;
        self.angles += other.angles;
    }
}

/// What evaluates a plan, of which each does other operations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Path {
    /// [`Plan::evaluate`](super::Plan::evaluate): in f64, one by one.
    Scalar,
    /// A batch without multiply-adds: [`Level::BASELINE`](crate::batch::Level::BASELINE) of x86-64.
    Batch,
    /// A batch with them: every other [`Level`](crate::batch::Level).
    FusedBatch,
}

impl<const K: usize> Chain<K> {
    /// What each stage does in an evaluation; first what comes before them.
    pub(crate) fn operations(&self, path: Path) -> Vec<Operations> {
        match path {
            Path::Scalar => self.count::<Counted<false, false>>(),
            Path::Batch => self.count::<Counted<true, false>>(),
            Path::FusedBatch => self.count::<Counted<true, true>>(),
        }
    }

    fn count<W: Real<Wide = W>>(&self) -> Vec<Operations> {
        let vector = |x, y, z| Vector::new(W::from_f64(x), W::from_f64(y), W::from_f64(z));
        let (wi, wo) = (vector(0.48, 0.0, 0.877), vector(0.0, 0.6, 0.8));
        COUNT.set(Operations::NONE);
        let mut ray = Ray::new(wi, wo);
        let mut counts = vec![COUNT.replace(Operations::NONE)];
        for stage in &self.stages {
            stage.step(&mut ray, wi, wo);
            if let Stage::Pass { .. } = stage {
                // Whether anything goes on is asked after it.
                let _ = ray.arrives();
            }
            counts.push(COUNT.replace(Operations::NONE));
        }
        counts
    }
}

std::thread_local! {
    /// What this thread's [`Counted`] numbers have done.
    static COUNT: Cell<Operations> = const { Cell::new(Operations::NONE) };
}

/// Counts `times` operations of a kind.
fn count(kind: impl Fn(&mut Operations) -> &mut u32, times: u32) {
    let mut operations = COUNT.get();
    *kind(&mut operations) += times;
    COUNT.set(operations);
}

/// An f64 that counts what is done with it, as the numbers of a path would: `CARRIES` those of a batch, `FUSED` with multiply-adds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Counted<const CARRIES: bool, const FUSED: bool>(f64);

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt, $kind:ident) => {
        impl<const C: bool, const F: bool> $trait for Counted<C, F> {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                count(|operations| &mut operations.$kind, 1);
                Counted(self.0 $op other.0)
            }
        }
    };
}
operator!(Add, add, +, sums);
operator!(Sub, sub, -, sums);
operator!(Mul, mul, *, sums);
operator!(Div, div, /, divisions);

impl<const C: bool, const F: bool> Neg for Counted<C, F> {
    type Output = Self;
    fn neg(self) -> Self {
        Counted(-self.0)
    }
}

/// Functions of one number, each of a kind.
macro_rules! functions {
    ($($method:ident $kind:ident),*) => {$(
        fn $method(self) -> Self {
            count(|operations| &mut operations.$kind, 1);
            Counted(Real::$method(self.0))
        }
    )*};
}

impl<const C: bool, const F: bool> Sealed for Counted<C, F> {}
impl<const C: bool, const F: bool> Real for Counted<C, F> {
    type Mask = bool;
    type Wide = Self;
    const CARRIES: bool = C;

    const ZERO: Self = Counted(0.0);
    const ONE: Self = Counted(1.0);
    const HALF: Self = Counted(0.5);
    const TWO: Self = Counted(2.0);
    const PI: Self = Counted(core::f64::consts::PI);
    const FRAC_1_PI: Self = Counted(core::f64::consts::FRAC_1_PI);
    const EPSILON: Self = Counted(f64::EPSILON);
    const EXP_LIMIT: Self = Counted(708.0);

    fn from_f64(x: f64) -> Self {
        Counted(x)
    }
    fn to_f64(self) -> f64 {
        self.0
    }
    fn widen(self) -> Self {
        self
    }
    fn narrow(wide: Self) -> Self {
        wide
    }
    functions!(sqrt roots, exp exponentials, ln exponentials, ln_one_plus exponentials);
    fn abs(self) -> Self {
        Counted(self.0.abs())
    }
    fn min(self, other: Self) -> Self {
        count(|operations| &mut operations.choices, 1);
        Counted(self.0.min(other.0))
    }
    fn max(self, other: Self) -> Self {
        count(|operations| &mut operations.choices, 1);
        Counted(self.0.max(other.0))
    }
    fn lt(self, other: Self) -> bool {
        count(|operations| &mut operations.choices, 1);
        self.0 < other.0
    }
    fn le(self, other: Self) -> bool {
        count(|operations| &mut operations.choices, 1);
        self.0 <= other.0
    }
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        count(|operations| &mut operations.choices, 1);
        if mask { yes } else { no }
    }
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        count(|operations| &mut operations.sums, if F { 1 } else { 2 });
        Counted(self.0 * factor.0 + addend.0)
    }
    fn product_exact(self, other: Self) -> (Self, Self) {
        // A product and its multiply-add; else Dekker's, with the masks that split the factors.
        count(|operations| &mut operations.sums, if F { 2 } else { 13 });
        (Counted(self.0 * other.0), Self::ZERO)
    }
    fn remainder(self, factor: Self, addend: Self) -> Self {
        count(|operations| &mut operations.sums, if F { 1 } else { 15 });
        Counted(addend.0 - self.0 * factor.0)
    }
    fn angle(self, adjacent: Self) -> Self {
        count(|operations| &mut operations.angles, 1);
        Counted(self.0.atan2(adjacent.0))
    }
    fn unit_circle(self) -> (Self, Self) {
        let (cosine, sine) = self.0.unit_circle();
        count(|operations| &mut operations.angles, 1);
        (Counted(cosine), Counted(sine))
    }
    fn product_wide(a: Self, b: Self) -> (Self, Self) {
        a.product_exact(b)
    }
    fn angle_wide(opposite: Self, adjacent: Self) -> Self {
        opposite.angle(adjacent)
    }
    fn erfcx_wide(x: Self) -> Self {
        count(|operations| &mut operations.exponentials, 1);
        Counted(x.0.erfcx())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layered::{Interface, Layer, Model, Stack};
    use crate::plan::{Options, Plan, Rule};
    use alloc::vec;

    fn total(plan: &Plan<3>, path: Path) -> Operations {
        let mut sum = Operations::NONE;
        plan.terms().for_each(|term| sum += term.operations(path));
        sum
    }

    #[test]
    fn what_rules_leave_out_is_not_counted() {
        let coated = |sigma| {
            let coat = Layer::new(Interface::dielectric(1.5, 0.1)).over([sigma, 0.2, 0.3], 1.0);
            let base = Interface::conductor([0.2, 1.0, 1.2], [4.0, 2.6, 2.4], 0.3);
            Stack::<f64, 3>::new(Model::Conserving, vec![coat, Layer::new(base)]).expect("in the ranges")
        };
        let plan = Plan::new(&coated(0.1)).expect("a closed form");
        for path in [Path::Scalar, Path::Batch, Path::FusedBatch] {
            let counts = total(&plan, path);
            // A lobe for each interface, absorption in each channel.
            assert_eq!(counts.exponentials, 2 + 3, "{path:?} {counts:?}");
            // One for each lobe and channel; tan², twice; the path; T; and where it is carried, what the roots of refraction lost.
            let carried = if path == Path::Scalar { 0 } else { 1 };
            assert_eq!(counts.divisions, 2 * 3 + 2 + 1 + 1 + carried, "{path:?} {counts:?}");
            assert_eq!(counts.angles, 0);
        }
        // Nothing is carried in f64, and a multiply-add is one operation.
        assert!(total(&plan, Path::FusedBatch).sums < total(&plan, Path::Batch).sums);
        let clear = Layer::new(Interface::dielectric(1.5, 0.1));
        let stack =
            Stack::<f64, 3>::new(Model::Conserving, vec![clear, coated(0.0).layers()[1]]).expect("in the ranges");
        let (with, without) = (Options::default(), Options { without: &[Rule::ClearMedium], ..Options::default() });
        let [with, without] =
            [with, without].map(|options| Plan::with_options(&stack, &options).expect("a closed form"));
        let (with, without) = (total(&with, Path::FusedBatch), total(&without, Path::FusedBatch));
        assert_eq!(without.exponentials - with.exponentials, 3);
        assert_eq!(without.divisions - with.divisions, 1);
    }
}
