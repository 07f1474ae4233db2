//! What `brdf check` makes of shaders, profiles and broken input, as a user meets it.
#![cfg(feature = "cli")]

use serde_json::Value;
use std::fs::{self, File};
use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder of this test run, empty.
fn folder(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("check_cli_inputs").join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).expect("a writable folder");
    path
}

/// `brdf check` without an adapter, on a tenth of the default budget.
fn check(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_brdf"))
        .args(["check", "--no-twins", "--budget", "100000"])
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("brdf runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("no signal")
}

/// What bad input is told, which exits with 2.
fn complaint(output: &Output) -> String {
    assert_eq!(code(output), 2, "{output:?}");
    text(&output.stderr)
}

fn report(output: &Output) -> Value {
    let json: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {output:?}"));
    json["reports"][0].clone()
}

fn finding<'a>(report: &'a Value, check: &str) -> &'a Value {
    let findings = report["findings"].as_array().expect("a list");
    findings.iter().find(|finding| finding["check"] == check).unwrap_or_else(|| panic!("no {check} in {report}"))
}

/// Lambert as two languages write it, its albedo a parameter; beside it a term that is not reciprocal and one that never ends.
const WGSL: &str = "fn lambert(L: vec3f, V: vec3f, N: vec3f, albedo: f32) -> f32 { return albedo / 3.14159265; }\n\
    fn lopsided(L: vec3f, V: vec3f, N: vec3f) -> f32 { return 0.2 * (1.0 + dot(N, V)); }\n\
    fn endless(L: vec3f, V: vec3f, N: vec3f) -> f32 {\n\
        var x = dot(N, L);\n    loop { x = x + 1.0; if (x < 0.0) { break; } }\n    return x;\n}\n\
    fn grazing(L: vec3f, V: vec3f, N: vec3f) -> f32 {\n\
        var x = 0.3;\n    loop { if (dot(N, L) > 0.5) { break; } x = x * 0.5; }\n    return x;\n}\n";
const GLSL: &str = "precision highp float;\nfloat lambert(const in vec3 l, const in vec3 v, float albedo) {\n\
    return albedo / 3.14159265;\n}\n";

#[test]
fn a_function_of_either_language_is_judged() {
    let at = folder("languages");
    fs::write(at.join("a.wgsl"), WGSL).expect("a file");
    fs::write(at.join("a.glsl"), GLSL).expect("a file");
    for (language, file, kind) in [("--wgsl", "a.wgsl", "WGSL"), ("--glsl", "a.glsl", "GLSL")] {
        let judged = report(&check(&at, &[language, file, "--fn", "lambert", "--json"]));
        assert_eq!((&judged["kind"], &judged["verdict"]), (&kind.into(), &"PASS".into()), "{judged}");
        assert_eq!(judged["coverage"]["parameters"][0]["name"], "albedo");
        // White is within the range that was searched, and is the most there is.
        let albedo = finding(&judged, "ENERGY")["value"].as_f64().expect("a number");
        assert!((albedo - 1.0).abs() < 1e-3, "{albedo}");
        // Beyond its range it gains: 1.5 of 1.
        let gains = check(&at, &[language, file, "--fn", "lambert", "--range", "albedo=0..1.5", "--json"]);
        assert_eq!(code(&gains), 1);
        let gains = report(&gains);
        let energy = finding(&gains, "ENERGY");
        assert!((energy["value"].as_f64().expect("a number") - 1.5).abs() < 1e-3, "{energy}");
        assert_eq!(energy["parameters"][0]["value"], 1.5);
        // The file is found without the option too.
        assert_eq!(code(&check(&at, &[file, "--fn", "lambert", "--param", "albedo=0.5"])), 0);
    }
}

