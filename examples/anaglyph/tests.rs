//! What the example prints of the names that it is given.

#[path = "../../tests/common/folder.rs"]
#[allow(dead_code, reason = "these tests use a part of it")]
mod folder;

use clap::Parser;
use stereotrace::output::Picture;

use self::folder::Folder;
use crate::{arguments::Arguments, error_line, run};

/// What would clear the screen, and what turns the direction of writing.
const STEERING: &str = "\u{1b}[2J\u{202e}";
const ESCAPED: &str = r"\u{1b}[2J\u{202e}";

/// Runs the example, and gives what it prints last: the table, or the error's message.
fn printed(arguments: &[&str]) -> String {
    let arguments = Arguments::try_parse_from([&["anaglyph", "--size", "16x12"], arguments].concat()).unwrap();
    run(&arguments).unwrap_or_else(|error| error_line(&*error))
}

#[test]
fn out_must_be_a_folder_and_the_message_says_so() {
    let folder = Folder::new("out");
    let file = folder.write("out.png", "old").to_str().unwrap().to_owned();
    assert_eq!(printed(&["--out", &file]), format!("{file}: it is no folder; --out takes a folder to write into"));
    let below = format!("{file}/pictures");
    let message = printed(&["--out", &below]);
    assert!(message.starts_with(&format!("{below}: the folder can't be made: ")), "{message}");
    assert_eq!(std::fs::read(file).unwrap(), b"old");
}

#[test]
fn one_of_anything_is_singular() {
    let folder = Folder::new("singular");
    let scene = folder.write("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").to_str().unwrap().to_owned();
    let out = folder.file("out").to_str().unwrap().to_owned();
    let cases: [(&[&str], &str); 3] = [
        (&[&scene, "--lights", "1"], "\nscene      one: 1 triangle, 0 spheres, 1 light\n"),
        (&[&scene, "--method", "buffer-1"], "\nmethod     buffer-1: 1 slot a pixel, "),
        (&["builtin:spheres", "--frames", "1"], "1 frame in "),
    ];
    for (arguments, expected) in cases {
        let text = printed(&[arguments, &["--out", &out]].concat());
        assert!(text.contains(expected), "{text}");
    }
}

#[test]
fn views_become_pictures_or_a_quilt_that_they_fill() {
    let folder = Folder::new("views");
    let out = folder.file("out").to_str().unwrap().to_owned();
    let run = |arguments: &[&str]| printed(&[&["builtin:hall", "--out", &out, "--views", "6"], arguments].concat());
    assert!(run(&[]).starts_with("6 views of which 1 traced, in 6 files of "));
    assert!(run(&["--quilt", "3x2", "--compare"]).contains("wrong surface at most 0.000%"));
    assert_eq!(run(&["--quilt", "4x2"]), "a quilt of 4x2 is not filled by 6 views");
    let mut names: Vec<_> = std::fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!((names[0].to_str(), names.len()), (Some("hall_qs3x2a1.3333.png"), 7));
}

#[test]
fn samples_are_those_that_are_asked_for() {
    let folder = Folder::new("samples");
    let out = folder.file("out").to_str().unwrap().to_owned();
    let run = |arguments: &[&str]| printed(&[&["builtin:hall", "--out", &out], arguments].concat());
    let text = run(&["--samples", "9", "--filter", "gauss", "--method", "bracket-rays", "--compare"]);
    // 16x12 pixels of 9 rays each, and one through the centre.
    assert!(text.contains("left          1920 ") && text.contains("100.00% of the right eye identical"), "{text}");
    let text = run(&["--adaptive", "8:3", "--method", "bracket-rays", "--compare"]);
    assert!(text.contains("100.00% of the right eye identical"), "{text}");
    assert!(run(&["--adaptive", "8:6"]).contains("adaptive: 6 levels; there can be 2 to 5"));
    assert_eq!(run(&["--samples", "5"]), "invalid samples: 5 a pixel; take 1, 4, 9, 16, 25, 36, 49 or 64");
}

#[test]
fn textures_that_are_missing_or_too_large_are_errors_or_warnings_as_asked() {
    let folder = Folder::new("textures");
    folder.write("one.mtl", "newmtl red\nmap_Kd gone.png\n");
    let obj = "mtllib one.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl red\nf 1/1 2/1 3/1\n";
    let scene = folder.write("one.obj", obj).to_str().unwrap().to_owned();
    let out = folder.file("out").to_str().unwrap().to_owned();
    let run = |arguments: &[&str]| printed(&[&[&scene, "--out", &out], arguments].concat());
    for arguments in [&[][..], &["--missing-textures", "error"]] {
        let message = run(arguments);
        assert!(message.contains("one.mtl:2: ") && message.contains("gone.png"), "{message}");
    }
    assert!(run(&["--missing-textures", "warn"]).contains("\nscene      one: 1 triangle"));
    let picture = Picture::new(1024, 1024, vec![[255; 4]; 1 << 20]);
    picture.save_png(folder.file("gone.png")).unwrap();
    let message = run(&["--max-texture", "1"]);
    assert!(message.contains("1024x1024") && message.contains("--max-texture"), "{message}");
    assert!(run(&["--max-texture", "2"]).contains("\nscene      one: 1 triangle"));
}

