//! Tests the files and messages of `stereotrace render`.

mod common;

use std::{fs, process::Command, thread, time::Duration};

use serde_json::Value;
use stereotrace::output::Picture;

use common::{ESCAPED, STEERING, error_of, folder::Folder, printed, run};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const SMALL: [&str; 3] = ["render", "--size", "16x12"];

/// Writes a scene file with one triangle. Returns its path and the path of an output folder.
fn one_triangle(folder: &Folder) -> [String; 2] {
    [folder.write("one.obj", TRIANGLE), folder.file("out")].map(|path| path.to_str().unwrap().to_owned())
}

#[test]
fn out_is_a_picture_or_a_folder() {
    let folder = Folder::new("out");
    let text = |name: &str| folder.file(name).to_str().unwrap().to_owned();
    fn render(out: &str) -> Vec<&str> {
        [&SMALL[..], &["builtin:spheres", "--out", out]].concat()
    }
    printed(&render(&text("new/pair.png")));
    assert_eq!(image::image_dimensions(folder.file("new/pair.png")).unwrap(), (16, 12));
    printed(&[&render(&text("new/pair.png"))[..], &["--packing", "cross-eyed"]].concat());
    assert_eq!(image::image_dimensions(folder.file("new/pair.png")).unwrap(), (32, 12));
    printed(&[&render(&text("all"))[..], &["--packing", "top-bottom"]].concat());
    let names =
        fs::read_dir(folder.file("all")).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names = Vec::from_iter(names);
    names.sort();
    assert_eq!(names, ["anaglyph.png", "left.png", "right.png", "top-bottom.png"]);
    let left = |name: &str| image::open(folder.file(name)).unwrap().into_rgba8();
    assert_ne!(left("all/left.png"), left("all/right.png"));
    // The name of a folder may also end like the name of a picture.
    fs::create_dir(folder.file("x.png")).unwrap();
    printed(&render(&text("x.png")));
    assert!(folder.file("x.png/left.png").is_file());

    folder.write("file", "old");
    let message = error_of(&render(&text("file")));
    assert!(
        message.ends_with("file: it is not a folder; --out takes a folder, or a picture's name like pair.png"),
        "{message}"
    );
    assert!(error_of(&render(&text("file/pictures"))).contains("pictures: the folder can't be created: "));
    assert!(error_of(&render(&text("a.gif"))).contains("a.gif: pictures can be written as .png, .jpg"));
    let one_file = error_of(&[&render(&text("a.png"))[..], &["--dump"]].concat());
    assert!(one_file.contains("--dump writes many files"), "{one_file}");
    assert_eq!(fs::read(folder.file("file")).unwrap(), b"old");
    assert!(!folder.file("a.png").exists());
}

#[test]
fn pictures_written_by_rows_are_those_of_a_whole_pair() {
    let folder = Folder::new("by_rows");
    let out = |name: &str| folder.file(name).to_str().unwrap().to_owned();
    let files = |name: &str| {
        let read = fs::read_dir(folder.file(name)).unwrap().map(|entry| entry.unwrap().path());
        let mut read = Vec::from_iter(read.map(|path| (path.file_name().unwrap().to_owned(), fs::read(path).unwrap())));
        read.sort();
        read
    };
    let command = ["render", "builtin:hall", "--size", "90x61", "--samples", "4", "--packing", "half-top-bottom"];
    printed(&[&command[..], &["--out", &out("rows")]].concat());
    printed(&[&command[..], &["--out", &out("whole"), "--compare"]].concat());
    assert_eq!(files("rows").len(), 4);
    assert!(files("rows") == files("whole"));
    printed(&[&command[..], &["--out", &out("rows.jpg")]].concat());
    printed(&[&command[..], &["--out", &out("whole.jpg"), "--compare"]].concat());
    assert!(fs::read(folder.file("rows.jpg")).unwrap() == fs::read(folder.file("whole.jpg")).unwrap());
}

