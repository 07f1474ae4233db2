//! The layers of stacks in the storage buffer that the twins of [`crate::layered`] read.

use crate::layered::{BufferLayer, Layer};

/// The WGSL that binds a storage buffer of layers and supplies `stack_layer` to the module `layered`.
pub const STACK_BINDINGS: &str = "\
@group(0) @binding(3) var<storage, read> stack_layers: array<layered_Layer>;
fn stack_layer(index: u32) -> layered_Layer {
    return stack_layers[index];
}
";

/// The bytes of a storage buffer that holds these layers.
pub fn layer_bytes<'a>(layers: impl IntoIterator<Item = &'a Layer<f32, 3>>) -> Vec<u8> {
    let layers: Vec<BufferLayer> = layers.into_iter().map(BufferLayer::from).collect();
    bytemuck::cast_slice(&layers).to_vec()
}
