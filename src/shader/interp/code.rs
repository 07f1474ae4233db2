//! What a function is lowered to: instructions on columns of scalars, in blocks.
//!
//! A column holds one scalar for every lane. Vectors, matrices, structs and arrays are lists of columns, so that taking
//! them apart costs nothing and no instruction knows about them. WGSL has no recursion: each function has one frame, and
//! every column its own place.

use super::number::{Number, Whole};
use super::words::{Word1, Word2};

/// A column: of real numbers, or of words.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Slot {
    Real(u32),
    Word(u32),
}

/// Where a variable lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Root {
    /// In columns: leaf i in the i-th real or word column from these on.
    Lanes { real: u32, word: u32 },
    /// In memory that all lanes see.
    Shared(u32),
}

/// The number of elements that an index is clamped to.
#[derive(Clone, Copy, Debug)]
pub(super) enum Length {
    Fixed(u32),
    /// What a shared memory holds beyond its first leaves, in elements of a stride.
    Runtime {
        memory: u32,
        before: u32,
        stride: u32,
    },
}

/// A leaf in memory: the leaf at `offset`, plus the word of each lane in `address`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) root: Root,
    pub(super) offset: u32,
    pub(super) address: Option<u32>,
}

/// An atomic operation.
#[derive(Clone, Copy, Debug)]
pub(super) enum Atomic {
    /// The new value from the old one and the operand.
    Update(fn(u32, u32) -> u32),
    /// Replaces the value where it equals that of the column; the second is where the success goes.
    Compare { expected: u32, success: u32 },
}

pub(super) type Real1<N> = fn(&mut [N], &[N]);
pub(super) type Real2<N> = fn(&mut [N], &[N], &[N]);
pub(super) type Real3<N> = fn(&mut [N], &[N], &[N], &[N]);
pub(super) type Test<N> = fn(&mut [u32], &[N], &[N]);

/// One instruction; the first column is the result.
#[derive(Clone, Debug)]
pub(super) enum Instruction<N> {
    Real1(Real1<N>, u32, u32),
    Real2(Real2<N>, u32, u32, u32),
    Real3(Real3<N>, u32, u32, u32, u32),
    Word1(Word1, u32, u32),
    Word2(Word2, u32, u32, u32),
    Test(Test<N>, u32, u32, u32),
    /// A word from a real number; more than one answer forks the lane.
    Whole(fn(N) -> Whole, u32, u32),
    /// A real number from a word.
    FromWord(fn(u32) -> N, u32, u32),
    /// x·2ᵉ, e a word.
    Scale(u32, u32, u32),
    /// A bool that is 0 or 1: one that is open forks the lane.
    Decide(u32, u32),
    SelectReal {
        to: u32,
        condition: u32,
        yes: u32,
        no: u32,
    },
    SelectWord {
        to: u32,
        condition: u32,
        yes: u32,
        no: u32,
    },
    /// In every lane, active or not.
    Copy(Slot, Slot),
    /// `to = base + min(index, length − 1)·stride`.
    Address {
        to: u32,
        base: Option<u32>,
        index: u32,
        stride: u32,
        length: Length,
    },
    /// The length of a runtime-sized array.
    Length {
        to: u32,
        length: Length,
    },
    /// One of several columns, by the word in `index`.
    Pick {
        to: Slot,
        index: u32,
        from: Box<[Slot]>,
    },
    Load {
        to: Slot,
        from: Place,
    },
    /// Only in active lanes.
    Store {
        to: Place,
        from: Slot,
    },
    Atomic {
        old: u32,
        place: Place,
        operand: u32,
        kind: Atomic,
    },
}

pub(super) type Block<N> = Vec<Step<N>>;

/// Straight code, or control flow.
#[derive(Clone, Debug)]
pub(super) enum Step<N> {
    Run(Vec<Instruction<N>>),
    If {
        condition: u32,
        accept: Block<N>,
        reject: Block<N>,
    },
    Loop {
        body: Block<N>,
        continuing: Block<N>,
        break_if: Option<u32>,
    },
    Switch {
        selector: u32,
        cases: Vec<Case<N>>,
    },
    /// A routine, its arguments in place.
    Call(usize),
    Break,
    Continue,
    Return,
}

/// A case of a switch.
#[derive(Clone, Debug)]
pub(super) struct Case<N> {
    /// The value; none for the default.
    pub(super) value: Option<u32>,
    pub(super) body: Block<N>,
    pub(super) falls_through: bool,
}

/// A function with its pointers resolved.
#[derive(Clone, Debug)]
pub(super) struct Routine<N> {
    pub(super) body: Block<N>,
}

/// Memory that all lanes see.
#[derive(Clone, Debug)]
pub(super) struct Memory {
    /// The binding, none for workgroup memory.
    pub(super) binding: Option<(u32, u32)>,
    pub(super) name: String,
    pub(super) writable: bool,
    /// The kinds and byte offsets of the leaves; those of one more element of a runtime-sized array.
    pub(super) fixed: Vec<super::layout::Leaf>,
    pub(super) element: Vec<super::layout::Leaf>,
    /// The bytes from one runtime element to the next.
    pub(super) stride: u32,
    /// The bytes of the fixed part, to where the runtime elements start.
    pub(super) bytes: u32,
}

/// Values that the pipeline supplies to an entry point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BuiltIn {
    GlobalId,
    LocalId,
    LocalIndex,
    GroupId,
    Groups,
}

/// A whole program.
#[derive(Clone, Debug)]
pub(super) struct Code<N: Number> {
    pub(super) routines: Vec<Routine<N>>,
    /// What is computed once: constant expressions.
    pub(super) prologue: Vec<Instruction<N>>,
    /// The initial values of per-lane globals.
    pub(super) initial: Vec<(Slot, Slot)>,
    pub(super) main: usize,
    pub(super) reals: u32,
    pub(super) words: u32,
    pub(super) real_constants: Vec<(u32, N)>,
    pub(super) word_constants: Vec<(u32, u32)>,
    pub(super) memories: Vec<Memory>,
    pub(super) arguments: Vec<Slot>,
    pub(super) results: Vec<Slot>,
    pub(super) result_kinds: Vec<super::layout::Kind>,
    pub(super) builtins: Vec<(u32, BuiltIn, u32)>,
    pub(super) workgroup: [u32; 3],
}