#[test]
fn pictures_all_around_have_the_names_that_players_read() {
    let folder = Folder::new("around");
    let out = folder.file("all").to_str().unwrap().to_owned();
    let around = |degrees: &'static str, more: &[&'static str]| {
        let size = if degrees == "360" { "32x16" } else { "32x32" };
        let fixed = ["render", "builtin:hall", "--projection", degrees, "--size", size, "--out", &out];
        printed(&[&fixed[..], more].concat())
    };
    let text = around("360", &["--ground-truth"]);
    assert!(text.contains("0.0650 apart, in all directions"), "{text}");
    around("180", &["--unit", "10", "--pole-merge", "off"]);
    around("360", &["--packing", "side-by-side", "--pole-merge", "50:80"]);
    let size = |name: &str| image::image_dimensions(folder.file("all").join(name)).unwrap();
    assert_eq!((size("hall_360_TB.png"), size("hall_360_LR.png")), ((32, 32), (64, 16)));
    assert_eq!(size("hall_180x180_3dh.png"), (64, 32));
    assert!(folder.file("all/disp1.pfm").is_file() && !folder.file("all/calib.txt").exists());
    let camera: Value = serde_json::from_slice(&fs::read(folder.file("all/camera.json")).unwrap()).unwrap();
    assert_eq!(camera["pose"]["projection"]["span_deg"], 360.0);
    for (options, expected) in [
        (["--fov", "40"], "--fov is for planar pictures"),
        (["--interaxial-px", "4"], "--interaxial-px is for planar pictures"),
        (["--pole-merge", "80:70"], "pole merge is 80 to 70 degrees"),
        (["--pole-merge", "high"], "it must be off, or two elevations"),
        (["--size", "100x100"], "100x100: the width of a picture of 360 degrees must be twice the height"),
    ] {
        let message = error_of(&[&["render", "builtin:hall", "--projection", "360"][..], &options].concat());
        assert!(message.contains(expected), "{message}");
    }
    let wide = ["render", "builtin:hall", "--projection", "180", "--size", "64x32"];
    assert!(error_of(&wide).contains("64x32: the width of a picture of 180 degrees must be the height"));
    let apart =
        ["render", "builtin:hall", "--projection", "360", "--size", "32x16", "--interaxial", "60", "--out", &out];
    let said = String::from_utf8(run(&apart).stderr).unwrap();
    assert!(said.contains("warning: interaxial 60: a surface is ") && said.contains("nearer than the eyes"), "{said}");
    assert!(error_of(&["render", "--projection", "270"]).contains("it must be planar, 360 or 180"));
}

#[test]
fn layers_are_written_for_each_surface_along_a_line_of_sight() {
    let folder = Folder::new("layers");
    let out = folder.file("all").to_str().unwrap().to_owned();
    let command = ["render", "builtin:three-spheres-mirrors", "--size", "64x48", "--out", &out];
    printed(&[&command[..], &["--layers", "2:mirrored"]].concat());
    let written = |name: &str| folder.file("all").join(name).is_file();
    for list in ["disp0.pfm", "disp_y1.pfm", "depth_z0.pfm", "distance1.pfm", "normals0.pfm", "objects1.png"] {
        assert!(written(&format!("layer1_{list}")) && written(&format!("layer2_{list}")), "{list}");
    }
    assert!(written("layer2_materials0.png") && !written("layer3_disp0.pfm") && !written("layer0_disp0.pfm"));
    let classes = image::open(folder.file("all/layer2_class0.png")).unwrap().into_luma8();
    assert!(classes.pixels().any(|class| class.0 == [0]) && classes.pixels().any(|class| class.0 == [32]));
    for (layers, expected) in [
        ("0", "it must begin with the number of surfaces, 1 to 32"),
        ("33", "it must begin with the number of surfaces, 1 to 32"),
        ("2:bent", "unknown 'bent'; use refracted or mirrored"),
    ] {
        let message = error_of(&[&command[..], &["--layers", layers]].concat());
        assert!(message.contains(expected), "{message}");
    }
    let message = error_of(&["render", "builtin:near", "--layers", "2", "--out", "pair.png"]);
    assert!(message.contains("--layers writes many files; --out must be a folder"), "{message}");
}

