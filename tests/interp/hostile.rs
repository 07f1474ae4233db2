//! Broken and hostile modules: an error, never a panic, never a hang.

use brdf::shader::interp::{Buffers, Cell, InterpError, Program, Shader};

fn error(source: &str, function: &str) -> String {
    let shader = match Shader::parse(source) {
        Ok(shader) => shader,
        Err(error) => return error.to_string(),
    };
    match Program::<f32>::new(&shader, function) {
        Err(error) => error.to_string(),
        Ok(program) => {
            let count = program.signature().map_or(0, |signature| signature.inputs().len());
            let cells = vec![Cell::Real(1.0); count];
            match program.with_budget(100_000).run(&cells, &mut Buffers::new()) {
                Err(error) => error.to_string(),
                Ok(cells) => format!("{cells:?}"),
            }
        }
    }
}

#[test]
fn what_is_not_supported_says_where() {
    let texture = "@group(0) @binding(0) var t: texture_2d<f32>;\nfn f(x: f32) -> f32 {\n    return x + textureLoad(t, vec2i(0), 0).x;\n}";
    assert_eq!(error(texture, "f"), "line 3: `f` uses a texture, which the evaluator does not support");
    let half = "enable f16;\nfn f(x: f32) -> f32 {\n    return f32(f16(x) * 2.0h);\n}";
    assert!(error(half, "f").contains("f16"), "{}", error(half, "f"));
    let derivative = "fn f(x: f32) -> f32 {\n    return dpdx(x);\n}";
    assert_eq!(error(derivative, "f"), "line 2: `f` uses a derivative, which the evaluator does not support");
    let kill = "fn g() { discard; }\nfn f(x: f32) -> f32 { g(); return x; }";
    assert_eq!(error(kill, "f"), "line 1: `g` uses `discard`, which the evaluator does not support");
    let wide = "fn f(x: f32) -> f32 { return f32(1li); }";
    assert!(error(wide, "f").contains("I64") || error(wide, "f").contains("64 bits"), "{}", error(wide, "f"));
}

#[test]
fn what_is_missing_is_named() {
    assert!(error("fn f(x: f32) -> f32 { return x; }", "g").contains("no function `g`"));
    assert!(error("fn f(x: f32) -> f32 { return y; }", "f").starts_with("line 1"));
    let buffer =
        "@group(1) @binding(2) var<storage> numbers: array<f32>;\nfn f(x: f32) -> f32 { return numbers[u32(x)]; }";
    assert_eq!(error(buffer, "f"), "no buffer is given for `numbers`, group 1, binding 2");
    let shader = Shader::parse(buffer).unwrap();
    let program = Program::<f32>::new(&shader, "f").unwrap();
    // Too short for one element: an index has nothing to be clamped to, and reads 0.
    let result = program.run(&[Cell::Real(3.0)], &mut Buffers::new().with(1, 2, vec![0; 2]));
    assert_eq!(result, Ok(vec![Cell::Real(0.0)]));
    let fixed =
        Shader::parse("@group(0) @binding(0) var<uniform> v: vec4f; fn f(x: f32) -> f32 { return v.x + x; }").unwrap();
    let short =
        Program::<f32>::new(&fixed, "f").unwrap().run(&[Cell::Real(3.0)], &mut Buffers::new().with(0, 0, vec![0; 8]));
    assert!(matches!(&short, Err(InterpError::Arguments(reason)) if reason.contains("too few")), "{short:?}");
    let cells =
        Program::<f32>::new(&fixed, "f").unwrap().run(&[Cell::Word(3)], &mut Buffers::new().with(0, 0, vec![0; 16]));
    assert!(matches!(&cells, Err(InterpError::Arguments(reason)) if reason.contains("x: a number")), "{cells:?}");
}

#[test]
fn loops_without_end_end() {
    for body in [
        "loop { if x > 1e30 { break; } }",
        "while x > 0.0 { }",
        "for (var i = 0u; i >= 0u; i++) { for (var j = 0; j < 2000000000; j++) { } }",
    ] {
        let message = error(&format!("fn f(x: f32) -> f32 {{ {body} return x; }}"), "f");
        assert!(message.contains("not finished after 100000 steps"), "{body}: {message}");
    }
}

#[test]
fn programs_that_grow_are_refused() {
    // Every function calls the one before it twice: a routine each, but 2⁴⁰ calls.
    let mut source = "fn g0(x: f32) -> f32 { return x + 1.0; }\n".to_owned();
    for i in 1..=40 {
        source += &format!("fn g{i}(x: f32) -> f32 {{ return g{0}(g{0}(x)); }}\n", i - 1);
    }
    assert!(error(&source, "g40").contains("not finished"), "{}", error(&source, "g40"));

    let mut source = "fn g0(x: f32) -> f32 { return x + 1.0; }\n".to_owned();
    for i in 1..=5000 {
        source += &format!("fn g{i}(x: f32) -> f32 {{ return g{}(x); }}\n", i - 1);
    }
    assert!(error(&source, "g5000").contains("nest more than"), "{}", error(&source, "g5000"));

    let big = "fn f(x: f32) -> f32 { var a: array<array<f32, 300>, 300>; a[u32(x)][1] = x; return a[2][3]; }";
    assert!(error(big, "f").contains("more than 65536 scalars"), "{}", error(big, "f"));
    let mut many = "fn f(x: f32) -> f32 {\n".to_owned();
    for i in 0..8 {
        many += &format!("var a{i}: array<f32, 60000>; a{i}[u32(x)] = x;\n");
    }
    many += "return a0[1] + a1[1] + a2[1] + a3[1] + a4[1] + a5[1] + a6[1] + a7[1]; }";
    assert!(error(&many, "f").contains("registers"), "{}", error(&many, "f"));
}

#[test]
fn cut_modules_do_not_panic() {
    let source = "struct S { a: vec3f, b: array<i32, 3> }
        var<private> p: S;
        fn g(q: ptr<function, vec3f>, i: i32) -> f32 { (*q)[i] += 1.0; return (*q).x; }
        fn f(x: f32) -> f32 { var v = p.a; p.b[u32(x)] = 3; return g(&v, p.b[1]) + select(1.0, 2.0, x > 0.0); }";
    assert_eq!(error(source, "f"), "[Real(2.0)]");
    // Any prefix, and any one character changed.
    for end in 0..source.len() {
        let _ = error(&source[..end], "f");
        for other in ["0", "}", "(", "u", "-"] {
            let changed = format!("{}{other}{}", &source[..end], &source[end + 1..]);
            let _ = error(&changed, "f");
            let _ = Shader::in_double(&changed);
        }
    }
}
