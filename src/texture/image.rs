//! Images: parameters of a material as texels, looked up by the coordinates of a surface.
//!
//! An [`Image`] is a rectangle of finite numbers in one to four channels: grey (g, g, g, 1), grey and alpha (g, g, g, a), RGB (r, g, b, 1), RGBA. Rows run
//! with v and columns with u: the first texel is the corner at (0, 0), texel (i, j) has its centre at ((i + ½)/width, (j + ½)/height).
//!
//! Where v rises upwards, as on the shapes of `brdf::render` and in OBJ files, the first row is the *lowest* of the picture. Files store the
//! upper one first: who loads a file turns it over, as `brdf::render::texture::read_image` does. The green of a normal map is then a slope towards
//! growing v, +Y up, as OpenGL and Blender have it.
//!
//! In WGSL texels are supplied by the embedder, `fn material_texel(index: u32) -> vec4f`; all images of a material lie one after
//! another, row by row, as [`Image::texels`] gives them. A function takes the index of the first texel and the size.
//!
//! Numbers are linear. [`Image::from_bytes`] decodes sRGB; nothing here encodes a second time.

use crate::real::Real;
use alloc::vec::Vec;
use core::fmt;

/// The most texels of an image, and of all images of a material: their indices fit in the 32 bits of WGSL's.
///
/// An adapter takes fewer, as a texel is 16 bytes of one storage buffer: 2²³ of them (an image of 2896 × 2896) under WebGPU's default limit of
/// 128 MiB, and what its `max_storage_buffer_binding_size` says elsewhere. More are refused before anything runs, with that limit.
pub const MOST_TEXELS: usize = 1 << 28;

/// What lies beyond the edge of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The image again: coordinates count modulo 1.
    #[default]
    Repeat,
    /// The texel at the edge: coordinates are clamped to [0, 1].
    Clamp,
}

/// What lies between the centres of texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Filter {
    /// The four texels around, blended linearly along both axes.
    #[default]
    Bilinear,
    /// The nearest texel: for masks that must stay hard.
    Nearest,
}

/// How bytes stand for numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// byte/255: masks, heights, normals, roughness.
    Linear,
    /// [`srgb_to_linear`] of byte/255, but for alpha: colours.
    Srgb,
}

/// A rectangle of texels.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    channels: u32,
    texels: Vec<f32>,
    /// What lies beyond its edges.
    pub wrap: Wrap,
    /// What lies between its texels.
    pub filter: Filter,
}

impl Image {
    /// An image of `width`·`height` texels of `channels` numbers each, row by row; repeated, and bilinear.
    ///
    /// # Errors
    /// No texels or more than [`MOST_TEXELS`]; channels other than 1 to 4; numbers too few, too many, or not finite.
    pub fn new(width: u32, height: u32, channels: u32, texels: Vec<f32>) -> Result<Self, ImageError> {
        let count = (width as usize).checked_mul(height as usize).filter(|count| (1..=MOST_TEXELS).contains(count));
        let Some(count) = count else { return Err(ImageError::Size { width, height }) };
        if !(1..=4).contains(&channels) {
            return Err(ImageError::Channels { channels });
        }
        let want = count * channels as usize;
        if texels.len() != want {
            return Err(ImageError::Length { want, got: texels.len() });
        }
        if let Some(index) = texels.iter().position(|x| !x.is_finite()) {
            let (texel, channel) = (index / channels as usize, (index % channels as usize) as u32);
            let (x, y) = ((texel % width as usize) as u32, (texel / width as usize) as u32);
            return Err(ImageError::NotFinite { x, y, channel });
        }
        Ok(Image { width, height, channels, texels, wrap: Wrap::default(), filter: Filter::default() })
    }

    /// An image of bytes.
    ///
    /// # Errors
    /// As [`Image::new`].
    pub fn from_bytes(
        width: u32,
        height: u32,
        channels: u32,
        bytes: &[u8],
        encoding: Encoding,
    ) -> Result<Self, ImageError> {
        let number = |(index, byte): (usize, &u8)| {
            let share = f64::from(*byte) / 255.0;
            let is_alpha = matches!(channels, 2 | 4) && index % channels as usize == channels as usize - 1;
            let encoded = encoding == Encoding::Srgb && !is_alpha;
            (if encoded { srgb_to_linear(share) } else { share }) as f32
        };
        Self::new(width, height, channels, bytes.iter().enumerate().map(number).collect())
    }

