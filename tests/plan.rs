//! Plans against the general evaluation of the same stack, and each rule at work.

mod stacks;

use brdf::Vector;
use brdf::batch::{LengthError, Level};
use brdf::layered::{Interface, Model, Stack};
use brdf::material::stack;
use brdf::plan::{Options, Plan, Rule};
use stacks::{Random, allowed, moved};

#[test]
fn plans_mean_what_their_stacks_mean() {
    let mut random = Random(1);
    let mut seen = std::collections::HashMap::<Rule, usize>::new();
    let mut worst = 0.0f64;
    for round in 0..3 * 4_000 {
        let model = Model::CLOSED_FORM[round % 3];
        let stack = random.stack(model);
        let plan = Plan::new(&stack).expect("a closed form");
        for applied in plan.applied() {
            *seen.entry(applied.rule).or_default() += 1;
            assert!(applied.layer < stack.layers().len());
        }
        for _ in 0..12 {
            let [wi, wo] = random.pair();
            let (want, got): ([f64; 3], [f64; 3]) = (stack.evaluate(wi, wo), plan.evaluate(wi, wo));
            for ((want, got), bound) in want.into_iter().zip(got).zip(allowed(&stack, [wi, wo])) {
                let error = (got - want).abs();
                worst = worst.max(error / (want + 1e-18));
                assert!(
                    error <= bound,
                    "{wi:?} {wo:?}: {got:e}, but the stack's f is {want:e}, {bound:e} allowed\n{stack:?}\n{plan:?}"
                );
            }
        }
    }
    println!("largest relative difference {worst:e}");
    for rule in Rule::ALL {
        assert!(seen.get(&rule).is_some_and(|times| *times > 20), "{rule} was hardly ever applied: {seen:?}");
    }
}

/// Structure of arrays, as a batch takes them.
fn columns(pairs: &[[Vector<f32>; 2]]) -> [Vec<f32>; 6] {
    let one = |c: usize| {
        let number = |[wi, wo]: &[Vector<f32>; 2]| [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z][c];
        pairs.iter().map(number).collect()
    };
    [0, 1, 2, 3, 4, 5].map(one)
}

/// f of a plan for pairs of directions, by a batch at a level.
fn batch(plan: &Plan<3>, level: Level, pairs: &[[Vector<f32>; 2]]) -> Vec<[f32; 3]> {
    let columns = columns(pairs);
    let [a, b, c, d, e, g] = columns.each_ref().map(Vec::as_slice);
    // What is not written shows.
    let mut f = [(); 3].map(|()| vec![f32::NAN; pairs.len()]);
    plan.evaluate_batch_at(level, [a, b, c], [d, e, g], f.each_mut().map(Vec::as_mut_slice)).expect("of one length");
    (0..pairs.len()).map(|i| [f[0][i], f[1][i], f[2][i]]).collect()
}

/// The bits of every number.
fn bits(f: &[[f32; 3]]) -> Vec<[u32; 3]> {
    f.iter().map(|f| f.map(f32::to_bits)).collect()
}

/// A plan of each of the built-in materials, under each closed-form model.
fn built_in_plans() -> impl Iterator<Item = Plan<3>> {
    let of = |model| stack::built_in().into_iter().map(move |one| one.stack.with_model(model));
    Model::CLOSED_FORM.into_iter().flat_map(of).map(|stack| Plan::new(&stack).expect("a closed form"))
}

/// The spacing of f32 at a positive number.
fn ulp(x: f64) -> f64 {
    f64::from((x as f32).next_up() - x as f32)
}

/// What an Oren–Nayar base may reflect: its parts of that size cancel.
fn cancels(stack: &Stack<f64, 3>) -> [f64; 3] {
    match stack.layers().last().map(|layer| layer.interface) {
        Some(Interface::Diffuse { albedo, sigma }) if sigma > 0.0 => albedo.map(|albedo| albedo / std::f64::consts::PI),
        _ => [0.0; 3],
    }
}

/// Whether no interface has a critical angle, where F has a slope that no rounding of an angle survives: none is thinner than what is
/// above it, and metals are not close to dielectrics that are.
fn steady(stack: &Stack<f64, 3>) -> bool {
    let mut n_above = 1.0;
    stack.layers().iter().enumerate().all(|(position, layer)| {
        let Interface::Microfacet { n, k, .. } = layer.interface else { return true };
        let last = position + 1 == stack.layers().len();
        let reference = if stack.model() == Model::Elek { 1.0 } else { n_above };
        // Refraction is by the real parts, whatever the Fresnel terms take.
        let refracts = last || n.iter().all(|n| *n >= n_above);
        n_above = n[0];
        refracts && (0..3).all(|c| steady_index(n[c] / reference, k[c] / reference))
    })
}

