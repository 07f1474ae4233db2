//! The linker on small libraries, and the rules that the real modules keep.

use super::error::LinkError;
use super::link::{link_item, mangled};
use super::unit::{Kind, Unit};
use super::{MODULES, functions, functions_of, link, link_function, link_with, source, token};
use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

const FRESNEL: &str = "\
// Fresnel's equations.

import package::real::{squared, TINY as SMALL};

/// Reflected and transmitted.
struct Fresnel {
    F: f32, // reflected
    squared: f32,
}

// Exact,
// for dielectrics.
fn dielectric(c: f32, eta: f32) -> Fresnel {
    let s = squared(c); /* squared */
    return Fresnel(_half(s + SMALL), s);
}

fn conductor(c: f32) -> f32 { return super::real::squared(c); } // trailing

fn _half(x: f32) -> f32 { return 0.5 * x; }
";

const REAL: &str = "\
const TINY: f32 = 1e-8;
const LARGE: f32 = 1e+8; // unused
const_assert TINY < 1.0;

fn squared(x: f32) -> f32 { return x * x; }
";

const MASKING: &str = "\
import package::fresnel;
fn v_cavity(a: f32) -> fresnel::Fresnel { return fresnel::dielectric(a, package::real::TINY); }
fn cyclic(a: f32) -> f32 { return v_cavity(a).squared; }
";

const LIBRARY: &[(&str, &str)] = &[("real", REAL), ("masking", MASKING), ("fresnel", FRESNEL)];

fn linked(root: &str) -> String {
    link_with(LIBRARY, root).unwrap()
}

fn error(modules: &[(&str, &str)], root: &str) -> String {
    link_with(modules, root).unwrap_err().to_string()
}

/// What the root's own part became.
fn root_part(root: &str) -> String {
    let linked = linked(root);
    linked[linked.find("fn main").unwrap()..].to_owned()
}

#[test]
fn golden() {
    let root = "\
import brdf::fresnel::dielectric; // exact

// The root.
fn main(c: f32) -> f32 {
    return dielectric(c, 1.5).squared;
}
";
    let want = "\
const real_TINY: f32 = 1e-8;
const_assert real_TINY < 1.0;

fn real_squared(x: f32) -> f32 { return x * x; }

/// Reflected and transmitted.
struct fresnel_Fresnel {
    F: f32, // reflected
    squared: f32,
}

// Exact,
// for dielectrics.
fn fresnel_dielectric(c: f32, eta: f32) -> fresnel_Fresnel {
    let s = real_squared(c); /* squared */
    return fresnel_Fresnel(fresnel__half(s + real_TINY), s);
}

fn fresnel__half(x: f32) -> f32 { return 0.5 * x; }

// The root.
fn main(c: f32) -> f32 {
    return fresnel_dielectric(c, 1.5).squared;
}
";
    assert_eq!(linked(root), want);
    let reversed: Vec<_> = LIBRARY.iter().rev().copied().collect();
    assert_eq!(link_with(&reversed, root).unwrap(), want);
}

#[test]
fn every_import_form() {
    for (import, call) in [
        ("import brdf::fresnel;", "fresnel::conductor(x)"),
        ("import brdf :: /* here */ fresnel ;", "fresnel /* there */ :: conductor(x)"),
        ("import brdf::fresnel as f;", "f::conductor(x)"),
        ("import brdf::fresnel::conductor;", "conductor(x)"),
        ("import brdf::fresnel::conductor as metal;", "metal(x)"),
        ("import brdf::fresnel::{dielectric, conductor as metal};", "metal(x)"),
        ("import brdf::{masking::v_cavity, fresnel,};", "fresnel::conductor(x)"),
        ("import brdf::{masking::v_cavity, fresnel::{dielectric as d, conductor}};", "conductor(x)"),
        ("import brdf::fresnel::{};", "brdf::fresnel::conductor(x)"),
        ("", "brdf::fresnel::conductor(x)"),
    ] {
        let out = linked(&format!("{import}\nfn main(x: f32) -> f32 {{ return {call}; }}\n"));
        let want = "\
fn real_squared(x: f32) -> f32 { return x * x; }

fn fresnel_conductor(c: f32) -> f32 { return real_squared(c); } // trailing

fn main(x: f32) -> f32 { return fresnel_conductor(x); }
";
        // `real` brings its assertion.
        let want = format!("const real_TINY: f32 = 1e-8;\nconst_assert real_TINY < 1.0;\n\n{want}");
        assert_eq!(out.replace("\n\n\n", "\n\n"), want, "{import} {call}");
    }
}