    /// This image with what lies beyond its edges.
    #[must_use]
    pub fn with_wrap(self, wrap: Wrap) -> Self {
        Image { wrap, ..self }
    }

    /// This image with what lies between its texels.
    #[must_use]
    pub fn with_filter(self, filter: Filter) -> Self {
        Image { filter, ..self }
    }

    /// The number of columns.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// The number of rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The numbers of a texel, 1 to 4.
    pub fn channels(&self) -> u32 {
        self.channels
    }

    /// The texel in a column and a row as (r, g, b, a); beyond the last the last.
    pub fn texel(&self, x: u32, y: u32) -> [f32; 4] {
        let (x, y) = (x.min(self.width - 1) as usize, y.min(self.height - 1) as usize);
        let channels = self.channels as usize;
        let start = (y * self.width as usize + x) * channels;
        match self.texels.get(start..start + channels) {
            Some([g]) => [*g, *g, *g, 1.0],
            Some([g, a]) => [*g, *g, *g, *a],
            Some([r, g, b]) => [*r, *g, *b, 1.0],
            Some([r, g, b, a]) => [*r, *g, *b, *a],
            _ => [0.0; 4],
        }
    }

    /// Every texel as (r, g, b, a), row by row: what `material_texel` reads.
    pub fn texels(&self) -> impl Iterator<Item = [f32; 4]> + '_ {
        (0..self.height).flat_map(move |y| (0..self.width).map(move |x| self.texel(x, y)))
    }

    /// The image at coordinates, by its [`Wrap`] and [`Filter`].
    #[inline]
    pub fn sample<R: Real>(&self, uv: [R; 2]) -> [R; 4] {
        match (self.filter, self.wrap) {
            (Filter::Bilinear, Wrap::Repeat) => bilinear(self, uv),
            (Filter::Bilinear, Wrap::Clamp) => bilinear_clamped(self, uv),
            (Filter::Nearest, Wrap::Repeat) => nearest(self, uv),
            (Filter::Nearest, Wrap::Clamp) => nearest_clamped(self, uv),
        }
    }

    /// The function of `wgsl/image.wgsl` that [`Image::sample`] is.
    pub fn function(&self) -> &'static str {
        match (self.filter, self.wrap) {
            (Filter::Bilinear, Wrap::Repeat) => "bilinear",
            (Filter::Bilinear, Wrap::Clamp) => "bilinear_clamped",
            (Filter::Nearest, Wrap::Repeat) => "nearest",
            (Filter::Nearest, Wrap::Clamp) => "nearest_clamped",
        }
    }
}

/// The four texels around a point blended linearly, the image repeated.
///
/// In plain text, along each axis: x = (u − ⌊u⌋)·width − ½; (1 − f)·texel⌊x⌋ + f·texel⌊x + 1⌋, f = x − ⌊x⌋, columns modulo the width.
///
/// Continuous, and exact at the centres. Coordinates that are not finite count as 0.
#[inline]
pub fn bilinear<R: Real>(image: &Image, uv: [R; 2]) -> [R; 4] {
    let place = [0, 1].map(|axis| {
        let size = R::from_f64(f64::from(image.sizes()[axis]));
        (uv[axis] - uv[axis].floor()).saturate() * size - R::HALF
    });
    image.blended(place, |index, size| index.rem_euclid(size))
}

/// The four texels around a point blended linearly, those at the edges repeated outwards.
///
/// In plain text, along each axis: x = u·width − ½ clamped to [0, width − 1]; then as [`bilinear`].
#[inline]
pub fn bilinear_clamped<R: Real>(image: &Image, uv: [R; 2]) -> [R; 4] {
    let place = [0, 1].map(|axis| {
        let size = R::from_f64(f64::from(image.sizes()[axis]));
        let last = R::from_f64(f64::from(image.sizes()[axis] - 1));
        (uv[axis].saturate() * size - R::HALF).max(R::ZERO).min(last)
    });
    image.blended(place, |index, size| index.min(size - 1))
}

/// The texel that a point lies in, the image repeated: column ⌊(u − ⌊u⌋)·width⌋.
///
/// Discontinuous at the edges of texels: there the texel is either neighbour's by rounding.
#[inline]
pub fn nearest<R: Real>(image: &Image, uv: [R; 2]) -> [R; 4] {
    let place = [0, 1].map(|axis| {
        let size = R::from_f64(f64::from(image.sizes()[axis]));
        ((uv[axis] - uv[axis].floor()).saturate() * size).floor()
    });
    R::at_cell(place, |cell| image.numbers(cell, |index, size| index.rem_euclid(size)))
}

