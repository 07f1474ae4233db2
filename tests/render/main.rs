//! Pictures against what is known of them: closed forms, furnaces, themselves in other ways, and files that are broken.
#![cfg(feature = "render")]

#[cfg(feature = "gpu")]
#[path = "../adapters/mod.rs"]
mod adapters;
#[cfg(feature = "gpu")]
mod on_a_gpu;

use brdf::layered::{Interface, Layer, Model, Stack};
use brdf::material::{Material, built_in, stack};
use brdf::render::camera::{Camera, Orbit};
use brdf::render::environment::Environment;
use brdf::render::light::{Falloff, Light};
use brdf::render::mesh::Mesh;
use brdf::render::offline::{self, Options, Strategy};
use brdf::render::shape::{Ray, Shape};
use brdf::render::torus::Torus;
use brdf::render::{Film, Scene, realtime, sources};
use brdf::{Frame, Vector};
use std::path::PathBuf;

fn scene(material: impl Into<Material>, environment: Environment, side: u32) -> Scene {
    Scene {
        shape: Shape::Sphere,
        material: material.into(),
        camera: Camera::new(&Orbit::default(), side, side).unwrap(),
        lights: Vec::new(),
        environment,
        backdrop: true,
    }
}

fn lambert(albedo: f64) -> Stack<f64, 3> {
    Stack::new(Model::Conserving, vec![Layer::new(Interface::diffuse([albedo; 3], 0.0))]).unwrap()
}

