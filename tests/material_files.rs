//! Material files: what they mean, and what is said of those that are refused.
#![cfg(feature = "toml")]

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
    let documentation = include_str!("../src/material/mod.rs");
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
    { interface = { diffuse = { albedo = 0.5, sigma = 0.25 } } },
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

#[test]
fn what_is_not_understood_is_refused_with_its_place() {
    for (text, want) in [
        ("name = ", "line 1: not TOML"),
        ("", "part: missing, expected a list of tables"),
        ("nam = 1", "line 1, nam: unknown key, did you mean `name`?"),
        ("part = 3", "line 1, part: found a number, expected a list of tables"),
        ("part = []", "line 1, part: there are 0 parts"),
        ("name = 3\npart = []", "line 1, name: found a number, expected a string"),
        ("material = \"patna\"", "line 1, material: unknown material \"patna\", did you mean `patina`?"),
        ("material = 3", "line 1, material: found a number, expected a string"),
        ("material = \"patina\"\nparameters = 3", "line 2, parameters: found a number, expected a table of numbers"),
        (
            "material = \"patina\"\n[parameters]\nextend = 1",
            "line 3, parameters.extend: patina has no parameter `extend`; it has",
        ),
        (
            "material = \"patina\"\n[parameters]\nextent = 1e9",
            "line 3, parameters.extent: extent of patina is 1000000000, allowed is",
        ),
        (
            "material = \"patina\"\n[parameters]\nextent = nan",
            "line 3, parameters.extent: extent of patina is NaN, allowed is",
        ),
        (
            "material = \"patina\"\n[parameters]\nextent = \"x\"",
            "line 3, parameters.extent: found a string, expected a number",
        ),
        (
            "material = \"patina\"\npart = []",
            "line 2, part: a material is built-in or made of parts, and material on line 1 is given",
        ),
        ("parameters = {}\npart = []", "line 1, parameters: belongs to a built-in material"),
        ("[[part]]", "line 1, part[0]: missing one of `layer`, `brushed`, `stack`"),
        ("[[part]]\ncover = 1\nlayer = []", "line 2, part[0].cover: the first part is the ground"),
        ("[[part]]\nlayer = []", "line 1, part[0]: there are 0 layers, a part has 1 to 4"),
        ("[[part]]\nlayers = []", "line 2, part[0].layers: unknown key, did you mean `layer`?"),
    ] {
        let message = refused(text);
        assert!(message.starts_with(want), "{text:?}\n  gives {message}\n   want {want}");
    }
}

