//! Shaders as renderers write them, put before the judge: what is read, what is assumed, and what is refused where.

#![cfg(all(feature = "check", feature = "shader"))]

#[cfg(feature = "gpu")]
mod adapters;

use brdf::check::Family;
use brdf::check::shader::{Language, Options, Returns, ShaderFamily, sniff};
use brdf::frame::Vector;
use std::f64::consts::PI;
use std::path::PathBuf;

/// How many broken files are tried; `BRDF_ROUNDS` sets another number.
fn rounds() -> usize {
    std::env::var("BRDF_ROUNDS").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(200)
}

fn options(function: &str) -> Options {
    Options { function: function.into(), ..Options::default() }
}

fn strings(texts: &[&str]) -> Vec<String> {
    texts.iter().map(|text| (*text).to_owned()).collect()
}

fn direction(theta: f64, phi: f64) -> Vector<f64> {
    Vector::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

/// f of a family with these values, checked to be the same one at a time, many at a time and, nearly, in f32.
fn f(family: &ShaderFamily, values: &[f64], wi: Vector<f64>, wo: Vector<f64>) -> Vec<f64> {
    let subject = family.subject(values);
    let mut one = vec![0.0; subject.channels()];
    subject.evaluate(wi, wo, &mut one);
    let mut many = vec![0.0; 300 * subject.channels()];
    subject.evaluate_many(&vec![(wi, wo); 300], &mut many);
    assert_eq!(many[many.len() - one.len()..], one[..]);
    let single = |v: Vector<f64>| Vector::new(v.x as f32, v.y as f32, v.z as f32);
    let mut rounded = vec![0.0; subject.channels()];
    assert!(subject.evaluate_single(single(wi), single(wo), &mut rounded));
    for (a, b) in one.iter().zip(&rounded) {
        // Lobes of α ≥ .1: rounding of 1-NoH² costs 2⁻²³/α² at most, some rounding steps more.
        assert!((a - f64::from(*b)).abs() <= 2e-4 * a.abs().max(1e-3), "{a} {b}");
    }
    assert_eq!(family.error(), None);
    one
}

/// GGX with height-correlated Smith, α, F = 1.
fn ggx(alpha: f64, wi: Vector<f64>, wo: Vector<f64>) -> f64 {
    let h = (wi + wo).normalized();
    let a2 = alpha * alpha;
    let d = a2 / (PI * (h.z * h.z * (a2 - 1.0) + 1.0).powi(2));
    let lambda = |a: f64, b: f64| a * (b * b * (1.0 - a2) + a2).sqrt();
    d * 0.5 / (lambda(wi.z, wo.z) + lambda(wo.z, wi.z))
}

fn near(value: f64, want: f64, relative: f64) {
    assert!((value - want).abs() <= relative * want.abs(), "{value} is not {want}");
}

const FILAMENT: &str = include_str!("check_shader/engine.glsl");
const THREE: &str = include_str!("check_shader/chunk.glsl.js");
const BEVY: &str = include_str!("check_shader/lighting.wgsl");
const VIEWER: &str = include_str!("check_shader/viewer.frag");

#[test]
fn languages_are_told_by_content() {
    assert_eq!(sniff(FILAMENT), Some(Language::Glsl));
    assert_eq!(sniff(THREE), Some(Language::Glsl));
    assert_eq!(sniff(VIEWER), Some(Language::Glsl));
    assert_eq!(sniff(BEVY), Some(Language::Wgsl));
    assert_eq!(sniff("analytic\n::begin parameters\n"), None);
    assert_eq!(sniff("\u{0}\u{1}"), None);
}

#[test]
fn engine_functions_of_cosines() {
    let (wi, wo) = (direction(0.6, 0.3), direction(0.9, 2.5));
    let family = ShaderFamily::from_source("engine.glsl", FILAMENT, &options("D_GGX")).unwrap();
    assert_eq!(family.signature(), "float D_GGX(float roughness, float NoH, vec3 h)");
    assert!(family.notes()[0].contains("NoH = n·h") && family.notes()[0].contains("h = h"), "{:?}", family.notes());
    assert_eq!(family.parameters()[0].name, "roughness");
    let h = (wi + wo).normalized();
    let a2 = 0.25 * 0.25;
    near(f(&family, &[0.25], wi, wo)[0], a2 / (PI * (h.z * h.z * (a2 - 1.0) + 1.0).powi(2)), 1e-6);

    // A struct of the engine, members by path; one overload of two by its types.
    let family = ShaderFamily::from_source("engine.glsl", FILAMENT, &options("isotropicLobe")).unwrap();
    let names: Vec<_> = family.parameters().iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["pixel.f0", "pixel.roughness"]);
    near(f(&family, &[1.0, 0.3], wi, wo)[1], ggx(0.3, wi, wo), 1e-6);
    let error = ShaderFamily::from_source("engine.glsl", FILAMENT, &options("F_Schlick")).unwrap_err();
    assert!(error.message().contains("several `F_Schlick`"), "{error}");
    let mut chosen = options("F_Schlick(vec3, float)");
    chosen.maps = strings(&["u=l_dot_h"]);
    let family = ShaderFamily::from_source("engine.glsl", FILAMENT, &chosen).unwrap();
    let u = wi.dot(h);
    near(f(&family, &[0.04], wi, wo)[0], 0.04 + 0.96 * (1.0 - u).powi(5), 1e-6);
    // No parameters at all.
    let family = ShaderFamily::from_source("engine.glsl", FILAMENT, &options("Fd_Lambert")).unwrap();
    near(f(&family, &[], wi, wo)[0], 1.0 / PI, 1e-6);
}

