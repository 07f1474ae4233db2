//! A layer, and the tables of the coupled model, as GPU buffers hold them.

#[cfg(feature = "std")]
use super::{Coupled, tables::Curve};
use super::{Interface, Layer, Medium};
#[cfg(feature = "std")]
use crate::real::Real;
use bytemuck::{Pod, Zeroable};
#[cfg(feature = "std")]
use std::vec::Vec;

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

#[cfg(feature = "std")]
impl<R: Real> Coupled<R, 3> {
    /// The tables as `coupled` of `wgsl/layered.wgsl` reads them: rows of 16 bytes, of which `coupled_row` supplies one.
    ///
    /// | row | xyz, a value for each channel | w |
    /// |---|---|---|
    /// | 0 | ρ²·r_i/(1 − ρ·r_i): what the bounces between base and coat add to the base's albedo | the row of E_T; 0: none |
    /// | 1 | 1/(π·m̄) | the row of s, which m follows; 0: neither |
    ///
    /// Then 32 rows for each curve that there is, in the order E_T, s, m, from grazing to normal incidence: linear in √cos,
    /// w unused. Rows are counted from the table's first. E_T is the share of light that reaches a base, s the factor of
    /// the layers under the top interface, m the albedo that is still missing (see [`coupled`](super::coupled)).
    ///
    /// 2 rows for a single interface or a Lambert base under a smooth coat, 34 for one under a rough coat, 98 for other
    /// diffuse bases under rough or several coats, 66 for the rest: 32 bytes to 1.6 kB.
    pub fn buffer_rows(&self) -> Vec<[f32; 4]> {
        self.rows().into_iter().map(|row| row.map(|x| x as f32)).collect()
    }

    /// The same before it is rounded.
    pub(crate) fn rows(&self) -> Vec<[f64; 4]> {
        let tables = self.tables();
        let row = |[x, y, z]: [f64; 3], w: usize| [x, y, z, w as f64];
        let mut rows = std::vec![[0.0; 4]; 2];
        let append = |rows: &mut Vec<[f64; 4]>, curve: &Curve<3>| {
            let start = rows.len();
            rows.extend(curve.nodes().iter().map(|node| row(*node, 0)));
            start
        };
        let transmitted = tables.transmitted.as_ref().map_or(0, |curve| append(&mut rows, curve));
        rows[0] = row(core::array::from_fn(|channel| tables.series(channel)), transmitted);
        if let Some(closure) = &tables.closure {
            let scale = append(&mut rows, &closure.scale);
            append(&mut rows, &closure.missing);
            rows[1] = row(closure.inverse, scale);
        }
        rows
    }
}