#[test]
fn parts_are_refused_with_their_place() {
    let diffuse = "layer = [{ interface = { diffuse = { albedo = 0.5 } } }]";
    for (keys, want) in [
        (
            "brushed = { metal = \"iron\", along = 0.1, across = 0.2 }\nmodel = \"elek\"",
            "line 5, part[1].model: belongs to a part with `layer`, and part[1].brushed on line 4",
        ),
        ("layer = []\nstack = {}", "line 5, part[1].stack: a part is of one kind, and part[1].layer on line 4"),
        (
            &format!("{diffuse}\nmodel = \"coupled\""),
            "line 5, part[1].model: layers that vary take no model \"coupled\"",
        ),
        (&format!("{diffuse}\nmodel = \"elk\""), "line 5, part[1].model: unknown model \"elk\", did you mean `elek`?"),
        (&format!("{diffuse}\nwidths = \"thin\""), "line 5, part[1].widths: unknown rule \"thin\""),
        (&format!("{diffuse}\nreturns = 1"), "line 5, part[1].returns: found a number, expected true or false"),
        (&format!("{diffuse}\nreturns = true"), "line 3, part[1]: `returns` needs a diffuse base"),
        (&format!("{diffuse}\nscatter = -1"), "line 5, part[1].scatter: -1 is not allowed, it must be in [0, 1e30]"),
        (
            &format!("{diffuse}\nreflectivity = [0, 1, 2]"),
            "line 5, part[1].reflectivity[2]: 2 is not allowed, it must be in [0, 1]",
        ),
        (&format!("{diffuse}\ncover = 1.5"), "line 5, part[1].cover: 1.5 is not allowed, it must be in [0, 1]"),
        ("layer = [3]", "line 4, part[1].layer[0]: found a number, expected a table with the key `interface`"),
        ("layer = [{}]", "line 4, part[1].layer[0].interface: missing"),
        ("layer = [{ interface = {} }]", "line 4, part[1].layer[0].interface: missing one of `dielectric`"),
        (
            "layer = [{ interface = { alpha = 0.1, dielectric = { n = 1.5 }, diffuse = {} } }]",
            "line 4, part[1].layer[0].interface.diffuse: an interface is of one kind",
        ),
        (
            "layer = [{ interface = { dielectric = { n = 0 }, alpha = 0.1 } }]",
            "line 4, part[1].layer[0].interface.dielectric.n: 0 is not allowed, it must be in [0.001, 1000]",
        ),
        ("layer = [{ interface = { dielectric = { n = 1.5 } } }]", "line 4, part[1].layer[0].interface.alpha: missing"),
        (
            "layer = [{ interface = { dielectric = { n = 1.5 }, alpha = 0 } }]",
            "line 4, part[1].layer[0].interface.alpha: 0 is not allowed, it must be in [0.0001, 1]",
        ),
        (
            "layer = [{ interface = { conductor = { metal = \"cooper\" }, alpha = 0.1 } }]",
            "line 4, part[1].layer[0].interface.conductor.metal: unknown metal \"cooper\", did you mean `copper`?",
        ),
        (
            "layer = [{ interface = { conductor = { metal = \"copper\", k = 1 }, alpha = 0.1 } }]",
            "line 4, part[1].layer[0].interface.conductor.k: give either this or the metal",
        ),
        (
            "layer = [{ interface = { conductor = { n = 1 }, alpha = 0.1 } }]",
            "line 4, part[1].layer[0].interface.conductor.k: missing",
        ),
        (
            "layer = [{ interface = { conductor = {}, alpha = 0.1 } }]",
            "line 4, part[1].layer[0].interface.conductor: missing either `metal`",
        ),
        (
            "layer = [{ interface = { diffuse = { albedo = 2 } } }]",
            "line 4, part[1].layer[0].interface.diffuse.albedo: 2 is not allowed, it must be in [0, 1]",
        ),
        (
            "layer = [{ interface = { diffuse = { albedo = 1, sigma = 2 } } }]",
            "line 4, part[1].layer[0].interface.diffuse.sigma: 2 is not allowed, it must be in [0, 1.57",
        ),
        (
            "layer = [{ interface = { diffuse = { albedo = 1 }, alpha = 1 } }]",
            "line 4, part[1].layer[0].interface.alpha: a diffuse base has no microfacet width",
        ),
        (
            "[[part.layer]]\ninterface = { diffuse = { albedo = 1 } }\n[[part.layer]]\ninterface = { diffuse = { albedo = 1 } }",
            "line 4, part[1].layer[0]: a diffuse base lets nothing through",
        ),
        (
            "[[part.layer]]\nmedium = { sigma = 1 }\ninterface = { diffuse = { albedo = 1 } }",
            "line 5, part[1].layer[0].medium.thickness: missing",
        ),
        (
            "[[part.layer]]\nmedium = { sigma = -1, thickness = 1 }\ninterface = { diffuse = { albedo = 1 } }",
            "line 5, part[1].layer[0].medium.sigma: -1 is not allowed",
        ),
        ("brushed = { metal = \"iron\", along = 0.1 }", "line 4, part[1].brushed.across: missing"),
        (
            "brushed = { metal = \"iron\", along = 0.1, across = 3 }",
            "line 4, part[1].brushed.across: 3 is not allowed, it must be in [0.0001, 1]",
        ),
        ("stack = 3", "line 4, part[1].stack: found a number, expected a table with the key `layer`"),
        (
            "stack = { layer = [{ interface = { dielectric = { n = 1.5 }, alpha = 2 } }] }",
            "line 4, part[1].stack.layer[0].interface.alpha: 2 is not allowed",
        ),
        (
            "stack = { layer = [{ interface = { dielectric = { n = [1, 2] }, alpha = 1 } }] }",
            "line 4, part[1].stack.layer[0].interface.dielectric.n",
        ),
        ("relief = {}\nlayer = []", "line 5, part[1].layer"),
    ] {
        let message = refused(&second(keys));
        if keys.starts_with("relief = {}") {
            // Layers are read first; an empty list of them is found by the material as a whole, after the relief.
            assert!(message.starts_with("line 4, part[1].relief: missing `height` or `normals`"), "{message}");
        } else {
            assert!(message.starts_with(want), "{keys:?}\n  gives {message}\n   want {want}");
        }
    }
}