#[test]
fn types_and_constants_are_items_too() {
    let out =
        linked("import brdf::{fresnel, real::TINY};\nfn main() { var a: array<fresnel::Fresnel, 2>; let b = TINY; }\n");
    assert!(out.contains("struct fresnel_Fresnel"));
    assert!(out.ends_with("fn main() { var a: array<fresnel_Fresnel, 2>; let b = real_TINY; }\n"), "{out}");
}

#[test]
fn nothing_to_link_changes_nothing() {
    for root in
        ["", "\n", "// a\nenable f16; // half\n\nconst a = 1;;\r\n", "fn pow5(x: f32) -> f32 { return x; } // b"]
    {
        assert_eq!(linked(root), root);
    }
    assert_eq!(linked("import brdf::fresnel;\nfn f() {}"), "fn f() {}");
}

#[test]
fn directives_stay_on_top() {
    let out = linked(
        "// mine\nimport brdf::real;\nenable f16; // half\ndiagnostic(off, derivative_uniformity);\n\nconst a = real::LARGE;\n",
    );
    let want = "// mine\nenable f16; // half\ndiagnostic(off, derivative_uniformity);\n\n\
        const real_TINY: f32 = 1e-8;\nconst real_LARGE: f32 = 1e+8; // unused\nconst_assert real_TINY < 1.0;\n\n\
        const a = real_LARGE;\n";
    assert_eq!(out, want);
}

#[test]
fn scopes_hide_items() {
    let import = "import brdf::real::squared;\nimport brdf::fresnel;\n";
    for (body, want) in [
        // A local hides the item from the end of its own statement.
        ("{ let squared = squared(2.0); return squared; }", "{ let squared = real_squared(2.0); return squared; }"),
        // To the end of its block.
        (
            "{ { var squared = 1.0; squared += 1.0; } squared(1.0); }",
            "{ { var squared = 1.0; squared += 1.0; } real_squared(1.0); }",
        ),
        (
            "{ if true { const squared: f32 = 1.0; } else { squared(1.0); } }",
            "{ if true { const squared: f32 = 1.0; } else { real_squared(1.0); } }",
        ),
        // A loop's variable lives in its header and body, braces within or not.
        (
            "{ for (var squared = squared(1.0); squared < 9.0; squared += 1.0) { if true { squared; } squared; } squared(1.0); }",
            "{ for (var squared = real_squared(1.0); squared < 9.0; squared += 1.0) { if true { squared; } squared; } real_squared(1.0); }",
        ),
        (
            "{ for (;;) { for (var squared = 1;;) { break; } squared(1.0); } squared(2.0); }",
            "{ for (;;) { for (var squared = 1;;) { break; } real_squared(1.0); } real_squared(2.0); }",
        ),
        (
            "{ loop { let squared = 1; continuing { break if squared > 0; } } }",
            "{ loop { let squared = 1; continuing { break if squared > 0; } } }",
        ),
        (
            "{ switch 1 { case 1: { let squared = 1; } default: { squared(1.0); } } }",
            "{ switch 1 { case 1: { let squared = 1; } default: { real_squared(1.0); } } }",
        ),
        // Members are never renamed, values before the point are.
        (
            "{ let a = fresnel::dielectric(1.0, 2.0).squared; a.squared . squared; }",
            "{ let a = fresnel_dielectric(1.0, 2.0).squared; a.squared . squared; }",
        ),
        // A module's name is no value's name.
        (
            "{ let fresnel = fresnel::conductor(1.0); return fresnel + fresnel::conductor(fresnel); }",
            "{ let fresnel = fresnel_conductor(1.0); return fresnel + fresnel_conductor(fresnel); }",
        ),
        (
            "{ var<function> squared: array<vec3<f32>, 4>; squared[0]; }",
            "{ var<function> squared: array<vec3<f32>, 4>; squared[0]; }",
        ),
    ] {
        assert_eq!(root_part(&format!("{import}fn main() {body}")), format!("fn main() {want}"));
    }
    let parameter = "(squared: f32, x: array<f32, u32(squared(2.0))>) -> f32 { return squared; }";
    let want = "(squared: f32, x: array<f32, u32(real_squared(2.0))>) -> f32 { return squared; }";
    assert_eq!(root_part(&format!("{import}fn main{parameter}")), format!("fn main{want}"));
}

