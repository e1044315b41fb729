//! Tests `stereotrace bench` and `--calibrate`.

mod common;

use std::{fs, process::Command};

use serde_json::Value;

use common::{error_of, folder::Folder, printed};

#[test]
fn a_report_is_two_files_and_says_what_it_leaves_out() {
    let folder = Folder::new("bench");
    let out = folder.file("new/report");
    let text = printed(&["bench", "--adapter", "software", "--seconds", "1", "--out", out.to_str().unwrap()]);
    assert!(text.contains("hall-finished at 1920x1080") && text.contains("wrote"), "{text}");
    let json: Value = serde_json::from_str(&fs::read_to_string(out.join("bench.json")).unwrap()).unwrap();
    let [measured, left_out] = ["scenes", "left_out"].map(|name| json[name].as_array().unwrap().len());
    assert_eq!(measured + left_out, 15);
    assert!(json["calibration"]["shadow"].as_f64().unwrap() > 0.0 && json["first_picture_ms"].as_f64().unwrap() > 0.0);
    let page = fs::read_to_string(out.join("bench.html")).unwrap();
    assert!(page.starts_with("<!doctype html>") && page.contains("Left out for lack of time"));
    // An output folder that can't be made is an error before anything is measured.
    fs::write(folder.file("taken"), "").unwrap();
    assert!(error_of(&["bench", "--out", folder.file("taken").to_str().unwrap()]).contains("taken"));
}

#[test]
fn a_calibration_is_kept_for_later_runs() {
    let folder = Folder::new("calibration");
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_stereotrace"));
        let out = folder.file("spheres.png");
        command.args(["render", "builtin:spheres", "--size", "16x12", "--out"]).arg(out).args(arguments);
        command.env("NODEVICE_SELECT", "1").env("XDG_CACHE_HOME", folder.path()).env("RUST_LOG", "stereotrace=info");
        let output = command.output().unwrap();
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{text}");
        text
    };
    assert!(!run(&[]).contains("calibration"));
    let measured = run(&["--calibrate"]);
    let line = measured.lines().find(|line| line.contains("calibration: ")).unwrap_or_else(|| panic!("{measured}"));
    let costs = line.split("calibration: ").nth(1).unwrap();
    assert!(run(&[]).contains(&format!("calibration: {costs}, as kept")));
    let file = folder.file("stereotrace/calibrations.json");
    let json: Value = serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    assert_eq!(json.as_object().unwrap().len(), 1);
    fs::write(&file, "no JSON").unwrap();
    assert!(run(&[]).contains("calibrations.json: not a list of calibrations; it is ignored"));
}
