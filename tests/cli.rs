//! The command `brdf`, as a user meets it.
#![cfg(feature = "cli")]

use serde_json::Value;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

fn brdf(arguments: &[&str], input: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_brdf"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("brdf starts");
    child.stdin.take().expect("a pipe").write_all(input.as_bytes()).expect("brdf reads its input");
    child.wait_with_output().expect("brdf ends")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

/// The one line that `brdf` ends with on bad input; drivers may have written before it.
fn last_error(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    text(&output.stderr).lines().rfind(|line| line.starts_with("brdf: ")).unwrap_or_default().to_owned()
}

/// A stack file in a folder of this test run.
fn stack_file(name: &str, content: &str) -> String {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, content).expect("a writable folder");
    path.to_str().expect("a path in UTF-8").to_owned()
}

const CUPRITE_OVER_COPPER: &str = r#"
name  = "Cu2O over Cu"
model = "elek"
[[layer]]
interface = { conductor = { n = [2.83, 3.10, 3.06], k = [0.083, 0.19, 0.6] }, alpha = 0.1 }
[[layer]]
interface = { conductor = { n = [0.213, 1.04, 1.17], k = [4.05, 2.59, 2.36] }, alpha = 0.3 }
"#;

#[test]
fn every_built_in_material_is_plausible() {
    let output = brdf(&["check", "--no-twins", "--json"], "");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stdout));
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(json["verdict"], "PASS");
    let reports = json["reports"].as_array().expect("a list");
    assert_eq!(reports.len(), brdf::material::stack::built_in().len());
    for report in reports {
        let checks: Vec<_> = report["findings"].as_array().expect("a list").iter().map(|f| &f["check"]).collect();
        for wanted in ["ENERGY", "RECIPROCITY", "FINITE", "SIGN"] {
            assert!(checks.iter().any(|check| *check == wanted), "{wanted} in {report}");
        }
    }
}

#[test]
fn the_documents_model_gains_energy_and_says_where() {
    let file = stack_file("cuprite.toml", CUPRITE_OVER_COPPER);
    let output = brdf(&["check", "--no-twins", &file], "");
    let shown = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{shown}");
    // Angles across, the red channel below them: 2.11 at 89.5°, as computed by an independent quadrature.
    let mut lines = shown.lines().skip_while(|line| !line.contains("albedo [light fixed]"));
    let angles: Vec<_> = lines.next().expect("a row of angles").split_whitespace().skip(3).collect();
    let red: Vec<_> = lines.next().expect("the red channel").split_whitespace().skip(1).collect();
    let at = angles.iter().position(|angle| *angle == "89.5°").expect("89.5° is judged");
    assert!(red[at].starts_with("2.11"), "{shown}");
    assert!(shown.contains("ENERGY") && shown.contains("[light fixed]"), "{shown}");

    // The same layers conserve energy under the default model.
    let output = brdf(&["check", "--no-twins", "--model", "conserving", &file], "");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stdout));
}

#[test]
fn bad_stack_files_are_refused_with_file_line_and_key() {
    let layer = |interface: &str| format!("model = \"conserving\"\n\n[[layer]]\ninterface = {interface}\n");
    for (name, content, want) in [
        (
            "alpha.toml",
            layer("{ dielectric = { n = 1.5 }, alpha = 2 }"),
            "line 4, layer[0].interface.alpha: 2 is not allowed, it must be in [0.0001, 1]",
        ),
        (
            "index.toml",
            layer("{ dielectric = { n = 0 }, alpha = 0.1 }"),
            "line 4, layer[0].interface.dielectric.n: 0 is not allowed, it must be in [0.001, 1000]",
        ),
        (
            "kappa.toml",
            layer("{ conductor = { n = 1, k = -1 }, alpha = 0.1 }"),
            "line 4, layer[0].interface.conductor.k: -1 is not allowed, it must be in [0, 1000]",
        ),
        ("nan.toml", layer("{ dielectric = { n = nan }, alpha = 0.1 }"), "it must be finite"),
        (
            "key.toml",
            layer("{ dielectric = { n = 1.5 }, alhpa = 0.1 }"),
            "unknown key, allowed: `dielectric`, `conductor`, `diffuse`, `alpha`",
        ),
        ("metal.toml", layer("{ conductor = { metal = \"mithril\" }, alpha = 0.1 }"), "copper"),
        ("empty.toml", String::new(), "layer"),
        ("model.toml", "model = \"phong\"\n".to_owned(), "line 1, model"),
        ("broken.toml", "model = \n".to_owned(), "line 1"),
    ] {
        let file = stack_file(name, &content);
        let error = last_error(&brdf(&["check", &file], ""));
        assert!(error.contains(name) && error.contains(want), "{name}: {error}");
    }
    let error = last_error(&brdf(&["check", "no/such/file.toml"], ""));
    assert!(error.contains("neither a built-in stack or material") && error.contains("brdf list"), "{error}");
}

