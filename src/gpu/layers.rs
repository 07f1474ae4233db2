//! Stacks in the storage buffers that the twins of [`crate::layered`] read, and texels in those of [`crate::table`] and
//! [`crate::texture`].

use super::{Gpu, GpuError};
use crate::layered::{BufferLayer, Coupled, Layer, Model, Stack};
use crate::real::Real;
use crate::texture::image::Image;

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

/// The WGSL that binds a storage buffer of texels, rows of [`ENTRIES`](crate::table::ENTRIES), and supplies `fresnel_texel` to the
/// module `table`.
pub const FRESNEL_BINDINGS: &str = "\
@group(0) @binding(5) var<storage, read> fresnel_texels: array<vec4f>;
fn fresnel_texel(column: u32, row: u32) -> vec3f {
    return fresnel_texels[row * 128u + column].xyz;
}
";

/// The WGSL that binds a storage buffer of texels, rows of [`SIDE`](crate::table::SIDE), and supplies `distribution_texel` to the
/// module `table`.
pub const DISTRIBUTION_BINDINGS: &str = "\
@group(0) @binding(6) var<storage, read> distribution_texels: array<f32>;
fn distribution_texel(column: u32, row: u32) -> f32 {
    return distribution_texels[row * 512u + column];
}
";

/// The WGSL that binds a storage buffer of texels, all images one after another, and supplies `material_texel` to the module `image`.
pub const TEXEL_BINDINGS: &str = "\
@group(0) @binding(7) var<storage, read> material_texels: array<vec4f>;
fn material_texel(index: u32) -> vec4f {
    return material_texels[index];
}
";

/// The WGSL that binds a storage buffer of stops, all ramps one after another, and supplies `ramp_stop` to the module `ramp`.
pub const RAMP_BINDINGS: &str = "\
@group(0) @binding(8) var<storage, read> ramp_stops: array<vec4f>;
fn ramp_stop(index: u32) -> vec4f {
    return ramp_stops[index];
}
";

/// The bytes of a texel: four numbers, however many channels the image has.
const TEXEL: u64 = 16;

/// The bytes of a storage buffer that holds the texels of these images, one image after another; of one texel where there are none.
///
/// # Errors
/// [`GpuError::TooLarge`] where the device binds less.
pub fn texel_bytes(gpu: &Gpu, images: &[Image]) -> Result<Vec<u8>, GpuError> {
    let size = |image: &Image| u64::from(image.width()) * u64::from(image.height());
    gpu.bindable(TEXEL * images.iter().map(size).sum::<u64>(), || {
        let largest = images.iter().max_by_key(|image| size(image));
        let [width, height] = largest.map_or([0; 2], |image| [image.width(), image.height()]);
        format!("the material's images (of {}, the largest {width}×{height} texels)", images.len())
    })?;
    let mut texels: Vec<[f32; 4]> = images.iter().flat_map(Image::texels).collect();
    // An adapter refuses an empty buffer.
    texels.resize(texels.len().max(1), [0.0; 4]);
    Ok(bytemuck::cast_slice(&texels).to_vec())
}

/// The bytes of a storage buffer that holds these layers.
pub fn layer_bytes<'a>(layers: impl IntoIterator<Item = &'a Layer<f32, 3>>) -> Vec<u8> {
    let layers: Vec<BufferLayer> = layers.into_iter().map(BufferLayer::from).collect();
    bytemuck::cast_slice(&layers).to_vec()
}

/// The layers and tables of any number of stacks, one after the other. An adapter reads them rounded to f32.
#[derive(Clone, Debug, Default)]
pub struct StackBuffers {
    pub(crate) layers: Vec<Layer<f64, 3>>,
    pub(crate) rows: Vec<[f64; 4]>,
    /// Texels of F and of D, for the twins of [`crate::table`].
    pub(crate) fresnel: Vec<[f64; 4]>,
    pub(crate) distribution: Vec<f64>,
    /// Texels of images and stops of ramps, for the twins of [`crate::texture`].
    pub(crate) texels: Vec<[f64; 4]>,
    pub(crate) stops: Vec<[f64; 4]>,
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
    /// Appends a stack with the widths that its model takes, and with its table (built now, unless it is) where its model is
    /// [`Model::Coupled`].
    pub fn push<R: Real>(&mut self, stack: &Stack<R, 3>) -> StackPlace {
        let (first, table) = (self.layers.len() as u32, self.rows.len() as u32);
        self.layers.extend(stack.effective_layers().iter().map(Layer::cast::<f64>));
        if stack.model() == Model::Coupled {
            self.rows.extend(Coupled::new(stack).rows());
        }
        StackPlace { first, count: stack.layers().len() as u32, table }
    }

    /// The WGSL that completes a linked module: bindings of layers and of tables, where the module calls for them.
    pub fn bindings(&self, source: &str) -> String {
        let needed = [
            ("stack_layer(", STACK_BINDINGS),
            ("coupled_row(", TABLE_BINDINGS),
            ("fresnel_texel(", FRESNEL_BINDINGS),
            ("distribution_texel(", DISTRIBUTION_BINDINGS),
            ("material_texel(", TEXEL_BINDINGS),
            ("ramp_stop(", RAMP_BINDINGS),
        ];
        needed.into_iter().filter(|(call, _)| source.contains(call)).map(|(_, bindings)| bindings).collect()
    }

    /// The content of the buffers that [`StackBuffers::bindings`] binds.
    pub fn storage(&self, source: &str) -> Vec<Vec<u8>> {
        let mut storage = Vec::new();
        if source.contains("stack_layer(") {
            let layers: Vec<_> = self.layers.iter().map(Layer::cast::<f32>).collect();
            storage.push(layer_bytes(&layers));
        }
        let vectors = |rows: &[[f64; 4]]| {
            let mut rows: Vec<[f32; 4]> = rows.iter().map(|row| row.map(|x| x as f32)).collect();
            // An adapter refuses an empty buffer.
            rows.resize(rows.len().max(1), [0.0; 4]);
            bytemuck::cast_slice(&rows).to_vec()
        };
        if source.contains("coupled_row(") {
            storage.push(vectors(&self.rows));
        }
        if source.contains("fresnel_texel(") {
            storage.push(vectors(&self.fresnel));
        }
        if source.contains("distribution_texel(") {
            let mut texels: Vec<f32> = self.distribution.iter().map(|x| *x as f32).collect();
            texels.resize(texels.len().max(1), 0.0);
            storage.push(bytemuck::cast_slice(&texels).to_vec());
        }
        if source.contains("material_texel(") {
            storage.push(vectors(&self.texels));
        }
        if source.contains("ramp_stop(") {
            storage.push(vectors(&self.stops));
        }
        storage
    }
}
