//! MERL files and what kind of file bytes are: any bytes, whole files with holes, and any pair of directions. Read or refused
//! in one line; a bin that exists and that swapping the directions keeps.

#![no_main]

use arbitrary::{Arbitrary, Unstructured};
use brdf::Vector;
use brdf::check::merl::{BINS, DIMENSIONS, LENGTH, Merl, bin};
use brdf::check::sniff::sniff;
use brdf::check::Subject;
use libfuzzer_sys::fuzz_target;

fn vector(source: &mut Unstructured<'_>) -> Vector<f64> {
    let mut number = || f64::arbitrary(source).unwrap_or(0.5);
    let (v, unit) = (Vector::new(number(), number(), number()), Vector::from_angles(number(), number()));
    if number() > 0.0 { v } else { unit }
}

/// A whole file, with numbers put where the bytes say, cut or gone on where they say.
fn file(source: &mut Unstructured<'_>) -> Vec<u8> {
    let mut bytes: Vec<u8> = DIMENSIONS.iter().flat_map(|d| (*d as i32).to_le_bytes()).collect();
    bytes.resize(LENGTH, 0);
    for _ in 0..u8::arbitrary(source).unwrap_or(0) % 8 {
        let at = 8 * (u32::arbitrary(source).unwrap_or(0) as usize % (3 * BINS)) + 12;
        let value = f64::arbitrary(source).unwrap_or(f64::NAN);
        bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
    }
    match u8::arbitrary(source).unwrap_or(0) % 4 {
        0 => bytes.truncate(u32::arbitrary(source).unwrap_or(0) as usize % LENGTH),
        1 => bytes.extend_from_slice(source.peek_bytes(source.len()).unwrap_or(&[1])),
        _ => {}
    }
    bytes
}

fuzz_target!(|data: &[u8]| {
    if let Err(refused) = sniff(data) {
        assert!(!refused.to_string().contains('\n'));
    }
    if let Err(error) = Merl::parse("bytes", data) {
        assert!(error.to_string().starts_with("byte ") && !error.to_string().contains('\n'));
    }
    let mut source = Unstructured::new(data);
    let whole = u8::arbitrary(&mut source).unwrap_or(1) % 64 == 0;
    let (wi, wo) = (vector(&mut source), vector(&mut source));
    let at = bin(wi, wo);
    assert!(at.iter().zip(DIMENSIONS).all(|(i, n)| *i < n));
    assert_eq!(at, bin(wo, wi));
    if whole {
        let bytes = file(&mut source);
        let _ = sniff(&bytes);
        match Merl::parse("file", &bytes) {
            Ok(read) => {
                assert_eq!(bytes.len(), LENGTH);
                let mut f = [f64::NAN; 3];
                read.evaluate(wi, wo, &mut f);
                assert!(f.iter().all(|f| *f >= 0.0));
            }
            Err(error) => assert!(error.to_string().starts_with("byte ")),
        }
    }
});
