//! `brdf check` and `brdf merge`, as a user and a farm meet them.
#![cfg(feature = "cli")]

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A folder of this test run, empty.
fn folder(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("check_cli").join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).expect("a writable folder");
    path
}

fn brdf(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_brdf")).args(arguments).current_dir(folder).output().expect("brdf runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("no signal")
}

/// The line that bad input ends with; drivers may have written before it.
fn complaint(output: &Output) -> String {
    assert_eq!(code(output), 2, "{output:?}");
    text(&output.stderr).lines().rfind(|line| !line.is_empty()).unwrap_or_default().to_owned()
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {output:?}"))
}

/// A white Lambert surface: plausible, and quickly judged.
const WHITE: &str = "name = \"white\"\n[[layer]]\ninterface = { diffuse = { albedo = 1.0 } }\n";

/// Cuprite over copper under the model as printed, which gains energy.
const GAINS: &str = "name = \"Cu2O over Cu\"\nmodel = \"elek\"\n\
    [[layer]]\ninterface = { conductor = { n = [2.83, 3.10, 3.06], k = [0.083, 0.19, 0.6] }, alpha = 0.1 }\n\
    [[layer]]\ninterface = { conductor = { n = [0.213, 1.04, 1.17], k = [4.05, 2.59, 2.36] }, alpha = 0.3 }\n";

/// Lambert with a slider; above 1 it reflects more than it receives.
const SLIDER: &str = "analytic\n::begin parameters\nfloat albedo 0.1 1.5 0.5\n::end parameters\n::begin shader\n\
    vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y) { return vec3(albedo / 3.14159265358979); }\n::end shader\n";

/// What every call here shares: no adapter, and no more than a tenth of the default budget.
const FAST: [&str; 3] = ["--no-twins", "--budget", "100000"];

fn check(folder: &Path, arguments: &[&str]) -> Output {
    brdf(folder, &[&["check"], &FAST[..], arguments].concat())
}

/// A folder with a plausible stack, one that gains energy, a slider and a file that is no BRDF.
fn library(name: &str) -> PathBuf {
    let at = folder(name);
    fs::create_dir(at.join("materials")).expect("a folder");
    for (file, content) in
        [("white.toml", WHITE), ("gains.toml", GAINS), ("slider.brdf", SLIDER), ("README.txt", "read me\n")]
    {
        fs::write(at.join("materials").join(file), content).expect("a file");
    }
    at
}

#[test]
fn exit_codes_tell_plausible_from_violating_from_unread() {
    let at = library("codes");
    assert_eq!(code(&check(&at, &["materials/white.toml"])), 0);
    assert_eq!(code(&check(&at, &["materials/gains.toml"])), 1);
    assert_eq!(code(&check(&at, &["materials"])), 1);
    fs::remove_file(at.join("materials/gains.toml")).expect("removed");
    let slider = check(&at, &["materials/slider.brdf", "--param", "albedo=1"]);
    assert_eq!(code(&slider), 0, "{slider:?}");
    fs::write(at.join("materials/torn.brdf"), "analytic\n::begin shader\n").expect("a file");
    let torn = check(&at, &["materials", "--param", "albedo=1", "--json"]);
    assert_eq!(code(&torn), 2, "{torn:?}");
    // A parameter that only some have refuses the others.
    let report = json(&torn);
    let verdicts: Vec<(&str, &str)> = report["reports"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|r| (r["source"].as_str().expect("a path"), r["verdict"].as_str().expect("a verdict")))
        .collect();
    assert_eq!(
        verdicts,
        [
            ("materials/README.txt", "SKIPPED"),
            ("materials/slider.brdf", "PASS"),
            ("materials/torn.brdf", "REFUSED"),
            ("materials/white.toml", "REFUSED")
        ]
    );
}

