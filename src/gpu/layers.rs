//! The layers of stacks in the storage buffer that the twins of [`crate::layered`] read.

use crate::layered::{Interface, Layer};

/// The WGSL that binds a storage buffer of layers and supplies `stack_layer` to the module `layered`.
pub const STACK_BINDINGS: &str = "\
@group(0) @binding(3) var<storage, read> stack_layers: array<layered_Layer>;
fn stack_layer(index: u32) -> layered_Layer {
    return stack_layers[index];
}
";

/// A layer as `layered::Layer` holds it in WGSL: 16 words, four rows of a vector and a scalar.
pub fn layer_words(layer: &Layer<f32, 3>) -> [u32; 16] {
    let (n, k, albedo, alpha, deviation, kind) = match layer.interface {
        Interface::Microfacet { n, k, alpha } => (n, k, [0.0; 3], alpha, 0.0, 0),
        Interface::Diffuse { albedo, sigma } => ([1.0; 3], [0.0; 3], albedo, 1.0, sigma, 1),
    };
    let row = |v: [f32; 3], last: u32| [v[0].to_bits(), v[1].to_bits(), v[2].to_bits(), last];
    let rows = [
        row(n, alpha.to_bits()),
        row(k, kind),
        row(albedo, deviation.to_bits()),
        row(layer.medium.sigma, layer.medium.thickness.to_bits()),
    ];
    let mut words = [0; 16];
    for (word, value) in words.iter_mut().zip(rows.into_iter().flatten()) {
        *word = value;
    }
    words
}

/// The bytes of a storage buffer that holds these layers.
pub fn layer_bytes<'a>(layers: impl IntoIterator<Item = &'a Layer<f32, 3>>) -> Vec<u8> {
    layers.into_iter().flat_map(layer_words).flat_map(u32::to_ne_bytes).collect()
}