/// The same of one index relative to the medium above: η ≥ 1, or (η+iκ)² − sin² stays at least .1 from 0.
fn steady_index(eta: f64, kappa: f64) -> bool {
    let real = eta * eta - 1.0 - kappa * kappa;
    let distance = real.max(-real - 1.0).max(0.0);
    (eta >= 1.0 && kappa == 0.0) || distance.hypot(2.0 * eta * kappa) >= 0.1
}

/// How far f of a steady stack may be off in a batch in ULP, besides 4 times what half an ULP of one number does to it: measured 5.7
/// over 9000 stacks of one to four layers at each level, whatever their number.
const BATCH_ULP: f64 = 8.0;

/// The largest error of a batch in ULP of f, or of what an Oren–Nayar base may reflect; conditioning taken off where it is more than
/// the bound. Where `share` of the numbers is changed f changes by the conditioning.
fn excess(stack: &Stack<f64, 3>, got: [f32; 3], want: [f64; 3], pair: [Vector<f64>; 2]) -> f64 {
    let base = cancels(stack);
    let mut worst = 0.0f64;
    let mut conditioning = None;
    for c in 0..3 {
        if want[c] < 1e-8 {
            continue;
        }
        let unit = ulp(want[c].max(base[c]));
        let mut error = (f64::from(got[c]) - want[c]).abs() / unit;
        if error.is_nan() || error > BATCH_ULP {
            let half = 0.5 * f64::from(f32::EPSILON);
            error -= 4.0 * conditioning.get_or_insert_with(|| moved(stack, pair, half))[c] / unit;
        }
        assert!(error.is_finite(), "{got:?}, want {want:?}");
        worst = worst.max(error);
    }
    worst
}

#[test]
fn batches_are_as_exact_as_f32_allows() {
    let mut random = Random(7);
    let (mut worst, mut judged) = (0.0f64, 0);
    for round in 0..3_000 {
        let stack = random.stack(Model::CLOSED_FORM[round % 3]);
        let plan = Plan::new(&stack).expect("a closed form");
        let pairs: Vec<[Vector<f32>; 2]> = (0..32).map(|_| random.pair().map(|w| w.cast())).collect();
        let steady = steady(&stack);
        for level in Level::available() {
            for (got, pair) in batch(&plan, level, &pairs).into_iter().zip(&pairs) {
                let pair = pair.map(|w| w.cast::<f64>());
                assert!(got.iter().all(|f| *f >= 0.0), "{} {pair:?}: {got:?}\n{stack:?}", level.name());
                if steady {
                    let error = excess(&stack, got, stack.evaluate(pair[0], pair[1]), pair);
                    (worst, judged) = (worst.max(error), judged + 1);
                    assert!(error <= BATCH_ULP, "{} {pair:?}: {got:?} is {error} ULP off\n{stack:?}", level.name());
                }
            }
        }
    }
    println!("{worst:.2} ULP, {judged} judged");
    assert!(judged > 20_000, "{judged} judged");
}