#[test]
fn eval_answers_what_it_can() {
    let input = concat!(
        "{\"term\": \"fresnel.dielectric\", \"cos\": 1, \"eta\": 1.5, \"id\": 7}\n",
        "not json\n",
        "\n",
        "{\"term\": \"fresnel.dielectric\", \"cos\": 3, \"eta\": 1.5}\n",
        "{\"term\": \"refraction.refract\", \"w\": [0.8, 0, 0.6], \"eta\": 0.5}\n",
    );
    let output = brdf(&["eval"], input);
    let error = last_error(&output);
    assert!(error.contains("2 of 4 lines"), "{error}");
    let errors = text(&output.stderr);
    assert!(errors.contains("line 2: not a JSON object") && errors.contains("line 4: `cos` is 3"), "{errors}");
    let rows: Vec<Value> = text(&output.stdout).lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert_eq!(rows.len(), 4);
    assert_eq!(rows[0]["id"], 7);
    assert!((rows[0]["F"].as_f64().expect("a number") - 0.04).abs() < 1e-15);
    assert!(rows[2]["error"].as_str().is_some_and(|error| error.contains("[0, 1]")), "{}", rows[2]);
    assert!(rows[3]["w"].is_null(), "total reflection: {}", rows[3]);
}

#[test]
fn eval_takes_stacks_by_name_file_and_inline() {
    let file = stack_file("inline.toml", CUPRITE_OVER_COPPER);
    let directions = "\"wi\": [0.6, 0, 0.8], \"wo\": [-0.28, 0, 0.96]";
    let inline = r#"{"layer": [
        {"interface": {"conductor": {"n": [2.83, 3.10, 3.06], "k": [0.083, 0.19, 0.6]}, "alpha": 0.1}},
        {"interface": {"conductor": {"n": [0.213, 1.04, 1.17], "k": [4.05, 2.59, 2.36]}, "alpha": 0.3}}]}"#
        .replace('\n', " ");
    let input = format!(
        "{{\"term\": \"stack\", \"stack\": \"{file}\", {directions}}}\n\
         {{\"term\": \"stack\", \"stack\": {inline}, \"model\": \"elek\", {directions}}}\n\
         {{\"term\": \"stack\", \"stack\": \"copper\", {directions}}}\n"
    );
    let output = brdf(&["eval"], &input);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let rows: Vec<Value> = text(&output.stdout).lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert_eq!(rows[0]["f"], rows[1]["f"]);
    assert_eq!(rows[2]["f"].as_array().map(Vec::len), Some(3));
}

