//! The light that comes from infinitely far away: maps of radiance, from files and built in.
//!
//! Whatever it is made of, an environment is held as an octahedral [`Map`], which needs no trigonometry to look up, with a density for
//! importance sampling in its fourth number. Both languages read the same texels.
//!
//! # Sampling
//!
//! A square of texels is chosen in proportion to its luminance times its solid angle by an alias table (Vose 1991): two numbers and
//! one access whatever the size, where a two-dimensional distribution function takes two searches. Within the square the point is uniform.
//!
//! # Files
//!
//! Equirectangular `.hdr` or `.exr` maps, twice as wide as high. The left edge is +x, columns turn clockwise seen from above, the top
//! row is +z. What a `.hdr` file says it was multiplied by (`EXPOSURE=`, `COLORCORR=`) is divided out again. A file may take 4 GiB when it is read,
//! which 16384×8192 texels fit; whatever its size, a map of at most 2048² texels is kept.

use super::octahedral::{self, Map};
use crate::frame::Vector;
use crate::real::{Mask, Real};
use image::codecs::hdr::HdrDecoder;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// The sides that a map may have: the finest is 64 MiB.
const SIDES: core::ops::RangeInclusive<usize> = 64..=2048;

/// The squares to a side that directions are drawn from, at most: their table is 128 kB, which stays in a processor's cache.
pub(crate) const SQUARES: usize = 128;

/// The memory that the texels of a file may take.
const MOST_BYTES: u64 = 1 << 32;

/// Points of a texel, along either axis, that a map made from a file averages.
const OVERSAMPLING: usize = 4;

/// The light from every direction, and how directions are drawn from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    map: Map,
    alias: Vec<Alias>,
}

/// An entry of the alias table: this texel with the probability `keep`, else the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Alias {
    pub(crate) keep: f32,
    pub(crate) other: u32,
}

impl Environment {
    /// An environment of any radiance in W/(sr·m²) as a function of the direction, on a map of `side`² texels; a power of two.
    pub fn from_radiance(side: usize, radiance: impl Fn(Vector<f64>) -> [f64; 3]) -> Self {
        let side = side.next_power_of_two().clamp(*SIDES.start(), *SIDES.end());
        let map = Map::new(side, |column, row| {
            let (w, _) = Map::centre(side, column, row);
            radiance(w).map(|x| x as f32)
        });
        Self::from_map(map)
    }

    /// Constant radiance of 1 from everywhere: what a lossless surface under it shows is 1.
    pub fn furnace() -> Self {
        Self::from_radiance(*SIDES.start(), |_| [1.0; 3])
    }

    /// No light.
    pub fn dark() -> Self {
        Self::from_radiance(*SIDES.start(), |_| [0.0; 3])
    }

    /// Reads an equirectangular map.
    ///
    /// # Errors
    /// One line: the file, what is wrong with it, and where. Files that are no images, maps that are not twice as wide as
    /// high or take more than 4 GiB, texels that are negative, infinite or not a number.
    pub fn read(path: &Path) -> Result<Self, String> {
        Self::read_within(path, MOST_BYTES)
    }

    fn read_within(path: &Path, most: u64) -> Result<Self, String> {
        let place = path.display();
        let decoder = image::ImageReader::open(path).map_err(|error| format!("{place}: {error}"))?;
        let mut decoder = decoder.with_guessed_format().map_err(|error| format!("{place}: {error}"))?;
        let mut limits = image::Limits::default();
        limits.max_alloc = Some(most);
        decoder.limits(limits);
        let radiance = decoder.format() == Some(image::ImageFormat::Hdr);
        match decoder.format() {
            Some(image::ImageFormat::Hdr | image::ImageFormat::OpenExr) => {}
            _ => return Err(format!("{place}: an environment is a Radiance .hdr or an OpenEXR .exr file")),
        }
        let picture = decoder.decode().map_err(|error| match error {
            image::ImageError::Limits(_) => {
                let gigabytes = most as f64 / f64::from(1 << 30);
                format!("{place}: its texels take more than {gigabytes} GiB: scale it down; what is kept of any map is 4096×2048 at most")
            }
            error => format!("{place}: {error}"),
        })?;
        let mut picture = picture.into_rgb32f();
        if radiance && let Some(scale) = multiplied(path).map_err(|error| format!("{place}: {error}"))? {
            picture.pixels_mut().for_each(|pixel| pixel.0 = [0, 1, 2].map(|c: usize| pixel.0[c] / scale[c]));
        }
        let (width, height) = (picture.width() as usize, picture.height() as usize);
        let (texels, _) = picture.as_raw().as_chunks::<3>();
        Self::from_equirectangular(width, height, texels).map_err(|error| format!("{place}: {error}"))
    }