#[test]
fn scopes_hide_items_in_modules() {
    let modules =
        &[("m", "fn a(b: f32) -> f32 { let c = b + c(); return c; }\nfn b() {}\nfn c() -> f32 { return 1.0; }")];
    let out = link_item(modules, "m", "a").unwrap();
    assert_eq!(out, "fn m_a(b: f32) -> f32 { let c = b + m_c(); return c; }\nfn m_c() -> f32 { return 1.0; }\n");
}

#[test]
fn attributes_members_comments_templates_survive() {
    let root = "import brdf::real::{squared as position, TINY as off, LARGE as x};
/* a /* position */ x */
struct V { @builtin(position) @size(16) position: vec4<f32>, @location(0) @interpolate(flat) x: u32, y: array<f32, u32(x)> }
@group(0) @binding(0) var<storage, read_write> data: array<vec3<f32>, 4>;
@diagnostic(off, derivative_uniformity) @fragment
fn main(v: V) -> @location(0) vec4f { // position
    let p = position(v.position.x) >> 1u; if p >= off { return vec4f(p<x); } return array<vec2<vec2<f32>>>(x);
}
";
    let want = "
/* a /* position */ x */
struct V { @builtin(position) @size(16) position: vec4<f32>, @location(0) @interpolate(flat) x: u32, y: array<f32, u32(real_LARGE)> }
@group(0) @binding(0) var<storage, read_write> data: array<vec3<f32>, 4>;
@diagnostic(off, derivative_uniformity) @fragment
fn main(v: V) -> @location(0) vec4f { // position
    let p = real_squared(v.position.x) >> 1u; if p >= real_TINY { return vec4f(p<real_LARGE); } return array<vec2<vec2<f32>>>(real_LARGE);
}
";
    assert!(linked(root).ends_with(want), "{}", linked(root));
}

#[test]
fn unreached_items_are_dropped() {
    let out = linked("import brdf::{masking, fresnel::conductor};\nfn main() -> f32 { return brdf::real::TINY; }");
    assert!(!out.contains("fresnel") && !out.contains("masking") && !out.contains("LARGE") && !out.contains("squared"));
    assert_eq!(out.matches("real_TINY").count(), 3); // declaration, assertion, use
}

#[test]
fn the_embedding_shader_supplies_what_a_module_lacks() {
    let modules = &[("layered", "fn f(i: u32) -> f32 { return stack_layer(i) + abs(1.0); }")];
    let root = "fn stack_layer(i: u32) -> f32 { return 1.0; }\nfn main() { brdf::layered::f(1u); }";
    assert!(
        link_with(modules, root)
            .unwrap()
            .starts_with("fn layered_f(i: u32) -> f32 { return stack_layer(i) + abs(1.0); }")
    );
    assert_eq!(
        error(modules, "fn abs(x: f32) -> f32 { return x; }\nfn main() { brdf::layered::f(1u); }"),
        "root:1:4: root's `abs` redefines WGSL's, which brdf::layered::f uses; rename it"
    );
}

#[test]
fn modules_may_need_each_other() {
    let modules = &[
        ("z", "import package::a::f;\nfn g(i: i32) -> i32 { return f(i); }"),
        ("b", "fn h() {}"),
        ("a", "import super::z;\nfn f(i: i32) -> i32 { return z::g(i); }\nfn k() { super::b::h(); }"),
    ];
    assert_eq!(
        link_with(modules, "fn main() { brdf::a::f(1); brdf::a::k(); }").unwrap(),
        "fn b_h() {}\n\nfn z_g(i: i32) -> i32 { return a_f(i); }\n\nfn a_f(i: i32) -> i32 { return z_g(i); }\n\
         fn a_k() { b_h(); }\n\nfn main() { a_f(1); a_k(); }"
    );
}