fn silent(_: f64) {}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("brdf-render-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

const CUBE: &str = "\
v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

fn mesh(name: &str, text: &str) -> Result<Mesh, String> {
    let folder = folder(name);
    let path = folder.join("mesh.obj");
    std::fs::write(&path, text).unwrap();
    let read = Mesh::read(&path);
    let _ = std::fs::remove_dir_all(&folder);
    read
}

/// Every pixel against 1 + 3σ of its own, and the rounding of 64-bit sums in 32-bit pixels.
fn furnace_holds(name: &str, film: &Film) {
    for (pixel, (mean, variance)) in film.mean().iter().zip(film.variance()).enumerate() {
        for c in 0..3 {
            let most = 1.0 + 3.0 * variance[c].sqrt() + 1e-6;
            assert!(mean[c] <= most, "{name}: pixel {pixel}, channel {c}: {} > {most}", mean[c]);
        }
    }
}

#[test]
fn no_stack_reflects_more_than_arrives() {
    let options = Options { samples: 64, ..Options::default() };
    for found in stack::built_in() {
        let film = offline::render(&scene(found.stack, Environment::furnace(), 40), options, &silent);
        furnace_holds(found.name, &film);
    }
}

#[test]
fn no_material_reflects_more_than_arrives() {
    let options = Options { samples: 32, ..Options::default() };
    // As printed, two of the documents' materials gain energy; FORMULAS.md, errata 12 and 4.
    for found in built_in::all().into_iter().filter(|found| !found.name.ends_with("as_printed")) {
        let film = offline::render(&scene(found.material().unwrap(), Environment::furnace(), 32), options, &silent);
        furnace_holds(found.name, &film);
    }
}

#[test]
fn a_white_base_in_a_furnace_is_white() {
    // Drawn from the cosine, each path's weight is (1/π)·cos/(cos/π): 1 but for three roundings.
    let alone = Options { samples: 4, strategy: Strategy::Material, ..Options::default() };
    let furnace = scene(lambert(1.0), Environment::furnace(), 32);
    let film = offline::render(&furnace, alone, &silent);
    assert!(film.mean().as_flattened().iter().all(|x| (x - 1.0).abs() < 1e-6));
    // In both ways the paths vary, the mean does not.
    let film = offline::render(&furnace, Options { samples: 64, ..Options::default() }, &silent);
    let count = film.mean().len() as f64;
    let mean = film.mean().iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / count;
    let error = film.variance().iter().map(|pixel| f64::from(pixel[0])).sum::<f64>().sqrt() / count;
    assert!((mean - 1.0).abs() < 4.0 * error, "{mean} ± {error}");
    // Of 700 pixels whose mean *is* 1 one is beyond 3σ; none is beyond 5.
    for (mean, variance) in film.mean().iter().zip(film.variance()) {
        assert!((mean[0] - 1.0).abs() <= 5.0 * variance[0].sqrt() + 1e-6, "{mean:?} {variance:?}");
    }
}

#[test]
fn realtime_furnaces_are_not_brighter_than_one() {
    for found in stack::built_in() {
        let film = realtime::render::<f64>(&scene(found.stack, Environment::furnace(), 32), 1, &silent);
        // Texels are f32: a sum of their weights is 1 to 1e-6.
        let largest = film.mean().as_flattened().iter().fold(0.0f32, |a, b| a.max(*b));
        assert!(largest <= 1.0 + 1e-5, "{}: {largest}", found.name);
    }
}

#[test]
fn a_lit_lambertian_sphere_has_its_closed_form() {
    let towards = Vector::new(0.6, -0.64, 0.48);
    let irradiance = [2.0, 3.0, 5.0];
    let position = Vector::new(1.5, -2.0, 1.0);
    for (light, at) in [
        (Light::Directional { towards, irradiance }, None),
        (Light::Point { position, intensity: irradiance, falloff: Falloff::InverseSquare }, Some(2.0)),
        (Light::Point { position, intensity: irradiance, falloff: Falloff::Inverse }, Some(1.0)),
    ] {
        let mut lit = scene(lambert(0.8), Environment::dark(), 24);
        lit.lights = vec![light];
        let film = realtime::render::<f64>(&lit, 1, &silent);
        let traced = offline::render(&lit, Options { samples: 64, ..Options::default() }, &silent);
        // The closed form along a ray: the nearer root of |o + t·d| = 1.
        let radiance = |pixel: u32, within: [f64; 2]| -> Option<[f64; 3]> {
            let ray = lit.camera.ray::<f64>(pixel, within);
            let along = ray.origin.dot(ray.direction);
            let square = along * along - (ray.origin.length_squared() - 1.0);
            let normal = (square > 0.0).then(|| ray.at(-along - square.sqrt()))?;
            let (way, scale) = match at {
                None => (towards, 1.0),
                Some(power) => {
                    let way = position - normal;
                    let distance = way.length_squared().sqrt();
                    (way * (1.0 / distance), distance.powf(-power))
                }
            };
            let cosine = normal.dot(way).max(0.0);
            Some(irradiance.map(|e| 0.8 / std::f64::consts::PI * e * scale * cosine))
        };
        let mut shown = 0;
        for pixel in 0..24 * 24 {
            let want = radiance(pixel, [0.5, 0.5]);
            shown += usize::from(want.is_some());
            let want = want.unwrap_or_default();
            let (got, mean) = (film.mean()[pixel as usize], traced.mean()[pixel as usize]);
            // A pixel of the path tracer is the mean of 64 points of its area, which 32×32 points on a grid tell with its variance.
            let points = (0..1024).map(|i| [f64::from(i % 32) + 0.5, f64::from(i / 32) + 0.5].map(|x| x / 32.0));
            let points: Vec<[f64; 3]> = points.map(|within| radiance(pixel, within).unwrap_or_default()).collect();
            for c in 0..3 {
                // Double precision throughout, rounded to f32.
                assert!((f64::from(got[c]) - want[c]).abs() <= 1e-6 * want[c] + 1e-9, "{light:?}: {got:?} {want:?}");
                let area = points.iter().map(|x| x[c]).sum::<f64>() / 1024.0;
                let variance = points.iter().map(|x| (x[c] - area).powi(2)).sum::<f64>() / 1024.0;
                let most = points.iter().fold(0.0f64, |most, x| most.max(x[c]));
                // Five deviations of the mean; the grid misses half of its width along an edge, 1/64 of the pixel.
                let tolerance =
                    5.0 * (variance / 64.0).sqrt() + most / 64.0 * f64::from(u8::from(variance > 0.0)) + 1e-6;
                assert!((f64::from(mean[c]) - area).abs() <= tolerance, "{light:?}: {mean:?} {area} ± {tolerance}");
            }
        }
        assert!(shown > 250, "{shown}");
    }
}

/// z of each pixel of one channel: the difference of two pictures over its standard deviation, of those that vary.
fn scores(a: &Film, b: &Film, channel: usize) -> Vec<f64> {
    let mut all = Vec::new();
    for (((a, va), b), vb) in a.mean().iter().zip(a.variance()).zip(b.mean()).zip(b.variance()) {
        let deviation = f64::from(va[channel] + vb[channel]).sqrt();
        let difference = f64::from(a[channel]) - f64::from(b[channel]);
        // Where nothing varies but rounding, as in a furnace's background, the two agree.
        if deviation <= 1e-5 * f64::from(a[channel]).max(1e-6) {
            assert!(difference.abs() <= 1e-4 * f64::from(a[channel]).max(1e-3), "{a:?} {b:?}");
        } else {
            all.push(difference / deviation);
        }
    }
    all
}

/// The two pictures are of one scene: their z are normal. Each of the three bounds is exceeded by chance in one case of 1000 or less.
fn agrees(what: &str, a: &Film, b: &Film) {
    let mut z = scores(a, b, 1);
    let n = z.len() as f64;
    assert!(n >= 100.0, "{what}: {n} pixels vary");
    let mean = z.iter().sum::<f64>() / n;
    assert!(mean.abs() < 3.3 / n.sqrt(), "{what}: mean z {mean} over {n}");
    // Variances are themselves estimated, of samples with long tails: z² is spread wider than χ² has it, so 1.5 times as wide.
    let square = z.iter().map(|z| z * z).sum::<f64>() / n;
    assert!((square - 1.0).abs() < 1.5 * 3.3 * (2.0 / n).sqrt(), "{what}: mean z² {square} over {n}");
    // Kolmogorov–Smirnov against the normal distribution: D·√n < 1.95.
    z.sort_by(f64::total_cmp);
    let normal = |x: f64| 0.5 * erfc(-x / std::f64::consts::SQRT_2);
    let far = z.iter().enumerate().map(|(i, z)| {
        let p = normal(*z);
        (p - i as f64 / n).abs().max((p - (i + 1) as f64 / n).abs())
    });
    let d = far.fold(0.0, f64::max) * n.sqrt();
    assert!(d < 1.95, "{what}: Kolmogorov–Smirnov {d}");
    let largest = z.iter().fold(0.0f64, |a, z| a.max(z.abs()));
    assert!(largest < 6.0, "{what}: |z| = {largest}");
}

/// erfc by Numerical Recipes' Chebyshev form, 1.2e-7 relative: enough for a distance of 1e-3.
fn erfc(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.5 * x.abs());
    let poly = [
        0.17087277,
        -0.82215223,
        1.48851587,
        -1.13520398,
        0.27886807,
        -0.18628806,
        0.09678418,
        0.37409196,
        1.00002368,
        -1.26551223,
    ];
    let sum = poly.iter().fold(0.0, |sum, c| sum * t + c);
    let y = t * (-x * x + sum).exp();
    if x >= 0.0 { y } else { 2.0 - y }
}

