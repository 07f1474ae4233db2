//! `brdf render` as a user meets it.
#![cfg(feature = "cli")]

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder of this test run, empty.
fn folder(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("render_cli").join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).expect("a writable folder");
    path
}

fn render(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_brdf"))
        .args(["render", "--size", "16x12"])
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("brdf runs")
}

fn report(output: &Output) -> Value {
    assert!(output.status.success(), "{output:?}");
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {output:?}"))
}

#[test]
fn a_picture_is_written() {
    let folder = folder("written");
    for (out, mode) in [("a.png", "realtime"), ("a.exr", "offline")] {
        let output = render(&folder, &["copper", "--mode", mode, "--samples", "4", "--out", out, "--json"]);
        // A pipe shows no progress.
        assert!(output.stderr.is_empty(), "{output:?}");
        let report = report(&output);
        assert_eq!((&report["width"], &report["height"], &report["samples"]), (&16.into(), &12.into(), &4.into()));
        let picture = image::open(folder.join(out)).expect("a picture");
        assert_eq!((picture.width(), picture.height()), (16, 12));
    }
    let shown = render(&folder, &["car_paint", "--light", "directional:1,-1,1,50", "--shape", "torus:0.3"]);
    let text = String::from_utf8(shown.stdout).expect("UTF-8");
    assert!(text.starts_with("render.png: 16×12, 4 samples a pixel on cpu, ") && text.contains("clipped"), "{text}");
}

#[test]
fn the_same_seed_is_the_same_picture() {
    let folder = folder("seed");
    for (out, seed) in [("a.exr", "3"), ("b.exr", "3"), ("c.exr", "4")] {
        let output = render(&folder, &["gold", "--mode", "offline", "--samples", "2", "--seed", seed, "--out", out]);
        assert!(output.status.success(), "{output:?}");
    }
    let [a, b, c] = ["a.exr", "b.exr", "c.exr"].map(|name| fs::read(folder.join(name)).expect("a picture"));
    assert!(a == b && a != c);
}

#[test]
fn a_stack_file_takes_a_model() {
    let folder = folder("stack");
    let stack = "[[layer]]\ninterface = { dielectric = { n = 1.5 }, alpha = 0.1 }\n\
                 [[layer]]\ninterface = { diffuse = { albedo = 0.5 } }\n";
    fs::write(folder.join("stack.toml"), stack).expect("a file");
    let mean = |model: &str| {
        let arguments = ["stack.toml", "--model", model, "--environment", "furnace", "--mode", "offline", "--json"];
        report(&render(&folder, &arguments))["mean"][0].as_f64().expect("a number")
    };
    let (less, more) = (mean("conserving"), mean("coupled"));
    // The light that bounces under the coat: a third of what the base reflects.
    assert!(less < more && more < 1.0, "{less} {more}");
}

#[test]
fn nothing_is_left_of_a_picture_that_is_broken_off() {
    let folder = folder("broken_off");
    let mut child = Command::new(env!("CARGO_BIN_EXE_brdf"))
        .args(["render", "copper", "--mode", "offline", "--samples", "1000000"])
        .current_dir(&folder)
        .spawn()
        .expect("brdf runs");
    std::thread::sleep(std::time::Duration::from_secs(2));
    assert!(child.try_wait().expect("a child").is_none(), "it was to take longer");
    child.kill().expect("killed");
    child.wait().expect("ended");
    assert_eq!(fs::read_dir(&folder).expect("a folder").count(), 0);
}

#[test]
fn figures_are_those_of_the_documents() {
    let folder = folder("gallery");
    let gallery = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_brdf"));
        command.args(["render", "--gallery"]).arg(&folder).args(arguments).output().expect("brdf runs")
    };
    let made = report(&gallery(&["--only", "tables", "--json"]));
    assert_eq!(made.as_array().map(Vec::len), Some(2), "{made}");
    for name in ["distribution_tables.png", "tables.png"] {
        let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/img/gallery").join(name);
        let [made, kept] = [folder.join(name), kept].map(|path| image::open(path).expect("a picture").into_rgb8());
        assert_eq!(made.dimensions(), kept.dimensions(), "{name}");
        // Closed forms in f64: what another system's functions round otherwise may move a byte by one.
        let most = made.as_raw().iter().zip(kept.as_raw()).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(most <= Some(1), "{name}: a byte differs by {most:?}");
    }
    assert_eq!(fs::read_dir(&folder).expect("a folder").count(), 2);
    for (arguments, said) in [
        (&["--only", "tables", "--out", "a.png"][..], "cannot be used with"),
        (&["--size", "16x16"], "cannot be used with"),
        (&["--gpu"], "cannot be used with"),
        (&["--only", "sculptures"], "no figure is called sculptures"),
    ] {
        let output = gallery(arguments);
        let error = String::from_utf8(output.stderr.clone()).expect("UTF-8");
        assert!(output.status.code() == Some(2) && error.contains(said), "{arguments:?}: {error}");
    }
}