#[test]
fn chunks_within_scripts() {
    let (wi, wo) = (direction(0.6, 0.3), direction(0.9, 2.5));
    let mut asked = options("BRDF_GGX");
    asked.values = strings(&["material.specularF90=1"]);
    let family = ShaderFamily::from_source("chunk.glsl.js", THREE, &asked).unwrap();
    assert_eq!(family.channels(), 3);
    let names: Vec<_> = family.parameters().iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["material.roughness", "material.specularColor"]);
    near(f(&family, &[0.5, 1.0], wi, wo)[2], ggx(0.25, wi, wo), 1e-5);
    // The sum of two members of an inout parameter, in which the cosine and a light are.
    let mut asked = options("RE_Direct");
    asked.result = Some("reflected.directDiffuse+reflected.directSpecular".into());
    asked.returns = Returns::Cosine;
    asked.values = strings(&["material.diffuseColor=0"]);
    let family = ShaderFamily::from_source("chunk.glsl.js", THREE, &asked).unwrap();
    near(f(&family, &[0.5, 1.0], wi, wo)[2], ggx(0.25, wi, wo), 1e-5);
}

#[test]
fn uniforms_and_varyings_are_parameters() {
    let (wi, wo) = (direction(0.6, 0.3), direction(0.9, 2.5));
    let family = ShaderFamily::from_source("viewer.frag", VIEWER, &options("specular")).unwrap();
    let names: Vec<_> = family.parameters().iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["u_RoughnessFactor"]);
    assert!(family.notes()[0].contains("v_Normal = n"), "{:?}", family.notes());
    near(f(&family, &[0.5], wi, wo)[0], ggx(0.25, wi, wo), 1e-5);
    let mut asked = options("specular");
    asked.defines = strings(&["SQUARED=0"]);
    asked.ranges = strings(&["u_RoughnessFactor=0.1..0.9:log"]);
    asked.values = strings(&["u_RoughnessFactor=0.3"]);
    let family = ShaderFamily::from_source("viewer.frag", VIEWER, &asked).unwrap();
    assert_eq!(family.parameters()[0].default, 0.3);
    near(f(&family, &[0.3], wi, wo)[0], ggx(0.3, wi, wo), 1e-5);
    // What samples a texture is refused where it does.
    let error = ShaderFamily::from_source("viewer.frag", VIEWER, &options("textured")).unwrap_err();
    let line = 1 + VIEWER.lines().position(|line| line.contains("texture(u_Map")).unwrap() as u32;
    assert_eq!(error.place().map(|place| place.line), Some(line), "{error}");
    assert!(error.message().contains("`u_Map`, a texture"), "{error}");
}