/// The texel that a point lies in, those at the edges repeated outwards: column ⌊u·width⌋, at most the last.
#[inline]
pub fn nearest_clamped<R: Real>(image: &Image, uv: [R; 2]) -> [R; 4] {
    let place = [0, 1].map(|axis| {
        let size = R::from_f64(f64::from(image.sizes()[axis]));
        (uv[axis].saturate() * size).floor()
    });
    R::at_cell(place, |cell| image.numbers(cell, |index, size| index.min(size - 1)))
}

impl Image {
    fn sizes(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// The texel of a column and a row after wrapping them; sizes are below 2³¹.
    fn numbers(&self, [x, y]: [i32; 2], wrap: impl Fn(i32, i32) -> i32) -> [f64; 4] {
        let column = wrap(x, self.width as i32).max(0) as u32;
        let row = wrap(y, self.height as i32).max(0) as u32;
        self.texel(column, row).map(f64::from)
    }

    /// The blend of the four texels around a place, in texels from the centre of the first.
    #[inline(always)]
    fn blended<R: Real>(&self, place: [R; 2], wrap: impl Fn(i32, i32) -> i32 + Copy) -> [R; 4] {
        let cell = place.map(R::floor);
        let [s, t] = [0, 1].map(|axis| (place[axis] - cell[axis]).saturate());
        let corners: [R; 16] = R::at_cell(cell, |[x, y]| {
            let four = [
                [x, y],
                [x.saturating_add(1), y],
                [x, y.saturating_add(1)],
                [x.saturating_add(1), y.saturating_add(1)],
            ];
            let four = four.map(|cell| self.numbers(cell, wrap));
            core::array::from_fn(|i| four[i / 4][i % 4])
        });
        let between = |a: R, b: R, share: R| (R::ONE - share) * a + share * b;
        core::array::from_fn(|c| {
            let [low, high] = [0, 8].map(|row| between(corners[row + c], corners[row + 4 + c], s));
            between(low, high, t)
        })
    }
}

/// The linear value of a number encoded by sRGB, both in [0, 1].
///
/// In plain text: c/12.92 up to 0.04045, then ((c + 0.055)/1.055)^2.4. Source: IEC 61966-2-1. Odd beyond 0, as extended sRGB has it.
pub fn srgb_to_linear(encoded: f64) -> f64 {
    let c = encoded.abs();
    let linear = if c <= 0.04045 { c / 12.92 } else { Real::exp(2.4 * Real::ln((c + 0.055) / 1.055)) };
    if encoded < 0.0 { -linear } else { linear }
}

/// The number that encodes a linear value by sRGB: the inverse of [`srgb_to_linear`].
///
/// In plain text: 12.92·c up to 0.0031308, then 1.055·c^(1/2.4) − 0.055.
pub fn linear_to_srgb(linear: f64) -> f64 {
    let c = linear.abs();
    let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * Real::exp(Real::ln(c) / 2.4) - 0.055 };
    if linear < 0.0 { -encoded } else { encoded }
}

/// Why numbers make no image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageError {
    /// No texels, or too many.
    Size {
        /// The width asked for.
        width: u32,
        /// The height asked for.
        height: u32,
    },
    /// Other than one to four channels.
    Channels {
        /// How many were asked for.
        channels: u32,
    },
    /// The numbers do not fill the image.
    Length {
        /// How many the size asks for.
        want: usize,
        /// How many there are.
        got: usize,
    },
    /// A number of a texel is NaN or infinite. All count from 0.
    NotFinite {
        /// The column.
        x: u32,
        /// The row.
        y: u32,
        /// The channel.
        channel: u32,
    },
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ImageError::Size { width, height } => {
                write!(
                    f,
                    "an image of {width} × {height} texels: both must be at least 1, and their product at most {MOST_TEXELS}"
                )
            }
            ImageError::Channels { channels } => write!(f, "an image of {channels} channels: give 1, 2, 3 or 4"),
            ImageError::Length { want, got } => {
                write!(f, "{got} numbers for an image that has {want}: give width · height · channels of them")
            }
            ImageError::NotFinite { x, y, channel } => {
                write!(f, "the texel in column {x}, row {y} is not finite in channel {channel}: give finite numbers")
            }
        }
    }
}

impl core::error::Error for ImageError {}

#[cfg(test)]
#[path = "image_tests.rs"]
mod tests;