    /// An environment of equirectangular texels, row by row from the top.
    ///
    /// # Errors
    /// Where the map is not twice as wide as high, and where a texel is negative, infinite or not a number: the first such.
    pub fn from_equirectangular(width: usize, height: usize, texels: &[[f32; 3]]) -> Result<Self, String> {
        if height == 0 || width != 2 * height || texels.len() != width * height {
            return Err(format!("{width}×{height} texels; an equirectangular map is twice as wide as high"));
        }
        for (i, texel) in texels.iter().enumerate() {
            if let Some(channel) = texel.iter().position(|x| !(*x >= 0.0 && x.is_finite())) {
                let (column, row, name) = (i % width, i / width, ["red", "green", "blue"][channel]);
                let value = texel[channel];
                return Err(format!("texel ({column}, {row}): {name} is {value}; radiance is finite and at least 0"));
            }
        }
        let side = height.next_power_of_two().clamp(*SIDES.start(), *SIDES.end());
        let fine = side * OVERSAMPLING;
        let map = Map::in_parallel(side, |column, row| {
            let mut sum = [0.0f64; 3];
            for i in 0..OVERSAMPLING * OVERSAMPLING {
                let (x, y) = (column * OVERSAMPLING + i % OVERSAMPLING, row * OVERSAMPLING + i / OVERSAMPLING);
                let (w, _) = Map::centre(fine, x, y);
                for (sum, x) in sum.iter_mut().zip(equirectangular(width, height, texels, w)) {
                    *sum += x;
                }
            }
            sum.map(|x| (x / (OVERSAMPLING * OVERSAMPLING) as f64) as f32)
        });
        Ok(Self::from_map(map))
    }

    fn from_map(map: Map) -> Self {
        let side = map.side();
        let stride = side + 2;
        let luminance = |column: usize, row: usize| {
            let [r, g, b, _] = map.texels().get(row * stride + column).copied().unwrap_or_default();
            // Rec. 709's weights; any that are positive will do.
            0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
        };
        let weight = |i: usize| {
            let (column, row) = (i % side, i / side);
            // The mean of the bilinear function over the texel: it is 0 only where the function is.
            let mut mean = 0.0;
            for (dy, wy) in [(0, 0.125), (1, 0.75), (2, 0.125)] {
                for (dx, wx) in [(0, 0.125), (1, 0.75), (2, 0.125)] {
                    mean += wx * wy * luminance(column + dx, row + dy);
                }
            }
            mean * Map::centre(side, column, row).1
        };
        let squares = side.min(SQUARES);
        let texels = side / squares;
        let mut weights = vec![0.0; squares * squares];
        for i in 0..side * side {
            let square = i / side / texels * squares + i % side / texels;
            if let Some(sum) = weights.get_mut(square) {
                *sum += weight(i);
            }
        }
        let total: f64 = weights.iter().sum();
        if total <= 0.0 {
            return Environment { map, alias: Vec::new() };
        }
        // p(ω) = P(square)·squares²/4·|octahedron|³.
        let scale = (squares * squares) as f64 / (4.0 * total);
        let map = map.with_fourth(|column, row| {
            weights.get(row / texels * squares + column / texels).map_or(0.0, |w| (w * scale) as f32)
        });
        Environment { map, alias: alias(&weights, total) }
    }

    /// The map.
    pub fn map(&self) -> &Map {
        &self.map
    }

    #[cfg(feature = "gpu")]
    pub(crate) fn alias(&self) -> &[Alias] {
        &self.alias
    }

    /// False where no light comes from anywhere.
    pub fn shines(&self) -> bool {
        !self.alias.is_empty()
    }

    /// The radiance from a direction, and the density in sr⁻¹ with which [`Environment::sample`] draws it.
    #[inline(always)]
    pub fn look<R: Real>(&self, w: Vector<R>) -> ([R; 3], R) {
        let (point, distance) = octahedral::square(w);
        let (radiance, fourth) = self.map.at(point);
        (radiance, fourth * (distance * distance * distance))
    }