#[test]
fn modules_with_imports() {
    let (wi, wo) = (direction(0.6, 0.3), direction(0.9, 2.5));
    // What the function does not reach may be missing.
    let family = ShaderFamily::from_source("lighting.wgsl", BEVY, &options("D_GGX")).unwrap();
    assert_eq!(family.signature(), "fn D_GGX(roughness: f32, NdotH: f32) -> f32");
    let h = (wi + wo).normalized();
    let a2 = 0.25 * 0.25;
    near(f(&family, &[0.25], wi, wo)[0], a2 / (PI * (h.z * h.z * (a2 - 1.0) + 1.0).powi(2)), 1e-6);
    let error = ShaderFamily::from_source("lighting.wgsl", BEVY, &options("lit")).unwrap_err();
    assert!(
        error.message().contains("`LightingInput` is imported from `engine::types::LightingInput`, which is not found"),
        "{error}"
    );
    assert!(error.place().is_some());
    let mut asked = options("lit");
    asked.include = vec![PathBuf::from("tests/check_shader")];
    let family = ShaderFamily::from_source("lighting.wgsl", BEVY, &asked).unwrap();
    // Both the pointer to the engine's struct and the uniform behind it are filled.
    let names: Vec<_> = family.parameters().iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["input.roughness", "input.F0_"]);
    near(f(&family, &[0.3, 1.0], wi, wo)[0], ggx(0.3, wi, wo), 1e-12);
    // The crate's own library by WESL's imports.
    let own = "import brdf::distribution;\nfn d(h: vec3f, alpha: f32) -> f32 { return distribution::ggx(h, alpha); }";
    let family = ShaderFamily::from_source("own.wgsl", own, &options("d")).unwrap();
    near(f(&family, &[0.25], wi, wo)[0], a2 / (PI * (h.z * h.z * (a2 - 1.0) + 1.0).powi(2)), 1e-12);
}

#[test]
fn conventions_are_undone() {
    let (wi, wo) = (direction(1.1, 0.3), direction(0.9, 2.5));
    for (body, returns) in [("1.0 / PI", "f"), ("max(l.z, 0.0) / PI", "fcos"), ("l.z", "pifcos")] {
        let source = format!("const PI = 3.141592653589793;\nfn f(l: vec3f, v: vec3f) -> f32 {{ return {body}; }}");
        let asked = Options { returns: returns.parse().unwrap(), ..options("f") };
        let family = ShaderFamily::from_source("a.wgsl", &source, &asked).unwrap();
        near(f(&family, &[], wi, wo)[0], 1.0 / PI, 1e-14);
    }
    assert!("cos".parse::<Returns>().unwrap_err().contains("f, fcos, pifcos"));
}

#[test]
fn overrides_and_private_variables() {
    let source = "
        override gain = 2.0;
        override bias: f32 = 1.0;
        override slope: f32;
        var<private> shift: f32 = 0.25;
        @group(0) @binding(0) var<uniform> table: array<vec4f, 2>;
        fn f(wi: vec3f, wo: vec3f) -> f32 { return gain * wi.z + bias + slope + shift + table[1].w; }";
    let mut asked = options("f");
    let error = ShaderFamily::from_source("a.wgsl", source, &asked).unwrap_err();
    assert!(error.message().contains("it is not clear what `slope`, `table[0]`, `table[1]` of `fn f("), "{error}");
    asked.values = strings(&["slope=3", "table[0]=0", "table[1]=1,2,3,4", "bias=0.5"]);
    let family = ShaderFamily::from_source("a.wgsl", source, &asked).unwrap();
    let up = direction(0.0, 0.0);
    assert_eq!(f(&family, &[], up, up), [2.0 + 0.5 + 3.0 + 0.25 + 4.0]);
    assert!(family.notes().iter().any(|note| note.starts_with("shift: its own value")), "{:?}", family.notes());
}

#[test]
fn a_negated_light_and_switches() {
    let source = "float f(vec3 rayDir, vec3 V, bool on, int n) { return on ? max(-rayDir.z, 0.0) * float(n) : 0.0; }";
    let mut asked = options("f");
    asked.maps = strings(&["rayDir=-wi"]);
    asked.values = strings(&["on=true"]);
    asked.ranges = strings(&["n=1..3"]);
    let family = ShaderFamily::from_source("a.glsl", source, &asked).unwrap();
    let up = direction(0.0, 0.0);
    assert_eq!(f(&family, &[2.0], up, up), [2.0]);
}

#[test]
fn nothing_that_is_not_a_number_is_lost() {
    let source = "float f(vec3 l, vec3 v) { float x = 0.0 / (l.z - l.z); return isnan(x) && !isinf(x) && isinf(1.0 / (v.z - v.z)) ? 3.0 : x; }";
    let family = ShaderFamily::from_source("a.glsl", source, &options("f")).unwrap();
    assert_eq!(f(&family, &[], direction(0.1, 0.0), direction(0.2, 0.0)), [3.0]);
}

