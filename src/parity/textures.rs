//! The twins of [`crate::texture`] and the inputs they are compared on.

use super::draw::Draw;
use super::table::{Flat, Judge, Twin, at, coordinates};
use crate::frame::Vector;
use crate::gpu::StackBuffers;
use crate::interval::WgslInterval;
use crate::random::random;
use crate::real::Real;
use crate::texture::image::{self, Image};
use crate::texture::ramp::{self, Ramp, Stop};
use crate::texture::{bump, mask, noise, scratch};
use std::sync::OnceLock;

/// Images of numbers in [0, 1], of each number of channels, one column or row among them; and where each begins.
fn images() -> &'static [(u32, Image)] {
    static IMAGES: OnceLock<Vec<(u32, Image)>> = OnceLock::new();
    IMAGES.get_or_init(|| {
        let mut first = 0;
        let sizes = [(7, 3, 1), (1, 7, 2), (3, 1, 3), (3, 7, 4)];
        let image = |(width, height, channels)| {
            let texels = (0..width * height * channels).map(|i| random::<f32>(channels, i, 0)[0]).collect();
            let image = Image::new(width, height, channels, texels).ok()?;
            first += width * height;
            Some((first - width * height, image))
        };
        sizes.into_iter().filter_map(image).collect()
    })
}

/// Ramps of one to nine stops, two of them at one place, and where each begins.
fn ramps() -> &'static [(u32, Ramp<3>)] {
    static RAMPS: OnceLock<Vec<(u32, Ramp<3>)>> = OnceLock::new();
    RAMPS.get_or_init(|| {
        let colour = |index: u32| -> [f32; 3] {
            let [r, g, b, _] = random(7, index, 1);
            [r, g, b]
        };
        let colours: Vec<_> = (0..9).map(colour).collect();
        let jump =
            [0.125, 0.375, 0.375, 0.75].into_iter().zip(&colours).map(|(at, colour)| Stop { at, colour: *colour });
        let all =
            [Ramp::even(&colours[..5]), Ramp::banded(&colours[4..]), Ramp::even(&colours), Ramp::even(&colours[..1])];
        let mut first = 0;
        let place = |ramp: Ramp<3>| {
            first += ramp.stops().len() as u32;
            (first - ramp.stops().len() as u32, ramp)
        };
        all.into_iter().chain([Ramp::new(jump)]).flatten().map(place).collect()
    })
}

/// Their texels and stops.
pub(super) fn buffers() -> &'static StackBuffers {
    static BUFFERS: OnceLock<StackBuffers> = OnceLock::new();
    BUFFERS.get_or_init(|| StackBuffers {
        texels: images().iter().flat_map(|(_, image)| image.texels()).map(|texel| texel.map(f64::from)).collect(),
        stops: ramps()
            .iter()
            .flat_map(|(_, ramp)| ramp.stops())
            .map(|Stop { at, colour: [r, g, b] }| [*r, *g, *b, *at].map(f64::from))
            .collect(),
        ..StackBuffers::default()
    })
}

/// One of a list.
fn pick<'a, T>(d: &mut Draw, all: &'a [T]) -> &'a T {
    &all[((d.unit() * all.len() as f64) as usize).min(all.len() - 1)]
}

/// The first texel of an image, its size, and coordinates in and around it.
fn image_and_place(d: &mut Draw) -> Vec<f64> {
    let (first, image) = pick(d, images());
    let size = [*first, image.width(), image.height()].map(f64::from);
    flat![size, d.between(-1.7, 2.3), d.between(-1.7, 2.3)]
}

fn image_of<R: Real>(first: R) -> &'static Image {
    let found = images().iter().find(|(place, _)| f64::from(*place) == first.to_f64());
    found.map_or(&images()[0].1, |(_, image)| image)
}

/// The first stop of a ramp and their number; in one of sixteen samples none.
fn ramp_place(d: &mut Draw) -> [f64; 2] {
    let (first, ramp) = pick(d, ramps());
    let none = d.unit() < 1.0 / 16.0;
    [f64::from(*first), if none { 0.0 } else { ramp.stops().len() as f64 }]
}

fn stops_of<R: Real>(a: &[R]) -> &'static [Stop<3>] {
    let found = ramps().iter().find(|(place, _)| f64::from(*place) == a[0].to_f64());
    found.filter(|_| a[1].to_f64() > 0.0).map_or(&[], |(_, ramp)| ramp.stops())
}

/// A unit normal of a bump, by its slopes.
fn normal(d: &mut Draw) -> Vector<f64> {
    bump::normal_from_slopes(d.between(-4.0, 3.0), d.between(-0.1, 50.0))
}

/// A point off the lattice, whose octaves in f32 hardly meet it.
fn point_and_seed(d: &mut Draw) -> Vec<f64> {
    flat![d.between(-19.3, 20.7), d.between(-19.3, 20.7), d.between(-0.13, 0.21), d.word()]
}

/// As [`point_and_seed`], and amplitude, frequency, octaves, gain and lacunarity.
fn point_and_octaves(d: &mut Draw) -> Vec<f64> {
    let p = [d.between(-4.3, 3.9), d.between(-4.3, 3.9), d.between(-0.13, 0.21)];
    let octaves = (5.0 * d.unit()).floor();
    flat![p, d.word(), d.between(-1.0, 2.0), d.between(0.31, 2.93), octaves, d.fraction(), d.between(1.71, 2.13)]
}