#[test]
fn each_rule_changes_nothing() {
    for rule in Rule::ALL {
        let stack = rule.example();
        Stack::new(stack.model(), stack.layers().to_vec()).expect("within the ranges");
        let applied = Plan::new(&stack).expect("a closed form").applied().to_vec();
        assert!(applied.iter().any(|applied| applied.rule == rule), "{rule}: {applied:?}");
    }
    let mut random = Random(3);
    let mut seen = std::collections::HashMap::<Rule, usize>::new();
    for round in 0..3_000 {
        let stack = random.stack(Model::CLOSED_FORM[round % 3]);
        let plan = Plan::new(&stack).expect("a closed form");
        let steady = steady(&stack);
        let pairs: Vec<[Vector<f64>; 2]> = (0..8).map(|_| random.pair()).collect();
        let singles: Vec<[Vector<f32>; 2]> = pairs.iter().map(|pair| pair.map(|w| w.cast())).collect();
        for rule in Rule::ALL {
            if !plan.applied().iter().any(|applied| applied.rule == rule) {
                continue;
            }
            *seen.entry(rule).or_default() += 1;
            let off = [rule];
            let without = Plan::with_options(&stack, &Options { without: &off, ..Options::default() });
            let without = without.expect("a closed form");
            assert!(without.applied().iter().all(|applied| applied.rule != rule));
            for pair in &pairs {
                let (a, b): ([f64; 3], [f64; 3]) =
                    (plan.evaluate(pair[0], pair[1]), without.evaluate(pair[0], pair[1]));
                let near = (0..3).all(|c| (a[c] - b[c]).abs() <= 1e-12 * a[c] + 1e-30);
                let bound = if near { [f64::INFINITY; 3] } else { allowed(&stack, *pair) };
                let near = (0..3).all(|c| (a[c] - b[c]).abs() <= bound[c]);
                assert!(near, "{rule} {pair:?}: {a:?} with, {b:?} without\n{stack:?}");
            }
            // Either is off by the bound of a batch.
            let level = Level::detect();
            let both = batch(&plan, level, &singles).into_iter().zip(batch(&without, level, &singles));
            for ((a, b), pair) in both.zip(&singles).filter(|_| steady) {
                let pair = pair.map(|w| w.cast::<f64>());
                let error = excess(&stack, b, a.map(f64::from), pair);
                assert!(error <= 2.0 * BATCH_ULP, "{rule} {pair:?}: {a:?} with, {b:?} without\n{stack:?}");
            }
        }
    }
    for rule in Rule::ALL {
        assert!(seen.get(&rule).is_some_and(|times| *times > 20), "{rule} was hardly ever applied: {seen:?}");
    }
}

/// Pairs over the hemisphere and below it.
fn any_pairs(count: usize) -> Vec<[Vector<f32>; 2]> {
    let mut random = Random(11);
    let down = |mut pair: [Vector<f64>; 2], i: usize| {
        if i % 17 == 3 {
            pair[i % 2].z *= -1.0;
        }
        pair.map(|w| w.cast())
    };
    (0..count).map(|i| down(random.pair(), i)).collect()
}

#[test]
fn a_viewer_is_a_batch_of_one_viewer() {
    for plan in built_in_plans() {
        for level in Level::available() {
            let mut pairs = any_pairs(300);
            let viewer = pairs[5][1];
            pairs.iter_mut().for_each(|pair| pair[1] = viewer);
            let columns = columns(&pairs);
            let [a, b, c, ..] = columns.each_ref().map(Vec::as_slice);
            let mut f = [(); 3].map(|()| vec![f32::NAN; pairs.len()]);
            let slots = f.each_mut().map(Vec::as_mut_slice);
            plan.evaluate_view_at(level, [a, b, c], viewer, slots).expect("of one length");
            let view: Vec<[f32; 3]> = (0..pairs.len()).map(|i| [f[0][i], f[1][i], f[2][i]]).collect();
            assert_eq!(bits(&view), bits(&batch(&plan, level, &pairs)), "{} {plan:?}", level.name());
        }
    }
}

#[cfg(feature = "rayon")]
#[test]
fn threads_change_nothing() {
    let pairs = any_pairs(3 * brdf::batch::GRAIN + 77);
    let columns = columns(&pairs);
    let [a, b, c, d, e, g] = columns.each_ref().map(Vec::as_slice);
    for plan in built_in_plans() {
        let mut f = [(); 3].map(|()| vec![f32::NAN; pairs.len()]);
        plan.par_evaluate_batch([a, b, c], [d, e, g], f.each_mut().map(Vec::as_mut_slice)).expect("of one length");
        let all: Vec<[f32; 3]> = (0..pairs.len()).map(|i| [f[0][i], f[1][i], f[2][i]]).collect();
        assert_eq!(bits(&all), bits(&batch(&plan, Level::detect(), &pairs)), "{plan:?}");
    }
}

#[test]
fn every_length_has_its_remainder() {
    let pairs = any_pairs(600);
    for plan in built_in_plans() {
        for level in Level::available() {
            let whole = bits(&batch(&plan, level, &pairs));
            for count in (0..=600).step_by(7) {
                assert_eq!(bits(&batch(&plan, level, &pairs[..count])), whole[..count], "{} {count}", level.name());
            }
        }
    }
}

