//! Tests how faces become triangles, normals and objects, for any layout of the file.

use stereotrace::{Scene, glam::Vec3};

use super::{ARC, Folder, SIX, corners, materials, objects};

fn smooth(scene: &Scene) -> Vec<bool> {
    scene.triangles().iter().map(|triangle| triangle.normals != [Vec3::ZERO; 3]).collect()
}

#[test]
fn polygons_are_fanned_in_file_order() {
    let folder = Folder::new("fan");
    let scene = folder.scene(format!("{ARC}f 6 5 4\nf 1 2 3 4\nf 2 3 4 5 6\nf 3 2 1\n"));
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
fn texture_coordinates_change_no_triangle() {
    let folder = Folder::new("texture");
    let plain = folder.scene(format!("{SIX}f 1 2 3\nf 2 3 4\n"));
    for faces in ["f 1/1 2/2 3/1\nf 2/1 3/2 4/1", "f 1/ 2/ 3/\nf 2// 3// 4//", "f 1/2 2/-1 3\nf 2/1 3/1 4/1"] {
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
    // The faces have, in order: no normals, all, all but one corner of a quad, all, a zero normal, all with another
    // material.
    let scene = folder.scene(format!(
        "{ARC}vt 1 1\nvn 0 0 1\nvn 0 1 0\nvn 0 0 0\no one\nf 1 2 3\nf 2//1 3//2 4//1\nf 1//1 2//2 3 4//1\nf 4//2 5//2 \
        6//1\n\
         f 1//1 2//3 3//1\nusemtl other\nf 1/1/2 2//2 3/1/1\n"
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
    assert_eq!(folder.warnings(), ["scene.obj: dropped triangles without area: 1 of 6"]); // f 1 3 5
}

#[test]
fn objects_are_g_lines_where_there_is_no_o() {
    let folder = Folder::new("groups");
    let scene =
        folder.scene(format!("{SIX}g a\nf 1 2 3\ng a\nf 2 3 4\n\tg\tb # 2\nf 3 4 5\ng\nf 4 5 6\ng a\nf 1 2 3\n"));
    assert_eq!(objects(&scene), [("a", 0), ("b # 2", 2), ("", 3), ("a", 4)]);
}

#[test]
fn line_ends_marks_and_layout_make_no_difference() {
    let folder = Folder::new("layout");
    let plain = format!("# a\no thing\n{SIX}vn 0 0 1\nf 1//1 2//1 3//1 4//1\nf 4 5 6\n");
    let expected = folder.scene(&plain);
    let mut latin = b"# \xe4\xf6\xfc\no \xff\n".to_vec();
    latin.extend_from_slice(plain.replace("o thing\n", "").as_bytes());
    let layouts: [Vec<u8>; 9] = [
        plain.replace('\n', "\r\n").into(),
        plain.replace('\n', "\r").into(),
        plain.replace("f 1//1 2//1 ", "f 1//1 \\\n 2//1 ").replace('\n', "\r").into(),
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
        assert_eq!(objects(&scene), [(if index == 8 { "\u{fffd}" } else { "thing" }, 0)], "{index}");
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
fn weights_divide_and_colours_are_read_over() {
    let folder = Folder::new("weights");
    let scene = folder.scene("v 2 0 0 2\nv 2 1 0 1\nv 1.5 0 1 0.5\nf 1 2 3\n");
    assert_eq!(corners(&scene), [[1, 2, 3]]);
    let scene = folder.scene("v 1 0 0 0.5 0.5 0.5\nv 2 1 0 1 1 1\nv 3 0 1 0 0 0\nf 1 2 3\n");
    assert_eq!(corners(&scene), [[1, 2, 3]]);
}

#[test]
fn the_still_life_of_the_repository_loads_whole() {
    let scene = Scene::from_obj(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/still_life.obj")).unwrap();
    assert_eq!((scene.primitive_count(), scene.degenerate_count(), scene.object_count()), (2006, 0, 15));
    assert_eq!(scene.materials().len(), 13, "12 of the file and grey");
    assert!(scene.has_normals());
}