#[test]
fn light_is_found_the_same_in_every_way() {
    let stacks = ["clear_coat_over_copper", "varnish_over_concrete", "iron"];
    let stacks = stacks.map(|name| (name, Material::from(stack::by_name(name).unwrap())));
    // A lobe of two widths, and parts with a relief.
    let varied = ["brushed_steel", "worn_metal"];
    let varied = varied.map(|name| (name, built_in::by_name(name).unwrap().material().unwrap()));
    for (name, material) in stacks.into_iter().chain(varied) {
        let lit = scene(material, sources::by_name("studio").unwrap(), 32);
        let by = |strategy, seed| {
            let options = Options { samples: 256, seed, strategy, ..Options::default() };
            offline::render(&lit, options, &silent)
        };
        let both = by(Strategy::Both, 1);
        agrees(&format!("{name}: two seeds"), &both, &by(Strategy::Both, 2));
        for (strategy, seed) in [(Strategy::Material, 3), (Strategy::Environment, 4)] {
            // Drawn in one way alone, some light is seldom met: most pixels are a little too dark and few far too bright, their own variances with
            // them. Of sums over 8×8 pixels, 16384 paths, the central limit holds; 48 comparisons for each of 5 materials.
            let other = by(strategy, seed);
            for block in 0..16 {
                let sum = |values: &[[f32; 3]]| -> f64 {
                    let inside = |i: &usize| i / 32 / 8 * 4 + i % 32 / 8 == block;
                    (0..32 * 32).filter(inside).map(|i| f64::from(values[i][1])).sum()
                };
                let variance = sum(both.variance()) + sum(other.variance());
                let difference = sum(both.mean()) - sum(other.mean());
                assert!(
                    difference.abs() <= 4.5 * variance.sqrt() + 1e-4,
                    "{name}, {strategy:?}, block {block}: {difference}"
                );
            }
        }
    }
}

