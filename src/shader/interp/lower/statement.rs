//! Statements: control flow, calls, stores, atomics.

use super::super::code::{Atomic, Block, Case, Instruction, Real1, Real2, Slot, Step};
use super::super::error::InterpError;
use super::super::number::Number;
use super::super::{Known, words};
use super::{Lowering, Parameter, Scope, Value};
use naga::{AtomicFunction, Expression, Handle, ScalarKind, Statement, SwitchValue, TypeInner};
use std::rc::Rc;

impl<'a, N: Number> Lowering<'a, N> {
    /// Appends the statements of a block. The columns of its values are free again where [`Lowering::leave`] follows.
    pub(super) fn block(&mut self, scope: &mut Scope<'a, N>, block: &'a naga::Block) -> Result<(), InterpError> {
        self.enter()?;
        for (statement, span) in block.span_iter() {
            if span.is_defined() {
                scope.span = *span;
            }
            self.statement(scope, statement)?;
        }
        self.depth -= 1;
        Ok(())
    }

    /// Lowers a block by itself.
    fn nested(&mut self, scope: &mut Scope<'a, N>, block: &'a naga::Block) -> Result<Block<N>, InterpError> {
        let outer = self.finished(scope);
        scope.taken.push(Vec::new());
        self.block(scope, block)?;
        self.leave(scope);
        let inner = self.finished(scope);
        scope.block = outer;
        Ok(inner)
    }

    /// Gives back what the innermost block took: its values are out of scope.
    fn leave(&mut self, scope: &mut Scope<'a, N>) {
        for slot in scope.taken.pop().unwrap_or_default() {
            match slot {
                Slot::Real(column) => scope.free[0].push(column),
                Slot::Word(column) => scope.free[1].push(column),
            }
        }
    }

