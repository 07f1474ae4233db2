//! From naga's IR to instructions on columns.
//!
//! Every function that the chosen one calls becomes a routine once for each set of variables that its pointer parameters
//! point into: pointers are resolved here, and only an index that is not constant is left to be computed.

mod expression;
mod integer;
mod math;
mod memory;
mod operator;
mod statement;

use super::code::{Block, BuiltIn, Code, Instruction, Memory, Place, Real1, Real2, Real3, Root, Routine, Slot, Step};
use super::error::InterpError;
use super::layout::{Kind, Layout};
use super::number::Number;
use super::words::{Word1, Word2};
use super::{Known, Shader};
use expression::{Expressions, Types};
use naga::{Expression, Function, Handle, Span, TypeInner};
use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

/// The most instructions of a program.
const MOST_INSTRUCTIONS: usize = 1 << 20;
/// The most columns that the values of a program list, again and again.
const MOST_SLOTS: usize = 1 << 24;
/// The most columns of a program.
pub(super) const MOST_COLUMNS: u32 = 1 << 18;
/// The most blocks and calls that may lie within each other: each takes a frame of the stack.
const DEEPEST: usize = 300;

/// What an expression is.
#[derive(Clone, Debug)]
enum Value {
    Data(Rc<[Slot]>),
    Pointer(Pointer),
}

/// A place of a type.
#[derive(Clone, Debug)]
struct Pointer {
    place: Place,
    kinds: Rc<[Kind]>,
}

/// The identity of a routine: the function and where its pointers point.
type Key = (Handle<Function>, Vec<Option<(Root, u32, bool)>>);

/// A routine as its callers see it.
#[derive(Clone, Debug)]
struct Callee {
    routine: usize,
    parameters: Vec<Parameter>,
    results: Rc<[Slot]>,
}

#[derive(Clone, Debug)]
enum Parameter {
    Data(Rc<[Slot]>),
    /// The column of the address, where the pointer has one.
    Pointer(Option<u32>),
}

/// What is lowered, and what came of it so far.
pub(super) struct Lowering<'a, N: Number> {
    shader: &'a Shader,
    module: &'a naga::Module,
    info: &'a naga::valid::ModuleInfo,
    layout: Layout<'a>,
    written_layout: Layout<'a>,
    known: &'a [(String, Known)],
    /// Workgroup memory is seen by all lanes: they are one workgroup.
    is_group: bool,
    code: Code<N>,
    real_constants: HashMap<u64, u32>,
    word_constants: HashMap<u32, u32>,
    globals: HashMap<Handle<naga::GlobalVariable>, Pointer>,
    /// The values of the module's expressions.
    constants: Vec<Option<Value>>,
    callees: HashMap<Key, Callee>,
    instructions: usize,
    slots: usize,
    /// The kinds of the types asked for so far.
    type_kinds: RefCell<HashMap<Handle<naga::Type>, Rc<[Kind]>>>,
    depth: usize,
}

/// The function that is being lowered.
struct Scope<'a, N> {
    name: String,
    code: Expressions<'a>,
    values: Vec<Option<Value>>,
    locals: HashMap<Handle<naga::LocalVariable>, Pointer>,
    arguments: Vec<Value>,
    results: Rc<[Slot]>,
    block: Block<N>,
    straight: Vec<Instruction<N>>,
    /// Where instructions of constant expressions go.
    is_prologue: bool,
    /// Columns that blocks have left behind.
    free: [Vec<u32>; 2],
    /// The columns that the blocks being lowered have taken.
    taken: Vec<Vec<Slot>>,
    span: Span,
}

