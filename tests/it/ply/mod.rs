//! Tests PLY files: the results of `Scene::from_ply`, and its messages about unsupported or invalid content.
use crate::common;

use common::{folder::Folder, warnings};
use stereotrace::{
    Error, Limits, Scene, SceneOptions,
    glam::{Vec2, Vec3},
};

/// Returns a text file with a square as one face of four corners. `properties` declares further properties of a vertex,
/// `values` contains them, and `face` is the line of the face.
fn square(properties: &str, values: [&str; 4], face: &str) -> String {
    let corners = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"];
    let vertices: String = corners.iter().zip(values).map(|(corner, more)| format!("{corner} {more}\n")).collect();
    format!(
        "ply\nformat ascii 1.0\ncomment made by hand\nobj_info none\nelement vertex 4\nproperty float x\nproperty \
        float \
         y\nproperty float z\n{properties}element face 1\nproperty list uchar int \
             vertex_indices\nend_header\n{vertices}{face}\n"
    )
}

fn read(content: impl AsRef<[u8]>) -> Result<Scene, Error> {
    let folder = Folder::new("ply");
    Scene::from_ply(folder.write("scene.ply", content))
}

fn scene(content: impl AsRef<[u8]>) -> Scene {
    read(content).unwrap()
}

fn corners(scene: &Scene) -> Vec<[Vec3; 3]> {
    scene.triangles().iter().map(|triangle| triangle.corners).collect()
}

/// Returns the line and the reason of the error that `content` gives.
#[track_caller]
fn error(content: impl AsRef<[u8]>) -> (Option<usize>, String) {
    match read(content) {
        Err(Error::Parse { line, reason, .. }) => (line, reason),
        other => panic!("not a file error: {other:?}"),
    }
}

const SQUARE: [[Vec3; 3]; 2] =
    [[Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0)], [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]];

#[test]
fn a_square_is_read_whatever_ends_its_lines() {
    let text = square("", [""; 4], "4 0 1 2 3");
    for text in
        [text.clone(), text.replace('\n', "\r\n"), text.replace('\n', "\r"), text.replace("0 0 0 \n", "\n0 0 0\n\n")]
    {
        assert_eq!(corners(&scene(&text)), SQUARE, "{text:?}");
    }
}

#[test]
fn normals_colours_and_texture_coordinates_reach_their_corners() {
    let properties = "property float nx\nproperty double ny\nproperty float nz\nproperty uchar red\nproperty uchar \
        green\nproperty \
                      uchar blue\nproperty uchar alpha\nproperty float s\nproperty float t\n";
    let values = ["0 0 2 255 0 0 9 0 0", "0 3 4 0 188 0 9 1 0", "0 0 1 0 0 255 9 1 1", "0 0 1 255 255 255 9 0 1"];
    let scene = scene(square(properties, values, "4 0 1 2 3"));
    assert_eq!(scene.triangles()[0].normals, [Vec3::Z, Vec3::new(0.0, 0.6, 0.8), Vec3::Z]);
    // The value 188 has half the light of 255 (IEC 61966-2-1: 0.5029).
    let [red, green, blue] = scene.colors()[0];
    assert_eq!((red, blue), (Vec3::X, Vec3::Z));
    assert!((green - Vec3::new(0.0, 0.502_886, 0.0)).length() < 1e-5, "{green}");
    assert_eq!(scene.uv()[1], [Vec2::ZERO, Vec2::ONE, Vec2::Y]);
    let floats = square(
        "property float r\nproperty float g\nproperty float b\n",
        ["1 0 0", "0 0.7372549 0", "0 0 1", "2 2 2"],
        "3 0 1 2",
    );
    assert!((self::scene(floats).colors()[0][1] - green).length() < 1e-6);
    let shorts = square(
        "property ushort r\nproperty ushort g\nproperty ushort b\n",
        ["65535 0 0", "0 48316 0", "0 0 65535", "0 0 0"],
        "3 0 1 2",
    );
    assert!((self::scene(shorts).colors()[0][1] - green).length() < 1e-5);
    // A zero normal has no direction.
    let flat = square(
        "property float nx\nproperty float ny\nproperty float nz\n",
        ["0 0 0", "0 0 1", "0 0 1", "0 0 1"],
        "4 0 1 2 3",
    );
    assert!(!self::scene(flat).has_normals());
}