#[test]
fn bad_input_is_named_in_one_line() {
    let at = library("bad");
    fs::write(at.join("words.json"), "not JSON\n").expect("a file");
    fs::write(at.join("empty.brdf"), "").expect("a file");
    for (arguments, says) in [
        (&["no/such/file"][..], "no/such/file"),
        (&["words.json"], "words.json"),
        (&["empty.brdf"], "empty"),
        (&["materials/white.toml", "--baseline", "words.json"], "no JSON report"),
        (&["materials/white.toml", "--baseline", "missing.json"], "missing.json"),
        (&["materials/white.toml", "--html", "no/folder/x.html"], "no/folder/x.html"),
        (&["materials/white.toml", "--param", "albedo=1"], "sets a parameter"),
        (&["materials/slider.brdf", "--param", "roughness=1"], "there are albedo"),
        (&["materials/slider.brdf", "--param", "albedo=9"], "0.1..1.5"),
        (&["materials", "--at", "theta=0,view"], "one subject"),
    ] {
        let line = complaint(&check(&at, arguments));
        assert!(line.starts_with("brdf: ") && line.contains(says), "{arguments:?}: {line}");
    }
    for (arguments, says) in [
        (&["--profile", "lenient"][..], "strict"),
        (&["--shard", "0/0"], "K/N"),
        (&["--shard", "3/2"], "K/N"),
        (&["--at", "up"], "want theta="),
        (&["--seed", "x"], "--seed"),
        (&["--at", "theta=0,view", "--json"], "cannot be used with"),
    ] {
        let output = check(&at, &[&["materials/white.toml"], arguments].concat());
        assert_eq!(code(&output), 2, "{output:?}");
        assert!(text(&output.stderr).contains(says), "{arguments:?}: {output:?}");
    }
}

#[test]
fn two_shards_merge_into_the_whole() {
    let at = library("shards");
    let whole = check(&at, &["materials", "--json"]);
    fs::write(at.join("whole.json"), &whole.stdout).expect("a file");
    let mut codes = Vec::new();
    for part in ["1", "2"] {
        let output = check(&at, &["materials", "--json", "--shard", &format!("{part}/2")]);
        codes.push(code(&output));
        fs::write(at.join(format!("part-{part}.json")), &output.stdout).expect("a file");
    }
    let merged = brdf(&at, &["merge", "part-2.json", "part-1.json", "--json", "--junit", "m.xml", "--html", "m.html"]);
    assert_eq!(text(&merged.stdout), text(&whole.stdout));
    assert_eq!(code(&merged), code(&whole));
    assert_eq!(codes.iter().filter(|code| **code == 1).count(), 2, "gains.toml and slider.brdf are in one each");
    // The same table too, and the same JUnit.
    let [from_parts, from_whole] =
        [&["merge", "part-1.json", "part-2.json"][..], &["merge", "whole.json"]].map(|a| text(&brdf(&at, a).stdout));
    assert_eq!(from_parts, from_whole);
    assert!(from_parts.contains("ENERGY") && from_parts.contains("3 judged, 2 violate"), "{from_parts}");

    let lost = complaint(&brdf(&at, &["merge", "part-1.json"]));
    assert!(lost.contains("missing"), "{lost}");
    let twice = complaint(&brdf(&at, &["merge", "part-1.json", "part-1.json"]));
    assert!(twice.contains("two of the reports") || twice.contains("missing"), "{twice}");

    let xml = fs::read_to_string(at.join("m.xml")).expect("JUnit");
    let document = roxmltree::Document::parse(&xml).unwrap_or_else(|error| panic!("{error}\n{xml}"));
    let suites = document.descendants().filter(|node| node.has_tag_name("testsuite")).count();
    let failures = document.descendants().filter(|node| node.has_tag_name("failure")).count();
    assert!(suites == 4 && failures >= 2, "{xml}");
    let html = fs::read_to_string(at.join("m.html")).expect("HTML");
    assert!(html.contains("<svg") && html.contains("Cu2O over Cu"));
}