#[test]
fn the_twins_answer_as_the_rust_functions_do() {
    if brdf::gpu::policy() == brdf::gpu::Policy::Off {
        eprintln!("SKIPPED: the_twins_answer_as_the_rust_functions_do: BRDF_GPU=off");
        return;
    }
    let input = "{\"term\": \"fresnel.conductor\", \"cos\": 0.5, \"n\": 0.2, \"k\": 3.9}\n\
                 {\"term\": \"stack\", \"stack\": \"varnish_over_concrete\", \"wi\": [0.6, 0, 0.8], \"wo\": [-0.28, 0, 0.96]}\n\
                 {\"term\": \"stack\", \"stack\": \"varnish_over_concrete\", \"model\": \"coupled\", \"wi\": [0.6, 0, 0.8], \"wo\": [-0.28, 0, 0.96]}\n\
                 {\"term\": \"stack\", \"stack\": \"clear_coat_over_copper\", \"model\": \"coupled\", \"wi\": [0.6, 0, 0.8], \"wo\": [-0.28, 0, 0.96]}\n";
    let rows = |mode: &str| -> Vec<Value> {
        let output = brdf(&["eval", "--as", mode], input);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        text(&output.stdout).lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
    };
    let (double, single, gpu) = (rows("f64"), rows("f32"), rows("gpu"));
    for others in [&single, &gpu] {
        let stacks = [1, 2, 3].map(|row| (&double[row]["f"][2], &others[row]["f"][2]));
        for (want, got) in stacks.into_iter().chain([(&double[0]["F"], &others[0]["F"])]) {
            let (want, got) = (want.as_f64().expect("a number"), got.as_f64().expect("a number"));
            // The inputs themselves are rounded to f32 (2⁻²⁴), and no term here magnifies that more than 50 times.
            assert!((got / want - 1.0).abs() < 50.0 * f64::from(f32::EPSILON), "{want} {got}");
        }
    }
}

#[test]
fn check_compares_the_twin_of_coupled() {
    if brdf::gpu::policy() == brdf::gpu::Policy::Off {
        eprintln!("SKIPPED: check_compares_the_twin_of_coupled: BRDF_GPU=off");
        return;
    }
    let output = brdf(&["check", "--model", "coupled", "--budget", "10000", "--json", "clear_coat_over_copper"], "");
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let findings = json["reports"][0]["findings"].as_array().expect("findings");
    let twin = findings.iter().find(|finding| finding["check"] == "TWIN").expect("a finding about the twin");
    assert_eq!(twin["verdict"], "PASS", "{twin}");
}

#[test]
fn parity_names_an_adapter_that_is_not_there() {
    let error = last_error(&brdf(&["parity", "--adapter", "voodoo 9000"], ""));
    assert!(error.contains("voodoo 9000"), "{error}");
    assert!(error.contains("mesa-vulkan-drivers"), "{error}");
    let error = last_error(&brdf(&["parity", "--function", "magic"], ""));
    assert!(error.contains("magic"), "{error}");
}

#[test]
fn plots_are_pictures_or_clear_errors() {
    let output = brdf(&["plot", "fresnel", "--metal", "gold"], "");
    assert_eq!(output.status.code(), Some(0));
    assert!(text(&output.stdout).starts_with("<svg"));
    let json: Value = serde_json::from_slice(&brdf(&["plot", "fresnel", "--json"], "").stdout).expect("JSON");
    // Normal incidence on glass: ((1.5 − 1)/(1.5 + 1))².
    let first = json["panels"][0]["curves"][0]["points"][0][1].as_f64();
    assert!(first.is_some_and(|f| (f - 0.04).abs() < 1e-15), "{first:?}");
    let error = last_error(&brdf(&["plot", "fresnel", "--metal", "mithril"], ""));
    assert!(error.contains("mithril") && error.contains("brdf list"), "{error}");
}

#[test]
fn listing_is_json_too() {
    let output = brdf(&["list", "--json"], "");
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!(json["terms"].as_array().is_some_and(|terms| terms.len() > 20));
    assert!(text(&brdf(&["list"], "").stdout).contains("clear_coat_over_copper"));
}

const COATED: &str = "[[layer]]\ninterface = { dielectric = { n = 1.5 }, alpha = 0.1 }\n[[layer]]\n\
    interface = { diffuse = { albedo = 0.5 } }\n";