#[test]
fn one_item_with_its_needs() {
    let out = link_item(LIBRARY, "fresnel", "conductor").unwrap();
    assert!(
        out.starts_with("const real_TINY")
            && out.ends_with("fn fresnel_conductor(c: f32) -> f32 { return real_squared(c); } // trailing\n")
    );
    let failed = |module, item| link_item(LIBRARY, module, item).unwrap_err().to_string();
    assert_eq!(
        failed("fresnell", "f"),
        "link_function: no module `fresnell`; did you mean `fresnel`? there are: fresnel, masking, real"
    );
    assert_eq!(
        failed("fresnel", "dielektric"),
        "link_function: no item `dielektric` in brdf::fresnel; did you mean `dielectric`? there are: Fresnel, conductor, dielectric"
    );
    assert_eq!(link_item(&[], "a", "b").unwrap_err().remedy, "there are none");
}

#[test]
fn errors_say_what_where_and_how() {
    for (root, want) in [
        (
            "import brdf::fresnell;",
            "root:1:14: no module `fresnell` in `brdf`; did you mean `fresnel`? there are: fresnel, masking, real",
        ),
        (
            "\nimport brdf::{real,\n  fresnel::{conductor, dielectrics}};",
            "root:3:24: no item `dielectrics` in brdf::fresnel; did you mean `dielectric`? there are: Fresnel, conductor, dielectric",
        ),
        (
            "fn main() {\n  brdf::fresnel::x();\n}",
            "root:2:3: no item `x` in brdf::fresnel; there are: Fresnel, conductor, dielectric",
        ),
        (
            "fn main() { fresnel::conductor(1.0); }",
            "root:1:13: `fresnel::conductor` does not begin in this library; add `import brdf::fresnel;`",
        ),
        (
            "fn main() { a::b(1.0); }",
            "root:1:13: `a::b` does not begin in this library; paths begin with an imported module or with `brdf::`",
        ),
        (
            "import package::fresnel;",
            "root:1:17: `package::fresnel` does not begin in this library; paths begin with an imported module or with `brdf::`",
        ),
        (
            "import brdf::fresnel::_half;",
            "root:1:23: `_half` is private to brdf::fresnel; use an item without a leading `_`",
        ),
        (
            "import brdf;",
            "root:1:8: `brdf` cannot be imported or renamed to; import a module or an item of it, and give it another name with `as`",
        ),
        (
            "import brdf::real as super;",
            "root:1:22: `super` cannot be imported or renamed to; import a module or an item of it, and give it another name with `as`",
        ),
        ("import brdf as b;", "root:1:8: `brdf` is the whole library; name a module of it"),
        (
            "import brdf::real::TINY::x;",
            "root:1:20: `brdf::real::TINY` is not a module; a path is package, module, item",
        ),
        (
            "fn f() { brdf::real::TINY::x(); }",
            "root:1:10: `TINY` in brdf::real is not a module; a path is package, module, item",
        ),
        (
            "import brdf::real::TINY;\nfn f() { TINY::x(); }",
            "root:2:10: `TINY` is an item, not a module; import its module",
        ),
        (
            "import brdf::real;\nfn f() { real(); }",
            "root:2:10: `real` is a module, not an item; name an item of it; there are: LARGE, TINY, squared",
        ),
        ("fn f() { let a = ::b; }", "root:1:18: `::` without a name on either side; write `module::item`"),
        (
            "import brdf::real::TINY;\nimport brdf::real::TINY;",
            "root:2:20: `TINY` is imported twice; drop one or rename the import with `as`",
        ),
        (
            "import brdf::real::TINY;\nfn TINY() {}",
            "root:1:20: `TINY` is imported and declared; drop one or rename the import with `as`",
        ),
        ("fn f() {}\nimport brdf::real;", "root:2:1: `import` after the first item; move it to the top"),
        ("fn f() {}\nenable f16;", "root:2:1: `enable` after the first item; move it to the top"),
        ("import brdf::real fn", "root:1:19: expected `;` after the import, found `fn`; correct the declaration"),
        ("import brdf::{real", "root:1:19: expected `,` or `}` in the import, the text ends; correct the declaration"),
        ("import brdf::real as ;", "root:1:22: expected a name after `as`, found `;`; correct the declaration"),
        (
            "#include <a>",
            "root:1:1: expected a declaration (fn, struct, const, alias, …), found `#`; correct the declaration",
        ),
        ("fn f() {\n  (1;\n}", "root:3:1: `}` closes nothing; balance the brackets"),
        ("fn f() {\n  if {", "root:1:8: `{` is never closed; balance the brackets"),
        ("const a = 1\n", "root:2:1: expected `;`, the text ends; correct the declaration"),
        ("fn f();", "root:1:8: expected the function's body, the text ends; correct the declaration"),
        ("struct S;", "root:1:9: expected `{` after the struct's name, found `;`; correct the declaration"),
        ("const a = 1; const a = 2;", "root:1:20: `a` is declared twice; rename one"),
        (" /* /* */", "root:1:2: a block comment never ends; close it with `*/`"),
        (
            "fn real_TINY() { brdf::real::TINY; }",
            "root:1:4: `real_TINY` in root is what brdf::real::TINY is called when linked; rename it, or import the item to use it",
        ),
        (
            "fn f() {\n let real_TINY = brdf::real::TINY; }",
            "root:2:6: `real_TINY` in root is what brdf::real::TINY is called when linked; rename it, or import the item to use it",
        ),
        (
            "fn f() { let a = real_TINY; brdf::real::TINY; }",
            "root:1:18: `real_TINY` in root is what brdf::real::TINY is called when linked; rename it, or import the item to use it",
        ),
    ] {
        assert_eq!(error(LIBRARY, root), want, "{root}");
    }
    // A member may have such a name, and so may anything while the item is not linked.
    linked("struct S { real_TINY: f32 }\nfn f(s: S) { s.real_TINY + brdf::real::TINY; }");
    linked("fn real_TINY() {}");
}

