//! Material files: what they mean, and what is said of those that are refused.
#![cfg(feature = "toml")]

mod any;
mod refused;

use brdf::layered::{Model, Widths};
use brdf::material::description::{ImageRequest, MaterialFile, read_file};
use brdf::material::field::{Colour, Lookup, Noise, Property, Scalar, Scratches};
use brdf::material::finish::{Body, Boundary, BrushedMetal, Coat, Encoding, Finish, Flakes, Layers, Relief};
use brdf::material::{Material, Part, Point, built_in, metal};
use brdf::texture::image::{self, Filter, Image};
use brdf::texture::ramp::{Ramp, Stop};

/// An image of two texels for every name but those that are missing or broken.
fn load(request: ImageRequest<'_>) -> Result<Image, String> {
    match request.file {
        "missing.png" => Err("no such file".to_owned()),
        "broken.hdr" => Image::new(2, 1, 1, vec![0.5, f32::NAN]).map_err(|error| error.to_string()),
        "talkative.exr" => Err("not an image\nof any kind\n".to_owned()),
        _ => Image::from_bytes(2, 1, 3, &[255, 128, 0, 0, 128, 255], request.encoding).map_err(|e| e.to_string()),
    }
}

fn file(text: &str) -> MaterialFile {
    read_file(text, load).unwrap_or_else(|error| panic!("{error}"))
}

fn refused(text: &str) -> String {
    let message = read_file(text, load).expect_err(text).to_string();
    assert!(!message.contains(['\n', '\r']), "{message:?}");
    message
}

/// A file whose first part is a plain metal and whose second has these keys from line 4 on.
fn second(keys: &str) -> String {
    let ground = "layer = [{ interface = { conductor = { metal = \"iron\" }, alpha = 0.2 } }]";
    format!("[[part]]\n{ground}\n[[part]]\n{keys}\n")
}

/// A field as the cover of a second part.
fn cover(field: &str) -> String {
    second(&format!("cover = {field}\nlayer = [{{ interface = {{ diffuse = {{ albedo = 0.5 }} }} }}]"))
}

/// A colour as the albedo of a second part.
fn albedo(colour: &str) -> String {
    second(&format!("layer = [{{ interface = {{ diffuse = {{ albedo = {colour} }} }} }}]"))
}

fn read_cover(field: &str) -> Scalar {
    file(&cover(field)).material.parts()[1].cover.clone()
}