impl<'a, N: Number> Lowering<'a, N> {
    /// Lowers a plain function.
    pub(super) fn function(
        shader: &'a Shader,
        handle: Handle<Function>,
        known: &'a [(String, Known)],
    ) -> Result<Code<N>, InterpError> {
        let mut lowering = Lowering::new(shader, known, false);
        let callee = lowering.callee((handle, Vec::new()))?;
        let mut arguments = Vec::new();
        for parameter in &callee.parameters {
            match parameter {
                Parameter::Data(slots) => arguments.extend_from_slice(slots),
                Parameter::Pointer(_) => return Err(InterpError::Arguments("a pointer is no argument".to_owned())),
            }
        }
        let result = lowering.module.functions[handle].result.as_ref().map(|result| result.ty);
        lowering.code.result_kinds = match result {
            Some(ty) => lowering.layout.kinds(ty).map_err(InterpError::TooLarge)?,
            None => Vec::new(),
        };
        lowering.code.main = callee.routine;
        lowering.code.arguments = arguments;
        lowering.code.results = callee.results.to_vec();
        Ok(lowering.code)
    }

    /// Lowers a compute entry point.
    pub(super) fn entry_point(
        shader: &'a Shader,
        index: usize,
        known: &'a [(String, Known)],
    ) -> Result<Code<N>, InterpError> {
        let mut lowering = Lowering::new(shader, known, true);
        let module = lowering.module;
        let entry = &module.entry_points[index];
        if entry.stage != naga::ShaderStage::Compute {
            return Err(InterpError::Arguments(format!("`{}` is no compute entry point", entry.name)));
        }
        let mut workgroup = entry.workgroup_size;
        for (size, expression) in workgroup.iter_mut().zip(entry.workgroup_size_overrides.unwrap_or_default()) {
            if let Some(expression) = expression {
                *size = lowering.constant_word(expression).ok_or_else(|| {
                    InterpError::Arguments(format!("`{}`: a workgroup size that is computed", entry.name))
                })?;
            }
        }
        lowering.code.workgroup = workgroup;
        let info = lowering.info.get_entry_point(index);
        let Callee { routine, parameters, .. } = lowering.routine(&entry.name, &entry.function, info, &[])?;
        lowering.code.main = routine;
        for (argument, parameter) in entry.function.arguments.iter().zip(parameters) {
            let Parameter::Data(slots) = parameter else { continue };
            let bindings: Vec<_> = match &module.types[argument.ty].inner {
                TypeInner::Struct { members, .. } => {
                    members.iter().map(|member| (&member.binding, member.ty)).collect()
                }
                _ => vec![(&argument.binding, argument.ty)],
            };
            let mut slots = slots.iter();
            for (binding, ty) in bindings {
                let builtin = match binding {
                    Some(naga::Binding::BuiltIn(naga::BuiltIn::GlobalInvocationId)) => BuiltIn::GlobalId,
                    Some(naga::Binding::BuiltIn(naga::BuiltIn::LocalInvocationId)) => BuiltIn::LocalId,
                    Some(naga::Binding::BuiltIn(naga::BuiltIn::LocalInvocationIndex)) => BuiltIn::LocalIndex,
                    Some(naga::Binding::BuiltIn(naga::BuiltIn::WorkGroupId)) => BuiltIn::GroupId,
                    Some(naga::Binding::BuiltIn(naga::BuiltIn::NumWorkGroups)) => BuiltIn::Groups,
                    other => {
                        let what = format!("the input {other:?}");
                        return Err(InterpError::Unsupported { what, function: entry.name.clone(), line: None });
                    }
                };
                let count = lowering.layout.leaves(ty).map_err(InterpError::TooLarge)?;
                for component in 0..count {
                    if let Some(Slot::Word(column)) = slots.next() {
                        lowering.code.builtins.push((*column, builtin, component));
                    }
                }
            }
        }
        Ok(lowering.code)
    }