    /// A direction drawn about in proportion to the radiance, from four numbers in [0, 1); its radiance and density as [`Environment::look`] has them.
    ///
    /// None where no light comes from anywhere.
    #[inline]
    pub fn sample<R: Real>(&self, u: [R; 4]) -> Option<(Vector<R>, [R; 3], R)> {
        let found = self.draw(u);
        found.2.gt(R::ZERO).any().then_some(found)
    }

    /// [`Environment::sample`], with density 0 where there is none.
    #[inline(always)]
    pub(crate) fn draw<R: Real>(&self, u: [R; 4]) -> (Vector<R>, [R; 3], R) {
        // Whole numbers up to 2¹⁴: exact in every type.
        let whole = |number: usize| R::from_f64(number as f64);
        let place = (u[0] * whole(self.alias.len())).floor().min(whole(self.alias.len().saturating_sub(1)));
        let [keep, other] = R::at_cell([place], |[place]| {
            self.alias.get(place as usize).map_or([0.0; 2], |entry| [f64::from(entry.keep), f64::from(entry.other)])
        });
        let chosen = R::select(u[1].lt(keep), place, other);
        let side = self.map.side().min(SQUARES);
        let row = (chosen * R::from_f64(1.0 / side as f64)).floor();
        let column = chosen - row * whole(side);
        let scale = R::TWO / whole(side);
        let point = [(column + u[2]) * scale - R::ONE, (row + u[3]) * scale - R::ONE];
        let (w, cube) = octahedral::direction(point);
        let (radiance, fourth) = self.map.at(point);
        (w, radiance, fourth * cube)
    }
}

/// What the header of a Radiance file says that its numbers are multiplied by, if it says so.
pub(super) fn multiplied(path: &Path) -> Result<Option<[f32; 3]>, String> {
    let file = BufReader::new(File::open(path).map_err(|error| error.to_string())?);
    let metadata = HdrDecoder::new(file).map_err(|error| error.to_string())?.metadata();
    if metadata.exposure.is_none() && metadata.color_correction.is_none() {
        return Ok(None);
    }
    let exposure = metadata.exposure.unwrap_or(1.0);
    let (r, g, b) = metadata.color_correction.unwrap_or((1.0, 1.0, 1.0));
    let scale = [r, g, b].map(|x| x * exposure);
    if scale.iter().all(|x| *x > 0.0 && x.is_finite()) {
        return Ok(Some(scale));
    }
    Err(format!("its header says EXPOSURE or COLORCORR of {scale:?}; they are above 0 and finite"))
}

/// The radiance of an equirectangular map at a direction, bilinear.
fn equirectangular(width: usize, height: usize, texels: &[[f32; 3]], w: Vector<f64>) -> [f64; 3] {
    let turn = (-w.y.atan2(w.x) / core::f64::consts::TAU).rem_euclid(1.0);
    let down = w.z.clamp(-1.0, 1.0).acos() / core::f64::consts::PI;
    let (x, y) = (turn * width as f64 - 0.5, (down * height as f64 - 0.5).clamp(0.0, (height - 1) as f64));
    let (left, top) = (x.floor(), y.floor());
    let (u, v) = (x - left, y - top);
    let column = |offset: f64| (left + offset).rem_euclid(width as f64) as usize;
    let row = |offset: f64| (top as usize + offset as usize).min(height - 1);
    let at = |dx: f64, dy: f64| {
        texels.get(row(dy) * width + column(dx).min(width - 1)).copied().unwrap_or_default().map(f64::from)
    };
    let (a, b, c, d) = (at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0));
    core::array::from_fn(|i| {
        let (top, bottom) = (a[i] + (b[i] - a[i]) * u, c[i] + (d[i] - c[i]) * u);
        top + (bottom - top) * v
    })
}