/// Whole numbers where GLSL makes them floats.
#[test]
fn whole_numbers_of_glsl() {
    let (wi, wo) = (direction(0.6, 0.3), direction(0.9, 2.5));
    for (body, want) in [
        ("return 1;", 1.0),
        ("int n = 3; if (l.z < 0) return 0; return n;", 3.0),
        ("return l.z > 0 ? 2 : 0;", 2.0),
        ("return 2*l.z;", 2.0 * wi.z),
        ("return l.z;", wi.z),
        ("return 1 - max(l.z, 0);", 1.0 - wi.z),
        ("float x = 1; x += 2; return pow(x, 2) / 2;", 4.5),
    ] {
        let source = format!("#line 7\nfloat f(vec3 l, vec3 v) {{ {body} }}");
        let family = ShaderFamily::from_source("a.glsl", &source, &options("f")).unwrap();
        near(f(&family, &[], wi, wo)[0], want, 1e-15);
    }
}

/// A light that points into the surface makes everything 0, which is no plausible surface but a wrong sign.
#[test]
fn a_light_that_points_the_other_way_is_told() {
    let source = "fn f(normal: vec3f, viewDir: vec3f, lightDirNorm: vec3f, tbn: mat3x3f, position: vec3f) -> f32 {
        return max(dot(tbn * normal, -lightDirNorm), 0.0);
    }";
    let mut asked = options("f");
    asked.returns = Returns::PiCosine;
    let error = ShaderFamily::from_source("a.wgsl", source, &asked).unwrap_err();
    assert!(error.message().contains("say --map lightDirNorm=-wi"), "{error}");
    asked.maps = strings(&["lightDirNorm=-wi"]);
    let family = ShaderFamily::from_source("a.wgsl", source, &asked).unwrap();
    near(f(&family, &[], direction(0.6, 0.3), direction(0.9, 2.5))[0], 1.0 / PI, 1e-14);
    // Less than dark: a note.
    let source = "fn f(n: vec3f, lightDirNorm: vec3f, v: vec3f) -> f32 { return 1.0 + dot(n, -lightDirNorm); }
        fn g(n: vec3f, l: vec3f, v: vec3f) -> f32 { return 1.0 + dot(reflect(-l, n), v); }";
    let family = ShaderFamily::from_source("a.wgsl", source, &options("f")).unwrap();
    assert!(family.notes().iter().any(|note| note.contains("--map lightDirNorm=-wi")), "{:?}", family.notes());
    let family = ShaderFamily::from_source("a.wgsl", source, &options("g")).unwrap();
    assert!(family.notes().iter().all(|note| !note.contains("negated")), "{:?}", family.notes());
    let source = "fn f(normal: vec3f, lightDirNorm: vec3f) -> f32 { return max(dot(normal, -lightDirNorm), 0.0); }";
    asked.maps = strings(&["lightDirNorm=wi"]);
    let family = ShaderFamily::from_source("a.wgsl", source, &asked).unwrap();
    assert!(family.notes().iter().any(|note| note.contains("not above 0")), "{:?}", family.notes());
}

/// WESL's conditions by `-D`, in members, statements and imports.
#[test]
fn features_of_wesl() {
    let source = "@if(MISSING) import nowhere::{nothing};
        struct Input { @if(COATED) strength: f32, @else level: f32, roughness: f32 }
        fn f(input: ptr<function, Input>, l: vec3f) -> f32 {
            @if(COATED) return (*input).strength * l.z;
            @else { let x = (*input).level; return x * l.z; }
        }";
    let mut asked = options("f");
    asked.values = strings(&["level=2"]);
    let (wi, wo) = (direction(0.6, 0.3), direction(0.9, 2.5));
    near(f(&ShaderFamily::from_source("a.wesl", source, &asked).unwrap(), &[], wi, wo)[0], 2.0 * wi.z, 1e-14);
    asked.values = strings(&["strength=3"]);
    asked.defines = strings(&["COATED"]);
    near(f(&ShaderFamily::from_source("a.wesl", source, &asked).unwrap(), &[], wi, wo)[0], 3.0 * wi.z, 1e-14);
}