/// Tests the square with each type of number, in both byte orders.
#[test]
fn binary_numbers_of_all_types_and_orders_are_read() {
    type Put = fn(f64) -> Vec<u8>; // big-endian
    let types: [(&str, Put); 8] = [
        ("char", |value| vec![value as i8 as u8]),
        ("uint8", |value| vec![value as u8]),
        ("short", |value| (value as i16).to_be_bytes().into()),
        ("ushort", |value| (value as u16).to_be_bytes().into()),
        ("int32", |value| (value as i32).to_be_bytes().into()),
        ("uint", |value| (value as u32).to_be_bytes().into()),
        ("float", |value| (value as f32).to_be_bytes().into()),
        ("float64", |value| value.to_be_bytes().into()),
    ];
    for (index, (name, put)) in types.into_iter().enumerate() {
        for (order, is_big) in [("big", true), ("little", false)] {
            let mut bytes = format!(
                "ply\nformat binary_{order}_endian 1.0\nelement noise 2\nproperty {name} skipped\nproperty list {name} \
                double \
                 also\nelement vertex 4\nproperty {name} x\nproperty list uchar {name} between\nproperty {name} \
                     y\nproperty \
                 {name} z\nelement face 1\nproperty {name} before\nproperty list {name} {name} \
                     vertex_index\nend_header\n"
            );
            if index > 5 {
                // Counts of lists are whole numbers.
                bytes = bytes.replace(&format!("list {name}"), "list uchar");
            }
            let mut bytes = bytes.into_bytes();
            let mut push = |put: Put, value: f64| {
                let mut number = put(value);
                if !is_big {
                    number.reverse();
                }
                bytes.extend(number);
            };
            let count = if index > 5 { types[1].1 } else { put };
            for _ in 0..2 {
                push(put, 7.0);
                push(count, 2.0);
                push(types[7].1, 1.5);
                push(types[7].1, 2.5);
            }
            for corner in [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y] {
                push(put, corner.x.into());
                push(types[1].1, 1.0);
                push(put, 9.0);
                push(put, corner.y.into());
                push(put, corner.z.into());
            }
            push(put, 3.0);
            push(count, 4.0);
            (0..4).for_each(|corner| push(put, corner.into()));
            assert_eq!(corners(&scene(&bytes)), SQUARE, "{name} {order}");
            bytes.pop();
            let (_, reason) = error(&bytes);
            assert!(reason.contains("face 0: the file ends before it"), "{reason}");
        }
    }
    let negative = "ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty float x\nproperty float \
        y\nproperty float z\nelement \
                    face 1\nproperty list char int vertex_index\nend_header\n\u{0}";
    let negative = [&negative.as_bytes()[..negative.len() - 1], &[0xff]].concat();
    assert!(error(negative).1.contains("face 0: a list has a negative count, -1"));
}

#[test]
fn polygons_are_split_by_ears_and_what_has_no_area_is_dropped() {
    // The face is an arrowhead whose first corner does not see the far wing.
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement \
        face \
                2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n2 1 0\n0 2 0\n1 1 0\n4 0 1 2 3\n3 0 0 \
                    1\n";
    let scene = scene(text);
    let area = |[a, b, c]: [Vec3; 3]| 0.5 * (b - a).cross(c - a).z;
    let areas: Vec<f32> = corners(&scene).into_iter().map(area).collect();
    assert_eq!((areas.iter().sum::<f32>(), scene.degenerate_count()), (1.0, 1));
    assert!(areas.iter().all(|&area| area >= 0.0), "{areas:?}");
}

