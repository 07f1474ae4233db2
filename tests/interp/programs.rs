//! Programs not written for the evaluator: control flow, pointers, memory, and expressions drawn at random.

use crate::adapters::adapters_for_tests;
use brdf::gpu::{Gpu, Kernel};
use brdf::interval::WgslInterval;
use brdf::shader::interp::{Buffers, Cell, Program, Shader};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

/// Functions of one word that no two lanes go through in the same way.
const PROGRAMS: &[&str] = &[
    // Nested loops with break and continue.
    "fn f(n: u32) -> u32 {
        var sum = 0u;
        for (var i = 0u; i < n % 17u; i++) {
            if i % 3u == 1u { continue; }
            for (var j = 0u; j < 100u; j++) {
                if j * i > n % 29u { break; }
                if j % 2u == 0u { continue; }
                sum += i * j;
            }
            if sum > 200u { break; }
            sum ^= i;
        }
        return sum;
    }",
    // A return from within.
    "fn f(n: u32) -> u32 {
        var x = n % 64u;
        loop {
            if x == 7u { return 1000u + x; }
            if x > 60u { break; }
            x = x * 2u + 1u;
            continuing { x += 1u; break if x > 40u; }
        }
        return x;
    }",
    // Switches: a default in the middle, several selectors, breaks, continue of the loop around.
    "fn f(n: u32) -> u32 {
        var r = 0u;
        for (var i = 0u; i < 9u; i++) {
            switch (n + i) % 7u {
                case 0u, 3u { r += 1u; }
                default { r += 10u; if r > 55u { break; } r += 2u; }
                case 1u { continue; }
                case 5u { if n % 2u == 0u { return r; } r += 100u; }
            }
            r = r * 3u % 1009u;
        }
        return r;
    }",
    // Pointers into an array, a struct and a vector, through two calls.
    "struct S { a: array<vec2u, 3>, b: u32 }
    fn bump(p: ptr<function, u32>, by: u32) -> u32 { let old = *p; *p = old * 2u + by; return old; }
    fn twice(p: ptr<function, S>, i: u32) {
        var b = (*p).b;
        (*p).b += bump(&b, i);
        (*p).a[i % 3u].y += b;
    }
    fn f(n: u32) -> u32 {
        var s: S;
        s.b = n % 13u;
        for (var i = 0u; i < n % 5u; i++) { twice(&s, i); }
        let copy = s;
        s.a[1u] = vec2u(7u, 9u);
        return copy.a[0].y + 3u * copy.a[1].y + 5u * copy.a[2].y + s.a[n % 3u].y * 11u + copy.b;
    }",
    // Collatz: lanes of very different lengths; private memory.
    "var<private> steps: u32;
    fn advance(x: u32) -> u32 { steps += 1u; return select(x / 2u, 3u * x + 1u, x % 2u == 1u); }
    fn f(n: u32) -> u32 {
        steps = 0u;
        var x = n % 1000u + 1u;
        while x != 1u { x = advance(x); }
        return steps;
    }",
    // Matrices of data, dynamic columns and components, short circuits with effects.
    "var<private> log: u32 = 1u;
    fn note(b: bool, k: u32) -> bool { log = log * 5u + k; return b; }
    fn f(n: u32) -> u32 {
        var m = mat3x2f(1.0, 2.0, 3.0, 4.0, 5.0, 6.0);
        m[n % 3u][n % 2u] += f32(n % 8u);
        let c = m[(n + 1u) % 3u];
        if note(n % 2u == 0u, 1u) && note(n % 3u == 0u, 2u) || note(n % 5u == 0u, 3u) { log += 7u; }
        return u32(c.x + 10.0 * m[n % 3u].y) * 1000u + log % 1000u;
    }",
    // Indices out of bounds stay within: clamped by hand, so that every device says the same.
    "const table = array<u32, 5>(3u, 1u, 4u, 1u, 5u);
    fn f(n: u32) -> u32 {
        var t = table;
        var sum = 0u;
        for (var i = 0u; i < 8u; i++) { let k = min(n % 11u + i, 4u); sum = sum * 7u + t[k]; t[k] += i; }
        return sum;
    }",
];

