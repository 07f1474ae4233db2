//! Images that a material file names, from beside it.

use crate::material::description::{ImageRequest, MaterialFile, read_file};
use crate::texture::image::{Encoding, Image, srgb_to_linear};
use std::path::Path;

/// Reads a material file and the images that it names, whose paths are relative to its folder.
///
/// # Errors
/// One line: the file, the line and key, and what is wrong; for an image its path and what is wrong with it.
pub fn read_material(path: &Path) -> Result<MaterialFile, String> {
    let place = path.display();
    let text = std::fs::read_to_string(path).map_err(|error| format!("{place}: {error}"))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let load = |request: ImageRequest<'_>| read_image(&folder.join(request.file), request.encoding);
    read_file(&text, load).map_err(|error| format!("{place}: {error}"))
}

/// Reads an image: PNG of 8 or 16 bits, Radiance .hdr or OpenEXR. Of no effect on what holds numbers and not bytes is `encoding`.
///
/// # Errors
/// One line: the path and what is wrong: no file, no image, too large, a texel that is not finite.
pub fn read_image(path: &Path, encoding: Encoding) -> Result<Image, String> {
    let place = path.display();
    let reader = image::ImageReader::open(path).map_err(|error| format!("{place}: {error}"))?;
    let reader = reader.with_guessed_format().map_err(|error| format!("{place}: {error}"))?;
    let numbers = matches!(reader.format(), Some(image::ImageFormat::Hdr | image::ImageFormat::OpenExr));
    let decoded = reader.decode().map_err(|error| format!("{place}: {error}"))?;
    let mut texels = decoded.into_rgba32f();
    if encoding == Encoding::Srgb && !numbers {
        for pixel in texels.pixels_mut() {
            let [r, g, b, a] = pixel.0;
            let [r, g, b] = [r, g, b].map(|x| srgb_to_linear(f64::from(x)) as f32);
            pixel.0 = [r, g, b, a];
        }
    }
    let (width, height) = texels.dimensions();
    Image::new(width, height, 4, texels.into_raw()).map_err(|error| format!("{place}: {error}"))
}
