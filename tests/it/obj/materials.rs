//! Tests the materials of MTL files: colours, and missing and odd names.

use stereotrace::{MaterialId, Principled, glam::Vec3};

use super::{Folder, SIX, materials};

#[test]
fn diffuse_colours_are_taken_as_linear_and_kept_within_0_and_1() {
    let folder = Folder::new("kd");
    folder.write(
        "sub/m.mtl",
        "newmtl plain\nKd 0.5 0.25 0.125 # clay\nnewmtl loud\nKd 2 -1 0.5\nnewmtl none\nKs 1 1 1\nnewmtl one\nKd 0.3\n",
    );
    let scene = folder.scene(format!("mtllib sub/m.mtl\n{SIX}usemtl plain\nf 1 2 3\n"));
    let albedo = |name: &str| scene.materials().iter().find(|material| material.name == name).unwrap().albedo;
    assert_eq!(scene.materials()[0].albedo, Vec3::splat(0.7));
    assert_eq!(albedo("plain"), Vec3::new(0.5, 0.25, 0.125));
    assert_eq!(albedo("loud"), Vec3::new(1.0, 0.0, 0.5));
    assert_eq!(albedo("none"), Vec3::splat(0.7));
    // MTL: "if only r is specified, then g and b are assumed to be equal to r".
    assert_eq!(albedo("one"), Vec3::splat(0.3));
    assert_eq!(materials(&scene), ["plain"]);
}

#[test]
fn a_bad_colour_is_grey_with_a_warning_that_names_file_and_line() {
    let folder = Folder::new("bad_kd");
    let bad = ["1.#QNAN 0 0", "", "0.5 0.5", "red", "nan 0 0", "0 inf 0", "0 0 1e99", "1 2 3 4", "spectral file.rfl"];
    for kd in bad {
        folder.write("m.mtl", format!("Kd 1 1 1\nnewmtl bad\nKd {kd}\nKa 1\nillum x\nnewmtl good\nKd 0 0 1\n"));
        let scene = folder.scene(format!("mtllib m.mtl\n{SIX}usemtl bad\nf 1 2 3\nusemtl good\nf 2 3 4\n"));
        assert_eq!(materials(&scene), ["bad", "good"]);
        assert_eq!(scene.materials()[1].albedo, Vec3::splat(0.7), "{kd}");
        assert_eq!(scene.materials()[2].albedo, Vec3::Z, "{kd}");
        let expected = format!("m.mtl:3: Kd '{kd}' of material 'bad'");
        assert!(folder.warnings().iter().any(|warning| warning.starts_with(&expected)), "{expected}");
    }
    assert!(folder.warnings().iter().any(|warning| warning.starts_with("m.mtl:1: Kd before")));
}

#[test]
fn a_missing_mtl_is_grey_with_a_warning() {
    let folder = Folder::new("missing_mtl");
    let scene = folder.scene(format!("mtllib gone.mtl\n{SIX}usemtl red\nf 1 2 3\n"));
    assert_eq!(scene.triangles()[0].material, MaterialId(0));
    let warnings = folder.warnings();
    assert!(warnings.iter().any(|warning| warning.starts_with("gone.mtl: ")), "{warnings:?}");
    assert!(warnings.iter().any(|warning| warning.starts_with("scene.obj:8: no material 'red'")), "{warnings:?}");
    let before = warnings.len();
    folder.scene(format!("# spaces\nmtllib no such.mtl\nmtllib\n{SIX}f 1 2 3\n"));
    let mut warnings = folder.warnings().split_off(before);
    warnings.sort();
    assert_eq!(warnings[1], "scene.obj:3: mtllib names no file; it is ignored");
    assert!(
        warnings[0].starts_with("no such.mtl: ")
            && warnings[0].ends_with("; its materials are grey (line 2 of scene.obj)"),
        "{warnings:?}"
    );
    assert_eq!(warnings.len(), 2, "{warnings:?}");
}

#[test]
fn an_unknown_material_is_grey_with_one_warning() {
    let folder = Folder::new("unknown_material");
    folder.write("m.mtl", "newmtl red\nKd 1 0 0\n");
    let scene = folder.scene(format!(
        "mtllib m.mtl\n{SIX}usemtl red\nf 1 2 3\nusemtl blue\nf 2 3 4\nusemtl red\nf 3 4 5\nusemtl blue\nf 4 5 6\n"
    ));
    assert_eq!(materials(&scene), ["red", "", "red", ""]);
    assert_eq!(scene.triangles()[1].material, MaterialId(0));
    let warnings = folder.warnings();
    assert!(warnings.len() == 1 && warnings[0].starts_with("scene.obj:10: no material 'blue'"), "{warnings:?}");
}