#[test]
fn what_is_no_shader_is_refused_where_it_is_wrong() {
    let at = folder("refused");
    fs::create_dir(at.join("shaders")).expect("a folder");
    fs::write(at.join("a.wgsl"), WGSL).expect("a file");
    fs::write(
        at.join("b.wgsl"),
        "fn counted(n: u32) -> f32 { return 0.3; }\n\
         fn width(roughness: f32) -> f32 { return roughness; }\n\
         fn framed(q: mat3x3f, wo: vec3f) -> f32 { return (q * wo).z; }\n",
    )
    .expect("a file");
    fs::write(at.join("torn.wgsl"), "fn f(L: vec3f) -> f32 {\n    return 1.0 +;\n}\n").expect("a file");
    for (arguments, says) in [
        (&["--wgsl", "shaders", "--fn", "f"][..], "shaders: is a folder"),
        (&["--glsl", "shaders", "--fn", "f"], "shaders: is a folder"),
        (&["--wgsl", "none.wgsl", "--fn", "f"], "none.wgsl"),
        (&["--wgsl", "a.wgsl"], "--fn"),
        (&["a.wgsl"], "--fn"),
        (&["--wgsl", "a.wgsl", "--fn", "phong"], "lambert"),
        (&["--wgsl", "torn.wgsl", "--fn", "f"], "torn.wgsl:2:"),
        (&["--wgsl", "a.wgsl", "--fn", "lambert", "--param", "roughness=1"], "roughness"),
        (&["--wgsl", "a.wgsl", "--fn", "lambert", "--map", "albedo=sky"], "sky"),
        (&["--wgsl", "b.wgsl", "--fn", "counted"], "`fn counted(n: u32) -> f32` takes no direction"),
        (&["--wgsl", "b.wgsl", "--fn", "width"], "`fn width(roughness: f32) -> f32` takes no direction"),
        (&["--wgsl", "b.wgsl", "--fn", "framed"], "what `q` of `fn framed(q: mat3x3<f32>, wo: vec3<f32>) -> f32` is"),
    ] {
        let said = complaint(&check(&at, arguments));
        assert!(said.contains(says), "{arguments:?}: {said}");
    }
}

/// What a function does not read may be anything, and the report says that it was left at 0.
#[test]
fn parameters_that_nothing_depends_on_are_noted() {
    let at = folder("idle");
    fs::write(at.join("a.wgsl"), "fn f(q: mat3x3f, wi: vec3f, wo: vec3f) -> f32 { return 0.3; }\n").expect("a file");
    let judged = report(&check(&at, &["--wgsl", "a.wgsl", "--fn", "f", "--json"]));
    let notes = judged["notes"].to_string();
    assert!(judged["verdict"] == "PASS" && notes.contains("q = 0: the function does not read it"), "{judged}");
}

/// A material that varies is judged over its points and numbers; commands that want a stack say where it belongs.
#[test]
fn materials_are_judged_at_their_worst_point() {
    let at = folder("materials");
    let file = |model: &str| {
        format!(
            "name = \"capped\"\n[[part]]\nlayer = [{{ interface = {{ diffuse = {{ albedo = 0.5 }} }} }}]\n[[part]]\n\
             cover = {{ above = 0.8, softness = 0.01, of = \"v\" }}\nmodel = \"{model}\"\nlayer = [\n\
             {{ interface = {{ conductor = {{ n = [2.83, 3.10, 3.06], k = [0.083, 0.19, 0.6] }}, alpha = 0.1 }} }},\n\
             {{ interface = {{ conductor = {{ n = [0.213, 1.04, 1.17], k = [4.05, 2.59, 2.36] }}, alpha = 0.3 }} }} ]\n"
        )
    };
    fs::write(at.join("fine.toml"), file("conserving")).expect("a file");
    fs::write(at.join("gains.toml"), file("elek")).expect("a file");
    let fine = report(&check(&at, &["fine.toml", "--json"]));
    assert_eq!((&fine["kind"], &fine["verdict"]), (&"material".into(), &"PASS".into()), "{fine}");
    assert_eq!(fine["subject"], "capped of fine.toml");
    let walks = "[[part]]\nstack = { model = \"walk\", layer = [{ interface = { dielectric = { n = 1.5 }, alpha = 0.1 } },\n\
        { interface = { diffuse = { albedo = 0.5 } } }] }\n";
    fs::write(at.join("walks.toml"), walks).expect("a file");
    let gains = report(&check(&at, &["gains.toml", "--json"]));
    assert_eq!(gains["verdict"], "FAIL", "{gains}");
    let energy = finding(&gains, "ENERGY");
    let v = energy["parameters"].as_array().expect("a list").iter().find(|one| one["name"] == "v").expect("v");
    assert!(v["value"].as_f64().expect("a number") > 0.78, "{energy}");
    let again = energy["again"].as_str().expect("a command");
    let seen = check(&at, &again.split(' ').skip(2).collect::<Vec<_>>());
    assert_eq!(code(&seen), 1, "{again}: {seen:?}");

    let patina = check(&at, &["patina", "--param", "u=0.25", "--param", "extent=0.5"]);
    assert_eq!(code(&patina), 0, "{patina:?}");
    for (arguments, says) in [
        (&["check", "coated_ceramic", "--model", "elek"][..], "--model is about stacks"),
        (&["check", "coated_ceramic", "--param", "gloss=1"], "there are n, alpha, albedo_r"),
        (&["check", "walks.toml"], "part[0]: the walk's f is a mean of random numbers"),
        (&["check", "patina", "--range", "v=5..9"], "patina: v is 5"),
        (&["check", "car_paint", "--range", "footprint=0.001..0.01"], "sees single flakes of spacing"),
        (
            &["check", "car_paint", "--param", "footprint=0.1", "--range", "spacing=0.1..1"],
            "sees single flakes of spacing",
        ),
        (&["check", "no_such"], "neither a built-in stack or material"),
        (&["plan", "patina"], "patina is a material that varies over a surface"),
        (&["plan", "fine.toml"], "fine.toml is a material that varies over a surface"),
    ] {
        let output =
            Command::new(env!("CARGO_BIN_EXE_brdf")).args(arguments).current_dir(&at).output().expect("brdf runs");
        let said = complaint(&output);
        assert!(said.contains(says), "{arguments:?}: {said}");
    }
}