#[test]
fn lenses_are_files_or_text() {
    let folder = Folder::new("lens");
    let lens = r#"{ "fx": 40, "cx": 32, "cy": 24, "radial_tangential": [-0.2, 0.03, 0.001, 0] }"#;
    let file = folder.write("lens.json", lens).to_str().unwrap().to_owned();
    let [from_file, from_text] = [file.as_str(), lens].map(|lens| {
        let out = folder.file(if lens == file { "a" } else { "b" }).to_str().unwrap().to_owned();
        printed(&["render", "builtin:hall", "--size", "64x48", "--lens", lens, "--ground-truth", "--out", &out]);
        folder.file(if lens == file { "a" } else { "b" })
    });
    let bytes = |name: &str| [&from_file, &from_text].map(|folder| fs::read(folder.join(name)).unwrap());
    for name in ["left.png", "right.png", "match0.flo", "match1.flo", "depth_z0.pfm", "occlusion1.png"] {
        let [first, second] = bytes(name);
        assert_eq!(first, second, "{name}");
    }
    assert_eq!(fs::read(from_file.join("match0.flo")).unwrap().len(), 12 + 8 * 64 * 48);
    assert!(!from_file.join("disp0.pfm").exists() && !from_file.join("calib.txt").exists());
    let camera: Value = serde_json::from_slice(&fs::read(from_file.join("camera.json")).unwrap()).unwrap();
    assert_eq!(camera["right"]["lens"]["radial_tangential"][0], -0.2);
    let out = folder.file("plain.png").to_str().unwrap().to_owned();
    printed(&["render", "builtin:hall", "--size", "64x48", "--lens", lens, "--method", "bracket", "--out", &out]);
    let strong = lens.replace("-0.2", "-0.9");
    for (options, expected) in [
        (["--lens", "none.json"], "No such file"),
        (["--lens", "{"], "invalid JSON"),
        (["--lens", r#"{ "fx": 40 }"#], "cx of a lens is missing"),
        (["--lens", &strong], "which folds at pixel"),
    ] {
        let message = error_of(&[&["render", "builtin:hall", "--size", "64x48"][..], &options].concat());
        assert!(message.contains(expected), "{message}");
    }
    let out = folder.file("set").to_str().unwrap().to_owned();
    let data = error_of(&["dataset", "builtin:hall", "--size", "64x48", "--lens", lens, "--out", &out]);
    assert!(data.contains("rectified pairs"), "{data}");
    assert!(error_of(&["render", "--lens", lens, "--fov", "40"]).contains("--fov"));
}

#[test]
fn files_of_physically_based_materials_are_shown_by_paths() {
    let folder = Folder::new("physical");
    folder.write("gold.mtl", "newmtl gold\nKd 0.9 0.7 0.3\nPr 0.3\nPm 1\n");
    let scene = folder.write("gold.obj", format!("mtllib gold.mtl\nusemtl gold\n{TRIANGLE}"));
    let [scene, out] = [scene, folder.file("gold.png")].map(|path| path.to_str().unwrap().to_owned());
    let report = |more: &[&str]| -> Value {
        let command = [&SMALL[..], &[&scene, "--out", &out, "--json"], more].concat();
        serde_json::from_str(&printed(&command)).unwrap()
    };
    let light = |more: &[&str]| {
        let light = report(more)["light"].clone();
        (light["lighting"].as_str().unwrap().to_owned(), light["denoise"].as_bool().unwrap())
    };
    assert_eq!(light(&[]), ("paths=4:3".into(), true));
    assert_eq!(light(&["--denoise=false"]), ("paths=4:3".into(), false));
    for direct in [
        &["--plain"][..],
        &["--lighting", "direct"],
        &["--adaptive", "8:2"],
        &["--ambient-occlusion", "4"],
        &["--sky-rays", "4"],
        &["--compare"],
    ] {
        assert_eq!(light(direct), ("direct".into(), false), "{direct:?}");
    }
    // OpenEXR files of such pictures have the albedo.
    let holds_albedo = |more: &[&str]| {
        let out = folder.file("gold.exr");
        printed(&[&SMALL[..], &[&scene, "--out", out.to_str().unwrap()], more].concat());
        let bytes = fs::read(out).unwrap();
        bytes.windows(8).any(|window| window == b"albedo.G")
    };
    assert!(holds_albedo(&[]) && !holds_albedo(&["--lighting", "direct"]));
    let text = printed(&[&SMALL[..], &[&scene, "--out", &out]].concat());
    assert!(text.contains("4 paths per pixel, 3 bounces, denoised"), "{text}");
    assert!(text.contains("--lighting direct is faster"), "{text}");
}

#[test]
fn the_exposure_suits_the_scene_or_is_as_given() {
    let folder = Folder::new("exposure");
    let [scene, out] = one_triangle(&folder);
    let stops = |more: &[&str]| {
        let command = [&SMALL[..], &[&scene, "--out", &out, "--json", "--sky", "0.01"], more].concat();
        let report: Value = serde_json::from_str(&printed(&command)).unwrap();
        report["light"]["exposure"].as_f64().unwrap()
    };
    let dark = ["--light", "0,0,5:0.01,0.01,0.01", "--ambient", "0.001"];
    // log2(0.12 / 0.01) is 3.6. Most of the picture is sky.
    assert!((2.5..=4.5).contains(&stops(&dark)), "{}", stops(&dark));
    assert_eq!(stops(&[&dark[..], &["--exposure", "-0.5"]].concat()), -0.5);
    assert_eq!(stops(&[&dark[..], &["--plain"]].concat()), 0.0);
    assert!(stops(&[&dark[..], &["--plain", "--exposure", "auto"]].concat()) > 2.0);
    // More light needs fewer stops.
    let brighter = [&dark[..], &["--sky-gain", "8"]].concat();
    assert!(stops(&brighter) < stops(&dark) - 1.5, "{} {}", stops(&brighter), stops(&dark));
    for (option, value, reason) in
        [("--sky-turn", "nan", "can't be turned by NaN degrees"), ("--sky-gain", "-1", "finite and")]
    {
        let message = error_of(&[&SMALL[..], &["builtin:hall", "--sky", "procedural", option, value]].concat());
        assert!(message.contains(reason), "{message}");
    }
    let message = error_of(&[&SMALL[..], &[&scene, "--exposure", "bright"]].concat());
    assert!(message.contains("it must be auto, or -64 to 64 stops"), "{message}");
}

/// Tests a red tetrahedron inside a glass one, in the automatic look of files without lights.
#[test]
fn what_stands_in_glass_is_seen() {
    let folder = Folder::new("glass");
    folder.write(
        "m.mtl",
        "newmtl red\nKd 0.9 0.1 0.1\nnewmtl pane\nKd 0 0 0\nKs 0.04 0.04 0.04\nTf 1 1 1\nNi 1.0\nillum 6\n",
    );
    let faces =
        |first: usize| [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|face| face.map(|corner| corner + first));
    let mut text = String::from("mtllib m.mtl\n");
    for (size, material, first) in [(3.0, "pane", 1), (1.0, "red", 5)] {
        for corner in [[-1.0, -1.0, -1.0], [1.0, -1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, 1.0, -1.0]] {
            text += &format!("v {} {} {}\n", size * corner[0], size * corner[1], size * corner[2]);
        }
        text += &format!("usemtl {material}\n");
        for [a, b, c] in faces(first) {
            text += &format!("f {a} {b} {c}\n");
        }
    }
    let scene = folder.write("case.obj", &text);
    let out = folder.file("out").to_str().unwrap().to_owned();
    let red = |more: &[&str]| {
        let command = ["render", scene.to_str().unwrap(), "--size", "96x72", "--samples", "4", "--out", &out];
        printed(&[&command[..], more].concat());
        let left = image::open(folder.file("out/left.png")).unwrap().into_rgb8();
        let is_red = |pixel: &[u8; 3]| pixel[0] > 100 && u32::from(pixel[0]) > 2 * u32::from(pixel[2]);
        left.pixels().filter(|pixel| is_red(&pixel.0)).count()
    };
    let (seen, hidden) = (red(&[]), red(&["--ambient-occlusion", "16"]));
    assert!(seen > 80 && hidden < seen / 4, "{seen} red pixels, by occlusion {hidden}");
}

/// An output path that can't be written is an error before anything is rendered.
#[cfg(target_os = "linux")]
#[test]
fn what_can_not_be_written_is_not_rendered() {
    // The scene does not exist either, which would be found later.
    let message = error_of(&["render", "nothing.obj", "--out", "/proc/pair.png"]);
    assert!(message.starts_with("/proc/pair.png: can't write there: "), "{message}");
}

#[test]
fn one_of_anything_is_singular() {
    let folder = Folder::new("singular");
    let [scene, out] = one_triangle(&folder);
    let cases: [(&[&str], &str); 2] = [
        (&["--lights", "1"], "\nscene      one: 1 triangle, 0 spheres, 1 light\n"),
        (&["--method", "buffer-1", "--stats"], "\nmethod     buffer-1: 1 slot per pixel, "),
    ];
    for (arguments, expected) in cases {
        let text = printed(&[&SMALL[..], &[&scene, "--out", &out], arguments].concat());
        assert!(text.contains(expected), "{text}");
    }
}

#[test]
fn samples_are_those_that_are_asked_for() {
    let folder = Folder::new("samples");
    let out = folder.file("out").to_str().unwrap().to_owned();
    let command = [&SMALL[..], &["builtin:hall", "--out", &out]].concat();
    let said = |arguments: &[&str]| printed(&[&command, arguments].concat());
    let fault = |arguments: &[&str]| error_of(&[&command, arguments].concat());
    let text = said(&["--samples", "9", "--filter", "gauss", "--method", "bracket-rays", "--compare", "--stats"]);
    // Each of 16x12 pixels has 9 samples and one ray through its centre.
    assert!(text.contains("left          1920 ") && text.contains("100.00% of the right eye identical"), "{text}");
    let text = said(&["--adaptive", "8:3", "--method", "bracket-rays", "--compare"]);
    assert!(text.contains("100.00% of the right eye identical"), "{text}");
    assert!(fault(&["--adaptive", "8:6"]).contains("6 levels; it must be 2 to 5"));
    assert!(fault(&["--samples", "5"]).contains("use 1, 4, 9, 16, 25, 36, 49 or 64"));
}

#[test]
fn textures_that_are_missing_or_too_large_are_errors_or_warnings_as_asked() {
    let folder = Folder::new("textures");
    folder.write("one.mtl", "newmtl red\nmap_Kd gone.png\n");
    let obj = "mtllib one.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl red\nf 1/1 2/1 3/1\n";
    let scene = folder.write("one.obj", obj).to_str().unwrap().to_owned();
    let out = folder.file("out").to_str().unwrap().to_owned();
    let command = [&SMALL[..], &[&scene, "--out", &out]].concat();
    for arguments in [&[][..], &["--missing-textures", "error"]] {
        let message = error_of(&[&command, arguments].concat());
        assert!(message.contains("one.mtl:2: ") && message.contains("gone.png"), "{message}");
    }
    assert!(
        printed(&[&command[..], &["--missing-textures", "warn"]].concat()).contains("\nscene      one: 1 triangle")
    );
    let picture = Picture::new(1024, 1024, vec![[255; 4]; 1 << 20]);
    picture.save_png(folder.file("gone.png")).unwrap();
    let message = error_of(&[&command[..], &["--max-texture", "1"]].concat());
    assert!(message.contains("1024x1024") && message.contains("--max-texture"), "{message}");
    assert!(printed(&[&command[..], &["--max-texture", "2"]].concat()).contains("\nscene      one: 1 triangle"));
}

#[test]
fn textures_outside_the_scenes_folder_are_read_where_the_option_allows_it() {
    let folder = Folder::new("outside");
    let picture = Picture::new(1, 1, vec![[255; 4]]);
    picture.save_png(folder.file("out.png")).unwrap();
    folder.write("in/one.mtl", "newmtl red\nmap_Kd ../out.png\n");
    let obj = "mtllib one.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl red\nf 1/1 2/1 3/1\n";
    let scene = folder.write("in/one.obj", obj).to_str().unwrap().to_owned();
    let out = folder.file("out").to_str().unwrap().to_owned();
    let command = [&SMALL[..], &[&scene, "--out", &out]].concat();
    let message = error_of(&command);
    let says = ["one.mtl:2: map_Kd '../out.png'", "outside the scene's folder ", "use --outside-files allow"];
    assert!(says.iter().all(|text| message.contains(text)), "{message}");
    assert!(printed(&[&command[..], &["--outside-files", "allow"]].concat()).contains("one: 1 triangle"));
}

/// The defaults that help prints in `[default: …]` are valid arguments.
#[test]
fn limits_take_the_defaults_that_help_prints() {
    let help = printed(&["render", "--help"]);
    let mut found = 0;
    for option in ["--max-file", "--max-sky", "--max-texture", "--max-triangles"] {
        let (_, text) = help.split_once(&format!("{option} <")).unwrap_or_else(|| panic!("no {option}"));
        let (_, default) = text.split_once("[default: ").unwrap();
        let value = &default[..default.find([',', ']']).unwrap()];
        let message = error_of(&["render", "none.obj", option, value]);
        assert!(message.starts_with("none.obj: no such file"), "{option} {value}: {message}");
        found += 1;
    }
    assert_eq!(found, 4);
    for value in ["", "-1", "nan", "inf", "8M"] {
        let message = error_of(&["render", "none.obj", &format!("--max-sky={value}")]);
        assert!(message.contains("--max-sky"), "{value}: {message}");
    }
}

#[test]
fn a_file_is_flattered_unless_it_is_to_be_plain() {
    let folder = Folder::new("studio");
    let [scene, out] = one_triangle(&folder);
    let command = [&SMALL[..], &[&scene, "--stats", "--out", &out]].concat();
    let said = |arguments: &[&str]| printed(&[&command, arguments].concat());
    let primary = |text: &str| {
        let line = text.lines().find(|line| line.trim_start().starts_with("left ")).unwrap().to_owned();
        line.split_whitespace().nth(1).unwrap().parse::<u32>().unwrap()
    };
    let flattered = said(&["--method", "naive"]);
    // Each pixel has four samples, and one ray through its centre for depths and ids.
    assert!(primary(&flattered) == 16 * 12 * 5 && flattered.contains(", 1 light\n"), "{flattered}");
    let plain = said(&["--method", "naive", "--plain"]);
    assert!(primary(&plain) == 16 * 12 && plain.contains(", 5 lights\n") && !plain.contains("trace_soft"), "{plain}");
    let asked = said(&["--method", "naive", "--samples", "1", "--lights", "2"]);
    assert!(primary(&asked) == 16 * 12 && asked.contains(", 2 lights\n") && !asked.contains("trace_soft"), "{asked}");
    let by_sky = said(&["--method", "naive", "--samples", "1", "--sky-rays", "4", "--plain"]);
    assert!(primary(&by_sky) == 16 * 12 && by_sky.contains("trace_soft"), "{by_sky}");
    let by_paths = said(&["--method", "naive", "--lighting", "paths=4:1"]);
    assert!(by_paths.contains("trace_paths"), "{by_paths}");
    assert!(error_of(&[&command[..], &["--lighting", "paths=0"]].concat()).contains("0; it must be 1 to 4096"));
    assert!(error_of(&[&command[..], &["--sky-rays", "33"]].concat()).contains("33; it must be 1 to 32"));
    assert!(error_of(&[&command[..], &["--ambient-occlusion", "0"]].concat()).contains("it must be 1 to 32"));
}

#[test]
fn lights_stand_where_they_are_placed() {
    let folder = Folder::new("lights");
    let out = folder.file("a.png").to_str().unwrap().to_owned();
    let command = [&SMALL[..], &["builtin:spheres", "--method", "naive", "--out", &out]].concat();
    let picture = |arguments: &[&str]| {
        printed(&[&command, arguments].concat());
        image::open(&out).unwrap().into_rgba8().into_raw()
    };
    let sum = |pixels: &[u8]| pixels.iter().map(|&value| u64::from(value)).sum::<u64>();
    let (left, right) = (picture(&["--light", "-4,3,4"]), picture(&["--light", "4,3,4:0.85,0.85,0.85"]));
    assert_ne!(left, right);
    let two = picture(&["--light", "-4,3,4", "--light", "4,3,4"]);
    assert!(sum(&two) > sum(&left) && sum(&two) > sum(&right));
    assert!(sum(&picture(&["--light", "-4,3,4", "--ambient", "0.5"])) > sum(&left));
    assert_ne!(picture(&["--light", "-4,3,4:1,1,1:2"]), picture(&["--light", "-4,3,4:1,1,1"]));
    let dark = picture(&["--light", "-4,3,4:0,0,0", "--ambient", "0"]);
    assert!(sum(&dark) < sum(&left));
}

#[test]
fn a_command_line_that_says_nothing_possible_ends_with_two_and_one_line() {
    let cases: [(&[&str], &str); 14] = [
        (&["--ambient-occlusion", "16:NaN"], "it must be a number above 0"),
        (&["--ambient-occlusion", "x"], "a number of rays like 16"),
        (&["--adaptive", "x"], "it must be a tolerance like 8"),
        (&["--light-radius", "-1"], "it must be a number above 0"),
        (&["--tone", "soft"], "it must be clamp or filmic"),
        (&["--sky-rays", "4", "--ambient-occlusion", "4"], "cannot be used with"),
        (&["--light", "1,2"], "it must be three numbers"),
        (&["--light", "1,2,3:1,1,1:1:1"], "followed by :R,G,B and :RADIUS"),
        (&["--light", "1,2,3:-1,1,1"], "of at least 0"),
        (&["--light", "1,2,3:1,1,1:0"], "above 0"),
        (&["--light", "1,2,inf"], "must be finite"),
        (&["--ambient", "-1"], "of at least 0"),
        (&["--crease-angle", "181"], "it must be 0 to 180, or off"),
        (&["--missing-textures", "skip"], "it must be error or warn"),
    ];
    for (arguments, expected) in cases {
        let output = run(&[&["render"], arguments].concat());
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), text.lines().count()), (Some(2), 1), "{text}");
        assert!(text.starts_with("error: ") && text.contains(expected), "{text}");
    }
    assert!(error_of(&["render", "--siez", "2x2"]).contains("a similar argument exists: '--size'"));
    assert!(error_of(&["rendre"]).contains("a similar subcommand exists: 'render'"));
    for text in ["0x10", "10x0", "10"] {
        assert!(error_of(&["render", "--size", text]).contains("it must be like 1280x720"));
    }
    assert!(error_of(&["render", "--packing", "cross-eyed", "--anaglyph", "grey"]).contains("cannot be used with"));
    let nothing = run(&[]);
    let help = String::from_utf8(nothing.stderr).unwrap();
    assert!(nothing.status.code() == Some(2) && help.contains("Usage: ") && help.contains("render"), "{help}");
    assert_eq!(run(&["render", "nothing.obj"]).status.code(), Some(1));
    assert_eq!(run(&["render", "builtin:hall", "--cameras", "nothing.json"]).status.code(), Some(1));
    assert!(printed(&["--version"]).starts_with("stereotrace "));
    assert!(printed(&["render", "--help"]).contains("--interaxial-px"));
}

