//! Images against their texels, and the curve of sRGB against its definition.

use super::*;
use alloc::string::ToString;
use alloc::vec;

/// Three columns, two rows, one channel of multiples of 1/8.
fn grey() -> Image {
    Image::new(3, 2, 1, vec![0.125, 0.5, 1.0, 0.75, 0.25, 0.0]).expect("an image")
}

fn centre(i: u32, size: u32) -> f64 {
    (f64::from(i) + 0.5) / f64::from(size)
}

#[test]
fn texels_are_exact_at_their_centres() {
    for (wrap, filter) in [
        (Wrap::Repeat, Filter::Bilinear),
        (Wrap::Clamp, Filter::Bilinear),
        (Wrap::Repeat, Filter::Nearest),
        (Wrap::Clamp, Filter::Nearest),
    ] {
        let image = grey().with_wrap(wrap).with_filter(filter);
        for (x, y) in [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)] {
            let want = image.texel(x, y).map(f64::from);
            let got = image.sample([centre(x, 3), centre(y, 2)]);
            for (got, want) in got.into_iter().zip(want) {
                // The centre's column is off by ≤ 2ε, times a slope ≤ 1 along each axis.
                assert!((got - want).abs() <= 6.0 * f64::EPSILON, "{wrap:?} {filter:?} {x} {y}: {got} {want}");
            }
        }
    }
}

#[test]
fn what_is_linear_stays_so_between_the_centres() {
    // A plane a + b·x + c·y of the columns and rows.
    let plane = |x: f64, y: f64| 0.25 + 0.125 * x - 0.0625 * y;
    let texels = (0..4 * 3).map(|i| plane(f64::from(i % 4), f64::from(i / 4)) as f32).collect();
    let image = Image::new(4, 3, 1, texels).expect("an image").with_wrap(Wrap::Clamp);
    for i in 0..=30 {
        for j in 0..=20 {
            let (x, y) = (f64::from(i) / 10.0, f64::from(j) / 10.0);
            let [got, .., alpha] = image.sample([(x + 0.5) / 4.0, (y + 0.5) / 3.0]);
            assert!(
                (got - plane(x, y)).abs() < 8.0 * f64::EPSILON && (alpha - 1.0).abs() <= f64::EPSILON,
                "{x} {y}: {got}"
            );
        }
    }
}

#[test]
fn edges_repeat_or_stay() {
    let image = grey();
    // Halfway between the last and the first column, as the image is repeated; v at the first row's centre.
    assert_eq!(bilinear(&image, [0.0f32, 0.25])[0], 0.5625);
    assert_eq!(bilinear(&image, [1.0f32, 0.25])[0], 0.5625);
    assert_eq!(bilinear(&image, [-3.0f32, 0.25])[0], 0.5625);
    assert_eq!(bilinear_clamped(&image, [0.0f32, 0.25])[0], 0.125);
    assert_eq!(bilinear_clamped(&image, [-7.0f32, -1.0])[0], 0.125);
    assert_eq!(bilinear_clamped(&image, [7.0f32, 9.0])[0], 0.0);
    assert_eq!(nearest(&image, [-0.01f32, 0.0])[0], 1.0);
    assert_eq!(nearest_clamped(&image, [1.0f32, 1.0])[0], 0.0);
    // Just below 0 the coordinate rounds to 1: still within the image.
    for f in [bilinear::<f32>, nearest, bilinear_clamped, nearest_clamped] {
        for u in [-1e-30, -0.0, 1e-30, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, f32::MAX] {
            let got = f(&image, [u, u]);
            assert!(got.iter().all(|x| (0.0..=1.0).contains(x)), "{u}: {got:?}");
        }
    }
}

#[test]
fn the_mean_over_a_period_is_that_of_the_texels() {
    // Bilinear filtering is a partition of unity; sampled 8 times a texel at the centres of eighths, exactly.
    let image = grey();
    let mut sum = 0.0f64;
    for i in 0..24 {
        for j in 0..16 {
            sum += bilinear(&image, [centre(i, 24), centre(j, 16)])[0];
        }
    }
    assert!((sum / 384.0 - 2.625 / 6.0).abs() < 1e-14, "{sum}");
}

