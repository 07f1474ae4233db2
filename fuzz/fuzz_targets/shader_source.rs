//! Shader files of any content, by the rules of both languages: an error or a family whose members evaluate, and never a
//! panic or an endless run.

#![no_main]

use brdf::check::Family;
use brdf::check::shader::{Language, Options, ShaderFamily};
use brdf::frame::Vector;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let (first, rest) = data.split_first().unwrap_or((&0, &[]));
    let text = String::from_utf8_lossy(rest);
    for language in [Language::Wgsl, Language::Glsl] {
        let mut options = Options { language: Some(language), function: "f".into(), ..Options::default() };
        if first % 2 == 1 {
            options.defines = vec!["A=1".into(), "F=f".into()];
            options.values = vec!["x=0.5".into()];
        }
        if let Ok(family) = ShaderFamily::from_source("fuzzed", &text, &options) {
            let subject = family.subject(&[]);
            let mut f = vec![0.0; subject.channels()];
            subject.evaluate(Vector::new(0.6, 0.0, 0.8), Vector::new(0.0, 0.6, 0.8), &mut f);
        }
    }
});