fn words() -> Vec<u32> {
    let mut word = 12345u32;
    (0..700)
        .map(|i| {
            word = word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            if i < 100 { i } else { word >> 8 }
        })
        .collect()
}

fn evaluated(source: &str, words: &[u32]) -> Vec<u32> {
    let shader = Shader::parse(source).unwrap_or_else(|error| panic!("{error}\n{source}"));
    let program = Program::<f32>::new(&shader, "f").unwrap_or_else(|error| panic!("{error}\n{source}"));
    let cells: Vec<_> = words.iter().map(|word| Cell::Word(*word)).collect();
    let results = program.run(&cells, &mut Buffers::new()).unwrap_or_else(|error| panic!("{error}\n{source}"));
    let word = |cell: Cell<f32>| if let Cell::Word(word) = cell { word } else { panic!("{cell:?}") };
    results.into_iter().map(word).collect()
}

#[test]
fn control_flow_is_that_of_every_adapter() {
    let (words, gpus) = (words(), adapters_for_tests());
    for source in PROGRAMS {
        let here = evaluated(source, &words);
        assert!(here.iter().any(|x| *x != here[0]), "{source}");
        // One lane at a time gives the same as many.
        for (word, want) in words.iter().zip(&here).step_by(61) {
            assert_eq!(evaluated(source, &[*word]), [*want], "{source}");
        }
        for gpu in &gpus {
            let there = Kernel::new(gpu, source, "f", None).and_then(|kernel| kernel.run(&words, &[]));
            assert_eq!(here, there.unwrap_or_else(|error| panic!("{error}\n{source}")), "{}\n{source}", gpu.info());
        }
    }
}

/// naga's SPIR-V does not take these: a pointer to a member, and to an element that is only known at run time.
#[test]
fn pointers_may_point_into_a_variable() {
    let source = "struct S { a: vec3f, c: array<u32, 3>, b: u32 }
        fn bump(p: ptr<function, u32>, by: u32) -> u32 { let old = *p; *p = old * 2u + by; return old; }
        fn twice(p: ptr<function, S>, i: u32) { (*p).b += bump(&(*p).b, i); bump(&(*p).c[i % 3u], 1u); }
        fn f(n: u32) -> u32 {
            var s: S;
            s.b = 3u;
            for (var i = 0u; i < n; i++) { twice(&s, i); }
            return s.c[0] + 10u * s.c[1] + 100u * s.c[2] + 1000u * s.b;
        }";
    // b: 3 → 3·2+0 = 6, then 6 + old 3: the sum is read after the call, so 6 + 3 or 3 + 3 by the order of loads.
    let results = evaluated(source, &[0, 1, 3]);
    assert_eq!(results[0], 3000);
    assert_eq!((results[1] % 1000, results[2] % 1000), (1, 111));
}

#[test]
fn indices_are_clamped() {
    let source =
        "fn f(n: u32) -> u32 { var t = array<u32, 3>(5u, 6u, 7u); t[n + 1u] = 9u; return t[n] * 100u + t[2]; }";
    assert_eq!(evaluated(source, &[0, 1, 2, 1000]), [507, 609, 909, 909]);
    let source = "fn f(n: u32) -> u32 { return array<u32, 3>(5u, 6u, 7u)[i32(n) - 1]; }";
    assert_eq!(evaluated(source, &[0, 1, 2, 9]), [7, 5, 6, 7]);
}

