//! A function made ready to run over rows.

use super::code::{Code, Memory, Slot};
use super::error::InterpError;
use super::layout::Kind;
use super::lower::Lowering;
use super::machine::{Columns, Machine, Shared};
use super::mask::MOST_LANES;
use super::number::Number;
use super::{Known, Shader};
use crate::shader::{Scalar, ShaderError, Signature};
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Mutex, PoisonError};

/// The lanes of a block: the fastest of 64, 128, 256, 512 and 1024, see `docs/decisions.md`.
const BLOCK: usize = 256;
/// The scalars that a block may hold.
const MOST_SCALARS: usize = 1 << 24;
/// The steps of a block of lanes before it counts as endless.
const BUDGET: u64 = 20_000_000;
/// The most ways that intervals follow through the forks of one row; a row of more has unbounded results.
pub const MOST_WAYS: usize = 64;

/// One scalar of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell<N> {
    /// A number.
    Real(N),
    /// An integer, as its bits; a bool, as 0 or 1. As an argument, any other word is a bool that is true.
    Word(u32),
    /// An integer or bool that intervals leave open.
    Open,
}

/// The contents of a module's buffers, by group and binding.
#[derive(Clone, Debug, Default)]
pub struct Buffers {
    contents: BTreeMap<(u32, u32), Content>,
}

#[derive(Clone, Debug)]
enum Content {
    Bytes(Vec<u8>),
    Numbers(Vec<f64>),
}

impl Buffers {
    /// No buffers.
    pub fn new() -> Self {
        Buffers::default()
    }

    /// With a buffer at a group and binding, in WGSL's memory layout.
    pub fn with(mut self, group: u32, binding: u32, bytes: Vec<u8>) -> Self {
        self.contents.insert((group, binding), Content::Bytes(bytes));
        self
    }

    /// With a buffer that is not rounded to f32: its scalars one after the other, without padding. It cannot be written.
    /// Integers are truncated and clamped to their type.
    pub fn with_numbers(mut self, group: u32, binding: u32, numbers: Vec<f64>) -> Self {
        self.contents.insert((group, binding), Content::Numbers(numbers));
        self
    }

    /// The bytes of the buffer at a group and binding.
    pub fn get(&self, group: u32, binding: u32) -> Option<&[u8]> {
        match self.contents.get(&(group, binding)) {
            Some(Content::Bytes(bytes)) => Some(bytes),
            _ => None,
        }
    }
}

/// A WGSL function that maps rows of arguments to rows of results, or a compute entry point.
#[derive(Clone, Debug)]
pub struct Program<N: Number> {
    code: Code<N>,
    signature: Option<Signature>,
    /// Which cells of a row are bools.
    is_bool: Vec<bool>,
    budget: u64,
    block: usize,
    kept: Kept<N>,
}

/// Registers that runs of few rows leave to each other: to make them takes longer than such a run.
#[derive(Debug)]
struct Kept<N>(Mutex<Vec<Columns<N>>>);

impl<N> Kept<N> {
    fn take(&self, width: usize) -> Option<Columns<N>> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let fitting = kept.iter().rposition(|columns| columns.width() == width)?;
        Some(kept.swap_remove(fitting))
    }
    fn put(&self, columns: Columns<N>) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // As many as threads may want at once.
        if kept.len() < 64 {
            kept.push(columns);
        }
    }
}

impl<N> Default for Kept<N> {
    fn default() -> Self {
        Kept(Mutex::new(Vec::new()))
    }
}

impl<N> Clone for Kept<N> {
    fn clone(&self) -> Self {
        Kept::default()
    }
}

/// A lane to run: the row that it belongs to and the choices that it takes.
struct Job {
    row: usize,
    choices: Vec<u8>,
}

impl<N: Number> Program<N> {
    /// Makes a plain function ready.
    ///
    /// # Errors
    /// A function that is missing or has other types than 32-bit scalars, as [`crate::shader::Module::function`]; a part of
    /// WGSL that is not supported, with its place.
    pub fn new(shader: &Shader, function: &str) -> Result<Self, InterpError> {
        Self::with_known(shader, function, &[])
    }

    /// As [`Program::new`], where functions of these names are error-free transformations.
    ///
    /// # Errors
    /// Those of [`Program::new`].
    pub fn with_known(shader: &Shader, function: &str, known: &[(String, Known)]) -> Result<Self, InterpError> {
        let signature = shader.written().function(function)?;
        let ir = shader.module.ir();
        let found = ir.functions.iter().find(|(_, f)| f.name.as_deref() == Some(function));
        let Some((handle, _)) = found else {
            let missing = format!("no function `{function}` in double precision");
            return Err(ShaderError::plain(missing).into());
        };
        let code = Lowering::function(shader, handle, known)?;
        Self::of(code, Some(signature), BLOCK)
    }