#[test]
fn single_and_double_precision_agree() {
    let lit = scene(stack::by_name("clear_coat_over_copper").unwrap(), sources::by_name("sky").unwrap(), 32);
    let options = |seed| Options { samples: 64, seed, ..Options::default() };
    agrees(
        "f32, f64",
        &offline::render_by_path::<f32>(&lit, options(1), &silent),
        &offline::render_by_path::<f64>(&lit, options(2), &silent),
    );
    let (single, double) = (realtime::render::<f32>(&lit, 1, &silent), realtime::render::<f64>(&lit, 1, &silent));
    let mut rim = 0;
    for (pixel, (a, b)) in single.mean().iter().zip(double.mean()).enumerate() {
        // A ray that touches the rim may hit in one precision alone.
        let hits = |pixel| {
            let of = |hit| u32::from(hit);
            of(realtime::fragments::<f32>(&lit, 1, pixel).all(|f| f.hit.is_some()))
                + of(realtime::fragments::<f64>(&lit, 1, pixel).all(|f| f.hit.is_some()))
        };
        if hits(pixel as u32) == 1 {
            rim += 1;
            continue;
        }
        for c in 0..3 {
            // A hit moves by 1e-6 or less in f32, and by 1e-6 over the cosine at the rim: lookups of a map that changes by up to 10 a texel
            // of 1/256 follow.
            assert!((a[c] - b[c]).abs() < 2e-2 * b[c].max(1.0), "pixel {pixel}: {a:?} {b:?}");
        }
    }
    assert!(rim <= 2, "{rim}");
}

#[test]
fn lambert_under_the_sky_is_the_same_in_both_modes() {
    let lit = scene(lambert(0.8), sources::by_name("sky").unwrap(), 24);
    let shown = realtime::render::<f64>(&lit, 8, &silent);
    let traced = offline::render(&lit, Options { samples: 1024, ..Options::default() }, &silent);
    let most = traced.mean().iter().fold(0.0f32, |most, pixel| most.max(pixel[1]));
    for pixel in 0..24 * 24u32 {
        // Within the outline: pixels that show the sky as well vary by it.
        if realtime::fragments::<f64>(&lit, 8, pixel).any(|fragment| fragment.hit.is_none()) {
            continue;
        }
        let place = pixel as usize;
        let (a, b) = (shown.mean()[place], traced.mean()[place]);
        let deviation = traced.variance()[place][1].sqrt();
        // Five deviations, and the bilinear texels of the irradiance.
        assert!((a[1] - b[1]).abs() < 5.0 * deviation + 6e-3 * most, "pixel {pixel}: {a:?} {b:?} ± {deviation}");
    }
}

#[test]
fn pictures_do_not_depend_on_the_threads() {
    let mut lit = scene(stack::by_name("gold").unwrap(), sources::by_name("sky").unwrap(), 33);
    lit.shape = Shape::Mesh(mesh("threads", CUBE).unwrap());
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let options = Options { samples: 5, seed: 7, ..Options::default() };
    let [one, three] = [1, 3].map(|n| pool(n).install(|| offline::render(&lit, options, &silent)));
    assert_eq!(one, three);
    let [one, three] = [1, 3].map(|n| pool(n).install(|| realtime::render::<f64>(&lit, 2, &silent)));
    assert_eq!(one, three);
    let other = offline::render(&lit, Options { seed: 8, ..options }, &silent);
    assert_ne!(offline::render(&lit, options, &silent), other);
}