/// The scene does not exist, so that a command that reads it first ends with 1.
#[test]
fn every_command_checks_its_options_before_it_reads_a_file() {
    let folder = Folder::new("usage");
    let file = folder.write("file", "").to_str().unwrap().to_owned();
    let out = folder.file("out").to_str().unwrap().to_owned();
    let below = format!("{file}/pair.png");
    let cases: [(&str, &[&str], &str); 33] = [
        ("render", &["--size", "200000x10"], "at most 131072 pixels"),
        ("render", &["--fov", "180"], "above 0 and below 180 degrees"),
        ("render", &["--screen", "0"], "between 1e-6 and 1e9, or be inf"),
        ("render", &["--interaxial", "-1"], "a number of at least 0"),
        ("render", &["--interaxial-px", "nan"], "a number of at least 0"),
        ("render", &["--screen", "inf", "--interaxial-px", "3"], "give it in world units"),
        ("render", &["--eye", "1,2,3", "--target", "1,2,3"], "they must differ"),
        ("render", &["--projection", "360", "--fov", "40"], "--fov is for planar pictures"),
        ("render", &["--projection", "360", "--size", "100x100"], "must be twice the height"),
        ("render", &["--lighting", "paths=4", "--sky-rays", "4"], "paths of light"),
        ("render", &["--lighting", "paths=4", "--ambient-occlusion", "4"], "paths of light"),
        ("render", &["--out", &below], "it is not a folder"),
        ("render", &["--out", &file], "it is not a folder"),
        ("render", &["--out", "film.mp4"], "pictures can be written as"),
        ("render", &["--out", "a.png", "--dump"], "--dump writes many files"),
        ("sequence", &["--out", "one.png"], "several pictures can't share one name"),
        ("sequence", &["--out", &out, "--orbit", "5", "--frames", "3..6"], "the sequence has 5"),
        ("sequence", &["--out", &out, "--shutter", "0.5", "--history", "9"], "exclude each other"),
        ("sequence", &["--out", &out, "--quilt", "2x2", "--packing", "side-by-side"], "--packing is for pairs"),
        ("sequence", &["--out", "-", "--ground-truth"], "is not a folder"),
        ("views", &["--out", "one.png", "--views", "2"], "a file holds only one view"),
        ("views", &["--quilt", "4x2", "--views", "6"], "--views 6: a quilt of 4x2 has 8 views"),
        ("views", &["--quilt", "4000x2000"], "it must have 1 to 1024 views"),
        ("views", &["--quilt", "9"], "it must be like 8x6"),
        ("views", &["--quilt", "2x2", "--out", "a.exr"], ".exr holds both eyes of a pair, not one picture"),
        ("views", &["--quilt", "2x2", "--projection", "360"], "--quilt and --projection exclude each other"),
        ("sequence", &["--out", "a_%d.jps", "--quilt", "2x2"], ".jps holds both eyes of a pair, not one picture"),
        ("sequence", &["--display", "looking-glass-go", "--toe-in"], "--display and --toe-in exclude each other"),
        ("views", &["--display", "looking-glass-go", "--calib", "calib.txt"], "cannot be used with"),
        ("views", &["--orbit", "8"], "use `stereotrace sequence --quilt CxR --orbit 8`"),
        ("views", &["--cone", "0"], "above 0, and at most 150 degrees"),
        ("views", &["--display", "looking-glass-go", "--size", "9x9"], "cannot be used with"),
        ("dataset", &["--out", "pair.png"], "a data set needs a folder"),
    ];
    for (command, options, expected) in cases {
        let output = run(&[&[command, "nothing.obj"], options].concat());
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(text.contains(expected), "{command} {options:?}: {text}");
        assert_eq!((output.status.code(), text.lines().count()), (Some(2), 1), "{command} {options:?}: {text}");
    }
    for (command, scene) in [("compare", "builtin:nope"), ("info", "builtin:nope"), ("dataset", "builtin:nope")] {
        assert_eq!(run(&[command, scene]).status.code(), Some(2), "{command}");
    }
    assert_eq!(run(&["bench", "--out", &file]).status.code(), Some(2));
}