#[test]
fn edges_are_smooth_up_to_the_crease_angle_unless_it_is_off() {
    let folder = Folder::new("crease");
    // Two triangles that meet at 45 degrees.
    let obj = "v 0 -1 0\nv 0 1 0\nv -1 0 0\nv 0.7071 0 -0.7071\nf 1 2 3\nf 2 1 4\n";
    let scene = folder.write("roof.obj", obj).to_str().unwrap().to_owned();
    let read = |arguments: &[&str]| {
        let arguments = Arguments::try_parse_from([&["anaglyph", &scene], arguments].concat()).unwrap();
        arguments.scene().unwrap().has_normals()
    };
    let found = [&[][..], &["--crease-angle", "50"], &["--crease-angle", "40"], &["--crease-angle", "off"]].map(read);
    assert_eq!(found, [false, true, false, false]);
    for wrong in ["-1", "181", "NaN", "on"] {
        let message = Arguments::try_parse_from(["anaglyph", "--crease-angle", wrong]).unwrap_err().to_string();
        assert!(message.contains("it must be 0 to 180, or off"), "{message}");
    }
    assert!(Arguments::try_parse_from(["anaglyph", "--missing-textures", "skip"]).is_err());
}

#[test]
fn an_obj_file_is_flattered_unless_it_is_to_be_plain() {
    let folder = Folder::new("studio");
    let scene = folder.write("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").to_str().unwrap().to_owned();
    let out = folder.file("out").to_str().unwrap().to_owned();
    let run = |arguments: &[&str]| printed(&[&[&scene, "--out", &out], arguments].concat());
    let primary = |text: &str| {
        let line = text.lines().find(|line| line.trim_start().starts_with("left ")).unwrap().to_owned();
        line.split_whitespace().nth(1).unwrap().parse::<u32>().unwrap()
    };
    let flattered = run(&["--method", "naive"]);
    // Four samples a pixel, and one in its centre for depths and ids.
    assert!(primary(&flattered) == 16 * 12 * 5 && flattered.contains(", 1 light\n"), "{flattered}");
    let plain = run(&["--method", "naive", "--plain"]);
    assert!(primary(&plain) == 16 * 12 && plain.contains(", 5 lights\n") && !plain.contains("trace_soft"), "{plain}");
    let asked = run(&["--method", "naive", "--samples", "1", "--lights", "2"]);
    assert!(primary(&asked) == 16 * 12 && asked.contains(", 2 lights\n") && !asked.contains("trace_soft"), "{asked}");
    let by_sky = run(&["--method", "naive", "--samples", "1", "--sky-light", "4", "--plain"]);
    assert!(primary(&by_sky) == 16 * 12 && by_sky.contains("trace_soft"), "{by_sky}");
    assert!(run(&["--sky-light", "33"]).contains("sky_rays: 33; there can be 1 to 32"));
    let both = Arguments::try_parse_from(["anaglyph", "--sky-light", "4", "--occlusion", "4"]).unwrap_err().to_string();
    assert!(both.contains("cannot be used with"), "{both}");
    assert!(run(&["--occlusion", "0"]).contains("occlusion: 0; there can be 1 to 32"));
    for (option, value, text) in [
        ("--occlusion", "16:NaN", "it must be a number above 0"),
        ("--occlusion", "x", "a number of rays like 16"),
        ("--adaptive", "x", "it must be a tolerance like 8"),
        ("--light-radius", "-1", "it must be a number above 0"),
        ("--tone", "soft", "it must be clamp or filmic"),
    ] {
        let message = Arguments::try_parse_from(["anaglyph", option, value]).unwrap_err().to_string();
        assert!(message.contains(text), "{message}");
    }
}

#[test]
fn names_of_files_and_folders_do_not_steer_the_terminal() {
    let folder = Folder::new(STEERING);
    let scene = format!("scene{STEERING}.obj");
    let scene = folder.write(&scene, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").to_str().unwrap().to_owned();
    let [out, file] = ["out", "file"].map(|name| folder.file(name).to_str().unwrap().to_owned());
    folder.write("file", "");
    let cases: [(&[&str], usize); 6] = [
        // The scene's name, and three files written.
        (&[&scene, "--out", &out], 4),
        (&["builtin:spheres", "--frames", "1", "--out", &out], 1),
        (&[&format!("{scene}.gone")], 2),
        (&[&out], 1),
        (&[&scene, "--out", &file], 1),
        (&[&scene, "--out", &out, "--cameras", &file], 1),
    ];
    for (arguments, names) in cases {
        let text = printed(arguments);
        assert!(!text.contains(['\u{1b}', '\u{202e}']), "{text}");
        assert_eq!(text.matches(ESCAPED).count(), names, "{text}");
    }
}
