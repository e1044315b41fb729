//! Tests the messages about files that are read.

use stereotrace::{Origin, Scene, SceneOptions, glam::Vec3};

use super::{Folder, SIX, common};

#[test]
fn of_like_warnings_five_are_printed_and_the_rest_counted() {
    let folder = Folder::new("like");
    folder.write("m.mtl", (0..9).map(|index| format!("newmtl m{index}\nKd red\n")).collect::<String>());
    let faces: String = (0..12).map(|index| format!("usemtl gone{index}\nf 1 2 3\n")).collect();
    let libraries: String = (0..8).map(|index| format!("mtllib gone{index}.mtl\n")).collect();
    folder.scene(format!("mtllib m.mtl\n{libraries}{SIX}{faces}"));
    let warnings = folder.warnings();
    let starting = |start: &str| warnings.iter().filter(|warning| warning.starts_with(start)).count();
    let counts = [starting("m.mtl:"), starting("scene.obj:"), starting("gone")];
    assert_eq!(counts, [6, 7, 5], "{warnings:?}");
    for counted in [
        "scene.obj: MTL files that can't be read: 3 more",
        "m.mtl: invalid diffuse colours (Kd): 4 more",
        "scene.obj: materials missing from the MTL files: 7 more",
    ] {
        assert_eq!(starting(counted), 1, "{counted}: {warnings:?}");
    }
}

#[test]
fn names_in_messages_steer_no_terminal_and_are_cut() {
    let folder = Folder::new("escape");
    let name = format!("red\u{1b}[31m{}", "n".repeat(1000));
    folder.scene(format!("{SIX}usemtl {name}\nf 1 2 3\n"));
    let warnings = folder.warnings();
    assert!(warnings[0].contains(r"'red\u{1b}[31mnnn") && warnings[0].len() < 200, "{warnings:?}");
    let error = folder.read(format!("{SIX}f 1 2 \u{1b}c{}\n", "9".repeat(1000))).unwrap_err().to_string();
    let reason = error.rsplit("scene.obj").next().unwrap();
    assert!(reason.contains(r"\u{1b}c999") && reason.len() < 300 && !reason.contains('\u{1b}'), "{reason}");
}

#[test]
fn what_is_left_out_is_said_once_a_file() {
    let folder = Folder::new("left_out");
    let material = "Ka 1 1 1\nKs 0.5 0.5 0.5\nNs 10\nNi 1.5\nKe 1 0 0\nmap_Kd a.png\nbump b.png\nillum 2\nd 0.5\nfoo\n";
    folder.write("m.mtl", format!("newmtl a\nKd 1 1 1\n{material}newmtl b\nKd 0.5 0 0\nmap_d c.png\n{material}"));
    folder
        .scene(format!("mtllib m.mtl\n{SIX}vt 0 0\ns 1\nl 1 2\nl 2 3\np 1\nf 1 2\nf 1 2 3\nf 1 1 2\ncurv 1 2\nbar\n"));
    let mut warnings = folder.warnings();
    warnings.sort();
    let expected = [
        "m.mtl: ignored: 2 ambient colours (Ka) from line 3 on; 2 other textures \
         (heights, displacement, reflections and similar) from line 9 on; \
         2 unknown statements from line 12 on",
        "scene.obj: dropped triangles without area: 1 of 2",
        "scene.obj: ignored: faces of fewer than three corners (f) on line 13; 2 lines (l) from line 10 on; points (p) \
         on line 12; smoothing groups (s) on line 9; statements of curves and surfaces on line 16; unknown statements \
         on line 17",
    ];
    assert_eq!(warnings, expected);
}

#[test]
fn what_changes_nothing_is_not_worth_a_word() {
    let folder = Folder::new("neutral");
    folder.write(
        "m.mtl",
        "# c\n\nnewmtl a # b\nKd 1 1 1\nKs 0 0 0\nKe 0 0 0 # no\nKa 0\nd 1.0\nTr 0\nTf 1 1 1\nillum 2\n",
    );
    folder.scene(format!("# c\n\nmtllib m.mtl\n{SIX}vn 0 0 1\nvt 0 0\ns 1\ns off\nf 1//1 2//1 3//1\n"));
    assert!(folder.warnings().is_empty(), "{:?}", folder.warnings());
}

#[test]
fn meshes_of_ones_own_are_warned_of_too_and_at_most_six_times() {
    let folder = Folder::new("own_meshes");
    let name = folder.file("mesh").display().to_string();
    let flat = stereotrace::Mesh::new(vec![Vec3::ZERO; 3], vec![[0, 1, 2]]).name(&*name);
    let mut scene = Scene::new();
    (0..20).for_each(|_| scene.add_mesh(&flat).unwrap());
    assert_eq!(scene.degenerate_count(), 20);
    let start = "mesh '/";
    let all = common::warnings::WARNINGS.lock().unwrap().clone();
    let own: Vec<_> = all.iter().filter(|text| text.starts_with(start) && text.contains("own_meshes")).collect();
    assert_eq!(own.len(), 6, "{all:?}");
    assert!(own[0].ends_with("dropped triangles without area: 1 of 1"), "{}", own[0]);
    assert!(own[5].ends_with("more meshes have triangles without area; they are counted but not listed"), "{}", own[5]);
}

/// Tests a grid of 40,000 quads, each a hundredth wide, far from the origin.
#[test]
fn triangles_lost_to_rounding_are_told_and_counted() {
    let folder = Folder::new("rounding");
    let mut text = String::new();
    for index in 0..201 * 201 {
        text += &format!("v {} 0 {}\n", 1e7 + 0.01 * f64::from(index % 201), 1e7 + 0.01 * f64::from(index / 201));
    }
    for quad in (0..201 * 200).filter(|quad| quad % 201 < 200).map(|quad| quad + 1) {
        text += &format!("f {} {} {} {}\n", quad, quad + 1, quad + 202, quad + 201);
    }
    let options = SceneOptions::default().origin(Origin::World);
    let scene = folder.read_with(text, &options).unwrap();
    assert_eq!(scene.primitive_count(), 80_000);
    let dropped = scene.degenerate_count();
    assert!(dropped > 79_900, "{dropped}");
    let expected = format!(
        "scene.obj: dropped triangles without area: {dropped} of 80000; coordinates near 1.0000002e7 are rounded to \
         steps of 1: move it nearer to the origin"
    );
    assert_eq!(folder.warnings(), [expected]);
}