/// Vose's alias table of weights ≥ 0 with this sum > 0.
fn alias(weights: &[f64], total: f64) -> Vec<Alias> {
    let count = weights.len() as f64;
    let mut scaled: Vec<f64> = weights.iter().map(|w| w / total * count).collect();
    let mut table: Vec<Alias> = (0..weights.len() as u32).map(|i| Alias { keep: 1.0, other: i }).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..weights.len()).partition(|i| scaled[*i] < 1.0);
    while let (Some(low), Some(&high)) = (small.pop(), large.last()) {
        table[low] = Alias { keep: scaled[low] as f32, other: high as u32 };
        scaled[high] -= 1.0 - scaled[low];
        if scaled[high] < 1.0 {
            large.pop();
            small.push(high);
        }
    }
    // What is left in either list is 1 but for rounding; an entry of weight 0 must never be kept.
    for i in small {
        if weights[i] <= 0.0
            && let Some(other) = weights.iter().position(|w| *w > 0.0)
        {
            table[i] = Alias { keep: 0.0, other: other as u32 };
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walk::random::random;

    fn lamp() -> Environment {
        Environment::from_radiance(64, |w| {
            let bright = if w.x > 0.9 { 50.0 } else { 0.0 };
            [bright + 0.5 + 0.5 * w.z, bright, 0.2]
        })
    }

    #[test]
    fn the_density_integrates_to_one() {
        let lamp = lamp();
        let side = 512;
        let sum: f64 = (0..side * side)
            .map(|i| {
                let (w, solid) = Map::centre(side, i % side, i / side);
                lamp.look(w).1 * solid
            })
            .sum();
        // The midpoint rule over 8×8 points of each texel, in which |p|³ varies by 2/64 of itself.
        assert!((sum - 1.0).abs() < 1e-3, "{sum}");
    }

    #[test]
    fn samples_estimate_the_irradiance() {
        let lamp = lamp();
        let side = 512;
        let mut want = 0.0;
        for i in 0..side * side {
            let (w, solid) = Map::centre(side, i % side, i / side);
            want += lamp.look(w).0[0] * solid;
        }
        let n = 1 << 16;
        let (mut sum, mut squares) = (0.0, 0.0);
        for i in 0..n {
            let (_, radiance, density) = lamp.sample::<f64>(random(5, i, 0)).expect("it shines");
            let x = radiance[0] / density;
            sum += x;
            squares += x * x;
        }
        let n = f64::from(n);
        let (mean, variance) = (sum / n, squares / n - (sum / n).powi(2));
        let error = (variance / n).sqrt();
        assert!((mean - want).abs() < 4.0 * error + 1e-3 * want, "{mean} ± {error}, want {want}");
    }

    #[test]
    fn broken_maps_name_the_texel() {
        let mut texels = vec![[1.0f32; 3]; 8];
        assert!(Environment::from_equirectangular(4, 2, &texels).is_ok());
        texels[6][1] = f32::NAN;
        let error = Environment::from_equirectangular(4, 2, &texels).expect_err("NaN");
        assert_eq!(error, "texel (2, 1): green is NaN; radiance is finite and at least 0");
        let error = Environment::from_equirectangular(3, 2, &texels[..6]).expect_err("shape");
        assert!(error.contains("3×2"), "{error}");
    }

    #[test]
    fn headers_and_limits_of_files_are_heeded() {
        let folder = std::env::temp_dir().join(format!("brdf-environment-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        // Flat texels of mantissa 128 and exponent 129: 1 each.
        let file = |header: &str| {
            let path = folder.join("map.hdr");
            let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n{header}\n-Y 2 +X 4\n").into_bytes();
            bytes.extend([128, 128, 128, 129].repeat(8));
            std::fs::write(&path, bytes).expect("written");
            path
        };
        let up = |header: &str| Environment::read(&file(header)).map(|map| map.look(Vector::new(0.0, 0.0, 1.0f64)).0);
        assert_eq!(up(""), Ok([1.0; 3]));
        assert_eq!(up("EXPOSURE=2\nEXPOSURE=4\n"), Ok([0.125; 3]));
        assert_eq!(up("EXPOSURE=0.5\nCOLORCORR=1 2 4\n"), Ok([2.0, 1.0, 0.5]));
        assert!(up("EXPOSURE=0\n").expect_err("0").contains("map.hdr: its header says EXPOSURE"));
        let error = Environment::read_within(&file(""), 64).expect_err("96 bytes");
        assert!(error.contains("map.hdr: its texels take more than") && error.lines().count() == 1, "{error}");
        let _ = std::fs::remove_dir_all(&folder);
    }

    #[test]
    fn an_equirectangular_map_stands_upright() {
        // One bright column at a quarter of the width, which is −y.
        let (width, height) = (64, 32);
        let texel = |i: usize| if i % width == 16 { [1.0; 3] } else { [0.0; 3] };
        let texels: Vec<_> = (0..width * height).map(texel).collect();
        let map = Environment::from_equirectangular(width, height, &texels).expect("valid");
        let at = |x, y, z| map.look::<f64>(Vector::new(x, y, z)).0[0];
        // The centre of column 16 is at 16.5/64 of a turn.
        assert!(at(-0.0490, -0.9988, 0.0) > 0.6 && at(0.0, 1.0, 0.0) == 0.0 && at(1.0, 0.0, 0.0) == 0.0);
    }
}
