//! `brdf check --prove`, as a user meets it.
#![cfg(feature = "cli")]

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

/// A distribution of normals, and one that a slip in its sign makes negative beside the normal.
const SOURCE: &str = "
fn d_ggx(NoH: f32, roughness: f32) -> f32 {
    let c = saturate(NoH);
    let a = roughness * roughness;
    let d = c * c * (a - 1.0) + 1.0;
    return a / (3.14159265 * d * d);
}
fn slipped(NoH: f32) -> f32 { return NoH - 0.9; }
fn cancels(NoL: f32, NoV: f32) -> f32 { return (NoL - NoV) * (NoL - NoV) - (NoL - NoV) * (NoL - NoV); }
";

fn prove(folder: &str, arguments: &[&str]) -> Output {
    let at = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("check_prove").join(folder);
    fs::create_dir_all(&at).expect("a writable folder");
    fs::write(at.join("f.wgsl"), SOURCE).expect("a writable file");
    let all = [&["check", "--wgsl", "f.wgsl", "--prove", "--isotropic"], arguments].concat();
    Command::new(env!("CARGO_BIN_EXE_brdf")).args(all).current_dir(at).output().expect("brdf runs")
}

fn shown(output: &Output, code: i32) -> String {
    assert_eq!(output.status.code(), Some(code), "{output:?}");
    String::from_utf8(output.stdout.clone()).expect("UTF-8")
}

#[test]
fn answers_and_exit_codes() {
    let text = shown(&prove("ggx", &["--fn", "d_ggx", "--range", "roughness=0.1..1"]), 0);
    assert!(text.contains("roughness in 0.1..1, cos_i in 0.05..1") && text.contains("phi_o = 0"), "{text}");
    assert_eq!(text.matches("PROVED").count(), 2, "{text}");
    assert!(!text.contains("DISPROVED"), "{text}");

    let text = shown(&prove("slipped", &["--fn", "slipped"]), 1);
    assert!(text.contains("not negative  DISPROVED -") && text.contains("again         --at wi="), "{text}");

    let text = shown(&prove("cancels", &["--fn", "cancels", "--boxes", "500"]), 3);
    assert!(text.contains("not negative  UNDECIDED on ") && text.contains("finite        PROVED"), "{text}");
}

#[test]
fn what_cannot_be_proved_is_refused() {
    let output = Command::new(env!("CARGO_BIN_EXE_brdf")).args(["check", "glass", "--prove"]).output().expect("brdf");
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("glass: --prove is about functions"), "{output:?}");
}
