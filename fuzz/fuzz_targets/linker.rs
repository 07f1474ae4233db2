//! The WGSL linker over any text and fragments of real shaders: an error, or text that names no import; and where the root
//! itself is valid, the result is.

#![no_main]

use arbitrary::{Arbitrary, Unstructured};
use brdf::shader::Module;
use libfuzzer_sys::fuzz_target;

const FRAGMENTS: [&str; 32] = [
    "import ", "brdf::", "package::", "fresnel", "distribution", "::", "ggx", "{", "}", ", ", ";", "\n", " as ",
    "fn f() -> f32 { return ", "ggx(vec3f(0.0, 0.0, 1.0), 0.3)", "fresnel::dielectric(0.5, 1.5).reflectance", "; }\n",
    "const a = 1.0;\n", "struct S { a: f32, }\n", "/*", "*/", "//", "@group(0) @binding(0) ", "var<private> x: f32;\n",
    "layered::conserving", "fn stack_layer(index: u32) -> layered::Layer { return layered::Layer(); }\n",
    "import brdf::fresnel;\n", "import brdf::distribution::ggx;\n", "import brdf::layered;\n", "\"", "é", "\u{0}",
];

fn text(data: &[u8]) -> String {
    let mut source = Unstructured::new(data);
    if bool::arbitrary(&mut source).unwrap_or(false) {
        return String::from_utf8_lossy(source.take_rest()).into_owned();
    }
    let mut text = String::new();
    while let (false, Ok(index)) = (source.is_empty(), u8::arbitrary(&mut source)) {
        text.push_str(FRAGMENTS[usize::from(index) % FRAGMENTS.len()]);
    }
    text
}

fuzz_target!(|data: &[u8]| {
    let text = text(data);
    let Ok(linked) = brdf::wgsl::link(&text) else { return };
    if !text.contains("import") && Module::parse(&text).is_ok() {
        assert!(Module::parse(&linked).is_ok(), "{text:?} became {linked:?}");
    }
    // Any other function of the module may be asked for too.
    let _ = brdf::wgsl::link_with(&[("mine", &text)], "import mine;\nfn f() -> f32 { return mine::f(); }");
});