#[test]
fn channels_fill_the_four() {
    for (channels, want) in [
        (1, [0.5, 0.5, 0.5, 1.0]),
        (2, [0.5, 0.5, 0.5, 0.25]),
        (3, [0.5, 0.25, 0.125, 1.0]),
        (4, [0.5, 0.25, 0.125, 0.75]),
    ] {
        let numbers = [0.5, 0.25, 0.125, 0.75];
        let image = Image::new(1, 1, channels, numbers[..channels as usize].to_vec()).expect("an image");
        assert_eq!(image.texel(9, 9), want);
        assert_eq!(image.texels().collect::<Vec<_>>(), [want]);
        assert_eq!(image.sample([0.3f32, 0.9]), want);
    }
}

#[test]
fn what_is_no_image_is_refused_with_its_place() {
    assert_eq!(Image::new(0, 4, 1, vec![]), Err(ImageError::Size { width: 0, height: 4 }));
    let huge = ImageError::Size { width: u32::MAX, height: u32::MAX };
    assert_eq!(Image::new(u32::MAX, u32::MAX, 4, vec![]), Err(huge));
    assert_eq!(Image::new(1, 1, 5, vec![0.0; 5]), Err(ImageError::Channels { channels: 5 }));
    assert_eq!(Image::new(1, 1, 0, vec![]), Err(ImageError::Channels { channels: 0 }));
    assert_eq!(Image::new(2, 2, 3, vec![0.0; 11]), Err(ImageError::Length { want: 12, got: 11 }));
    let mut texels = vec![0.0; 12];
    texels[10] = f32::NAN;
    assert_eq!(Image::new(2, 2, 3, texels), Err(ImageError::NotFinite { x: 1, y: 1, channel: 1 }));
    let bytes = Image::from_bytes(2, 1, 1, &[1, 2, 3], Encoding::Linear);
    assert_eq!(bytes, Err(ImageError::Length { want: 2, got: 3 }));
    for error in [
        ImageError::Size { width: 0, height: 4 },
        ImageError::Channels { channels: 5 },
        ImageError::Length { want: 12, got: 11 },
        ImageError::NotFinite { x: 1, y: 1, channel: 1 },
    ] {
        let line = error.to_string();
        assert!(line.contains(": ") && !line.contains('\n'), "{line}");
    }
}

#[test]
fn the_curve_is_that_of_its_definition() {
    // IEC 61966-2-1, by powf where the library has it.
    for byte in 0..=255 {
        let c = f64::from(byte) / 255.0;
        let want = if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
        let got = srgb_to_linear(c);
        // ln to 1 ULP of up to 2.7, times 2.4, is an error of the exponent of 6.5 · 2⁻⁵³·2.
        assert!((got - want).abs() <= 8.0 * f64::EPSILON * want, "{byte}: {got} {want}");
        // The two branches of the standard meet to 3e-8 alone.
        assert!((linear_to_srgb(got) - c).abs() < 1e-7, "{byte}");
    }
    assert_eq!(srgb_to_linear(0.0), 0.0);
    assert!((srgb_to_linear(1.0) - 1.0).abs() <= f64::EPSILON);
    assert_eq!(srgb_to_linear(-0.5), -srgb_to_linear(0.5));
    let bytes = [255, 188, 0, 128];
    let image = Image::from_bytes(1, 1, 4, &bytes, Encoding::Srgb).expect("an image").texel(0, 0);
    let linear = Image::from_bytes(1, 1, 4, &bytes, Encoding::Linear).expect("an image").texel(0, 0);
    assert!((image[1] - 0.5028865).abs() < 1e-6 && image[3] == linear[3] && linear[1] == (188.0 / 255.0) as f32);
}