#[test]
fn rays_to_a_black_sky_are_warned_of() {
    let folder = Folder::new("black_sky");
    let [scene, out] = one_triangle(&folder);
    let said = |more: &[&str]| {
        let command = [&SMALL[..], &[&scene, "--plain", "--sky-light", "4", "--out", &out], more].concat();
        String::from_utf8(run(&command).stderr).unwrap()
    };
    assert!(said(&[]).contains("warning: --sky-rays: the sky is black and gives no light; add --sky"));
    assert_eq!(said(&["--sky", "0.5"]), "");
}

#[test]
fn the_table_names_the_file_to_open_and_keeps_figures_for_stats() {
    let folder = Folder::new("table");
    let [scene, out] = one_triangle(&folder);
    let said = |more: &[&str]| printed(&[&SMALL[..], &[&scene, "--out", &out], more].concat());
    let text = said(&[]);
    assert!(text.contains("/anaglyph.png: wear glasses, red (left), cyan (right)\n"), "{text}");
    assert!(text.contains("comfortable on a display 0.6 m wide\n"), "{text}");
    assert!(!text.contains("rays ") && !text.contains("re-traced"), "{text}");
    assert!(said(&["--stats"]).contains("\nre-traced  "));
    assert!(said(&["--screen", "0.01"]).contains("\ndepth      0.0% of the width before the screen"));
    let text = said(&["--packing", "cross-eyed"]);
    assert!(text.contains("/cross-eyed.png: view it with crossed eyes\n"), "{text}");
}

