//! Runs a program over a block of lanes, one instruction at a time.
//!
//! Straight code runs in every lane, active or not: nothing in it can fail. Only stores look at the mask. A branch runs
//! each side that some lane takes, a loop goes on until no lane is left in it.

use super::code::{Atomic, Block, BuiltIn, Code, Instruction, Length, Place, Root, Slot, Step};
use super::error::InterpError;
use super::mask::Mask;
use super::number::{Number, OPEN, Whole};

/// The whole numbers that one real number may stand for before nothing is known.
const MOST_CHOICES: i64 = 8;
/// The forks that one lane may meet. Each new one is a way more for its row, of which [`super::MOST_WAYS`] are followed.
const MOST_FORKS: usize = 2 * super::MOST_WAYS;

/// Memory that all lanes see.
#[derive(Clone, Debug, Default)]
pub(super) struct Shared<N> {
    pub(super) reals: Vec<N>,
    pub(super) words: Vec<u32>,
    pub(super) leaves: usize,
}

/// How one lane took the forks that it met.
#[derive(Clone, Debug, Default)]
pub(super) struct Path {
    /// The choices; those past the ones that the lane came with are its own.
    pub(super) choices: Vec<u8>,
    /// How many of them it has used.
    met: usize,
    /// Nothing is known of the lane any more.
    pub(super) lost: bool,
}

/// The registers of a block of lanes, constants in their places.
#[derive(Debug)]
pub(super) struct Columns<N> {
    width: usize,
    reals: Vec<Vec<N>>,
    words: Vec<Vec<u32>>,
}

impl<N> Columns<N> {
    pub(super) fn width(&self) -> usize {
        self.width
    }
}

/// The state of a block of lanes.
pub(super) struct Machine<'c, N: Number> {
    code: &'c Code<N>,
    width: usize,
    reals: Vec<Vec<N>>,
    words: Vec<Vec<u32>>,
    pub(super) shared: Vec<Shared<N>>,
    pub(super) paths: Vec<Path>,
    /// The choices of lanes that go on beside the ones here, with the lane that each parted from.
    pub(super) forks: Vec<(usize, Vec<u8>)>,
    /// The steps left, and those given.
    left: u64,
    budget: u64,
    /// Lanes were lost because no steps were left.
    exhausted: bool,
}

/// Where lanes went that left a block early.
struct Exits {
    broken: Mask,
    continued: Mask,
}

impl<'c, N: Number> Machine<'c, N> {
    /// A machine for one program, on registers that an earlier one of the same program left, if any are of this width.
    pub(super) fn new(
        code: &'c Code<N>,
        width: usize,
        budget: u64,
        kept: Option<Columns<N>>,
    ) -> Result<Self, InterpError> {
        let kept = kept.filter(|kept| kept.width == width);
        let is_new = kept.is_none();
        let columns = kept.unwrap_or_else(|| Columns {
            width,
            reals: vec![vec![N::ZERO; width]; code.reals as usize],
            words: vec![vec![0; width]; code.words as usize],
        });
        let mut machine = Machine {
            code,
            width,
            reals: columns.reals,
            words: columns.words,
            shared: Vec::new(),
            paths: vec![Path::default(); if N::MAY_BE_OPEN { width } else { 0 }],
            forks: Vec::new(),
            left: budget,
            budget,
            exhausted: false,
        };
        if !is_new {
            return Ok(machine);
        }
        for (column, value) in &code.real_constants {
            machine.reals[*column as usize].fill(*value);
        }
        for (column, value) in &code.word_constants {
            machine.words[*column as usize].fill(*value);
        }
        // Where bools may be open, each run computes them anew: it settles them in place.
        if !N::MAY_BE_OPEN {
            machine.straight(&code.prologue, &mut Mask::first(width))?;
        }
        Ok(machine)
    }

    /// The registers, for the next machine.
    pub(super) fn columns(self) -> Columns<N> {
        Columns { width: self.width, reals: self.reals, words: self.words }
    }

    /// The lanes of a block.
    pub(super) fn width(&self) -> usize {
        self.width
    }