#[test]
fn entry_points_share_memory_within_a_workgroup() {
    // A prefix sum in workgroup memory, atomics over all workgroups, a runtime-sized array.
    let source = "
        struct Total { count: atomic<u32>, most: atomic<i32>, scale: vec3f, values: array<f32> }
        override size = 8u;
        @group(0) @binding(0) var<storage, read_write> total: Total;
        @group(0) @binding(1) var<uniform> offset: vec4u;
        var<workgroup> sums: array<u32, 8>;
        @compute @workgroup_size(size)
        fn main(@builtin(local_invocation_index) i: u32, @builtin(workgroup_id) group: vec3u,
                @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
            sums[i] = id.x + offset.y;
            workgroupBarrier();
            for (var step = 1u; step < 8u; step *= 2u) {
                var other = 0u;
                if i >= step { other = sums[i - step]; }
                workgroupBarrier();
                sums[i] += other;
                workgroupBarrier();
            }
            atomicAdd(&total.count, 1u);
            atomicMax(&total.most, i32(sums[i]));
            if id.x < arrayLength(&total.values) { total.values[id.x] = f32(sums[7]) * total.scale.y + f32(groups.x); }
        }";
    let shader = Shader::parse(source).unwrap();
    let program = Program::<f32>::entry_point(&shader, "main").unwrap();
    let total: Vec<u8> = [0, 0, 0, 0, 1f32.to_bits(), 0.5f32.to_bits(), 0].map(u32::to_le_bytes).concat();
    let total = [total, vec![0; 4 * 20]].concat();
    let offset = [0u32, 1, 0, 0].map(u32::to_le_bytes).concat();
    let mut buffers = Buffers::new().with(0, 0, total).with(0, 1, offset);
    program.dispatch([2, 1, 1], &mut buffers).unwrap();
    let bytes = buffers.get(0, 0).unwrap();
    let word = |index: usize| u32::from_le_bytes(bytes[4 * index..4 * index + 4].try_into().unwrap());
    // 1 + … + 8 and 9 + … + 16.
    assert_eq!((word(0), word(1)), (16, 100));
    assert_eq!((f32::from_bits(word(7)), f32::from_bits(word(7 + 15)), word(7 + 16)), (20.0, 52.0, 0));
}

/// An expression of a, b, c (integers, or reals) as text.
fn whole_expression() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        Just("a".to_owned()),
        Just("b".to_owned()),
        Just("c".to_owned()),
        (0u32..100).prop_map(|n| format!("{n}u"))
    ];
    leaf.prop_recursive(5, 40, 3, |inner| {
        prop_oneof![
            (inner.clone(), inner.clone(), prop::sample::select(vec!["+", "-", "*", "/", "%", "&", "|", "^"]))
                .prop_map(|(a, b, op)| format!("({a} {op} select({b}, 1u, {b} == 0u))")),
            (inner.clone(), inner.clone(), prop::sample::select(vec!["<<", ">>"]))
                .prop_map(|(a, b, op)| format!("({a} {op} ({b} & 31u))")),
            (inner.clone(), inner.clone(), inner.clone()).prop_map(|(a, b, c)| format!("select({a}, {b}, {c} > a)")),
            (inner.clone(), inner.clone(), prop::sample::select(vec!["min", "max"]))
                .prop_map(|(a, b, f)| format!("{f}({a}, {b})")),
            (inner.clone(), prop::sample::select(vec!["reverseBits", "countOneBits", "countLeadingZeros", "~"]))
                .prop_map(|(a, f)| format!("{f}({a})")),
            (inner.clone(), inner.clone())
                .prop_map(|(a, b)| format!("bitcast<u32>(-bitcast<i32>({a}) / max(bitcast<i32>({b}), 1))")),
            (inner.clone(), inner).prop_map(|(a, b)| format!("vec3u({a}, {b}, 5u)[{b} % 3u]")),
        ]
    })
}

fn real_expression() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        Just("a".to_owned()),
        Just("b".to_owned()),
        Just("c".to_owned()),
        // naga does not compute constants of f64.
        (1u32..1000).prop_map(|n| format!("(a + {:?})", f64::from(n) / 37.0))
    ];
    leaf.prop_recursive(5, 30, 3, |inner| {
        prop_oneof![
            (inner.clone(), inner.clone(), prop::sample::select(vec!["+", "-", "*"]))
                .prop_map(|(a, b, op)| format!("({a} {op} {b})")),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("({a} / (abs({b}) + 0.5))")),
            (inner.clone(), prop::sample::select(vec!["abs", "floor", "trunc", "saturate", "sign", "fract", "ceil"]))
                .prop_map(|(a, f)| format!("{f}({a})")),
            inner.clone().prop_map(|a| format!("sqrt(abs({a}) + 0.01)")),
            inner.clone().prop_map(|a| format!("exp(clamp({a}, -20.0, 20.0))")),
            inner.clone().prop_map(|a| format!("log2(abs({a}) + 0.1)")),
            (inner.clone(), inner.clone(), inner.clone()).prop_map(|(a, b, c)| format!("select({a}, {b}, {c} > 0.25)")),
            (inner.clone(), inner.clone(), inner.clone()).prop_map(|(a, b, c)| format!("mix({a}, {b}, saturate({c}))")),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("dot(vec2f({a}, 1.5), vec2f({b}, {a}))")),
            (inner.clone(), inner).prop_map(|(a, b)| format!("length(vec3f({a}, {b}, 0.5))")),
        ]
    })
}