#[test]
fn faults_are_named_with_their_line_or_element() {
    let square = |face: &str| square("", [""; 4], face);
    let good = square("4 0 1 2 3");
    for (content, line, expected) in [
        (String::new(), Some(1), "its first line is not `ply`"),
        ("solid ply\n".into(), Some(1), "its first line is not `ply`"),
        ("ply\n".into(), Some(2), "the header has no end_header"),
        ("ply\nend_header\n".into(), Some(2), "the header has no format"),
        (good.replace("1.0", "2.0"), Some(2), "'format ascii 2.0' is not supported; the format must have version 1.0"),
        (good.replace("ascii", "binary"), Some(2), "unknown format 'binary'; use ascii, binary_little_endian"),
        (good.replace("comment", "coment"), Some(3), "'coment made by hand' is not a header line"),
        (good.replace("vertex 4", "vertex many"), Some(5), "element vertex: 'many' is not a count"),
        (good.replace("vertex 4", "vertex -4"), Some(5), "element vertex: '-4' is not a count"),
        (good.replace("float y", "real y"), Some(7), "'real' is not a property type"),
        (good.replace("float y", "float x"), Some(7), "element vertex has two properties x"),
        (good.replace("face 1", "vertex 1"), Some(9), "there are two elements vertex"),
        (good.replace("float y", "float"), Some(7), "a property must have a type and a name"),
        (
            good.replace("list uchar", "list float"),
            Some(10),
            "property vertex_indices: a list's count must have an integer type",
        ),
        (good.replace("element vertex 4\n", ""), Some(5), "a property before the first element"),
        (good.replace("float z", "float w"), None, "vertex 0: there is no property z"),
        (square("4 0 1 2 4"), Some(16), "face 0: corner 4 is out of range for 4 vertices, numbered from 0"),
        (square("4 0 1 2 -1"), Some(16), "face 0: corner -1 is out of range for 4 vertices"),
        (square("4 0 1 2"), Some(16), "face 0: the line has too few values"),
        (square("4000000000 0 1 2"), Some(16), "face 0: the line has too few values"),
        (square("-3 0 1 2"), Some(16), "face 0: a list has a negative count, -3"),
        (square("3 0 1 2 3"), Some(16), "face 0: '3' follows its last value"),
        (square("3 0 1 2.5"), Some(16), "face 0: '2.5' is not a whole number"),
        (square("3 0 1 2,"), Some(16), "face 0: '2,' is not a number"),
        (square(""), Some(16), "face 0: the file ends before it"),
        (good.replace("\n1 1 0", "\n1 nan 0"), Some(14), "vertex 2: its y is NaN; it must be a finite number"),
        (good.replace("\n1 1 0", "\n1 1e99 0"), Some(14), "vertex 2: its y is inf"),
        (good.replace("\n1 1 0", "\n1 1e9 0"), None, "vertex 2: coordinate 1000000000 is beyond"),
        (
            good.replace("face 1", "face 0"),
            None,
            "it is a point cloud, with 4 vertices and no faces; a scene needs faces of 3 corners or more",
        ),
        (square("2 0 1"), None, "it is a point cloud, with 4 vertices and no faces"),
    ] {
        let (found, reason) = error(&content);
        assert!(reason.contains(expected), "{expected}: {reason}");
        // A missing property has no line.
        assert!(found == line || expected.contains("there is no property"), "{expected}: {found:?}");
    }
}

#[test]
fn what_pictures_do_not_show_is_named_once() {
    let folder = Folder::new("ply_left_out");
    let text = square("property uchar alpha\nproperty float confidence\n", ["1 1"; 4], "3 0 1 2\n2 0 1\n1 0")
        .replace("face 1", "face 3")
        .replace("comment made by hand", "comment TextureFile skin.png")
        .replace(
            "end_header",
            "element tristrips 0\nproperty list int int vertex_indices\nelement edge 0\nproperty int a\nend_header",
        );
    warnings::collect();
    Scene::from_ply(folder.write("scene.ply", text)).unwrap();
    let expected = "scene.ply: ignored: edges on line 15; 2 faces of fewer than three corners from line 23 on; \
                    opacities of vertices (alpha) on line 9; strips of triangles (tristrips) on line 13; texture files \
                    (comment TextureFile) on line 3; unknown properties of vertices on line 10";
    assert_eq!(warnings::of(&folder), [expected]);
}

#[test]
fn smooth_normals_are_made_where_they_are_asked_for() {
    let folder = Folder::new("ply_crease");
    let text = square("", [""; 4], "4 0 1 2 3").replace("\n1 1 0", "\n1 1 0.2");
    let path = folder.write("scene.ply", text);
    assert!(!Scene::from_ply(&path).unwrap().has_normals());
    let smooth = |degrees| Scene::from_ply_with(&path, &SceneOptions::default().crease_angle(Some(degrees)));
    assert!(smooth(30.0).unwrap().has_normals());
    assert!(smooth(300.0).unwrap_err().to_string().contains("crease angle: it is 300 degrees"));
}

