//! Specialised WGSL: what is in it, what it means, and that adapters compute by it what the general kernel computes.
#![cfg(feature = "gpu")]

mod adapters;
mod stacks;

use adapters::adapters_for_tests;
use brdf::Vector;
use brdf::gpu::{Kernel, StackBuffers};
use brdf::interval::WgslInterval;
use brdf::layered::{Interface, Layer, Model, Stack};
use brdf::material::{metal, stack::built_in};
use brdf::parity::{Draw, allowed as allowed_by_text, map_twin, stack_arguments, stack_twin};
use brdf::plan::{Plan, Rule};
use brdf::shader::interp::{Buffers, Cell, Known, Number, Program, Shader};
use brdf::shader::{Module, specialise, specialise_scene};
use brdf::wgsl;
use stacks::{Random, allowed};

/// The module of a stack's plan, linked.
fn special(stack: &Stack<f64, 3>) -> String {
    linked(&Plan::new(stack).expect("a closed form"))
}

fn linked(plan: &Plan<3>) -> String {
    let text = specialise(plan, "special");
    wgsl::link(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn single(interface: Interface<f64, 3>) -> Vec<Layer<f64, 3>> {
    vec![Layer::new(interface)]
}

fn copper(alpha: f64) -> Interface<f64, 3> {
    let copper = metal::by_name("copper").expect("a built-in metal");
    Interface::conductor(copper.n, copper.k, alpha)
}

/// Stacks at which every rule and every form of a Fresnel term is at work, each with its name.
fn stacks_of_every_kind() -> Vec<(String, Vec<Layer<f64, 3>>)> {
    let coat = |n: f64, alpha: f64| Layer::new(Interface::dielectric(n, alpha));
    let tinted = |layer: Layer<f64, 3>| layer.over([0.2, 0.5, 1.5], 0.4);
    let base = |interface| Layer::new(interface);
    let diffuse = |sigma| Interface::diffuse([0.7, 0.4, 0.1], sigma);
    let prism = Interface::Microfacet { n: [1.5, 1.52, 1.54], k: [0.0; 3], alpha: 0.1 };
    let oxide = Interface::conductor([2.83, 3.10, 3.06], [0.083, 0.19, 0.6], 0.1);
    let all = vec![
        ("metal", single(copper(0.3))),
        ("grey metal", single(Interface::conductor([1.5; 3], [4.0; 3], 0.2))),
        ("conductor", single(Interface::conductor([3.0, 2.5, 4.0], [1.0, 0.5, 0.3], 0.2))),
        ("weak conductor", single(Interface::conductor([1.3, 1.1, 1.2], [0.05, 0.02, 0.0], 0.2))),
        ("bare glass", single(Interface::dielectric(1.5, 0.2))),
        ("bubble", single(Interface::dielectric(0.7, 0.2))),
        ("clear coat", vec![coat(1.5, 0.1), base(copper(0.3))]),
        ("tinted coat", vec![tinted(coat(1.5, 0.1)), base(copper(0.3))]),
        ("grey coat", vec![coat(1.5, 0.1).over([0.5; 3], 0.4), base(copper(0.3))]),
        ("matched coat", vec![tinted(coat(1.0, 0.1)), tinted(coat(1.0, 0.1)), base(copper(0.3))]),
        ("thin coat", vec![coat(0.8, 0.2), base(diffuse(0.0))]),
        ("thin film", vec![tinted(coat(1.8, 0.2)), tinted(coat(1.2, 0.05)), base(diffuse(0.3))]),
        ("opaque", vec![coat(1.5, 0.1).over([100.0; 3], 1.0), base(copper(0.3))]),
        ("black", vec![coat(1.5, 0.1), base(Interface::diffuse([0.0; 3], 0.3))]),
        ("lambert", vec![tinted(coat(1.5, 0.1)), base(diffuse(0.0))]),
        ("rough base", vec![tinted(coat(1.5, 0.3)), base(diffuse(0.5))]),
        ("bare rough base", vec![base(diffuse(0.5))]),
        ("bare black", vec![base(Interface::diffuse([0.0; 3], 0.0))]),
        ("oxide", vec![tinted(base(oxide)), base(copper(0.3))]),
        ("prism", vec![tinted(base(prism)), base(diffuse(0.4))]),
        ("prism over copper", vec![base(prism), base(copper(0.2))]),
    ];
    let mut all: Vec<_> = all.into_iter().map(|(name, layers)| (name.to_owned(), layers)).collect();
    all.extend(built_in().into_iter().map(|m| (m.name.to_owned(), m.stack.layers().to_vec())));
    all
}

fn every_stack() -> impl Iterator<Item = (String, Stack<f64, 3>)> {
    stacks_of_every_kind().into_iter().flat_map(|(name, layers)| {
        Model::CLOSED_FORM.into_iter().map(move |model| {
            let stack = Stack::new(model, layers.clone()).expect("within the ranges");
            (format!("{name}, {}", model.name()), stack)
        })
    })
}

/// Runs a linked module's function over pairs of directions.
fn run<N: Number>(
    source: &str,
    function: &str,
    known: &[(&str, &str, Known)],
    first: &[Cell<N>],
    pairs: &[[Vector<f64>; 2]],
    number: impl Fn(f64) -> N,
) -> Vec<[N; 3]> {
    let shader = Shader::in_double(source).unwrap_or_else(|error| panic!("{}\n{source}", error.report()));
    let known: Vec<_> = known.iter().map(|(module, name, known)| (wgsl::mangled(module, name), *known)).collect();
    let program = Program::<N>::with_known(&shader, function, &known).expect("a program");
    let numbers = |[wi, wo]: &[Vector<f64>; 2]| [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z].map(|x| Cell::Real(number(x)));
    let cells: Vec<_> = pairs.iter().flat_map(|pair| first.iter().cloned().chain(numbers(pair))).collect();
    let results = program.run(&cells, &mut Buffers::new()).expect("results");
    let real = |cell: &Cell<N>| match cell {
        Cell::Real(value) => *value,
        Cell::Word(_) => panic!("f is no word"),
        Cell::Open => N::anything(),
    };
    results.chunks_exact(3).map(|f| [real(&f[0]), real(&f[1]), real(&f[2])]).collect()
}

/// The text in f64, with what belongs to the precision taken from f64.
fn in_double(source: &str, function: &str, first: &[Cell<f64>], pairs: &[[Vector<f64>; 2]]) -> Vec<[f64; 3]> {
    let source = source.replace("exp_limit: f32 = 87.0", "exp_limit: f32 = 708.0");
    run(&source, function, &[("real", "angle", Known::Angle)], first, pairs, |x| x)
}

/// What WGSL allows the text.
fn intervals(source: &str, pairs: &[[Vector<f64>; 2]]) -> Vec<[WgslInterval; 3]> {
    let known = [("real", "sum_exact", Known::SumExact), ("real", "product_exact", Known::ProductExact)];
    run(source, "special", &known, &[], pairs, |x| WgslInterval::exactly(x as f32))
}

fn assert_means(name: &str, stack: &Stack<f64, 3>, source: &str, pairs: &[[Vector<f64>; 2]]) {
    let plan = Plan::new(stack).expect("a closed form");
    for (pair, got) in pairs.iter().zip(in_double(source, "special", &[], pairs)) {
        let want: [f64; 3] = plan.evaluate(pair[0], pair[1]);
        for ((want, got), bound) in want.into_iter().zip(got).zip(allowed(stack, *pair)) {
            assert!(
                (got - want).abs() <= bound,
                "{name} at {pair:?}: {got:e}, but the plan's f is {want:e}, {bound:e} allowed\n{source}\n{plan:?}"
            );
        }
    }
}

#[test]
fn modules_mean_what_their_plans_mean() {
    let mut random = Random(7);
    for (name, stack) in every_stack() {
        let pairs: Vec<_> = (0..150).map(|_| random.pair()).collect();
        assert_means(&name, &stack, &special(&stack), &pairs);
    }
    let mut seen = std::collections::HashMap::<Rule, usize>::new();
    for round in 0..600 {
        let stack = random.stack(Model::CLOSED_FORM[round % 3]);
        for applied in Plan::new(&stack).expect("a closed form").applied() {
            *seen.entry(applied.rule).or_default() += 1;
        }
        let pairs: Vec<_> = (0..12).map(|_| random.pair()).collect();
        assert_means(&format!("stack {round}"), &stack, &special(&stack), &pairs);
    }
    assert!(Rule::ALL.iter().all(|rule| seen.contains_key(rule)), "{seen:?}");
}

#[test]
fn fits_are_emitted_as_fits() {
    let mut random = Random(3);
    let pairs: Vec<_> = (0..200).map(|_| random.pair()).collect();
    for (name, stack) in every_stack() {
        for error in [1e-2, 1e-4, 1e-6] {
            let plan = Plan::with_error(&stack, error).expect("a closed form");
            let source = linked(&plan);
            Module::parse(&source).unwrap_or_else(|error| panic!("{name}: {}", error.report()));
            if name.starts_with("metal") && error == 1e-2 {
                assert!(source.contains("plan_stretched") && !source.contains("plan_metal"), "{source}");
            }
            // A fit is not more than its condition away from itself; two plans' difference is not judged here.
            for (pair, got) in pairs.iter().zip(in_double(&source, "special", &[], &pairs)) {
                let want: [f64; 3] = plan.evaluate(pair[0], pair[1]);
                for ((want, got), bound) in want.into_iter().zip(got).zip(allowed(&stack, *pair)) {
                    assert!(
                        (got - want).abs() <= 2.0 * bound + 1e-12 * want,
                        "{name} at {pair:?}: {got:e}, not {want:e}"
                    );
                }
            }
        }
    }
}

/// Broken texts are found by the comparison above: a digit or a sign at a time.
#[test]
fn a_broken_module_means_something_else() {
    let faults = [
        ("metal", "(mean_s - cross)", "(mean_s - 1.000001 * cross)"),
        ("metal", "max(min(cos_i, cos_o), edge)", "min(min(cos_i, cos_o), edge)"),
        ("clear coat", "(p + both * s)", "(p - both * s)"),
        ("tinted coat", "exp(-select(vec3f", "exp(-0.99999 * select(vec3f"),
        ("conductor", "real < vec3f(0.0)", "real > vec3f(0.0)"),
        ("rough base", "albedo * base.interreflection", "base.interreflection"),
        ("thin coat", "> 0.0;", "> 0.5;"),
    ];
    let mut random = Random(5);
    let pairs: Vec<_> = (0..150).map(|_| random.pair()).collect();
    for (wanted, right, wrong) in faults {
        let (_, layers) = stacks_of_every_kind().into_iter().find(|(name, _)| name == wanted).expect("a stack");
        let stack = Stack::new(Model::Conserving, layers).expect("within the ranges");
        let source = special(&stack);
        assert!(source.contains(right), "{wanted} has `{right}`:\n{source}");
        let broken = source.replacen(right, wrong, 1);
        let found = std::panic::catch_unwind(|| assert_means(wanted, &stack, &broken, &pairs));
        assert!(found.is_err(), "{wanted} with `{wrong}` passes");
    }
}

#[test]
fn modules_hold_only_what_they_need() {
    let without = |wanted: &str, absent: &[&str]| {
        let (name, layers) = stacks_of_every_kind().into_iter().find(|(name, _)| name == wanted).expect("a stack");
        let source = special(&Stack::new(Model::Conserving, layers).expect("within the ranges"));
        for word in absent {
            assert!(!source.contains(word), "{name} has `{word}`:\n{source}");
        }
    };
    let below = ["refract", "absorb", "diffuse", "transmitted", "stack_layer"];
    without("metal", &[&below[..], &["dielectric", "_conductor"]].concat());
    without("bare glass", &[&below[..], &["metal", "_conductor"]].concat());
    without("clear coat", &["absorb", "diffuse", "_conductor", "goes_on"]);
    without("lambert", &["oren_nayar", "metal", "_conductor"]);
    without("opaque", &["metal", "absorb", "transmitted"]);
    without("matched coat", &["transmitted", "dielectric", "m1_"]);
    for (name, stack) in every_stack() {
        let source = special(&stack);
        assert!(!source.contains("for (") && !source.contains("loop") && !source.contains("var<"), "{name}: {source}");
        assert!(
            !source.contains(" pow(") && !source.contains(" sin(") && !source.contains(" cos("),
            "{name}: {source}"
        );
        let module = Module::parse(&source).unwrap_or_else(|error| panic!("{name}: {}\n{source}", error.report()));
        // Every function is called, or is the stack's.
        for function in module.functions() {
            let calls = source.matches(&format!("{function}(")).count();
            assert!(calls > 1 || function == "special", "{name}: {function} is not called\n{source}");
        }
    }
}

#[test]
fn a_scene_selects_its_stacks_and_shares_functions() {
    let stacks: Vec<_> = every_stack().map(|(name, stack)| (wgsl::identifier(&name), stack)).collect();
    let plans: Vec<_> =
        stacks.iter().map(|(name, stack)| (name.as_str(), Plan::new(stack).expect("a closed form"))).collect();
    let source = wgsl::link(&specialise_scene(&plans)).expect("a scene that links");
    let module = Module::parse(&source).unwrap_or_else(|error| panic!("{}\n{source}", error.report()));
    let names: Vec<_> = module.functions().collect();
    assert_eq!(names.iter().filter(|name| name.starts_with("plan_lobe")).count(), 1);
    let mut random = Random(11);
    let pairs: Vec<_> = (0..20).map(|_| random.pair()).collect();
    for (index, (name, stack)) in stacks.iter().enumerate() {
        let got = in_double(&source, "scene", &[Cell::Word(index as u32)], &pairs);
        let alone = in_double(&special(stack), "special", &[], &pairs);
        assert_eq!(got, alone, "{name}");
    }
    let none = in_double(&source, "scene", &[Cell::Word(stacks.len() as u32)], &pairs);
    assert!(none.iter().flatten().all(|f| *f == 0.0));
}

#[test]
fn modules_are_smaller_than_the_general_kernel() {
    for (name, stack) in every_stack() {
        let general = wgsl::link_function("layered", stack.model().name()).expect("a twin");
        let general = format!("{general}\n{}", StackBuffers::default().bindings(&general));
        let [general, special] =
            [general, special(&stack)].map(|source| Module::parse(&source).expect("valid").counts().expect("SPIR-V"));
        println!(
            "{name:40} IR {:4} of {:4}, SPIR-V {:4} of {:4} instructions, {:5} of {:5} words",
            special.expressions + special.statements,
            general.expressions + general.statements,
            special.instructions,
            general.instructions,
            special.words,
            general.words
        );
        if !name.contains("prism") && !name.contains("oxide") {
            assert!(special.instructions < general.instructions && special.words < general.words, "{name}");
        }
        if name.starts_with("metal,") {
            assert!(4 * special.instructions < general.instructions, "{special:?} {general:?}");
        }
    }
}

/// Special and general on every adapter: each lies in what WGSL allows its own text, and both hold the same value.
#[test]
fn adapters_agree_with_the_general_kernel() {
    const SAMPLES: u64 = 600;
    for gpu in adapters_for_tests() {
        let mut largest = (0.0f64, String::new());
        for (name, stack) in every_stack() {
            let alpha = |layer: &Layer<f64, 3>| match layer.interface {
                Interface::Microfacet { alpha, .. } => alpha,
                Interface::Diffuse { .. } => 1.0,
            };
            let narrowest = stack.layers().iter().map(alpha).fold(1.0, f64::min);
            let single = |w: Vector<f64>| w.cast::<f32>().cast::<f64>();
            let pairs: Vec<_> = (0..SAMPLES).map(|index| Draw::new(index).pair(narrowest).map(single)).collect();
            let source = special(&stack);
            let rows: Vec<f32> = pairs.iter().flatten().flat_map(|w| [w.x as f32, w.y as f32, w.z as f32]).collect();
            let kernel = Kernel::new(&gpu, &source, "special", None).expect("a kernel");
            let got = kernel.run_f32(&rows, &[]).expect("results");
            let bounds = intervals(&source, &pairs);

            let twin = stack_twin(stack.model()).expect("a twin");
            let mut buffers = StackBuffers::default();
            let place = stack_arguments(&stack.cast::<f32>(), &mut buffers);
            let rows: Vec<Vec<f32>> = rows.chunks_exact(6).map(|pair| [&place[..], pair].concat()).collect();
            let general = map_twin(&gpu, &twin, &rows, &buffers).expect("results").values;
            let text = wgsl::link_function(twin.module, twin.function).expect("a twin");
            let general_bounds = allowed_by_text(&twin, &text, &rows, &buffers).expect("intervals");

            let mut open = 0;
            for (index, pair) in pairs.iter().enumerate() {
                for channel in 0..3 {
                    let special = f64::from(got[3 * index + channel]);
                    let general = f64::from(general[3 * index + channel]);
                    let (own, other): (WgslInterval, WgslInterval) =
                        (bounds[index][channel], general_bounds[index][channel]);
                    assert!(special.is_finite(), "{name} at {pair:?} on {}", gpu.info());
                    if !own.is_bounded() {
                        open += 1;
                        continue;
                    }
                    // Numbers that an adapter may flush count as 0.
                    let tiny = f64::from(f32::MIN_POSITIVE);
                    assert!(
                        own.low() - tiny <= special && special <= own.high() + tiny,
                        "{name} at {pair:?} on {}: {special:e} is not in {own:?}\n{source}",
                        gpu.info()
                    );
                    // The rules may be silent about the general text where it divides after an open comparison.
                    if !other.is_bounded() {
                        continue;
                    }
                    let room = (own.high() - own.low()) + (other.high() - other.low()) + tiny;
                    assert!(
                        (special - general).abs() <= room,
                        "{name} at {pair:?} on {}: {special:e}, generally {general:e}: {room:e} allowed",
                        gpu.info()
                    );
                    if general > 1e-8 {
                        let ulp = general * f64::from(f32::EPSILON) * 0.5;
                        let error = (special - general).abs() / ulp;
                        if error > largest.0 {
                            largest = (error, format!("{name} at {pair:?}: {special:e}, generally {general:e}"));
                        }
                    }
                }
            }
            assert!(open as f64 <= 0.02 * (3 * SAMPLES) as f64, "{name}: {open} unbounded");
        }
        println!("{}: at most {:.1} ULP apart: {}", gpu.info(), largest.0, largest.1);
    }
}
