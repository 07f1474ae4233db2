//! Pictures of convex shapes that are one stack, in vector instructions.
//!
//! Light that a convex shape reflects never meets it again: a path is the viewer, one point and a light. So paths are taken many at a
//! time, in three steps: the directions that light comes from at their points, with all that weighs it but the BRDF; the BRDF of all of
//! them at once, by [`Plan::evaluate_batch`]; and the sums. The paths are those of [`Tracer`](super::Tracer), of the same numbers.

use super::{Options, Strategy, heuristic, pixel_seed};
use crate::batch::Level;
use crate::batch::dispatch::Work;
use crate::batch::lanes::Lanes;
use crate::frame::Vector;
use crate::plan::Plan;
use crate::random::random_in_lanes;
use crate::real::Mask;
use crate::render::film::Tally;
use crate::render::scene::Scene;
use crate::render::shading::whole;
use crate::render::shape;
use crate::sampling::{Sample, Views};
use core::ops::Range;

/// Paths taken at a time: what they keep, 50 bytes for each direction of each, stays in a second-level cache.
const BLOCK: usize = 1024;

/// A scene of a convex shape, prepared.
pub(super) struct Convex<'a> {
    scene: &'a Scene,
    shape: shape::Convex,
    plan: Plan<3>,
    views: Views,
    options: Options,
}

impl<'a> Convex<'a> {
    /// None where the shape is not convex, the material is not one stack under a closed-form model, or paths have no point.
    pub(super) fn new(scene: &'a Scene, options: Options) -> Option<Self> {
        let stack = whole(&scene.material)?;
        let (shape, plan, views) = (scene.shape.convex()?, Plan::new(stack).ok()?, Views::new(stack)?);
        (options.depth > 0).then_some(Convex { scene, shape, plan, views, options })
    }

    /// The tally of each of these pixels, with the instructions of a level.
    pub(super) fn tallies(&self, level: Level, pixels: Range<u32>) -> Vec<Tally> {
        let mut tallies = vec![Tally::default(); pixels.len()];
        let (mut paths, mut arrivals) = (Paths::new(), Arrivals::new(BLOCK * (2 + self.scene.lights.len())));
        let samples = self.options.samples.max(1);
        // Which path comes next: of all pixels, and of one.
        let (mut pixel, mut sample) = (pixels.start, 0u32);
        while pixel < pixels.end {
            paths.clear();
            while pixel < pixels.end && paths.count < BLOCK {
                let room = (BLOCK - paths.count) as u32;
                let end = samples.min(sample.saturating_add(room));
                paths.add(self, pixel, sample..end);
                (pixel, sample) = if end < samples { (pixel, end) } else { (pixel + 1, 0) };
            }
            arrivals.clear();
            level.run(Find { convex: self, paths: &mut paths, arrivals: &mut arrivals });
            arrivals.evaluate(level, &self.plan);
            level.run(Reflect { arrivals: &arrivals, radiance: &mut paths.radiance });
            let [red, green, blue] = &paths.radiance;
            for (pixel, run) in &paths.runs {
                let tally = &mut tallies[(pixel - pixels.start) as usize];
                for ((r, g), b) in red[run.clone()].iter().zip(&green[run.clone()]).zip(&blue[run.clone()]) {
                    tally.add([f64::from(*r), f64::from(*g), f64::from(*b)]);
                }
            }
        }
        tallies
    }
}

/// A block of paths.
struct Paths {
    count: usize,
    /// Which of them are of which pixel.
    runs: Vec<(u32, Range<usize>)>,
    /// The upper left corner of each one's pixel.
    column: Vec<f32>,
    row: Vec<f32>,
    seed: Vec<u32>,
    sample: Vec<u32>,
    /// The radiance that each of them finds.
    radiance: [Vec<f32>; 3],
}

impl Paths {
    fn new() -> Self {
        let (numbers, words) = (|| vec![0.0; BLOCK], || vec![0; BLOCK]);
        let radiance = [numbers(), numbers(), numbers()];
        Paths {
            count: 0,
            runs: Vec::new(),
            column: numbers(),
            row: numbers(),
            seed: words(),
            sample: words(),
            radiance,
        }
    }

