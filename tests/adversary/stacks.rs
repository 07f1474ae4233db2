//! Stacks and pairs of directions from genes.

use brdf::Vector;
use brdf::layered::{Interface, Layer};
use std::f64::consts::PI;

/// Genes of a layer.
const LAYER: usize = 7;
/// Genes of a stack of at most four layers.
pub(crate) const STACK: usize = 2 + 4 * LAYER;
/// Genes of a pair of directions.
pub(crate) const PAIR: usize = 6;

/// From `low` to `high`, uniform in the logarithm.
pub(crate) fn decades(gene: f64, low: f64, high: f64) -> f64 {
    (low * (high / low).powf(gene)).clamp(low, high)
}

/// 0 for the first quarter of the genes, else from `low` to `high` by decades.
pub(crate) fn zero_or_decades(gene: f64, low: f64, high: f64) -> f64 {
    if gene < 0.25 { 0.0 } else { decades((gene - 0.25) / 0.75, low, high) }
}

/// Near 1 on either side, or anywhere in a stack's range.
fn index(gene: f64) -> f64 {
    match gene * 4.0 {
        g if g < 1.0 => 1.0 + decades(g, 1e-9, 1.0),
        g if g < 2.0 => 1.0 - decades(g - 1.0, 1e-9, 0.5),
        g => decades(0.5 * (g - 2.0), 1e-3, 1e3),
    }
}

/// A stack of one to four layers over all that a stack allows, of two channels that may disperse.
pub(crate) fn stack(genes: &[f64]) -> Vec<Layer<f64, 2>> {
    let covers = ((genes[0] * 4.0) as usize).min(3);
    let mut layers: Vec<_> = genes[2..].chunks(LAYER).take(covers + 1).map(layer).collect();
    if let Some(base) = layers.last_mut().filter(|_| genes[1] < 0.5) {
        let g = &genes[2 + LAYER * covers..];
        *base = Layer::new(Interface::diffuse([g[0], 1.0], zero_or_decades(g[2], 1e-6, 1.57)));
    }
    layers
}

fn layer(g: &[f64]) -> Layer<f64, 2> {
    let n = index(g[0]);
    let other = if g[5] < 0.5 { n } else { (n * (1.0 + decades(2.0 * g[5] - 1.0, 1e-9, 1.0))).min(1e3) };
    let k = zero_or_decades(g[1], 1e-9, 1e3);
    let sigma = zero_or_decades(g[3], 1e-6, 1e3);
    let interface = Interface::conductor([n, other], [k, 0.5 * k], decades(g[2], 1e-4, 1.0));
    Layer::new(interface).over([sigma, g[6] * sigma], decades(g[4], 1e-6, 10.0))
}

fn polar(cos: f64, turn: f64) -> Vector<f64> {
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    let phi = 2.0 * PI * turn;
    Vector::new(sin * phi.cos(), sin * phi.sin(), cos)
}

/// A cosine in [1e-9, 1], by decades towards both ends.
pub(crate) fn cosine(gene: f64) -> f64 {
    if gene < 0.7 { decades(gene / 0.7, 1e-9, 1.0) } else { 1.0 - decades((gene - 0.7) / 0.3, 1e-9, 0.5) }
}

/// Two directions above the horizon: independent, of one height, or mirrored about a normal near the macro normal.
pub(crate) fn pair(genes: &[f64]) -> [Vector<f64>; 2] {
    let wi = polar(cosine(genes[0]), genes[1]);
    let wo = match genes[4] * 3.0 {
        g if g < 1.0 => polar(cosine(genes[2]), genes[3]),
        g if g < 2.0 => polar(wi.z, genes[3]),
        _ => {
            let tan = decades(genes[5], 1e-6, 10.0);
            let h = Vector::new(tan * (2.0 * PI * genes[3]).cos(), tan * (2.0 * PI * genes[3]).sin(), 1.0).normalized();
            let mirrored = h * (2.0 * wi.dot(h)) - wi;
            if mirrored.z > 0.0 { mirrored.normalized() } else { polar(cosine(genes[2]), genes[3]) }
        }
    };
    [wi, wo]
}
