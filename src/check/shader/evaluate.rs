//! Evaluates a shader function for pairs of directions: by the evaluator, or on an adapter.

use super::ShaderFamily;
use crate::check::subject::Subject;
use crate::frame::Vector;
use crate::shader::interp::{Buffers, Cell, InterpError, Number, Program};

/// The pairs of one run: several blocks of the evaluator, so that what a run costs by itself does not show.
const BATCH: usize = 4096;

/// A member of a [`ShaderFamily`].
#[derive(Clone, Debug)]
pub struct ShaderSubject<'a> {
    family: &'a ShaderFamily,
    values: Vec<f64>,
}

/// An error of the evaluator in the words of who has only a shader.
pub(super) fn explained(error: &InterpError, function: &str) -> String {
    match error {
        InterpError::Budget(steps) => {
            format!(
                "`{function}` has not ended after {steps} steps: it has a loop that does not end, or takes too long"
            )
        }
        other => other.to_string(),
    }
}

impl<'a> ShaderSubject<'a> {
    pub(super) fn new(family: &'a ShaderFamily, values: &[f64]) -> Self {
        // A value that is missing is the default: a row must be whole.
        let value = |(index, parameter): (usize, &crate::check::Parameter)| {
            values.get(index).copied().unwrap_or(parameter.default)
        };
        let values = family.parameters.iter().enumerate().map(value).collect();
        ShaderSubject { family, values }
    }

    /// Why an evaluation of the family failed, if one has.
    pub fn error(&self) -> Option<&str> {
        self.family.error()
    }
}

impl ShaderFamily {
    /// Evaluates one pair in each precision, for what only shows when it runs.
    pub(super) fn probe(&self) -> Result<(), String> {
        let values: Vec<f64> = self.parameters.iter().map(|parameter| parameter.default).collect();
        let wi = Vector::new(0.48, 0.36, 0.8);
        let wo = Vector::new(-0.6, 0.0, 0.8);
        let row: Vec<f64> = [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z].into_iter().chain(values.iter().copied()).collect();
        let single: Vec<Cell<f32>> = row.iter().map(|x| Cell::Real(*x as f32)).collect();
        let double: Vec<Cell<f64>> = row.into_iter().map(Cell::Real).collect();
        self.single.run(&single, &mut Buffers::new()).map_err(|error| explained(&error, &self.name))?;
        if let Some(program) = &self.double {
            program.run(&double, &mut Buffers::new()).map_err(|error| explained(&error, &self.name))?;
        }
        Ok(())
    }

    /// Whether f is above 0 nowhere: at the defaults, the least and the greatest of all parameters.
    pub(super) fn is_dark(&self) -> bool {
        let directions = [(0.0, 0.0), (0.6, 0.0), (-0.6, 0.0), (0.0, 0.6), (0.48, -0.36), (0.96, 0.0), (-0.96, 0.0)]
            .map(|(x, y): (f64, f64)| Vector::new(x, y, (1.0 - x * x - y * y).sqrt()));
        let pairs: Vec<_> = directions.iter().flat_map(|wi| directions.iter().map(move |wo| (*wi, *wo))).collect();
        let choices: [fn(&crate::check::Parameter) -> f64; 3] = [|p| p.default, |p| p.low, |p| p.high];
        choices.iter().all(|choice| {
            let values: Vec<f32> = self.parameters.iter().map(|parameter| choice(parameter) as f32).collect();
            let mut cells: Vec<Cell<f32>> = Vec::new();
            for (wi, wo) in &pairs {
                cells.extend([wi.x, wi.y, wi.z, wo.x, wo.y, wo.z].map(|x| Cell::Real(x as f32)));
                cells.extend(values.iter().map(|value| Cell::Real(*value)));
            }
            // What cannot be run is told where it is judged.
            let is_lit = |cell: Cell<f32>| matches!(cell, Cell::Real(f) if f > 0.0);
            self.single.run(&cells, &mut Buffers::new()).is_ok_and(|f| !f.into_iter().any(is_lit))
        })
    }

