//! Stack files, as any text and as fragments of real ones: read, or refused in one line that says where.

#![no_main]

use arbitrary::{Arbitrary, Unstructured};
use brdf::layered::description::Description;
use libfuzzer_sys::fuzz_target;

const FRAGMENTS: [&str; 32] = [
    "[[layer]]\n", "[layer]\n", "interface = ", "medium = ", "dielectric", "conductor", "diffuse", "alpha", "n", "k",
    "metal", "albedo", "sigma", "thickness", " = ", "{ ", " }", "[", "]", ", ", "\n", "1.5", "0.1", "-1", "nan", "inf",
    "1e999", "\"copper\"", "model = \"coupled\"\n", "widths = \"variance\"\n", "name = 'x'\n",
    "interface = { dielectric = { n = 1.5 }, alpha = 0.1 }\n",
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
    match Description::from_toml(&text) {
        Ok(description) => {
            // What was read is a stack: only the number of channels may still be wrong.
            let stack = match description.channels() {
                1 => description.stack::<f64, 1>().map(drop),
                3 => description.stack::<f64, 3>().map(drop),
                _ => return,
            };
            assert!(stack.is_ok(), "{text:?}: {stack:?}");
        }
        Err(error) => {
            let line = error.to_string();
            assert!(!line.is_empty() && !line.contains('\n'), "{text:?}: {line:?}");
        }
    }
});
