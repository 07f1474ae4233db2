//! Inputs that once gave a wrong answer, or none.

use brdf::interval::WgslInterval;
use brdf::shader::interp::{Buffers, Cell, InterpError, Program, Shader};

type Wide = Cell<WgslInterval>;

fn intervals(source: &str, budget: u64, arguments: &[f32]) -> Result<Vec<Wide>, InterpError> {
    let shader = Shader::in_double(source).unwrap_or_else(|error| panic!("{error}\n{source}"));
    let program = Program::new(&shader, "f").unwrap_or_else(|error| panic!("{error}\n{source}"));
    let cells: Vec<Wide> = arguments.iter().map(|x| Cell::Real(WgslInterval::exactly(*x))).collect();
    program.with_budget(budget).run(&cells, &mut Buffers::new())
}

fn bounds(source: &str, arguments: &[f32]) -> Vec<(f64, f64)> {
    let cells = intervals(source, 100_000, arguments).unwrap_or_else(|error| panic!("{error}\n{source}"));
    let bounds = |cell: &Wide| match cell {
        Cell::Real(x) => (x.low(), x.high()),
        other => panic!("{other:?}"),
    };
    cells.iter().map(bounds).collect()
}

fn words(source: &str, arguments: &[u32], buffers: &mut Buffers) -> Result<Vec<Cell<f32>>, InterpError> {
    let shader = Shader::parse(source).unwrap_or_else(|error| panic!("{error}\n{source}"));
    let cells: Vec<_> = arguments.iter().map(|word| Cell::Word(*word)).collect();
    Program::new(&shader, "f")?.run(&cells, buffers)
}

#[test]
fn an_open_constant_stays_open_in_every_row() {
    let open = "override K: f32 = 0.7; override B: bool = K * 1.3 / 1.3 < K;\n";
    let branch = format!("{open}fn f(x: f32) -> f32 {{ if B {{ return 1.0; }} return x; }}");
    assert_eq!(bounds(&branch, &[5.0, 6.0, 7.0]), [(1.0, 5.0), (1.0, 6.0), (1.0, 7.0)]);
    let select = format!("{open}fn f(x: f32) -> u32 {{ return select(5u, 6u, B); }}");
    assert_eq!(intervals(&select, 1000, &[0.5, 0.6]), Ok(vec![Cell::Open, Cell::Open]));
}

#[test]
fn one_binding_may_have_two_variables() {
    let two = "@group(0) @binding(0) var<storage, read_write> a: array<vec2f>;
        @group(0) @binding(0) var<storage, read_write> b: array<u32>;
        @compute @workgroup_size(1) fn one() { a[0].x = 1.5; }
        @compute @workgroup_size(1) fn two() { b[1] = 7u; b[3] = 9u; }
        fn f(n: u32) -> u32 { a[0].x = 1.0; b[1] = n; return n; }";
    let shader = Shader::parse(two).unwrap();
    let mut buffers = Buffers::new().with(0, 0, vec![0; 16]);
    Program::<f32>::entry_point(&shader, "two").unwrap().dispatch([1, 1, 1], &mut buffers).unwrap();
    assert_eq!(buffers.get(0, 0), Some(&[0u32, 7, 0, 9].map(u32::to_le_bytes).concat()[..]));
    Program::<f32>::entry_point(&shader, "one").unwrap().dispatch([1, 1, 1], &mut buffers).unwrap();
    assert_eq!(buffers.get(0, 0), Some(&[1.5f32.to_bits(), 7, 0, 9].map(u32::to_le_bytes).concat()[..]));
    let both = Program::<f32>::new(&shader, "f").unwrap_err().to_string();
    assert!(both.contains("`a` and `b`, of different types at one binding"), "{both}");

    let shared = "@group(0) @binding(0) var<storage, read_write> a: array<u32>;
        @group(0) @binding(0) var<storage, read_write> b: array<u32>;
        fn f(n: u32) -> u32 { a[0] = n; b[1] = a[0] + 1u; return b[0] * 10u + a[1]; }";
    let mut buffers = Buffers::new().with(0, 0, vec![0; 8]);
    assert_eq!(words(shared, &[4], &mut buffers), Ok(vec![Cell::Word(45)]));
    assert_eq!(buffers.get(0, 0), Some(&[4u32, 5].map(u32::to_le_bytes).concat()[..]));
}

