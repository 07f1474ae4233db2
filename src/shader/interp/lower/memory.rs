//! Variables, and the places within them.

use super::super::code::{Instruction, Length, Memory, Place, Root, Slot};
use super::super::error::InterpError;
use super::super::layout::{Kind, Leaf, fixed_length};
use super::super::number::Number;
use super::super::words;
use super::{Lowering, Pointer, Scope};
use naga::{AddressSpace, Handle, TypeInner};
use std::rc::Rc;

/// The leaves from one element of a composite to the next, the number of elements, and the kinds of one.
pub(super) type Elements = (u32, Option<u32>, Rc<[Kind]>);

impl<'a, N: Number> Lowering<'a, N> {
    /// A variable of which every lane has its own.
    pub(super) fn lane_variable(
        &mut self,
        scope: &Scope<'a, N>,
        ty: Handle<naga::Type>,
    ) -> Result<Pointer, InterpError> {
        let kinds = self.kinds(scope, ty)?;
        let root = Root::Lanes { real: self.code.reals, word: self.code.words };
        // Leaf i has the i-th column of its kind; a kind that no leaf has takes no columns.
        let count = kinds.len() as u32;
        if kinds.iter().any(|kind| matches!(kind, Kind::Real(_))) {
            self.code.reals += count;
            Self::bounded(self.code.reals)?;
        }
        if kinds.iter().any(|kind| !matches!(kind, Kind::Real(_))) {
            self.code.words += count;
            Self::bounded(self.code.words)?;
        }
        Ok(Pointer { place: Place { root, offset: 0, address: None }, kinds })
    }

    /// The columns of a place without an address in columns; empty for any other.
    pub(super) fn lane_slots(&self, pointer: &Pointer) -> Vec<Slot> {
        let Place { root: Root::Lanes { real, word }, offset, address: None } = pointer.place else {
            return Vec::new();
        };
        let slot = |(index, kind): (u32, &Kind)| match kind {
            Kind::Real(_) => Slot::Real(real + offset + index),
            _ => Slot::Word(word + offset + index),
        };
        (0..).zip(pointer.kinds.iter()).map(slot).collect()
    }

    /// The place of a global variable.
    pub(super) fn global(
        &mut self,
        scope: &mut Scope<'a, N>,
        handle: Handle<naga::GlobalVariable>,
    ) -> Result<Pointer, InterpError> {
        if let Some(pointer) = self.globals.get(&handle) {
            return Ok(pointer.clone());
        }
        let module = self.module;
        let variable = &module.global_variables[handle];
        let name = variable.name.clone().unwrap_or_default();
        let writable = match variable.space {
            AddressSpace::Private => return self.lane_global(scope, handle),
            AddressSpace::WorkGroup if !self.is_group => return self.lane_global(scope, handle),
            AddressSpace::WorkGroup => true,
            AddressSpace::Uniform => false,
            AddressSpace::Storage { access } => access.contains(naga::StorageAccess::STORE),
            _ => {
                let what = self.layout.leaves(variable.ty).err();
                let what = what.unwrap_or_else(|| "an address space of its own".to_owned());
                return Err(self.unsupported(scope, format!("{what} (`{name}`)")));
            }
        };
        // Buffers are laid out by the types as written.
        let written = match variable.binding {
            None => Some(variable.ty),
            Some(_) => {
                // Entry points may use one binding for different variables; names are unique.
                let ir = self.shader.written().ir();
                ir.global_variables.iter().find(|(_, v)| v.name == variable.name).map(|(_, v)| v.ty)
            }
        };
        let Some(written) = written else {
            return Err(self.unsupported(scope, format!("a binding that is not as written (`{name}`)")));
        };
        let layout = if variable.binding.is_some() { &self.written_layout } else { &self.layout };
        let describe = || -> Result<(Vec<Leaf>, Vec<Leaf>, u32, u32), String> {
            let (mut fixed, mut element) = (Vec::new(), Vec::new());
            layout.flatten(written, 0, &mut fixed)?;
            let (stride, start) = match layout.runtime_array(written) {
                Some((base, stride, start)) => {
                    layout.flatten(base, 0, &mut element)?;
                    (stride, start)
                }
                None => (0, 0),
            };
            Ok((fixed, element, stride, start))
        };
        let (fixed, element, stride, bytes) = describe().map_err(|what| self.unsupported(scope, what))?;
        if fixed.iter().chain(&element).any(|leaf| leaf.kind == Kind::Exponent) {
            return Err(self.unsupported(scope, format!("integers of 64 bits (`{name}`)")));
        }
        let binding = variable.binding.map(|binding| (binding.group, binding.binding));
        let kinds = self.kinds(scope, variable.ty)?;
        // Variables at one binding are one memory.
        let same = self.code.memories.iter().position(|memory| binding.is_some() && memory.binding == binding);
        let index = match same {
            Some(index) => {
                let memory = &mut self.code.memories[index];
                if (&memory.fixed, &memory.element, memory.stride, memory.bytes) != (&fixed, &element, stride, bytes) {
                    let what = format!("`{}` and `{name}`, of different types at one binding", memory.name);
                    return Err(self.unsupported(scope, what));
                }
                memory.writable |= writable;
                index as u32
            }
            None => {
                self.code.memories.push(Memory { binding, name, writable, fixed, element, stride, bytes });
                self.code.memories.len() as u32 - 1
            }
        };
        let pointer = Pointer { place: Place { root: Root::Shared(index), offset: 0, address: None }, kinds };
        self.globals.insert(handle, pointer.clone());
        Ok(pointer)
    }