#[test]
fn the_walk_is_evaluated_with_its_error_and_not_judged() {
    let line = |model| {
        let stack = serde_json::json!({"model": model, "layer": [
            {"interface": {"dielectric": {"n": 1.5}, "alpha": 0.1}}, {"interface": {"diffuse": {"albedo": 0.5}}},
        ]});
        let directions = r#""wi": [0.6, 0.0, 0.8], "wo": [0.0, 0.6, 0.8]"#;
        format!("{{\"term\": \"stack\", \"stack\": {stack}, {directions}}}\n")
    };
    let output = brdf(&["eval", "--walks", "20000", "--seed", "3"], &(line("walk") + &line("coupled")));
    let shown = text(&output.stdout);
    let answers: Vec<Value> = shown.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let number = |i: usize, key: &str| answers[i][key][0].as_f64().expect("a number");
    let (walk, error, coupled) = (number(0, "f"), number(0, "standard_error"), number(1, "f"));
    // The coupled model of this stack is within .5 % (src/layered/coupled.rs).
    assert!((walk - coupled).abs() <= 4.0 * error + 0.005 * coupled, "{shown}");
    assert!(error > 0.0 && error < 0.01 * walk && answers[1].get("standard_error").is_none(), "{shown}");

    let file = stack_file("walk.toml", &format!("model = \"walk\"\n{COATED}"));
    let error = last_error(&brdf(&["check", "--no-twins", &file], ""));
    assert!(error.contains("--model coupled"), "{error}");
}

#[test]
fn the_models_are_measured_against_the_walk() {
    let file = stack_file("coated.toml", &format!("name = \"coated\"\n{COATED}"));
    let svg = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("layered.svg");
    let picture = svg.to_str().expect("a path in UTF-8");
    drop(std::fs::remove_file(&svg));
    let arguments = ["bench", "layered", "--walks", "4096", "--json", "--svg", picture, &file, "glass_over_nothing"];
    let error = last_error(&brdf(&arguments, ""));
    assert!(error.contains("neither a built-in stack or material") && !svg.exists(), "{error}");
    let error = last_error(&brdf(&["bench", "layered", "glass"], ""));
    assert!(error.contains("give a stack of two"), "{error}");

    let output = brdf(&arguments[..8], "");
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let stack = &json["stacks"][0];
    assert_eq!((&stack["stack"], stack["walk"]["pairs"].as_array().map(Vec::len)), (&"coated".into(), Some(19)));
    let model = |name: &str, widths: &str| {
        let mut models = stack["models"].as_array().expect("a list").iter();
        models.find(|row| row["model"] == name && row["widths"] == widths).expect("a row for each model")
    };
    let rms = |name, widths| model(name, widths)["rms"].as_f64().expect("a number");
    // A Lambert base under a coat: .27 of .35 at 60° is what one bounce misses (LAYERED's table), and coupled is exact.
    assert!(rms("coupled", "variance") < 0.02 && rms("conserving", "own") > 0.1, "{stack}");
    assert!(rms("elek", "own") > 0.3, "{stack}");
    assert!(model("coupled", "own")["table_bytes"].as_u64() > Some(100));
    assert!(model("conserving", "own")["ns"].as_f64() > Some(1.0));
    let drawn = std::fs::read_to_string(&svg).expect("the picture");
    for label in ["walk", "elek", "weidlich_wilkie", "conserving, variance", "coupled, own"] {
        assert!(drawn.contains(label), "{label}");
    }
}

/// A number that is finite and positive.
fn positive(value: &Value) -> f64 {
    value.as_f64().filter(|x| x.is_finite() && *x > 0.0).unwrap_or_else(|| panic!("{value} is no positive number"))
}

