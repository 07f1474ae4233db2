//! Whole stacks over slices: [`Plan`]'s stages, each a loop over a block of evaluations that stays in the first cache.

use super::dispatch::{Level, Work};
use super::lanes::{Lanes, load_part, store_part};
use super::{LengthError, check_lengths};
use crate::frame::Vector;
use crate::layered::Model;
use crate::plan::chain::{Chain, Stage, with_surface, with_way};
use crate::plan::stage::Ray;
use crate::plan::{Chains, Plan};
use crate::real::Mask;

/// Vectors of a block: 14 numbers of each, three channels, fill less than half of a first-level cache.
const BLOCK: usize = 16;

impl<const C: usize> Plan<C> {
    /// The BRDF in sr⁻¹ of many pairs of local unit directions, on the calling thread and without allocating: components of the
    /// directions in, a slice for each channel out.
    ///
    /// f32 throughout; what it loses is in `docs/accuracy.md`, column *batch*. Directions as for [`Plan::evaluate`].
    ///
    /// # Errors
    /// Where the slices differ in length; nothing is written then. They are counted wi.x, wi.y, wi.z, wo.x, wo.y, wo.z, then f.
    pub fn evaluate_batch(&self, wi: [&[f32]; 3], wo: [&[f32]; 3], f: [&mut [f32]; C]) -> Result<(), LengthError> {
        self.evaluate_batch_at(Level::detect(), wi, wo, f)
    }

    /// [`Plan::evaluate_batch`] with the instructions of a level that this processor has.
    ///
    /// # Errors
    /// As [`Plan::evaluate_batch`].
    pub fn evaluate_batch_at(
        &self,
        level: Level,
        wi: [&[f32]; 3],
        wo: [&[f32]; 3],
        f: [&mut [f32]; C],
    ) -> Result<(), LengthError> {
        let ([a, b, c], [d, e, g]) = (wi, wo);
        check_lengths(&[a, b, c, d, e, g], &f)?;
        self.run(level, wi, wo, f);
        Ok(())
    }

    /// The BRDF in sr⁻¹ towards one viewer for many lights: what depends on the viewer alone is computed once a block.
    ///
    /// # Errors
    /// As [`Plan::evaluate_batch`]; the slices are counted wi.x, wi.y, wi.z, then f.
    pub fn evaluate_view(&self, wi: [&[f32]; 3], wo: Vector<f32>, f: [&mut [f32]; C]) -> Result<(), LengthError> {
        self.evaluate_view_at(Level::detect(), wi, wo, f)
    }

    /// [`Plan::evaluate_view`] with the instructions of a level that this processor has.
    ///
    /// # Errors
    /// As [`Plan::evaluate_view`].
    pub fn evaluate_view_at(
        &self,
        level: Level,
        wi: [&[f32]; 3],
        wo: Vector<f32>,
        f: [&mut [f32]; C],
    ) -> Result<(), LengthError> {
        check_lengths(&wi, &f)?;
        self.run(level, wi, wo, f);
        Ok(())
    }

    /// [`Plan::evaluate_batch`] on the threads of rayon's current pool.
    ///
    /// # Errors
    /// As [`Plan::evaluate_batch`].
    #[cfg(feature = "rayon")]
    pub fn par_evaluate_batch(&self, wi: [&[f32]; 3], wo: [&[f32]; 3], f: [&mut [f32]; C]) -> Result<(), LengthError> {
        let ([a, b, c], [d, e, g]) = (wi, wo);
        let count = check_lengths(&[a, b, c, d, e, g], &f)?;
        let level = Level::detect();
        super::halve(count, [a, b, c, d, e, g], f, &|[a, b, c, d, e, g], f| self.run(level, [a, b, c], [d, e, g], f));
        Ok(())
    }

    fn run(&self, level: Level, wi: [&[f32]; 3], wo: impl Viewers, f: [&mut [f32]; C]) {
        match self.chains() {
            Chains::Together(chain) => level.run(Run { chain, wi, wo, f }),
            Chains::Apart(chains) => {
                for (chain, f) in chains.iter().zip(f) {
                    level.run(Run { chain, wi, wo, f: [f] });
                }
            }
        }
    }
}

/// Where the directions towards the viewer come from.
trait Viewers: Copy {
    fn load<L: Lanes>(&self, start: usize, length: usize) -> Vector<L>;
}

impl Viewers for [&[f32]; 3] {
    #[inline(always)]
    fn load<L: Lanes>(&self, start: usize, length: usize) -> Vector<L> {
        Vector::new(load(self[0], start, length), load(self[1], start, length), load(self[2], start, length))
    }
}