fn read_albedo(colour: &str) -> Colour {
    match &file(&albedo(colour)).material.parts()[1].finish.body {
        Body::Layers(layers) => match &layers.coats[0].boundary {
            Boundary::Diffuse { albedo, .. } => albedo.clone(),
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    }
}

/// The examples that the documentation of `material` gives.
#[test]
fn the_examples_of_the_documentation_are_read() {
    let documentation = include_str!("../../src/material/mod.rs");
    let examples: Vec<String> = documentation
        .split("//! ```toml\n")
        .skip(1)
        .filter_map(|rest| rest.split("//! ```").next())
        .map(|text| text.lines().map(|line| line.trim_start_matches("//!").trim()).collect::<Vec<_>>().join("\n"))
        .collect();
    assert_eq!(examples.len(), 2);
    assert_eq!(file(&examples[0]).name.as_deref(), Some("patina"));
    let rusty = file(&examples[1]);
    assert_eq!(rusty.name.as_deref(), Some("rusty iron"));
    assert_eq!(rusty.material.parts().len(), 2);
    assert_eq!(rusty.material.images().len(), 1);
}

#[test]
fn a_file_is_the_material_built_by_hand() {
    let text = r#"
name = "everything"
[[part]]
model = "elek"
widths = "variance"
reflectivity = 0.75
scatter = [0.1, 0.2, 0.3]
[[part.layer]]
interface = { dielectric = { n = 1.5 }, alpha = 0.1 }
medium = { sigma = [0.0, 1.0, 2.0], thickness = { noise = { frequency = 2 } } }
flakes = { spacing = 0.002, resolution = 4, seed = 7 }
[[part.layer]]
interface = { conductor = { n = [1, 2, 3], k = 4 }, alpha = "occlusion" }
flakes = { normals = { image = "flakes.png", repeat = 1000 } }
[[part]]
cover = 0.5
relief = { height = { ridged = { frequency = [1, 2, 3], seed = 9, octaves = 3 } }, step = 0.01 }
brushed = { metal = "chromium", along = 0.05, across = 0.3, turn = "u" }
[[part]]
returns = true
relief = { normals = { image = "normals.png" }, encoding = "alpha_green", strength = 2 }
layer = [
    { interface = { dielectric = { n = 1.5 }, alpha = 0.1 } },
    { interface = { diffuse = { albedo = 0.5 } } },
]
[[part]]
stack = { model = "coupled", layer = [{ interface = { diffuse = { albedo = 0.5 } } }] }
"#;
    let read = file(text);
    assert_eq!(read.name.as_deref(), Some("everything"));
    let chromium = metal::by_name("chromium").unwrap();
    let flakes = Flakes::AsPrinted { normals: Lookup { image: 0, repeat: [1000.0; 2] } };
    let noise = Noise::new(0, 2.0);
    let first = Layers {
        model: Model::Elek,
        widths: Widths::Variance,
        coats: vec![
            Coat::dielectric(1.5, 0.1).over([0.0, 1.0, 2.0], Scalar::Fractal(noise)).with_flakes(Flakes::Glints {
                spacing: 0.002,
                resolution: 4,
                seed: 7,
            }),
            Coat::conductor([1.0, 2.0, 3.0], 4.0, Scalar::Of(Property::Occlusion)).with_flakes(flakes),
        ],
        returns: false,
        scatter: Some(Colour::Constant([0.1, 0.2, 0.3])),
    };
    let parts = read.material.parts();
    assert_eq!(parts[0], Part { cover: 1.0.into(), finish: Finish::new(Body::Layers(first)).dimmed(0.75) });
    let ridged = Noise { frequency: [1.0, 2.0, 3.0], ..Noise::new(9, 1.0) }.octaves(3);
    let brushed = BrushedMetal {
        n: chromium.n.into(),
        k: chromium.k.into(),
        along: 0.05.into(),
        across: 0.3.into(),
        turn: Scalar::Of(Property::U),
    };
    let relief = Relief::Height { height: Scalar::Ridged(ridged), step: 0.01 };
    let finish = Finish::new(Body::Brushed(Box::new(brushed))).with_relief(relief);
    assert_eq!(parts[1], Part { cover: 0.5.into(), finish });
    let normals = Lookup { image: 1, repeat: [1.0; 2] };
    let third = &parts[2].finish;
    assert_eq!(third.relief, Some(Relief::Map { normals, encoding: Encoding::AlphaGreen, strength: 2.0 }));
    assert!(matches!(&third.body, Body::Layers(layers) if layers.returns && layers.model == Model::Conserving));
    assert!(matches!(&parts[3].finish.body, Body::Whole(stack) if stack.model() == Model::Coupled));
    // Flakes are not filtered, normals are.
    let filters: Vec<_> = read.material.images().iter().map(|image| image.filter).collect();
    assert_eq!(filters, [Filter::Nearest, Filter::Bilinear]);
}

#[test]
fn every_number_that_varies_is_read() {
    let u = || Box::new(Scalar::Of(Property::U));
    let noise = Noise { seed: 3, amplitude: 0.5, frequency: [2.0; 3], octaves: 5, gain: 0.4, lacunarity: 2.1 };
    for (text, want) in [
        ("0.25", Scalar::Constant(0.25)),
        ("\"distance\"", Scalar::Of(Property::Distance)),
        (
            "{ noise = { seed = 3, amplitude = 0.5, frequency = 2, octaves = 5, gain = 0.4, lacunarity = 2.1 } }",
            Scalar::Fractal(noise),
        ),
        ("{ ridged = { frequency = 1 } }", Scalar::Ridged(Noise::new(0, 1.0))),
        (
            "{ scratches = { seed = 2, frequency = [1, 2, 3], density = 0.5, width = 0.02, layers = 7 } }",
            Scalar::Scratches(Scratches { seed: 2, frequency: [1.0, 2.0, 3.0], density: 0.5, width: 0.02, layers: 7 }),
        ),
        ("{ scratches = { frequency = 1 } }", Scalar::Scratches(Scratches::new(0, 1.0))),
        ("{ image = \"a.png\" }", Scalar::Image(Lookup { image: 0, repeat: [1.0; 2] }, 0)),
        (
            "{ image = \"a.png\", channel = \"a\", repeat = [2, 3] }",
            Scalar::Image(Lookup { image: 0, repeat: [2.0, 3.0] }, 3),
        ),
        ("{ of = \"u\", scale = 2, offset = -1 }", Scalar::Scaled { of: u(), factor: 2.0, offset: -1.0 }),
        ("{ of = \"u\" }", Scalar::Scaled { of: u(), factor: 1.0, offset: 0.0 }),
        ("{ sum = [\"u\", 1, \"u\"] }", Scalar::Sum(Box::new(Scalar::Sum(u(), Box::new(1.0.into()))), u())),
        ("{ product = [\"u\", 7] }", Scalar::Product(u(), Box::new(7.0.into()))),
        ("{ product = [7] }", Scalar::Constant(7.0)),
        ("{ mix = [0, 9], by = \"u\" }", Scalar::mix(0.0, 9.0, Scalar::Of(Property::U))),
        ("{ levels = [0.7, 0.2], of = \"u\" }", Scalar::Levels { of: u(), black: 0.7, white: 0.2 }),
        ("{ above = 0.5, of = \"u\" }", Scalar::Threshold { of: u(), at: 0.5, softness: 0.0 }),
        ("{ above = 0.5, softness = 0.1, of = \"u\" }", Scalar::Threshold { of: u(), at: 0.5, softness: 0.1 }),
        ("{ extent = 0.5, transition = 0.1, of = \"u\" }", Scalar::Extent { of: u(), extent: 0.5, transition: 0.1 }),
    ] {
        assert_eq!(read_cover(text), want, "{text}");
    }
}

#[test]
fn every_colour_that_varies_is_read() {
    let v = || Scalar::Of(Property::V);
    let colours = [[0.0, 0.0, 0.0], [1.0, 0.5, 0.25]];
    let stops = [(0.25, colours[0]), (0.5, colours[1])].map(|(at, colour)| Stop { at, colour });
    let list = "[[0, 0, 0], [1, 0.5, 0.25]]";
    let film = Colour::Film {
        absorption: [1.0, 2.0, 3.0],
        scattering: [4.0; 3],
        thickness: v(),
        ground: Box::new(0.5.into()),
    };
    for (text, want) in [
        ("0.5".to_owned(), Colour::Constant([0.5; 3])),
        ("[0.1, 0.2, 0.3]".to_owned(), Colour::Constant([0.1, 0.2, 0.3])),
        ("{ grey = \"v\" }".to_owned(), Colour::Grey(v())),
        (format!("{{ ramp = {list}, by = \"v\" }}"), Colour::Ramp(Ramp::even(&colours).unwrap(), v())),
        (format!("{{ ramp = {list}, at = [0.25, 0.5], by = \"v\" }}"), Colour::Ramp(Ramp::new(stops).unwrap(), v())),
        (
            format!("{{ bands = {list}, softness = 0.1, by = \"v\" }}"),
            Colour::Bands(Ramp::banded(&colours).unwrap(), 0.1, v()),
        ),
        ("{ image = \"a.png\", repeat = 2 }".to_owned(), Colour::Image(Lookup { image: 0, repeat: [2.0; 2] })),
        ("{ colour = 0.5, scale = \"v\" }".to_owned(), Colour::Scaled(Box::new(0.5.into()), v())),
        ("{ mix = [0, [1, 1, 1]], by = \"v\" }".to_owned(), Colour::mix(0.0, 1.0, v())),
        ("{ film = { absorption = [1, 2, 3], scattering = 4, thickness = \"v\", ground = 0.5 } }".to_owned(), film),
    ] {
        assert_eq!(read_albedo(&text), want, "{text}");
    }
}

#[test]
fn images_are_asked_for_once_in_each_encoding() {
    let mut asked = Vec::new();
    let text = second(
        "cover = { product = [{ image = \"a.png\" }, { image = \"a.png\", channel = \"g\" }] }\n\
         layer = [{ interface = { diffuse = { albedo = { mix = [{ image = \"a.png\" }, { image = \"a.png\", srgb = false }], by = \"u\" } } } }]",
    );
    let read = read_file(&text, |request| {
        asked.push((request.file.to_owned(), request.encoding));
        load(request)
    });
    let material = read.unwrap().material;
    let a = |encoding| ("a.png".to_owned(), encoding);
    assert_eq!(asked, [a(image::Encoding::Linear), a(image::Encoding::Srgb)]);
    assert_eq!(material.images().len(), 2);
    // The middle channel of the texel is 128: a half as a number, a fifth as a colour.
    let [linear, colour] = [0, 1].map(|image: usize| material.images()[image].texel(0, 0)[1]);
    assert!((linear - 0.50196).abs() < 1e-5 && (colour - 0.21586).abs() < 1e-5, "{linear} {colour}");
}

#[test]
fn a_built_in_material_takes_its_numbers() {
    let read = file("material = \"patina\"\nparameters = { extent = 0.75 }");
    let mut patina = built_in::by_name("patina").unwrap();
    patina.set("extent", 0.75).unwrap();
    assert_eq!(read.material, patina.material().unwrap());
    assert_eq!(file("name = \"mine\"\nmaterial = \"patina\"").name.as_deref(), Some("mine"));
    for material in built_in::all() {
        let read = file(&format!("material = \"{}\"", material.name));
        assert_eq!(read.material, material.material().unwrap(), "{}", material.name);
    }
}

/// Two materials are one if they reflect alike: the example of a file against a material of the library, at a few points.
#[test]
fn what_is_read_is_evaluated() {
    let material: Material = file(&cover("{ above = 0.5, softness = 0.25, of = \"occlusion\" }")).material;
    let at = |occlusion: f64| Point { occlusion, uv: [0.5; 2], ..Point::default() };
    let (wi, wo) = (brdf::Vector::from_angles(0.3, 0.0), brdf::Vector::from_angles(0.4, 2.0));
    let [ground, middle, cover] = [0.0, 0.5, 1.0].map(|x| material.at(&at(x)).reflected(wi, wo));
    for c in 0..3 {
        assert!((middle[c] - 0.5 * (ground[c] + cover[c])).abs() < 1e-12, "{ground:?} {middle:?} {cover:?}");
    }
    // The cover is Lambertian.
    assert!((cover[0] - 0.5 * std::f64::consts::FRAC_1_PI * wi.z).abs() < 1e-12);
}

/// The files that the documentation points to.
#[test]
fn examples_are_read() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/materials");
    let mut count = 0;
    for entry in std::fs::read_dir(&folder).expect("the folder is there") {
        let path = entry.expect("an entry").path();
        let text = std::fs::read_to_string(&path).expect("a text");
        let read = read_file(&text, load).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(read.name.is_some(), "{}", path.display());
        count += 1;
    }
    assert_eq!(count, 2);
}