    /// Sets one lane's value in a column.
    pub(super) fn set_real(&mut self, column: u32, lane: usize, value: N) {
        self.reals[column as usize][lane] = value;
    }
    pub(super) fn set_word(&mut self, column: u32, lane: usize, value: u32) {
        self.words[column as usize][lane] = value;
    }
    pub(super) fn real(&self, column: u32, lane: usize) -> N {
        self.reals[column as usize][lane]
    }
    pub(super) fn word(&self, column: u32, lane: usize) -> u32 {
        self.words[column as usize][lane]
    }

    /// Runs the main routine in the first lanes. Each is a fresh invocation that meets the forks of its path.
    pub(super) fn run(&mut self, lanes: usize) -> Result<(), InterpError> {
        self.left = self.budget;
        self.exhausted = false;
        for path in &mut self.paths {
            (path.met, path.lost) = (0, false);
        }
        let code = self.code;
        let mut exits = Exits { broken: Mask::NONE, continued: Mask::NONE };
        let mut live = Mask::first(lanes.min(self.width));
        if N::MAY_BE_OPEN {
            self.straight(&code.prologue, &mut live)?;
        }
        for (to, from) in &code.initial {
            self.copy(*to, *from);
        }
        self.block(&code.routines[code.main].body, &mut live, &mut exits)
    }

    /// Supplies what the pipeline knows of the lanes of a workgroup.
    pub(super) fn place(&mut self, group: [u32; 3], groups: [u32; 3], lanes: usize) {
        let size = self.code.workgroup;
        for (column, builtin, component) in &self.code.builtins {
            let component = *component as usize % 3;
            for lane in 0..lanes {
                let index = lane as u32;
                let local = [index % size[0], index / size[0] % size[1], index / (size[0] * size[1])];
                self.words[*column as usize][lane] = match builtin {
                    BuiltIn::GlobalId => group[component].wrapping_mul(size[component]).wrapping_add(local[component]),
                    BuiltIn::LocalId => local[component],
                    BuiltIn::LocalIndex => index,
                    BuiltIn::GroupId => group[component],
                    BuiltIn::Groups => groups[component],
                };
            }
        }
    }

    /// Takes steps from the budget. Where none are left nothing is known of the lanes, or the program ends.
    fn spend(&mut self, steps: u64, live: &mut Mask) -> Result<(), InterpError> {
        if let Some(left) = self.left.checked_sub(steps) {
            self.left = left;
            return Ok(());
        }
        if !N::MAY_BE_OPEN {
            return Err(InterpError::Budget(self.budget));
        }
        (self.left, self.exhausted) = (0, true);
        live.lanes().for_each(|lane| self.lose(lane));
        *live = Mask::NONE;
        Ok(())
    }

    /// Whether what the last run leaves in shared memory is known.
    ///
    /// # Errors
    /// [`InterpError::Budget`] where lanes did not end, [`InterpError::Open`] where they went more than one way.
    pub(super) fn settled(&self) -> Result<(), InterpError> {
        if self.exhausted {
            return Err(InterpError::Budget(self.budget));
        }
        if !self.forks.is_empty() || self.paths.iter().any(|path| path.lost) {
            return Err(InterpError::Open);
        }
        Ok(())
    }