#[test]
fn reliefs_and_flakes_are_refused_with_their_place() {
    let relief = |keys: &str| {
        refused(&second(&format!("relief = {keys}\nlayer = [{{ interface = {{ diffuse = {{ albedo = 1 }} }} }}]")))
    };
    for (keys, want) in [
        ("{ height = 1 }", ".step: missing"),
        ("{ height = 1, step = 0 }", ".step: 0 is not allowed, it must be in [1e-30, 1e30]"),
        ("{ height = 1, step = 1, strength = 1 }", ".strength: does not belong to a relief of this kind"),
        ("{ height = 1, normals = {} }", ".normals: a relief is of one kind"),
        ("{ normals = {}, step = 1 }", ".step: does not belong"),
        ("{ normals = {} }", ".normals.image: missing"),
        (
            "{ normals = { image = \"a.png\" }, encoding = \"bgr\" }",
            ".encoding: unknown encoding \"bgr\", allowed: `rgb`, `alpha_green`",
        ),
        (
            "{ normals = { image = \"a.png\" }, strength = inf }",
            ".strength: inf is not allowed, it must be in [-1e30, 1e30]",
        ),
    ] {
        let message = relief(keys);
        let want = format!("line 4, part[1].relief{want}");
        assert!(message.starts_with(&want), "{keys}\n  gives {message}\n   want {want}");
    }
    let flakes = |keys: &str| {
        let interface = "interface = { dielectric = { n = 1.5 }, alpha = 0.1 }";
        refused(&second(&format!("[[part.layer]]\n{interface}\nflakes = {keys}")))
    };
    for (keys, want) in [
        ("3", ": found a number"),
        ("{ resolution = 2 }", ".spacing: missing"),
        ("{ spacing = -1, resolution = 2 }", ".spacing: -1 is not allowed, it must be in [1e-30, 1e30]"),
        ("{ spacing = 1, resolution = 2.5 }", ".resolution: 2.5 is not allowed, it must be a whole number in [1, 8]"),
        ("{ spacing = 1, resolution = 9 }", ".resolution: 9 is not allowed"),
        (
            "{ spacing = 1, resolution = 2, seed = -1 }",
            ".seed: -1 is not allowed, it must be a whole number in [0, 4294967295]",
        ),
        ("{ normals = { image = \"a.png\" }, seed = 1 }", ".seed: give either this or a map of normals"),
    ] {
        let message = flakes(keys);
        let want = format!("line 6, part[1].layer[0].flakes{want}");
        assert!(message.starts_with(&want), "{keys}\n  gives {message}\n   want {want}");
    }
}