#[test]
fn numbers_of_a_buffer_keep_their_sign() {
    let source = "struct S { count: u32, values: array<i32> }
        @group(0) @binding(0) var<storage> s: S; fn f(i: u32) -> i32 { return s.values[i]; }";
    let mut buffers = Buffers::new().with_numbers(0, 0, vec![3e9, -1.0, 5.0, -2.5]);
    let want = [-1, 5, -2].map(|value: i32| Cell::Word(value.cast_unsigned()));
    assert_eq!(words(source, &[0, 1, 2], &mut buffers), Ok(want.to_vec()));
}

#[test]
fn a_function_of_nothing_runs_once() {
    assert_eq!(words("fn f() -> u32 { return 3u; }", &[], &mut Buffers::new()), Ok(vec![Cell::Word(3)]));
    assert!(words("fn f() -> u32 { return 3u; }", &[1], &mut Buffers::new()).is_err());
    assert_eq!(words("fn f(n: u32) -> u32 { return n; }", &[], &mut Buffers::new()), Ok(vec![]));
}

#[test]
fn branches_cost_steps() {
    // No instruction in any of them.
    let branches = "if b { } else { } ".repeat(100);
    let switches = "switch n { case 1u { } case 2u { } default { } } ".repeat(100);
    for body in [branches, switches] {
        let shader = Shader::parse(&format!("fn f(b: bool, n: u32) -> u32 {{ {body} return n; }}")).unwrap();
        let program = Program::<f32>::new(&shader, "f").unwrap();
        let cells = [Cell::Word(1), Cell::Word(2)];
        let few = program.clone().with_budget(50).run(&cells, &mut Buffers::new());
        assert_eq!(few, Err(InterpError::Budget(50)), "{body}");
        assert_eq!(program.with_budget(1000).run(&cells, &mut Buffers::new()), Ok(vec![Cell::Word(2)]));
    }
}

#[test]
fn a_row_without_end_is_unbounded_and_others_are_not() {
    for turn in ["", "n = n * 0.5 + x;"] {
        for budget in 9_990..10_000 {
            let source = format!("fn f(x: f32) -> f32 {{ var n = 0.0; while x > 1.0 {{ {turn} }} return x; }}");
            let cells = intervals(&source, budget, &[0.5, 2.0]).unwrap();
            let Cell::Real(endless) = cells[1] else { panic!("{cells:?}") };
            assert!(!endless.is_bounded(), "{cells:?}");
        }
    }
    // What ended before the steps did keeps its result.
    let source = "fn f(x: f32) -> f32 { if x < 1.0 { return x; } loop { } return x; }";
    {
        let shader = Shader::in_double(source).unwrap();
        let program = Program::<WgslInterval>::new(&shader, "f").unwrap().with_budget(1000);
        let cells = [0.5, 2.0].map(|x| Cell::Real(WgslInterval::exactly(x)));
        let results = program.run(&cells, &mut Buffers::new()).unwrap();
        assert_eq!(results[0], Cell::Real(WgslInterval::exactly(0.5)));
    }
    // Memory that a lane without end writes is not known.
    let source = "@group(0) @binding(0) var<storage, read_write> a: array<f32>;
        fn f(x: f32) -> f32 { while x > 1.0 { a[0] += x; } return x; }";
    let shader = Shader::in_double(source).unwrap();
    let program = Program::<WgslInterval>::new(&shader, "f").unwrap().with_budget(1000);
    let result = program.run(&[Cell::Real(WgslInterval::exactly(2.0))], &mut Buffers::new().with(0, 0, vec![0; 4]));
    assert_eq!(result, Err(InterpError::Budget(1000)));
}