    /// Runs a block; `live` becomes the lanes that reach its end.
    fn block(&mut self, block: &'c Block<N>, live: &mut Mask, exits: &mut Exits) -> Result<(), InterpError> {
        for step in block {
            if !live.any() {
                return Ok(());
            }
            match step {
                Step::Run(instructions) => self.straight(instructions, live)?,
                Step::If { condition, accept, reject } => {
                    self.spend(1, live)?;
                    self.decide(*condition, live);
                    let words = &self.words[*condition as usize];
                    let mut yes = live.filtered(words, |word| word != 0);
                    let mut no = live.without(&yes);
                    self.block(accept, &mut yes, exits)?;
                    self.block(reject, &mut no, exits)?;
                    *live = yes.with(&no);
                }
                Step::Loop { body, continuing, break_if } => {
                    self.repeat(body, continuing, *break_if, live)?;
                }
                Step::Switch { selector, cases } => {
                    self.spend(cases.len() as u64, live)?;
                    let mut unmatched = *live;
                    let mut entering = vec![Mask::NONE; cases.len()];
                    for (mask, case) in entering.iter_mut().zip(cases) {
                        if let Some(value) = case.value {
                            *mask = unmatched.filtered(&self.words[*selector as usize], |word| word == value);
                            unmatched = unmatched.without(mask);
                        }
                    }
                    for (mask, case) in entering.iter_mut().zip(cases) {
                        if case.value.is_none() {
                            *mask = unmatched;
                            unmatched = Mask::NONE;
                        }
                    }
                    // A break ends the switch; a continue is the loop's around it.
                    let mut inner = Exits { broken: unmatched, continued: Mask::NONE };
                    let mut through = Mask::NONE;
                    for (mask, case) in entering.iter().zip(cases) {
                        let mut lanes = through.with(mask);
                        self.block(&case.body, &mut lanes, &mut inner)?;
                        through = if case.falls_through { lanes } else { Mask::NONE };
                        if !case.falls_through {
                            inner.broken = inner.broken.with(&lanes);
                        }
                    }
                    exits.continued = exits.continued.with(&inner.continued);
                    *live = inner.broken.with(&through);
                }
                Step::Call(routine) => {
                    self.spend(1, live)?;
                    let mut inside = *live;
                    let mut none = Exits { broken: Mask::NONE, continued: Mask::NONE };
                    let code = self.code;
                    self.block(&code.routines[*routine].body, &mut inside, &mut none)?;
                }
                Step::Break => {
                    exits.broken = exits.broken.with(live);
                    *live = Mask::NONE;
                }
                Step::Continue => {
                    exits.continued = exits.continued.with(live);
                    *live = Mask::NONE;
                }
                Step::Return => *live = Mask::NONE,
            }
        }
        Ok(())
    }

    fn repeat(
        &mut self,
        body: &'c Block<N>,
        continuing: &'c Block<N>,
        break_if: Option<u32>,
        live: &mut Mask,
    ) -> Result<(), InterpError> {
        let mut running = *live;
        let mut ended = Mask::NONE;
        while running.any() {
            self.spend(1, &mut running)?;
            let mut exits = Exits { broken: Mask::NONE, continued: Mask::NONE };
            self.block(body, &mut running, &mut exits)?;
            running = running.with(&exits.continued);
            ended = ended.with(&exits.broken);
            if running.any() {
                let mut none = Exits { broken: Mask::NONE, continued: Mask::NONE };
                self.block(continuing, &mut running, &mut none)?;
                if let Some(condition) = break_if {
                    self.decide(condition, &running);
                    let done = running.filtered(&self.words[condition as usize], |word| word != 0);
                    ended = ended.with(&done);
                    running = running.without(&done);
                }
            }
            if N::MAY_BE_OPEN {
                let lost: Vec<usize> = running.lanes().filter(|lane| self.paths[*lane].lost).collect();
                let mut mask = Mask::NONE;
                lost.into_iter().for_each(|lane| mask.set(lane));
                running = running.without(&mask);
            }
        }
        *live = ended;
        Ok(())
    }

    /// The choice of a lane among several ways to go on; it takes the first, and leaves the others to its forks.
    fn choose(&mut self, lane: usize, ways: u8) -> u8 {
        let path = &mut self.paths[lane];
        if path.lost || path.choices.len() > MOST_FORKS && path.met >= path.choices.len() {
            path.lost = true;
            return 0;
        }
        let choice = match path.choices.get(path.met) {
            Some(choice) => *choice,
            None => {
                for way in 1..ways {
                    let mut fork = path.choices.clone();
                    fork.push(way);
                    self.forks.push((lane, fork));
                }
                path.choices.push(0);
                0
            }
        };
        path.met += 1;
        choice
    }

    fn lose(&mut self, lane: usize) {
        if let Some(path) = self.paths.get_mut(lane) {
            path.lost = true;
        }
    }

    /// Settles the open bools of a column in active lanes.
    fn decide(&mut self, column: u32, live: &Mask) {
        if !N::MAY_BE_OPEN {
            return;
        }
        let open = live.filtered(&self.words[column as usize], |word| word == OPEN);
        for lane in open.lanes() {
            let choice = self.choose(lane, 2);
            self.words[column as usize][lane] = u32::from(choice == 0);
        }
    }

