//! Tests `stereotrace dataset`, which renders pairs with ground truth in the layouts that loaders expect.

mod common;

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use common::{error_of, folder::Folder, printed, run};
use serde_json::Value;

const SMALL: [&str; 6] = ["dataset", "builtin:hall", "--size", "48x36", "--lights", "1"];

/// Returns the contents of all files below a folder, by their paths relative to it.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                found.insert(path.strip_prefix(folder).unwrap().to_owned(), fs::read(&path).unwrap());
            }
        }
    }
    found
}

#[test]
fn a_data_set_goes_on_where_it_stopped_and_each_pair_can_be_made_alone() {
    let folder = Folder::new("dataset");
    let [whole, parts] = ["whole", "parts"].map(|name| folder.file(name).to_str().unwrap().to_owned());
    let make = |more: &[&str]| printed(&[&SMALL[..], &["--pairs", "3"], more].concat());
    assert!(make(&["--out", &whole]).starts_with("3 pairs in "));
    let expected = files(folder.file("whole").as_ref());
    assert_eq!(expected.len(), 3 * 10 + 1, "{:?}", expected.keys());

    // The last pair is rendered first. Then the folder gets the state that a killed process leaves: an incomplete line,
    // and a pair without one of its files.
    assert!(make(&["--out", &parts, "--items", "2..3"]).starts_with("1 pair in "));
    assert!(make(&["--out", &parts, "--items", "0..1"]).starts_with("1 pair in "));
    let manifest = folder.file("parts/manifest.jsonl");
    let mut text = fs::read(&manifest).unwrap();
    text.extend(b"{\"item\":1,\"fil");
    fs::write(&manifest, text).unwrap();
    fs::remove_file(folder.file("parts/000000/disp1.pfm")).unwrap();
    assert!(make(&["--out", &parts]).contains("; 1 already existed"));
    assert!(make(&["--out", &parts]).starts_with("0 pairs in "));
    let mut found = files(folder.file("parts").as_ref());
    for line in String::from_utf8(found.remove(Path::new("manifest.jsonl")).unwrap()).unwrap().lines() {
        serde_json::from_str::<Value>(line).unwrap();
    }
    for (name, bytes) in &found {
        assert!(expected[name] == *bytes, "{} is another", name.display());
    }
    assert_eq!(found.len() + 1, expected.len());

    let other = [&SMALL[..], &["--pairs", "3", "--seed", "1", "--out", &parts]].concat();
    assert!(error_of(&other).contains("was made with different files, settings"));
    assert!(error_of(&[&SMALL[..], &["--pairs", "3", "--items", "1..4", "--out", &parts]].concat()).contains("has 3"));
}

#[test]
fn verify_names_what_is_missing_or_changed() {
    let folder = Folder::new("verify");
    let out = folder.file("set").to_str().unwrap().to_owned();
    printed(&[&SMALL[..], &["--pairs", "3", "--out", &out]].concat());
    let verify = || {
        let done = run(&["dataset", "verify", &out]);
        (done.status.code(), String::from_utf8(done.stdout).unwrap())
    };
    assert_eq!(verify(), (Some(0), format!("{out}: no fault in 30 files\n")));

    let changed = folder.file("set/000001/disp0.pfm");
    let mut bytes = fs::read(&changed).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&changed, bytes).unwrap();
    fs::remove_file(folder.file("set/000000/im1.png")).unwrap();
    let manifest = folder.file("set/manifest.jsonl");
    let lines: Vec<String> = fs::read_to_string(&manifest).unwrap().lines().map(String::from).collect();
    let outside = lines[2].replace("000001/im0.png", "../im0.png");
    fs::write(&manifest, [&lines[0], &lines[1], &outside].map(|line| format!("{line}\n")).concat()).unwrap();
    let faults = [
        "000000/im1.png: no such file",
        "../im0.png: it is not within the data set's folder",
        "000001/disp0.pfm: its SHA-256 is not that of its record",
        "item 2: it has not been made",
    ];
    let (status, text) = verify();
    assert_eq!(status, Some(1));
    assert_eq!(text, format!("{}\n{out}: 4 faults in 20 files\n", faults.join("\n")));
    assert!(error_of(&["dataset", "verify", folder.file(".").to_str().unwrap()]).contains("this is no data set"));
}