#[test]
fn numbers_that_vary_are_refused_with_their_place() {
    let deep = format!("{}1{}", "{ of = ".repeat(40), " }".repeat(40));
    let many = format!("{{ sum = [{}] }}", "1, ".repeat(17));
    for (field, want) in [
        ("true", ": found true or false, expected a number, a property"),
        ("[]", ": found a list, expected a number, a property"),
        ("1979-05-27", ": found a date or time"),
        ("nan", ": NaN is not allowed, it must be in [0, 1]"),
        ("\"oclusion\"", ": unknown property \"oclusion\", did you mean `occlusion`?"),
        ("{}", ": found an empty table, expected a number"),
        ("{ noize = {} }", ".noize: unknown key, did you mean `noise`?"),
        ("{ noise = {} }", ".noise.frequency: missing"),
        ("{ noise = { frequency = 1, octave = 2 } }", ".noise.octave: unknown key, did you mean `octaves`?"),
        (
            "{ noise = { frequency = 1, octaves = 0 } }",
            ".noise.octaves: 0 is not allowed, it must be a whole number in [1, 12]",
        ),
        ("{ noise = { frequency = 1, octaves = 13 } }", ".noise.octaves: 13 is not allowed"),
        ("{ noise = { frequency = 1, seed = 1e10 } }", ".noise.seed: 10000000000 is not allowed"),
        ("{ noise = { frequency = [1, 2] } }", ".noise.frequency: found a list of 2, expected three numbers"),
        ("{ noise = { frequency = inf } }", ".noise.frequency: inf is not allowed, it must be in [-1e30, 1e30]"),
        ("{ noise = { frequency = 1, gain = \"x\" } }", ".noise.gain: found a string, expected a number"),
        ("{ noise = { frequency = 1 }, ridged = {} }", ".ridged: unknown key, allowed: `noise`"),
        ("{ scratches = {} }", ".scratches.frequency: missing"),
        (
            "{ scratches = { frequency = 1, density = 2 } }",
            ".scratches.density: 2 is not allowed, it must be in [0, 1]",
        ),
        (
            "{ scratches = { frequency = 1, width = 1 } }",
            ".scratches.width: 1 is not allowed, it must be in [0, 0.375]",
        ),
        (
            "{ scratches = { frequency = 1, layers = 65 } }",
            ".scratches.layers: 65 is not allowed, it must be a whole number in [1, 64]",
        ),
        ("{ scratches = { frequency = 1, octaves = 2 } }", ".scratches.octaves: unknown key"),
        ("{ image = 3 }", ".image: found a number, expected a string"),
        ("{ image = \"\" }", ".image: found an empty name"),
        ("{ image = \"missing.png\" }", ".image: \"missing.png\" cannot be used: no such file"),
        (
            "{ image = \"broken.hdr\" }",
            ".image: \"broken.hdr\" cannot be used: the texel in column 1, row 0 is not finite",
        ),
        ("{ image = \"talkative.exr\" }", ".image: \"talkative.exr\" cannot be used: not an image, of any kind"),
        ("{ image = \"a.png\", channel = \"z\" }", ".channel: unknown channel \"z\""),
        ("{ image = \"a.png\", repeat = [1, 2, 3] }", ".repeat: found a list of 3, expected two"),
        ("{ image = \"a.png\", srgb = true }", ".srgb: unknown key, allowed: `image`, `channel`, `repeat`"),
        ("{ sum = [] }", ".sum: there are 0 terms, a list has 1 to 16"),
        (&many, ".sum: there are 17 terms"),
        ("{ sum = [1, \"w\"] }", ".sum[1]: unknown property \"w\""),
        ("{ product = 3 }", ".product: found a number, expected a list"),
        ("{ mix = [1], by = 1 }", ".mix: found a list of 1, expected two"),
        ("{ mix = [1, 2] }", ".by: missing"),
        ("{ levels = [0, 1] }", ".of: missing"),
        ("{ levels = [0, \"x\"], of = 1 }", ".levels[1]: found a string, expected a number"),
        ("{ above = 0.5, softness = -1, of = 1 }", ".softness: -1 is not allowed, it must be in [0, 1e30]"),
        ("{ extent = 0.5, transition = -1, of = 1 }", ".transition: -1 is not allowed"),
        ("{ of = 1, factor = 2 }", ".factor: unknown key, allowed: `of`, `scale`, `offset`"),
        (&deep, ".of.of"),
    ] {
        let message = refused(&cover(field));
        let want = format!("line 4, part[1].cover{want}");
        assert!(message.starts_with(&want), "{field}\n  gives {message}\n   want {want}");
    }
}