#[test]
fn names_may_be_odd_and_libraries_several() {
    let folder = Folder::new("names");
    folder
        .write("a.mtl", "newmtl red #1\nKd 1 0 0\nnewmtl\nKd 0 0 1\n")
        .write("with space.mtl", "  newmtl\tgreen \r\n\tKd\t0 1 0\r\n");
    folder.write("b/b.mtl", b"# caf\xe9\nnewmtl caf\xe9\nKd 1 1 0\n");
    let mut content =
        format!("{SIX}usemtl red #1\nf 1 2 3\n  usemtl\tgreen\t\nf 2 3 4\nusemtl\nf 3 4 5\nusemtl caf").into_bytes();
    content.extend_from_slice(b"\xe9\nf 4 5 6\nmtllib a.mtl b\\b.mtl\nmtllib with space.mtl\n");
    let scene = folder.scene(content);
    assert_eq!(materials(&scene), ["red #1", "green", "", "caf\u{fffd}"]);
    let albedo = |triangle: usize| scene.materials()[scene.triangles()[triangle].material.0 as usize].albedo;
    assert_eq!([0, 1, 2, 3].map(albedo), [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(1.0, 1.0, 0.0)]);
    assert!(folder.warnings().is_empty(), "{:?}", folder.warnings());
}

#[test]
fn lines_may_end_in_a_carriage_return_alone() {
    let folder = Folder::new("mtl_line_ends");
    folder.write("m.mtl", "\u{feff}newmtl red\rKd 1 0 0\rnewmtl green\rKd 0 1 0\r");
    let scene = folder.scene(format!("mtllib m.mtl\n{SIX}usemtl green\nf 1 2 3\n"));
    assert_eq!((materials(&scene), scene.materials()[2].albedo), (vec!["green"], Vec3::Y));
}

#[test]
fn mirrors_and_glass_without_a_colour_are_black_but_for_what_they_send_on() {
    let folder = Folder::new("mirrors");
    folder.write(
        "m.mtl",
        "newmtl mirror\nKd 0 0 0\nKs 0.9 0.8 0.7\nillum 3\nnewmtl glass\nillum 7\nKs 0 0 0\nnewmtl chrome\nKs 2 1 1\n\
         illum 5\nnewmtl tinted\nKd 0.2 0 0\nKs 1 1 1\nillum 4\nnewmtl soot\nKd 0 0 0\nKs 1 1 1\nillum 2\n",
    );
    let scene = folder.scene(format!("mtllib m.mtl\n{SIX}f 1 2 3\n"));
    let albedos: Vec<Vec3> = scene.materials()[1..].iter().map(|material| material.albedo).collect();
    assert_eq!(albedos, [Vec3::ZERO, Vec3::ZERO, Vec3::ZERO, Vec3::new(0.2, 0.0, 0.0), Vec3::ZERO]);
    let expected = "m.mtl: values out of range, which are clamped, in 1 material"; // chrome
    assert_eq!(folder.warnings(), [expected]);
}

#[test]
fn a_name_that_is_defined_twice_is_one_material_and_the_last_holds() {
    let folder = Folder::new("twice");
    folder.write("a.mtl", "newmtl red\nKd 0.1 0 0\nnewmtl green\nKd 0 1 0\n").write("b.mtl", "newmtl red\nKd 1 0 0\n");
    let scene = folder.scene(format!("mtllib a.mtl\nmtllib b.mtl\nmtllib a.mtl\n{SIX}usemtl red\nf 1 2 3\n"));
    assert_eq!(scene.materials().len(), 3);
    assert_eq!(scene.materials()[scene.triangles()[0].material.0 as usize].albedo, Vec3::X);
}

#[test]
fn statements_of_the_physically_based_extension_make_a_principled_surface() {
    let folder = Folder::new("pbr_mtl");
    let mtl = "newmtl plain\nKd 0.5 0.4 0.3\nNs 30\nnewmtl gold\nKd 1 0.8 0.3\nPr 0.25\nPm 1\nKe 0.1 0 0\n\
               newmtl odd\nPr 7\nnewmtl pane\nillum 7\nTf 0.5 1 1\nNi 1.3\nPm 0\nnewmtl brass\nPm 1\nNs 30\n";
    folder.write("m.mtl", mtl);
    let uses: String =
        ["plain", "gold", "odd", "pane", "brass"].map(|name| format!("usemtl {name}\nf 1 2 3\n")).concat();
    let scene = folder.scene(format!("mtllib m.mtl\n{SIX}{uses}"));
    let of = |name: &str| scene.materials().iter().find(|material| material.name == name).unwrap().principled;
    assert_eq!(of("plain"), None);
    let gold = Principled::new(Vec3::new(1.0, 0.8, 0.3), 1.0, 0.25).emission(Vec3::new(0.1, 0.0, 0.0));
    assert_eq!(of("gold"), Some(gold));
    assert_eq!(of("odd").unwrap().roughness, 1.0);
    let pane = of("pane").unwrap();
    assert_eq!((pane.roughness, pane.base, pane.transmission, pane.index), (0.0, Vec3::new(0.5, 1.0, 1.0), 1.0, 1.3));
    // Without Pr the roughness is that of a highlight as wide as Phong's.
    let brass = of("brass").unwrap();
    assert!((brass.roughness - (2.0_f32 / 32.0).powf(0.25)).abs() < 1e-6, "{brass:?}");
    assert!(folder.warnings().iter().any(|warning| warning.contains("values out of range")), "{:?}", folder.warnings());
}
