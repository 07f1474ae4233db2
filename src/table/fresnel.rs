//! F of a material over the angle of incidence, and the F of many as rows of one texture.

use super::{LENGTHS, Mapping, TableError, Texel, check_index, check_length};
use crate::fresnel;
use crate::real::Real;
use alloc::vec::Vec;

/// The entries of a table of F as printed: 384 bytes in 8 bits and three channels.
pub const ENTRIES: usize = 128;

/// F of one material, tabulated: C channels, interpolated linearly between entries of `f32`, [`Half`](super::Half) or `u8`.
///
/// $$F(c) \approx (1-s)\,F_i + s\,F_{i+1},\quad i+s = (N-1)\,u$$
///
/// In plain text: F ≈ (1−s)·Fᵢ + s·Fᵢ₊₁ at i+s = (N−1)·u, where u = 2·acos(c)/π ([`Mapping::Angle`]) or √c ([`Mapping::Root`]).
///
/// * Domain: n in [`N_RANGE`](crate::layered::N_RANGE), κ in [`K_RANGE`](crate::layered::K_RANGE), relative to a transparent
///   medium; [`LENGTHS`] entries.
/// * At c = 0, F = 1 exactly. There is no T: 1−F loses its digits at grazing incidence.
///
/// Largest error of F with 128 entries, over the angle: .0022 for the indices of Elek 2010, App. A, and n = 1.33 and 1.5, .0024 for all
/// built-in metals and n in [1.2, 4]; in 8 bits .0026 and .0028. Over the root: 1.3e-4 and 1.4e-4; in 8 bits .0020. The closer n is
/// to 1, the later and steeper F rises.
///
/// Source: Elek 2010, §3.1, "Fresnel term".
///
/// ```
/// use brdf::fresnel;
/// use brdf::table::{ENTRIES, FresnelTable, Mapping};
///
/// let (n, k) = ([0.213, 1.04, 1.17], [4.05, 2.59, 2.36]);
/// let copper = FresnelTable::<3, u8>::new(n, k, ENTRIES, Mapping::Angle)?;
/// assert_eq!(size_of_val(copper.entries()), 384);
/// let exact = fresnel::conductor(0.3_f64, n[1], k[1]).reflectance;
/// assert!((copper.reflectance(0.3)[1] - exact).abs() < 0.0026);
/// # Ok::<(), brdf::table::TableError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FresnelTable<const C: usize, T = f32> {
    entries: Vec<[T; C]>,
    mapping: Mapping,
}

impl<const C: usize, T: Texel> FresnelTable<C, T> {
    /// Tabulates the exact F of the relative index n + iκ.
    ///
    /// # Errors
    /// [`TableError::Length`] and [`TableError::Index`], outside the domain.
    pub fn new(n: [f64; C], k: [f64; C], entries: usize, mapping: Mapping) -> Result<Self, TableError> {
        check_length(entries)?;
        for channel in 0..C {
            check_index(channel, n[channel], k[channel])?;
        }
        let entry = |i: usize| {
            let u = i as f64 / (entries - 1) as f64;
            let cos = match mapping {
                Mapping::Angle => (0.25 * u).unit_circle().0,
                Mapping::Root => u * u,
            };
            core::array::from_fn(|channel| {
                // A step at grazing incidence, where n = 1, is one to 1 as well.
                let exact = fresnel::conductor(cos, n[channel], k[channel]).reflectance;
                T::encode(if cos > 0.0 { exact.saturate() } else { 1.0 })
            })
        };
        Ok(FresnelTable { entries: (0..entries).map(entry).collect(), mapping })
    }

    /// The reflected fraction in each channel.
    ///
    /// `cos_i` in [0, 1]: cosine of the angle of incidence, clamped there. F in [0, 1] for any number.
    #[inline(always)]
    pub fn reflectance<R: Real>(&self, cos_i: R) -> [R; C] {
        let c = cos_i.widen().saturate();
        let one = R::Wide::ONE;
        let u = match self.mapping {
            Mapping::Angle => {
                R::angle_wide(((one - c) * (one + c)).sqrt(), c) * R::Wide::from_f64(core::f64::consts::FRAC_2_PI)
            }
            Mapping::Root => c.sqrt(),
        };
        let cells = self.entries.len() - 1;
        let value = (u * R::Wide::from_f64(cells as f64)).linear(cells, |i| {
            let mut ends = [[0.0; 2]; C];
            for channel in 0..C {
                ends[channel] = [self.entries[i][channel].decode(), self.entries[i + 1][channel].decode()];
            }
            ends
        });
        value.map(R::narrow)
    }

    /// The entries: from normal to grazing incidence over the angle, from grazing to normal over the root.
    pub fn entries(&self) -> &[[T; C]] {
        &self.entries
    }

    /// What the entries are equally spaced in.
    pub fn mapping(&self) -> Mapping {
        self.mapping
    }
}

/// The tables of many materials, each a row of one texture or storage buffer.
///
/// A hundred materials of 128 entries are 50 kB in 8 bits: WebGPU has no texture of three channels, so that each texel has a
/// fourth, 1. Source: Elek 2010, §3.1.
#[derive(Clone, Debug, PartialEq)]
pub struct FresnelAtlas<T = f32> {
    tables: Vec<FresnelTable<3, T>>,
    entries: usize,
    mapping: Mapping,
}

impl<T: Texel> FresnelAtlas<T> {
    /// An atlas without tables.
    ///
    /// # Errors
    /// [`TableError::Length`].
    pub fn new(entries: usize, mapping: Mapping) -> Result<Self, TableError> {
        check_length(entries)?;
        Ok(FresnelAtlas { tables: Vec::new(), entries, mapping })
    }

    /// Appends a table, and returns the row that it is in.
    ///
    /// # Errors
    /// [`TableError::Mismatch`] and [`TableError::Full`].
    pub fn push(&mut self, table: FresnelTable<3, T>) -> Result<u32, TableError> {
        let (entries, mapping) = (table.entries.len(), table.mapping);
        if (entries, mapping) != (self.entries, self.mapping) {
            return Err(TableError::Mismatch { entries, mapping });
        }
        if self.tables.len() == *LENGTHS.end() {
            return Err(TableError::Full);
        }
        self.tables.push(table);
        Ok(self.tables.len() as u32 - 1)
    }

    /// The tables, row by row.
    pub fn tables(&self) -> &[FresnelTable<3, T>] {
        &self.tables
    }

    /// The texels of a row: the width of the texture.
    pub fn entries(&self) -> usize {
        self.entries
    }

    /// The texels, row by row: `rgba8unorm` of `u8`, `rgba16float` of `Half`, `rgba32float` or `vec4f` of `f32`.
    pub fn texels(&self) -> Vec<[T; 4]> {
        let texel = |[r, g, b]: &[T; 3]| [*r, *g, *b, T::encode(1.0)];
        self.tables.iter().flat_map(|table| table.entries.iter().map(texel)).collect()
    }
}