/// A source, what is asked of it, and how the error begins.
#[test]
fn errors_name_the_users_place() {
    let wgsl = "fn f(l: vec3f, v: vec3f) -> f32 { return l.z; }";
    for (name, source, asked, want) in [
        // What validation alone finds is blamed on the part that does not fit, not on the function.
        (
            "a.wgsl",
            "fn g(x: f32) -> f32 { return x; }\nfn f(l: vec3f) -> f32 {\n    return g(l);\n}",
            options("f"),
            "a.wgsl:2:6: ",
        ),
        ("a.txt", "no shader", options("f"), "a.txt: neither WGSL nor GLSL"),
        ("a.wgsl", wgsl, options("g"), "a.wgsl: no function `g`: the file has f"),
        ("a.wgsl", wgsl, options(""), "a.wgsl: name a function of this file: it has f"),
        ("a.wgsl", "fn f(l: vec3f) -> f32 {\n    return l.q;\n}", options("f"), "a.wgsl:2:14: "),
        ("a.glsl", "float f(vec3 l) {\n  return  frobnicate(l.z);\n}", options("f"), "a.glsl:2:11: "),
        ("a.glsl", "#define BAD(x) (x.q)\n\nfloat f(vec3 l) {\n  return 1.0 + BAD(l);\n}", options("f"), "a.glsl:4:"),
        ("a.glsl", "float f(vec3 l) {\n  return (l.z;\n}", options("f"), "a.glsl:"),
        ("a.glsl", "float f(vec3 l) {\n  return l.z;\n", options("f"), "a.glsl:1:17: `{` is not closed"),
        (
            "a.wgsl",
            "fn f(a: vec3f, b: vec3f) -> f32 { return a.z * b.z; }",
            options("f"),
            "a.wgsl: it is not clear what `a`, `b` of",
        ),
        (
            "a.wgsl",
            "fn f(x: vec3f, y: vec3f) -> f32 { return x.z * y.z; }",
            options("f"),
            "a.wgsl: it is not clear what `x`, `y` of",
        ),
        (
            "a.wgsl",
            "fn f(l: vec3f, lightDir: vec3f) -> f32 { return l.z; }",
            options("f"),
            "a.wgsl: l, lightDir all look like wi",
        ),
        (
            "a.wgsl",
            "fn f(l: vec3f, u: f32) -> f32 { return u; }",
            options("f"),
            "a.wgsl: it is not clear what `u` of `fn f(l: vec3<f32>, u: f32) -> f32` is: say --map",
        ),
        (
            "a.wgsl",
            "fn f(l: vec3f) -> vec2f { return l.xy; }",
            options("f"),
            "a.wgsl: which result of `fn f(l: vec3<f32>) -> vec2<f32>` is the BRDF? say --result x, y",
        ),
        (
            "a.wgsl",
            "fn f(l: vec3f, m: mat3x3f) -> f32 { return (m * l).z; }",
            options("f"),
            "a.wgsl: it is not clear what `m`",
        ),
        (
            "a.wgsl",
            "struct R { d: vec3f, s: vec3f } fn f(l: vec3f) -> R { return R(l, l); }",
            options("f"),
            "a.wgsl: which result of",
        ),
        (
            "a.glsl",
            "void g(inout float x) { x = 1.0; }\nfloat f(vec3 l) { vec3 a = l; g(a.y); return a.y; }",
            options("f"),
            "a.glsl: ",
        ),
        (
            "a.glsl",
            "float f(vec3 l) { float x = 0.0; for (;;) { x += l.z; } return x; }",
            options("f"),
            "a.glsl: `f of a.glsl` has not ended after",
        ),
        (
            "a.wgsl",
            "fn f(l: vec3f) -> f32 { var x = l.z; loop { x += 1.0; if x < 0.0 { break; } } return x; }",
            options("f"),
            "a.wgsl: `f of a.wgsl` has not ended after",
        ),
    ] {
        let error = ShaderFamily::from_source(name, source, &asked).map(|family| family.wgsl().to_owned()).unwrap_err();
        assert!(error.to_string().starts_with(want), "{source}\n{error}\nwant {want}");
        assert_eq!(error.to_string().lines().count(), 1);
    }
    let wrong = |change: fn(&mut Options)| {
        let mut asked = options("f");
        change(&mut asked);
        ShaderFamily::from_source("a.wgsl", "fn f(l: vec3f, x: f32, y: f32) -> f32 { return x; }", &asked).unwrap_err()
    };
    for (error, want) in [
        (wrong(|o| o.maps = strings(&["x"])), "--map x: write NAME="),
        (wrong(|o| o.maps = strings(&["z=wi"])), "--map z: there is no such value; the function waits for l, x, y"),
        (wrong(|o| o.maps = strings(&["x=q"])), "--map x=q: `q` is none of wi"),
        (wrong(|o| o.maps = strings(&["x=wi"])), "--map x=wi: the role is a vector of 3"),
        (wrong(|o| o.values = strings(&["x=a"])), "--param x=a: `a` is not a number"),
        (wrong(|o| o.values = strings(&["x=1,2"])), "--param x=1,2: 2 numbers for 1 components"),
        (wrong(|o| o.values = strings(&["x=1e39"])), "--param x=1e39: `1e39` is not a number of 32 bits"),
        (wrong(|o| o.values = strings(&["x=1", "x=2"])), "--param x: given twice"),
        (wrong(|o| o.ranges = strings(&["x=1"])), "--range x=1: write LO..HI"),
        (wrong(|o| o.ranges = strings(&["x=2..1"])), "--range x=2..1: the first number must be below"),
        (wrong(|o| o.ranges = strings(&["x=0..1:log"])), "--range x=0..1:log: a logarithmic range begins above 0"),
        (wrong(|o| o.ranges = strings(&["x=0..1:lin"])), "--range x=0..1:lin: `lin` is not `log`"),
        (wrong(|o| o.defines = strings(&["=1"])), "-D =1"),
    ] {
        assert!(error.to_string().contains(want), "{error}\nwant {want}");
    }
}

