//! BRDF Explorer files: what a shader computes, what a parameter means, and what is said of those that are refused.
#![cfg(all(feature = "check", feature = "shader"))]

use brdf::Vector;
use brdf::check::{self, Check, Explorer, Family, Fixed, Options, Profile, Scale, Verdict};
use std::f64::consts::{PI, TAU};

fn file(parameters: &str, shader: &str) -> String {
    format!(
        "analytic\n\n# test\n::begin parameters\n{parameters}\n::end parameters\n\n::begin shader\n{shader}\n::end shader\n"
    )
}

fn brdf(body: &str) -> String {
    format!("vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y) {{ {body} }}")
}

/// Pairs over the hemisphere.
fn pairs() -> Vec<(Vector<f64>, Vector<f64>)> {
    let u = |i: u32, a: f64| (0.5 + f64::from(i) * a).fract();
    (0..600)
        .map(|i| {
            let wi = Vector::from_angles(1.5 * u(i, 0.754_877_666), TAU * u(i, 0.569_840_290));
            (wi, Vector::from_angles(1.5 * u(i, 0.819_172_513), TAU * u(i, 0.671_043_606)))
        })
        .collect()
}

/// The shader against the same formula in Rust, in f64 and in f32, one pair and many at a time.
fn agrees(text: &str, values: &[f64], want: impl Fn(Vector<f64>, Vector<f64>) -> [f64; 3]) {
    let explorer = Explorer::parse("test.brdf", text).unwrap();
    let subject = explorer.subject(values);
    let pairs = pairs();
    let mut many = vec![0.0; 3 * pairs.len()];
    subject.evaluate_many(&pairs, &mut many);
    for ((wi, wo), many) in pairs.iter().zip(many.chunks(3)) {
        let (mut one, mut single) = ([0.0; 3], [0f32; 3]);
        subject.evaluate(*wi, *wo, &mut one);
        assert!(subject.evaluate_single(wi.cast(), wo.cast(), &mut single));
        assert_eq!(one, many);
        for ((f, single), want) in one.iter().zip(single).zip(want(*wi, *wo)) {
            // Constants of the shader are rounded to f32 by its compiler: 6e-8, and what powers make of it.
            assert!((f - want).abs() <= 1e-5 * want.abs() + 1e-9, "{f} {want} at {wi:?} {wo:?}");
            assert!((f64::from(single) - want).abs() <= 3e-3 * want.abs() + 1e-6, "{single} {want} at {wi:?} {wo:?}");
        }
    }
}

#[test]
fn shaders_mean_what_they_say() {
    // What GLSL allows and other languages do not: whole numbers for reals, redefined builtins, components by index,
    // overloads, chains of ternaries, globals with constant values, parameters that functions see.
    let text = file(
        "float k 0.5 2 1\nbool square 1\ncolor tint .2 .4 .8\nfloat gain_1 0 4 2",
        "const float PI = 3.14159265358979323846;
# dropped: would not compile

float sqr(float x) { return x*x; }
float smoothstep(float a, float b, float x) { return x < a ? 7.0 : x > b ? 9.0 : 11.0; }
vec3 reflect(vec3 I, vec3 N) { return 2*dot(I,N)*N - I; }
float power(float x) { return square ? pow(x, 2) : pow(x, k); }
float power(float x, float y) { return pow(x, y); }
vec3 BRDF( vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y )
{
    vec3 H = normalize(L+V);
    float m = max(0, dot(reflect(L, N), V));
    vec3 lin = vec3(power(tint[0]), power(tint.g), power(tint[2], 2));
    if (dot(N,L) < 0 || dot(N,V) < 0) return vec3(0);
    return gain_1 * lin * (smoothstep(0.2, 0.6, dot(N,H)) / PI + sqr(m) + max(0, dot(H,X)) + 2 * abs(dot(H,Y)));
}",
    );
    let explorer = Explorer::parse("dir/test.brdf", &text).unwrap();
    let names: Vec<_> = explorer.parameters().iter().map(|p| (p.name.as_str(), p.low, p.high, p.default)).collect();
    let wanted = [
        ("k", 0.5, 2.0, 1.0),
        ("square", 0.0, 1.0, 1.0),
        ("tint.r", 0.0, 1.0, 0.2),
        ("tint.g", 0.0, 1.0, 0.4),
        ("tint.b", 0.0, 1.0, 0.8),
        ("gain_1", 0.0, 4.0, 2.0),
    ];
    assert_eq!(names, wanted);
    assert_eq!(explorer.parameters()[1].scale, Scale::Switch);
    for square in [0.0, 1.0] {
        let (k, tint, gain) = (1.7, [0.3, 0.6, 0.9], 1.25);
        agrees(&text, &[k, square, tint[0], tint[1], tint[2], gain], |wi, wo| {
            let h = (wi + wo).normalized();
            let step = if h.z < 0.2 {
                7.0
            } else if h.z > 0.6 {
                9.0
            } else {
                11.0
            };
            let mirrored = Vector::new(-wi.x, -wi.y, wi.z);
            let m = mirrored.dot(wo).max(0.0);
            let value = step / PI + m * m + h.x.max(0.0) + 2.0 * h.y.abs();
            let power = |x: f64| if square > 0.0 { x * x } else { x.powf(k) };
            [power(tint[0]), power(tint[1]), tint[2] * tint[2]].map(|lin| gain * lin * value)
        });
    }
}

