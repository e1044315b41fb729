//! Tests files that can't be read: the error names the line.

use std::path::Path;

use stereotrace::{Error, Limits, Scene, SceneOptions};

use super::{Folder, SIX, common::random::Random};

#[test]
fn numbers_that_are_none_are_errors_on_their_line() {
    let folder = Folder::new("numbers");
    let cases = [
        ("v 1 x 0", "vertex: 'x' is not a number"),
        ("v 1 2", "vertex: 2 numbers instead of 3"),
        ("v 1", "vertex: 1 number instead of 3"),
        ("v", "vertex: 0 numbers instead of 3"),
        ("v 1 nan 0", "vertex: NaN is not a finite number"),
        ("v 0 0 1.#INF", "vertex: '1.#INF' is not a number"),
        ("v -1.#IND 0 0", "vertex: '-1.#IND' is not a number"),
        ("v -inf 0 0", "vertex: -inf is not a finite number"),
        ("v 1e39 0 0", "vertex: 1e39 is beyond ±1e8"),
        ("v 0 2e8 0", "is beyond ±1e8"),
        ("v 1 2 3 0", "vertex: the weight w is 0"),
        ("v 1 2 3 1e-9", "is beyond ±1e8"),
        ("v 1 2 3 4 5", "vertex: 5 numbers"),
        ("v 1 2 3 4 5 6 7", "vertex: 7 numbers"),
        ("v 1 2 3 nan 5 6", "vertex: colour NaN is not a finite number"),
        ("vt", "texture coordinates: 0 numbers instead of 2"),
        ("vt 0 up", "texture coordinates: 'up' is not a number"),
        ("vt nan 0", "texture coordinates: NaN is not a finite number"),
        ("vt 0 -inf 7", "texture coordinates: -inf is not a finite number"),
        ("vn 0 0", "normal: 2 numbers instead of 3"),
        ("vn 0 up 0", "normal: 'up' is not a number"),
        ("vn 0 nan 0", "normal: NaN is not a finite number"),
        ("vn 0 inf 0 x", "normal: inf is not a finite number"),
    ];
    for (line, expected) in cases {
        // A face uses each of these lines. A folded line before it counts as two lines.
        let face = match line.split(' ').next() {
            Some("vn") => "f 1//-1 2//-1 3//-1",
            Some("vt") => "f 1/-1 2/-1 3/-1",
            _ => "f 1 2 -1",
        };
        let vertices = if expected.contains("colour") { SIX.replace('\n', " 0 0 0\n") } else { SIX.into() };
        folder.fails_on_line(9, expected, format!("{vertices}f 1 2 \\\n 3\n{line}\n{face}\n"));
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
        ("f 1//1 2//1 3//2", "face corner '3//2': normal index 2 is out of range: there is 1 before this line"),
        // These offsets would wrap to small ones if they were multiplied by three unchecked.
        ("f 1//1 2//1 3//-2", "normal index -2 is out of range"),
        ("f 1//1 2//1 3//-5", "normal index -5 is out of range"),
        ("f 1//1 2//1 3//6148914691236517207", "is out of range"),
        ("f 1//0 2//1 3//1", "normal index 0; the first is 1"),
        ("f 1/1 2/1 3/1", "face corner '1/1': texture index 1 is out of range: there are 0 before this line"),
        ("f 1/-1 2/1 3/1", "texture index -1 is out of range"),
        ("f 1/0 2 3", "texture index 0; the first is 1"),
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
fn lines_are_counted_whatever_they_end_in() {
    let folder = Folder::new("line_ends");
    for end in ["\n", "\r\n", "\r"] {
        let text = format!("{SIX}\nv 1 2\n# more\nf 1 2 3\n").replace('\n', end);
        folder.fails_on_line(8, "vertex: 2 numbers instead of 3", text);
    }
}

#[test]
fn utf_16_is_named_and_so_is_the_remedy() {
    let folder = Folder::new("utf_16");
    let [obj, mtl] = [format!("mtllib m.mtl\n{SIX}f 1 2 3\n"), "newmtl red\nKd 1 0 0\n".into()];
    for (bytes_of, mark) in
        [(u16::to_le_bytes as fn(u16) -> [u8; 2], true), (u16::to_be_bytes, true), (u16::to_le_bytes, false)]
    {
        let encode = |text: &str| -> Vec<u8> {
            let text = format!("{}{text}", if mark { "\u{feff}" } else { "" });
            text.encode_utf16().flat_map(bytes_of).collect()
        };
        let name = if mark {
            "it is UTF-16 text, judging by its byte order mark; save it as UTF-8"
        } else {
            "it is UTF-16 text or binary data, judging by a zero byte at its start; save it as UTF-8"
        };
        assert_eq!(folder.error(encode(&obj)), (None, name.into()));
        folder.write("m.mtl", encode(&mtl));
        assert_eq!(folder.scene(&obj).materials().len(), 1);
        assert_eq!(
            folder.warnings().last(),
            Some(&format!("m.mtl: {name}; its materials are grey (line 1 of scene.obj)"))
        );
    }
}

#[test]
fn colours_of_vertices_that_are_none_are_errors() {
    let folder = Folder::new("colours");
    let faces = "f 1 2 3\n";
    folder.fails_on_line(2, "'red' is not a number", format!("v 1 0 0 1 1 1\nv 2 1 0 1 red 1\nv 3 0 1 1 1 1\n{faces}"));
    folder.fails_on_line(2, "vertex: 5 numbers; give", format!("v 1 0 0 1 1 1\nv 2 1 0 1 1\nv 3 0 1\n{faces}"));
    for obj in ["v 1 0 0 2\nv 2 1 0 1 1 1\nv 3 0 1\n", "v 1 0 0 2\nv 2 1 0\nv 3 0 1 1 1 1\n"] {
        folder.fails_on_line(1, "this vertex has a weight w, but others have colours", format!("{obj}{faces}"));
    }
}

#[test]
fn a_file_without_faces_is_an_error_that_says_so() {
    let folder = Folder::new("no_faces");
    for (content, vertices) in
        [("", 0), ("\n\n", 0), ("# nothing\n", 0), (SIX, 6), ("v 1 2 3\nl 1 1 1\nf 1 1\no x\n", 1)]
    {
        let (line, reason) = folder.error(content);
        assert_eq!(line, None);
        let vertices = if vertices == 1 { "1 vertex".into() } else { format!("{vertices} vertices") };
        assert!(reason.starts_with(&format!("no faces and {vertices};")), "{reason}");
    }
    let picture = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\xff\xfe\0".as_slice();
    assert!(folder.error(picture).1.starts_with("no faces"));
}

#[test]
fn a_missing_file_is_an_error_with_its_path() {
    let error = Scene::from_obj(Path::new("no/such/scene.obj")).unwrap_err();
    assert!(matches!(error, Error::Io { .. }) && error.to_string().contains("scene.obj"), "{error}");
}

/// Bytes of a valid file are replaced, doubled and cut at random. Any result is allowed except a panic.
#[test]
fn no_damaged_file_panics() {
    let folder = Folder::new("damaged");
    let mtl = "newmtl red\nKd 0.5 0.25 1\nKa 1 1 1\nNs 3\nmap_Kd a.png\nnewmtl green\nKd 0 1 0\n";
    let obj = format!(
        "mtllib m.mtl\no a\n{SIX}vt 0 1\nvn 0 0 1\nvn 0 1 0\nusemtl red\nf 1/1/1 2//2 -1/-1/-1 4\nf 1/1 2/1 3/1\nl 1 2 \
        3\ng b\n\
         usemtl green\nf 4 5 6 1\n"
    );
    #[cfg(feature = "textures")]
    image::RgbImage::new(1, 1).save(folder.file("a.png")).unwrap();
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
fn more_triangles_than_the_limit_are_refused() {
    let folder = Folder::new("triangle_limit");
    let content = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 2 3 4\nf 1 2\n";
    let read = |triangles| {
        let limits = Limits::default().triangles(triangles).triangle_option_name("--max-triangles");
        folder.read_with(content, &SceneOptions::default().limits(limits))
    };
    assert_eq!(read(3).unwrap().triangles().len(), 3);
    let message = read(2).unwrap_err().to_string();
    assert!(
        message.contains("scene.obj: it has 3 triangles, over the limit of 2; raise it with --max-triangles"),
        "{message}"
    );
}

#[test]
fn objects_200_000_of_them_take_no_square_of_time() {
    let folder = Folder::new("many_objects");
    let objects: String = (0..200_000).map(|object| format!("o {object}\nf 1/1 2/1 3/1\n")).collect();
    let started = std::time::Instant::now();
    let scene = folder.scene(format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n{objects}"));
    assert_eq!((scene.object_count(), scene.object_name(199_999)), (200_000, "199999"));
    // This takes half a second. It took a minute when each object was compared with all before it.
    assert!(started.elapsed().as_secs() < 20, "{:?}", started.elapsed());
}