    /// Makes a compute entry point ready.
    ///
    /// # Errors
    /// No compute entry point of that name; a part of WGSL that is not supported, with its place.
    pub fn entry_point(shader: &Shader, name: &str) -> Result<Self, InterpError> {
        let entries = &shader.module.ir().entry_points;
        let Some(index) = entries.iter().position(|entry| entry.name == name) else {
            return Err(ShaderError::plain(format!("no entry point `{name}`")).into());
        };
        let code = Lowering::entry_point(shader, index, &[])?;
        let lanes = code.workgroup.iter().fold(1u32, |product, size| product.saturating_mul(*size)) as usize;
        if lanes > MOST_LANES {
            return Err(InterpError::TooLarge(format!(
                "`{name}` has workgroups of more than {MOST_LANES} invocations"
            )));
        }
        Self::of(code, None, lanes)
    }

    fn of(code: Code<N>, signature: Option<Signature>, block: usize) -> Result<Self, InterpError> {
        let columns = (code.reals + code.words) as usize;
        let most = MOST_SCALARS / columns.max(1);
        if signature.is_none() && most < block {
            return Err(InterpError::TooLarge(format!("{columns} registers for each of {block} invocations")));
        }
        let inputs = signature.as_ref().map(Signature::inputs).unwrap_or_default();
        let is_bool = inputs.iter().map(|leaf| leaf.scalar == Scalar::Bool).collect();
        let block = block.min(most.max(1));
        Ok(Program { code, signature, is_bool, budget: BUDGET, block, kept: Kept::default() })
    }

    /// Sets the steps that a block of lanes may take, 20 million by default: instructions, calls, turns of loops, branches,
    /// cases of switches.
    pub fn with_budget(mut self, steps: u64) -> Self {
        self.budget = steps;
        self
    }

    /// Sets the rows that run together, from 1 to 1024. It changes the speed, and nothing else.
    pub fn with_block(mut self, lanes: usize) -> Self {
        if self.signature.is_some() {
            let columns = (self.code.reals + self.code.words) as usize;
            self.block = lanes.clamp(1, MOST_LANES).min((MOST_SCALARS / columns.max(1)).max(1));
        }
        self
    }

    /// What the function takes and returns; none of an entry point.
    pub fn signature(&self) -> Option<&Signature> {
        self.signature.as_ref()
    }

    /// The results of the function for every row of arguments, in the same order.
    ///
    /// Rows are as [`Signature::inputs`] and [`Signature::outputs`] list them; a function without parameters takes no cells
    /// and runs once. Buffers that the function writes are changed.
    ///
    /// # Errors
    /// [`InterpError::Arguments`] for cells that are no whole rows or not of the types of the signature, and for buffers
    /// that are missing or too short; [`InterpError::Budget`]; [`InterpError::Open`].
    pub fn run(&self, rows: &[Cell<N>], buffers: &mut Buffers) -> Result<Vec<Cell<N>>, InterpError> {
        let width = self.row_width(rows.len())?;
        // A function of nothing has one row.
        let count = rows.len().checked_div(width).unwrap_or(1);
        let mut machine = self.machine(count, buffers)?;
        let kinds = &self.code.result_kinds;
        let mut results: Vec<Option<Cell<N>>> = vec![None; count * self.code.results.len()];
        let mut ways = vec![1usize; if N::MAY_BE_OPEN { count } else { 0 }];
        let mut jobs: VecDeque<Job> = (0..count).map(|row| Job { row, choices: Vec::new() }).collect();
        let writes = self.code.memories.iter().any(|memory| memory.writable);
        while !jobs.is_empty() {
            let batch: Vec<Job> = jobs.drain(..jobs.len().min(machine.width())).collect();
            for (lane, job) in batch.iter().enumerate() {
                let cells = rows.get(job.row * width..).unwrap_or_default();
                for ((slot, cell), is_bool) in self.code.arguments.iter().zip(cells).zip(&self.is_bool) {
                    match (*slot, *cell) {
                        (Slot::Real(column), Cell::Real(value)) => machine.set_real(column, lane, value.flushed()),
                        (Slot::Word(column), Cell::Word(value)) => {
                            let word = if *is_bool { u32::from(value != 0) } else { value };
                            machine.set_word(column, lane, word);
                        }
                        _ => return Err(self.misfit(job.row)),
                    }
                }
                if let Some(path) = machine.paths.get_mut(lane) {
                    path.choices.clone_from(&job.choices);
                }
            }
            machine.run(batch.len())?;
            if writes {
                machine.settled()?;
            }
            for (lane, choices) in std::mem::take(&mut machine.forks) {
                let row = batch[lane].row;
                ways[row] += 1;
                if ways[row] <= MOST_WAYS {
                    jobs.push_back(Job { row, choices });
                }
            }
            for (lane, job) in batch.iter().enumerate() {
                let lost = machine.paths.get(lane).is_some_and(|path| path.lost);
                let first = job.row * self.code.results.len();
                for (index, (slot, kind)) in self.code.results.iter().zip(kinds).enumerate() {
                    let value = match slot {
                        Slot::Real(_) if lost => Cell::Real(N::anything()),
                        Slot::Word(_) if lost => Cell::Open,
                        Slot::Real(column) => Cell::Real(machine.real(*column, lane)),
                        Slot::Word(column) => match machine.word(*column, lane) {
                            super::number::OPEN if *kind == Kind::Bool => Cell::Open,
                            word => Cell::Word(word),
                        },
                    };
                    let cell = &mut results[first + index];
                    *cell = Some(match *cell {
                        None => value,
                        Some(before) => joined(before, value),
                    });
                }
            }
        }
        let width = self.code.results.len().max(1);
        let mut cells: Vec<Cell<N>> = results.into_iter().map(|cell| cell.unwrap_or(Cell::Open)).collect();
        for (row, cells) in cells.chunks_mut(width).enumerate() {
            if ways.get(row).is_some_and(|ways| *ways > MOST_WAYS) {
                for cell in cells {
                    *cell = if matches!(cell, Cell::Real(_)) { Cell::Real(N::anything()) } else { Cell::Open };
                }
            }
        }
        self.write_back(&machine, buffers)?;
        self.kept.put(machine.columns());
        Ok(cells)
    }