#[test]
fn any_word_but_0_is_true() {
    let shader = Shader::in_double("fn f(b: bool) -> f32 { if b { return 1.0; } return 2.0; }").unwrap();
    let program = Program::<WgslInterval>::new(&shader, "f").unwrap();
    let cells = [0, 1, 2, u32::MAX].map(Cell::Word);
    let results = program.run(&cells, &mut Buffers::new()).unwrap();
    assert_eq!(results, [2.0, 1.0, 1.0, 1.0].map(|x| Cell::Real(WgslInterval::exactly(x))));
    assert_eq!(words("fn f(b: bool) -> bool { return b; }", &[2], &mut Buffers::new()), Ok(vec![Cell::Word(1)]));
}

#[test]
fn a_subnormal_number_may_count_as_0() {
    let tiny = 1e-40f32;
    let times = |source: &str| bounds(source, &[tiny])[0];
    for source in [
        "fn f(x: f32) -> f32 { return x * 1e38; }",
        "fn f(x: f32) -> f32 { return sign(x); }",
        "fn f(x: f32) -> f32 { if x > 0.0 { return 1.0; } return 0.0; }",
        "fn f(x: f32) -> f32 { return 1e-40 * 1e38 * (x - x + 1.0); }",
        "fn f(x: f32) -> f32 { return bitcast<f32>(71362u) * 1e38; }",
    ] {
        let (low, high) = times(source);
        assert!(low <= 0.0 && high > 0.009, "{source}: {low} {high}");
    }
    let source = "@group(0) @binding(0) var<storage> a: array<f32>; fn f(n: u32) -> f32 { return a[n] * 1e38; }";
    let shader = Shader::in_double(source).unwrap();
    let program = Program::<WgslInterval>::new(&shader, "f").unwrap();
    let bytes = Buffers::new().with(0, 0, (-tiny).to_le_bytes().to_vec());
    let numbers = Buffers::new().with_numbers(0, 0, vec![f64::from(-tiny)]);
    for mut buffers in [bytes, numbers] {
        let Cell::Real(result) = program.run(&[Cell::Word(0)], &mut buffers).unwrap()[0] else { panic!() };
        assert!(result.low() < -0.009 && result.high() == 0.0, "{result:?}");
    }
}

#[test]
fn values_that_are_listed_again_and_again_are_refused() {
    let lines = "r += array<f32, 65536>()[i];\n".repeat(4000);
    let source = format!("fn f(x: f32) -> f32 {{ var r = x; let i = u32(x);\n{lines} return r; }}");
    let shader = Shader::parse(&source).unwrap();
    let error = Program::<f32>::new(&shader, "f").unwrap_err();
    assert!(matches!(&error, InterpError::TooLarge(what) if what.contains("scalars")), "{error}");
}

/// As deep as is let through, on the stack of a thread.
#[test]
fn deep_modules_are_refused_or_fit_the_stack() {
    let chains = |count: usize| {
        let branches = "else if x > 1.0 { } ".repeat(count);
        [
            format!("x{}", " + x".repeat(count)),
            format!("{}x", "-".repeat(count)),
            format!("{}x", "- ".repeat(count)),
            format!("{}true", "!".repeat(count)),
            format!("x{}", "[0]".repeat(count)),
            format!("x{}", ".x".repeat(count)),
            format!("{}x{}", "(".repeat(count), ")".repeat(count)),
            format!("{}x{}", "(x + ".repeat(count), ")".repeat(count)),
            format!("{}x{}", "abs(".repeat(count), ")".repeat(count)),
            format!("x{}", " && x".repeat(count)),
            format!("{}f32{}(0)", "array<".repeat(count), ", 1>".repeat(count)),
            format!("x; if x > 0.0 {{ }} {branches}"),
            format!("x; {}{}", "{".repeat(count), "}".repeat(count)),
        ]
    };
    let run = |count: usize| {
        for chain in chains(count) {
            let source = format!("fn f(x: f32) -> f32 {{ return {chain}; }}");
            let what = format!("{count} of {}", &chain[..chain.len().min(20)]);
            let thread = std::thread::Builder::new().stack_size(2 << 20).spawn(move || {
                let single = Shader::parse(&source).map(|shader| drop(Program::<f32>::new(&shader, "f")));
                (single.is_err(), Shader::in_double(&source).is_err())
            });
            let refused = thread.unwrap().join().unwrap_or_else(|_| panic!("{what}"));
            assert!(count < 5000 || refused == (true, true), "{what}");
        }
    };
    for count in [10, 100, 240, 400, 490, 5000, 20_000] {
        run(count);
    }
}