    fn clear(&mut self) {
        self.runs.clear();
        self.count = 0;
    }

    /// Adds samples of a pixel, at most as many as there is room for.
    fn add(&mut self, convex: &Convex<'_>, pixel: u32, samples: Range<u32>) {
        let run = self.count..self.count + samples.len();
        let width = convex.scene.camera.width();
        self.column[run.clone()].fill((pixel % width) as f32);
        self.row[run.clone()].fill((pixel / width) as f32);
        self.seed[run.clone()].fill(pixel_seed(convex.options.seed, pixel));
        for (place, sample) in self.sample[run.clone()].iter_mut().zip(samples) {
            *place = sample;
        }
        self.count = run.end;
        self.runs.push((pixel, run));
    }

    /// A group of random numbers for each of a vector of paths.
    #[inline(always)]
    fn random<L: Lanes>(&self, path: usize, dimension: u32) -> [L; 4] {
        random_in_lanes(&self.seed[path..], &self.sample[path..], dimension)
    }
}

/// The light that arrives at the points of paths, a vector of paths and a direction of each after the other.
struct Arrivals {
    /// The first path of each vector.
    paths: Vec<usize>,
    /// How many numbers of each slice are in use.
    count: usize,
    wi: [Vec<f32>; 3],
    wo: [Vec<f32>; 3],
    /// What the BRDF is multiplied by: radiance times cosine over density, or irradiance. 0 where nothing arrives.
    gain: [Vec<f32>; 3],
    f: [Vec<f32>; 3],
}

impl Arrivals {
    fn new(room: usize) -> Self {
        let numbers = || [(); 3].map(|()| vec![0.0; room]);
        Arrivals { paths: Vec::new(), count: 0, wi: numbers(), wo: numbers(), gain: numbers(), f: numbers() }
    }

    fn clear(&mut self) {
        self.paths.clear();
        self.count = 0;
    }

    /// Light of the vector of paths from `path` on, times a scale.
    #[inline(always)]
    fn push<L: Lanes>(&mut self, path: usize, wi: Vector<L>, wo: Vector<L>, light: [L; 3], scale: L) {
        let (wi, wo) = ([wi.x, wi.y, wi.z], [wo.x, wo.y, wo.z]);
        for i in 0..3 {
            wi[i].store(&mut self.wi[i][self.count..]);
            wo[i].store(&mut self.wo[i][self.count..]);
            (light[i] * scale).store(&mut self.gain[i][self.count..]);
        }
        self.count += L::COUNT;
        self.paths.push(path);
    }

    /// The BRDF of all of them.
    fn evaluate(&mut self, level: Level, plan: &Plan<3>) {
        let count = self.count;
        plan.run(level, cut(&self.wi, count), cut(&self.wo, count), self.f.each_mut().map(|f| &mut f[..count]));
    }
}

fn cut(slices: &[Vec<f32>; 3], count: usize) -> [&[f32]; 3] {
    slices.each_ref().map(|slice| &slice[..count])
}

/// Finds the points of a block of paths and the light that arrives there.
struct Find<'a> {
    convex: &'a Convex<'a>,
    paths: &'a mut Paths,
    arrivals: &'a mut Arrivals,
}