    /// Runs an entry point over a grid of workgroups, one after the other. Buffers that it writes are changed.
    ///
    /// # Errors
    /// Those of [`Program::run`]; a program that is no entry point.
    pub fn dispatch(&self, groups: [u32; 3], buffers: &mut Buffers) -> Result<(), InterpError> {
        if self.signature.is_some() {
            return Err(InterpError::Arguments("a plain function is run over rows, not dispatched".to_owned()));
        }
        let mut machine = self.machine(self.block, buffers)?;
        for z in 0..groups[2] {
            for y in 0..groups[1] {
                for x in 0..groups[0] {
                    self.clear_group(&mut machine);
                    machine.place([x, y, z], groups, self.block);
                    machine.run(self.block)?;
                    machine.settled()?;
                }
            }
        }
        self.write_back(&machine, buffers)
    }

    /// The scalars of a row, where these are whole rows.
    fn row_width(&self, cells: usize) -> Result<usize, InterpError> {
        let Some(signature) = &self.signature else {
            return Err(InterpError::Arguments("an entry point is dispatched, not run over rows".to_owned()));
        };
        let width = self.code.arguments.len();
        if !cells.is_multiple_of(width) {
            let names: Vec<_> = signature.inputs().into_iter().map(|leaf| leaf.name).collect();
            let (function, names) = (&signature.name, names.join(", "));
            let reason = format!("`{function}`: {cells} cells are no whole rows of {width} ({names})");
            return Err(InterpError::Arguments(reason));
        }
        Ok(width)
    }

    fn misfit(&self, row: usize) -> InterpError {
        let leaves = self.signature.as_ref().map(Signature::inputs).unwrap_or_default();
        let describe = |leaf: &crate::shader::Leaf| match leaf.scalar {
            Scalar::F32 => format!("{}: a number", leaf.name),
            other => format!("{}: a word ({other})", leaf.name),
        };
        let wanted: Vec<_> = leaves.iter().map(describe).collect();
        InterpError::Arguments(format!("row {row} is not of these types: {}", wanted.join(", ")))
    }

