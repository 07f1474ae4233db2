//! Materials of files that reach what the built-in ones do not.

use brdf::Vector;
use brdf::material::Material;
use brdf::material::description::{ImageRequest, read_file};
use brdf::random::random;
use brdf::texture::bump::encode;
use brdf::texture::image::Image;

/// Each under its name, the parts after a first one of iron.
const PARTS: &[(&str, &str)] = &[
    (
        "normal maps",
        r#"
cover = 0.5
relief = { normals = { image = "normals", repeat = 3 }, strength = 1.5 }
layer = [{ interface = { conductor = { metal = "gold" }, alpha = 0.3 } }]
[[part]]
cover = 0.5
relief = { normals = { image = "two channels", repeat = [2, 3.5] }, encoding = "alpha_green", strength = -0.7 }
brushed = { metal = "chromium", along = 0.1, across = { mix = [0.3, 0.6], by = "v" }, turn = { of = "u", scale = 7, offset = -3 } }
"#,
    ),
    (
        "images in fields",
        r#"
cover = { image = "colours", channel = "b", repeat = [3, -2] }
relief = { height = { of = { image = "grey", repeat = 2 }, scale = 0.05 }, step = 0.01 }
reflectivity = { image = "colours", repeat = 4 }
[[part.layer]]
interface = { dielectric = { n = { mix = [1.33, { image = "colours", srgb = false }], by = { image = "grey" } } }, alpha = { image = "grey", channel = "r" } }
[[part.layer]]
interface = { diffuse = { albedo = { colour = { image = "colours" }, scale = { image = "grey", repeat = 7 } }, sigma = { image = "grey" } } }
"#,
    ),
    (
        "flakes of a map under weidlich_wilkie",
        r#"
cover = 0.7
model = "weidlich_wilkie"
widths = "clamp"
[[part.layer]]
interface = { dielectric = { n = 1.5 }, alpha = 0.2 }
[[part.layer]]
interface = { conductor = { metal = "copper" }, alpha = 0.1 }
flakes = { normals = { image = "normals", repeat = 20 } }
"#,
    ),
    (
        "every field",
        r#"
cover = { levels = [0.2, 0.9], of = { sum = ["x", "y", { of = "z", scale = -1 }] } }
[[part.layer]]
interface = { conductor = { n = { mix = [1.0, 2.0], by = { ridged = { frequency = 2, octaves = 3 } } }, k = { colour = [1, 2, 3], scale = { product = ["u", "v", 4] } } }, alpha = { extent = 0.3, transition = 0.2, of = "occlusion" } }
[[part]]
cover = { above = 0.4, softness = 0.3, of = "occlusion" }
returns = true
[[part.layer]]
interface = { dielectric = { n = 1.5 }, alpha = { extent = 0.5, transition = 0.5, of = "v" } }
[[part.layer]]
interface = { diffuse = { albedo = { mix = [{ ramp = [0.1, [0.9, 0.5, 0.2], 0.4], at = [0, 0.3, 0.7], by = "u" }, { bands = [0.2, 0.7, [0.1, 0.4, 0.3]], softness = 0.05, by = "v" }], by = "occlusion" } } }
"#,
    ),
    (
        "a film that is nowhere and a ground that is too bright",
        r#"
cover = 0.8
layer = [{ interface = { diffuse = { albedo = { film = { absorption = [1, 2, 3], scattering = 8, thickness = { of = "x", scale = 0.1 }, ground = { colour = [0.5, 1, 3], scale = "v" } } } } } }]
"#,
    ),
    (
        "fields beyond their ranges",
        r#"
cover = 0.8
scatter = { grey = { of = "x", scale = 3 } }
relief = { height = { noise = { frequency = 6, amplitude = 0.3 } }, step = 0.01 }
model = "elek"
widths = "variance"
[[part.layer]]
interface = { dielectric = { n = { mix = [1.2, 1.9], by = "distance" } }, alpha = { mix = [0.2, 0.4], by = { of = "z", scale = 4 } } }
medium = { sigma = { mix = [0, [1, 2, 3]], by = "y" }, thickness = { of = "y", scale = 2 } }
[[part.layer]]
interface = { conductor = { metal = "copper" }, alpha = { of = "x", scale = 2 } }
"#,
    ),
    (
        "stacks",
        r#"
cover = 0.6
stack = { model = "elek", layer = [{ interface = { dielectric = { n = 1.5 }, alpha = 0.3 } }, { interface = { conductor = { metal = "copper" }, alpha = 0.1 } }] }
[[part]]
cover = 0.6
relief = { height = { scratches = { frequency = 3, layers = 8, width = 0.1 } }, step = 0.01 }
stack = { model = "conserving", widths = "variance", layer = [{ interface = { dielectric = { n = [1.5, 1.52, 1.55] }, alpha = 0.2 }, medium = { sigma = [0.1, 1, 2], thickness = 0.3 } }, { interface = { diffuse = { albedo = [0.9, 0.5, 0.2], sigma = 0.4 } } }] }
[[part]]
cover = 0.3
stack = { model = "weidlich_wilkie", layer = [{ interface = { dielectric = { n = 1.3 }, alpha = 0.2 } }, { interface = { conductor = { metal = "iron" }, alpha = 0.3 } }] }
"#,
    ),
    (
        "slopes as steep as they may be",
        r#"
cover = 0.5
relief = { height = { of = "u", scale = 1e9 }, step = 1e-5 }
layer = [{ interface = { conductor = { metal = "gold" }, alpha = 0.5 } }]
[[part]]
cover = 0.5
relief = { normals = { image = "normals" }, strength = 1e6 }
layer = [{ interface = { conductor = { metal = "gold" }, alpha = 0.5 } }]
"#,
    ),
];