#[test]
fn a_loop_that_never_ends_is_told_and_ended() {
    let at = folder("endless");
    fs::write(at.join("a.wgsl"), WGSL).expect("a file");
    let said = complaint(&check(&at, &["--wgsl", "a.wgsl", "--fn", "endless"]));
    assert!(said.contains("`endless of a.wgsl` has not ended after"), "{said}");
    // It is told too where only some directions never end.
    for asked in [&[][..], &["--at", "theta=0,view"], &["--html", "page.html"]] {
        let said = complaint(&check(&at, &[&["--wgsl", "a.wgsl", "--fn", "grazing"], asked].concat()));
        assert!(said.contains("`grazing of a.wgsl` has not ended"), "{asked:?}: {said}");
    }
}

#[test]
fn profiles_say_what_binds() {
    let at = folder("profiles");
    fs::write(at.join("a.wgsl"), WGSL).expect("a file");
    // 0.2 (1 + NoV): the albedo is at most 0.4 π at a fixed view, and the two orders differ.
    let judge = |profile: &str| {
        let arguments = ["--wgsl", "a.wgsl", "--fn", "lopsided", "--profile", profile, "--json"];
        let output = check(&at, &arguments);
        (code(&output), report(&output))
    };
    let (strict, lines) = judge("strict");
    assert_eq!((strict, &finding(&lines, "RECIPROCITY")["verdict"]), (1, &"FAIL".into()));
    let (_, lines) = judge("realtime");
    assert_eq!(finding(&lines, "RECIPROCITY")["binding"], false);
    let (term, lines) = judge("term");
    assert_eq!((term, &finding(&lines, "SIGN")["verdict"]), (0, &"PASS".into()), "{lines}");
}

/// A MERL file whose bins all hold `value`, but for the one at `hole`.
fn measured(path: &Path, value: f64, hole: Option<(u64, f64)>) {
    let mut out = BufWriter::new(File::create(path).expect("a file"));
    for n in [90i32, 90, 180] {
        out.write_all(&n.to_le_bytes()).expect("written");
    }
    let row: Vec<u8> = (0..180).flat_map(|_| value.to_le_bytes()).collect();
    for _ in 0..3 * 90 * 90 {
        out.write_all(&row).expect("written");
    }
    if let Some((bin, value)) = hole {
        out.seek(SeekFrom::Start(12 + 8 * bin)).expect("a seek");
        out.write_all(&value.to_le_bytes()).expect("written");
    }
}

#[test]
fn measurements_are_judged_and_broken_ones_refused_by_offset() {
    let at = folder("merl");
    // Red is scaled by 1/1500: an albedo of .3 there, 1.66 times that in blue.
    let value = 0.3 / std::f64::consts::PI * 1500.0;
    measured(&at.join("grey.binary"), value, None);
    let judged = report(&check(&at, &["grey.binary", "--json"]));
    assert_eq!((&judged["kind"], &judged["verdict"]), (&"MERL".into(), &"PASS".into()), "{judged}");
    measured(&at.join("hole.binary"), value, Some((1000, f64::NAN)));
    let said = complaint(&check(&at, &["hole.binary"]));
    assert!(said.contains("hole.binary") && said.contains("8012"), "{said}");
    let torn = File::options().write(true).open(at.join("grey.binary")).expect("the file");
    torn.set_len(20_000_000).expect("cut");
    let said = complaint(&check(&at, &["grey.binary"]));
    assert!(said.contains("34992012"), "{said}");
}