    fn new(shader: &'a Shader, known: &'a [(String, Known)], is_group: bool) -> Self {
        let module = shader.module.ir();
        Lowering {
            shader,
            module,
            info: shader.module.info(),
            layout: Layout::new(module),
            written_layout: Layout::new(shader.written().ir()),
            known,
            is_group,
            code: Code {
                routines: Vec::new(),
                prologue: Vec::new(),
                initial: Vec::new(),
                main: 0,
                reals: 0,
                words: 0,
                real_constants: Vec::new(),
                word_constants: Vec::new(),
                memories: Vec::new(),
                arguments: Vec::new(),
                results: Vec::new(),
                result_kinds: Vec::new(),
                builtins: Vec::new(),
                workgroup: [1; 3],
            },
            real_constants: HashMap::new(),
            word_constants: HashMap::new(),
            globals: HashMap::new(),
            constants: vec![None; module.global_expressions.len()],
            callees: HashMap::new(),
            instructions: 0,
            slots: 0,
            type_kinds: RefCell::new(HashMap::new()),
            depth: 0,
        }
    }

    /// A constant expression that is a literal word, or an override that defaults to one.
    fn constant_word(&self, handle: Handle<Expression>) -> Option<u32> {
        match self.module.global_expressions[handle] {
            Expression::Literal(naga::Literal::U32(word)) => Some(word),
            Expression::Literal(naga::Literal::I32(word)) => u32::try_from(word).ok(),
            Expression::Constant(constant) => self.constant_word(self.module.constants[constant].init),
            // An override's default is an expression before it.
            Expression::Override(o) => self.module.overrides[o].init.and_then(|init| self.constant_word(init)),
            _ => None,
        }
    }

    fn callee(&mut self, key: Key) -> Result<Callee, InterpError> {
        if let Some(callee) = self.callees.get(&key) {
            return Ok(callee.clone());
        }
        let function = &self.module.functions[key.0];
        let name = function.name.clone().unwrap_or_else(|| "a function without a name".to_owned());
        let callee = self.routine(&name, function, &self.info[key.0], &key.1)?;
        self.callees.insert(key, callee.clone());
        Ok(callee)
    }

    /// Lowers a function whose pointer parameters point into these roots.
    fn routine(
        &mut self,
        name: &str,
        function: &'a Function,
        info: &'a naga::valid::FunctionInfo,
        pointers: &[Option<(Root, u32, bool)>],
    ) -> Result<Callee, InterpError> {
        self.enter()?;
        let mut scope = Scope {
            name: name.to_owned(),
            code: Expressions { arena: &function.expressions, types: Types::Function(info) },
            values: vec![None; function.expressions.len()],
            locals: HashMap::new(),
            arguments: Vec::new(),
            results: Rc::from([]),
            block: Vec::new(),
            straight: Vec::new(),
            is_prologue: false,
            free: [Vec::new(), Vec::new()],
            taken: Vec::new(),
            span: Span::UNDEFINED,
        };
        let mut parameters = Vec::new();
        for (index, argument) in function.arguments.iter().enumerate() {
            if let TypeInner::Pointer { base, .. } = self.module.types[argument.ty].inner {
                let Some(Some((root, offset, moves))) = pointers.get(index).copied() else {
                    return Err(self.unsupported(&scope, "a pointer as an argument from outside"));
                };
                let address = if moves { Some(self.word_column()?) } else { None };
                let kinds = self.kinds(&scope, base)?;
                scope.arguments.push(Value::Pointer(Pointer { place: Place { root, offset, address }, kinds }));
                parameters.push(Parameter::Pointer(address));
            } else {
                let slots = self.columns(&scope, argument.ty)?;
                scope.arguments.push(Value::Data(Rc::clone(&slots)));
                parameters.push(Parameter::Data(slots));
            }
        }
        if let Some(result) = &function.result {
            scope.results = self.columns(&scope, result.ty)?;
        }
        for (handle, variable) in function.local_variables.iter() {
            let pointer = self.lane_variable(&scope, variable.ty)?;
            scope.locals.insert(handle, pointer);
        }
        scope.taken.push(Vec::new());
        for (handle, variable) in function.local_variables.iter() {
            let pointer = scope.locals[&handle].clone();
            let initial = match variable.init {
                Some(init) => self.data(&mut scope, init)?,
                None => self.zeros(&pointer.kinds)?,
            };
            for (to, from) in self.lane_slots(&pointer).into_iter().zip(initial.iter()) {
                self.emit(&mut scope, Instruction::Copy(to, *from))?;
            }
        }
        self.block(&mut scope, &function.body)?;
        let body = self.finished(&mut scope);
        self.code.routines.push(Routine { body });
        self.depth -= 1;
        Ok(Callee { routine: self.code.routines.len() - 1, parameters, results: scope.results })
    }

