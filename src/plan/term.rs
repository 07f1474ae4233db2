//! What is left of a stack: the terms of a plan, for people and programs to read.

use super::chain::{Chain, Stage, Surface, Way};
#[cfg(feature = "std")]
use super::cost::{Operations, Path};
use super::{Chains, Plan};
use crate::layered::Model;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt::Write as _;

/// A step of every evaluation of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// What it computes: one of [`Term::NAMES`].
    pub name: &'static str,
    /// The layer that it is of, counted from the top, from 0.
    pub layer: usize,
    /// The channel that it is computed for; none where it is for all at once.
    pub channel: Option<usize>,
    /// The same in words, with its numbers.
    pub about: String,
    /// For each [`Path`].
    #[cfg(feature = "std")]
    operations: [Operations; 3],
}

impl Term {
    /// The name of every term.
    pub const NAMES: [&'static str; 13] = [
        "directions",
        "reflect_dielectric",
        "reflect_any_dielectric",
        "reflect_metal",
        "reflect_conductor",
        "reflect_any_conductor",
        "reflect_fit",
        "pass_dielectric",
        "pass_conductor",
        "pass_fit",
        "absorb",
        "lambert",
        "oren_nayar",
    ];

    /// What it does in one evaluation on this path.
    #[cfg(feature = "std")]
    pub fn operations(&self, path: Path) -> Operations {
        self.operations[path as usize]
    }
}

impl<const C: usize> Plan<C> {
    /// The terms of an evaluation, from the top; channel by channel where the channels' directions differ.
    pub fn terms(&self) -> impl Iterator<Item = Term> + use<C> {
        let terms = match self.chains() {
            Chains::Together(chain) => terms(chain, None),
            Chains::Apart(chains) => chains.iter().enumerate().flat_map(|(c, chain)| terms(chain, Some(c))).collect(),
        };
        terms.into_iter()
    }
}

fn terms<const K: usize>(chain: &Chain<K>, channel: Option<usize>) -> Vec<Term> {
    #[cfg(feature = "std")]
    let operations = [Path::Scalar, Path::Batch, Path::FusedBatch].map(|path| chain.operations(path));
    let first = ("directions", 0, String::from("the half vector's tan², and (V·H)²"));
    let stages = chain.stages.iter().zip(&chain.layers).map(|(stage, layer)| {
        let (name, about) = describe(stage);
        (name, *layer, about)
    });
    let term = |(_index, (name, layer, about)): (usize, (&'static str, usize, String))| Term {
        name,
        layer,
        channel,
        about,
        #[cfg(feature = "std")]
        operations: [0, 1, 2].map(|path: usize| operations[path][_index]),
    };
    core::iter::once(first).chain(stages).enumerate().map(term).collect()
}

/// The name of a stage and what it does.
fn describe<const K: usize>(stage: &Stage<K>) -> (&'static str, String) {
    match stage {
        Stage::Reflect { lobe, surface } => {
            let (name, fresnel) = match surface {
                Surface::Dielectric(one) => ("reflect_dielectric", format!("dielectric, n {}", list([one.eta()]))),
                Surface::AnyDielectric(one) => {
                    ("reflect_any_dielectric", format!("dielectric of any index, n {}", list([one.eta])))
                }
                Surface::GreyMetal(one) => (
                    "reflect_metal",
                    format!("metal, one for all channels, {}", complex([one.0.indices(lobe.n_above)])),
                ),
                Surface::Metals(each) => {
                    ("reflect_metal", format!("metal, {}", complex(each.0.map(|one| one.indices(lobe.n_above)))))
                }
                Surface::Conductors(each) => (
                    "reflect_conductor",
                    format!("conductor, {}", complex(each.0.map(|one| one.indices(lobe.n_above)))),
                ),
                Surface::AnyConductors(each) => {
                    let indices = each.0.map(|one| (one.eta, one.kappa));
                    ("reflect_any_conductor", format!("conductor of any index, {}", complex(indices)))
                }
                Surface::Fit8(fit) => ("reflect_fit", fitted(8, fit.fit.max_error)),
                Surface::Fit10(fit) => ("reflect_fit", fitted(10, fit.fit.max_error)),
                Surface::Fit12(fit) => ("reflect_fit", fitted(12, fit.fit.max_error)),
            };
            (name, format!("Beckmann's lobe, α {}; F of a {fresnel}", list([lobe.alpha()])))
        }
        Stage::Pass { way, model, .. } => {
            let (name, fresnel) = match way {
                Way::Dielectric(one) => ("pass_dielectric", format!("dielectric, n {}", list([one.eta()]))),
                Way::AnyDielectric(one) => {
                    ("pass_dielectric", format!("dielectric of any index, n {}", list([one.eta])))
                }
                Way::AnyConductors(each) => {
                    ("pass_conductor", format!("conductor, {}", complex(each.0.map(|one| (one.eta, one.kappa)))))
                }
                Way::Fit8(fit) => ("pass_fit", fitted(8, fit.fit.max_error)),
                Way::Fit10(fit) => ("pass_fit", fitted(10, fit.fit.max_error)),
                Way::Fit12(fit) => ("pass_fit", fitted(12, fit.fit.max_error)),
            };
            let about = match model {
                Model::Elek => "T and t at V·H, refraction about the normal",
                Model::WeidlichWilkie => "T and t at V·H, refraction about the half vector",
                _ => "T of both directions, refraction about the normal",
            };
            (name, format!("{about}; {fresnel}"))
        }
        Stage::Absorb(medium) => ("absorb", format!("e to the path's depth, n·σd {}", list(medium.depth))),
        Stage::Lambert(base) => ("lambert", format!("Lambert's constant, albedo {}", list(base.albedo))),
        Stage::OrenNayar { base, .. } => {
            ("oren_nayar", format!("Oren and Nayar's base, albedo {}, σ {}", list(base.albedo), list([base.sigma])))
        }
    }
}

fn fitted<const K: usize>(coefficients: usize, max_error: [f64; K]) -> String {
    let most = max_error.iter().fold(0.0f64, |most, error| most.max(*error));
    format!("conductor, fitted by {coefficients} coefficients, off by {most:.1e} at most")
}

/// A number to six digits, without trailing zeros.
fn number(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

fn list<const K: usize>(numbers: [f64; K]) -> String {
    let mut text = String::new();
    for (i, x) in numbers.into_iter().enumerate() {
        // Writing to a String does not fail.
        let _ = write!(text, "{}{}", if i > 0 { ", " } else { "" }, number(x));
    }
    text
}

fn complex<const K: usize>(indices: [(f64, f64); K]) -> String {
    format!("n {}, κ {}", list(indices.map(|(n, _)| n)), list(indices.map(|(_, k)| k)))
}