    fn fail(&self, error: &InterpError) {
        // The first error is the one that is told.
        let _ = self.error.set(explained(error, &self.name));
    }

    /// Runs rows; false, and NaN everywhere, where they cannot be run.
    fn run<N: Number>(&self, program: &Program<N>, cells: &[Cell<N>], f: &mut [N]) -> bool {
        if self.error.get().is_none() {
            match program.run(cells, &mut Buffers::new()) {
                Ok(results) => {
                    for (f, cell) in f.iter_mut().zip(results) {
                        *f = if let Cell::Real(value) = cell { value } else { N::anything() };
                    }
                    return true;
                }
                Err(error) => self.fail(&error),
            }
        }
        f.fill(N::anything());
        false
    }

    /// f of pairs of directions on an adapter, [`ShaderFamily::channels`] numbers a pair.
    ///
    /// # Errors
    /// What the adapter refuses.
    #[cfg(feature = "gpu")]
    pub fn evaluate_on(
        &self,
        gpu: &crate::gpu::Gpu,
        values: &[f64],
        pairs: &[(Vector<f32>, Vector<f32>)],
    ) -> Result<Vec<f32>, crate::gpu::GpuError> {
        let kernel = crate::gpu::Kernel::new(gpu, &self.wgsl, Self::ENTRY, None)?;
        let subject = ShaderSubject::new(self, values);
        let mut rows: Vec<f32> = Vec::with_capacity(pairs.len() * (6 + subject.values.len()));
        for (wi, wo) in pairs {
            rows.extend([wi.x, wi.y, wi.z, wo.x, wo.y, wo.z]);
            rows.extend(subject.values.iter().map(|value| *value as f32));
        }
        kernel.run_f32(&rows, &[])
    }
}

impl Subject for ShaderSubject<'_> {
    fn name(&self) -> String {
        self.family.name.clone()
    }

    fn channels(&self) -> usize {
        self.family.channels
    }

    fn evaluate(&self, wi: Vector<f64>, wo: Vector<f64>, f: &mut [f64]) {
        self.evaluate_many(&[(wi, wo)], f);
    }

    fn evaluate_single(&self, wi: Vector<f32>, wo: Vector<f32>, f: &mut [f32]) -> bool {
        let mut cells: Vec<Cell<f32>> = [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z].map(Cell::Real).to_vec();
        cells.extend(self.values.iter().map(|value| Cell::Real(*value as f32)));
        self.family.run(&self.family.single, &cells, f);
        // A result that failed is not one of single precision.
        self.family.error.get().is_none()
    }

    fn evaluate_many(&self, pairs: &[(Vector<f64>, Vector<f64>)], f: &mut [f64]) {
        let channels = self.channels();
        let batches = pairs.chunks(BATCH).zip(f.chunks_mut(BATCH * channels));
        for (pairs, f) in batches {
            match &self.family.double {
                Some(program) => {
                    let mut cells = Vec::with_capacity(pairs.len() * (6 + self.values.len()));
                    for (wi, wo) in pairs {
                        cells.extend([wi.x, wi.y, wi.z, wo.x, wo.y, wo.z].map(Cell::Real));
                        cells.extend(self.values.iter().map(|value| Cell::Real(*value)));
                    }
                    self.family.run(program, &cells, f);
                }
                None => {
                    let mut single = vec![0.0f32; f.len()];
                    let mut cells = Vec::with_capacity(pairs.len() * (6 + self.values.len()));
                    for (wi, wo) in pairs {
                        cells.extend([wi.x, wi.y, wi.z, wo.x, wo.y, wo.z].map(|x| Cell::Real(x as f32)));
                        cells.extend(self.values.iter().map(|value| Cell::Real(*value as f32)));
                    }
                    self.family.run(&self.family.single, &cells, &mut single);
                    for (f, single) in f.iter_mut().zip(single) {
                        *f = f64::from(single);
                    }
                }
            }
        }
    }
}