    fn machine(&self, rows: usize, buffers: &Buffers) -> Result<Machine<'_, N>, InterpError> {
        let width = self.block.min(rows.max(1));
        let mut machine = Machine::new(&self.code, width, self.budget, self.kept.take(width))?;
        for memory in &self.code.memories {
            machine.shared.push(self.filled(memory, buffers)?);
        }
        Ok(machine)
    }

    /// Zeroes workgroup memory.
    fn clear_group(&self, machine: &mut Machine<'_, N>) {
        for (shared, memory) in machine.shared.iter_mut().zip(&self.code.memories) {
            if memory.binding.is_none() {
                shared.reals.fill(N::ZERO);
                shared.words.fill(0);
            }
        }
    }

    fn filled(&self, memory: &Memory, buffers: &Buffers) -> Result<Shared<N>, InterpError> {
        let mut shared = Shared { reals: Vec::new(), words: Vec::new(), leaves: 0 };
        let Some((group, binding)) = memory.binding else {
            shared.leaves = memory.fixed.len();
            (shared.reals, shared.words) = (vec![N::ZERO; shared.leaves], vec![0; shared.leaves]);
            return Ok(shared);
        };
        let name = &memory.name;
        if let Some(Content::Numbers(numbers)) = buffers.contents.get(&(group, binding)) {
            if numbers.len() < memory.fixed.len() + memory.element.len() || memory.writable {
                let reason = format!("`{name}`: {} numbers are too few, or the buffer is written", numbers.len());
                return Err(InterpError::Arguments(reason));
            }
            shared.leaves = numbers.len();
            shared.reals = numbers.iter().map(|number| N::from_f64(*number).flushed()).collect();
            let elements = memory.element.iter().cycle();
            let kinds =
                memory.fixed.iter().chain(elements).map(|leaf| leaf.kind).chain(std::iter::repeat(Kind::Unsigned));
            shared.words = numbers.iter().zip(kinds).map(|(number, kind)| word_of(*number, kind)).collect();
            return Ok(shared);
        }
        let Some(bytes) = buffers.get(group, binding) else {
            let reason = format!("no buffer is given for `{name}`, group {group}, binding {binding}");
            return Err(InterpError::Arguments(reason));
        };
        let elements = runtime_elements(memory, bytes.len());
        shared.leaves = memory.fixed.len() + elements * memory.element.len();
        shared.reals = Vec::with_capacity(shared.leaves);
        shared.words = Vec::with_capacity(shared.leaves);
        for (kind, offset) in offsets(memory, elements) {
            let word = bytes.get(offset..offset + 4).and_then(|bytes| bytes.try_into().ok()).map(u32::from_le_bytes);
            let Some(word) = word else {
                let reason = format!("`{name}`: {} bytes are too few, {} are needed", bytes.len(), offset + 4);
                return Err(InterpError::Arguments(reason));
            };
            let real = match kind {
                Kind::Real(8) => {
                    let double = bytes.get(offset..offset + 8).and_then(|bytes| bytes.try_into().ok());
                    N::from_f64(double.map(f64::from_le_bytes).unwrap_or_default()).flushed()
                }
                Kind::Real(_) => N::from_single(f32::from_bits(word)).flushed(),
                _ => N::ZERO,
            };
            shared.reals.push(real);
            shared.words.push(if kind == Kind::Bool { u32::from(word != 0) } else { word });
        }
        Ok(shared)
    }

    fn write_back(&self, machine: &Machine<'_, N>, buffers: &mut Buffers) -> Result<(), InterpError> {
        for (memory, shared) in self.code.memories.iter().zip(&machine.shared) {
            let (Some(key), true) = (memory.binding, memory.writable) else { continue };
            let Some(Content::Bytes(bytes)) = buffers.contents.get_mut(&key) else { continue };
            let elements = runtime_elements(memory, bytes.len());
            for ((kind, offset), (real, word)) in offsets(memory, elements).zip(shared.reals.iter().zip(&shared.words))
            {
                let value = match kind {
                    Kind::Real(8) => real.to_f64().to_le_bytes().to_vec(),
                    Kind::Real(_) if N::MAY_BE_OPEN => (real.to_f64() as f32).to_le_bytes().to_vec(),
                    Kind::Real(_) => real.bits().unwrap_or_default().to_le_bytes().to_vec(),
                    _ => word.to_le_bytes().to_vec(),
                };
                if let Some(place) = bytes.get_mut(offset..offset + value.len()) {
                    place.copy_from_slice(&value);
                }
            }
        }
        Ok(())
    }
}

/// The elements of the runtime-sized array that a buffer of this length has room for.
fn runtime_elements(memory: &Memory, bytes: usize) -> usize {
    match memory.stride {
        0 => 0,
        stride => bytes.saturating_sub(memory.bytes as usize) / stride as usize,
    }
}

/// The kinds and byte offsets of all leaves of a memory.
fn offsets(memory: &Memory, elements: usize) -> impl Iterator<Item = (Kind, usize)> {
    let fixed = memory.fixed.iter().map(|leaf| (leaf.kind, leaf.offset as usize));
    let start = memory.bytes as usize;
    let runtime = (0..elements).flat_map(move |index| {
        let base = start + index * memory.stride as usize;
        memory.element.iter().map(move |leaf| (leaf.kind, base + leaf.offset as usize))
    });
    fixed.chain(runtime)
}

/// The word of a kind for a number, truncated and clamped to what the kind holds.
fn word_of(number: f64, kind: Kind) -> u32 {
    match kind {
        Kind::Signed => (number as i32).cast_unsigned(),
        Kind::Bool => u32::from(number != 0.0),
        _ => number as u32,
    }
}

/// What holds on both ways.
fn joined<N: Number>(a: Cell<N>, b: Cell<N>) -> Cell<N> {
    match (a, b) {
        (Cell::Real(a), Cell::Real(b)) => Cell::Real(a.hull(b)),
        (Cell::Word(a), Cell::Word(b)) if a == b => Cell::Word(a),
        _ => Cell::Open,
    }
}