#[test]
fn quiet_says_nothing_and_json_all() {
    let folder = Folder::new("json");
    let out = folder.file("a.png").to_str().unwrap().to_owned();
    let command =
        [&SMALL[..], &["builtin:hall", "--method", "bracket", "--compare", "--count", "--out", &out]].concat();
    assert_eq!(printed(&[&command[..], &["--quiet"]].concat()), "");
    let said: Value = serde_json::from_str(&printed(&[&command[..], &["--json"]].concat())).unwrap();
    assert_eq!(said["camera"]["size"], serde_json::json!([16, 12]));
    assert_eq!(said["files"], serde_json::json!([out]));
    assert_eq!(said["rays"]["left"]["primary"], 16 * 12);
    assert_eq!(said["to_naive"]["wrong_surface_percent"], 0.0);
    assert!(said["second_eye"].as_f64().unwrap() > 0.0);
}

/// Built-in cameras define the interaxial in pixels, by the parallax at infinity. Parallel cameras have no parallax at
/// infinity, so they keep the interaxial in world units.
#[test]
fn parallel_cameras_keep_the_interaxial_that_the_camera_had() {
    let folder = Folder::new("parallel");
    let out = folder.file("a.png").to_str().unwrap().to_owned();
    let command = [&SMALL[..], &["builtin:hall", "--json", "--out", &out]].concat();
    let interaxial = |more: &[&str]| {
        let said: Value = serde_json::from_str(&printed(&[&command[..], more].concat())).unwrap();
        said["camera"]["interaxial"].as_f64().unwrap()
    };
    assert_eq!(interaxial(&["--screen", "inf"]), interaxial(&[]));
    assert!((interaxial(&["--screen", "inf", "--interaxial", "0.125"]) - 0.125).abs() < 1e-6);
    let message = error_of(&[&command[..], &["--screen", "inf", "--interaxial-px", "3"]].concat());
    assert!(message.contains("give it in world units"), "{message}");
    // The light of a file is placed relative to the point that the camera looks at, not relative to the screen.
    let scene = folder.write("triangle.obj", TRIANGLE).to_str().unwrap().to_owned();
    printed(&[&SMALL[..], &[&scene, "--screen", "inf", "--out", &out]].concat());
}

