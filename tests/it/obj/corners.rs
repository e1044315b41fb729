//! Tests the attributes of triangle corners: texture coordinates, colours, and normals if the file has none.

use stereotrace::{
    Error, Scene, SceneOptions,
    glam::{Vec2, Vec3},
};

use super::{ARC, Folder, SIX, corners};

/// Returns the texture coordinates that these tests give to a vertex of [`ARC`].
fn of_corner(corner: u32) -> Vec2 {
    Vec2::new(0.5 * corner as f32, -(corner as f32))
}

fn uv_lines() -> String {
    (1..=6).map(|corner| format!("vt {} {}\n", of_corner(corner).x, of_corner(corner).y)).collect()
}

fn assert_uv_follow_corners(scene: &Scene) {
    assert_eq!(scene.uv().len(), scene.triangles().len());
    for (corners, uv) in corners(scene).into_iter().zip(scene.uv()) {
        assert_eq!(corners.map(of_corner), *uv);
    }
}

#[test]
fn texture_coordinates_stay_with_their_corners_however_faces_are_split() {
    let folder = Folder::new("uv");
    let uv = uv_lines();
    let scene = folder.scene(format!(
        "{ARC}{uv}vn 0 0 1\nf 1/1 2/2 3/3 4/4\no b\nf 6/6/1 5/-2/1 4/4/1\nusemtl m\nf 2/2 3/3 4/4 5/5 6/6\ng c\nf 1/1/ \
        2/2/ 3/3/\n"
    ));
    assert_eq!(scene.primitive_count(), 7);
    assert_uv_follow_corners(&scene);
    assert_eq!(scene.triangles()[2].normals, [Vec3::Z; 3]);
    // This concave face is cut into ears, since a fan from its first corner would leave the face.
    let scene =
        folder.scene(format!("v 1 0 0\nv 2 9 0\nv 3 3 0\nv 4 9 0\nv 5 0 0\nv 6 -9 0\n{uv}f 1/1 2/2 3/3 4/4 5/5 6/6\n"));
    assert_eq!(scene.primitive_count(), 4);
    assert_uv_follow_corners(&scene);
}

#[test]
fn one_vertex_may_have_several_texture_coordinates() {
    let folder = Folder::new("seam");
    let scene = folder.scene(format!("{SIX}vt 0 0\nvt 1\nvt 2 3 4\nf 1/1 2/2 3/3\nf 1/3 3/1 4/2\n"));
    let [a, b, c] = [Vec2::ZERO, Vec2::X, Vec2::new(2.0, 3.0)];
    assert_eq!(scene.uv(), [[a, b, c], [c, a, b]]);
}

#[test]
fn a_face_without_texture_coordinates_has_zeros_and_takes_none_from_others() {
    let folder = Folder::new("some_uv");
    let uv = uv_lines();
    let scene =
        folder.scene(format!("{ARC}{uv}f 4 5 6\nf 1/1 2/2 3/3\nf 1/1 2/2 3\nf 2/2 3/3 4/4\no plain\nf 1 2 3\n"));
    let of = |first: u32| [first, first + 1, first + 2].map(of_corner);
    let none = [Vec2::ZERO; 3];
    assert_eq!(scene.uv(), [none, of(1), none, of(2), none]);
    // If no face has texture coordinates, the scene has no list.
    assert!(folder.scene(format!("{ARC}{uv}f 1/1 2 3\nf 1 2 3\n")).uv().is_empty());
}

#[test]
fn colours_of_vertices_are_srgb_and_clamped_with_one_warning() {
    let folder = Folder::new("vertex_colours");
    let faces = "f 1 2 3 4\no b\nf 4 3 2\n";
    let scene = folder.scene(format!("v 1 1 0 1 0 0.5\nv 2 4 0 0 1 0\nv 3 9 0 0 0 1\nv 4 16 0 1 1 1\n{faces}"));
    let [a, b, c, d] = [Vec3::new(1.0, 0.0, 0.214_041_14), Vec3::Y, Vec3::Z, Vec3::ONE];
    assert_eq!(scene.colors(), [[a, b, c], [a, c, d], [d, c, b]]);
    assert!(folder.warnings().is_empty(), "{:?}", folder.warnings());
    let scene = folder.scene("v 1 0 0 255 0 0\nv 2 0 0 0 -1 0\nv 3 1 0 0 0 1\nf 1 2 3\n");
    assert_eq!(scene.colors(), [[Vec3::X, Vec3::ZERO, Vec3::Z]]);
    assert_eq!(folder.warnings(), ["scene.obj: colours outside 0 to 1, which are clamped, at 2 vertices"]);
    assert!(folder.scene(format!("{SIX}f 1 2 3\n")).colors().is_empty());
}