impl Viewers for Vector<f32> {
    #[inline(always)]
    fn load<L: Lanes>(&self, _: usize, _: usize) -> Vector<L> {
        Vector::new(L::from_f64(f64::from(self.x)), L::from_f64(f64::from(self.y)), L::from_f64(f64::from(self.z)))
    }
}

/// A vector of `length` numbers from `start` on, at most as many as it has lanes.
#[inline(always)]
fn load<L: Lanes>(slice: &[f32], start: usize, length: usize) -> L {
    if length >= L::COUNT { L::load(&slice[start..]) } else { load_part(&slice[start..start + length]) }
}

/// A chain over slices of one length.
struct Run<'a, V, const K: usize> {
    chain: &'a Chain<K>,
    wi: [&'a [f32]; 3],
    wo: V,
    f: [&'a mut [f32]; K],
}

impl<V: Viewers, const K: usize> Run<'_, V, K> {
    /// The directions of a vector of evaluations.
    #[inline(always)]
    fn pair<L: Lanes>(&self, start: usize, count: usize) -> (Vector<L>, Vector<L>) {
        (self.wi.load(start, count - start), self.wo.load(start, count - start))
    }

    /// Puts f of a vector of evaluations in its place.
    #[inline(always)]
    fn put<L: Lanes>(&mut self, start: usize, values: [L; K]) {
        for channel in 0..K {
            let room = &mut self.f[channel][start..];
            if room.len() >= L::COUNT {
                values[channel].store(room);
            } else {
                store_part(values[channel], room);
            }
        }
    }
}

impl<V: Viewers, const K: usize> Work for Run<'_, V, K> {
    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        let count = self.f.first().map_or(0, |f| f.len());
        if let [Stage::Reflect { lobe, surface }] = self.chain.stages.as_slice() {
            // One interface: nothing to keep between stages.
            with_surface!(surface, fresnel => {
                for start in (0..count).step_by(L::COUNT) {
                    let (wi, wo) = self.pair(start, count);
                    let mut ray = Ray::<L, K>::new(wi, wo);
                    lobe.reflect(&mut ray, fresnel);
                    self.put(start, ray.f);
                }
            });
            return;
        }
        let mut rays = [Ray::<L, K>::dark(); BLOCK];
        for start in (0..count).step_by(BLOCK * L::COUNT) {
            let end = count.min(start + BLOCK * L::COUNT);
            let vectors = (end - start).div_ceil(L::COUNT);
            self.block(&mut rays[..vectors], start, end);
            for i in 0..vectors {
                self.put(start + i * L::COUNT, rays[i].f);
            }
        }
    }
}

impl<V: Viewers, const K: usize> Run<'_, V, K> {
    /// Takes the pairs from `start` to `end` through the stages.
    // Loops over indices and no closures: what runs over vectors must be inlined whole.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    fn block<L: Lanes>(&self, rays: &mut [Ray<L, K>], start: usize, end: usize) {
        for i in 0..rays.len() {
            let (wi, wo) = self.pair(start + i * L::COUNT, end);
            rays[i] = Ray::new(wi, wo);
        }
        for stage in &self.chain.stages {
            match stage {
                Stage::Reflect { lobe, surface } => with_surface!(surface, fresnel => {
                    for i in 0..rays.len() {
                        lobe.reflect(&mut rays[i], fresnel);
                    }
                }),
                Stage::Pass { passage, way, model } => {
                    with_way!(way, fresnel => match model {
                        Model::Elek => {
                            for i in 0..rays.len() {
                                let (wi, wo) = self.pair(start + i * L::COUNT, end);
                                passage.elek(&mut rays[i], (wi.z, wo.z), fresnel);
                            }
                        }
                        Model::WeidlichWilkie => {
                            for i in 0..rays.len() {
                                passage.weidlich_wilkie(&mut rays[i], fresnel);
                            }
                        }
                        _ => {
                            for i in 0..rays.len() {
                                let (wi, wo) = self.pair(start + i * L::COUNT, end);
                                passage.conserve(&mut rays[i], (wi.z, wo.z), fresnel);
                            }
                        }
                    });
                    let mut arrives = false;
                    for i in 0..rays.len() {
                        arrives |= rays[i].arrives().any();
                    }
                    if !arrives {
                        return;
                    }
                }
                Stage::Absorb(medium) => {
                    for i in 0..rays.len() {
                        medium.absorb(&mut rays[i]);
                    }
                }
                Stage::Lambert(base) => {
                    for i in 0..rays.len() {
                        base.lambert(&mut rays[i]);
                    }
                }
                Stage::OrenNayar { base, about_half } => {
                    for i in 0..rays.len() {
                        let (wi, wo) = self.pair(start + i * L::COUNT, end);
                        base.oren_nayar(&mut rays[i], wi, wo, *about_half);
                    }
                }
            }
        }
    }
}