#[test]
fn a_mesh_is_met_where_its_triangles_are() {
    let cube = Shape::Mesh(mesh("cube", CUBE).unwrap());
    // The cube's corners are on the unit sphere: its faces at 1/√3.
    let face = 1.0 / 3f64.sqrt();
    for azimuth in 0..48 {
        let eye = Vector::from_angles(1.2, f64::from(azimuth) * 0.13) * 4.0;
        for target in 0..25 {
            let target = Vector::new(0.2 * f64::from(target % 5) - 0.4, 0.2 * f64::from(target / 5) - 0.4, 0.1);
            let direction = (target - eye).normalized();
            // The slabs of the box.
            let walls = [(eye.x, direction.x), (eye.y, direction.y), (eye.z, direction.z)];
            let enters = walls.map(|(o, d)| ((-face - o) / d).min((face - o) / d));
            let want = enters.into_iter().fold(f64::MIN, f64::max);
            let hit = cube.hit(&Ray { origin: eye, direction }, f64::MAX).expect("met");
            // Corners are f32.
            assert!((hit.distance - want).abs() < 1e-5, "{} {want}", hit.distance);
            let frame: Frame<f64> = hit.frame;
            assert!(frame.normal.dot(direction) < 0.0 && hit.occlusion < 0.02, "{hit:?}");
        }
    }
}

#[test]
fn an_inner_corner_is_occluded() {
    // Two squares at a right angle, each of which hides half the other's hemisphere near the edge.
    let corner = "v 0 0 0\nv 9 0 0\nv 9 0 9\nv 0 0 9\nv 0 9 0\nv 0 9 9\nf 1 4 3 2\nf 1 5 6 4\n";
    let mesh = mesh("corner", corner).unwrap();
    assert!(mesh.occlusion().is_none());
    mesh.measure_occlusion(&silent);
    let (mut near, mut distant) = (0.0f32, 1.0f32);
    for occlusion in mesh.occlusion().unwrap().as_flattened() {
        (near, distant) = (near.max(*occlusion), distant.min(*occlusion));
    }
    // At the end of the edge a quarter of the hemisphere is hidden; 128 rays: ± 4·√(¼·¾/128).
    assert!((near - 0.25).abs() < 0.16 && distant < 0.1, "{near} {distant}");
}

#[test]
fn occlusion_is_measured_where_a_material_asks() {
    let corner = "v 0 0 0\nv 9 0 0\nv 9 0 9\nv 0 0 9\nv 0 9 0\nv 0 9 9\nf 1 4 3 2\nf 1 5 6 4\n";
    for (name, asks) in [("rusty_iron", false), ("worn_metal", true)] {
        let material = built_in::by_name(name).unwrap().material().unwrap();
        let mut seen = scene(material, Environment::furnace(), 4);
        seen.shape = Shape::Mesh(mesh("asked", corner).unwrap());
        let told = std::sync::atomic::AtomicBool::new(false);
        seen.prepare(&|_| told.store(true, std::sync::atomic::Ordering::Relaxed));
        let Shape::Mesh(mesh) = &seen.shape else { panic!("a mesh") };
        assert_eq!((mesh.occlusion().is_some(), told.into_inner()), (asks, asks), "{name}");
        realtime::render::<f32>(&seen, 1, &silent);
    }
}

