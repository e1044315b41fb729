//! Odd OBJ and MTL files: what `Scene::from_obj` makes of them, and what it says where it can't.
#![cfg(feature = "obj")]

mod common;

use std::{
    path::{Path, PathBuf},
    sync::{Mutex, Once},
};

use common::random::Random;
use stereotrace::{Error, MaterialId, Scene, glam::Vec3};

/// Every warning of this process; tests look for those that name their own folder.
static WARNINGS: Mutex<Vec<String>> = Mutex::new(Vec::new());

struct Collector;

impl log::Log for Collector {
    fn enabled(&self, _: &log::Metadata) -> bool {
        true
    }

    fn log(&self, record: &log::Record) {
        if record.level() == log::Level::Warn {
            WARNINGS.lock().unwrap().push(record.args().to_string());
        }
    }

    fn flush(&self) {}
}

/// A folder of one test, whose OBJ files are read.
struct Folder(common::folder::Folder);

impl Folder {
    fn new(test: &str) -> Self {
        static LOGGER: Once = Once::new();
        LOGGER.call_once(|| {
            log::set_logger(&Collector).unwrap();
            log::set_max_level(log::LevelFilter::Warn);
        });
        Self(common::folder::Folder::new(test))
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.file(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) -> &Self {
        self.0.write(name, content);
        self
    }

    /// Writes `content` to an OBJ file and reads it.
    fn read(&self, content: impl AsRef<[u8]>) -> Result<Scene, Error> {
        self.write("scene.obj", content);
        Scene::from_obj(self.file("scene.obj"))
    }

    fn scene(&self, content: impl AsRef<[u8]>) -> Scene {
        self.read(content).unwrap()
    }

    /// The line and the reason of the error that `content` gives.
    fn error(&self, content: impl AsRef<[u8]>) -> (Option<usize>, String) {
        match self.read(content) {
            Err(Error::File { path, line, reason }) => {
                assert_eq!(path, self.file("scene.obj"));
                (line, reason)
            }
            other => panic!("not a file error: {other:?}"),
        }
    }

    #[track_caller]
    fn fails_on_line(&self, line: usize, expected: &str, content: impl AsRef<[u8]>) {
        let (found, reason) = self.error(content);
        assert!(found == Some(line) && reason.contains(expected), "line {found:?} and not {line}: {reason}");
    }

    /// The warnings that name a file of this folder, from the file's name on.
    fn warnings(&self) -> Vec<String> {
        let prefix = format!("{}{}", self.0.path().display(), std::path::MAIN_SEPARATOR);
        let warnings = WARNINGS.lock().unwrap();
        warnings.iter().filter_map(|warning| warning.strip_prefix(&prefix)).map(str::to_owned).collect()
    }
}

/// Six vertices at x = 1 to 6, so that a corner's x tells which vertex it is.
const SIX: &str = "v 1 0 0\nv 2 1 0\nv 3 0 1\nv 4 2 0\nv 5 0 2\nv 6 3 1\n";

/// The corners of each triangle as numbers of vertices of [`SIX`].
fn corners(scene: &Scene) -> Vec<[u32; 3]> {
    scene.triangles().iter().map(|triangle| triangle.corners.map(|corner| corner.x as u32)).collect()
}

fn materials(scene: &Scene) -> Vec<&str> {
    let name = |MaterialId(id)| scene.materials()[id as usize].name.as_str();
    scene.triangles().iter().map(|triangle| name(triangle.material)).collect()
}

/// Name and first primitive of each object.
fn objects(scene: &Scene) -> Vec<(&str, u32)> {
    let first = |object| (0..scene.primitive_count() as u32).find(|&id| scene.object_of(id) == object).unwrap();
    (0..scene.object_count() as u32).map(|object| (scene.object_name(object), first(object))).collect()
}

fn smooth(scene: &Scene) -> Vec<bool> {
    scene.triangles().iter().map(|triangle| triangle.normals != [Vec3::ZERO; 3]).collect()
}

#[test]
fn polygons_are_fanned_in_file_order() {
    let folder = Folder::new("fan");
    let scene = folder.scene(format!("{SIX}f 6 5 4\nf 1 2 3 4\nf 2 3 4 5 6\nf 3 2 1\n"));
    assert_eq!(corners(&scene), [[6, 5, 4], [1, 2, 3], [1, 3, 4], [2, 3, 4], [2, 4, 5], [2, 5, 6], [3, 2, 1]]);
}

#[test]
fn negative_indices_count_back_from_their_own_line() {
    let folder = Folder::new("negative");
    let scene = folder.scene("v 1 0 0\nv 2 1 0\nv 3 0 1\nf -3 -2 -1\nv 4 0 2\nf -1 -3 1\n");
    assert_eq!(corners(&scene), [[1, 2, 3], [4, 2, 1]]);
}

#[test]
fn points_and_lines_are_no_faces_however_long() {
    let folder = Folder::new("lines");
    let scene = folder.scene(format!("{SIX}l 1 2 3\np 1\nl 1 2 3 4 5\nf 1 2\nf 1\nf 4 5 6\nl 1 2\n"));
    assert_eq!(corners(&scene), [[4, 5, 6]]);
}

#[test]
fn triangles_without_area_keep_their_number() {
    let folder = Folder::new("degenerate");
    let scene = folder.scene(format!("{SIX}f 1 2 3\nf 1 1 2\nf 4 4 4\nf 4 5 6\n"));
    assert_eq!(corners(&scene)[3], [4, 5, 6]);
    assert_eq!((scene.primitive_count(), scene.degenerate_count()), (4, 2));
}

#[test]
fn texture_coordinates_change_nothing() {
    let folder = Folder::new("texture");
    let plain = folder.scene(format!("{SIX}f 1 2 3\nf 2 3 4\n"));
    // Also where an index of one is out of range: nothing is read through it.
    for faces in ["f 1/1 2/2 3/1\nf 2/1 3/2 4/1", "f 1/ 2/ 3/\nf 2// 3// 4//", "f 1/9 2/-9 3/0\nf 2/1 3/1 4/1"] {
        let scene = folder.scene(format!("{SIX}vt 0 0\nvt 1 0.5 0\n{faces}\n"));
        assert_eq!(corners(&scene), corners(&plain), "{faces}");
    }
}

#[test]
fn normals_are_made_unit_length_and_stay_with_their_corners() {
    let folder = Folder::new("normals");
    let scene =
        folder.scene(format!("{SIX}vn 0 0 5\nvn 0 1e-30 0\nvn -1e30 0 0\nf 1//1 2//2 3//3\nf 3//-3 2//-1 1//-2\n"));
    assert!(scene.has_normals());
    assert_eq!(scene.triangles()[0].normals, [Vec3::Z, Vec3::Y, Vec3::NEG_X]);
    assert_eq!(scene.triangles()[1].normals, [Vec3::Z, Vec3::NEG_X, Vec3::Y]);
}

#[test]
fn faces_without_normals_are_flat_and_take_none_from_others() {
    let folder = Folder::new("some_normals");
    let flat = folder.scene(format!("{SIX}vn 0 0 1\nf 1 2 3\n"));
    assert!(!flat.has_normals());
    // In order: none, all, one corner of a quad without, all, zero, all of another material.
    let scene = folder.scene(format!(
        "{SIX}vn 0 0 1\nvn 0 1 0\nvn 0 0 0\no one\nf 1 2 3\nf 2//1 3//2 4//1\nf 1//1 2//2 3 4//1\nf 4//2 5//2 6//1\n\
         f 1//1 2//3 3//1\nusemtl other\nf 1/7/2 2//2 3/7/1\n"
    ));
    assert_eq!(corners(&scene), [[1, 2, 3], [2, 3, 4], [1, 2, 3], [1, 3, 4], [4, 5, 6], [1, 2, 3], [1, 2, 3]]);
    assert_eq!(smooth(&scene), [false, true, false, false, true, false, true]);
    assert_eq!(scene.triangles()[1].normals, [Vec3::Z, Vec3::Y, Vec3::Z]);
    assert_eq!(scene.triangles()[4].normals, [Vec3::Y, Vec3::Y, Vec3::Z]);
    assert_eq!(scene.triangles()[6].normals, [Vec3::Y, Vec3::Y, Vec3::Z]);
    assert_eq!(objects(&scene), [("one", 0)]);
}

#[test]
fn objects_are_o_lines_and_materials_do_not_split_them() {
    let folder = Folder::new("objects");
    folder.write("m.mtl", "newmtl red\nKd 1 0 0\nnewmtl green\nKd 0 1 0\n");
    let scene = folder.scene(format!(
        "mtllib m.mtl\n{SIX}f 1 2 3\no table\ng legs\nusemtl red\nf 2 3 4\ng top\nusemtl green\nf 3 4 5\nusemtl red\n\
         f 4 5 6\no empty\no chair set\nf 1 3 5\no  chair set\nf 2 4 6\n"
    ));
    assert_eq!(objects(&scene), [("", 0), ("table", 1), ("chair set", 4), ("chair set", 5)]);
    assert_eq!(corners(&scene), [[1, 2, 3], [2, 3, 4], [3, 4, 5], [4, 5, 6], [1, 3, 5], [2, 4, 6]]);
    assert_eq!(materials(&scene), ["", "red", "green", "red", "red", "red"]);
    assert_eq!(folder.warnings(), ["scene.obj: triangles without area, which are dropped: 1 of 6"]); // f 1 3 5
}

#[test]
fn objects_are_g_lines_where_there_is_no_o() {
    let folder = Folder::new("groups");
    let scene =
        folder.scene(format!("{SIX}g a\nf 1 2 3\ng a\nf 2 3 4\n\tg\tb # 2\nf 3 4 5\ng\nf 4 5 6\ng a\nf 1 2 3\n"));
    assert_eq!(objects(&scene), [("a", 0), ("b # 2", 2), ("", 3), ("a", 4)]);
}

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
    let bad = ["", "0.5 0.5", "red", "nan 0 0", "0 inf 0", "0 0 1e99", "1 2 3 4", "spectral file.rfl"];
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
    // The folder itself, for a library without a name.
    assert_eq!(folder.scene(format!("mtllib\n{SIX}f 1 2 3\n")).primitive_count(), 1);
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
        "scene.obj: 3 more MTL files that can't be read",
        "m.mtl: 4 more diffuse colours",
        "scene.obj: 7 more materials that are in no MTL file",
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
    folder.write("m.mtl", format!("newmtl a\nKd 1 1 1\n{material}newmtl b\nKd 1 0 0\nillum 5\n{material}"));
    folder
        .scene(format!("mtllib m.mtl\n{SIX}vt 0 0\ns 1\nl 1 2\nl 2 3\np 1\nf 1 2\nf 1 2 3\nf 1 1 2\ncurv 1 2\nbar\n"));
    let mut warnings = folder.warnings();
    warnings.sort();
    let expected = [
        "m.mtl: left out: 2 ambient colours of their own (Ka) from line 3 on; 2 emissions (Ke) from line 7 on; \
         2 highlights (Ks) from line 4 on; 2 indices of refraction (Ni) from line 6 on; \
         reflections and refractions (illum 3 and above) on line 15; 4 textures (map_Kd and their like) from line 8 on; \
         2 transparencies (d, Tr, Tf) from line 11 on; 2 unknown statements from line 12 on",
        "scene.obj: left out: faces of fewer than three corners (f) on line 13; 2 lines (l) from line 10 on; \
         points (p) on line 12; smoothing groups (s) on line 9; statements of curves and surfaces on line 16; \
         unknown statements on line 17",
        "scene.obj: triangles without area, which are dropped: 1 of 2",
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
fn mirrors_and_glass_without_a_colour_take_the_specular_one() {
    let folder = Folder::new("mirrors");
    folder.write(
        "m.mtl",
        "newmtl mirror\nKd 0 0 0\nKs 0.9 0.8 0.7\nillum 3\nnewmtl glass\nillum 7\nKs 0 0 0\nnewmtl chrome\nKs 2 1 1\n\
         illum 5\nnewmtl tinted\nKd 0.2 0 0\nKs 1 1 1\nillum 4\nnewmtl soot\nKd 0 0 0\nKs 1 1 1\nillum 2\n",
    );
    let scene = folder.scene(format!("mtllib m.mtl\n{SIX}f 1 2 3\n"));
    let albedos: Vec<Vec3> = scene.materials()[1..].iter().map(|material| material.albedo).collect();
    let (mirror, grey) = (Vec3::new(0.9, 0.8, 0.7), Vec3::splat(0.7));
    assert_eq!(albedos, [mirror, grey, Vec3::ONE, Vec3::new(0.2, 0.0, 0.0), Vec3::ZERO]);
    let warnings = folder.warnings();
    let said = |line: usize, text: &str| {
        let start = format!("m.mtl:{line}: material {text}");
        assert!(warnings.iter().any(|warning| warning.starts_with(&start)), "{start}: {warnings:?}");
    };
    said(1, "'mirror' is a mirror or glass (illum 3) without a diffuse colour; reflection is not rendered, its spec");
    said(5, "'glass' is a mirror or glass (illum 7) without a diffuse colour; reflection is not rendered, grey");
    said(8, "'chrome'");
    assert_eq!(warnings.len(), 4, "{warnings:?}");
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
fn meshes_of_ones_own_are_warned_of_too_and_at_most_six_times() {
    let folder = Folder::new("own_meshes");
    let name = folder.file("mesh").display().to_string();
    let flat = stereotrace::Mesh {
        name: name.clone(),
        positions: vec![Vec3::ZERO; 3],
        triangles: vec![[0, 1, 2]],
        materials: vec![MaterialId(0)],
        ..Default::default()
    };
    let mut scene = Scene::new();
    (0..20).for_each(|_| scene.add_mesh(&flat).unwrap());
    assert_eq!(scene.degenerate_count(), 20);
    let start = "mesh '/";
    let all = WARNINGS.lock().unwrap().clone();
    let own: Vec<_> = all.iter().filter(|text| text.starts_with(start) && text.contains("own_meshes")).collect();
    assert_eq!(own.len(), 6, "{all:?}");
    assert!(own[0].ends_with("triangles without area, which are dropped: 1 of 1"), "{}", own[0]);
    assert!(own[5].ends_with("more meshes with triangles without area follow; they are counted"), "{}", own[5]);
}

/// A grid of 40,000 quads, each a hundredth wide, far from the origin.
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
    let scene = folder.scene(text);
    assert_eq!(scene.primitive_count(), 80_000);
    let dropped = scene.degenerate_count();
    assert!(dropped > 79_900, "{dropped}");
    let expected = format!(
        "scene.obj: triangles without area, which are dropped: {dropped} of 80000; coordinates near 1.0000002e7 are rounded \
         to steps of 1: move it nearer to the origin"
    );
    assert_eq!(folder.warnings(), [expected]);
}

#[test]
fn line_ends_marks_and_layout_make_no_difference() {
    let folder = Folder::new("layout");
    let plain = format!("# a\no thing\n{SIX}vn 0 0 1\nf 1//1 2//1 3//1 4//1\nf 4 5 6\n");
    let expected = folder.scene(&plain);
    let mut latin = b"# \xe4\xf6\xfc\no \xff\n".to_vec();
    latin.extend_from_slice(plain.replace("o thing\n", "").as_bytes());
    let layouts: [Vec<u8>; 7] = [
        plain.replace('\n', "\r\n").into(),
        format!("\u{feff}{}", plain.replace("# a\n", "")).into(),
        plain.trim_end().into(),
        plain.replace('\n', "  # x y z w\n").replace("thing  # x y z w", "thing").into(),
        plain.replace("f 1//1 2//1 ", "  f\t1//1 \\\r\n 2//1\\\n").into(),
        plain.replace("f 4", "\n\n#comment\ns off\nvp 1 2\ncurv 1\nunknown\nf 4").into(),
        latin,
    ];
    for (index, layout) in layouts.into_iter().enumerate() {
        let scene = folder.scene(layout);
        assert_eq!((corners(&scene), smooth(&scene)), (corners(&expected), smooth(&expected)), "{index}");
        assert_eq!(objects(&scene), [(if index == 6 { "\u{fffd}" } else { "thing" }, 0)], "{index}");
    }
}

#[test]
fn a_comment_that_ends_in_a_backslash_hides_nothing() {
    let folder = Folder::new("backslash");
    assert_eq!(corners(&folder.scene(format!("# C:\\models\\\n{SIX}f 1 2 3\n"))), [[1, 2, 3]]);
}

#[test]
fn a_byte_order_mark_does_not_hide_the_first_vertex() {
    let folder = Folder::new("mark");
    assert_eq!(corners(&folder.scene(format!("\u{feff}{SIX}f 1 2 3\n"))), [[1, 2, 3]]);
}

#[test]
fn numbers_that_are_none_are_errors_on_their_line() {
    let folder = Folder::new("numbers");
    let cases = [
        ("v 1 x 0", "vertex: 'x' is not a number"),
        ("v 1 2", "vertex: 2 numbers of 3"),
        ("v", "vertex: 0 numbers of 3"),
        ("v 1 nan 0", "vertex: NaN is not a finite number"),
        ("v -inf 0 0", "vertex: -inf is not a finite number"),
        ("v 1e39 0 0", "vertex: inf is not a finite number"),
        ("v 0 2e8 0", "is beyond ±1e8"),
        ("v 1 2 3 0", "vertex: the weight w is 0"),
        ("v 1 2 3 1e-9", "is beyond ±1e8"),
        ("v 1 2 3 4 5", "vertex: 5 numbers"),
        ("v 1 2 3 4 5 6 7", "vertex: 7 numbers"),
        ("vn 0 0", "normal: 2 numbers of 3"),
        ("vn 0 up 0", "normal: 'up' is not a number"),
        ("vn 0 nan 0", "normal: NaN is not a finite number"),
        ("vn 0 inf 0 x", "normal: inf is not a finite number"),
    ];
    for (line, expected) in cases {
        // Used by a face whichever it is, and behind a folded line, which counts as two.
        let face = if line.starts_with("vn") { "f 1//-1 2//-1 3//-1" } else { "f 1 2 -1" };
        folder.fails_on_line(9, expected, format!("{SIX}f 1 2 \\\n 3\n{line}\n{face}\n"));
    }
}

#[test]
fn indices_out_of_range_are_errors_on_their_line() {
    let folder = Folder::new("indices");
    let cases = [
        ("f 1 2 7", "face corner '7': vertex index 7 is out of range: there are 6"),
        ("f 1 2 -7", "vertex index -7 is out of range"),
        ("f 0 1 2", "face corner '0': vertex index 0; the first is 1"),
        ("f 1 2 9223372036854775807", "is out of range"),
        ("f 1 2 -9223372036854775808", "is out of range"),
        ("f 1 2 9223372036854775808", "is not a whole number"),
        ("f 1//1 2//1 3//2", "face corner '3//2': normal index 2 is out of range: there are 1"),
        // Offsets that would wrap to small ones if they were multiplied by three unchecked.
        ("f 1//1 2//1 3//-2", "normal index -2 is out of range"),
        ("f 1//1 2//1 3//-5", "normal index -5 is out of range"),
        ("f 1//1 2//1 3//6148914691236517207", "is out of range"),
        ("f 1//0 2//1 3//1", "normal index 0; the first is 1"),
        ("f 1/x 2/1 3/1", "texture index 'x' is not a whole number"),
        ("f 1 2 3.0", "vertex index '3.0' is not a whole number"),
        ("f 1 2 /1/1", "no vertex index"),
        ("f 1/1/1/1 2 3", "more than vertex/texture/normal"),
        ("f", "a face without corners"),
        ("f # 1 2 3", "a face without corners"),
    ];
    for (line, expected) in cases {
        folder.fails_on_line(9, expected, format!("{SIX}vn 0 0 1\nf 1 2 3\n{line}\nf 1 2 99\n"));
    }
    folder.fails_on_line(3, "vertex index 3 is out of range: there are 2", "v 1 0 0\nv 2 0 1\nf 1 2 3\nv 3 1 0\n");
    folder.fails_on_line(7, "normal index 1 is out of range: there are 0", format!("{SIX}f 1//1 2//1 3//1\n"));
}

#[test]
fn of_two_faults_the_first_in_the_file_is_named() {
    let folder = Folder::new("first_fault");
    folder.fails_on_line(2, "'x' is not a number", "v 1 0 0\nv x 0 0\nv 1 1 1\nf 1 2 9\n");
    folder.fails_on_line(4, "vertex index 9", "v 1 0 0\nv 2 0 0\nv 1 1 1\nf 1 2 9\nv x 0 0\n");
    folder.fails_on_line(3, "NaN", "v 1 0 0\nv 2 0 0\nv nan 1 1\nf 1 2 3\nv x 0 0\n");
}

#[test]
fn weights_divide_and_colours_are_read_over() {
    let folder = Folder::new("weights");
    let scene = folder.scene("v 2 0 0 2\nv 2 1 0 1\nv 1.5 0 1 0.5\nf 1 2 3\n");
    assert_eq!(corners(&scene), [[1, 2, 3]]);
    let scene = folder.scene("v 1 0 0 0.5 0.5 0.5\nv 2 1 0 1 1 1\nv 3 0 1 0 0 0\nf 1 2 3\n");
    assert_eq!(corners(&scene), [[1, 2, 3]]);
}

#[test]
fn vertices_with_and_without_colours_are_an_error_with_a_remedy() {
    let folder = Folder::new("colours");
    let faces = "f 1 2 3\n";
    folder.fails_on_line(
        3,
        "this vertex has no colour and the first, on line 1, has one; give all vertices x y z r g b, or none",
        format!("v 1 0 0 1 1 1\nv 2 1 0 1 1 1\nv 3 0 1\n{faces}"),
    );
    folder.fails_on_line(3, "this vertex has a colour", format!("# c\nv 1 0 0\nv 2 1 0 1 1 1\nv 3 0 1\n{faces}"));
    folder.fails_on_line(2, "'red' is not a number", format!("v 1 0 0 1 1 1\nv 2 1 0 1 red 1\nv 3 0 1 1 1 1\n{faces}"));
}

#[test]
fn a_file_without_faces_is_an_error_that_says_so() {
    let folder = Folder::new("no_faces");
    for (content, vertices) in
        [("", 0), ("\n\n", 0), ("# nothing\n", 0), (SIX, 6), ("v 1 2 3\nl 1 1 1\nf 1 1\no x\n", 1)]
    {
        let (line, reason) = folder.error(content);
        assert_eq!(line, None);
        assert!(reason.starts_with(&format!("no faces and {vertices} vertices")), "{reason}");
    }
    let picture = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\xff\xfe\0".as_slice();
    assert!(folder.error(picture).1.starts_with("no faces"));
}

#[test]
fn a_missing_file_is_an_error_with_its_path() {
    let error = Scene::from_obj(Path::new("no/such/scene.obj")).unwrap_err();
    assert!(matches!(error, Error::Io { .. }) && error.to_string().contains("scene.obj"), "{error}");
}

/// Bytes of a valid file are replaced, doubled and cut at random: any result will do, a panic will not.
#[test]
fn no_damaged_file_panics() {
    let folder = Folder::new("damaged");
    let mtl = "newmtl red\nKd 0.5 0.25 1\nKa 1 1 1\nNs 3\nmap_Kd a.png\nnewmtl green\nKd 0 1 0\n";
    let obj = format!(
        "mtllib m.mtl\no a\n{SIX}vt 0 1\nvn 0 0 1\nvn 0 1 0\nusemtl red\nf 1/1/1 2//2 -1/-1/-1 4\nl 1 2 3\ng b\n\
         usemtl green\nf 4 5 6 1\n"
    );
    let mut random = Random::new(1);
    let mut damage = |text: &str| {
        let mut bytes = text.as_bytes().to_vec();
        for _ in 0..=random.below(4) {
            if bytes.len() < 2 {
                break;
            }
            let (at, other) = (random.below(bytes.len()), random.below(bytes.len()));
            match random.below(5) {
                0 => bytes[at] = b"0123456789-./ \t\r\n\\#fvnlog\xff\0"[random.below(27)],
                1 => bytes.insert(at, bytes[other]),
                2 => drop(bytes.remove(at)),
                3 => bytes.truncate(at.max(1)),
                _ => bytes.extend_from_within(at.min(other)..at.max(other)),
            }
        }
        bytes
    };
    let mut read = [0, 0];
    for _ in 0..1000 {
        folder.write("m.mtl", damage(mtl));
        read[usize::from(folder.read(damage(&obj)).is_ok())] += 1;
    }
    assert!(read[0] > 100 && read[1] > 100, "the damage is one-sided: {read:?}");
}

#[test]
fn the_still_life_of_the_repository_loads_whole() {
    let scene = Scene::from_obj(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/still_life.obj")).unwrap();
    assert_eq!((scene.primitive_count(), scene.degenerate_count(), scene.object_count()), (2006, 0, 15));
    assert_eq!(scene.materials().len(), 13, "12 of the file and grey");
    assert!(scene.has_normals());
}
