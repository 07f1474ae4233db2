//! Whole stacks over slices: [`Plan`]'s stages, each a loop over a block of evaluations that stays in the first cache.

use super::dispatch::{Level, Work};
use super::lanes::{Lanes, load_part, store_part};
use super::{LengthError, check_lengths};
use crate::frame::Vector;
use crate::layered::Model;
use crate::plan::chain::{
    Chain, Conserve, Reflect, Rough, Stage, Steps, Surface, Way, with_metal, with_surface, with_way,
};
use crate::plan::stage::Ray;
use crate::plan::{Chains, Plan};
use crate::real::Mask;

/// Vectors of a block: 16 numbers of each, three channels, fill a quarter of a first-level cache. Twice as many take 2 % less from
/// caches and 20 % more from memory, which waits while a block is computed.
const BLOCK: usize = 8;

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
        super::halve(count, [a, b, c, d, e, g], f, &|[a, b, c, d, e, g], f| {
            self.run(level, [a, b, c], [d, e, g], f);
        });
        Ok(())
    }

    /// [`Plan::evaluate_batch_at`] or [`Plan::evaluate_view_at`] of slices of one length.
    pub(crate) fn run(&self, level: Level, wi: [&[f32]; 3], wo: impl Viewers, f: [&mut [f32]; C]) {
        match self.chains() {
            Chains::Together(chain) => run(level, chain, Slices { wi, wo, f }),
            Chains::Apart(chains) => {
                for (chain, f) in chains.iter().zip(f) {
                    run(level, chain, Slices { wi, wo, f: [f] });
                }
            }
        }
    }
}

/// Takes the pairs through a chain: what most materials are, one interface or a coat of one index over a base, in one loop.
///
/// Each kind of loop is a function of its own: together they would fill the stack where nothing is optimised.
fn run<V: Viewers, const K: usize>(level: Level, chain: &Chain<K>, slices: Slices<'_, V, K>) {
    match chain.stages.as_slice() {
        [Stage::Reflect { lobe, surface }] => with_surface!(surface, fresnel => {
            level.run(Through { steps: Reflect { lobe: *lobe, fresnel: *fresnel }, slices });
        }),
        [
            Stage::Reflect { lobe, surface: Surface::Dielectric(reflected) },
            Stage::Pass { passage, way: Way::Dielectric(passed), model: Model::Conserving },
            below @ ..,
        ] => {
            let coat = (Reflect { lobe: *lobe, fresnel: *reflected }, Conserve { passage: *passage, fresnel: *passed });
            match below {
                [Stage::Absorb(medium), Stage::Reflect { lobe, surface }] => with_metal!(surface, fresnel => {
                    let base = Reflect { lobe: *lobe, fresnel: *fresnel };
                    level.run(Through { steps: ((coat, *medium), base), slices });
                }, else level.run(Blocks { chain, slices })),
                [Stage::Reflect { lobe, surface }] => with_metal!(surface, fresnel => {
                    level.run(Through { steps: (coat, Reflect { lobe: *lobe, fresnel: *fresnel }), slices });
                }, else level.run(Blocks { chain, slices })),
                [Stage::Absorb(medium), Stage::Lambert(base)] => {
                    level.run(Through { steps: ((coat, *medium), *base), slices });
                }
                [Stage::Lambert(base)] => level.run(Through { steps: (coat, *base), slices }),
                [Stage::Absorb(medium), Stage::OrenNayar { base, about_half: false }] => {
                    level.run(Through { steps: ((coat, *medium), Rough(*base)), slices });
                }
                [Stage::OrenNayar { base, about_half: false }] => {
                    level.run(Through { steps: (coat, Rough(*base)), slices });
                }
                _ => level.run(Blocks { chain, slices }),
            }
        }
        _ => level.run(Blocks { chain, slices }),
    }
}

/// Where the directions towards the viewer come from.
pub(crate) trait Viewers: Copy {
    /// The first `count`.
    fn cut(self, count: usize) -> Self;
    fn load<L: Lanes>(&self, start: usize, length: usize) -> Vector<L>;
}

impl Viewers for [&[f32]; 3] {
    #[inline(always)]
    fn cut(self, count: usize) -> Self {
        [&self[0][..count], &self[1][..count], &self[2][..count]]
    }
    #[inline(always)]
    fn load<L: Lanes>(&self, start: usize, length: usize) -> Vector<L> {
        Vector::new(load(self[0], start, length), load(self[1], start, length), load(self[2], start, length))
    }
}

