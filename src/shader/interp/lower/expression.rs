//! Expressions: constants, composites taken apart, loads.

use super::super::code::{Instruction, Slot};
use super::super::error::InterpError;
use super::super::layout::{Kind, kind_of};
use super::super::number::Number;
use super::{Lowering, Pointer, Scope, Value};
use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{Arena, Expression, Handle, Literal, TypeInner};
use std::rc::Rc;

/// Expressions and their types: those of a function, or those of the module.
#[derive(Clone, Copy)]
pub(super) struct Expressions<'a> {
    pub(super) arena: &'a Arena<Expression>,
    pub(super) types: Types<'a>,
}

/// Who knows the types of expressions.
#[derive(Clone, Copy)]
pub(super) enum Types<'a> {
    Function(&'a FunctionInfo),
    Module(&'a ModuleInfo),
}

impl<'a> Expressions<'a> {
    fn inner(self, handle: Handle<Expression>, module: &'a naga::Module) -> &'a TypeInner {
        match self.types {
            Types::Function(info) => info[handle].ty.inner_with(&module.types),
            Types::Module(info) => info[handle].inner_with(&module.types),
        }
    }
}

impl<'a, N: Number> Lowering<'a, N> {
    /// The type of an expression.
    pub(super) fn inner(&self, scope: &Scope<'a, N>, handle: Handle<Expression>) -> TypeInner {
        scope.code.inner(handle, self.module).clone()
    }

    /// The scalar type of an expression's components.
    pub(super) fn kind(&self, scope: &Scope<'a, N>, handle: Handle<Expression>) -> Result<Kind, InterpError> {
        let scalar = match self.inner(scope, handle) {
            TypeInner::Pointer { base, .. } => self.module.types[base].inner.scalar(),
            inner => inner.scalar(),
        };
        match scalar.map(kind_of) {
            Some(Ok(kind)) => Ok(kind),
            Some(Err(what)) => Err(self.unsupported(scope, what)),
            None => Err(self.unsupported(scope, "an operation on a type without components")),
        }
    }

    /// The value of an expression: computed already, or one of those that no statement emits.
    pub(super) fn value(&mut self, scope: &mut Scope<'a, N>, handle: Handle<Expression>) -> Result<Value, InterpError> {
        if let Some(Some(value)) = scope.values.get(handle.index()) {
            return Ok(value.clone());
        }
        // What no statement emits is constant, and computed before everything else.
        let outer = std::mem::replace(&mut scope.is_prologue, true);
        self.enter()?;
        let value = self.expression(scope, handle)?;
        self.depth -= 1;
        scope.is_prologue = outer;
        scope.values[handle.index()] = Some(value.clone());
        Ok(value)
    }

    pub(super) fn data(
        &mut self,
        scope: &mut Scope<'a, N>,
        handle: Handle<Expression>,
    ) -> Result<Rc<[Slot]>, InterpError> {
        match self.value(scope, handle)? {
            Value::Data(slots) => Ok(slots),
            Value::Pointer(_) => Err(self.unsupported(scope, "a pointer as a value")),
        }
    }

    pub(super) fn pointer(
        &mut self,
        scope: &mut Scope<'a, N>,
        handle: Handle<Expression>,
    ) -> Result<Pointer, InterpError> {
        match self.value(scope, handle)? {
            Value::Pointer(pointer) => Ok(pointer),
            Value::Data(_) => Err(self.unsupported(scope, "a value as a pointer")),
        }
    }

    pub(super) fn one_word(
        &mut self,
        scope: &mut Scope<'a, N>,
        handle: Handle<Expression>,
    ) -> Result<u32, InterpError> {
        match self.data(scope, handle)?.as_ref() {
            [Slot::Word(column)] => Ok(*column),
            _ => Err(self.unsupported(scope, "something other than an integer or a bool here")),
        }
    }

    /// The columns of a constant expression of the module.
    pub(super) fn constant(
        &mut self,
        scope: &mut Scope<'a, N>,
        handle: Handle<Expression>,
    ) -> Result<Rc<[Slot]>, InterpError> {
        if matches!(scope.code.types, Types::Module(_)) {
            return self.data(scope, handle);
        }
        let body = Expressions { arena: &self.module.global_expressions, types: Types::Module(self.info) };
        let outer = std::mem::replace(&mut scope.code, body);
        std::mem::swap(&mut scope.values, &mut self.constants);
        let slots = self.data(scope, handle);
        std::mem::swap(&mut scope.values, &mut self.constants);
        scope.code = outer;
        slots
    }

    fn literal(&mut self, scope: &Scope<'a, N>, literal: Literal) -> Result<Rc<[Slot]>, InterpError> {
        let slot = match literal {
            Literal::F32(value) => Slot::Real(self.real_constant(f64::from(value))?),
            Literal::F64(value) => Slot::Real(self.real_constant(value)?),
            Literal::U32(value) => Slot::Word(self.word_constant(value)?),
            Literal::I32(value) => Slot::Word(self.word_constant(value.cast_unsigned())?),
            Literal::Bool(value) => Slot::Word(self.word_constant(u32::from(value))?),
            other => return Err(self.unsupported(scope, format!("the literal {other:?}"))),
        };
        Ok(Rc::from([slot]))
    }

    fn swizzled(
        &self,
        scope: &Scope<'a, N>,
        slots: &[Slot],
        size: usize,
        pattern: &[naga::SwizzleComponent; 4],
    ) -> Result<Rc<[Slot]>, InterpError> {
        let picked = pattern.iter().take(size).map(|component| slots.get(*component as usize).copied());
        picked.collect::<Option<_>>().ok_or_else(|| self.unsupported(scope, "a component that is not there"))
    }

    /// The part of a value at a constant index.
    fn part(
        &self,
        scope: &Scope<'a, N>,
        slots: &[Slot],
        inner: &TypeInner,
        index: u32,
    ) -> Result<Rc<[Slot]>, InterpError> {
        let (start, count) = match inner {
            TypeInner::Struct { members, .. } => {
                let (before, kinds) = self.member(scope, members, index)?;
                (before, kinds.len())
            }
            inner => {
                let (stride, _, kinds) = self.elements(scope, inner)?;
                (index.saturating_mul(stride), kinds.len())
            }
        };
        let start = start as usize;
        match slots.get(start..start.saturating_add(count)) {
            Some(part) => Ok(Rc::from(part)),
            None => Err(self.unsupported(scope, "a part that is not there")),
        }
    }

    /// Lowers one expression.
    pub(super) fn expression(
        &mut self,
        scope: &mut Scope<'a, N>,
        handle: Handle<Expression>,
    ) -> Result<Value, InterpError> {
        let module = self.module;
        let expressions = scope.code.arena;
        let span = expressions.get_span(handle);
        if span.is_defined() && matches!(scope.code.types, Types::Function(_)) {
            scope.span = span;
        }
        let slots = match &expressions[handle] {
            Expression::Literal(literal) => self.literal(scope, *literal)?,
            Expression::Constant(constant) => self.constant(scope, module.constants[*constant].init)?,
            Expression::Override(o) => match module.overrides[*o].init {
                Some(init) => self.constant(scope, init)?,
                None => return Err(self.unsupported(scope, "an override without a default")),
            },
            Expression::ZeroValue(ty) => {
                let kinds = self.kinds(scope, *ty)?;
                self.zeros(&kinds)?
            }
            Expression::Compose { components, .. } => {
                let mut slots = Vec::new();
                for component in components {
                    slots.extend_from_slice(&self.data(scope, *component)?);
                }
                Rc::from(slots)
            }
            Expression::Splat { size, value } => {
                let slots = self.data(scope, *value)?;
                slots.iter().copied().cycle().take(slots.len() * *size as usize).collect()
            }
            Expression::Swizzle { size, vector, pattern } => {
                let slots = self.data(scope, *vector)?;
                self.swizzled(scope, &slots, *size as usize, pattern)?
            }
            Expression::AccessIndex { base, index } => {
                let inner = self.indexed(&self.inner(scope, *base));
                match self.value(scope, *base)? {
                    Value::Data(slots) => self.part(scope, &slots, &inner, *index)?,
                    Value::Pointer(pointer) => {
                        return Ok(Value::Pointer(self.pointer_at(scope, &pointer, &inner, *index)?));
                    }
                }
            }
            Expression::Access { base, index } => {
                let inner = self.indexed(&self.inner(scope, *base));
                let index = self.one_word(scope, *index)?;
                match self.value(scope, *base)? {
                    Value::Data(slots) => {
                        let (stride, length, _) = self.elements(scope, &inner)?;
                        self.pick(scope, &slots, stride, length.unwrap_or(1), index)?
                    }
                    Value::Pointer(pointer) => {
                        return Ok(Value::Pointer(self.pointer_by(scope, &pointer, &inner, index)?));
                    }
                }
            }
            Expression::FunctionArgument(index) => match scope.arguments.get(*index as usize) {
                Some(value) => return Ok(value.clone()),
                None => return Err(self.unsupported(scope, "an argument that is not there")),
            },
            Expression::GlobalVariable(handle) => return Ok(Value::Pointer(self.global(scope, *handle)?)),
            Expression::LocalVariable(handle) => match scope.locals.get(handle) {
                Some(pointer) => return Ok(Value::Pointer(pointer.clone())),
                None => return Err(self.unsupported(scope, "a variable that is not there")),
            },
            Expression::Load { pointer } => {
                let pointer = self.pointer(scope, *pointer)?;
                self.load(scope, &pointer)?
            }
            Expression::Unary { op, expr } => {
                let (slots, kind) = (self.data(scope, *expr)?, self.kind(scope, *expr)?);
                self.unary(scope, *op, kind, &slots)?
            }
            Expression::Binary { op, left, right } => self.operator(scope, *op, *left, *right)?,
            Expression::Select { condition, accept, reject } => {
                let (condition, yes, no) =
                    (self.data(scope, *condition)?, self.data(scope, *accept)?, self.data(scope, *reject)?);
                self.select(scope, &condition, &yes, &no)?
            }
            Expression::Relational { fun, argument } => self.relational(scope, *fun, *argument)?,
            Expression::Math { fun, arg, arg1, arg2, arg3 } => self.math(scope, *fun, *arg, [*arg1, *arg2, *arg3])?,
            Expression::As { expr, kind, convert } => self.conversion(scope, *expr, *kind, *convert)?,
            Expression::ArrayLength(array) => {
                let inner = self.indexed(&self.inner(scope, *array));
                let (stride, _, _) = self.elements(scope, &inner)?;
                let pointer = self.pointer(scope, *array)?;
                let length = self.runtime_length(scope, &pointer, stride)?;
                let to = self.word(scope)?;
                self.emit(scope, Instruction::Length { to, length })?;
                Rc::from([Slot::Word(to)])
            }
            Expression::Derivative { .. } => return Err(self.unsupported(scope, "a derivative")),
            Expression::ImageSample { .. } | Expression::ImageLoad { .. } | Expression::ImageQuery { .. } => {
                return Err(self.unsupported(scope, "a texture"));
            }
            Expression::RayQueryVertexPositions { .. }
            | Expression::RayQueryProceedResult
            | Expression::RayQueryGetIntersection { .. } => return Err(self.unsupported(scope, "ray tracing")),
            Expression::SubgroupBallotResult | Expression::SubgroupOperationResult { .. } => {
                return Err(self.unsupported(scope, "subgroups"));
            }
            Expression::CooperativeLoad { .. } | Expression::CooperativeMultiplyAdd { .. } => {
                return Err(self.unsupported(scope, "a cooperative matrix"));
            }
            Expression::CallResult(_)
            | Expression::AtomicResult { .. }
            | Expression::WorkGroupUniformLoadResult { .. } => {
                return Err(self.unsupported(scope, "a result before its statement"));
            }
        };
        self.list(slots.len())?;
        Ok(Value::Data(slots))
    }
}