#[test]
fn constants_are_computed_in_double_precision() {
    for (source, want) in [
        ("const PI = 3.1875; const INV_PI = 1.0 / PI; fn f(x: f32) -> f32 { return x * INV_PI; }", 1.0 / 3.1875),
        ("const A: f32 = 3.1; const B: f32 = A * A; fn f(x: f32) -> f32 { return x * B; }", 3.1 * 3.1),
        ("const A: f32 = 2; const B: f32 = -A; fn f(x: f32) -> f32 { return x * B; }", -2.0),
        ("override K: f32 = 2.0 / 3.0; fn f(x: f32) -> f32 { return x * K; }", 2.0 / 3.0),
        ("override K: f32 = sqrt(2.0); fn f(x: f32) -> f32 { return x * K; }", 2f64.sqrt()),
        ("var<private> p: f32 = 1.0 / 3.0; fn f(x: f32) -> f32 { return x * p; }", 1.0 / 3.0),
        ("fn f(x: f32) -> f32 { const k = 4.0; const m = k / 3.0; return x * m; }", 4.0 / 3.0),
        ("fn f(x: f32) -> f32 { let a = sqrt(2.0); return x * a; }", 2f64.sqrt()),
        ("fn f(x: f32) -> f32 { return x * max(0.5, 0.25); }", 0.5),
        ("fn f(x: f32) -> f32 { return x * f32(i32(2.5)); }", 2.0),
        ("fn f(x: f32) -> f32 { return x * (vec3f(1, 2, 3) / 7).y; }", 2.0 / 7.0),
        ("const V = vec2f(0.1, 0.2) * 0.3; fn f(x: f32) -> f32 { return x * V.y; }", 0.2 * 0.3),
        ("const N = u32(2.5); fn f(x: f32) -> f32 { var a: array<f32, N>; a[1] = x; return a[1] * 0.1; }", 0.1),
        ("const C = 0.5; const D = C < 1.0; fn f(x: f32) -> f32 { return select(2.0, x, D); }", 1.0),
        (
            "const M = mat2x2f(1, 2, 3, 4); fn f(x: f32) -> f32 { return (M * vec2f(0.1, x)).x * (1.0 / 3.0); }",
            3.1 / 3.0,
        ),
        ("fn f(x: f32) -> f32 { return x * bitcast<f32>(1069547520) * (3.0 / 2.0); }", 2.25),
        ("fn f(x: f32) -> f32 { let real_0 = 1.0 / 3.0; return x * real_0; }", 1.0 / 3.0),
    ] {
        let shader = Shader::in_double(source).unwrap_or_else(|error| panic!("{error}\n{source}"));
        let program = Program::<f64>::new(&shader, "f").unwrap_or_else(|error| panic!("{error}\n{source}"));
        let results = program.run(&[Cell::Real(1.0)], &mut Buffers::new());
        let Ok([Cell::Real(result)]) = results.as_deref() else { panic!("{source}: {results:?}") };
        assert!((result - want).abs() < 1e-15, "{source}: {result} {want}");
        // Intervals hold it.
        let (low, high) = bounds(source, &[1.0])[0];
        assert!(low <= want && want <= high && high - low < 1e-5, "{source}: {low} {high}");
    }
}