/// Eight texels square: unit normals, or numbers from .1 to 1.
fn load(request: ImageRequest<'_>) -> Result<Image, String> {
    const SIDE: u32 = 8;
    let normal = |i: u32| {
        let [x, y, ..] = random::<f64>(7, i, 0).map(|u| 1.2 * (u - 0.5));
        encode(Vector::new(x, y, (1.0 - x * x - y * y).sqrt()))
    };
    let texels: Vec<f64> = match request.file {
        "normals" => (0..SIDE * SIDE).flat_map(normal).collect(),
        "two channels" => {
            let texel = |[x, y, _]: [f64; 3]| [0.3, y, 0.7, x];
            (0..SIDE * SIDE).flat_map(|i| texel(normal(i))).collect()
        }
        "grey" => (0..SIDE * SIDE).map(|i| 0.1 + 0.9 * random::<f64>(8, i, 0)[0]).collect(),
        "colours" => {
            let bytes: Vec<u8> =
                (0..SIDE * SIDE * 3).map(|i| (25.0 + 230.0 * random::<f64>(9, i, 0)[0]) as u8).collect();
            return Image::from_bytes(SIDE, SIDE, 3, &bytes, request.encoding).map_err(|error| error.to_string());
        }
        other => return Err(format!("there is no {other}")),
    };
    let channels = texels.len() as u32 / (SIDE * SIDE);
    let texels = texels.into_iter().map(|x| x as f32).collect();
    Image::new(SIDE, SIDE, channels, texels).map_err(|error| error.to_string())
}

pub(super) fn variants() -> Vec<(&'static str, Material)> {
    let read = |(name, parts): &(&'static str, &str)| {
        let ground = "[[part]]\nlayer = [{ interface = { conductor = { metal = \"iron\" }, alpha = 0.4 } }]\n[[part]]";
        let file = read_file(&format!("{ground}{parts}"), load).unwrap_or_else(|error| panic!("{name}: {error}"));
        (*name, file.material)
    };
    PARTS.iter().map(read).collect()
}