/// Returns the values of a PFM file with one channel and this width, top row first.
fn pfm(path: &Path, width: usize) -> Vec<f32> {
    let bytes = fs::read(path).unwrap();
    let lines: Vec<_> = bytes.splitn(4, |&byte| byte == b'\n').collect();
    let (values, _) = lines[3].as_chunks::<4>();
    let rows = values.chunks(width).rev();
    rows.flatten().map(|&bytes| f32::from_le_bytes(bytes)).collect()
}

#[test]
fn middlebury_has_parallel_cameras_and_no_label_that_its_loaders_turn_round() {
    let folder = Folder::new("middlebury");
    let make = |name: &str, more: &[&str]| {
        let out = folder.file(name).to_str().unwrap().to_owned();
        let whole =
            ["dataset", "builtin:spheres", "--size", "64x48", "--orbit", "1", "--interaxial", "0.3", "--out", &out];
        run(&[&whole[..], more].concat())
    };
    let made = make("parallel", &[]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let pair = folder.file("parallel/000000");
    let calib = fs::read_to_string(pair.join("calib.txt")).unwrap();
    let value = |name: &str| -> f32 {
        let line = calib.lines().find_map(|line| line.strip_prefix(&format!("{name}="))).unwrap();
        line.parse().unwrap()
    };
    for eye in 0..2 {
        let disparity = pfm(&pair.join(format!("disp{eye}.pfm")), 64);
        let grey = |name: &str| image::open(pair.join(format!("mask{eye}{name}.png"))).unwrap().into_luma8().into_raw();
        let [sky, nocc] = ["sky", "nocc"].map(grey);
        assert!(sky.contains(&255) && nocc.contains(&255), "the picture has sky and spheres");
        for index in 0..disparity.len() {
            assert_eq!(disparity[index] == f32::INFINITY, sky[index] == 255);
            assert_eq!(nocc[index] == 0, sky[index] == 255);
            if sky[index] == 0 {
                // By Middlebury's format, a search from 0 to ndisp - 1 finds every disparity.
                assert!(disparity[index] > 0.0 && disparity[index] <= value("ndisp") - 1.0, "{}", disparity[index]);
            }
        }
    }
    assert_eq!(value("doffs"), 0.0);

    // Cameras converge only on request, and all their disparities must then be above 0.
    let negative = make("converged", &["--screen", "1"]);
    let said = String::from_utf8(negative.stderr).unwrap();
    assert!(!negative.status.success() && said.contains("absolute value of a disparity"), "{said}");
    assert!(said.contains("behind the screen at 1") && said.contains("view has -"), "{said}");
    assert!(!folder.file("converged/000000/disp0.pfm").exists());
    let behind = make("behind", &["--screen", "1000"]);
    assert!(behind.status.success(), "{}", String::from_utf8_lossy(&behind.stderr));
    let calib = fs::read_to_string(folder.file("behind/000000/calib.txt")).unwrap();
    let doffs = calib.lines().find_map(|line| line.strip_prefix("doffs=")).unwrap().parse::<f32>().unwrap();
    assert!(doffs > 0.0, "{calib}");
    let toed = make("toed", &["--toe-in", "--screen", "5"]);
    assert!(!toed.status.success() && String::from_utf8(toed.stderr).unwrap().contains("toed in"));
}

#[test]
fn two_commands_in_one_folder_list_each_pair_once() {
    let folder = Folder::new("two");
    let out = folder.file("out").to_str().unwrap().to_owned();
    let command = [&SMALL[..], &["--pairs", "8", "--out", &out]].concat();
    let counts = std::thread::scope(|scope| {
        let runs = [(); 2].map(|()| scope.spawn(|| printed(&[&command[..], &["--json"]].concat())));
        runs.map(|run| {
            let said: Value = serde_json::from_str(&run.join().unwrap()).unwrap();
            (said["rendered"].as_u64().unwrap(), said["kept"].as_u64().unwrap())
        })
    });
    assert_eq!(counts.iter().map(|(made, _)| made).sum::<u64>(), 8, "{counts:?}");
    assert!(counts.iter().all(|(made, kept)| made + kept == 8), "{counts:?}");
    let manifest = fs::read_to_string(folder.file("out/manifest.jsonl")).unwrap();
    let lines = manifest.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let mut items = Vec::from_iter(lines.skip(1).map(|line| line["item"].as_u64()));
    items.sort();
    assert_eq!(items, Vec::from_iter((0..8).map(Some)), "{manifest}");
}

#[test]
fn kitti_and_scene_flow_have_parallel_cameras() {
    let folder = Folder::new("layouts");
    let names = [
        ("kitti", "training/image_2/000001_10.png", "training/disp_occ_0/000001_10.png"),
        ("sceneflow", "frames_finalpass/stereotrace/left/0001.png", "disparity/stereotrace/right/0001.pfm"),
    ];
    for (layout, picture, disparity) in names {
        let out = folder.file(layout).to_str().unwrap().to_owned();
        let said = printed(&[&SMALL[..], &["--pairs", "2", "--layout", layout, "--out", &out, "--json"]].concat());
        let said: Value = serde_json::from_str(&said).unwrap();
        assert_eq!((&said["rendered"], &said["layout"]), (&2.into(), &layout.into()));
        for name in [picture, disparity, "cameras/000001.json"] {
            assert!(folder.file(layout).join(name).is_file(), "{layout} has no {name}");
        }
        let camera: Value =
            serde_json::from_slice(&fs::read(folder.file(layout).join("cameras/000001.json")).unwrap()).unwrap();
        assert_eq!((camera["doffs"].as_f64(), &camera["pose"]["screen_distance"]), (Some(0.0), &"inf".into()));
        let manifest = fs::read_to_string(folder.file(layout).join("manifest.jsonl")).unwrap();
        let line: Value = serde_json::from_str(manifest.lines().nth(1).unwrap()).unwrap();
        let range: Vec<f64> = serde_json::from_value(line["disparity"].clone()).unwrap();
        assert!(range[0] > 0.0 && range[1] < 256.0, "{range:?}");
    }
    let out = folder.file("converged").to_str().unwrap().to_owned();
    let converged = run(&[&SMALL[..], &["--pairs", "1", "--layout", "kitti", "--screen", "5", "--out", &out]].concat());
    let said = String::from_utf8(converged.stderr).unwrap();
    assert!(!converged.status.success() && said.contains("its cameras must be parallel"), "{said}");
}

#[test]
fn a_pair_that_can_not_be_made_is_said_and_stops_no_other() {
    let folder = Folder::new("failed");
    let out = folder.file("out").to_str().unwrap().to_owned();
    // No place in the hall is this far from all surfaces.
    let command = [&SMALL[..], &["--pairs", "2", "--clearance", "1000", "--out", &out]].concat();
    let message = error_of(&command);
    assert!(
        message.starts_with("2 pairs of 2 failed, the first is item 0: ") && message.contains("too near a surface"),
        "{message}"
    );
    let manifest = fs::read_to_string(folder.file("out/manifest.jsonl")).unwrap();
    assert_eq!(manifest.matches("\"error\":").count(), 2);
}

#[test]
fn a_path_makes_a_data_set_too() {
    let folder = Folder::new("orbit");
    let out = folder.file("out").to_str().unwrap().to_owned();
    let command = ["dataset", "builtin:spheres", "--size", "24x18", "--orbit", "2", "--exr", "--out", &out];
    assert!(printed(&command).starts_with("2 pairs in "));
    assert!(folder.file("out/exr/000001.exr").is_file());
}
