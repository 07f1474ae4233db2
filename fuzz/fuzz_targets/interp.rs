//! The evaluator over any text, fragments of shaders, and whole programs with a hole: an error or a result, in f32, f64 and
//! intervals, and never a panic or an endless run.

#![no_main]

use arbitrary::{Arbitrary, Unstructured};
use brdf::interval::WgslInterval;
use brdf::shader::interp::{Buffers, Cell, Number, Program, Shader};
use libfuzzer_sys::fuzz_target;

/// Steps that a run may take before it ends with an error.
const BUDGET: u64 = 20_000;

const EXPRESSIONS: [&str; 40] = [
    "x", "1.5", "-x", "x + y", "x * y", "x / y", "x - y", "x % y", "sqrt(x)", "exp(x)", "log(y)", "pow(x, y)", "sin(x)",
    "atan2(x, y)", "min(x, y)", "max(x, y)", "clamp(x, 0.0, y)", "mix(x, y, 0.3)", "floor(x)", "fract(y)", "abs(x)",
    "select(x, y, x < y)", "f32(i32(x))", "f32(u32(y) / u32(x))", "f32(i32(x) << (u32(y) & 31u))", "length(vec3f(x, y, 1.0))",
    "dot(vec2f(x, y), vec2f(y, x))", "normalize(vec3f(x, y, 2.0)).z", "a[u32(x)]", "bitcast<f32>(bitcast<u32>(x) ^ 1u)",
    "f32(firstLeadingBit(u32(x)))", "frexp(x).fract", "ldexp(x, i32(y))", "(mat2x2f(x, y, y, x) * vec2f(x, 1.0)).y",
    "vec4f(x, y, x, y).wzyx[u32(y)]", "f32(all(vec2f(x) < vec2f(y)))", "unpack2x16float(pack2x16float(vec2f(x, y))).x",
    "step(x, y)", "smoothstep(0.0, 1.0, x)", "g(&a, x)",
];

const STATEMENTS: [&str; 16] = [
    "x = E;", "y = E;", "a[u32(x)] = E;", "if E < E { x = E; } else { y = E; }", "if x > E { return E; }",
    "for (var i = 0; i < 4; i++) { x += E; }", "while y < E { y += 1.0; }", "loop { x = E; if x > 1.0 { break; } continuing { x += 1.0; } }",
    "switch i32(x) { case 1: { x = E; } case 2, 3: { y = E; } default: { x += E; } }", "{ var x = E; y = x; }",
    "loop { continuing { break if x < E; } }", "a = array<f32, 4>(E, E, x, y);", "let t = E; x = t + t;", "x += g(&a, E);",
    "for (;;) { x += 1.0; if x > E { break; } if x > E { continue; } y += E; }", "p = p + vec2f(E, E); x = p.y;",
];

/// A function whose statements and expressions the bytes choose.
fn program(source: &mut Unstructured<'_>) -> String {
    let mut body = String::new();
    while let (false, Ok(choice)) = (source.is_empty(), u8::arbitrary(source)) {
        let mut statement = STATEMENTS[usize::from(choice) % STATEMENTS.len()].to_owned();
        while statement.contains('E') {
            let pick = u8::arbitrary(source).unwrap_or(0);
            statement = statement.replacen('E', EXPRESSIONS[usize::from(pick) % EXPRESSIONS.len()], 1);
        }
        body.push_str(&statement);
        body.push('\n');
    }
    format!(
        "var<private> p: vec2f;
        fn g(a: ptr<function, array<f32, 4>>, v: f32) -> f32 {{ (*a)[u32(v)] += v; return (*a)[0]; }}
        fn f(u: f32, v: f32) -> f32 {{ var x = u; var y = v; var a: array<f32, 4>; {body} return x + y + a[1]; }}"
    )
}

fn run<N: Number>(shader: &Shader, number: impl Fn(f32) -> N) {
    let Ok(program) = Program::<N>::new(shader, "f") else { return };
    let program = program.with_budget(BUDGET);
    let width = program.signature().map_or(0, |signature| signature.inputs().len());
    if width > 64 {
        return;
    }
    let numbers = [0.0, 1.0, -1.5, 3.25, 1e30, f32::NAN, f32::INFINITY, -0.0];
    let cells: Vec<Cell<N>> = (0..width * 8).map(|i| Cell::Real(number(numbers[(i + i / 8) % 8]))).collect();
    let _ = program.run(&cells, &mut Buffers::new());
}

fuzz_target!(|data: &[u8]| {
    let mut source = Unstructured::new(data);
    let text = if u8::arbitrary(&mut source).unwrap_or(0) % 8 == 0 {
        String::from_utf8_lossy(source.take_rest()).into_owned()
    } else {
        program(&mut source)
    };
    if let Ok(shader) = Shader::parse(&text) {
        run::<f32>(&shader, |x| x);
    }
    if let Ok(shader) = Shader::in_double(&text) {
        run::<f64>(&shader, f64::from);
        run::<WgslInterval>(&shader, WgslInterval::exactly);
    }
});
