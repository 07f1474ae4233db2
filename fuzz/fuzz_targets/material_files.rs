//! Material files, as any text and as fragments of real ones: read, or refused in one line that says where.

#![no_main]

use arbitrary::{Arbitrary, Unstructured};
use brdf::Vector;
use brdf::material::Point;
use brdf::material::description::read_file;
use brdf::texture::image::Image;
use libfuzzer_sys::fuzz_target;

const FRAGMENTS: [&str; 68] = [
    "[[part]]\n",
    "[[part.layer]]\n",
    "[part]\n",
    "interface = ",
    "medium = ",
    "dielectric",
    "conductor",
    "diffuse",
    "alpha",
    "n",
    "k",
    "metal",
    "albedo",
    "sigma",
    "thickness",
    " = ",
    "{ ",
    " }",
    "[",
    "]",
    ", ",
    "\n",
    "1.5",
    "0.1",
    "-1",
    "nan",
    "inf",
    "1e999",
    "\"copper\"",
    "\"u\"",
    "\"occlusion\"",
    "cover = ",
    "reflectivity = ",
    "relief = ",
    "height",
    "step",
    "normals",
    "image",
    "\"a.png\"",
    "repeat",
    "noise",
    "ridged",
    "scratches",
    "density",
    "width",
    "layers",
    "frequency",
    "octaves",
    "seed",
    "sum",
    "product",
    "mix",
    "by",
    "levels",
    "above",
    "of",
    "extent",
    "ramp",
    "bands",
    "grey",
    "colour",
    "scale",
    "film",
    "flakes",
    "brushed = { metal = 'iron', along = 0.1, across = 0.2 }\n",
    "stack = ",
    "material = \"patina\"\n",
    "[[part]]\nlayer = [{ interface = { diffuse = { albedo = { ramp = [0, 1], by = 'v' } } } }]\n",
];

fn text(data: &[u8]) -> String {
    let mut source = Unstructured::new(data);
    if bool::arbitrary(&mut source).unwrap_or(false) {
        return String::from_utf8_lossy(source.take_rest()).into_owned();
    }
    let mut text = String::new();
    while let (false, Ok(index)) = (source.is_empty(), u8::arbitrary(&mut source)) {
        text.push_str(FRAGMENTS[usize::from(index) % FRAGMENTS.len()]);
    }
    text
}

fuzz_target!(|data: &[u8]| {
    let text = text(data);
    let load = |_: brdf::material::description::ImageRequest| {
        Image::new(1, 1, 1, vec![0.5]).map_err(|error| error.to_string())
    };
    match read_file(&text, load) {
        Ok(read) => {
            // What was read is a material: it reflects what is finite and not negative.
            let point = Point { uv: [0.3, 0.7], position: Vector::new(0.3, -0.4, 0.5), ..Point::<f32>::default() };
            let (wi, wo) = (Vector::new(0.6, 0.0, 0.8), Vector::new(0.0, -0.28, 0.96));
            let f = read.material.at(&point).reflected(wi, wo);
            assert!(f.iter().all(|x| x.is_finite() && *x >= 0.0), "{text:?}: {f:?}");
        }
        Err(error) => {
            let line = error.to_string();
            assert!(!line.is_empty() && !line.contains('\n'), "{text:?}: {line:?}");
        }
    }
});