#[test]
fn a_ray_within_a_wall_of_boxes_meets_the_mesh() {
    // A grid of 8×8 squares around the middle, whose boxes have walls at the very coordinates of these rays.
    let mut grid = String::new();
    for i in 0..81 {
        grid += &format!("v {} 0 {}\n", i % 9 - 4, i / 9 - 4);
    }
    for i in 0..64 {
        let first = i / 8 * 9 + i % 8 + 1;
        grid += &format!("f {} {} {} {}\n", first, first + 9, first + 10, first + 1);
    }
    let grid = mesh("grid", &grid).unwrap();
    let mut walls: Vec<f32> = grid.triangles().iter().flatten().map(|vertex| vertex.position[0]).collect();
    walls.sort_by(f32::total_cmp);
    walls.dedup();
    assert_eq!(walls.len(), 9);
    let (grid, other, half) = (Shape::Mesh(grid), 0.1234, 0.5f64.sqrt());
    for wall in walls[1..8].iter().map(|x| f64::from(*x)) {
        for (origin, direction) in [
            ([wall, other, 3.0], [0.0, 0.0, -1.0]),
            ([other, wall, 3.0], [0.0, 0.0, -1.0]),
            ([wall, other - 3.0, 3.0], [0.0, half, -half]),
            ([other - 3.0, wall, 3.0], [half, 0.0, -half]),
        ] {
            let ray = Ray { origin: Vector::from(origin), direction: Vector::from(direction) };
            assert!(grid.hit(&ray, f64::MAX).is_some(), "{ray:?}");
            let ray = Ray { origin: ray.origin.cast::<f32>(), direction: ray.direction.cast() };
            assert!(grid.hit(&ray, f32::MAX).is_some(), "{ray:?}");
        }
    }
}

#[test]
fn a_mesh_without_coordinates_has_a_spheres() {
    // A sphere of 24×16 quads, away from the file's origin.
    let mut text = String::new();
    for i in 0..=16 {
        for j in 0..24 {
            let (theta, phi) =
                (f64::from(i) * std::f64::consts::PI / 16.0, f64::from(j) * std::f64::consts::TAU / 24.0);
            let p = Vector::<f64>::from_angles(theta, phi);
            text += &format!("v {} {} {}\n", p.x + 7.0, p.z - 9.0, -p.y + 5.0);
        }
    }
    for i in 0..16 {
        for j in 0..24 {
            let (a, b) = (i * 24 + j + 1, i * 24 + (j + 1) % 24 + 1);
            text += &format!("f {a} {} {} {b}\n", a + 24, b + 24);
        }
    }
    let (ball, sphere) = (Shape::Mesh(mesh("ball", &text).unwrap()), Shape::Sphere);
    for i in 0..400 {
        let direction: Vector<f64> = -Vector::from_angles(0.02 + 0.0077 * f64::from(i), 0.377 * f64::from(i));
        let ray = Ray { origin: direction * -3.0, direction };
        let uv = |shape: &Shape| shape.point(&shape.hit(&ray, 9.0).expect("met"), 3.0, 0.0).uv;
        let (got, want) = (uv(&ball), uv(&sphere));
        let apart = [0, 1].map(|k: usize| (got[k] - want[k]).abs());
        // Linear in u and v over a facet of 1/24 by 1/16; near a pole u turns by a facet.
        assert!(apart[0].min(1.0 - apart[0]) < 1.0 / 24.0 && apart[1] < 0.01, "{got:?} {want:?}");
    }
}

#[test]
fn faces_without_normals_are_flat_beside_faces_with() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 1 0 0\nvt 0.25 0.5\nf 1/1/1 2/1/1 3/1/1\nf 1 3 4\n";
    let mesh = mesh("mixed", text).unwrap();
    let mut normals: Vec<_> = mesh.triangles().iter().map(|t| (t[1].normal, t[1].uv == [0.25, 0.5])).collect();
    normals.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
    assert_eq!(normals, [([0.0, -1.0, 0.0], false), ([1.0, 0.0, 0.0], true)]);
}

/// A material whose colour is a picture that is white above and black below.
fn upright() -> Material {
    let folder = folder("upright");
    let above = image::GrayImage::from_fn(1, 2, |_, y| image::Luma([if y == 0 { 255 } else { 0 }]));
    above.save(folder.join("above.png")).unwrap();
    let text =
        "[[part]]\nlayer = [{ interface = { diffuse = { albedo = { image = \"above.png\" }, sigma = 0.0 } } }]\n";
    std::fs::write(folder.join("above.toml"), text).unwrap();
    let material = brdf::render::texture::read_material(&folder.join("above.toml")).unwrap().material;
    let _ = std::fs::remove_dir_all(&folder);
    material
}

