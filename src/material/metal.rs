//! Indices of refraction of metals and their oxides, n + iκ against vacuum at three wavelengths.
//!
//! `_elek` are the values of Elek 2010, App. A. All others are Johnson & Christy 1972/1974 and (aluminium) Rakić 1995, read from the
//! refractiveindex.info database (CC0).

/// The index of a material at the wavelengths that stand for red, green and blue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metal {
    /// The name that stack files use.
    pub name: &'static str,
    /// The real part n for red, green and blue.
    pub n: [f64; 3],
    /// The imaginary part κ for red, green and blue.
    pub k: [f64; 3],
    /// The wavelengths of the three channels in nanometres.
    pub wavelengths: [f64; 3],
    /// Where the values come from.
    pub source: &'static str,
}

/// The metal of this name.
pub fn by_name(name: &str) -> Option<&'static Metal> {
    METALS.iter().find(|metal| metal.name == name)
}

/// The documents' wavelengths.
const DOCUMENTS: [f64; 3] = [690.0, 550.0, 450.0];
/// Wavelengths close to the primaries of today's wide-gamut displays.
const DISPLAY: [f64; 3] = [630.0, 532.0, 465.0];

const ELEK: &str = "Elek 2010, App. A";
const JC: &str = "Johnson & Christy, by refractiveindex.info (CC0)";
const RAKIC: &str = "Rakić 1995, by refractiveindex.info (CC0)";

const fn metal(name: &'static str, [r, g, b]: [(f64, f64); 3], wavelengths: [f64; 3], source: &'static str) -> Metal {
    Metal { name, n: [r.0, g.0, b.0], k: [r.1, g.1, b.1], wavelengths, source }
}

/// Every built-in index.
#[rustfmt::skip]
pub const METALS: &[Metal] = &[
    metal("copper", [(0.213, 4.057), (1.007, 2.582), (1.240, 2.393)], DOCUMENTS, JC),
    metal("gold", [(0.133, 3.972), (0.424, 2.472), (1.383, 1.915)], DOCUMENTS, JC),
    metal("silver", [(0.043, 4.724), (0.060, 3.597), (0.040, 2.648)], DOCUMENTS, JC),
    metal("aluminium", [(1.840, 8.069), (1.015, 6.627), (0.633, 5.454)], DOCUMENTS, RAKIC),
    metal("chromium", [(3.062, 3.374), (3.181, 3.329), (2.323, 3.135)], DOCUMENTS, JC),
    metal("iron", [(2.879, 3.162), (2.950, 2.932), (2.584, 2.767)], DOCUMENTS, JC),
    metal("titanium", [(2.829, 3.923), (2.542, 3.435), (2.267, 3.038)], DOCUMENTS, JC),
    metal("copper_elek", [(0.213, 4.05), (1.04, 2.59), (1.17, 2.36)], DOCUMENTS, ELEK),
    metal("chromium_elek", [(3.84, 4.37), (3.18, 4.41), (1.99, 4.22)], DOCUMENTS, ELEK),
    metal("cuprite_elek", [(2.83, 0.083), (3.10, 0.19), (3.06, 0.6)], DOCUMENTS, ELEK),
    metal("copper_630_532_465", [(0.275, 3.373), (1.116, 2.596), (1.247, 2.456)], DISPLAY, JC),
    metal("gold_630_532_465", [(0.188, 3.403), (0.544, 2.231), (1.332, 1.869)], DISPLAY, JC),
    metal("silver_630_532_465", [(0.057, 4.254), (0.054, 3.429), (0.047, 2.803)], DISPLAY, JC),
    metal("aluminium_630_532_465", [(1.430, 7.508), (0.939, 6.420), (0.686, 5.635)], DISPLAY, RAKIC),
    metal("chromium_630_532_465", [(3.145, 3.312), (3.034, 3.330), (2.456, 3.210)], DISPLAY, JC),
    metal("iron_630_532_465", [(2.892, 3.065), (2.895, 2.918), (2.646, 2.805)], DISPLAY, JC),
    metal("titanium_630_532_465", [(2.698, 3.757), (2.479, 3.351), (2.305, 3.082)], DISPLAY, JC),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_values_in_the_domain() {
        for (i, metal) in METALS.iter().enumerate() {
            assert!(METALS[..i].iter().all(|other| other.name != metal.name), "{}", metal.name);
            assert!(metal.n.iter().chain(&metal.k).all(|v| *v > 0.0), "{}", metal.name);
            assert_eq!(by_name(metal.name), Some(metal));
        }
        assert_eq!(by_name("unobtainium"), None);
    }
}
