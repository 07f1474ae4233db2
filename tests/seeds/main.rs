//! The errata of the two documents that this crate grew from, as code.
//!
//! Each printed form is implemented as printed, its consequence measured, and the measurement held against the number
//! that the project's formula notes give. `docs/errata.md` is written from the same records:
//!
//! ```sh
//! BRDF_BLESS=1 cargo test --features check --test seeds
//! ```
//!
//! E is Elek, "Layered Materials in Real-Time Rendering" (2010); M is Mihaylov, "Rendering Metals and Worn or Weathered Metallic Objects" (2013).
#![cfg(feature = "check")]

mod elek;
mod integrate;
mod layered;
mod mihaylov;
mod record;
mod reference;
mod single;
mod tables;

/// A test for each erratum, so that a failure names it.
macro_rules! errata {
    ($($name:ident $number:literal),+ $(,)?) => {$(
        #[test]
        fn $name() {
            record::assert_holds($number);
        }
    )+};
}

errata! {
    erratum_01 1, erratum_02 2, erratum_03 3, erratum_04 4, erratum_05 5, erratum_06 6, erratum_07 7, erratum_08 8,
    erratum_09 9, erratum_10 10, erratum_11 11, erratum_12 12, erratum_13 13, erratum_14 14, erratum_15 15,
    erratum_16 16, erratum_17 17, erratum_18 18, erratum_19 19, erratum_20 20, erratum_21 21, erratum_22 22,
    erratum_23 23, erratum_24 24, erratum_25 25,
}

#[test]
fn the_records_are_numbered_1_to_25() {
    let numbers: Vec<usize> = record::all().iter().map(|erratum| erratum.number).collect();
    assert_eq!(numbers, (1..=25).collect::<Vec<_>>());
}

#[test]
fn the_document_is_what_the_records_say() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/errata.md");
    let generated = record::document();
    if std::env::var_os("BRDF_BLESS").is_some_and(|value| value == "1") {
        std::fs::create_dir_all(concat!(env!("CARGO_MANIFEST_DIR"), "/docs")).expect("docs/ can be made");
        std::fs::write(path, generated).expect("docs/errata.md can be written");
        return;
    }
    let found = std::fs::read_to_string(path).unwrap_or_default().replace("\r\n", "\n");
    if let Some((line, (found, generated))) =
        found.lines().zip(generated.lines()).enumerate().find(|(_, (found, generated))| found != generated)
    {
        panic!("docs/errata.md, line {}:\n  found     {found}\n  generated {generated}\n{}", line + 1, record::COMMAND);
    }
    assert_eq!(found.len(), generated.len(), "docs/errata.md ends elsewhere; {}", record::COMMAND);
}