/// The shapes that show it: with a mesh as Blender writes it, +y up and v upwards.
fn upright_scenes() -> Vec<Scene> {
    let quad = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
    let shapes = [
        (Shape::Sphere, 0.0),
        (Shape::Plane, 89.0),
        (Shape::Mesh(mesh("upright_quad", quad).unwrap()), 0.0),
        (Shape::Mesh(mesh("upright_cube", CUBE).unwrap()), 0.0),
    ];
    shapes
        .into_iter()
        .map(|(shape, elevation)| Scene {
            shape,
            camera: Camera::new(&Orbit { elevation, ..Orbit::default() }, 32, 32).unwrap(),
            backdrop: false,
            ..scene(upright(), Environment::furnace(), 32)
        })
        .collect()
}

fn stands_upright(what: &str, film: &Film) {
    let sum = |rows: std::ops::Range<usize>| -> f64 {
        film.mean()[rows.start * 32..rows.end * 32].iter().map(|pixel| f64::from(pixel[1])).sum()
    };
    // Bilinear texels, repeated: three quarters above and one quarter below, the centre of each half white or black.
    let (above, below) = (sum(0..16), sum(16..32));
    assert!(above > 2.0 * below && above > 60.0, "{what}: {above} above, {below} below");
}

#[test]
fn images_stand_upright() {
    for (i, scene) in upright_scenes().iter().enumerate() {
        stands_upright(&format!("shape {i} of f64"), &realtime::render::<f64>(scene, 1, &silent));
    }
}

#[test]
fn green_of_a_normal_map_is_up() {
    let folder = folder("green");
    // A slope towards growing v.
    image::RgbImage::from_pixel(1, 1, image::Rgb([128, 200, 220])).save(folder.join("green.png")).unwrap();
    let text = "[[part]]\nrelief = { normals = { image = \"green.png\" }, encoding = \"rgb\" }\n\
                layer = [{ interface = { diffuse = { albedo = 0.5, sigma = 0.0 } } }]\n";
    std::fs::write(folder.join("green.toml"), text).unwrap();
    let material = brdf::render::texture::read_material(&folder.join("green.toml")).unwrap().material;
    let _ = std::fs::remove_dir_all(&folder);
    let mirrored = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 1 0\nvt 0 0\nvt 0 1\nvt 1 1\nf 1/1 2/2 3/3 4/4\n";
    let mirrored = Shape::Mesh(mesh("mirrored_quad", mirrored).unwrap());
    let mirrored = upright_scenes().into_iter().nth(2).map(|scene| Scene { shape: mirrored, ..scene });
    // The back of a square, which v runs down.
    let back = upright_scenes().into_iter().nth(1).map(|scene| {
        let below = Orbit { elevation: -89.0, azimuth: 180.0, ..Orbit::default() };
        Scene { camera: Camera::new(&below, 32, 32).unwrap(), ..scene }
    });
    for mut seen in upright_scenes().into_iter().take(3).chain(mirrored).chain(back) {
        seen.material = material.clone();
        seen.environment = Environment::dark();
        // From the viewer's side, from above and from below in the picture.
        let [eye, _, _, up] = seen.camera.vectors();
        let (eye, up) = (eye.normalized(), up.normalized());
        let mut lit = |towards: Vector<f64>| -> f64 {
            seen.lights = vec![Light::Directional { towards: towards.normalized(), irradiance: [1.0; 3] }];
            realtime::render::<f64>(&seen, 1, &silent).mean().iter().map(|pixel| f64::from(pixel[1])).sum()
        };
        let (above, below) = (lit(eye + up), lit(eye - up));
        assert!(above > 1.2 * below, "{above} {below}");
    }
}