    fn copy(&mut self, to: Slot, from: Slot) {
        match (to, from) {
            (Slot::Real(to), Slot::Real(from)) if to != from => {
                let mut out = std::mem::take(&mut self.reals[to as usize]);
                out.copy_from_slice(&self.reals[from as usize]);
                self.reals[to as usize] = out;
            }
            (Slot::Word(to), Slot::Word(from)) if to != from => {
                let mut out = std::mem::take(&mut self.words[to as usize]);
                out.copy_from_slice(&self.words[from as usize]);
                self.words[to as usize] = out;
            }
            _ => {}
        }
    }

    fn straight(&mut self, instructions: &'c [Instruction<N>], live: &mut Mask) -> Result<(), InterpError> {
        self.spend(instructions.len() as u64, live)?;
        if !live.any() {
            return Ok(());
        }
        for instruction in instructions {
            self.instruction(instruction, live);
        }
        Ok(())
    }

    #[inline(always)]
    fn fill_real(&mut self, to: u32, f: impl FnOnce(&mut [N], &Self)) {
        let mut out = std::mem::take(&mut self.reals[to as usize]);
        f(&mut out, self);
        self.reals[to as usize] = out;
    }

    #[inline(always)]
    fn fill_word(&mut self, to: u32, f: impl FnOnce(&mut [u32], &Self)) {
        let mut out = std::mem::take(&mut self.words[to as usize]);
        f(&mut out, self);
        self.words[to as usize] = out;
    }

    fn instruction(&mut self, instruction: &'c Instruction<N>, live: &Mask) {
        match instruction {
            Instruction::Real1(f, to, a) => self.fill_real(*to, |out, m| f(out, &m.reals[*a as usize])),
            Instruction::Real2(f, to, a, b) => {
                self.fill_real(*to, |out, m| f(out, &m.reals[*a as usize], &m.reals[*b as usize]));
            }
            Instruction::Real3(f, to, a, b, c) => self.fill_real(*to, |out, m| {
                f(out, &m.reals[*a as usize], &m.reals[*b as usize], &m.reals[*c as usize]);
            }),
            Instruction::Word1(f, to, a) => self.fill_word(*to, |out, m| f(out, &m.words[*a as usize])),
            Instruction::Word2(f, to, a, b) => {
                self.fill_word(*to, |out, m| f(out, &m.words[*a as usize], &m.words[*b as usize]));
            }
            Instruction::Test(f, to, a, b) => {
                self.fill_word(*to, |out, m| f(out, &m.reals[*a as usize], &m.reals[*b as usize]));
            }
            Instruction::Whole(f, to, a) => self.whole(*f, *to, *a, live),
            Instruction::FromWord(f, to, a) => self.fill_real(*to, |out, m| {
                out.iter_mut().zip(&m.words[*a as usize]).for_each(|(out, word)| *out = f(*word));
            }),
            Instruction::Scale(to, a, b) => self.fill_real(*to, |out, m| {
                for ((out, a), b) in out.iter_mut().zip(&m.reals[*a as usize]).zip(&m.words[*b as usize]) {
                    *out = a.scaled(b.cast_signed());
                }
            }),
            Instruction::Decide(to, from) => {
                self.decide(*from, live);
                self.copy(Slot::Word(*to), Slot::Word(*from));
            }
            Instruction::SelectReal { to, condition, yes, no } => self.fill_real(*to, |out, m| {
                let (yes, no) = (&m.reals[*yes as usize], &m.reals[*no as usize]);
                for (((out, word), yes), no) in out.iter_mut().zip(&m.words[*condition as usize]).zip(yes).zip(no) {
                    *out = N::chosen(*word, *yes, *no);
                }
            }),
            Instruction::SelectWord { to, condition, yes, no } => {
                if N::MAY_BE_OPEN {
                    self.decide_where_different(*condition, *yes, *no, live);
                }
                self.fill_word(*to, |out, m| {
                    let (yes, no) = (&m.words[*yes as usize], &m.words[*no as usize]);
                    for (((out, word), yes), no) in out.iter_mut().zip(&m.words[*condition as usize]).zip(yes).zip(no) {
                        *out = if *word != 0 { *yes } else { *no };
                    }
                });
            }
            Instruction::Copy(to, from) => self.copy(*to, *from),
            Instruction::Address { to, base, index, stride, length } => {
                let last = self.length(*length).saturating_sub(1);
                self.fill_word(*to, |out, m| {
                    for (out, index) in out.iter_mut().zip(&m.words[*index as usize]) {
                        *out = (*index).min(last).wrapping_mul(*stride);
                    }
                    if let Some(base) = base {
                        for (out, base) in out.iter_mut().zip(&m.words[*base as usize]) {
                            *out = out.wrapping_add(*base);
                        }
                    }
                });
            }
            Instruction::Length { to, length } => {
                let length = self.length(*length);
                self.words[*to as usize].fill(length);
            }
            Instruction::Pick { to, index, from } => self.pick(*to, *index, from),
            Instruction::Load { to, from } => self.load(*to, from),
            Instruction::Store { to, from } => self.store(to, *from, live),
            Instruction::Atomic { old, place, operand, kind } => self.atomic(*old, place, *operand, *kind, live),
        }
    }

