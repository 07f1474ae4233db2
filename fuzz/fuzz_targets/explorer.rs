//! BRDF Explorer files: any text, and files of chosen parameters, statements and fragments. Read or refused in one line; what is
//! read evaluates to numbers or an error. A panic of the GLSL compiler counts as refused, one of ours does not.

#![no_main]

use arbitrary::{Arbitrary, Unstructured};
use brdf::Vector;
use brdf::check::{Explorer, Family};
use brdf::check::sniff::sniff;
use libfuzzer_sys::fuzz_target;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

const LINES: [&str; 12] = [
    "float n 1 1000 100", "bool b 1", "color c .1 .5 1", "float a 0 0 0", "float a 1 0 0", "# comment", "", "float q 0 1",
    "::end parameters", "::begin parameters", "float n 0 1 nan", "bool b 2",
];

const STATEMENTS: [&str; 24] = [
    "float x = dot(L, V);", "x *= n;", "vec3 H = normalize(L + V);", "x = pow(max(0, dot(N, H)), n);", "if (b) x = 1/x;",
    "for (int i = 0; i < 4; i++) x += c[i];", "while (x < 1) x += dot(L, N);", "x = b ? x : n;", "vec3 y = mix(c, vec3(1), x);",
    "y.xy = y.yx;", "x = y[2];", "return y;", "return vec3(x);", "mat3 m = mat3(L, V, N); y = m * y;", "x = sqrt(1-x*x);", "}", "{",
    "float f(float x) { return x; }", "discard;", "switch (int(x)) { case 0: x = 1.0; break; default: x = 2.0; }",
    "do { x += 1.0; } while (x < 3.0);", "const float PI = 3.14159;", "struct S { float a; }; S s; s.a = x;", "x = inversesqrt(y.x);",
];

fn file(source: &mut Unstructured<'_>) -> String {
    let mut text = "analytic\n::begin parameters\n".to_owned();
    let pick = |from: &[&'static str], source: &mut Unstructured<'_>| {
        from[usize::from(u8::arbitrary(source).unwrap_or(0)) % from.len()]
    };
    for _ in 0..u8::arbitrary(source).unwrap_or(0) % 5 {
        text.push_str(pick(&LINES, source));
        text.push('\n');
    }
    text.push_str("::end parameters\n::begin shader\nvec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y) {\n");
    for _ in 0..u8::arbitrary(source).unwrap_or(0) % 12 {
        text.push_str(pick(&STATEMENTS, source));
        text.push('\n');
    }
    let fragment = String::from_utf8_lossy(source.peek_bytes(source.len().min(40)).unwrap_or(&[])).into_owned();
    if u8::arbitrary(source).unwrap_or(0) % 4 == 0 {
        text.push_str(&fragment);
    }
    text.push_str("\nreturn vec3(1.0);\n}\n::end shader\n");
    text
}

fn run(data: &[u8]) {
    let _ = sniff(data);
    let mut source = Unstructured::new(data);
    let text = if u8::arbitrary(&mut source).unwrap_or(0) % 8 == 0 {
        String::from_utf8_lossy(source.take_rest()).into_owned()
    } else {
        file(&mut source)
    };
    match Explorer::parse("fuzz", &text) {
        Ok(explorer) => {
            let values: Vec<f64> = explorer.parameters().iter().map(|parameter| parameter.high).collect();
            let (up, aside) = (Vector::new(0.0, 0.0, 1.0), Vector::from_angles(1.2, 0.7));
            let mut f = [0.0; 6];
            explorer.subject(&values).evaluate_many(&[(up, aside), (aside, up)], &mut f);
        }
        Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
    }
}

fuzz_target!(|data: &[u8]| {
    // The fuzzer's own hook would end the process over a panic that is caught.
    static QUIET: Once = Once::new();
    QUIET.call_once(|| std::panic::set_hook(Box::new(|_| {})));
    if let Err(panic) = catch_unwind(AssertUnwindSafe(|| run(data))) {
        let message = panic.downcast_ref::<String>().map_or("a panic", String::as_str);
        eprintln!("{message}");
        std::process::abort();
    }
});