#[test]
fn modules_keep_the_rules() {
    for (module, want) in [
        ("@group(0) @binding(0) var<uniform> a: f32;", "brdf::m:1:23: a library module declares var"),
        ("override a = 1;", "brdf::m:1:1: a library module declares override"),
        ("\n@compute @workgroup_size(1) fn main() {}", "brdf::m:2:29: a library module declares an entry point"),
        ("enable f16;", "brdf::m:1:1: a library module has the directive `enable`"),
        ("import brdf::n;", "brdf::m:1:14: `brdf::n` does not begin in this library"),
        ("import super::n;", "brdf::m:1:15: no module `n` in `super`"),
        ("fn a() {}\nfn a() {}", "brdf::m:2:4: `a` is declared twice"),
    ] {
        let error = error(&[("m", module)], "");
        assert!(error.starts_with(want), "{error}");
    }
    let clash = &[("a", "fn b_c() {}"), ("a_b", "fn c() {}")];
    assert_eq!(
        error(clash, "fn f() { brdf::a::b_c(); brdf::a_b::c(); }"),
        "brdf::a_b:1:4: brdf::a_b::c and brdf::a::b_c are both `a_b_c` when linked; rename one"
    );
    let local = &[("a", "fn b() {}\nfn c() { let a_b = 1; b(); }")];
    assert!(
        error(local, "fn f() { brdf::a::c(); }")
            .starts_with("brdf::a:2:14: `a_b` in brdf::a is what brdf::a::b is called")
    );
}

#[test]
fn functions_are_listed_with_their_parameters() {
    let text = "fn a() {}\nfn _b(x: f32) {}\n@must_use fn c(@foo(1) x: array<vec3<f32>, 4>, y: package::m::T,) -> f32 { var z: f32; }\nconst d = 1;";
    let list: Vec<_> = functions_of("m", text).map(|f| (f.module, f.name, f.parameters)).collect();
    assert_eq!(list, [("m", "a", 0), ("m", "c", 2)]);
    assert_eq!(functions_of("m", "fn").count(), 0);
    assert_eq!(mangled("m", "a"), "m_a");
}

/// A generator of numbers for tests: xorshift.
fn next(state: &mut u64) -> usize {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    usize::try_from(*state >> 33).unwrap_or(0)
}

/// Links a text as a root and as a module; whatever it says, it must say it.
fn survives(text: &str) {
    let _ = link_with(LIBRARY, text).map_err(|error| error.to_string());
    let _ = link_with(&[("real", REAL), ("m", text)], "import brdf::m;\nfn f() { m::a(); }")
        .map_err(|error| error.to_string());
    let _ = functions_of("m", alloc::boxed::Box::leak(text.into())).count();
}