#[test]
fn errors_within_includes() {
    let mut asked = options("f");
    asked.include = vec![PathBuf::from("tests/check_shader")];
    let source = "#include <broken.glsl>\nfloat f(vec3 l) { return broken(l); }";
    let error = ShaderFamily::from_source("a.glsl", source, &asked).unwrap_err();
    let place = error.place().unwrap();
    assert!(place.file.ends_with("broken.glsl") && place.line == 3, "{error}");
    assert!(error.report().contains("undeclared"), "{}", error.report());
}

/// Endless for some directions only: what is measured must not pass for numbers.
#[test]
fn an_endless_loop_is_told() {
    let source =
        "fn f(l: vec3f, v: vec3f) -> f32 { var x = 0.0; loop { if l.z < 0.9 { break; } x += 1e-9; } return x; }";
    let family = ShaderFamily::from_source("a.wgsl", source, &options("f")).unwrap();
    let subject = family.subject(&[]);
    let mut f = [0.0];
    subject.evaluate(direction(1.0, 0.0), direction(0.5, 0.0), &mut f);
    assert_eq!((f, family.error()), ([0.0], None));
    subject.evaluate(direction(0.0, 0.0), direction(0.5, 0.0), &mut f);
    assert!(f[0].is_nan());
    assert!(family.error().unwrap().contains("has not ended after"), "{:?}", family.error());
}

/// The judge's own numbers: a white GGX keeps its energy, one without masking does not.
#[test]
fn verdicts_are_those_of_the_model() {
    use brdf::check::{self, Fixed, Verdict};
    let mut asked = options("lit");
    asked.include = vec![PathBuf::from("tests/check_shader")];
    asked.values = strings(&["input.roughness=0.3", "input.F0_=1"]);
    let family = ShaderFamily::from_source("lighting.wgsl", BEVY, &asked).unwrap();
    let limits = check::Options { budget: 200_000, thetas: &[0.0, 60.0, 85.0], ..Default::default() };
    let report = check::check(&*family.subject(&[]), &limits);
    assert_eq!(report.energy(Fixed::View).unwrap().verdict, Verdict::Pass, "{report}");
    let source = "fn f(n_dot_h: f32, n_dot_l: f32, n_dot_v: f32) -> f32 {
        let d = n_dot_h * n_dot_h * (0.01 * 0.01 - 1.0) + 1.0;
        return 0.01 * 0.01 / (3.141592653589793 * d * d) / (4.0 * n_dot_l * n_dot_v);
    }"
    .replace("0.01 * 0.01", "0.01");
    let family = ShaderFamily::from_source("a.wgsl", &source, &options("f")).unwrap();
    let report = check::check(&*family.subject(&[]), &check::Options { thetas: &[0.0, 89.9], ..limits });
    let energy = report.energy(Fixed::View).unwrap();
    assert_eq!(energy.verdict, Verdict::Fail, "{report}");
    assert!(energy.value > 20.0, "{report}");
    assert_eq!(family.error(), None);
}

