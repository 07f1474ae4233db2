//! Pictures: linear radiance for each pixel, how sure it is, and the files that they are written to.
//!
//! An EXR file holds the radiance as it is. A PNG file holds it times 2^exposure, clipped to [0, 1] and encoded by sRGB's transfer function (IEC
//! 61966-2-1); no other tone curve is applied, and how many pixels were clipped is said. A file appears under its name whole or not at all.

use image::ImageFormat;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// A picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    mean: Vec<[f32; 3]>,
    variance: Vec<[f32; 3]>,
}

/// What the samples of a pixel add up to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// How many there are.
    pub count: u32,
    /// Their sum.
    pub sum: [f64; 3],
    /// The sum of their squares.
    pub squares: [f64; 3],
}

impl Tally {
    /// Adds a sample.
    #[inline]
    pub fn add(&mut self, value: [f64; 3]) {
        self.count += 1;
        for c in 0..3 {
            self.sum[c] += value[c];
            self.squares[c] += value[c] * value[c];
        }
    }

    /// Their mean, and the variance of that mean; 0 of fewer than two samples.
    pub fn estimate(&self) -> ([f32; 3], [f32; 3]) {
        let n = f64::from(self.count.max(1));
        let mean = self.sum.map(|sum| sum / n);
        let variance = core::array::from_fn(|c| {
            let spread = (self.squares[c] / n - mean[c] * mean[c]).max(0.0);
            if self.count > 1 { (spread / (n - 1.0)) as f32 } else { 0.0 }
        });
        (mean.map(|x| x as f32), variance)
    }
}

impl Film {
    /// A picture of tallies, row by row from the upper left.
    pub fn new(width: u32, height: u32, tallies: &[Tally]) -> Self {
        let (mean, variance) = tallies.iter().map(Tally::estimate).unzip();
        Film { width, height, mean, variance }
    }

    /// Pixels to a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows of pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The mean radiance of each pixel.
    pub fn mean(&self) -> &[[f32; 3]] {
        &self.mean
    }

    /// The variance of each mean: what another picture of other seeds differs by, squared.
    pub fn variance(&self) -> &[[f32; 3]] {
        &self.variance
    }

    /// Writes a `.png` or `.exr` file. `exposure` in stops is for PNG alone. Returns how many pixels were clipped.
    ///
    /// The file is on the disk, as far as the system tells, before it gets its name.
    ///
    /// # Errors
    /// One line: the file and why it cannot be written, a full disk too; what else was under the name stays.
    pub fn write(&self, path: &Path, exposure: f64) -> Result<usize, String> {
        let place = path.display();
        let format = format(path)?;
        // A link stays one: the file that it leads to is replaced.
        let path = &std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let partial = partial_name(path);
        let written = File::create(&partial).map_err(|error| error.to_string());
        let written = written.and_then(|file| self.write_into(file, format, exposure));
        let written = written
            .and_then(|clipped| std::fs::rename(&partial, path).map(|()| clipped).map_err(|error| error.to_string()));
        written.map_err(|error| {
            let _ = std::fs::remove_file(&partial);
            format!("{place}: {error}")
        })
    }

    /// Encodes the picture into an open file and waits until it is stored: what a buffer holds back is not written yet.
    fn write_into(&self, file: File, format: ImageFormat, exposure: f64) -> Result<usize, String> {
        let unfit = || format!("{}×{} pixels do not fit the file", self.width, self.height);
        let (picture, clipped) = if format == ImageFormat::Png {
            let (bytes, clipped) = self.encoded(exposure);
            let buffer = image::RgbImage::from_raw(self.width, self.height, bytes).ok_or_else(unfit)?;
            (image::DynamicImage::ImageRgb8(buffer), clipped)
        } else {
            let all = self.mean.iter().flatten().copied().collect();
            let buffer = image::Rgb32FImage::from_raw(self.width, self.height, all).ok_or_else(unfit)?;
            (image::DynamicImage::ImageRgb32F(buffer), 0)
        };
        let mut writer = BufWriter::new(file);
        picture.write_to(&mut writer, format).map_err(|error| error.to_string())?;
        let file = writer.into_inner().map_err(|error| error.error().to_string())?;
        file.sync_all().map_err(|error| error.to_string())?;
        Ok(clipped)
    }

    /// How many pixels hold a number that is infinite or none.
    pub fn not_finite(&self) -> usize {
        self.mean.iter().filter(|pixel| !pixel.iter().all(|x| x.is_finite())).count()
    }

    /// The bytes of a PNG file and how many pixels exceed what it can hold.
    pub fn encoded(&self, exposure: f64) -> (Vec<u8>, usize) {
        let scale = exposure.exp2();
        let mut clipped = 0;
        let mut bytes = Vec::with_capacity(3 * self.mean.len());
        for pixel in &self.mean {
            let scaled = pixel.map(|x| f64::from(x) * scale);
            clipped += usize::from(scaled.iter().any(|x| *x > 1.0));
            bytes.extend(scaled.map(|x| (255.0 * transfer(x.clamp(0.0, 1.0))).round() as u8));
        }
        (bytes, clipped)
    }
}