impl Work for Find<'_> {
    // Functions and loops over indices, no closures: what runs over vectors must be inlined whole.
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Find { convex: Convex { scene, shape, views, options, .. }, paths, arrivals } = self;
        let environment = &scene.environment;
        let both = options.strategy == Strategy::Both;
        let group = 1;
        // What is behind the last path in its vector are others of before.
        for path in (0..paths.count).step_by(L::COUNT) {
            let [x, y, ..] = paths.random::<L>(path, 0);
            let (column, row) = (L::load(&paths.column[path..]), L::load(&paths.row[path..]));
            let ray = scene.camera.ray_through([column + x, row + y]);
            let (met, position, frame) = shape.meet(&ray);
            let mut behind = [L::ZERO; 3];
            if scene.backdrop && environment.shines() && !met.all() {
                (behind, _) = environment.look(ray.direction);
            }
            for c in 0..3 {
                L::select(met, L::ZERO, behind[c]).store(&mut paths.radiance[c][path..]);
            }
            let wo = frame.to_local(-ray.direction);
            let seen = met & wo.z.gt(L::ZERO);
            if !seen.any() {
                continue;
            }
            for light in &scene.lights {
                let arriving = light.at(position);
                let wi = frame.to_local(arriving.towards);
                let cosine = L::select(seen & wi.z.gt(L::ZERO), wi.z, L::ZERO);
                arrivals.push(path, wi, wo, arriving.irradiance, cosine);
            }
            if !environment.shines() {
                continue;
            }
            let view = views.facing(wo);
            if options.strategy != Strategy::Material {
                let (towards, radiance, drawn) = environment.draw(paths.random(path, group + 1));
                let wi = frame.to_local(towards);
                let weight = if both { heuristic(drawn, view.pdf(wi)) } else { L::ONE };
                arrivals.push(path, wi, wo, radiance, over_density(seen, wi, drawn, weight));
            }
            if options.strategy != Strategy::Environment {
                let [_, u, v, w] = paths.random(path, group);
                let Sample { wi, pdf } = view.draw([u, v, w]);
                let (radiance, other) = environment.look(frame.to_world(wi));
                let weight = if both { heuristic(pdf, other) } else { L::ONE };
                arrivals.push(path, wi, wo, radiance, over_density(seen, wi, pdf, weight));
            }
        }
    }
}

/// What light from a direction drawn with a density counts, by its cosine and weight.
#[inline(always)]
fn over_density<L: Lanes>(seen: L::Mask, wi: Vector<L>, density: L, weight: L) -> L {
    let usable = seen & wi.z.gt(L::ZERO) & density.gt(L::ZERO);
    L::select(usable, wi.z * weight / density, L::ZERO)
}

/// Adds what of the light is reflected to the radiance of its paths.
struct Reflect<'a> {
    arrivals: &'a Arrivals,
    radiance: &'a mut [Vec<f32>; 3],
}