    fn lane_global(
        &mut self,
        scope: &mut Scope<'a, N>,
        handle: Handle<naga::GlobalVariable>,
    ) -> Result<Pointer, InterpError> {
        let variable = &self.module.global_variables[handle];
        let pointer = self.lane_variable(scope, variable.ty)?;
        let initial = match variable.init {
            Some(init) => self.constant(scope, init)?,
            None => self.zeros(&pointer.kinds)?,
        };
        let slots = self.lane_slots(&pointer);
        self.code.initial.extend(slots.into_iter().zip(initial.iter().copied()));
        self.globals.insert(handle, pointer.clone());
        Ok(pointer)
    }

    /// Loads every leaf of a place.
    pub(super) fn load(&mut self, scope: &mut Scope<'a, N>, pointer: &Pointer) -> Result<Rc<[Slot]>, InterpError> {
        let mut slots = Vec::with_capacity(pointer.kinds.len());
        let direct = self.lane_slots(pointer);
        for (index, kind) in pointer.kinds.iter().enumerate() {
            let to = match kind {
                Kind::Real(_) => Slot::Real(self.real(scope)?),
                _ => Slot::Word(self.word(scope)?),
            };
            match direct.get(index) {
                Some(from) => self.emit(scope, Instruction::Copy(to, *from))?,
                None => self.emit(scope, Instruction::Load { to, from: leaf(pointer.place, index) })?,
            }
            slots.push(to);
        }
        Ok(Rc::from(slots))
    }

    /// Stores every leaf of a value.
    pub(super) fn store(
        &mut self,
        scope: &mut Scope<'a, N>,
        pointer: &Pointer,
        value: &[Slot],
    ) -> Result<(), InterpError> {
        for (index, from) in value.iter().enumerate() {
            self.emit(scope, Instruction::Store { to: leaf(pointer.place, index), from: *from })?;
        }
        Ok(())
    }

    /// The type that is indexed: what a pointer points to, or the type itself.
    pub(super) fn indexed(&self, inner: &TypeInner) -> TypeInner {
        match inner {
            TypeInner::Pointer { base, .. } => self.module.types[*base].inner.clone(),
            TypeInner::ValuePointer { size: Some(size), scalar, .. } => {
                TypeInner::Vector { size: *size, scalar: *scalar }
            }
            other => other.clone(),
        }
    }

    /// The leaves from one element of a composite to the next, the number of elements, and the kinds of one.
    pub(super) fn elements(&self, scope: &Scope<'a, N>, inner: &TypeInner) -> Result<Elements, InterpError> {
        let vector = |scalar, count: usize| {
            let kind = super::super::layout::kind_of(scalar).map_err(|what| self.unsupported(scope, what))?;
            Ok::<Rc<[Kind]>, InterpError>(Rc::from(vec![kind; count]))
        };
        match inner {
            TypeInner::Vector { size, scalar } => Ok((1, Some(*size as u32), vector(*scalar, 1)?)),
            TypeInner::Matrix { columns, rows, scalar } => {
                Ok((*rows as u32, Some(*columns as u32), vector(*scalar, *rows as usize)?))
            }
            TypeInner::Array { base, size, .. } => {
                let kinds = self.kinds(scope, *base)?;
                Ok((kinds.len() as u32, fixed_length(self.module, *size), kinds))
            }
            _ => Err(self.unsupported(scope, "an index into a type without elements")),
        }
    }

    /// The leaves before a member of a struct, and the kinds of the member.
    pub(super) fn member(
        &self,
        scope: &Scope<'a, N>,
        members: &[naga::StructMember],
        index: u32,
    ) -> Result<(u32, Rc<[Kind]>), InterpError> {
        let mut before = 0;
        for member in members.iter().take(index as usize) {
            before += self.layout.leaves(member.ty).map_err(|what| self.unsupported(scope, what))?;
        }
        match members.get(index as usize) {
            Some(member) => Ok((before, self.kinds(scope, member.ty)?)),
            None => Err(self.unsupported(scope, "a member that is not there")),
        }
    }