    fn statement(&mut self, scope: &mut Scope<'a, N>, statement: &'a Statement) -> Result<(), InterpError> {
        match statement {
            Statement::Emit(range) => {
                for handle in range.clone() {
                    let value = self.expression(scope, handle)?;
                    scope.values[handle.index()] = Some(value);
                }
                Ok(())
            }
            Statement::Block(block) => self.block(scope, block),
            Statement::If { condition, accept, reject } => {
                let condition = self.one_word(scope, *condition)?;
                let accept = self.nested(scope, accept)?;
                let reject = self.nested(scope, reject)?;
                self.step(scope, Step::If { condition, accept, reject })
            }
            Statement::Switch { selector, cases } => {
                let selector = self.one_word(scope, *selector)?;
                let mut lowered = Vec::with_capacity(cases.len());
                for case in cases {
                    let value = match case.value {
                        SwitchValue::I32(value) => Some(value.cast_unsigned()),
                        SwitchValue::U32(value) => Some(value),
                        SwitchValue::Default => None,
                    };
                    let body = self.nested(scope, &case.body)?;
                    lowered.push(Case { value, body, falls_through: case.fall_through });
                }
                self.step(scope, Step::Switch { selector, cases: lowered })
            }
            Statement::Loop { body, continuing, break_if } => {
                let outer = self.finished(scope);
                // What the body computes is in scope in the continuing block and the condition.
                scope.taken.push(Vec::new());
                self.block(scope, body)?;
                let body = self.finished(scope);
                self.block(scope, continuing)?;
                let break_if = break_if.map(|condition| self.one_word(scope, condition)).transpose()?;
                let continuing = self.finished(scope);
                self.leave(scope);
                scope.block = outer;
                self.step(scope, Step::Loop { body, continuing, break_if })
            }
            Statement::Break => self.step(scope, Step::Break),
            Statement::Continue => self.step(scope, Step::Continue),
            Statement::Return { value } => {
                if let Some(value) = value {
                    let value = self.data(scope, *value)?;
                    let results = Rc::clone(&scope.results);
                    for (to, from) in results.iter().zip(value.iter()) {
                        let to = super::Place { root: to_root(*to), offset: 0, address: None };
                        self.emit(scope, Instruction::Store { to, from: *from })?;
                    }
                }
                self.step(scope, Step::Return)
            }
            Statement::Store { pointer, value } => {
                let value = self.data(scope, *value)?;
                let pointer = self.pointer(scope, *pointer)?;
                self.store(scope, &pointer, &value)
            }
            Statement::Call { function, arguments, result } => self.call(scope, *function, arguments, *result),
            Statement::Atomic { pointer, fun, value, result } => self.atomic(scope, *pointer, fun, *value, *result),
            Statement::WorkGroupUniformLoad { pointer, result } => {
                let pointer = self.pointer(scope, *pointer)?;
                let slots = self.load(scope, &pointer)?;
                scope.values[result.index()] = Some(Value::Data(slots));
                Ok(())
            }
            // All lanes of a workgroup run in lockstep, so that each has done what lies before the barrier; a lane that is
            // its own workgroup waits for nobody.
            Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) => Ok(()),
            Statement::Kill => Err(self.unsupported(scope, "`discard`")),
            Statement::ImageStore { .. } | Statement::ImageAtomic { .. } => Err(self.unsupported(scope, "a texture")),
            Statement::RayQuery { .. } | Statement::RayPipelineFunction(_) => {
                Err(self.unsupported(scope, "ray tracing"))
            }
            Statement::SubgroupBallot { .. }
            | Statement::SubgroupGather { .. }
            | Statement::SubgroupCollectiveOperation { .. } => Err(self.unsupported(scope, "subgroups")),
            Statement::CooperativeStore { .. } => Err(self.unsupported(scope, "a cooperative matrix")),
        }
    }

    fn call(
        &mut self,
        scope: &mut Scope<'a, N>,
        function: Handle<naga::Function>,
        arguments: &[Handle<Expression>],
        result: Option<Handle<Expression>>,
    ) -> Result<(), InterpError> {
        if let Some(pair) = self.known_function(scope, function, arguments)? {
            if let Some(result) = result {
                scope.values[result.index()] = Some(Value::Data(pair));
            }
            return Ok(());
        }
        let mut values = Vec::with_capacity(arguments.len());
        let mut pointers = Vec::with_capacity(arguments.len());
        for argument in arguments {
            let value = self.value(scope, *argument)?;
            pointers.push(match &value {
                Value::Data(_) => None,
                Value::Pointer(pointer) => {
                    Some((pointer.place.root, pointer.place.offset, pointer.place.address.is_some()))
                }
            });
            values.push(value);
        }
        let callee = self.callee((function, pointers))?;
        for (parameter, value) in callee.parameters.iter().zip(&values) {
            match (parameter, value) {
                (Parameter::Data(slots), Value::Data(value)) => {
                    for (to, from) in slots.iter().zip(value.iter()) {
                        self.emit(scope, Instruction::Copy(*to, *from))?;
                    }
                }
                (Parameter::Pointer(to), Value::Pointer(pointer)) => self.pass_address(scope, *to, pointer)?,
                _ => return Err(self.unsupported(scope, "an argument that is a pointer in one place only")),
            }
        }
        self.step(scope, Step::Call(callee.routine))?;
        if let Some(result) = result {
            // The next call of the routine overwrites its results.
            let mut slots = Vec::with_capacity(callee.results.len());
            for from in callee.results.iter() {
                let to = self.like(scope, *from)?;
                self.emit(scope, Instruction::Copy(to, *from))?;
                slots.push(to);
            }
            scope.values[result.index()] = Some(Value::Data(Rc::from(slots)));
        }
        Ok(())
    }

    /// The results of a function that stands for a method of `Real`.
    fn known_function(
        &mut self,
        scope: &mut Scope<'a, N>,
        function: Handle<naga::Function>,
        arguments: &[Handle<Expression>],
    ) -> Result<Option<Rc<[Slot]>>, InterpError> {
        let name = self.module.functions[function].name.as_deref();
        let Some((_, kind)) = self.known.iter().find(|(known, _)| Some(known.as_str()) == name) else {
            return Ok(None);
        };
        let mut columns = Vec::with_capacity(arguments.len());
        for argument in arguments {
            match self.data(scope, *argument)?.as_ref() {
                [Slot::Real(column)] => columns.push(*column),
                _ => return Ok(None),
            }
        }
        let one: &[Real1<N>] = match kind {
            Known::LnOnePlus => &[|o, a| words::map(o, a, N::ln_one_plus)],
            Known::Erfcx => &[|o, a| words::map(o, a, N::erfcx)],
            Known::UnitCircle => {
                &[|o, a| words::map(o, a, |a| a.unit_circle().0), |o, a| words::map(o, a, |a| a.unit_circle().1)]
            }
            _ => &[],
        };
        let two: &[Real2<N>] = match kind {
            Known::SumExact => &[
                |o, a, b| words::zip(o, a, b, |a, b| a.sum_exact(b).0),
                |o, a, b| words::zip(o, a, b, |a, b| a.sum_exact(b).1),
            ],
            Known::ProductExact => &[
                |o, a, b| words::zip(o, a, b, |a, b| a.product_exact(b).0),
                |o, a, b| words::zip(o, a, b, |a, b| a.product_exact(b).1),
            ],
            Known::ExpProduct => &[|o, a, b| words::zip(o, a, b, N::exp_product)],
            Known::Angle => &[|o, a, b| words::zip(o, a, b, N::angle)],
            _ => &[],
        };
        let mut results = Vec::with_capacity(2);
        match columns.as_slice() {
            [a] => {
                for f in one {
                    results.push(Slot::Real(self.real1(scope, *f, *a)?));
                }
            }
            [a, b] => {
                for f in two {
                    results.push(Slot::Real(self.real2(scope, *f, *a, *b)?));
                }
            }
            _ => {}
        }
        // A function of that name with other parameters is its own.
        Ok((!results.is_empty()).then(|| Rc::from(results)))
    }

    fn atomic(
        &mut self,
        scope: &mut Scope<'a, N>,
        pointer: Handle<Expression>,
        fun: &AtomicFunction,
        value: Handle<Expression>,
        result: Option<Handle<Expression>>,
    ) -> Result<(), InterpError> {
        let scalar = match self.inner(scope, pointer) {
            TypeInner::Pointer { base, .. } => match self.module.types[base].inner {
                TypeInner::Atomic(scalar) | TypeInner::Scalar(scalar) => Some(scalar),
                _ => None,
            },
            _ => None,
        };
        let signed = match scalar.map(|scalar| (scalar.kind, scalar.width)) {
            Some((ScalarKind::Sint, 4)) => true,
            Some((ScalarKind::Uint, 4)) => false,
            _ => return Err(self.unsupported(scope, "an atomic that is not of 32-bit integers")),
        };
        let operand = self.one_word(scope, value)?;
        let place = self.pointer(scope, pointer)?.place;
        let old = self.word(scope)?;
        let mut slots = vec![Slot::Word(old)];
        let kind = match fun {
            AtomicFunction::Add => Atomic::Update(u32::wrapping_add),
            AtomicFunction::Subtract => Atomic::Update(u32::wrapping_sub),
            AtomicFunction::And => Atomic::Update(|a, b| a & b),
            AtomicFunction::ExclusiveOr => Atomic::Update(|a, b| a ^ b),
            AtomicFunction::InclusiveOr => Atomic::Update(|a, b| a | b),
            AtomicFunction::Min if signed => {
                Atomic::Update(|a, b| a.cast_signed().min(b.cast_signed()).cast_unsigned())
            }
            AtomicFunction::Max if signed => {
                Atomic::Update(|a, b| a.cast_signed().max(b.cast_signed()).cast_unsigned())
            }
            AtomicFunction::Min => Atomic::Update(|a, b| a.min(b)),
            AtomicFunction::Max => Atomic::Update(|a, b| a.max(b)),
            AtomicFunction::Exchange { compare: None } => Atomic::Update(|_, b| b),
            AtomicFunction::Exchange { compare: Some(compare) } => {
                let (expected, success) = (self.one_word(scope, *compare)?, self.word(scope)?);
                slots.push(Slot::Word(success));
                Atomic::Compare { expected, success }
            }
        };
        self.emit(scope, Instruction::Atomic { old, place, operand, kind })?;
        if let Some(result) = result {
            scope.values[result.index()] = Some(Value::Data(Rc::from(slots)));
        }
        Ok(())
    }
}

/// The root of one column by itself.
fn to_root(slot: Slot) -> super::Root {
    match slot {
        Slot::Real(real) => super::Root::Lanes { real, word: 0 },
        Slot::Word(word) => super::Root::Lanes { real: 0, word },
    }
}