#[test]
fn the_commands_of_the_document_work() {
    let at = library("document");
    let document = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/report.md")).expect("docs");
    let (_, rest) = document.split_once("runs this block -->").expect("the marked block");
    let block = rest.split("```").nth(1).and_then(|block| block.strip_prefix("sh\n")).expect("a block of sh");
    let program = Path::new(env!("CARGO_BIN_EXE_brdf")).parent().expect("a folder");
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap_or_default());
    // `set -e` stops at the first command that fails and is not meant to.
    let script =
        format!("set -e\n{}", block.replace("check materials/", "check materials/ --no-twins --budget 100000"));
    let output = Command::new("sh").args(["-c", &script]).current_dir(&at).env("PATH", path).output().expect("sh");
    assert_eq!(code(&output), 1, "{output:?}");
    let html = fs::read_to_string(at.join("report.html")).expect("HTML");
    // Figures travelled through the JSON: five pictures of a stack with single precision, six of a family.
    assert!(html.matches("<svg").count() >= 15, "{}", html.matches("<svg").count());
    assert!(at.join("report.xml").exists());
}

#[test]
fn a_baseline_accepts_what_it_knows_and_nothing_else() {
    let at = library("baseline");
    let before = check(&at, &["materials", "--json"]);
    assert_eq!(code(&before), 1);
    fs::write(at.join("known.json"), &before.stdout).expect("a file");

    let same = check(&at, &["materials", "--baseline", "known.json"]);
    let shown = text(&same.stdout);
    assert_eq!(code(&same), 0, "{shown}");
    assert!(shown.contains("accepted by the baseline:") && shown.contains("gains.toml: ENERGY FAIL"), "{shown}");
    // Another seed finds the same within its errors.
    let seed = check(&at, &["materials", "--baseline", "known.json", "--seed", "2"]);
    assert_eq!(code(&seed), 0, "{}", text(&seed.stdout));

    // Worse: the slider goes further. New: another file.
    let farther = SLIDER.replace("1.5", "1.9");
    fs::write(at.join("materials/slider.brdf"), farther).expect("a file");
    let worse = check(&at, &["materials", "--baseline", "known.json"]);
    assert_eq!(code(&worse), 1);
    assert!(text(&worse.stdout).contains("worse than the baseline:"), "{}", text(&worse.stdout));
    fs::write(at.join("materials/slider.brdf"), SLIDER.replace("1.5", "1.0")).expect("a file");
    let mended = check(&at, &["materials", "--baseline", "known.json"]);
    assert_eq!(code(&mended), 0);
    assert!(text(&mended.stdout).contains("no longer found"), "{}", text(&mended.stdout));
    fs::write(at.join("materials/new.toml"), GAINS).expect("a file");
    assert_eq!(code(&check(&at, &["materials", "--baseline", "known.json"])), 1);
}

#[test]
fn the_fields_of_the_schema_stay() {
    let at = library("schema");
    let report = json(&check(&at, &["materials/gains.toml", "--json", "--figures"]));
    let keys = |value: &Value| value.as_object().expect("an object").keys().cloned().collect::<Vec<_>>().join(" ");
    assert_eq!(report["version"], 2);
    assert_eq!(keys(&report), "exit_code reports schema shard tool total twins verdict version");
    let subject = &report["reports"][0];
    assert_eq!(keys(subject), "albedos channels coverage figures findings index kind notes source subject verdict");
    let finding = &subject["findings"][0];
    assert_eq!(
        keys(finding),
        "accepted again binding cause channel check error limit line note parameters place precision value values verdict"
    );
    assert_eq!(keys(&finding["place"]), "fixed phi theta");
    assert_eq!(
        keys(&subject["albedos"][0]),
        "agrees cross_check error evaluations fixed non_finite phi standard_error theta value"
    );
    // Every field is in the document.
    let document = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/report.md")).expect("docs");
    for object in [&report, subject, finding, &subject["albedos"][0], &subject["coverage"]] {
        for key in object.as_object().expect("an object").keys() {
            assert!(document.contains(&format!("`{key}`")) || document.contains(&format!("\"{key}\"")), "{key}");
        }
    }
    let again = fs::write(at.join("r.json"), serde_json::to_vec(&report).expect("JSON"));
    assert!(again.is_ok() && code(&brdf(&at, &["merge", "r.json"])) == 1);
}