#[test]
fn results_do_not_depend_on_where_slices_start() {
    const COUNT: usize = 7_001;
    let pairs = any_pairs(COUNT);
    let columns = columns(&pairs);
    let [a, b, c, d, e, g] = columns.each_ref().map(Vec::as_slice);
    for plan in built_in_plans() {
        for level in Level::available() {
            let want: Vec<[f32; 3]> = pairs.chunks(130).flat_map(|pairs| batch(&plan, level, pairs)).collect();
            for offsets in [[0, 0, 0], [3, 3, 3], [0, 1, 2]] {
                let mut f = offsets.map(|offset| vec![f32::NAN; offset + COUNT + 1]);
                let [x, y, z] = f.each_mut().map(Vec::as_mut_slice);
                let rooms =
                    [&mut x[offsets[0]..][..COUNT], &mut y[offsets[1]..][..COUNT], &mut z[offsets[2]..][..COUNT]];
                plan.evaluate_batch_at(level, [a, b, c], [d, e, g], rooms).expect("of one length");
                for ((f, offset), channel) in f.iter().zip(offsets).zip(0..) {
                    assert!(f[offset + COUNT].is_nan(), "{} {offsets:?}: past the end", level.name());
                    for (i, (f, want)) in f[offset..].iter().zip(&want).enumerate() {
                        let same = f.to_bits() == want[channel].to_bits();
                        assert!(same, "{} {offsets:?} {i}: {f} {want:?}", level.name());
                    }
                }
            }
        }
    }
}

#[test]
fn a_slice_of_another_length_is_named_and_nothing_is_written() {
    let plan = built_in_plans().next().expect("a plan");
    for slice in 0..9 {
        let length = |i: usize| if i == slice { 5 } else { 4 };
        // Of the first slice the length is what is expected.
        let error = if slice == 0 {
            LengthError { expected: 5, found: 4, slice: 1 }
        } else {
            LengthError { expected: 4, found: 5, slice }
        };
        let inputs: Vec<Vec<f32>> = (0..6).map(|i| vec![0.5; length(i)]).collect();
        let mut f = [6, 7, 8].map(|i| vec![-1.0f32; length(i)]);
        let [a, b, c, d, e, g] = [0, 1, 2, 3, 4, 5].map(|i| inputs[i].as_slice());
        let slots = f.each_mut().map(Vec::as_mut_slice);
        assert_eq!(plan.evaluate_batch([a, b, c], [d, e, g], slots), Err(error));
        assert!(f.iter().flatten().all(|f| *f == -1.0));
    }
    let (short, long) = ([0.5f32; 3], [0.5f32; 4]);
    let (mut x, mut y, mut z) = ([0.0; 4], [0.0; 4], [0.0; 3]);
    let viewer = Vector::new(0.0, 0.0, 1.0);
    let found = plan.evaluate_view([&long, &short, &long], viewer, [&mut x, &mut y, &mut z]);
    assert_eq!(found, Err(LengthError { expected: 4, found: 3, slice: 1 }));
    let found = plan.evaluate_view([&long, &long, &long], viewer, [&mut x, &mut y, &mut z]);
    assert_eq!(found, Err(LengthError { expected: 4, found: 3, slice: 5 }));
}

#[test]
fn wild_directions_are_dark_or_finite() {
    let wild = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        1e-7,
        1e-19,
        1e-30,
        1e-40,
        f32::MIN_POSITIVE,
        1e10,
        f32::MAX,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
    ];
    let mut random = Random(5);
    let mut one = || wild[(wild.len() as f64 * random.unit()) as usize];
    let pairs: Vec<[Vector<f32>; 2]> =
        (0..4000).map(|_| [Vector::new(one(), one(), one()), Vector::new(one(), one(), one())]).collect();
    // Of components in [−1, 1] there is a number, whatever the length, and 0 below the horizon; of others, NaN among them, no panic.
    let tame = |w: &Vector<f32>| [w.x, w.y, w.z].iter().all(|x| x.abs() <= 1.0);
    for plan in built_in_plans() {
        for level in Level::available() {
            for (f, pair) in batch(&plan, level, &pairs).into_iter().zip(&pairs) {
                let lit = pair.iter().all(|w| w.z > 1e-18);
                let scalar: [f32; 3] = plan.evaluate(pair[0], pair[1]);
                for f in [f, scalar] {
                    if pair.iter().all(tame) {
                        assert!(f.iter().all(|f| *f >= 0.0), "{} {pair:?}: {f:?}\n{plan:?}", level.name());
                    }
                    if !lit && pair.iter().all(tame) {
                        assert!(f.iter().all(|f| *f == 0.0), "{} {pair:?}: {f:?}\n{plan:?}", level.name());
                    }
                }
            }
        }
    }
}