    fn whole(&mut self, f: fn(N) -> Whole, to: u32, a: u32, live: &Mask) {
        for lane in 0..self.width {
            let word = match f(self.reals[a as usize][lane]) {
                Whole::Range(low, high) if low == high => low as u32,
                _ if !live.holds(lane) => 0,
                Whole::Range(low, high) if high - low < MOST_CHOICES && low < high => {
                    let choice = self.choose(lane, (high - low + 1) as u8);
                    (low + i64::from(choice)) as u32
                }
                _ => {
                    self.lose(lane);
                    0
                }
            };
            self.words[to as usize][lane] = word;
        }
    }

    fn decide_where_different(&mut self, condition: u32, yes: u32, no: u32, live: &Mask) {
        let open = live.filtered(&self.words[condition as usize], |word| word == OPEN);
        for lane in open.lanes() {
            if self.words[yes as usize][lane] != self.words[no as usize][lane] {
                let choice = self.choose(lane, 2);
                self.words[condition as usize][lane] = u32::from(choice == 0);
            }
        }
    }

    fn length(&self, length: Length) -> u32 {
        match length {
            Length::Fixed(length) => length,
            Length::Runtime { memory, before, stride } => {
                let leaves = self.shared.get(memory as usize).map_or(0, |shared| shared.leaves as u32);
                leaves.saturating_sub(before) / stride.max(1)
            }
        }
    }

    fn pick(&mut self, to: Slot, index: u32, from: &[Slot]) {
        match to {
            Slot::Real(to) => self.fill_real(to, |out, m| {
                for (lane, (out, index)) in out.iter_mut().zip(&m.words[index as usize]).enumerate() {
                    if let Some(Slot::Real(column)) = from.get(*index as usize) {
                        *out = m.reals[*column as usize][lane];
                    }
                }
            }),
            Slot::Word(to) => self.fill_word(to, |out, m| {
                for (lane, (out, index)) in out.iter_mut().zip(&m.words[index as usize]).enumerate() {
                    if let Some(Slot::Word(column)) = from.get(*index as usize) {
                        *out = m.words[*column as usize][lane];
                    }
                }
            }),
        }
    }

    /// The leaf of a lane.
    fn leaf(&self, place: &Place, lane: usize) -> usize {
        let address = place.address.map_or(0, |column| self.words[column as usize][lane]);
        place.offset.wrapping_add(address) as usize
    }