#[test]
fn colours_are_refused_with_their_place() {
    let many = format!("{{ ramp = [{}], by = 1 }}", "1, ".repeat(65));
    for (colour, want) in [
        ("\"red\"", ": found a string, expected a number, a list of three numbers"),
        ("[1, 2]", ": found a list of 2, expected three numbers"),
        ("[0, 0, nan]", "[2]: NaN is not allowed, it must be in [0, 1]"),
        ("{ gray = 1 }", ".gray: unknown key, did you mean `grey`?"),
        ("{ ramp = [1] }", ".by: missing"),
        ("{ ramp = [], by = 1 }", ".ramp: there are 0 colours, a ramp has 1 to 64"),
        (&many, ".ramp: there are 65 colours"),
        ("{ ramp = [[1, 1, 2]], by = 1 }", ".ramp[0][2]: 2 is not allowed, it must be in [0, 1]"),
        ("{ ramp = [0, 1], at = [0], by = 1 }", ".at: there are 1 positions for 2 colours"),
        ("{ ramp = [0, 1], at = [1, 0], by = 1 }", ".at[1]: positioned below the colour before it"),
        ("{ ramp = [0, 1], at = [0, 1e99], by = 1 }", ".at[1]: 1e99 is not allowed"),
        ("{ bands = [0, 1], softness = -1, by = 1 }", ".softness: -1 is not allowed"),
        ("{ image = \"a.png\", srgb = 1 }", ".srgb: found a number, expected true or false"),
        ("{ image = \"missing.png\" }", ".image: \"missing.png\" cannot be used"),
        ("{ colour = 1 }", ".scale: missing"),
        ("{ mix = [0, 3], by = 1 }", ".mix[1]: 3 is not allowed, it must be in [0, 1]"),
        ("{ film = 3 }", ".film: found a number"),
        (
            "{ film = { absorption = 1, scattering = -1, thickness = 1, ground = 1 } }",
            ".film.scattering: -1 is not allowed",
        ),
        ("{ film = { absorption = 1, scattering = 1, ground = 1 } }", ".film.thickness: missing"),
        (
            "{ film = { absorption = 1, scattering = 1, thickness = -2, ground = 1 } }",
            ".film.thickness: -2 is not allowed",
        ),
    ] {
        let message = refused(&albedo(colour));
        let want = format!("line 4, part[1].layer[0].interface.diffuse.albedo{want}");
        assert!(message.starts_with(&want), "{colour}\n  gives {message}\n   want {want}");
    }
}

/// Numbers that choose what a file says.
struct Chance(u32, u32);

impl Chance {
    fn below(&mut self, count: u32) -> u32 {
        self.1 += 1;
        brdf::random::random_words([self.0, self.1, 0, 0])[0] % count
    }