#[test]
fn a_material_file_brings_its_images() {
    let folder = folder("material");
    let map = image::GrayImage::from_fn(2, 1, |x, _| image::Luma([if x == 0 { 0 } else { 255 }]));
    map.save(folder.join("halves.png")).expect("a file");
    let text =
        "[[part]]\nlayer = [{ interface = { diffuse = { albedo = { image = \"halves.png\" }, sigma = 0.0 } } }]\n";
    fs::write(folder.join("halves.toml"), text).expect("a file");
    let arguments =
        ["halves.toml", "--shape", "plane", "--environment", "furnace", "--elevation", "80", "--out", "a.exr"];
    let whole = report(&render(&folder, &[&arguments[..], &["--json", "--no-backdrop"]].concat()));
    // White where the map is, black where it is not: the brightest pixel is about 1, and the mean far below.
    let [mean, largest] = ["mean", "largest"].map(|key| whole[key][0].as_f64().expect("a number"));
    assert!(largest > 0.9 && largest < 1.001 && mean < 0.5, "{mean} {largest}");
}

#[test]
fn bad_input_is_one_line_and_nothing_is_written() {
    let folder = folder("refused");
    fs::write(folder.join("empty.obj"), "v 0 0 0\n").expect("a file");
    fs::write(folder.join("text.hdr"), "no picture").expect("a file");
    fs::write(folder.join("bad.toml"), "[[layer]]\ninterface = { dielectric = { n = -1 }, alpha = 0.1 }\n")
        .expect("a file");
    let painted =
        "[[part]]\nlayer = [{ interface = { diffuse = { albedo = { image = \"absent.png\" }, sigma = 0.3 } } }]\n";
    fs::write(folder.join("painted.toml"), painted).expect("a file");
    fs::write(folder.join("neither.toml"), "name = \"paint\"\nmodel = \"elek\"\n").expect("a file");
    let walks = "model = \"walk\"\n[[layer]]\ninterface = { diffuse = { albedo = 0.5 } }\n";
    fs::write(folder.join("walks.toml"), walks).expect("a file");
    fs::create_dir(folder.join("folder.png")).expect("a folder");
    for (arguments, said) in [
        (&["neither.toml"][..], "neither.toml: layer: a stack needs at least one layer"),
        (&["walks.toml"], "walks.toml: part[0] is under the model `walk`"),
        (&["copper", "--model", "walk", "--mode", "offline"], "--model walk: "),
        (&["copper", "--distance", "0.5"], "--distance 0.5: the camera is inside the sphere"),
        (&["copper", "--distance", "1", "--shape", "torus:0.4"], "inside the torus:0.4"),
        (&["copper", "--only", "rust"], "cannot be used with"),
        (&["copper", "--out", "absent/a.png"], "--out absent/a.png: "),
        (&["copper", "--out", "folder.png"], "--out folder.png: a folder is in the way"),
        (&["copper", "--light", "point:0,0,1e60"], "a coordinate of 1e60"),
        (&["copper", "--shape", "cube"], "--shape cube"),
        (&["copper", "--shape", "torus:2"], "[0.01, 0.99]"),
        (&["copper", "--shape", "empty.obj"], "empty.obj: no triangles"),
        (&["copper", "--shape", "absent.obj"], "absent.obj: "),
        (&["copper", "--environment", "text.hdr"], "text.hdr: "),
        (&["copper", "--environment", "cellar"], "--environment cellar"),
        (&["copper", "--out", "a.bmp"], "a.bmp: a picture is a .png or an .exr file"),
        (&["copper", "--set", "alpha=0.1"], "--set alpha"),
        (&["car_paint", "--set", "wheels=4"], "wheels"),
        (&["car_paint", "--model", "elek"], "--model elek"),
        (&["copper", "--elevation", "90"], "the elevation is 90"),
        (&["copper", "--field", "0"], "the field of view is 0"),
        (&["unobtainium"], "unobtainium is neither"),
        (&["bad.toml"], "bad.toml: "),
        (&["copper", "--light", "torch:1,2,3"], "torch"),
        (&["copper", "--samples", "0"], "0 is not in"),
        (&["painted.toml"], "absent.png"),
        (&["copper", "--gpu", "--adapter", "no such adapter"], "no such adapter"),
    ] {
        let output = render(&folder, arguments);
        let error = String::from_utf8(output.stderr.clone()).expect("UTF-8");
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(error.contains(said), "{arguments:?}: {error}");
        // What clap refuses comes with its usage.
        assert!(error.starts_with("error: ") || error.lines().count() == 1, "{arguments:?}: {error}");
        assert!(!folder.join("render.png").exists(), "{arguments:?}");
    }
}