#[test]
fn ranges_and_scales_follow_the_file() {
    let text = file(
        "float n 1 1000 100\nfloat a 0 1 2\nfloat b 0.001 0.05 0.01\ncolor c 2 .5 -1",
        &brdf("return c * n * a * b;"),
    );
    let explorer = Explorer::parse("x", &text).unwrap();
    let parameters = explorer.parameters();
    assert_eq!(parameters[0].scale, Scale::Logarithmic);
    assert_eq!((parameters[1].high, parameters[1].scale), (2.0, Scale::Linear));
    assert_eq!(parameters[2].scale, Scale::Linear);
    assert_eq!((parameters[3].high, parameters[5].low), (2.0, -1.0));
    assert!(!explorer.has_sampler());
    for (name, profile) in
        [("brdfs/d_ggx.brdf", Profile::Term), ("dAniso.brdf", Profile::Strict), ("disney.brdf", Profile::Strict)]
    {
        assert_eq!(Explorer::parse(name, &text).unwrap().profile(), profile);
    }
}

#[test]
fn verdicts_are_those_of_the_models() {
    let options = Options { budget: 100_000, ..Options::default() };
    // Blinn–Phong with (n+8)/8π, n = 10: 1.075 at the normal.
    let phong = file(
        "float n 1 100 10",
        &brdf("return vec3((n+8)/(8*3.14159265358979) * pow(max(0, dot(N, normalize(L+V))), n));"),
    );
    let report = check::check(&*Explorer::parse("phong", &phong).unwrap().subject(&[10.0]), &options);
    assert_eq!(report.energy(Fixed::View).unwrap().verdict, Verdict::Fail, "{report}");
    let normal = report.albedos.iter().find(|albedo| albedo.theta == 0.0).unwrap();
    assert!((normal.value[0] - 1.075).abs() < 1e-3, "{report}");
    assert!(report.finding(Check::Precision).is_some(), "{report}");
    let lambert = file("float rho 0 1 1", &brdf("return vec3(rho / 3.14159265358979);"));
    let report = check::check_family(&Explorer::parse("lambert", &lambert).unwrap(), &options);
    assert_eq!(report.verdict(), Verdict::Pass, "{report}");
}

