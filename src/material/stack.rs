//! The built-in stacks.

use super::metal;
use crate::layered::{Interface, Layer, Model, Stack};
use alloc::vec;
use alloc::vec::Vec;

/// A built-in stack of three channels under its name.
#[derive(Clone, Debug, PartialEq)]
pub struct BuiltIn {
    /// The name that the command line uses.
    pub name: &'static str,
    /// What it stands for.
    pub about: &'static str,
    /// The layers, under the model `conserving`.
    pub stack: Stack<f64, 3>,
}

/// Every built-in stack.
pub fn built_in() -> Vec<BuiltIn> {
    let mut all = Vec::new();
    let mut add = |name, about, layers| {
        // Each of the stacks below is valid, which a test asserts.
        if let Ok(stack) = Stack::new(Model::Conserving, layers) {
            all.push(BuiltIn { name, about, stack });
        }
    };
    for (name, about, metal, alpha) in BARE_METALS {
        add(name, about, vec![conductor(metal, alpha)]);
    }
    add("glass", "a rough dielectric", vec![dielectric(1.5, 0.1)]);
    add("clear_coat_over_copper", "a clear coat over copper", vec![dielectric(1.5, 0.1), conductor("copper", 0.3)]);
    add(
        "cuprite_over_copper",
        "the documents' patina: Cu₂O over Cu (Elek 2010, §4.2)",
        vec![conductor("cuprite_elek", 0.3).over([0.15, 0.6, 0.9], 0.5), conductor("copper_elek", 0.2)],
    );
    add(
        "tinted_coat_over_chromium",
        "the documents' metallic paint: a tinted coat over Cr (Elek 2010, §4.1)",
        vec![dielectric(1.5, 0.05).over([0.15, 1.2, 1.6], 0.4), conductor("chromium_elek", 0.3)],
    );
    add(
        "varnish_over_concrete",
        "a blue varnish over an Oren–Nayar base (Elek 2010, fig. 10)",
        vec![dielectric(1.5, 0.1).over([1.4, 0.7, 0.1], 0.3), Layer::new(Interface::diffuse([0.55, 0.53, 0.5], 0.5))],
    );
    add(
        "three_layer_lacquer",
        "a smooth clear coat over a tinted lacquer over aluminium",
        vec![dielectric(1.5, 0.02), dielectric(1.55, 0.15).over([0.1, 0.8, 2.0], 0.5), conductor("aluminium", 0.25)],
    );
    add(
        "open_pbr_carpaint",
        "red paint after OpenPBR's carpaint: a smooth coat over a rough coat over a diffuse base, both of index 1.6",
        vec![dielectric(1.6, 0.02), dielectric(1.6, 0.3), Layer::new(Interface::diffuse([0.1, 0.6, 0.9], 0.0))],
    );
    add(
        "coated_gold",
        "gold under a thin smooth coat (after pbrt-v4-scenes)",
        vec![dielectric(1.5, 0.02), conductor("gold", 0.002)],
    );
    add(
        "clear_coat_over_diffuse",
        "a diffuse base of .7 under a smooth coat (after pbrt-v4-scenes, BMW M6)",
        vec![dielectric(1.5, 0.02), Layer::new(Interface::diffuse([0.7; 3], 0.0))],
    );
    all
}

/// The built-in stack of this name.
pub fn by_name(name: &str) -> Option<Stack<f64, 3>> {
    built_in().into_iter().find(|material| material.name == name).map(|material| material.stack)
}

const BARE_METALS: [(&str, &str, &str, f64); 7] = [
    ("copper", "bare copper", "copper", 0.2),
    ("gold", "bare gold", "gold", 0.1),
    ("silver", "bare silver", "silver", 0.05),
    ("aluminium", "brushed-bright aluminium", "aluminium", 0.3),
    ("chromium", "polished chromium", "chromium", 0.02),
    ("iron", "bare iron", "iron", 0.4),
    ("titanium", "bare titanium", "titanium", 0.5),
];

fn dielectric(n: f64, alpha: f64) -> Layer<f64, 3> {
    Layer::new(Interface::dielectric(n, alpha))
}

fn conductor(metal: &str, alpha: f64) -> Layer<f64, 3> {
    // An unknown name would give an index that Stack::new refuses, and so a missing stack in the test below.
    let (n, k) = metal::by_name(metal).map_or(([0.0; 3], [0.0; 3]), |metal| (metal.n, metal.k));
    Layer::new(Interface::conductor(n, k, alpha))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stack_is_valid() {
        let all = built_in();
        assert_eq!(all.len(), BARE_METALS.len() + 9);
        for (i, material) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|other| other.name != material.name), "{}", material.name);
            assert_eq!(by_name(material.name).as_ref(), Some(&material.stack));
            // One name, one thing.
            assert!(crate::material::built_in::by_name(material.name).is_none(), "{}", material.name);
        }
    }
}
