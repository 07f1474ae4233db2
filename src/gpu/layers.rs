//! Stacks in the storage buffers that the twins of [`crate::layered`] read.

use crate::layered::{BufferLayer, Coupled, Layer, Model, Stack};

/// The WGSL that binds a storage buffer of layers and supplies `stack_layer` to the module `layered`.
pub const STACK_BINDINGS: &str = "\
@group(0) @binding(3) var<storage, read> stack_layers: array<layered_Layer>;
fn stack_layer(index: u32) -> layered_Layer {
    return stack_layers[index];
}
";

/// The WGSL that binds a storage buffer of tables and supplies `coupled_row` to `layered::coupled`; beside
/// [`STACK_BINDINGS`], which that function needs as well.
pub const TABLE_BINDINGS: &str = "\
@group(0) @binding(4) var<storage, read> coupled_rows: array<vec4f>;
fn coupled_row(index: u32) -> vec4f {
    return coupled_rows[index];
}
";

/// The bytes of a storage buffer that holds these layers.
pub fn layer_bytes<'a>(layers: impl IntoIterator<Item = &'a Layer<f32, 3>>) -> Vec<u8> {
    let layers: Vec<BufferLayer> = layers.into_iter().map(BufferLayer::from).collect();
    bytemuck::cast_slice(&layers).to_vec()
}

/// The layers and tables of any number of stacks, one after the other.
#[derive(Clone, Debug, Default)]
pub struct StackBuffers {
    layers: Vec<BufferLayer>,
    rows: Vec<[f32; 4]>,
}

/// Where a stack lies in its [`StackBuffers`]: what the twins take as `first`, `count` and `table`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StackPlace {
    /// The index of its first layer.
    pub first: u32,
    /// How many layers it has.
    pub count: u32,
    /// The index of the first row of its table; of no meaning under a model that has none.
    pub table: u32,
}

impl StackBuffers {
    /// Appends a stack with the widths that its model takes, and with its table (built now, unless it is) where its model is [`Model::Coupled`].
    pub fn push(&mut self, stack: &Stack<f32, 3>) -> StackPlace {
        let (first, table) = (self.layers.len() as u32, self.rows.len() as u32);
        self.layers.extend(stack.effective_layers().iter().map(BufferLayer::from));
        if stack.model() == Model::Coupled {
            self.rows.extend(Coupled::new(stack).buffer_rows());
        }
        StackPlace { first, count: stack.layers().len() as u32, table }
    }

    /// The WGSL that completes a linked module, and the content of the buffers that it binds: of layers and of tables,
    /// where the module calls for them.
    pub fn complete(&self, source: &str) -> (String, Vec<&[u8]>) {
        let (mut bindings, mut storage) = (String::new(), Vec::new());
        if source.contains("stack_layer(") {
            bindings += STACK_BINDINGS;
            storage.push(bytemuck::cast_slice(&self.layers));
        }
        if source.contains("coupled_row(") {
            bindings += TABLE_BINDINGS;
            storage.push(bytemuck::cast_slice(&self.rows));
        }
        (bindings, storage)
    }
}