impl Work for Reflect<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Reflect { arrivals: Arrivals { paths, gain, f, .. }, radiance } = self;
        for (vector, path) in paths.iter().enumerate() {
            let at = vector * L::COUNT;
            for c in 0..3 {
                let (gain, sum) = (L::load(&gain[c][at..]), &mut radiance[c][*path..]);
                let reflected = L::select(gain.gt(L::ZERO), L::load(&f[c][at..]) * gain, L::ZERO);
                (L::load(sum) + reflected).store(sum);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Convex;
    use crate::batch::Level;
    use crate::layered::{Interface, Stack};
    use crate::material::stack::{self, built_in};
    use crate::render::camera::{Camera, Orbit};
    use crate::render::environment::Environment;
    use crate::render::film::Tally;
    use crate::render::offline::{Options, Strategy, Tracer};
    use crate::render::shape::Shape;
    use crate::render::{Scene, sources};

    const SIDE: u32 = 19;

    fn scene(shape: Shape, stack: Stack<f64, 3>, environment: Environment) -> Scene {
        let lights = ["directional:1,-1,1,2", "point:-2,-2,2,6,5,4"].map(|light| light.parse().expect("a light"));
        let camera = Camera::new(&Orbit::default(), SIDE, SIDE).expect("a picture");
        Scene { shape, material: stack.into(), camera, lights: lights.into(), environment, backdrop: true }
    }

    /// How many channels differ by more than a part of their value, counted from 1/100 up.
    fn apart(got: &[Tally], want: &[Tally], tolerance: f64) -> usize {
        assert_eq!(got.len(), want.len());
        let differing = |(got, want): (&Tally, &Tally)| {
            assert_eq!(got.count, want.count);
            let close = |c: &usize| (got.sum[*c] - want.sum[*c]).abs() <= tolerance * want.sum[*c].max(1e-2);
            3 - (0..3).filter(close).count()
        };
        got.iter().zip(want).map(differing).sum()
    }

    /// What f32 takes from a path: its point and its directions are off by 2e-6, but at the rim. A lookup of a map whose texels differ by
    /// up to 25 a texel of 1/256 follows by 1e-4; and a lobe of facets, which is exp(−tan²/α²) at up to 3α, by 2·3·2e-6/α.
    fn tolerance(stack: &Stack<f64, 3>) -> f64 {
        let alphas = stack.layers().iter().map(|layer| match layer.interface {
            Interface::Microfacet { alpha, .. } => alpha,
            Interface::Diffuse { .. } => 1.0,
        });
        1e-4 + 6.0 * 2e-6 / alphas.fold(1.0, f64::min)
    }

    #[test]
    fn paths_are_those_of_the_tracer() {
        let pixels = SIDE * SIDE;
        for found in built_in() {
            for shape in [Shape::Sphere, Shape::Plane] {
                for strategy in [Strategy::Both, Strategy::Environment, Strategy::Material] {
                    let scene = scene(shape.clone(), found.stack.clone(), sources::by_name("sky").expect("built in"));
                    // One path to a pixel: each is compared by itself.
                    let options = Options { samples: 1, seed: 3, strategy, ..Options::default() };
                    let convex = Convex::new(&scene, options).expect("convex, one stack");
                    let tracer = Tracer::new(&scene, options);
                    let want: Vec<Tally> = (0..pixels).map(|pixel| tracer.pixel::<f64>(pixel, 0, 1)).collect();
                    for level in Level::available() {
                        let count = apart(&convex.tallies(level, 0..pixels), &want, tolerance(&found.stack));
                        // Paths that meet the rim, and the few that another rounding sends elsewhere.
                        assert!(count <= 6, "{} {shape:?} {strategy:?} {}: {count}", found.name, level.name());
                    }
                }
            }
        }
    }

    #[test]
    fn any_number_of_paths_and_lights_will_do() {
        let stack = stack::by_name("clear_coat_over_copper").expect("built in");
        let base = scene(Shape::Sphere, stack.clone(), sources::by_name("studio").expect("built in"));
        let unlit = Scene { lights: Vec::new(), backdrop: false, ..base.clone() };
        let dark = Scene { environment: Environment::dark(), ..base.clone() };
        for scene in [base, unlit, dark] {
            for (samples, pixels) in [(1, 5..6), (3, 0..SIDE), (2100, 180..183), (1024, 0..1)] {
                let options = Options { samples, ..Options::default() };
                let convex = Convex::new(&scene, options).expect("convex, one stack");
                let tracer = Tracer::new(&scene, options);
                let want: Vec<Tally> = pixels.clone().map(|pixel| tracer.pixel::<f64>(pixel, 0, samples)).collect();
                for level in Level::available() {
                    let got = convex.tallies(level, pixels.clone());
                    assert_eq!(apart(&got, &want, 2.0 * tolerance(&stack)), 0, "{samples} {pixels:?} {}", level.name());
                }
            }
        }
    }

    #[test]
    fn other_scenes_are_left_to_the_tracer() {
        use crate::layered::Model;
        use crate::material::built_in;
        let options = Options::default();
        let stack = stack::by_name("clear_coat_over_copper").expect("built in");
        let simple = scene(Shape::Sphere, stack.clone(), Environment::dark());
        assert!(Convex::new(&simple, options).is_some());
        let torus = crate::render::torus::Torus::new(0.4).expect("a torus");
        let rust = built_in::by_name("rusty_iron").and_then(|found| found.material().ok()).expect("built in");
        for other in [
            Scene { shape: Shape::Torus(torus), ..simple.clone() },
            Scene { material: rust, ..simple.clone() },
            Scene { material: stack.with_model(Model::Coupled).into(), ..simple.clone() },
        ] {
            assert!(Convex::new(&other, options).is_none());
        }
        assert!(Convex::new(&simple, Options { depth: 0, ..options }).is_none());
    }
}