    fn load(&mut self, to: Slot, from: &Place) {
        match (to, from.root) {
            (Slot::Real(to), Root::Lanes { real, .. }) => self.fill_real(to, |out, m| {
                for (lane, out) in out.iter_mut().enumerate() {
                    // A column beyond the last belongs to no address that a lane in use can have.
                    let column = m.reals.get(real as usize + m.leaf(from, lane));
                    *out = column.and_then(|column| column.get(lane).copied()).unwrap_or_default();
                }
            }),
            (Slot::Word(to), Root::Lanes { word, .. }) => self.fill_word(to, |out, m| {
                for (lane, out) in out.iter_mut().enumerate() {
                    let column = m.words.get(word as usize + m.leaf(from, lane));
                    *out = column.and_then(|column| column.get(lane).copied()).unwrap_or_default();
                }
            }),
            (Slot::Real(to), Root::Shared(memory)) => self.fill_real(to, |out, m| {
                let memory = &m.shared[memory as usize];
                for (lane, out) in out.iter_mut().enumerate() {
                    *out = memory.reals.get(m.leaf(from, lane)).copied().unwrap_or_default();
                }
            }),
            (Slot::Word(to), Root::Shared(memory)) => self.fill_word(to, |out, m| {
                let memory = &m.shared[memory as usize];
                for (lane, out) in out.iter_mut().enumerate() {
                    *out = memory.words.get(m.leaf(from, lane)).copied().unwrap_or_default();
                }
            }),
        }
    }

    fn store(&mut self, to: &Place, from: Slot, live: &Mask) {
        match (from, to.root, to.address) {
            (Slot::Real(from), Root::Lanes { real, .. }, None) => {
                let to = real + to.offset;
                if to != from {
                    self.fill_real(to, |out, m| live.copy(out, &m.reals[from as usize]));
                }
            }
            (Slot::Word(from), Root::Lanes { word, .. }, None) => {
                let to = word + to.offset;
                if to != from {
                    self.fill_word(to, |out, m| live.copy(out, &m.words[from as usize]));
                }
            }
            (Slot::Real(from), Root::Lanes { real, .. }, Some(_)) => {
                for lane in live.lanes() {
                    let (column, value) = (real as usize + self.leaf(to, lane), self.reals[from as usize][lane]);
                    if let Some(cell) = self.reals.get_mut(column).and_then(|column| column.get_mut(lane)) {
                        *cell = value;
                    }
                }
            }
            (Slot::Word(from), Root::Lanes { word, .. }, Some(_)) => {
                for lane in live.lanes() {
                    let (column, value) = (word as usize + self.leaf(to, lane), self.words[from as usize][lane]);
                    if let Some(cell) = self.words.get_mut(column).and_then(|column| column.get_mut(lane)) {
                        *cell = value;
                    }
                }
            }
            (Slot::Real(from), Root::Shared(memory), _) => {
                for lane in live.lanes() {
                    let (leaf, value) = (self.leaf(to, lane), self.reals[from as usize][lane]);
                    if let Some(cell) = self.shared[memory as usize].reals.get_mut(leaf) {
                        *cell = value;
                    }
                }
            }
            (Slot::Word(from), Root::Shared(memory), _) => {
                for lane in live.lanes() {
                    let (leaf, value) = (self.leaf(to, lane), self.words[from as usize][lane]);
                    if let Some(cell) = self.shared[memory as usize].words.get_mut(leaf) {
                        *cell = value;
                    }
                }
            }
        }
    }

    /// One lane after the other.
    fn atomic(&mut self, old: u32, place: &Place, operand: u32, kind: Atomic, live: &Mask) {
        for lane in live.lanes() {
            let (leaf, operand) = (self.leaf(place, lane), self.words[operand as usize][lane]);
            let before = match place.root {
                Root::Shared(memory) => self.shared[memory as usize].words.get(leaf).copied(),
                Root::Lanes { word, .. } => self.words.get(word as usize + leaf).map(|column| column[lane]),
            };
            let before = before.unwrap_or_default();
            let after = match kind {
                Atomic::Update(f) => f(before, operand),
                Atomic::Compare { expected, success } => {
                    let equal = before == self.words[expected as usize][lane];
                    self.words[success as usize][lane] = u32::from(equal);
                    if equal { operand } else { before }
                }
            };
            let cell = match place.root {
                Root::Shared(memory) => self.shared[memory as usize].words.get_mut(leaf),
                Root::Lanes { word, .. } => {
                    self.words.get_mut(word as usize + leaf).and_then(|column| column.get_mut(lane))
                }
            };
            if let Some(cell) = cell {
                *cell = after;
            }
            self.words[old as usize][lane] = before;
        }
    }
}
