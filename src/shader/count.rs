//! How much a module asks an adapter to do, counted in what naga makes of it.

use super::{Module, ShaderError, causes};

/// The size of a module: each function once, however often it is called, and each loop's body once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Functions, entry points included.
    pub functions: usize,
    /// Expressions of naga's IR that are computed: no literals, no arguments, no names of variables.
    pub expressions: usize,
    /// Statements of naga's IR, nested ones too; ranges in which expressions are computed are none.
    pub statements: usize,
    /// Instructions of SPIR-V within functions.
    pub instructions: usize,
    /// Words of SPIR-V, the header included.
    pub words: usize,
}

impl Module {
    /// The size of the module, in naga's IR and in SPIR-V.
    ///
    /// # Errors
    /// naga's message where SPIR-V cannot express the module.
    pub fn counts(&self) -> Result<Counts, ShaderError> {
        let options = naga::back::spv::Options {
            // No names, and no guards of accesses: only what the module itself says.
            flags: naga::back::spv::WriterFlags::empty(),
            ..Default::default()
        };
        let words = naga::back::spv::write_vec(&self.ir, &self.info, &options, None)
            .map_err(|error| ShaderError::plain(causes(&error)))?;
        let functions = || {
            let entries = self.ir.entry_points.iter().map(|entry| &entry.function);
            self.ir.functions.iter().map(|(_, function)| function).chain(entries)
        };
        Ok(Counts {
            functions: functions().count(),
            expressions: functions().flat_map(|f| f.expressions.iter()).filter(|(_, e)| computes(e)).count(),
            statements: functions().map(|f| statements(&f.body)).sum(),
            instructions: instructions(&words),
            words: words.len(),
        })
    }
}

fn computes(expression: &naga::Expression) -> bool {
    use naga::Expression::{
        CallResult, Constant, FunctionArgument, GlobalVariable, Literal, LocalVariable, Override, ZeroValue,
    };
    !matches!(
        expression,
        Literal(_)
            | Constant(_)
            | Override(_)
            | ZeroValue(_)
            | FunctionArgument(_)
            | GlobalVariable(_)
            | LocalVariable(_)
            | CallResult(_)
    )
}

fn statements(block: &naga::Block) -> usize {
    use naga::Statement;
    let one = |statement: &Statement| match statement {
        Statement::Emit(_) => 0,
        Statement::Block(block) => statements(block),
        Statement::If { accept, reject, .. } => 1 + statements(accept) + statements(reject),
        Statement::Switch { cases, .. } => 1 + cases.iter().map(|case| statements(&case.body)).sum::<usize>(),
        Statement::Loop { body, continuing, .. } => 1 + statements(body) + statements(continuing),
        _ => 1,
    };
    block.iter().map(one).sum()
}

/// The instructions between `OpFunction` and `OpFunctionEnd`, without those two, parameters, labels and variables.
fn instructions(words: &[u32]) -> usize {
    const FUNCTION: u32 = 54;
    const PARAMETER: u32 = 55;
    const END: u32 = 56;
    const VARIABLE: u32 = 59;
    const LABEL: u32 = 248;
    let (mut at, mut inside, mut count) = (5, false, 0);
    while at < words.len() {
        let (opcode, length) = (words[at] & 0xffff, (words[at] >> 16).max(1) as usize);
        match opcode {
            FUNCTION => inside = true,
            END => inside = false,
            PARAMETER | VARIABLE | LABEL => {}
            _ => count += usize::from(inside),
        }
        at += length;
    }
    count
}
