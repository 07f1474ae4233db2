//! Images of materials from files, and material files with theirs.
//!
//! PNG, Radiance HDR and OpenEXR. What is stored in 8 or 16 bits stands for numbers as the material says (sRGB or linear); what is stored in
//! floating point is linear.
//!
//! Files store their upper row first, and v rises upwards on every shape and in OBJ files: an image is turned over when it is read, so that a picture
//! stands upright where v is up, as it does in Blender. Green of a normal map is a slope towards growing v: +Y up, OpenGL's convention. A map
//! with green downwards (DirectX's) must have its green inverted.

use super::environment::multiplied;
use crate::material::description::{MaterialFile, read_file};
use crate::texture::image::{Encoding, Image, ImageError, srgb_to_linear};
use image::DynamicImage;
use std::path::Path;

/// What a decoder may take: [`MOST_TEXELS`](crate::texture::image::MOST_TEXELS) of four channels in floating point.
const MOST_BYTES: u64 = 4 << 30;

/// Reads an image, the lowest row of the picture first: v = 0 is its lower edge.
///
/// # Errors
/// One line: the file, and what is wrong with it; rows are counted from the top, as in the file.
pub fn read_image(path: &Path, encoding: Encoding) -> Result<Image, String> {
    let place = |error: String| format!("{}: {error}", path.display());
    let reader = image::ImageReader::open(path).map_err(|error| place(error.to_string()))?;
    let mut reader = reader.with_guessed_format().map_err(|error| place(error.to_string()))?;
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits);
    let is_radiance = reader.format() == Some(image::ImageFormat::Hdr);
    let mut picture = reader.decode().map_err(|error| match error {
        image::ImageError::Limits(_) => {
            place(format!("its texels take more than {} GiB: scale it down", MOST_BYTES >> 30))
        }
        error => place(error.to_string()),
    })?;
    if is_radiance
        && let DynamicImage::ImageRgb32F(picture) = &mut picture
        && let Some(scale) = multiplied(path).map_err(place)?
    {
        picture.pixels_mut().for_each(|pixel| pixel.0 = [0, 1, 2].map(|c: usize| pixel.0[c] / scale[c]));
    }
    let picture = picture.flipv();
    let (width, height) = (picture.width(), picture.height());
    let channels = u32::from(picture.color().channel_count());
    let bytes = |bytes: &[u8]| Image::from_bytes(width, height, channels, bytes, encoding);
    let words = |words: &[u16]| {
        let number = |(index, word): (usize, &u16)| {
            let share = f64::from(*word) / 65535.0;
            let alpha = matches!(channels, 2 | 4) && index % channels as usize == channels as usize - 1;
            (if encoding == Encoding::Srgb && !alpha { srgb_to_linear(share) } else { share }) as f32
        };
        Image::new(width, height, channels, words.iter().enumerate().map(number).collect())
    };
    let read = match &picture {
        DynamicImage::ImageLuma8(picture) => bytes(picture),
        DynamicImage::ImageLumaA8(picture) => bytes(picture),
        DynamicImage::ImageRgb8(picture) => bytes(picture),
        DynamicImage::ImageRgba8(picture) => bytes(picture),
        DynamicImage::ImageLuma16(picture) => words(picture),
        DynamicImage::ImageLumaA16(picture) => words(picture),
        DynamicImage::ImageRgb16(picture) => words(picture),
        DynamicImage::ImageRgba16(picture) => words(picture),
        DynamicImage::ImageRgb32F(picture) => Image::new(width, height, 3, picture.as_raw().clone()),
        DynamicImage::ImageRgba32F(picture) => Image::new(width, height, 4, picture.as_raw().clone()),
        other => return Err(place(format!("{:?} is no kind of image that a material reads", other.color()))),
    };
    read.map_err(|error| match error {
        ImageError::NotFinite { x, y, channel } => ImageError::NotFinite { x, y: height - 1 - y, channel },
        other => other,
    })
    .map_err(|error| place(error.to_string()))
}