/// The same expressions in every run.
fn runner() -> TestRunner {
    TestRunner::new_with_rng(
        Config { failure_persistence: None, ..Config::default() },
        TestRng::deterministic_rng(RngAlgorithm::ChaCha),
    )
}

/// One module of many functions, so that an adapter compiles once.
fn drawn(strategy: impl Strategy<Value = String>, count: usize) -> Vec<String> {
    let mut runner = runner();
    (0..count).map(|_| strategy.new_tree(&mut runner).expect("an expression").current()).collect()
}

fn on(gpu: &Gpu, source: &str, words: &[u32]) -> Vec<u32> {
    let result = Kernel::new(gpu, source, "f", None).and_then(|kernel| kernel.run(words, &[]));
    result.unwrap_or_else(|error| panic!("{error}\n{source}"))
}

#[test]
fn random_whole_expressions_are_those_of_every_adapter() {
    let gpus = adapters_for_tests();
    let inputs: Vec<u32> = words().into_iter().take(300).collect();
    for expressions in drawn(whole_expression(), 240).chunks(8) {
        let results: Vec<_> = expressions.iter().enumerate().map(|(i, e)| format!("r[{i}] = {e};")).collect();
        let source = format!(
            "fn f(a: u32, b: u32, c: u32) -> array<u32, 8> {{ var r: array<u32, 8>; {} return r; }}",
            results.concat()
        );
        let here = evaluated(&source, &inputs);
        for gpu in &gpus {
            assert_eq!(here, on(gpu, &source, &inputs), "{}\n{source}", gpu.info());
        }
    }
}

#[test]
fn random_real_expressions_stay_in_their_intervals() {
    let gpus = adapters_for_tests();
    let inputs: Vec<f32> = words().into_iter().take(300).map(|word| (word % 4096) as f32 / 512.0 - 4.0).collect();
    let (mut bounded, mut all) = (0, 0);
    for expressions in drawn(real_expression(), 240).chunks(8) {
        let results: Vec<_> = expressions.iter().enumerate().map(|(i, e)| format!("r[{i}] = {e};")).collect();
        let source = format!(
            "fn f(a: f32, b: f32, c: f32) -> array<f32, 8> {{ var r: array<f32, 8>; {} return r; }}",
            results.concat()
        );
        let double = Shader::in_double(&source).unwrap_or_else(|error| panic!("{error}\n{source}"));
        let points: Vec<_> = inputs.iter().map(|x| Cell::Real(WgslInterval::exactly(*x))).collect();
        let allowed = Program::new(&double, "f").unwrap().run(&points, &mut Buffers::new()).unwrap();
        let single = Shader::parse(&source).unwrap();
        let cells: Vec<_> = inputs.iter().map(|x| Cell::Real(*x)).collect();
        let here = Program::<f32>::new(&single, "f").unwrap().run(&cells, &mut Buffers::new()).unwrap();
        let words: Vec<u32> = inputs.iter().map(|x| x.to_bits()).collect();
        let there: Vec<Vec<u32>> = gpus.iter().map(|gpu| on(gpu, &source, &words)).collect();
        for (index, (allowed, here)) in allowed.iter().zip(here).enumerate() {
            let (Cell::Real(allowed), Cell::Real(here)) = (allowed, here) else { panic!("{allowed:?} {here:?}") };
            all += 1;
            bounded += usize::from(allowed.is_bounded());
            let row = &inputs[index / 8 * 3..index / 8 * 3 + 3];
            let inside = |x: f32| allowed.contains(x) || !allowed.is_bounded();
            assert!(inside(here), "{here} not in {allowed:?} at {row:?}: {}", expressions[index % 8]);
            for there in &there {
                let there = f32::from_bits(there[index]);
                assert!(inside(there), "{there} not in {allowed:?} at {row:?}: {}", expressions[index % 8]);
            }
        }
    }
    assert!(bounded * 10 > all * 9, "{bounded} of {all} intervals are bounded");
}