#[test]
fn broken_shaders_are_refused_with_the_files_line() {
    let refused = |shader: &str| Explorer::parse("x", &file("float n 0 1 1", shader)).unwrap_err();
    // The shader starts in line 9 of the file.
    let error = refused("\nvec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y)\n{\n    return vec3(roughness);\n}");
    assert_eq!(error.line(), Some(12), "{error}");
    assert!(error.to_string().contains("roughness"), "{error}");
    let error = refused("vec3 BRDF(vec3 L, vec3 V) { return L; }");
    assert!(error.to_string().starts_with("the shader does not fit `vec3 BRDF(vec3 L"), "{error}");
    assert!(refused("").to_string().contains("does not fit `vec3 BRDF"), "{}", refused(""));
    assert!(refused(&brdf("return vec3(1.0)")).line().is_some());
    let error = refused(&format!("uniform sampler2D lut;\n{}", brdf("return texture(lut, L.xy).rgb;")));
    assert_eq!(error.to_string().lines().count(), 1, "{error}");
    let error = refused(&format!("float f(float x) {{ return f(x); }}\n{}", brdf("return vec3(f(n));")));
    assert_eq!(error.to_string().lines().count(), 1, "{error}");
    let error = refused(&format!("float f(float x) {{\n    return 1;\n}}\n{}", brdf("return vec3(f(n));")));
    assert!(error.to_string().contains("write 1.0"), "{error}");
    // Deep nesting is counted, not tried.
    for deep in ["(", "{", "-", "!", "[", "if (true) "] {
        let error = refused(&brdf(&format!("{} return vec3(1.0);", deep.repeat(100_000))));
        assert_eq!(error.to_string().lines().count(), 1, "{error}");
    }
}

#[test]
fn loops_without_end_are_errors_not_hangs() {
    let endless = file("float n 0 1 1", &brdf("float x = 0.0; while (n > 0.5) { x += 1.0; } return vec3(x);"));
    let error = Explorer::parse("x", &endless).unwrap_err().to_string();
    assert!(error.contains("not finished after") && error.contains("a loop that does not end"), "{error}");
    // Only for other values than the defaults: told after the check.
    let explorer = Explorer::parse("x", &endless.replace("float n 0 1 1", "float n 0 1 0")).unwrap();
    assert_eq!(explorer.error(), None);
    let report =
        check::check(&*explorer.subject(&[1.0]), &Options { budget: 20_000, thetas: &[0.0], ..Options::default() });
    assert!(explorer.error().unwrap().contains("not finished after"), "{report}");
    assert!(report.notes.join(" ").contains("not finished after"), "{report}");
    assert_ne!(report.verdict(), Verdict::Pass, "{report}");
}

#[test]
fn any_text_is_read_or_refused() {
    let good = file(
        "float n 0 1 1\nbool b 1\ncolor c 1 1 1",
        &format!(
            "float f(float x) {{ for (int i = 0; i < 3; i++) x *= 2; return b ? x : n; }}\n{}",
            brdf("return c * f(dot(L, H));")
        ),
    )
    .replace('H', "V");
    Explorer::parse("good", &good).unwrap();
    let words = [
        "",
        "(",
        ")",
        "{",
        "}",
        ";",
        ",",
        "vec3",
        "float",
        "x",
        "1",
        "1.0",
        "=",
        "*",
        "?",
        ":",
        "return",
        "if",
        "for",
        "::end shader\n",
        "::begin shader\n",
        "\n#",
        "in",
        "out",
        "inout",
        "const",
        "struct",
        "[2]",
        ".xyz",
        "\"",
        "\\",
        "é",
        "0x",
        "1e999",
        "while",
        "void",
        "layout(binding=0)",
        "uniform",
        "/*",
        "//",
        "mat3",
        "int",
        "bool",
        "==",
        "&&",
        "++",
        "<<",
        "texture",
        "sampler2D",
        "discard",
    ];
    let mut state = 7u32;
    let mut next = |n: usize| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as usize % n
    };
    let tokens: Vec<&str> = good.split_inclusive(|c: char| !c.is_alphanumeric()).collect();
    let mut read = 0;
    for _ in 0..400 {
        let mut text = tokens.clone();
        for _ in 0..1 + next(3) {
            let at = next(text.len());
            match next(3) {
                0 => drop(text.remove(at)),
                1 => text.insert(at, words[next(words.len())]),
                _ => text[at] = words[next(words.len())],
            }
        }
        match Explorer::parse("mutant", &text.concat()) {
            Ok(_) => read += 1,
            Err(error) => assert_eq!(error.to_string().lines().count(), 1, "{error}"),
        }
    }
    assert!(read > 5, "{read}");
}