    fn one<'a>(&mut self, of: &[&'a str]) -> &'a str {
        of[self.below(of.len() as u32) as usize]
    }

    fn number(&mut self) -> &'static str {
        self.one(&["0.5", "0", "1", "0.02", "-0.3", "1e30", "-1e30", "1e-30", "7.5"])
    }

    fn scalar(&mut self, depth: u32) -> String {
        let deep = depth > 2;
        match self.below(if deep { 4 } else { 11 }) {
            0 => self.one(&["0.5", "0.3", "1"]).to_owned(),
            1 => self.one(&["'u'", "'x'", "'occlusion'", "'distance'"]).to_owned(),
            2 => format!("{{ noise = {{ frequency = {}, octaves = {} }} }}", self.number(), self.below(12) + 1),
            3 => "{ image = 'a.png', channel = 'g', repeat = [3, 0.5] }".to_owned(),
            4 => format!("{{ sum = [{}, {}] }}", self.scalar(depth + 1), self.scalar(depth + 1)),
            5 => format!("{{ product = [{}, {}] }}", self.scalar(depth + 1), self.number()),
            6 => format!("{{ mix = [{}, 1], by = {} }}", self.scalar(depth + 1), self.scalar(depth + 1)),
            7 => format!("{{ levels = [{}, {}], of = {} }}", self.number(), self.number(), self.scalar(depth + 1)),
            8 => format!("{{ above = {}, softness = 0.1, of = {} }}", self.number(), self.scalar(depth + 1)),
            9 => format!("{{ extent = {}, transition = 0.2, of = {} }}", self.number(), self.scalar(depth + 1)),
            _ => {
                format!("{{ of = {}, scale = {}, offset = {} }}", self.scalar(depth + 1), self.number(), self.number())
            }
        }
    }

    fn colour(&mut self, depth: u32) -> String {
        match self.below(if depth > 2 { 3 } else { 8 }) {
            0 => "0.5".to_owned(),
            1 => "[0.25, 1, 0.75]".to_owned(),
            2 => "{ image = 'a.png' }".to_owned(),
            3 => format!("{{ grey = {} }}", self.scalar(depth + 1)),
            4 => format!("{{ ramp = [0, [0.5, 1, 1], 1], by = {} }}", self.scalar(depth + 1)),
            5 => format!("{{ bands = [0, 0.75, 1], softness = 0.1, by = {} }}", self.scalar(depth + 1)),
            6 => format!("{{ mix = [0, {}], by = {} }}", self.colour(depth + 1), self.scalar(depth + 1)),
            _ => format!("{{ colour = {}, scale = {} }}", self.colour(depth + 1), self.scalar(depth + 1)),
        }
    }

    fn file(&mut self) -> String {
        let (cover, alpha, base) = (self.scalar(0), self.scalar(0), self.colour(0));
        let (sigma, thickness, dim) = (self.colour(0), self.scalar(0), self.colour(0));
        let height = self.scalar(0);
        let medium = format!("medium = {{ sigma = {sigma}, thickness = {thickness} }}");
        let coat = format!("{{ interface = {{ dielectric = {{ n = 1.5 }}, alpha = {alpha} }}, {medium} }}");
        let relief = format!("relief = {{ height = {height}, step = 0.01 }}");
        let base = format!("{{ interface = {{ diffuse = {{ albedo = {base} }} }} }}");
        second(&format!("cover = {cover}\nreflectivity = {dim}\n{relief}\nlayer = [{coat}, {base}]"))
    }
}

/// Files of chosen fields, half of them with a character gone: read, and what they reflect is a number; or refused in one line.
#[test]
fn any_fields_are_read_or_refused() {
    let mut read = 0;
    for index in 0..20_000 {
        let mut chance = Chance(index, 0);
        let mut text = chance.file();
        if index % 2 == 1 {
            text.remove(chance.below(text.len() as u32) as usize);
        }
        match read_file(&text, load) {
            Ok(file) => {
                read += 1;
                let position = brdf::Vector::new(0.3, -0.4, 0.5);
                let [tangent, bitangent] = [brdf::Vector::new(1.0, 0.0, 0.0), brdf::Vector::new(0.0, 1.0, 0.0)];
                let point = Point { uv: [0.3, 0.7], position, tangent, bitangent, ..Point::<f32>::default() };
                let (wi, wo) = (brdf::Vector::new(0.6, 0.0, 0.8), brdf::Vector::new(0.0, -0.28, 0.96));
                let f = file.material.at(&point).reflected(wi, wo);
                assert!(f.iter().all(|x| x.is_finite() && *x >= 0.0), "{text}: {f:?}");
            }
            Err(error) => {
                let line = error.to_string();
                assert!(!line.is_empty() && !line.contains('\n'), "{text:?}: {line:?}");
                assert!(index % 2 == 1 || line.contains("is not allowed"), "{text}: {line}");
            }
        }
    }
    assert!(read > 8_000, "{read}");
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