/// Reads a material file, and the images that it names from beside it.
///
/// # Errors
/// One line: the file, the line and key in it, and what is wrong or allowed there; of an image its own file.
pub fn read_material(path: &Path) -> Result<MaterialFile, String> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    parse_material(path, &text)
}

/// [`read_material`] of a text that was read: images are looked for beside `path`.
///
/// # Errors
/// As [`read_material`].
pub fn parse_material(path: &Path, text: &str) -> Result<MaterialFile, String> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let load = |request: crate::material::description::ImageRequest<'_>| {
        read_image(&folder.join(request.file), request.encoding)
    };
    read_file(text, load).map_err(|error| format!("{}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{Luma, LumaA, Rgb};

    #[test]
    fn images_and_their_materials_are_read() {
        let folder = std::env::temp_dir().join(format!("brdf-texture-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let save = |name: &str, picture: DynamicImage| picture.save(folder.join(name)).expect("written");
        save("grey.png", DynamicImage::ImageLuma8(image::GrayImage::from_pixel(2, 1, Luma([128]))));
        save("fine.png", DynamicImage::ImageLumaA16(image::ImageBuffer::from_pixel(1, 1, LumaA([32896, 32896]))));
        save("float.exr", DynamicImage::ImageRgb32F(image::ImageBuffer::from_pixel(1, 2, Rgb([0.25, 2.0, 4.0]))));
        let broken = |_, y| Rgb([0.0, if y == 0 { f32::NAN } else { 1.0 }, 0.0]);
        save("nan.exr", DynamicImage::ImageRgb32F(image::ImageBuffer::from_fn(1, 3, broken)));
        let rising = |_, y| Luma([if y == 0 { 200u8 } else { 50 }]);
        save("rising.png", DynamicImage::ImageLuma8(image::ImageBuffer::from_fn(1, 2, rising)));
        let first = |name: &str, encoding| {
            read_image(&folder.join(name), encoding).map(|image| image.texels().next().unwrap_or_default())
        };
        // 128/255 = 0.50196 is 0.21586 decoded; 32896/65535 is the same number.
        let close = |got: [f32; 4], want: [f32; 4]| got.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-5);
        let half = 128.0 / 255.0;
        assert!(close(first("grey.png", Encoding::Linear).expect("read"), [half, half, half, 1.0]));
        let [r, g, b] = [0.215_86; 3];
        assert!(close(first("grey.png", Encoding::Srgb).expect("read"), [r, g, b, 1.0]));
        assert!(close(first("fine.png", Encoding::Srgb).expect("read"), [r, g, b, half]));
        assert!(close(first("float.exr", Encoding::Srgb).expect("read"), [0.25, 2.0, 4.0, 1.0]));
        let error = first("nan.exr", Encoding::Linear).expect_err("NaN");
        assert!(error.contains("nan.exr: the texel in column 0, row 0 "), "{error}");
        // The lower row is the first: v rises.
        let low = 50.0 / 255.0;
        assert!(close(first("rising.png", Encoding::Linear).expect("read"), [low, low, low, 1.0]));
        assert!(first("absent.png", Encoding::Linear).expect_err("absent").contains("absent.png: "));

        let material = |image: &str| {
            let path = folder.join("material.toml");
            let text = format!(
                "[[part]]\nlayer = [{{ interface = {{ diffuse = {{ albedo = {{ image = \"{image}\" }}, sigma = 0.3 }} }} }}]\n"
            );
            std::fs::write(&path, text).expect("written");
            read_material(&path)
        };
        let read = material("grey.png").expect("valid");
        assert!(close(read.material.images()[0].texels().next().unwrap_or_default(), [r, g, b, 1.0]));
        let error = material("absent.png").expect_err("absent");
        assert!(error.contains("material.toml: ") && error.contains("absent.png"), "{error}");
        let _ = std::fs::remove_dir_all(&folder);
    }
}
