//! Shader functions, bounded by the evaluator.

use super::{Enclosure, Provable};
use crate::check::family::{Family, Parameter};
use crate::check::shader::ShaderFamily;
use crate::frame::Vector;
use crate::real::Real;
use crate::shader::interp::{Buffers, Cell, InterpError, Program, Shader};

/// The steps of a block of boxes, after which they are undecided: a loop over bounds may not know its end.
const BUDGET: u64 = 2_000_000;

/// A function of a shader file, to be bounded over boxes.
#[derive(Debug)]
pub struct ShaderFormula<'a> {
    family: &'a ShaderFamily,
    program: Program<Enclosure>,
}

impl<'a> ShaderFormula<'a> {
    /// Makes the function ready.
    ///
    /// # Errors
    /// What the evaluator refuses.
    pub fn new(family: &'a ShaderFamily) -> Result<Self, InterpError> {
        let shader = Shader::in_double(family.wgsl()).or_else(|_| Shader::parse(family.wgsl()))?;
        let program = Program::new(&shader, ShaderFamily::ENTRY)?.with_budget(BUDGET);
        Ok(ShaderFormula { family, program })
    }
}

impl Provable for ShaderFormula<'_> {
    fn name(&self) -> String {
        self.family.name()
    }

    fn parameters(&self) -> &[Parameter] {
        self.family.parameters()
    }

    fn enclose(&self, rows: &[Enclosure], count: usize) -> Vec<Enclosure> {
        let cells: Vec<Cell<Enclosure>> = rows.iter().copied().map(Cell::Real).collect();
        let Ok(results) = self.program.run(&cells, &mut Buffers::new()) else {
            return vec![Enclosure::ANYTHING; count];
        };
        let channel = |cell: &Cell<Enclosure>| if let Cell::Real(value) = cell { *value } else { Enclosure::ANYTHING };
        let least = |cells: &[Cell<Enclosure>]| cells.iter().map(channel).reduce(Real::min);
        results.chunks(self.family.channels()).map(|cells| least(cells).unwrap_or(Enclosure::ANYTHING)).collect()
    }

    fn value(&self, wi: Vector<f64>, wo: Vector<f64>, parameters: &[f64]) -> f64 {
        let mut f = vec![0.0; self.family.channels()];
        self.family.subject(parameters).evaluate(wi, wo, &mut f);
        // NaN is smaller than any number here.
        f.iter().copied().find(|f| !f.is_finite()).unwrap_or_else(|| f.iter().copied().fold(f64::INFINITY, f64::min))
    }
}
