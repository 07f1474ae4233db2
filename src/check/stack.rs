//! A stack under judgement, in double precision and as f32 computes it.

use super::subject::{Sample, Subject};
use crate::frame::Vector;
use crate::layered::Stack;

/// A stack and its name as a [`Subject`].
#[derive(Clone, Debug)]
pub struct StackSubject<const C: usize> {
    name: String,
    double: Stack<f64, C>,
    single: Stack<f32, C>,
}

impl<const C: usize> StackSubject<C> {
    /// The subject of a stack.
    pub fn new(name: impl Into<String>, stack: Stack<f64, C>) -> Self {
        StackSubject { name: name.into(), single: stack.cast(), double: stack }
    }
}

impl<const C: usize> Subject for StackSubject<C> {
    fn name(&self) -> String {
        self.name.clone()
    }
    fn channels(&self) -> usize {
        C
    }
    fn evaluate(&self, wi: Vector<f64>, wo: Vector<f64>, f: &mut [f64]) {
        f.copy_from_slice(&self.double.evaluate(wi, wo));
    }
    fn evaluate_single(&self, wi: Vector<f32>, wo: Vector<f32>, f: &mut [f32]) -> bool {
        f.copy_from_slice(&self.single.evaluate(wi, wo));
        true
    }
    fn samples(&self) -> bool {
        true
    }
    fn sample(&self, wo: Vector<f64>, u: [f64; 3]) -> Option<Sample> {
        let drawn = self.double.sample(wo, u)?;
        let scale = drawn.wi.z / drawn.pdf;
        let weight = self.double.evaluate(drawn.wi, wo).map(|f| f * scale).to_vec();
        Some(Sample { wi: drawn.wi, weight, pdf: drawn.pdf })
    }
    fn pdf(&self, wi: Vector<f64>, wo: Vector<f64>) -> f64 {
        self.double.pdf(wi, wo)
    }
}
