//! The same pictures on every adapter.

use super::*;
use crate::adapters::adapters_for_tests;
use brdf::material::field::{Colour, Lookup, Scalar};
use brdf::material::finish::{Boundary, Coat};
use brdf::material::{Finish, Part};
use brdf::render::gpu;
use brdf::texture::image::Image;

/// A metal under scratches; one whose height is an image; one whose normals are.
fn reliefs() -> [Material; 3] {
    let folder = folder("reliefs");
    let heights = image::GrayImage::from_fn(8, 8, |x, y| image::Luma([(37 * x + 91 * y + 13 * x * y) as u8]));
    heights.save(folder.join("heights.png")).unwrap();
    // Tilted by 0.4 at most.
    let normal = |x, y| image::Rgb([(37 * x + 91 * y) % 101 + 78, (53 * x + 29 * y) % 101 + 78, 245].map(|x| x as u8));
    image::RgbImage::from_fn(8, 8, normal).save(folder.join("normals.png")).unwrap();
    let materials = [
        "{ height = { of = { scratches = { frequency = 3, layers = 8, width = 0.2 } }, scale = -0.02 }, step = 0.02 }",
        "{ height = { of = { image = \"heights.png\", repeat = 2 }, scale = 0.03 }, step = 0.02 }",
        "{ normals = { image = \"normals.png\", repeat = 3 } }",
    ]
    .map(|relief| {
        let metal = "layer = [{ interface = { conductor = { metal = \"gold\" }, alpha = 0.4 } }]";
        let text = format!("[[part]]\nrelief = {relief}\n{metal}\n");
        brdf::render::texture::parse_material(&folder.join("relief.toml"), &text).unwrap().material
    });
    let _ = std::fs::remove_dir_all(&folder);
    materials
}

fn scenes() -> Vec<(String, Scene)> {
    let stack = |name: &str| Material::from(stack::by_name(name).unwrap());
    let built_in = |name: &str| built_in::by_name(name).unwrap().material().unwrap();
    let sky = || sources::by_name("sky").unwrap();
    let studio = || sources::by_name("studio").unwrap();
    let lights = vec!["directional:1,-1,1,2".parse().unwrap(), "point:-2,-2,2,6,5,4".parse().unwrap()];
    let mut all = Vec::new();
    let mut add = |name: &str, shape, material: Material, environment| {
        let lights = lights.clone();
        all.push((name.to_owned(), Scene { shape, lights, ..scene(material, environment, 24) }));
    };
    add("sphere, copper", Shape::Sphere, stack("clear_coat_over_copper"), studio());
    add("torus, concrete", Shape::Torus(Torus::new(0.4).unwrap()), stack("varnish_over_concrete"), sky());
    add("plane, iron", Shape::Plane, stack("iron"), studio());
    add("cube, paint", Shape::Mesh(mesh("gpu", CUBE).unwrap()), stack("open_pbr_carpaint"), sky());
    add("sphere, rust", Shape::Sphere, built_in("rusty_iron"), studio());
    add("sphere, brushed", Shape::Sphere, built_in("brushed_steel"), studio());
    add("torus, patina", Shape::Torus(Torus::new(0.3).unwrap()), built_in("patina"), studio());
    let [scratched, embossed, mapped] = reliefs();
    add("torus, scratched", Shape::Torus(Torus::new(0.4).unwrap()), scratched, studio());
    add("plane, embossed", Shape::Plane, embossed, studio());
    add("sphere, map of normals", Shape::Sphere, mapped, sky());
    all
}

#[test]
fn paths_agree() {
    for gpu in adapters_for_tests() {
        for (name, scene) in scenes() {
            let options = |seed| Options { samples: 64, seed, ..Options::default() };
            let want = offline::render(&scene, options(1), &silent);
            let got = gpu::offline(&gpu, &scene, options(2), &silent).unwrap_or_else(|error| panic!("{name}: {error}"));
            agrees(&format!("{}: {name}", gpu.info()), &got, &want);
        }
    }
}