/// sRGB's transfer function on [0, 1].
fn transfer(x: f64) -> f64 {
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// Whether a picture can be written under this name, asked before it is computed: an empty file is made beside it and removed again, so that
/// nothing is left where the work is broken off.
///
/// # Errors
/// One line: the file, and why not. What has no name of a `.png` or `.exr` file, a folder, and a folder that is absent or may not be written to.
pub fn writable(path: &Path) -> Result<(), String> {
    let place = |error: &dyn core::fmt::Display| format!("{}: {error}", path.display());
    format(path)?;
    if path.is_dir() {
        return Err(place(&"a folder is in the way"));
    }
    let partial = partial_name(path);
    File::create(&partial).and_then(|_| std::fs::remove_file(&partial)).map_err(|error| place(&error))
}

/// The format that a name asks for, in capitals too.
fn format(path: &Path) -> Result<ImageFormat, String> {
    let extension = path.extension().map(|extension| extension.to_ascii_lowercase());
    match extension.as_deref().and_then(|extension| extension.to_str()) {
        Some("png") => Ok(ImageFormat::Png),
        Some("exr") => Ok(ImageFormat::OpenExr),
        _ => Err(format!("{}: a picture is a .png or an .exr file", path.display())),
    }
}

/// A name beside the picture's own that no other process writes to.
fn partial_name(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}.partial", std::process::id()));
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film(values: &[[f64; 3]]) -> Film {
        let tally = |value: &[f64; 3]| {
            let mut tally = Tally::default();
            tally.add(*value);
            tally
        };
        let tallies: Vec<Tally> = values.iter().map(tally).collect();
        Film::new(values.len() as u32, 1, &tallies)
    }

    #[test]
    fn pixels_are_encoded_by_srgb() {
        let (bytes, clipped) = film(&[[0.0, 1.0, 0.214_041_14], [2.0, 0.001, -1.0]]).encoded(0.0);
        assert_eq!((bytes, clipped), (vec![0, 255, 128, 255, 3, 0], 1));
        let (bytes, clipped) = film(&[[0.5, 0.25, 0.0]]).encoded(1.0);
        assert_eq!((bytes, clipped), (vec![255, 188, 0], 0));
    }

    #[test]
    fn the_variance_is_that_of_the_mean() {
        let mut tally = Tally::default();
        for x in [1.0, 2.0, 3.0, 4.0] {
            tally.add([x; 3]);
        }
        let (mean, variance) = tally.estimate();
        // The sample variance 5/3 over 4.
        assert!(mean == [2.5; 3] && (variance[0] - 5.0 / 12.0).abs() < 1e-6);
    }

    #[test]
    fn files_are_whole_or_absent() {
        let folder = std::env::temp_dir().join(format!("brdf-film-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let film = film(&[[0.5, 1.5, 0.25]]);
        for (name, clipped) in [("a.png", 1), ("a.exr", 0), ("B.PNG", 1), ("B.Exr", 0)] {
            assert_eq!(film.write(&folder.join(name), 0.0), Ok(clipped), "{name}");
        }
        for name in ["a.exr", "B.Exr"] {
            let back = image::open(folder.join(name)).expect("readable").into_rgb32f();
            assert_eq!(back.get_pixel(0, 0).0, [0.5, 1.5, 0.25]);
        }
        assert!(film.write(&folder.join("a.bmp"), 0.0).is_err());
        assert!(film.write(&folder.join("none").join("a.png"), 0.0).is_err());
        assert!(writable(&folder.join("b.png")).is_ok() && writable(&folder.join("a.exr")).is_ok());
        std::fs::create_dir(folder.join("c.png")).expect("a folder");
        for wrong in ["a.bmp", "none/a.png", "c.png"] {
            let error = writable(&folder.join(wrong)).expect_err(wrong);
            assert!(error.contains(wrong) && error.lines().count() == 1, "{error}");
        }
        let names = std::fs::read_dir(&folder).expect("a folder").count();
        assert_eq!(names, 5);
        let _ = std::fs::remove_dir_all(&folder);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_full_disk_is_an_error() {
        let film = film(&[[0.5, 1.5, 0.25]]);
        for format in [ImageFormat::Png, ImageFormat::OpenExr] {
            let full = File::options().write(true).open("/dev/full").expect("it is there");
            let error = film.write_into(full, format, 0.0).expect_err("nothing fits");
            assert!(error.contains("space") && error.lines().count() == 1, "{format:?}: {error}");
        }
    }

    #[test]
    fn pixels_that_are_no_numbers_are_counted() {
        assert_eq!(film(&[[0.5, 1.5, 0.25], [f64::NAN, 0.0, 0.0], [0.0, f64::INFINITY, 0.0]]).not_finite(), 2);
    }
}