#[test]
fn names_of_files_and_folders_do_not_steer_the_terminal() {
    let folder = Folder::new(STEERING);
    let scene = folder.write(&format!("scene{STEERING}.obj"), TRIANGLE).to_str().unwrap().to_owned();
    let [out, file] = ["out", "file"].map(|name| folder.file(name).to_str().unwrap().to_owned());
    folder.write("file", "");
    let gone = format!("{scene}.gone");
    // The output contains the scene's name, the file to open, and the names of three written files.
    let said = printed(&[&SMALL[..], &[&scene, "--out", &out]].concat());
    let mut texts = vec![(said, 5)];
    let cases: [(&[&str], usize); 4] = [
        (&[&gone], 2),
        (&[&out], 1),
        (&[&scene, "--out", &file], 1),
        (&[&scene, "--out", &out, "--cameras", &file], 1),
    ];
    texts.extend(cases.map(|(arguments, names)| (error_of(&[&SMALL[..], arguments].concat()), names)));
    for (text, names) in texts {
        assert!(!text.contains(['\u{1b}', '\u{202e}']), "{text}");
        assert_eq!(text.matches(ESCAPED).count(), names, "{text}");
    }
}

#[test]
fn what_is_watched_is_rendered_again_when_it_changes() {
    let folder = Folder::new("watch");
    let [scene, _] = one_triangle(&folder);
    let out = folder.file("a.png");
    let mut watcher = Command::new(env!("CARGO_BIN_EXE_stereotrace"))
        .args([&SMALL[..], &[&scene, "--watch", "--quiet", "--out", out.to_str().unwrap()]].concat())
        .spawn()
        .unwrap();
    let wait_for = |what: &dyn Fn() -> bool| {
        // Two minutes, since the first picture may wait for other tests' kernels.
        (0..2400).any(|_| {
            thread::sleep(Duration::from_millis(50));
            what()
        })
    };
    let first = wait_for(&|| out.exists());
    let before = fs::read(&out);
    fs::write(&scene, "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 3 3 3\nf 1 2 4\n").unwrap();
    let again = wait_for(&|| fs::read(&out).ok() != before.as_ref().ok().cloned());
    watcher.kill().unwrap();
    watcher.wait().unwrap();
    assert!(first && again, "rendered at first: {first}, and again: {again}");
    let nothing = error_of(&["render", "builtin:hall", "--watch", "--out", out.to_str().unwrap()]);
    assert!(nothing.starts_with("--watch: no input file is read"), "{nothing}");
}