    /// The steps lowered since the last call.
    fn finished(&mut self, scope: &mut Scope<'a, N>) -> Block<N> {
        if !scope.straight.is_empty() {
            scope.block.push(Step::Run(std::mem::take(&mut scope.straight)));
        }
        std::mem::take(&mut scope.block)
    }

    fn enter(&mut self) -> Result<(), InterpError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(InterpError::TooLarge(format!("blocks and calls nest more than {DEEPEST} deep")));
        }
        Ok(())
    }

    fn step(&mut self, scope: &mut Scope<'a, N>, step: Step<N>) -> Result<(), InterpError> {
        self.count()?;
        if !scope.straight.is_empty() {
            scope.block.push(Step::Run(std::mem::take(&mut scope.straight)));
        }
        scope.block.push(step);
        Ok(())
    }

    fn emit(&mut self, scope: &mut Scope<'a, N>, instruction: Instruction<N>) -> Result<(), InterpError> {
        self.count()?;
        if scope.is_prologue {
            self.code.prologue.push(instruction);
        } else {
            scope.straight.push(instruction);
        }
        Ok(())
    }

    fn count(&mut self) -> Result<(), InterpError> {
        self.instructions += 1;
        if self.instructions > MOST_INSTRUCTIONS {
            return Err(InterpError::TooLarge(format!("the program has more than {MOST_INSTRUCTIONS} instructions")));
        }
        Ok(())
    }

    /// Counts the columns that a value lists.
    fn list(&mut self, slots: usize) -> Result<(), InterpError> {
        self.slots = self.slots.saturating_add(slots);
        if self.slots > MOST_SLOTS {
            return Err(InterpError::TooLarge(format!("the program's values have more than {MOST_SLOTS} scalars")));
        }
        Ok(())
    }

    /// The error for a part of WGSL that is not known here.
    fn unsupported(&self, scope: &Scope<'a, N>, what: impl Into<String>) -> InterpError {
        let line = scope.span.is_defined().then(|| scope.span.location(self.shader.text()).line_number);
        InterpError::Unsupported { what: what.into(), function: scope.name.clone(), line }
    }

    fn kinds(&self, scope: &Scope<'a, N>, ty: Handle<naga::Type>) -> Result<Rc<[Kind]>, InterpError> {
        if let Some(kinds) = self.type_kinds.borrow().get(&ty) {
            return Ok(Rc::clone(kinds));
        }
        let kinds: Rc<[Kind]> = self.layout.kinds(ty).map(Rc::from).map_err(|what| self.unsupported(scope, what))?;
        self.type_kinds.borrow_mut().insert(ty, Rc::clone(&kinds));
        Ok(kinds)
    }

    /// New columns for a value of a type, never given back.
    fn columns(&mut self, scope: &Scope<'a, N>, ty: Handle<naga::Type>) -> Result<Rc<[Slot]>, InterpError> {
        let kinds = self.kinds(scope, ty)?;
        kinds
            .iter()
            .map(|kind| match kind {
                Kind::Real(_) => self.real_column().map(Slot::Real),
                _ => self.word_column().map(Slot::Word),
            })
            .collect()
    }

    fn real_column(&mut self) -> Result<u32, InterpError> {
        self.code.reals += 1;
        Self::bounded(self.code.reals)
    }

    fn word_column(&mut self) -> Result<u32, InterpError> {
        self.code.words += 1;
        Self::bounded(self.code.words)
    }

    fn bounded(columns: u32) -> Result<u32, InterpError> {
        if columns > MOST_COLUMNS {
            return Err(InterpError::TooLarge(format!("the program needs more than {MOST_COLUMNS} registers")));
        }
        Ok(columns - 1)
    }

    /// A column for a value within the current block.
    fn real(&mut self, scope: &mut Scope<'a, N>) -> Result<u32, InterpError> {
        if scope.is_prologue {
            return self.real_column();
        }
        let column = match scope.free[0].pop() {
            Some(column) => column,
            None => self.real_column()?,
        };
        if let Some(taken) = scope.taken.last_mut() {
            taken.push(Slot::Real(column));
        }
        Ok(column)
    }

    fn word(&mut self, scope: &mut Scope<'a, N>) -> Result<u32, InterpError> {
        if scope.is_prologue {
            return self.word_column();
        }
        let column = match scope.free[1].pop() {
            Some(column) => column,
            None => self.word_column()?,
        };
        if let Some(taken) = scope.taken.last_mut() {
            taken.push(Slot::Word(column));
        }
        Ok(column)
    }

    fn like(&mut self, scope: &mut Scope<'a, N>, slot: Slot) -> Result<Slot, InterpError> {
        match slot {
            Slot::Real(_) => self.real(scope).map(Slot::Real),
            Slot::Word(_) => self.word(scope).map(Slot::Word),
        }
    }

    fn real_constant(&mut self, value: f64) -> Result<u32, InterpError> {
        if let Some(column) = self.real_constants.get(&value.to_bits()) {
            return Ok(*column);
        }
        let column = self.real_column()?;
        self.real_constants.insert(value.to_bits(), column);
        self.code.real_constants.push((column, N::from_f64(value).flushed()));
        Ok(column)
    }

    fn word_constant(&mut self, value: u32) -> Result<u32, InterpError> {
        if let Some(column) = self.word_constants.get(&value) {
            return Ok(*column);
        }
        let column = self.word_column()?;
        self.word_constants.insert(value, column);
        self.code.word_constants.push((column, value));
        Ok(column)
    }

    fn zeros(&mut self, kinds: &[Kind]) -> Result<Rc<[Slot]>, InterpError> {
        kinds
            .iter()
            .map(|kind| match kind {
                Kind::Real(_) => self.real_constant(0.0).map(Slot::Real),
                _ => self.word_constant(0).map(Slot::Word),
            })
            .collect()
    }

    fn real1(&mut self, scope: &mut Scope<'a, N>, f: Real1<N>, a: u32) -> Result<u32, InterpError> {
        let to = self.real(scope)?;
        self.emit(scope, Instruction::Real1(f, to, a))?;
        Ok(to)
    }

    fn real2(&mut self, scope: &mut Scope<'a, N>, f: Real2<N>, a: u32, b: u32) -> Result<u32, InterpError> {
        let to = self.real(scope)?;
        self.emit(scope, Instruction::Real2(f, to, a, b))?;
        Ok(to)
    }

    fn real3(&mut self, scope: &mut Scope<'a, N>, f: Real3<N>, a: u32, b: u32, c: u32) -> Result<u32, InterpError> {
        let to = self.real(scope)?;
        self.emit(scope, Instruction::Real3(f, to, a, b, c))?;
        Ok(to)
    }

    fn word1(&mut self, scope: &mut Scope<'a, N>, f: Word1, a: u32) -> Result<u32, InterpError> {
        let to = self.word(scope)?;
        self.emit(scope, Instruction::Word1(f, to, a))?;
        Ok(to)
    }

    fn word2(&mut self, scope: &mut Scope<'a, N>, f: Word2, a: u32, b: u32) -> Result<u32, InterpError> {
        let to = self.word(scope)?;
        self.emit(scope, Instruction::Word2(f, to, a, b))?;
        Ok(to)
    }

    fn memory_of(&self, index: u32) -> Option<&Memory> {
        self.code.memories.get(index as usize)
    }
}