#[test]
fn fragments_agree() {
    for gpu in adapters_for_tests() {
        for (name, scene) in scenes() {
            let want = realtime::render::<f32>(&scene, 1, &silent);
            let got = gpu::realtime(&gpu, &scene, 1, &silent).unwrap_or_else(|error| panic!("{name}: {error}"));
            for (pixel, (a, b)) in got.mean().iter().zip(want.mean()).enumerate() {
                for c in 0..3 {
                    // The lookup of a map carries the rounding of the direction, 2 ULP of 1, times 256 texels to a
                    // unit and the contrast between two of them, at most the largest radiance, 12; the lobes of lights 1/α² of it.
                    let tolerance = 2e-3 * b[c].max(0.1);
                    assert!((a[c] - b[c]).abs() < tolerance, "{}: {name}, pixel {pixel}: {a:?} {b:?}", gpu.info());
                }
            }
        }
    }
}

#[test]
fn images_stand_upright_on_a_gpu() {
    for gpu in adapters_for_tests() {
        for (i, scene) in upright_scenes().iter().enumerate() {
            let options = Options { samples: 4, ..Options::default() };
            for film in [gpu::realtime(&gpu, scene, 1, &silent), gpu::offline(&gpu, scene, options, &silent)] {
                stands_upright(&format!("shape {i} on {}", gpu.info()), &film.unwrap());
            }
        }
    }
}

/// A material whose image has a row more than the adapter binds; nothing where it would fill this machine.
fn too_large(gpu: &brdf::gpu::Gpu) -> Option<Material> {
    let limits = gpu.device().limits();
    let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    let rows = u32::try_from(most / (16 * 4096) + 1).ok().filter(|rows| *rows <= 8192)?;
    let image = Image::new(4096, rows, 1, vec![0.5; 4096 * rows as usize]).unwrap();
    let albedo = Colour::Image(Lookup { image: 0, repeat: [1.0; 2] });
    let coat = Coat::new(Boundary::Diffuse { albedo, sigma: Scalar::Constant(0.0) });
    let part = Part { cover: Scalar::Constant(1.0), finish: Finish::layers(vec![coat]) };
    Some(Material::new(vec![part], vec![image]).unwrap())
}

#[test]
fn images_that_an_adapter_does_not_bind_are_refused_as_images() {
    for gpu in adapters_for_tests() {
        let Some(material) = too_large(&gpu) else { continue };
        let scene = scene(material.clone(), Environment::furnace(), 4);
        let refused = gpu::realtime(&gpu, &scene, 1, &silent).expect_err("too large").to_string();
        let adapter = gpu.info().to_string();
        for said in ["the material's images (of 1, the largest 4096×", " MiB and ", adapter.as_str(), "without --gpu"]
        {
            assert!(refused.contains(said) && refused.lines().count() == 1, "{refused}");
        }
        #[cfg(feature = "check")]
        {
            use brdf::check::{Family, MaterialFamily};
            let family = MaterialFamily::new("large", &material);
            let values: Vec<f64> = family.parameters().iter().map(|parameter| parameter.default).collect();
            let up = Vector::new(0.0f32, 0.0, 1.0);
            let refused = family.evaluate_on(&gpu, &values, &[(up, up)]).expect_err("too large");
            assert!(refused.contains("the material's images (of 1, the largest 4096×"), "{refused}");
        }
    }
}

#[test]
fn a_model_without_a_twin_is_refused() {
    let coupled = stack::by_name("clear_coat_over_copper").unwrap().with_model(Model::Coupled);
    for gpu in adapters_for_tests() {
        let refused =
            gpu::offline(&gpu, &scene(coupled.clone(), Environment::furnace(), 4), Options::default(), &silent);
        let error = refused.expect_err("no twin").to_string();
        assert!(error.contains("coupled") && error.lines().count() == 1, "{error}");
    }
}
