//! A layer as a GPU buffer holds it.

use super::{Interface, Layer, Medium};
use bytemuck::{Pod, Zeroable};

/// A layer as `layered::Layer` of `wgsl/layered.wgsl` holds it: four rows of a vector and a scalar, 64 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BufferLayer {
    /// The real part of the index; 1 of a diffuse base.
    pub n: [f32; 3],
    /// The width of the distribution.
    pub alpha: f32,
    /// The imaginary part of the index.
    pub k: [f32; 3],
    /// 0: a microfacet interface. 1: a diffuse base.
    pub kind: u32,
    /// The reflectance of a diffuse base.
    pub albedo: [f32; 3],
    /// The standard deviation of a diffuse base's slope angle.
    pub deviation: f32,
    /// The absorption coefficient of the medium below.
    pub sigma: [f32; 3],
    /// The thickness of the medium below.
    pub thickness: f32,
}

impl From<&Layer<f32, 3>> for BufferLayer {
    fn from(layer: &Layer<f32, 3>) -> Self {
        let Medium { sigma, thickness } = layer.medium;
        let blank = BufferLayer { n: [1.0; 3], alpha: 1.0, sigma, thickness, ..BufferLayer::zeroed() };
        match layer.interface {
            Interface::Microfacet { n, k, alpha } => BufferLayer { n, k, alpha, ..blank },
            Interface::Diffuse { albedo, sigma } => BufferLayer { kind: 1, albedo, deviation: sigma, ..blank },
        }
    }
}