#[test]
fn the_machine_has_peaks() {
    let output = brdf(&["bench", "machine", "--quick", "--json"], "");
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!(json["processor"].as_str().is_some_and(|name| !name.is_empty()));
    let date = json["date"].as_str().expect("a date");
    assert!(date.len() == 10 && date > "2025-01-01", "{date}");
    let peaks = json["peaks"].as_array().expect("a list");
    assert_eq!(peaks[0]["level"], "baseline");
    for peak in peaks {
        for rate in ["multiply_adds_per_s", "operations_per_s", "divides_per_s", "roots_per_s"] {
            positive(&peak[rate]);
        }
    }
    let rates = json["copy"]["rates"].as_array().expect("a list");
    assert_eq!(rates.len(), 2);
    rates.iter().for_each(|rate| assert!(positive(&rate["bytes_per_s"]) > 1e6));
}

#[test]
fn paths_a_second_are_measured() {
    let output = brdf(&["bench", "offline", "--quick", "--json", "clear_coat_over_copper", "coated_ceramic"], "");
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let rows = json.as_array().expect("a list");
    assert_eq!(rows.iter().map(|row| &row["name"]).collect::<Vec<_>>(), ["clear_coat_over_copper", "coated_ceramic"]);
    for row in rows {
        positive(&row["samples_per_second"]);
        positive(&row["path_by_path_samples_per_second"]);
    }
    assert!(
        last_error(&brdf(&["bench", "offline", "copperr"], "")).contains("copperr is no built-in stack or material")
    );
    assert!(last_error(&brdf(&["bench", "offline", "--environment", "fog"], "")).contains("sky, studio, furnace"));
}

#[test]
fn terms_are_measured_and_drawn() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("bench");
    let pictures = folder.to_str().expect("a path in UTF-8");
    let output =
        brdf(&["bench", "terms", "fresnel", "whole", "--cpu-only", "--quick", "--json", "--svg", pictures], "");
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let families = json["families"].as_array().expect("a list");
    let keys: Vec<_> = families.iter().map(|family| family["key"].as_str().expect("a name")).collect();
    assert_eq!(keys, ["fresnel-metal", "fresnel-glass", "whole"]);
    for family in families {
        let picture = folder.join(format!("bench-{}.svg", family["key"].as_str().expect("a name")));
        let drawn = std::fs::read_to_string(picture).expect("the picture");
        for variant in family["variants"].as_array().expect("a list") {
            assert!(drawn.contains(variant["name"].as_str().expect("a name")), "{variant}");
            let points = variant["points"].as_array().expect("a list");
            let batches = brdf::batch::Level::available().count();
            assert_eq!(points.len(), 1 + batches + 1, "scalar, each level, all threads: {variant}");
            for point in points {
                positive(&point["ns"]);
                let [max, mean, rare] = ["max", "mean", "p999"].map(|name| positive(&point["error"][name]));
                assert!(mean <= rare && rare <= max, "{point}");
            }
        }
    }
    let largest = |family: usize, variant: &str, way: &str| {
        let mut variants = families[family]["variants"].as_array().expect("a list").iter();
        let points = &variants.find(|row| row["name"] == variant).expect("a variant of this name")["points"];
        let of_way = points.as_array().expect("a list").iter().filter(|point| point["way"] == way);
        of_way.map(|point| positive(&point["error"]["max"])).fold(0.0, f64::max)
    };
    // .6 ULP below 1 in f32; some ULP of it in a batch; what the documentation of each says.
    assert!(largest(0, "exact conductor", "scalar") <= 0.6 * 2f64.powi(-24));
    assert!(largest(0, "exact conductor", "batch") <= 16.0 * 2f64.powi(-24));
    assert!(largest(1, "exact dielectric", "batch") <= 16.0 * 2f64.powi(-24));
    assert!(largest(0, "Fit 8", "batch") <= 2.2e-5 && largest(0, "Fit 12", "batch") <= 1.1e-6);
    assert!(largest(0, "table, 128 × 8 bits", "batch") <= 2.6e-3);
    assert!((largest(0, "Lazányi, uncorrected", "scalar") - 0.041).abs() < 1e-3);
    assert!(largest(2, "exact conductor", "batch") <= 1.3e-5, "FORMULAS: α ≥ .05");
    for place in json["limit"]["places"].as_array().expect("a list") {
        positive(&place["ns"]);
        positive(&place["bound_ns"]);
    }
}