#[test]
fn no_text_panics() {
    let good = "// é\nimport brdf::{fresnel::{conductor as c}, real};\nenable f16;\n/* /* */ */ @fragment fn a(x: array<f32, 4>) -> \
        @location(0) vec4<f32> { for (var i = 0x1p-3f; i >= 1; i++) { let b = c(1.e+2).x; } }\nstruct S { real: real::T, }\nvar<private> s: S;\n";
    let prefixes: Vec<&str> = (0..=good.len()).filter_map(|end| good.get(..end)).collect();
    prefixes.iter().for_each(|prefix| survives(prefix));
    (0..=good.len()).filter_map(|start| good.get(start..)).for_each(survives);

    let pieces = [
        "import ",
        "brdf",
        "package",
        "super",
        "::",
        "{",
        "}",
        "(",
        ")",
        "[",
        "]",
        "<",
        ">",
        ";",
        ":",
        ",",
        ".",
        "@",
        "fn ",
        "struct ",
        "const ",
        "let ",
        "var",
        "for",
        "as ",
        "alias ",
        "const_assert ",
        "enable ",
        "real",
        "fresnel",
        "TINY",
        "conductor",
        "a",
        "_",
        "1",
        "0x",
        ".5",
        "e+",
        "/*",
        "*/",
        "//",
        "\n",
        "\r",
        "\u{2028}",
        "é",
        "\u{301}",
        "\0",
        "😀",
        "\\",
        "\"",
        "'",
        "#",
        "compute",
        "builtin",
        "=",
        "fn a() {",
        "import brdf::{",
    ];
    let mut state = 0x9e37_79b9_7f4a_7c15;
    for _ in 0..6_000 {
        let length = next(&mut state) % 24;
        let text: String = (0..length).map(|_| pieces[next(&mut state) % pieces.len()]).collect();
        survives(&text);
        let bytes: Vec<u8> = (0..length).map(|_| (next(&mut state) % 256) as u8).collect();
        survives(&String::from_utf8_lossy(&bytes));
    }
    // Nearly right: a few tokens of a good text dropped or replaced.
    let spans = token::tokens(good).unwrap();
    for _ in 0..6_000 {
        let mut text = good.to_owned();
        let (first, count) = (next(&mut state) % spans.len(), 1 + next(&mut state) % 3);
        let last = spans[(first + count).min(spans.len()) - 1];
        let piece = if next(&mut state) < 1 << 29 { "" } else { pieces[next(&mut state) % pieces.len()] };
        text.replace_range(spans[first].start..last.end, piece);
        survives(&text);
    }
    for deep in ["import brdf::{", "import a::{a::{a::{", "fn a(){((((", "{", "(", "/*", "a::", "<", "@a("] {
        survives(&deep.repeat(20_000));
        survives(&format!("fn a() {{ {} }}", deep.repeat(20_000)));
        survives(&format!("import {};", deep.repeat(20_000)));
    }
}

#[test]
fn the_librarys_modules_keep_its_rules() {
    for &(module, text) in MODULES {
        assert_eq!(source(module), Some(text));
        let unit = Unit::parse(Some(module), text).unwrap_or_else(|error| panic!("{error}"));
        let ends_in_digit = |name: &str| name.ends_with(|c: char| c.is_ascii_digit());
        for item in &unit.items {
            assert!(!ends_in_digit(item.name), "{module}::{} ends in a digit", item.name);
            assert!(!item.is_entry_point, "{module}::{} is an entry point", item.name);
            for at in item.tokens.clone() {
                let word = unit.token(at);
                let is_member = item.kind == Kind::Struct && unit.is(at + 1, ":");
                assert!(!(is_member && ends_in_digit(word)), "{module}::{}.{word} ends in a digit", item.name);
                let is_call = unit.word(at).is_some() && unit.is(at + 1, "(");
                let inexact = ["pow", "sin", "cos", "tan", "asin", "acos", "atan", "atan2"].contains(&word);
                assert!(!(is_call && inexact), "{module}::{} calls {word}", item.name);
                assert!(!(word == "@" && unit.is(at + 1, "group")), "{module}::{} is a binding", item.name);
            }
        }
    }
    assert_eq!(source("no_such_module"), None);
    for function in functions() {
        link_function(function.module, function.name).unwrap_or_else(|error| panic!("{error}"));
    }
}

#[test]
fn an_empty_library_links() {
    assert_eq!(link("fn f() {}").unwrap(), "fn f() {}");
    let error: LinkError = link("import brdf::no_such_module;").unwrap_err();
    assert_eq!((error.place.as_str(), error.position), ("root", Some((1, 14))));
    assert!(core::error::Error::source(&error).is_none());
    assert_eq!(token::tokens("").unwrap().len(), 0);
}