#[test]
fn broken_meshes_are_refused() {
    for (text, said) in [
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no triangles; a face has"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n", "line 4: vertex 7 is not there"),
        ("v 0 0 0\nv NaN 0 0\nv 0 1 0\nf 1 2 3\n", "line 2: `NaN` is not finite"),
        ("v 0 0 0\nv 1 0 x\nf 1 2 3\n", "line 2: `x` is no number"),
        ("v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n", "all vertices are one point"),
        ("v 1 0 0\nv 2 0 0\nv 3 0 0\nf 1 2 3\n", "no triangles with an area"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 1e60 0\nf 1/1 2/1 3/1\n", "triangle 1: texture coordinates [1e60, 0.0]"),
        ("v 0 0 0\nv 1e200 0 0\nv 0 1 0\nf 1 2 3\n", "triangle 1: a vertex at"),
        ("solid cube\n facet normal 0 0 1\n", "line 1: `solid` begins no line of an OBJ file"),
        ("", "no triangles"),
    ] {
        let error = mesh("broken", text).expect_err(text);
        assert!(error.contains("mesh.obj: ") && error.contains(said) && error.lines().count() == 1, "{error}");
    }
    let error = Mesh::read(&folder("absent").join("absent.obj")).expect_err("absent");
    assert!(error.contains("absent.obj: "), "{error}");
}

#[test]
fn broken_environments_are_refused() {
    let folder = folder("environments");
    let save = |name: &str, width: u32, height: u32, value: f32| {
        let path = folder.join(name);
        let mut map = image::Rgb32FImage::from_pixel(width, height, image::Rgb([1.0; 3]));
        map.get_pixel_mut(1, 0).0[2] = value;
        image::DynamicImage::ImageRgb32F(map).save(&path).unwrap();
        path
    };
    for (name, value) in [("nan.exr", f32::NAN), ("inf.exr", f32::INFINITY), ("negative.exr", -1.0)] {
        let error = Environment::read(&save(name, 8, 4, value)).expect_err(name);
        assert!(error.contains(&format!("{name}: texel (1, 0): blue")) && error.lines().count() == 1, "{error}");
    }
    let error = Environment::read(&save("square.exr", 4, 4, 1.0)).expect_err("square");
    assert!(error.contains("square.exr: 4×4 texels"), "{error}");
    let text = folder.join("text.hdr");
    std::fs::write(&text, "no picture").unwrap();
    assert!(Environment::read(&text).expect_err("text").contains("text.hdr: "));
    assert!(Environment::read(&folder.join("absent.hdr")).expect_err("absent").contains("absent.hdr: "));
    for name in ["good.exr", "good.hdr"] {
        let path = save(name, 8, 4, 2.0);
        assert!(Environment::read(&path).expect(name).shines());
        let capitals = folder.join(name.to_uppercase());
        std::fs::rename(&path, &capitals).unwrap();
        assert!(Environment::read(&capitals).expect(name).shines());
    }
    let _ = std::fs::remove_dir_all(&folder);
}

/// What docs/materials.md says of the realtime mode's brightness, beside the offline mode in a white furnace.
#[test]
fn realtime_furnaces_are_about_as_bright_as_offline_ones() {
    let stacks = stack::built_in().into_iter().map(|found| (found.name, Material::from(found.stack)));
    let materials = built_in::all();
    let materials = materials.iter().filter(|found| !found.name.ends_with("as_printed"));
    for (name, material) in stacks.chain(materials.map(|found| (found.name, found.material().unwrap()))) {
        let lit = Scene { backdrop: false, ..scene(material, Environment::furnace(), 32) };
        let options = Options { samples: 32, ..Options::default() };
        let (shown, traced) = (realtime::render::<f64>(&lit, 4, &silent), offline::render(&lit, options, &silent));
        let most = match name {
            // Lobes that keep all of F.
            "brushed_steel" | "turned_steel" => 1.15,
            // Oren–Nayar's base counts as Lambert's.
            "varnish_over_concrete" | "varnished_concrete" => 1.15,
            "patina_over_time" => 1.1,
            _ => 1.06,
        };
        for c in 0..3 {
            let sum = |values: &[[f32; 3]]| values.iter().map(|pixel| f64::from(pixel[c])).sum::<f64>();
            let ratio = sum(shown.mean()) / sum(traced.mean());
            // Five deviations of the sum.
            let noise = 5.0 * sum(traced.variance()).sqrt() / sum(traced.mean());
            println!("{name:28} {c} {ratio:.3} ± {noise:.3}");
            assert!(ratio > 0.99 - noise && ratio < most + noise, "{name}, channel {c}: {ratio} ± {noise}");
        }
    }
}