#[test]
fn unknown_families_are_refused() {
    let error = last_error(&brdf(&["bench", "terms", "fresnell"], ""));
    assert!(error.contains("fresnell") && error.contains("fresnel, distribution"), "{error}");
}

#[test]
fn shader_prints_what_a_stack_needs() {
    let special = brdf(&["shader", "copper"], "");
    assert_eq!(special.status.code(), Some(0), "{}", text(&special.stderr));
    let special = text(&special.stdout);
    assert!(special.contains("fn copper(wi: vec3f, wo: vec3f) -> vec3f") && !special.contains("refract"), "{special}");
    let general = text(&brdf(&["shader", "copper", "--general"], "").stdout);
    assert!(general.contains("layered_conserving") && general.contains("stack_layers"), "{general}");
    let scene = text(&brdf(&["shader", "copper", "gold"], "").stdout);
    assert!(scene.contains("fn scene(material: u32, wi: vec3f, wo: vec3f) -> vec3f"), "{scene}");
    let counts = brdf(&["shader", "copper", "--count", "--json"], "");
    let counts: Value = serde_json::from_slice(&counts.stdout).expect("JSON");
    let instructions = |name: &str| counts[name]["counts"]["spirv_instructions"].as_u64().expect("a count");
    assert!(4 * instructions("special") < instructions("general"), "{counts}");
    assert!(last_error(&brdf(&["shader", "copper", "--model", "walk"], "")).contains("no closed form"));
    assert!(last_error(&brdf(&["shader", "copper", "copper"], "")).contains("twice"));
}

#[test]
fn plan_says_what_was_left_out_and_what_it_costs() {
    let output = brdf(&["plan", "clear_coat_over_copper", "varnish_over_concrete", "--json"], "");
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let coated = &json["stacks"][0];
    let rules: Vec<_> = coated["applied"].as_array().expect("a list").iter().map(|one| &one["rule"]).collect();
    assert!(rules.iter().any(|rule| *rule == "clear_medium"), "{coated}");
    let terms: Vec<_> = coated["terms"].as_array().expect("a list").iter().map(|one| &one["name"]).collect();
    assert_eq!(terms, ["directions", "reflect_dielectric", "pass_dielectric", "reflect_metal"]);
    assert_eq!(coated["operations"]["scalar"]["exponentials"], 2);
    for cost in ["general", "plan", "batch"] {
        assert!(coated["measured_ns"][cost].as_f64().is_some_and(|ns| ns > 0.0), "{coated}");
    }
    for level in brdf::batch::Level::available() {
        assert!(coated["predicted_ns"][level.name()].as_f64().is_some_and(|ns| ns > 0.0), "{coated}");
    }
    let needless = json["scene"]["needless"].as_array().expect("a list");
    assert!(needless.contains(&"lambert".into()) && !needless.contains(&"oren_nayar".into()), "{needless:?}");

    let shown = text(&brdf(&["plan", "clear_coat_over_copper"], "").stdout);
    assert!(shown.contains("clear_medium") && shown.contains("absorbs nothing"), "{shown}");
}

#[test]
fn plan_takes_a_folder_and_refuses_what_has_no_closed_form() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("scene");
    std::fs::create_dir_all(&folder).expect("a writable folder");
    stack_file("scene/one.toml", CUPRITE_OVER_COPPER);
    stack_file("scene/two.toml", CUPRITE_OVER_COPPER);
    let folder = folder.to_str().expect("a path in UTF-8");
    let shown = text(&brdf(&["plan", folder], "").stdout);
    assert!(shown.contains("SCENE of 2 stacks"), "{shown}");

    let error = last_error(&brdf(&["plan", "copper", "--model", "coupled"], ""));
    assert!(error.contains("the model coupled has no closed form"), "{error}");
    assert_eq!(brdf(&["plan", "copper", "--error", "2"], "").status.code(), Some(2));
    assert_eq!(brdf(&["plan"], "").status.code(), Some(2));
}