    /// The place of an element at a constant index.
    pub(super) fn pointer_at(
        &mut self,
        scope: &mut Scope<'a, N>,
        pointer: &Pointer,
        inner: &TypeInner,
        index: u32,
    ) -> Result<Pointer, InterpError> {
        if let TypeInner::Struct { members, .. } = inner {
            let (before, kinds) = self.member(scope, members, index)?;
            let place = Place { offset: pointer.place.offset + before, ..pointer.place };
            return Ok(Pointer { place, kinds });
        }
        let (stride, length, kinds) = self.elements(scope, inner)?;
        match length {
            Some(length) => {
                let index = index.min(length.saturating_sub(1));
                let place = Place { offset: pointer.place.offset + index * stride, ..pointer.place };
                Ok(Pointer { place, kinds })
            }
            // The buffer may be shorter than the index.
            None => {
                let index = self.word_constant(index)?;
                self.pointer_by(scope, pointer, inner, index)
            }
        }
    }

    /// The place of an element at the index in a column, clamped to the elements that there are.
    pub(super) fn pointer_by(
        &mut self,
        scope: &mut Scope<'a, N>,
        pointer: &Pointer,
        inner: &TypeInner,
        index: u32,
    ) -> Result<Pointer, InterpError> {
        let (stride, length, kinds) = self.elements(scope, inner)?;
        let length = match length {
            Some(length) => Length::Fixed(length),
            None => self.runtime_length(scope, pointer, stride)?,
        };
        let to = self.word(scope)?;
        let base = pointer.place.address;
        self.emit(scope, Instruction::Address { to, base, index, stride, length })?;
        Ok(Pointer { place: Place { address: Some(to), ..pointer.place }, kinds })
    }

    /// The length of the runtime-sized array at a place.
    pub(super) fn runtime_length(
        &mut self,
        scope: &Scope<'a, N>,
        pointer: &Pointer,
        stride: u32,
    ) -> Result<Length, InterpError> {
        match pointer.place.root {
            Root::Shared(memory) => {
                let before = self.memory_of(memory).map_or(0, |memory| memory.fixed.len() as u32);
                Ok(Length::Runtime { memory, before, stride: stride.max(1) })
            }
            Root::Lanes { .. } => Err(self.unsupported(scope, "a runtime-sized array outside a buffer")),
        }
    }

    /// Copies a place's address into the column that a routine reads it from.
    pub(super) fn pass_address(
        &mut self,
        scope: &mut Scope<'a, N>,
        to: Option<u32>,
        pointer: &Pointer,
    ) -> Result<(), InterpError> {
        match (to, pointer.place.address) {
            (Some(to), Some(from)) => self.emit(scope, Instruction::Copy(Slot::Word(to), Slot::Word(from))),
            _ => Ok(()),
        }
    }

    /// One element out of a value's columns, by the word in a column.
    pub(super) fn pick(
        &mut self,
        scope: &mut Scope<'a, N>,
        slots: &[Slot],
        stride: u32,
        length: u32,
        index: u32,
    ) -> Result<Rc<[Slot]>, InterpError> {
        self.list(slots.len())?;
        let at = self.word(scope)?;
        let length = Length::Fixed(length);
        self.emit(scope, Instruction::Address { to: at, base: None, index, stride: 1, length })?;
        let stride = stride.max(1) as usize;
        let mut picked = Vec::with_capacity(stride);
        for leaf in 0..stride {
            let from: Box<[Slot]> = slots.iter().skip(leaf).step_by(stride).copied().collect();
            let Some(first) = from.first() else { break };
            let to = self.like(scope, *first)?;
            self.emit(scope, Instruction::Pick { to, index: at, from })?;
            picked.push(to);
        }
        Ok(Rc::from(picked))
    }

    /// Bools as 0 or 1: an open one forks its lane.
    pub(super) fn decided(&mut self, scope: &mut Scope<'a, N>, column: u32) -> Result<u32, InterpError> {
        if !N::MAY_BE_OPEN {
            return Ok(column);
        }
        let to = self.word(scope)?;
        self.emit(scope, Instruction::Decide(to, column))?;
        Ok(to)
    }

    /// The negation of a bool.
    pub(super) fn negated(&mut self, scope: &mut Scope<'a, N>, column: u32) -> Result<u32, InterpError> {
        self.word1(scope, words::NOT, column)
    }
}

/// The place of one leaf of a place.
fn leaf(place: Place, index: usize) -> Place {
    Place { offset: place.offset + index as u32, ..place }
}