/// As [`point_and_seed`], and density, width and layers.
fn point_and_scratches(d: &mut Draw) -> Vec<f64> {
    let mut arguments = point_and_seed(d);
    arguments.extend([d.fraction(), d.between(-0.03, 0.43), (5.0 * d.unit()).floor()]);
    arguments
}

fn word<R: Real>(x: R) -> u32 {
    x.to_f64() as u32
}

fn triple<R: Real>(a: &[R], start: usize) -> [R; 3] {
    coordinates(at(a, start))
}

/// Every twin of a texture.
#[rustfmt::skip]
pub(super) fn twins() -> Vec<Twin> {
    vec![
        twin!(noise::gradient / 2, point_and_seed, |a| [noise::gradient(at(a, 0), word(a[3]))]),
        twin!(noise::gradient_slope / 2, point_and_seed, |a| coordinates(noise::gradient_slope(at(a, 0), word(a[3])))),
        twin!(noise::fractal / 7, point_and_octaves,
            |a| [noise::fractal(at(a, 0), word(a[3]), a[4], a[5], word(a[6]), a[7], a[8])]),
        twin!(noise::fractal_slope / 7, point_and_octaves,
            |a| coordinates(noise::fractal_slope(at(a, 0), word(a[3]), a[4], a[5], word(a[6]), a[7], a[8]))),
        twin!(noise::ridged / 7, point_and_octaves,
            |a| [noise::ridged(at(a, 0), word(a[3]), a[4], a[5], word(a[6]), a[7], a[8])]),

        twin!(scratch::scratches / 5, point_and_scratches,
            |a| [scratch::scratches(at(a, 0), word(a[3]), a[4], a[5], word(a[6]))]),

        twin!(ramp::two / 3, |d| flat![std::array::from_fn::<_, 9, _>(|_| d.fraction())],
            |a| ramp::two(triple(a, 0), triple(a, 3), triple(a, 6))),
        twin!(ramp::ramp / 3, |d| flat![ramp_place(d), d.between(-0.23, 1.31)], |a| ramp::ramp(stops_of(a), a[2])),
        twin!(ramp::bands / 4, |d| flat![ramp_place(d), d.fraction(), d.between(-0.23, 1.31)],
            |a| ramp::bands(stops_of(a), a[2], a[3])),
        twin!(ramp::aged / 3, |d| flat![d.between(-0.2, 1.2), d.between(-0.2, 1.2), (6.0 * d.unit()).floor()],
            |a| [ramp::aged(a[0], a[1], word(a[2]))]),

        twin!(mask::threshold / 2, |d| flat![d.fraction(), d.fraction()], |a| [mask::threshold(a[0], a[1])]),
        twin!(mask::soft_threshold / 3, |d| flat![d.between(-1.0, 2.0), d.fraction(), d.between(-0.1, 1.0)],
            |a| [mask::soft_threshold(a[0], a[1], a[2])]),
        twin!(mask::grey / 3, |d| flat![d.between(-1.0, 2.0), d.fraction(), d.fraction()], |a| [mask::grey(a[0], a[1], a[2])]),

        twin!(bump::normal_from_slopes / 2, |d| flat![d.between(-4.0, 3.0), d.between(-0.1, 50.0)],
            |a| coordinates(bump::normal_from_slopes(a[0], a[1]))),
        twin!(bump::slopes / 4, |d| flat![d.fraction(), d.fraction(), d.fraction(), d.between(-0.01, 0.1)],
            |a| bump::slopes(a[0], a[1], a[2], a[3])),
        twin!(bump::tilted / 2, |d| flat![d.direction(), d.between(-4.0, 3.0), d.between(-1.0, 1.0), d.between(-0.1, 7.0)],
            |a| coordinates(bump::tilted(at(a, 0), at(a, 3)))),
        twin!(bump::decode_rgb / 1, |d| flat![d.fraction(), d.fraction(), d.fraction()],
            |a| coordinates(bump::decode_rgb(triple(a, 0)))),
        twin!(bump::decode_two_channel / 2, |d| flat![d.fraction(), d.fraction()],
            |a| coordinates(bump::decode_two_channel(a[0], a[1]))),
        twin!(bump::encode / 1, |d| flat![d.direction()], |a| bump::encode(at(a, 0))),
        twin!(bump::scaled / 2, |d| flat![d.direction(), d.between(0.0, 8.0)], |a| coordinates(bump::scaled(at(a, 0), a[3]))),
        twin!(bump::combined / 2, |d| flat![normal(d), normal(d)], |a| coordinates(bump::combined(at(a, 0), at(a, 3)))),
        twin!(bump::frame_about / 1, |d| flat![d.direction()], |a| {
            let frame = bump::frame_about(at(a, 0));
            let [t, b, n] = [frame.tangent, frame.bitangent, frame.normal].map(coordinates);
            [t[0], t[1], t[2], b[0], b[1], b[2], n[0], n[1], n[2]]
        }),

        twin!(image::bilinear / 4, image_and_place, |a| image::bilinear(image_of(a[0]), [a[3], a[4]])),
        twin!(image::bilinear_clamped / 4, image_and_place, |a| image::bilinear_clamped(image_of(a[0]), [a[3], a[4]])),
        twin!(image::nearest / 4, image_and_place, |a| image::nearest(image_of(a[0]), [a[3], a[4]])),
        twin!(image::nearest_clamped / 4, image_and_place, |a| image::nearest_clamped(image_of(a[0]), [a[3], a[4]])),
    ]
}