/// Long chains that would take a compiler's stack, and their place.
#[test]
fn what_nests_too_deep_is_refused() {
    for (name, head) in [("a.wgsl", "fn f(l: vec3f) -> f32 {\n return "), ("a.glsl", "float f(vec3 l) {\n return ")] {
        for chain in ["1.0 + ".repeat(100_000), "-".repeat(100_000), "(".repeat(100_000)] {
            let close = if chain.starts_with('(') { ")".repeat(100_000) } else { String::new() };
            let source = format!("{head}{chain}l.z{close};\n}}");
            let error = ShaderFamily::from_source(name, &source, &options("f")).unwrap_err();
            assert_eq!(error.place().map(|place| place.line), Some(2), "{error}");
        }
    }
}

/// Real files with pieces cut, doubled, moved and broken: an error or numbers, and never a panic.
#[test]
fn broken_files_end_in_errors() {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 16) as usize % below.max(1)
    };
    let corpus = [(FILAMENT, "isotropicLobe"), (THREE, "BRDF_GGX"), (BEVY, "D_GGX"), (VIEWER, "specular")];
    let (mut read, mut refused) = (0, 0);
    for round in 0..rounds() {
        let (text, function) = corpus[round % corpus.len()];
        let mut bytes = text.as_bytes().to_vec();
        for _ in 0..1 + random(4) {
            let (from, length) = (random(bytes.len()), random(24));
            let to = (from + length).min(bytes.len());
            let piece = bytes[from..to].to_vec();
            match random(4) {
                0 => drop(bytes.drain(from..to)),
                1 => drop(bytes.splice(from..from, piece)),
                2 => {
                    let at = random(bytes.len());
                    drop(bytes.splice(at..at, piece));
                }
                _ => {
                    let sign = b"(){}[];,.#*/+-=<>\"\\\n0\xff"[random(22)];
                    bytes.insert(from, sign);
                }
            }
        }
        let text = String::from_utf8_lossy(&bytes);
        match ShaderFamily::from_source("broken", &text, &options(function)) {
            Ok(family) => {
                let values: Vec<f64> = family.parameters().iter().map(|parameter| parameter.default).collect();
                let mut f = vec![0.0; family.channels()];
                family.subject(&values).evaluate(direction(0.6, 0.3), direction(0.9, 2.5), &mut f);
                read += 1;
            }
            Err(error) => {
                assert_eq!(error.to_string().lines().count(), 1, "{error}");
                refused += 1;
            }
        }
    }
    assert!(read > 0 && refused > 0, "{read} {refused}");
}

/// The same function on an adapter: what the shader gives there, apart by rounding alone.
#[cfg(feature = "gpu")]
#[test]
fn an_adapter_agrees() {
    for gpu in adapters::adapters_for_tests() {
        adapter_agrees(&gpu);
    }
}

#[cfg(feature = "gpu")]
fn adapter_agrees(gpu: &brdf::gpu::Gpu) {
    let mut asked = options("lit");
    asked.include = vec![PathBuf::from("tests/check_shader")];
    let family = ShaderFamily::from_source("lighting.wgsl", BEVY, &asked).unwrap();
    let single = |v: Vector<f64>| Vector::new(v.x as f32, v.y as f32, v.z as f32);
    let pairs: Vec<_> = (0..50)
        .map(|i| (direction(0.02 * f64::from(i), 0.3), direction(1.2 - 0.01 * f64::from(i), 2.5)))
        .map(|(wi, wo)| (single(wi), single(wo)))
        .collect();
    let values = [0.5, 1.0];
    let on_gpu = family.evaluate_on(gpu, &values, &pairs).unwrap();
    assert_eq!(on_gpu.len(), pairs.len() * family.channels());
    let subject = family.subject(&values);
    for ((wi, wo), got) in pairs.iter().zip(on_gpu.chunks(family.channels())) {
        let mut f = vec![0.0; family.channels()];
        assert!(subject.evaluate_single(*wi, *wo, &mut f));
        for (got, want) in got.iter().zip(&f) {
            // α = .5: a division and a square root of 2.5 ulp each, and 1-NoH² at 2⁻²³/α².
            assert!((got - want).abs() <= 1e-4 * want.abs().max(1e-3), "{got} {want}");
        }
    }
}