#[test]
fn vertices_without_a_colour_beside_others_are_white() {
    let folder = Folder::new("some_colours");
    let [red, plain] = [" 1 0 0", ""];
    // Each vertex has a colour or none. One vertex is in no face, and would shift the others' colours.
    for last in [red, plain] {
        for of_colors in 0..8 {
            let of = |vertex: usize| if of_colors >> vertex & 1 == 1 { red } else { plain };
            let obj = format!("v 1 0 0{}\n# c\nv 2 1 0{}\nv 3 0 1{}\nv 9 9 9{last}\nf 1 2 3\n", of(0), of(1), of(2));
            let scene = folder.scene(&obj);
            let colored = (0..3).filter(|&vertex| of(vertex) == red).count() + usize::from(last == red);
            let expected = [0, 1, 2].map(|vertex| if of(vertex) == red { Vec3::X } else { Vec3::ONE });
            match colored {
                0 => assert!(scene.colors().is_empty()),
                _ => assert_eq!(scene.colors(), [expected], "{obj}"),
            }
            let warned = folder.warnings().last().cloned().unwrap_or_default();
            let count = format!(
                "scene.obj: {} of 4 without a colour, drawn white",
                ["", "1 vertex", "2 vertices", "3 vertices"][(4 - colored) % 4]
            );
            assert!(matches!(colored, 0 | 4) || warned == count, "{warned} {count}");
        }
    }
}

fn smoothed(folder: &Folder, degrees: f32, content: &str) -> Scene {
    folder.read_with(content, &SceneOptions::default().crease_angle(Some(degrees))).unwrap()
}

fn smooth(scene: &Scene) -> Vec<bool> {
    scene.triangles().iter().map(|triangle| triangle.is_smooth()).collect()
}

/// Returns four strips side by side, each 10 degrees steeper than the one before, with separate vertices.
fn gutter() -> String {
    let mut text = String::new();
    let (mut x, mut y) = (0.0f32, 0.0f32);
    for strip in 0..4 {
        let (sin, cos) = (10.0 * strip as f32).to_radians().sin_cos();
        let next = (x + cos, y + sin);
        text += &format!("v {x} {y} 0\nv {x} {y} -1\nv {} {} -1\nv {} {} 0\n", next.0, next.1, next.0, next.1);
        (x, y) = next;
    }
    text
}

#[test]
fn normals_are_made_below_the_crease_angle_and_only_where_they_are_asked_for() {
    let folder = Folder::new("crease");
    let faces = "f 4 3 2 1\nf 8 7 6 5\nf 12 11 10 9\nf 16 15 14 13\n";
    let text = format!("{}{faces}", gutter());
    assert!(!folder.scene(&text).has_normals());
    assert!(!smoothed(&folder, 9.9, &text).has_normals());
    let scene = smoothed(&folder, 10.1, &text);
    assert_eq!(smooth(&scene), [true; 8]);
    // The normal at the seam of the first two strips is halfway between their normals, on both sides.
    let expected = Vec3::new(-5f32.to_radians().sin(), 5f32.to_radians().cos(), 0.0);
    let mut seen = 0;
    for triangle in scene.triangles() {
        for (corner, normal) in triangle.corners.iter().zip(triangle.normals) {
            if corner.x == 1.0 {
                seen += 1;
                assert!((normal - expected).length() < 1e-6, "{normal} {expected}");
            }
        }
    }
    assert_eq!(seen, 6);
    // Faces with normals keep them, and so do faces without normals in the same object. Another object gets smooth
    // normals.
    let mixed =
        format!("{}vn 0 1 0\no a\nf 4//1 3//1 2//1 1//1\nf 8 7 6 5\no b\nf 12 11 10 9\nf 16 15 14 13\n", gutter());
    let scene = smoothed(&folder, 30.0, &mixed);
    assert_eq!(smooth(&scene), [true, true, false, false, true, true, true, true]);
    assert_eq!(scene.triangles()[0].normals, [Vec3::Y; 3]);
    let Error::Scene { element, reason, .. } =
        folder.read_with(&text, &SceneOptions::default().crease_angle(Some(f32::NAN))).unwrap_err()
    else {
        panic!("another error")
    };
    assert_eq!((&*element, &*reason), ("crease angle", "it is NaN degrees; it must be within 0 to 180"));
}

#[test]
fn smoothing_groups_bound_what_is_smooth_and_off_stays_flat() {
    let folder = Folder::new("groups_of_s");
    let faces = ["f 4 3 2 1\n", "f 8 7 6 5\n", "f 12 11 10 9\n", "f 16 15 14 13\n"];
    let with = |groups: [&str; 4]| {
        let faces: String = groups.iter().zip(faces).map(|(group, face)| format!("{group}{face}")).collect();
        let scene = smoothed(&folder, 30.0, &format!("{}{faces}", gutter()));
        let smooth = smooth(&scene);
        [0, 2, 4, 6].map(|first| smooth[first] && smooth[first + 1])
    };
    assert_eq!(with(["", "", "", ""]), [true; 4]);
    assert_eq!(with(["s 1\n", "", "", ""]), [true; 4]);
    assert_eq!(with(["s 1\n", "", "s off\n", ""]), [true, true, false, false]);
    assert_eq!(with(["s 0\n", "", "s 3\n", ""]), [false, false, true, true]);
    assert_eq!(with(["s 1\n", "s 2\n", "", "s 1\n"]), [false, true, true, false]);
    assert!(folder.warnings().is_empty(), "{:?}", folder.warnings());
}
