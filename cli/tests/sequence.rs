//! Tests `stereotrace sequence` and `views`, which render many pictures in one run.

mod common;

use std::fs;
#[cfg(unix)]
use std::path::PathBuf;

use common::{error_of, folder::Folder, printed, run};

const SMALL: [&str; 5] = ["sequence", "builtin:spheres", "--size", "16x12", "--orbit"];

#[test]
fn a_sequence_that_was_interrupted_goes_on_where_it_stopped() {
    let folder = Folder::new("orbit");
    let out = folder.file("film").to_str().unwrap().to_owned();
    let command = |more: &[&'static str]| [&SMALL[..], &["5"], more].concat();
    let said = |more: &[&'static str]| printed(&[&command(more)[..], &["--out", &out]].concat());
    let fault = |more: &[&'static str]| error_of(&[&command(more)[..], &["--out", &out]].concat());
    assert!(said(&["--frames", "1..3"]).starts_with("2 pairs in "));
    let names = || {
        let entries = fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names = Vec::from_iter(entries);
        names.sort();
        names
    };
    assert_eq!(names().len(), 7, "{:?}", names());
    assert!(names().contains(&"anaglyph_0002.png".into()) && names().contains(&"sequence.json".into()));
    let second = fs::read(folder.file("film/left_0002.png")).unwrap();
    fs::remove_file(folder.file("film/right_0001.png")).unwrap();
    assert!(said(&[]).contains("; 1 already existed"), "one of the two is not whole");
    assert_eq!(names().len(), 16);
    assert!(said(&[]).starts_with("0 pairs in "));
    // Existing pictures with other settings are an error.
    let message = fault(&["--interaxial", "0.3"]);
    assert!(message.contains("left_0000.png: it was made with different files, settings"), "{message}");
    assert!(fault(&["--frames", "3..6"]).contains("the sequence has 5"));
    assert!(fault(&["--packing", "side-by-side"]).contains("was made with different"));
    assert_eq!(fs::read(folder.file("film/left_0002.png")).unwrap(), second);
    assert!(said(&["--interaxial", "0.3", "--overwrite", "--frames", "0..1"]).starts_with("1 pair in "));
    assert!(said(&["--interaxial", "0.3"]).starts_with("4 pairs in "));
    assert_ne!(fs::read(folder.file("film/right_0002.png")).unwrap(), second);
    // Existing pictures without a record of their settings are an error too.
    fs::remove_file(folder.file("film/sequence.json")).unwrap();
    assert!(fault(&[]).contains("it was made with different"));
}

/// Pictures by samples of earlier ones are the same, whichever pictures a run renders.
#[test]
fn a_film_has_the_same_bytes_in_one_run_in_parts_and_after_a_loss() {
    let folder = Folder::new("blocks");
    let film = |name: &str, frames: &str| {
        let out = folder.file(name).to_str().unwrap().to_owned();
        let command = ["sequence", "builtin:hall", "--size", "64x48", "--orbit", "400", "--method", "bracket"];
        printed(&[&command[..], &["--frames", frames, "--out", &out]].concat())
    };
    let picture = |name: &str, frame: u32| {
        let eye = |eye: &str| fs::read(folder.file(&format!("{name}/{eye}_{frame:04}.png"))).unwrap();
        [eye("left"), eye("right")]
    };
    film("whole", "0..20");
    film("part", "13..18");
    (13..18).for_each(|frame| assert!(picture("part", frame) == picture("whole", frame), "frame {frame}"));
    let before: Vec<_> = (0..20).map(|frame| picture("whole", frame)).collect();
    for lost in ["left_0005", "right_0006", "left_0018"] {
        fs::remove_file(folder.file(&format!("whole/{lost}.png"))).unwrap();
    }
    assert!(film("whole", "0..20").contains("3 pairs in "));
    (0..20).for_each(|frame| assert!(picture("whole", frame) == before[frame as usize], "frame {frame}"));
}

#[test]
fn a_sequence_of_another_material_or_texture_is_another_one() {
    let folder = Folder::new("materials");
    folder.write("m.mtl", "newmtl m\nKd 1 0 0\n");
    let scene = folder.write("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n");
    let out = folder.file("film").to_str().unwrap().to_owned();
    let command = ["sequence", scene.to_str().unwrap(), "--size", "16x12", "--orbit", "2", "--out", &out];
    assert!(printed(&command).starts_with("2 pairs in "));
    assert!(printed(&command).starts_with("0 pairs in "));
    folder.write("m.mtl", "newmtl m\nKd 1 0 0.01\n");
    let message = error_of(&command);
    assert!(message.contains("it was made with different files, settings"), "{message}");
}

#[test]
fn pictures_are_numbered_as_the_name_says_or_go_to_standard_output() {
    let folder = Folder::new("numbered");
    let pattern = folder.file("film/frame_%03d.png").to_str().unwrap().to_owned();
    printed(&[&SMALL[..], &["2", "--packing", "side-by-side", "--out", &pattern]].concat());
    let size = |name: &str| image::image_dimensions(folder.file(name)).unwrap();
    assert_eq!([size("film/frame_000.png"), size("film/frame_001.png")], [(32, 12); 2]);
    let message = error_of(&[&SMALL[..], &["2", "--out", &pattern.replace("_%03d", "")]].concat());
    assert!(message.contains("several pictures can't share one name"), "{message}");

    let output = run(&[&SMALL[..], &["3", "--out", "-", "--packing", "side-by-side"]].concat());
    assert!(output.status.success() && output.stdout.len() == 3 * 32 * 12 * 3);
    let first: Vec<u8> = image::open(folder.file("film/frame_000.png")).unwrap().into_rgb8().into_raw();
    assert_eq!(output.stdout[..first.len()], first);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("-video_size 32x12"), "{said}");
}

#[test]
fn a_path_leads_through_its_key_frames() {
    let folder = Folder::new("path");
    let camera = |x: u32, frame: &str| {
        format!(
            r#"{{ {frame} "eye": [{x}, 1, 6], "target": [{x}, 0, 0], "up": [0, 1, 0], "vfov_deg": 45,
                "screen_distance": 6, "eye_separation": 0.2 }}"#
        )
    };
    let file = |name: &str, text: String| folder.write(name, text).to_str().unwrap().to_owned();
    let keys = file("keys.json", format!("[{}, {}]", camera(0, r#""frame": 0,"#), camera(2, r#""frame": 2,"#)));
    let list = file("list.json", format!("[{}, {}, {}]", camera(0, ""), camera(1, ""), camera(2, "")));
    let frames = [keys, list].map(|path| {
        let command =
            ["sequence", "builtin:spheres", "--size", "16x12", "--light", "3,3,3", "--path", &path, "--out", "-"];
        let output = run(&command);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        output.stdout
    });
    assert_eq!(frames[0].len(), 3 * 16 * 12 * 3);
    assert!(frames[0] == frames[1], "cameras half way between two are not those in a list");
    let bad = [
        (format!("[{}, {}]", camera(0, r#""frame": 3,"#), camera(2, r#""frame": 2,"#)), "ascend"),
        (format!("[{}, {}]", camera(0, r#""frame": 3,"#), camera(2, "")), "1 of 2 cameras have a frame"),
        (format!("[{}, 7]", camera(0, "")), "camera 1: 7 is not an object"),
        (format!("[{}]", camera(0, r#""frame": 1e9,"#)), "at most 2^24"),
        ("[]".into(), "at least one camera"),
        ("{}".into(), "not a JSON list of cameras"),
        (format!("[{}]", camera(0, "").replace("45", "\"wide\"")), "camera 0: vfov_deg is \"wide\""),
    ];
    for (text, expected) in bad {
        let path = file("bad.json", text);
        let message = error_of(&["sequence", "builtin:spheres", "--size", "16x12", "--path", &path, "--out", "-"]);
        assert!(message.contains("bad.json:") && message.contains(expected), "{message}");
    }
}

#[test]
fn views_become_pictures_or_a_quilt_that_they_fill() {
    let folder = Folder::new("views");
    let out = folder.file("out").to_str().unwrap().to_owned();
    let command = |more: &[&'static str]| [&["views", "builtin:hall", "--size", "16x12"], more].concat();
    let said = |more: &[&'static str]| printed(&[&command(more)[..], &["--out", &out]].concat());
    let text = said(&["--views", "6"]);
    assert!(
        text.contains("\nviews      6 views, 1 of them traced, in ") && text.contains("\nwrote      6 files into ")
    );
    assert!(said(&["--quilt", "3x2", "--compare"]).contains("wrong surface at most 0.000%"));
    let grid = folder.file("grid");
    let place = ["--out", grid.to_str().unwrap()];
    let rows = ["--views", "2", "--rows", "2", "--ground-truth", "--screen", "inf", "--interaxial", "0.1"];
    let text = printed(&[&command(&rows)[..], &place].concat());
    assert!(text.contains("4 views, 2 of them traced, in "), "{text}");
    assert!(text.contains("\nfocus      the views are parallel\n"), "{text}");
    let size = |name: &str| image::image_dimensions(grid.join(name)).unwrap();
    assert_eq!((size("view_0003.png"), size("pair_0002_0003/im0.png")), ((16, 12), (16, 12)));
    // An upper and a lower view are turned by 90 degrees.
    assert_eq!((size("pair_0000_0002/im1.png"), size("pair_0001_0003/occlusion0.png")), ((12, 16), (12, 16)));
    let pairs = fs::read_dir(&grid).unwrap().filter(|entry| entry.as_ref().unwrap().path().is_dir());
    assert_eq!(pairs.count(), 4);
    let turned = image::open(grid.join("view_0002.png")).unwrap().rotate270().into_rgba8();
    assert_eq!(turned, image::open(grid.join("pair_0000_0002/im1.png")).unwrap().into_rgba8());
    let fault = error_of(&command(&["--views", "6", "--quilt", "4x2"]));
    assert_eq!(fault, "--views 6: a quilt of 4x2 has 8 views");
    let names = fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names = Vec::from_iter(names);
    names.sort();
    assert_eq!((&*names[0], names.len()), ("hall_qs3x2a1.3333.png", 7));
    let file = folder.file("quilt.png");
    printed(&[&command(&["--quilt", "3x2", "--out"])[..], &[file.to_str().unwrap()]].concat());
    assert_eq!(image::image_dimensions(&file).unwrap(), (48, 24));
    let mono = folder.file("mono.png");
    printed(&[&command(&["--views", "1", "--out"])[..], &[mono.to_str().unwrap()]].concat());
    assert_eq!(image::image_dimensions(&mono).unwrap(), (16, 12));
    let two = error_of(&[&command(&["--views", "2", "--out"])[..], &[mono.to_str().unwrap()]].concat());
    assert!(two.ends_with("a file holds only one view; use a folder, or a quilt"), "{two}");
}

/// A triangle at a depth of 4 before a wall at 8.
const BEFORE_A_WALL: &str = "v -9 -9 -8\nv 9 -9 -8\nv 0 9 -8\nv -1 -1 -4\nv 1 -1 -4\nv 0 1 -4\nf 1 2 3\nf 4 5 6\n";

#[test]
fn a_quilt_covers_a_cone_and_is_sharp_at_its_subject() {
    let folder = Folder::new("cone");
    let scene = folder.write("wall.obj", BEFORE_A_WALL).to_str().unwrap().to_owned();
    let out = folder.file("quilt.png").to_str().unwrap().to_owned();
    let place = ["--eye", "0,0,0", "--target", "0,0,-8", "--size", "16x12", "--json", "--out", &out];
    let said = |more: &[&str]| -> serde_json::Value {
        serde_json::from_str(&printed(&[&["views", &scene, "--quilt", "3x2"][..], &place, more].concat())).unwrap()
    };
    let camera = |said: &serde_json::Value, name: &str| said["camera"][name].as_f64().unwrap();
    let quilt = said(&[]);
    // Both surfaces have the same parallax at 2 / (1/4 + 1/8).
    assert!((camera(&quilt, "screen_distance") - 16.0 / 3.0).abs() < 1e-4, "{quilt}");
    let parallax = [0, 1].map(|end| quilt["comfort"]["parallax_px"][end].as_f64().unwrap());
    assert!(parallax[0] < 0.0 && (parallax[0] + parallax[1]).abs() < 1e-4, "{quilt}");
    let gap = |degrees: f64| 2.0 * (0.5 * degrees.to_radians()).tan() / 5.0;
    assert!((camera(&quilt, "interaxial") - gap(40.0) * 16.0 / 3.0).abs() < 1e-4, "{quilt}");
    let wide = said(&["--cone", "60", "--screen", "8"]);
    assert!((camera(&wide, "interaxial") - gap(60.0) * 8.0).abs() < 1e-4, "{wide}");
    let said = said(&["--interaxial", "0.25"]);
    assert!((camera(&said, "interaxial") - 0.25).abs() < 1e-6 && said["camera"]["cone_degrees"].is_null(), "{said}");
}

#[test]
fn a_film_of_quilts_goes_on_where_it_stopped() {
    let folder = Folder::new("quilts");
    let [out, one] = ["film", "one.png"].map(|name| folder.file(name).to_str().unwrap().to_owned());
    let small = ["builtin:spheres", "--size", "16x12", "--quilt", "2x2"];
    let said = |more: &[&str]| printed(&[&["sequence"][..], &small, &["--orbit", "4", "--out", &out], more].concat());
    assert!(said(&["--frames", "0..2"]).starts_with("2 quilts in "));
    assert!(said(&[]).contains("; 2 already existed"));
    printed(&[&["views"][..], &small, &["--out", &one]].concat());
    let picture = |name: &str| image::open(folder.file(name)).unwrap().into_rgba8();
    assert_eq!(picture("film/quilt_0000.png").dimensions(), (32, 24));
    assert_eq!(picture("film/quilt_0000.png"), picture("one.png"));
    assert_ne!(picture("film/quilt_0003.png"), picture("one.png"));
    for other in [["--cone", "9"], ["--quality", "50"]] {
        let message = error_of(&[&["sequence"][..], &small, &other, &["--orbit", "4", "--out", &out]].concat());
        assert!(message.contains("quilt_0000.png: it was made with different"), "{message}");
    }
}

/// A program in place of `ffmpeg`, which keeps its arguments and writes the file that its last argument names.
#[cfg(unix)]
const FFMPEG: &str = r#"#!/bin/sh
case "$*" in
    -version) echo "ffmpeg version VERSION Copyright" ;;
    *-encoders) echo " V....D libx264  H.264" ;;
    *) echo "$*" >> "${0%/*}/log"; for last; do :; done; FAULT; echo film > "$last" ;;
esac
"#;

/// A folder with a program in place of `ffmpeg`, and the film that `sequence` makes by it.
#[cfg(unix)]
struct FilmFolder {
    folder: Folder,
    film: PathBuf,
}

#[cfg(unix)]
impl FilmFolder {
    /// A film whose name has a number format and, where files can be named so, no Unicode.
    fn new(name: &str) -> Self {
        use std::{ffi::OsStr, os::unix::ffi::OsStrExt};

        let folder = Folder::new(name);
        let own: &[u8] = if cfg!(target_os = "linux") { b"a 100%d \xff.mp4" } else { b"a 100%d.mp4" };
        Self { film: folder.file("films_qs").join(OsStr::from_bytes(own)), folder }
    }

    /// Runs `sequence` with an `ffmpeg` of this version, which does `fault` before it writes a file. Returns the exit
    /// status, and what the command prints to standard output and error.
    fn made(&self, [version, fault]: [&str; 2], more: &[&str]) -> (i32, String, String) {
        use std::{os::unix::fs::PermissionsExt, process::Command};

        let program = self.folder.write("bin/ffmpeg", FFMPEG.replace("VERSION", version).replace("FAULT", fault));
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
        let path = format!("{}:/usr/bin:/bin", self.folder.file("bin").display());
        let mut command = Command::new(env!("CARGO_BIN_EXE_stereotrace"));
        command.args(["sequence", "--size", "16x12", "--out"]).arg(&self.film).args(more);
        let output = command.env("PATH", path).env("NODEVICE_SELECT", "1").output().unwrap();
        let [text, fault] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        (output.status.code().unwrap(), text, fault)
    }

    /// Returns the folder of the film's pictures.
    fn frames(&self) -> PathBuf {
        let mut name = self.film.file_name().unwrap().to_owned();
        name.push(".frames");
        self.film.with_file_name(name)
    }

    fn log(&self) -> Vec<String> {
        let text = fs::read_to_string(self.folder.file("bin/log")).unwrap();
        text.lines().map(str::to_owned).collect()
    }
}

/// A version of `ffmpeg`, and that it has no fault.
#[cfg(unix)]
const GOOD: [&str; 2] = ["N-1-g2", ":"];

#[cfg(unix)]
#[test]
fn films_are_made_by_ffmpeg_whole_or_not_at_all() {
    let films = FilmFolder::new("ffmpeg");
    let made =
        |ffmpeg: [&str; 2], more: &[&str]| films.made(ffmpeg, &[&["builtin:spheres", "--orbit", "3"], more].concat());
    let (status, _, old) = made(["3.4", ":"], &[]);
    assert!(status == 1 && old.contains("films need FFmpeg 4 or newer; this is 3 (3.4)"), "{old}");
    let (status, _, scene) = films.made(GOOD, &["nothing.obj"]);
    assert!(status == 1 && scene.contains("nothing.obj: no such file"), "{scene}");
    assert!(!films.frames().exists(), "no pictures were made");
    for fps in ["0.001", "1e9"] {
        let (status, _, fault) = made(GOOD, &["--fps", fps]);
        assert!(status == 2 && fault.contains("a film has 0.01 to 1000 pictures per second"), "{fault}");
    }
    let pair = ["--packing", "side-by-side"];
    let three_and_record = |what: &str| assert_eq!(fs::read_dir(films.frames()).unwrap().count(), 4, "{what}");
    let (_, _, fault) = made(["n7.1", "echo half > \"$last\"; echo disk is full >&2; exit 1"], &pair);
    assert!(fault.contains("ffmpeg failed (exit status: 1): disk is full") && !films.film.exists(), "{fault}");
    three_and_record("after a fault");
    let (status, _, fault) = made(["7", "echo half > \"$last\"; kill -INT $PPID; exit 255"], &pair);
    assert_eq!((status, &*fault), (130, "error: interrupted while FFmpeg made the film; run the same command again\n"));
    three_and_record("after a signal");
    let (status, text, _) = made(GOOD, &[&pair[..], &["--fps", "12.5"]].concat());
    assert!(status == 0 && text.starts_with("0 pairs in ") && text.contains(" has 3 pictures; its folder"), "{text}");
    assert_eq!(fs::read(&films.film).unwrap(), b"film\n");
    three_and_record("after a film");
    let log = films.log();
    let [.., encoded, wrapped] = &log[..] else { panic!("{log:?}") };
    assert!(encoded.contains("-framerate 12.5 -start_number 0 -i frame_%04d.png -frames:v 3 "), "{encoded}");
    assert!(encoded.contains("-vf crop=trunc(iw/2)*2:trunc(ih/2)*2:0:0,scale=out_color_matrix="), "{encoded}");
    assert!(encoded.contains("frame-packing=3 ") && encoded.contains("stereo_mode=left_right "), "{encoded}");
    assert!(wrapped.contains("-i film.mkv -c copy -strict unofficial "), "{wrapped}");
    let (_, text, _) = made(GOOD, &[&pair[..], &["--swap", "--overwrite", "--json"]].concat());
    let encoded = &films.log()[log.len()];
    assert!(!encoded.contains("frame-packing"), "{encoded}");
    let said: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(said["film"], films.film.to_string_lossy().as_ref());
}

#[cfg(unix)]
#[test]
fn a_film_is_replaced_by_the_whole_sequence_or_on_request() {
    let films = FilmFolder::new("replaced");
    let made =
        |more: &[&str]| films.made(GOOD, &[&["builtin:spheres", "--orbit", "3", "--quilt", "2x1"], more].concat());
    let (_, text, fault) = made(&["--frames", "0..2"]);
    assert!(text.contains(" has 2 pictures"), "{fault}");
    assert!(text.contains("players of quilts read the layout from a name that ends in _qs2x1a"), "{text}");
    assert!(films.log()[0].contains("-vf scale=trunc(iw/2)*2:trunc(ih/2)*2:out_color_matrix="), "{:?}", films.log());
    let kept = |more: &[&str]| {
        fs::write(&films.film, "mine").unwrap();
        let (status, _, fault) = made(more);
        let reason = "it exists, and is not the whole film of these settings; use another name, or --overwrite";
        assert!(status == 1 && fault.contains(reason), "{fault}");
        assert_eq!(fs::read(&films.film).unwrap(), b"mine");
    };
    kept(&["--frames", "0..2"]);
    kept(&["--cone", "20"]);
    let (_, text, fault) = made(&[]);
    assert!(text.starts_with("1 quilt in ") && text.contains(" has 3 pictures"), "{fault}");
    let (_, text, fault) = made(&["--frames", "1..2", "--overwrite"]);
    assert!(text.contains(" has 1 picture"), "{fault}");
    fs::remove_dir_all(films.frames()).unwrap();
    kept(&[]);
    assert!(!films.frames().exists());
}

#[test]
fn a_comparison_says_that_bracket_is_right_and_atomic_nearly() {
    let text = printed(&[
        "compare",
        "builtin:hall",
        "--size",
        "64x48",
        "--methods",
        "bracket,atomic",
        "--rounds",
        "1",
        "--json",
    ]);
    let said: serde_json::Value = serde_json::from_str(&text).unwrap();
    let wrong = |method: usize| said["methods"][method]["to_naive"]["wrong_surface_percent"].as_f64().unwrap();
    assert_eq!((wrong(0), wrong(1)), (0.0, 0.0));
    assert!(wrong(2) > 0.0, "{said}");
    assert_eq!(said["methods"][0]["of_naive"], 1.0);
}

#[test]
fn info_says_what_there_is_in_a_file_and_where_edges_are_smooth() {
    let folder = Folder::new("info");
    // Two triangles meet at an angle of 45 degrees.
    let obj = "v 0 -1 0\nv 0 1 0\nv -1 0 0\nv 0.7071 0 -0.7071\nf 1 2 3\nf 2 1 4\n";
    let scene = folder.write("roof.obj", obj).to_str().unwrap().to_owned();
    let read = |arguments: &[&str]| {
        let text = printed(&[&["info", &scene, "--json"], arguments].concat());
        let said: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!((&said["scene"]["triangles"], &said["scene"]["name"]), (&2.into(), &"roof".into()));
        said["scene"]["normals"].as_bool().unwrap()
    };
    let found = [&[][..], &["--crease-angle", "50"], &["--crease-angle", "40"], &["--crease-angle", "off"]].map(read);
    assert_eq!(found, [false, true, false, false]);
    assert!(printed(&["info"]).contains("\nadapter    "));
}

/// A glTF file of a square that moves by one unit to the right within a second.
fn moving(folder: &Folder) -> String {
    let corners: [[f32; 3]; 4] = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let places: [[f32; 3]; 2] = [[0.0; 3], [1.0, 0.0, 0.0]];
    let numbers = [corners.as_flattened(), &[0.0, 1.0], places.as_flattened()].concat();
    let mut bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    bytes.extend([0_u8, 1, 2, 0, 2, 3]);
    fs::write(folder.file("moving.bin"), bytes).unwrap();
    let json = r#"{
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 3 }] }],
        "animations": [{
            "name": "slide",
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
            "samplers": [{ "input": 1, "output": 2 }]
        }],
        "buffers": [{ "byteLength": 86, "uri": "moving.bin" }],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 48 }, { "buffer": 0, "byteOffset": 48, "byteLength": 8 },
            { "buffer": 0, "byteOffset": 56, "byteLength": 24 }, { "buffer": 0, "byteOffset": 80, "byteLength": 6 }
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4 },
            { "bufferView": 1, "componentType": 5126, "type": "SCALAR", "count": 2 },
            { "bufferView": 2, "componentType": 5126, "type": "VEC3", "count": 2 },
            { "bufferView": 3, "componentType": 5121, "type": "SCALAR", "count": 6 }
        ]
    }"#;
    let path = folder.file("moving.gltf");
    fs::write(&path, json).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn animations_play_with_the_flow_of_their_points() {
    let folder = Folder::new("play");
    let (file, out) = (moving(&folder), folder.file("film").to_str().unwrap().to_owned());
    let still = folder.file("still").to_str().unwrap().to_owned();
    let look =
        ["--plain", "--fov", "45", "--eye", "0,0,6", "--target", "0,0,0", "--size", "48x32", "--method", "naive"];
    let film = [&["sequence", &file, "--fps", "2", "--ground-truth", "--out", &out], &look[..]].concat();
    assert!(printed(&film).starts_with("3 pairs in "));
    assert!(printed(&film).contains("; 3 already existed"));
    // The same picture by `render`, at the time of the last one.
    printed(&[&["render", &file, "--time", "1", "--out", &still], &look[..]].concat());
    let bytes = |name: &str| fs::read(folder.file(name)).unwrap();
    assert_eq!(bytes("film/left_0002.png"), bytes("still/left.png"));
    assert_ne!(bytes("film/left_0000.png"), bytes("film/left_0002.png"));
    let has = |name: &str| folder.file(name).exists();
    assert!(has("film/truth_0001/flow_forward0.flo") && has("film/truth_0001/flow_backward1.flo"));
    assert!(!has("film/truth_0000/flow_backward0.flo") && !has("film/truth_0002/flow_forward0.flo"));
    // The square is six units away, and moves by half a unit within a picture.
    let flow = bytes("film/truth_0001/flow_forward0.flo");
    let step = |index: usize| f32::from_le_bytes(flow[12 + 4 * index..][..4].try_into().unwrap());
    let middle = 48 * 16 + 26;
    let expected = 0.5 / 6.0 * 16.0 / 22.5_f32.to_radians().tan();
    assert!((step(2 * middle) - expected).abs() < 1e-4 && step(2 * middle + 1).abs() < 1e-4, "{}", step(2 * middle));
    for (more, text) in [
        (&["render", "builtin:near", "--time", "1"][..], "--time 1: the scene has no animations"),
        (&["render", &file, "--animation", "walk"], "--animation walk: no such animation; use slide"),
        (&["render", &file, "--time", "inf"], "it must be a finite number"),
        (&["sequence", &file, "--ground-truth", "--out", "a_%d.png"], "--ground-truth: a_%d.png is not a folder"),
    ] {
        let message = error_of(more);
        assert!(message.contains(text), "{message}");
    }
}

/// A picture of an orbit whose shutter is always open shows the mean of two pictures of a finer orbit.
#[test]
fn a_shutter_averages_what_moves_and_truth_is_that_of_its_middle() {
    let folder = Folder::new("shutter");
    let film = |name: &str, more: &[&str]| {
        let out = folder.file(name).to_str().unwrap().to_owned();
        let command = ["sequence", "builtin:spheres", "--size", "64x48", "--method", "naive", "--out", &out];
        printed(&[&command[..], more].concat())
    };
    film("blurred", &["--orbit", "10", "--frames", "1..2", "--shutter", "1:2", "--ground-truth"]);
    film("sharp", &["--orbit", "10", "--frames", "1..2", "--ground-truth"]);
    film("fine", &["--orbit", "40", "--frames", "3..6"]);
    let read = |file: &str| fs::read(folder.file(file)).unwrap();
    let light = |file: &str| {
        let picture = image::load_from_memory(&read(file)).unwrap().to_rgb8();
        let linear = |value: u8| {
            let value = f64::from(value) / 255.0;
            if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        };
        Vec::from_iter(picture.into_raw().into_iter().map(linear))
    };
    for eye in ["left", "right"] {
        let [before, after] = [3, 5].map(|frame| light(&format!("fine/{eye}_{frame:04}.png")));
        let [blurred, sharp] = ["blurred", "sharp"].map(|name| light(&format!("{name}/{eye}_0001.png")));
        // Highlights brighter than white are clipped after averaging.
        let pairs = before.iter().zip(&after).zip(&blurred).filter(|((before, after), _)| before.max(**after) < 1.0);
        let off = Vec::from_iter(pairs.map(|((before, after), blurred)| ((before + after) / 2.0 - blurred).abs()));
        // A level of sRGB is at most 0.009 of linear light, and each of three pictures is rounded to half of it.
        let most = off.iter().copied().fold(0.0, f64::max);
        assert!(off.len() > blurred.len() * 9 / 10 && most < 0.01, "{eye}: {most}, {} values", off.len());
        assert_ne!(blurred, sharp);
    }
    for file in ["disp0.pfm", "occlusion1.png", "flow_forward0.flo", "normals1.pfm"] {
        let there = |name: &str| read(&format!("{name}/truth_0001/{file}"));
        assert_eq!(there("blurred"), there("sharp"), "{file}");
    }
    for (more, text) in [
        (&["--shutter", "2"][..], "it must be a share from 0 to 1"),
        (&["--shutter", "0.5:1"], "followed by : and 2 to 256 times"),
        (&["--shutter", "0.5", "--history", "64"], "--shutter and --history exclude each other"),
    ] {
        let message = error_of(&[&["sequence", "builtin:spheres", "--size", "16x12"], more].concat());
        assert!(message.contains(text), "{message}");
    }
}