impl Viewers for Vector<f32> {
    #[inline(always)]
    fn cut(self, _: usize) -> Self {
        self
    }
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

/// The directions of a vector of evaluations.
#[inline(always)]
fn pair<L: Lanes>(wi: [&[f32]; 3], wo: impl Viewers, start: usize, end: usize) -> (Vector<L>, Vector<L>) {
    (wi.load(start, end - start), wo.load(start, end - start))
}

/// Directions in, f out.
struct Slices<'a, V, const K: usize> {
    wi: [&'a [f32]; 3],
    wo: V,
    f: [&'a mut [f32]; K],
}

impl<V: Viewers, const K: usize> Slices<'_, V, K> {
    /// All of one length, which the compiler can then tell.
    #[inline(always)]
    fn cut(self) -> (Self, usize) {
        let Slices { wi, wo, mut f } = self;
        let count = wi[0].len();
        for channel in 0..K {
            f[channel] = &mut core::mem::take(&mut f[channel])[..count];
        }
        (Slices { wi: [&wi[0][..count], &wi[1][..count], &wi[2][..count]], wo: wo.cut(count), f }, count)
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

// Loops over indices and no closures: what runs over vectors must be inlined whole. Constants are copied out of the plan, or each
// store to f would have them loaded again.

/// Steps that are one loop.
struct Through<'a, S, V, const K: usize> {
    steps: S,
    slices: Slices<'a, V, K>,
}

impl<S: Steps<K>, V: Viewers, const K: usize> Work for Through<'_, S, V, K> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Through { steps, slices } = self;
        let (mut slices, count) = slices.cut();
        let mut done = 0;
        while done < count {
            let (wi, wo) = if done + L::COUNT <= count {
                pair::<L>(slices.wi, slices.wo, done, done + L::COUNT)
            } else {
                pair::<L>(slices.wi, slices.wo, done, count)
            };
            let mut ray = Ray::<L, K>::new(wi, wo);
            steps.take(&mut ray, wi, wo);
            slices.put(done, ray.f);
            done += L::COUNT;
        }
    }
}

/// Any stages, from one to the next with a block of vectors.
struct Blocks<'a, V, const K: usize> {
    chain: &'a Chain<K>,
    slices: Slices<'a, V, K>,
}

impl<V: Viewers, const K: usize> Work for Blocks<'_, V, K> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Blocks { chain, slices } = self;
        let (mut slices, count) = slices.cut();
        let mut rays = [Ray::<L, K>::dark(); BLOCK];
        for start in (0..count).step_by(BLOCK * L::COUNT) {
            let end = count.min(start + BLOCK * L::COUNT);
            let vectors = (end - start).div_ceil(L::COUNT);
            block(chain, slices.wi, slices.wo, &mut rays[..vectors], start, end);
            for i in 0..vectors {
                slices.put(start + i * L::COUNT, rays[i].f);
            }
        }
    }
}

/// Takes the pairs from `start` to `end` through the stages.
#[inline(always)]
fn block<L: Lanes, const K: usize>(
    chain: &Chain<K>,
    wi: [&[f32]; 3],
    wo: impl Viewers,
    rays: &mut [Ray<L, K>],
    start: usize,
    end: usize,
) {
    for i in 0..rays.len() {
        let (wi, wo) = pair(wi, wo, start + i * L::COUNT, end);
        rays[i] = Ray::new(wi, wo);
    }
    for stage in &chain.stages {
        match stage {
            Stage::Reflect { lobe, surface } => with_surface!(surface, fresnel => {
                let (lobe, fresnel) = (*lobe, *fresnel);
                for i in 0..rays.len() {
                    lobe.reflect(&mut rays[i], &fresnel);
                }
            }),
            Stage::Pass { passage, way, model } => {
                let passage = *passage;
                with_way!(way, fresnel => {
                    let fresnel = *fresnel;
                    match model {
                        Model::Elek => {
                            for i in 0..rays.len() {
                                let (wi, wo) = pair::<L>(wi, wo, start + i * L::COUNT, end);
                                passage.elek(&mut rays[i], (wi.z, wo.z), &fresnel);
                            }
                        }
                        Model::WeidlichWilkie => {
                            for i in 0..rays.len() {
                                passage.weidlich_wilkie(&mut rays[i], &fresnel);
                            }
                        }
                        _ => {
                            for i in 0..rays.len() {
                                let (wi, wo) = pair::<L>(wi, wo, start + i * L::COUNT, end);
                                passage.conserve(&mut rays[i], (wi.z, wo.z), &fresnel);
                            }
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
                let medium = *medium;
                for i in 0..rays.len() {
                    medium.absorb(&mut rays[i]);
                }
            }
            Stage::Lambert(base) => {
                let base = *base;
                for i in 0..rays.len() {
                    base.lambert(&mut rays[i]);
                }
            }
            Stage::OrenNayar { base, about_half } => {
                let (base, about_half) = (*base, *about_half);
                for i in 0..rays.len() {
                    let (wi, wo) = pair(wi, wo, start + i * L::COUNT, end);
                    base.oren_nayar(&mut rays[i], wi, wo, about_half);
                }
            }
        }
    }
}