/// The counts in a header take no memory and no time until the file has the data.
#[test]
fn a_header_that_promises_billions_is_answered_at_once() {
    let start = std::time::Instant::now();
    let vertex = "property float x\nproperty float y\nproperty float z\n";
    let face = "element face 4000000000\nproperty list uint int vertex_indices\n";
    for format in ["ascii", "binary_little_endian"] {
        let head = format!("ply\nformat {format} 1.0\n");
        for elements in [
            format!("element vertex 4000000000\n{vertex}"),
            format!("element vertex 18446744073709551615\n{vertex}"),
            "element vertex 4000000000\n".into(),
            format!("element vertex 0\n{vertex}{face}"),
            format!("element vertex 0\n{vertex}element none 4000000000\n"),
            format!("element many 4000000000\nproperty list uint double x\nelement vertex 0\n{vertex}"),
        ] {
            let message = read(format!("{head}{elements}end_header\n")).unwrap_err().to_string();
            assert!(
                message.contains("ends before it") || message.contains("no faces") || message.contains("no property"),
                "{message}"
            );
        }
        // The list declares about four thousand million entries, but the file contains only one.
        let list = format!("{head}element vertex 0\n{vertex}{face}end_header\n");
        let list =
            [list.as_bytes(), if format == "ascii" { b"4000000000 0" } else { &[255, 255, 255, 255, 0, 0, 0, 0] }]
                .concat();
        assert!(read(list).unwrap_err().to_string().contains("face 0: corner 0 is out of range for 0 vertices"));
    }
    assert!(start.elapsed().as_secs() < 5, "{:?}", start.elapsed());
}

#[test]
fn files_over_the_limit_are_not_read() {
    let folder = Folder::new("ply_limit");
    let path = folder.write("scene.ply", square("", [""; 4], "4 0 1 2 3"));
    let options = SceneOptions::default().limits(Limits::default().file_bytes(100).option_names("--max-file", ""));
    let message = Scene::from_ply_with(path, &options).unwrap_err().to_string();
    assert!(message.contains("over the limit of 100; raise it with --max-file"), "{message}");
}

/// Tests doubles in UTM coordinates, as scanners write them, which f32 rounds to half a unit.
#[test]
fn doubles_far_from_the_origin_keep_what_they_say() {
    let corners =
        [[500_000.125, 12.5, 5_400_000.062_5], [500_001.125, 12.5, 5_400_000.0], [500_000.5, 13.25, 5_400_000.0]];
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty double x\nproperty double \
        y\nproperty \
                  double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let mut bytes = header.as_bytes().to_vec();
    corners.iter().flatten().for_each(|value: &f64| bytes.extend(value.to_le_bytes()));
    bytes.push(3);
    (0..3i32).for_each(|corner| bytes.extend(corner.to_le_bytes()));
    let scene = scene(bytes);
    let found = scene.triangles()[0].corners.map(|corner| (scene.origin() + corner.as_dvec3()).to_array());
    assert_eq!(found, corners);
}

#[test]
fn more_triangles_than_the_limit_are_refused() {
    let folder = Folder::new("ply_triangles");
    let path = folder.write("scene.ply", square("", [""; 4], "4 0 1 2 3"));
    let read = |triangles| {
        let limits = Limits::default().triangles(triangles).triangle_option_name("--max-triangles");
        Scene::from_ply_with(&path, &SceneOptions::default().limits(limits))
    };
    assert_eq!(read(2).unwrap().triangles().len(), 2);
    let message = read(1).unwrap_err().to_string();
    assert!(
        message.contains("scene.ply: it has 2 triangles, over the limit of 1; raise it with --max-triangles"),
        "{message}"
    );
}

#[test]
fn names_200_000_of_them_take_no_square_of_time() {
    let started = std::time::Instant::now();
    let properties: String = (0..200_000).map(|number| format!("property uchar p{number}\n")).collect();
    let elements: String = (0..200_000).map(|number| format!("element e{number} 0\n")).collect();
    let content = square(&format!("element other 0\n{properties}{elements}"), [""; 4], "4 0 1 2 3");
    assert_eq!(scene(content).triangles().len(), 2);
    // This takes half a second. It took minutes when each name was compared with all before it.
    assert!(started.elapsed().as_secs() < 20, "{:?}", started.elapsed());
    for (header, expected) in [
        ("property float w\nproperty uchar w\n", "element vertex has two properties w"),
        ("element face 0\n", "there are two elements face"),
        ("element other 0\nproperty uchar x\n", ""),
    ] {
        let message =
            read(square(header, [""; 4], "4 0 1 2 3")).map_or_else(|error| error.to_string(), |_| String::new());
        assert!(message.contains(expected) && message.is_empty() == expected.is_empty(), "{message}");
    }
}