#[test]
fn the_command_of_a_finding_shows_it_again() {
    let at = library("again");
    let report = json(&check(&at, &["materials", "--json"]));
    let mut seen = 0;
    for subject in report["reports"].as_array().expect("a list") {
        let findings = subject["findings"].as_array().map(Vec::as_slice).unwrap_or_default();
        for finding in findings.iter().filter(|f| f["check"] == "ENERGY" && f["verdict"] == "FAIL") {
            let again = finding["again"].as_str().expect("a command").strip_prefix("brdf ").expect("brdf");
            let output = brdf(&at, &again.split(' ').collect::<Vec<_>>());
            let shown = text(&output.stdout);
            assert_eq!(code(&output), 1, "{again}: {output:?}");
            let albedos = shown.lines().filter_map(|line| line.split_once(" ± "));
            let largest = albedos
                .filter_map(|(value, _)| value.split_whitespace().last()?.parse::<f64>().ok())
                .fold(0.0, f64::max);
            let [value, error] = ["value", "error"].map(|key| finding[key].as_f64().expect("a number"));
            assert!((largest - value).abs() <= 2.0 * error + 1e-4, "{again}: {value} ± {error}\n{shown}");
            seen += 1;
        }
    }
    assert!(seen >= 3, "{seen}");
}

/// The exit code of a command whose reader is gone before it says anything.
fn unheard(folder: &Path, arguments: &[&str]) -> i32 {
    let mut brdf = Command::new(env!("CARGO_BIN_EXE_brdf"))
        .args(arguments)
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("brdf runs");
    drop((brdf.stdout.take(), brdf.stderr.take()));
    brdf.wait().expect("it ends").code().expect("no signal")
}

/// `brdf check … | head -1` in somebody's CI.
#[test]
fn a_reader_that_leaves_does_not_hide_a_violation() {
    let at = library("unheard");
    let judge = |arguments: &[&str]| unheard(&at, &[&["check"], &FAST[..], arguments].concat());
    assert_eq!(judge(&["materials/gains.toml"]), 1);
    assert_eq!(judge(&["materials/gains.toml", "--json"]), 1);
    assert_eq!(judge(&["materials/gains.toml", "--at", "theta=60,phi=0,view"]), 1);
    assert_eq!(judge(&["materials/white.toml"]), 0);
    // What is complained of on the standard error has no reader either.
    assert_eq!(judge(&["absent.toml"]), 2);
    assert_eq!(judge(&["materials", "--param", "albedo=9"]), 2);
    fs::write(at.join("r.json"), check(&at, &["materials/gains.toml", "--json"]).stdout).expect("a file");
    assert_eq!(unheard(&at, &["merge", "r.json"]), 1);
}

/// `--at` judges as the check did: with its tolerance, and what its profile lets bind; and the command that is printed says so.
#[test]
fn a_place_is_judged_by_the_same_rules() {
    let at = folder("rules");
    // An albedo of 1.2, and 0.2 (1 + NoV): the two orders differ.
    fs::write(
        at.join("a.wgsl"),
        "fn bright(L: vec3f, V: vec3f) -> f32 { return 1.2 / 3.14159265; }\n\
         fn lopsided(L: vec3f, V: vec3f, N: vec3f) -> f32 { return 0.2 * (1.0 + dot(N, V)); }\n",
    )
    .expect("a file");
    let judge = |function: &str, rest: &[&str]| check(&at, &[&["--wgsl", "a.wgsl", "--fn", function], rest].concat());
    let place = ["--at", "theta=60,phi=0,view"];
    assert_eq!(code(&judge("bright", &place)), 1);
    assert_eq!(code(&judge("bright", &[&place[..], &["--tolerance", "0.5"]].concat())), 0);
    let pair = ["--at", "wi=0.6:0:0.8,wo=0:0:1"];
    for (profile, expected) in [("strict", 1), ("realtime", 0), ("measured", 0), ("term", 0)] {
        let output = judge("lopsided", &[&pair[..], &["--profile", profile]].concat());
        assert_eq!(code(&output), expected, "{profile}: {output:?}");
        assert_eq!(text(&output.stdout).contains("only advises"), expected == 0, "{output:?}");
    }
    // What is wrong at no one pair is shown by the whole check.
    let limit = "fn aniso(L: vec3f, V: vec3f, N: vec3f, alpha_x: f32, alpha_y: f32) -> f32 {\n\
        return 0.1 * (1.0 + alpha_x * L.x * V.x + 0.5 * alpha_y * L.y * V.y);\n}\n";
    fs::write(at.join("b.wgsl"), limit).expect("a file");
    let report = json(&check(&at, &["--wgsl", "b.wgsl", "--fn", "aniso", "--json"]));
    let findings = report["reports"][0]["findings"].as_array().expect("a list");
    let limit = findings.iter().find(|finding| finding["check"] == "LIMIT").expect("two widths");
    let again = limit["again"].as_str().expect("a command");
    assert!(limit["verdict"] == "FAIL" && !again.contains("--at"), "{limit}");
    let again = |function: &str, rest: &[&str]| {
        let report = json(&judge(function, &[rest, &["--json"]].concat()));
        let findings = report["reports"][0]["findings"].as_array().expect("a list").clone();
        let commands = findings.iter().filter_map(|finding| finding["again"].as_str().map(str::to_owned));
        commands.filter(|command| command.contains("--at")).collect::<Vec<_>>()
    };
    let commands = again("lopsided", &["--profile", "realtime", "--tolerance", "0.25"]);
    assert!(commands.len() >= 2, "{commands:?}");
    for command in commands {
        assert!(command.contains("--profile realtime --tolerance 0.25"), "{command}");
    }
}