/// Whether it ends; what waits for a pipe never does.
#[cfg(unix)]
fn ended(mut child: std::process::Child) -> Output {
    for _ in 0..1200 {
        if child.try_wait().expect("a child").is_some() {
            return child.wait_with_output().expect("ended");
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    child.kill().expect("killed");
    panic!("it waits");
}

#[cfg(unix)]
fn piped(folder: &Path, arguments: &[&str], input: &str) -> Output {
    use std::process::Stdio;
    let mut child = Command::new(env!("CARGO_BIN_EXE_brdf"))
        .args(["check", "--no-twins", "--budget", "20000"])
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("brdf runs");
    // What is refused may not read it.
    let _ = child.stdin.take().expect("a pipe").write_all(input.as_bytes());
    ended(child)
}

#[test]
#[cfg(unix)]
fn pipes_are_read_once_and_never_waited_for() {
    let at = folder("pipes");
    let layer = "layer]]\ninterface = { diffuse = { albedo = 0.5 } }\n";
    let (stack, material) = (format!("[[{layer}"), format!("[[part]]\n[[part.{layer}"));
    for (text, kind) in [(&stack, "conserving"), (&material, "material")] {
        let judged = piped(&at, &["/dev/stdin", "--json"], text);
        assert_eq!((code(&judged), &report(&judged)["kind"]), (0, &kind.into()), "{judged:?}");
    }
    let shader = piped(&at, &["/dev/stdin", "--fn", "lambert"], WGSL);
    let line = complaint(&shader);
    assert!(line.contains("/dev/stdin: ") && line.contains("name it by --wgsl") && line.lines().count() == 1, "{line}");
    let shader = piped(&at, &["--wgsl", "/dev/stdin", "--fn", "lambert"], WGSL);
    assert_eq!(code(&shader), 0, "{shader:?}");

    fs::write(at.join("stack.toml"), &stack).expect("a file");
    let made = Command::new("mkfifo").arg("pipe").current_dir(&at).status().expect("mkfifo runs");
    assert!(made.success());
    for option in ["--html", "--junit"] {
        let line = complaint(&piped(&at, &["stack.toml", option, "pipe"], ""));
        assert!(line.contains("pipe: ") && line.contains("named pipe") && line.lines().count() == 1, "{line}");
        let said = piped(&at, &["stack.toml", option, "/dev/stdout"], "");
        assert!(code(&said) == 0 && text(&said.stdout).starts_with('<'), "{said:?}");
        assert_eq!(code(&piped(&at, &["stack.toml", option, "/dev/null"], "")), 0);
    }
    let whole = piped(&at, &[".", "--json"], "");
    assert_eq!((code(&whole), &report(&whole)["kind"]), (0, &"conserving".into()), "{whole:?}");
}

/// What an adapter refuses is no reason to be silent about it.
#[test]
fn an_adapter_that_is_left_out_is_told() {
    let at = folder("large");
    let side = 4096;
    image::GrayImage::from_pixel(side, side, image::Luma([128])).save(at.join("large.png")).expect("a file");
    let text = "[[part]]\nlayer = [{ interface = { diffuse = { albedo = { image = \"large.png\" }, sigma = 0 } } }]\n";
    fs::write(at.join("large.toml"), text).expect("a file");
    let Ok(gpu) = brdf::gpu::Gpu::open(None) else { return };
    let judged = Command::new(env!("CARGO_BIN_EXE_brdf"))
        .args(["check", "large.toml", "--budget", "20000", "--json"])
        .current_dir(&at)
        .output()
        .expect("brdf runs");
    let notes = report(&judged)["notes"].to_string();
    // 16 bytes a texel.
    let refused = gpu.device().limits().max_storage_buffer_binding_size < 16 * u64::from(side * side);
    let said = notes.contains("the adapter is left out: the material's images (of 1, the largest 4096×4096 texels)");
    assert_eq!(said, refused, "{notes}");
}