/// Nothing is judged for a report that cannot be kept: with this budget it would take hours.
#[test]
fn reports_are_tried_before_anything_is_judged() {
    let at = library("reports");
    let long = ["--budget", "1000000000"];
    let line = complaint(&brdf(
        &at,
        &[
            &["check", "materials/slider.brdf", "--no-twins", "--junit", "good.xml", "--html", "no/page.html"],
            &long[..],
        ]
        .concat(),
    ));
    assert!(line.contains("no/page.html"), "{line}");
    let line = complaint(&brdf(
        &at,
        &[&["check", "materials/slider.brdf", "--no-twins", "--junit", "materials"], &long[..]].concat(),
    ));
    assert!(line.contains("materials"), "{line}");
    let twice = ["check", "materials/slider.brdf", "--no-twins", "--junit", "one", "--html", "one"];
    let line = complaint(&brdf(&at, &[&twice[..], &long[..]].concat()));
    assert!(line.contains("name one file"), "{line}");
    let left = fs::read_dir(&at).expect("a folder").count();
    assert_eq!(left, 1, "neither report is there, nor anything of them");
    let judged = check(&at, &["materials/white.toml", "--junit", "good.xml", "--html", "page.html"]);
    assert_eq!((code(&judged), fs::read_dir(&at).expect("a folder").count()), (0, 3), "{judged:?}");
}

#[test]
fn a_pipe_sees_no_colours() {
    let at = library("colour");
    let output = check(&at, &["materials/gains.toml"]);
    let shown = text(&output.stdout);
    assert!(!shown.contains('\x1b') && shown.contains("ENERGY") && shown.contains("again:"), "{shown}");
}

#[test]
fn every_plot_is_drawn_alone() {
    let at = library("plots");
    for plot in ["albedo", "lobes", "reciprocity", "validity", "precision", "sweep"] {
        let file = format!("{plot}.svg");
        let output =
            brdf(&at, &["plot", plot, "materials/slider.brdf", "--no-twins", "--param", "albedo=0.9", "-o", &file]);
        if plot == "sweep" {
            // What is set is not swept.
            assert!(complaint(&output).contains("no parameter"), "{output:?}");
            continue;
        }
        assert_eq!(code(&output), 0, "{plot}: {output:?}");
        let svg = fs::read_to_string(at.join(file)).expect("SVG");
        let document = roxmltree::Document::parse(&svg).unwrap_or_else(|error| panic!("{plot}: {error}"));
        assert!(document.root_element().has_tag_name(("http://www.w3.org/2000/svg", "svg")));
    }
    assert_eq!(code(&brdf(&at, &["plot", "sweep", "materials/slider.brdf", "--no-twins", "-o", "s.svg"])), 0);
    assert!(complaint(&brdf(&at, &["plot", "albedo", "materials"])).contains("one subject"));
}
