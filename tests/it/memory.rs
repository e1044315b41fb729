//! Tests scene files in memory: they give the same scenes, warnings and errors as files on the disk.
use crate::common;
use crate::common::gltf;

use std::{
    collections::BTreeMap,
    fs,
    hash::{DefaultHasher, Hasher},
    io::ErrorKind,
    path::Path,
};

use common::{folder::Folder, warnings};
use gltf::Builder;
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use serde_json::json;
use stereotrace::{Error, Limits, MissingTextures, SceneFile, SceneOptions, Texture};

/// Message for a file that is missing in memory. For a file on the disk, the message is the system's.
const MISSING: &str = "no such file among those in memory";

/// Names and bytes of files.
type Files<'a> = &'a [(&'a str, &'a [u8])];

fn png(pixels: &[[u8; 4]]) -> Vec<u8> {
    let (mut bytes, width) = (Vec::new(), pixels.len() as u32);
    PngEncoder::new(&mut bytes).write_image(pixels.as_flattened(), width, 1, ExtendedColorType::Rgba8).unwrap();
    bytes
}

fn hash(file: &SceneFile) -> u64 {
    let mut hasher = DefaultHasher::new();
    file.scene.content(|bytes| hasher.write(bytes));
    hasher.write(format!("{:?}", file.cameras).as_bytes());
    hasher.finish()
}

fn from_memory(name: &str, files: Files, options: &SceneOptions) -> Result<SceneFile, Error> {
    let files = files.iter().map(|(name, bytes)| ((*name).to_owned(), bytes.to_vec())).collect();
    SceneFile::from_memory(name, &files, options)
}

/// Result of reading a file, and the messages.
struct Outcome {
    result: Result<SceneFile, Error>,
    message: String,
    warnings: Vec<String>,
}

/// Reads the first file from the disk and from memory, and checks that both give the same scene and messages.
#[track_caller]
fn both(files: Files, options: &SceneOptions) -> Outcome {
    warnings::collect();
    let folder = Folder::new("memory");
    // The names contain a folder that only this test uses, so that the warnings of this test can be found.
    let [above, own] = [folder.path().parent(), folder.path().file_name().map(Path::new)].map(|path| path.unwrap());
    let (above, own) = (format!("{}/", above.display()), own.display().to_string());
    let mut given = BTreeMap::new();
    for (name, bytes) in files {
        folder.write(name, bytes);
        given.insert(format!("{own}/{name}"), bytes.to_vec());
    }
    let missing = fs::metadata(folder.file("none")).unwrap_err().to_string();
    let said = |result: &Result<SceneFile, Error>| match result {
        Ok(file) => format!("a scene: {:x}", hash(file)),
        Err(error) => error.to_string().replace(&above, "").replace(&missing, MISSING),
    };
    let logged = |prefix: &str| -> Vec<String> {
        let all = warnings::WARNINGS.lock().unwrap();
        let own = all.iter().filter_map(|text| text.strip_prefix(prefix)).filter(|text| text.starts_with(&own));
        own.map(|text| text.replace(&above, "").replace(&missing, MISSING)).collect()
    };
    let on_disk = SceneFile::open(folder.file(files[0].0), options);
    let result = SceneFile::from_memory(&format!("{own}/{}", files[0].0), &given, options);
    let (message, warnings) = (said(&result), logged(""));
    assert_eq!(message, said(&on_disk));
    assert_eq!(warnings, logged(&above));
    let tidy = |text: &String| text.replace(&format!("{own}/"), "");
    Outcome { result, message: tidy(&message), warnings: warnings.iter().map(tidy).collect() }
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";
const FACE: &str = "f 1/1 2/2 3/3\n";

/// Returns a glTF file as text, with its buffer and a picture in separate files.
fn gltf_files(buffer: &str, picture: &str) -> (String, Vec<u8>, Vec<u8>) {
    let mut builder = Builder::triangle(json!({}));
    builder.push("images", json!({ "uri": picture }));
    builder.push("textures", json!({ "source": 0 }));
    builder.json["materials"][0]["pbrMetallicRoughness"] = json!({ "baseColorTexture": { "index": 0 } });
    builder.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }));
    builder.node(json!({ "camera": 0, "name": "door", "translation": [0, 0, 3] }));
    builder.json["buffers"] = json!([{ "byteLength": builder.bytes.len(), "uri": buffer }]);
    (serde_json::to_string_pretty(&builder.json).unwrap(), builder.bytes, png(&[[1, 2, 3, 255], [9, 8, 7, 255]]))
}

#[test]
fn an_obj_with_mtl_files_and_textures_is_the_same_scene() {
    let obj =
        format!("mtllib sub/a.mtl  sub\\b.mtl\n{TRIANGLE}usemtl wood\n{FACE}usemtl plank\n{FACE}usemtl leaf\n{FACE}");
    let mtl =
        "newmtl wood\nmap_Kd ../tex/./wood.png\nmap_d ..\\tex\\wood.png\nnewmtl plank\nmap_Kd ../tex/../tex/wood.png\n";
    let files: [(&str, &[u8]); 5] = [
        ("house.obj", obj.as_bytes()),
        ("sub/a.mtl", mtl.as_bytes()),
        ("sub/b.mtl", b"newmtl leaf\nKd 0 1 0\nmap_Kd -clamp on a leaf.png\n"),
        ("tex/wood.png", &png(&[[200, 100, 50, 255], [1, 2, 3, 255]])),
        ("sub/a leaf.png", &png(&[[9; 4]])),
    ];
    let Outcome { result, warnings, .. } = both(&files, &SceneOptions::default());
    let scene = result.unwrap().scene;
    // The wood is used once unchanged, and once with its brightness as alpha.
    assert_eq!((scene.textures().len(), scene.materials().len(), warnings.len()), (3, 4, 0), "{warnings:?}");
    assert!(both(&files, &SceneOptions::default().crease_angle(Some(30.0))).result.is_ok());
}

#[test]
fn gltf_files_with_files_beside_them_and_in_one_are_the_same_scene() {
    let (text, buffer, picture) = gltf_files("data/house%20one.bin", "data\\wood.png");
    let files: [(&str, &[u8]); 3] =
        [("house.gltf", text.as_bytes()), ("data/house one.bin", &buffer), ("data/wood.png", &picture)];
    let file = both(&files, &SceneOptions::default()).result.unwrap();
    assert_eq!((file.scene.textures().len(), &*file.cameras[0].0), (1, "door"));
    let mut builder = Builder::triangle(json!({}));
    let texture = builder.texture(&picture);
    builder.json["materials"][0]["pbrMetallicRoughness"] = json!({ "baseColorTexture": { "index": texture } });
    for content in [builder.binary(), builder.text().into_bytes()] {
        // The content determines the format, not the file's name.
        let file = both(&[("house", &content)], &SceneOptions::default()).result.unwrap();
        assert_eq!(file.scene.textures().len(), 1);
    }
}

#[test]
fn a_ply_file_is_the_same_scene_with_the_same_warnings() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty \
        float w\n\
               element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 7\n1 0 0 7\n0 1 0 7\n3 0 1 \
                   2\n";
    let Outcome { result, warnings, .. } = both(&[("a.PLY", ply.as_bytes())], &SceneOptions::default());
    assert_eq!(result.unwrap().scene.triangles().len(), 1);
    assert_eq!(warnings, ["a.PLY: ignored: unknown properties of vertices on line 7"]);
}

#[test]
fn faults_are_named_as_those_of_files_on_the_disk_are() {
    let at_line_8 = format!("{TRIANGLE}{FACE}f 1 2 9\n");
    let utf_16: Vec<u8> = TRIANGLE.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let (text, buffer, picture) = gltf_files("a.bin", "a.png");
    let (text, short) = (text.as_bytes(), &buffer[..40]);
    let mtl = format!("mtllib a.mtl\n{TRIANGLE}usemtl a\n{FACE}");
    let mtl = mtl.as_bytes();
    let cases: [(Files, &str); 14] = [
        (&[("a.obj", at_line_8.as_bytes())], "a.obj:8: "),
        (&[("a.obj", &utf_16)], "a.obj: it is UTF-16 text or binary data"),
        (&[("a.obj", b"")], "a.obj: no faces and 0 vertices"),
        (&[("a.stl", b"solid")], "unknown ending of a scene file 'stl'"),
        (&[("a.ply", b"ply\nformat binary 1.0\n")], "a.ply:2: "),
        (&[("a.gltf", b"{\n\"asset\": 7 }")], "a.gltf:2: invalid glTF JSON"),
        (&[("a.glb", b"glTF\x02\0\0\0\x0c\0\0\0")], "a.glb: it has no JSON chunk"),
        (&[("a.gltf", text), ("a.png", &picture)], "a.gltf: buffers[0]: a.bin: no such file"),
        (&[("a.gltf", text), ("a.bin", short), ("a.png", &picture)], "a.gltf: buffers[0]: its byteLength is"),
        (&[("a.gltf", text), ("a.bin", &buffer)], "baseColorTexture: a.png: no such file"),
        (&[("a.gltf", text), ("a.bin", &buffer), ("a.png", &picture[..30])], "can't read the texture"),
        (
            &[("a.obj", mtl), ("a.mtl", b"newmtl a\nmap_Kd tex\\a.png")],
            "a.mtl:2: map_Kd 'tex\\a.png' of material 'a': no",
        ),
        (&[("a.obj", mtl), ("a.mtl", b"newmtl a\nmap_Kd a.png"), ("a.png", b"text")], "it is not PNG"),
        (&[("a.obj", mtl), ("a.mtl", b"newmtl a\nmap_Kd ./a.obj")], "it is the OBJ file itself"),
    ];
    for (files, expected) in cases {
        let Outcome { result, message, .. } = both(files, &SceneOptions::default());
        assert!(result.is_err() && message.contains(expected), "{expected}: {message}");
    }
}

#[test]
fn what_is_left_out_is_warned_of_as_on_the_disk() {
    let obj = format!("mtllib none.mtl\nmtllib wide.mtl\nmtllib a.mtl\n{TRIANGLE}usemtl a\n{FACE}l 1 2\n");
    let wide: Vec<u8> = "newmtl b\n".encode_utf16().flat_map(u16::to_be_bytes).collect();
    let mtl = "newmtl a\nmap_Kd gone.png\nKd 0.5 0.5 0.5\nnonsense\n";
    let warn = SceneOptions::default().missing_textures(MissingTextures::Warn);
    let files: [(&str, &[u8]); 3] = [("a.obj", obj.as_bytes()), ("wide.mtl", &wide), ("a.mtl", mtl.as_bytes())];
    let Outcome { result, warnings, .. } = both(&files, &warn);
    assert_eq!(result.unwrap().scene.textures().len(), 0);
    let expected = [
        "none.mtl: no such file among those in memory; its materials are grey (line 1 of a.obj)",
        "wide.mtl: it is UTF-16 text or binary data",
        "a.mtl:2: map_Kd 'gone.png' of material 'a': no such file among those in memory; the material is rendered \
         without it",
        "a.mtl: ignored: unknown statements on line 4",
        "a.obj: ignored: lines (l) on line 12",
    ];
    assert_eq!(warnings.len(), expected.len(), "{warnings:?}");
    for (found, expected) in warnings.iter().zip(expected) {
        assert!(found.starts_with(expected), "{found}");
    }
    let (text, buffer, _) = gltf_files("a.bin", "gone.png");
    let Outcome { result, warnings, .. } = both(&[("a.gltf", text.as_bytes()), ("a.bin", &buffer)], &warn);
    assert_eq!(result.unwrap().scene.textures().len(), 0);
    assert!(warnings[0].ends_with("gone.png: no such file among those in memory; the material is rendered without it"));
}

#[test]
fn limits_hold_as_they_do_on_the_disk() {
    let said = |files: Files, limits: Limits| both(files, &SceneOptions::default().limits(limits)).message;
    let limit = |bytes: usize| Limits::default().file_bytes(bytes as u64).option_names("--max-file", "--max-sky");
    let obj = format!("mtllib a.mtl b.mtl\n{TRIANGLE}usemtl a\n{FACE}");
    let mtl = format!("newmtl a\nmap_Kd a.png\n{}", "#".repeat(100));
    let pixels = [[9, 8, 7, 255]; 10];
    let picture = png(&pixels);
    let files: [(&str, &[u8]); 4] =
        [("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes()), ("b.mtl", mtl.as_bytes()), ("a.png", &picture)];
    let message = said(&files, limit(obj.len() - 1));
    let expected = format!("a.obj: the file has {} bytes, over the limit of {}", obj.len(), obj.len() - 1);
    assert!(message.starts_with(&expected) && message.contains("raise it with --max-file"), "{message}");
    // All MTL files share one limit.
    let warnings = both(&files, &SceneOptions::default().limits(limit(mtl.len() + 9))).warnings;
    assert!(warnings[0].starts_with("b.mtl: the file has 122 bytes, over the limit of 9"), "{warnings:?}");
    let message = said(&files, limit(1 << 20).texture_pixels(9));
    assert!(message.contains("a.mtl:2: map_Kd 'a.png' of material 'a': the picture has 10x1 pixels"), "{message}");
    let large = [&*picture, &[0; 500]].concat();
    let message = said(&[files[0], files[1], ("a.png", &large)], limit(300));
    assert!(message.contains(&format!("the file has {} bytes, over the limit of 300", large.len())), "{message}");
    // All buffers share one limit too.
    let (text, buffer, picture) = gltf_files("a.bin", "a.png");
    let buffer = [buffer, vec![0; text.len()]].concat();
    let files: [(&str, &[u8]); 3] = [("a.gltf", text.as_bytes()), ("a.bin", &buffer), ("a.png", &picture)];
    let message = said(&files, limit(text.len()));
    assert!(message.starts_with(&format!("a.bin: the file has {} bytes", buffer.len())), "{message}");
    let message = said(&files, limit(1 << 20).json_bytes(9));
    assert!(message.contains("outside strings, over the limit of 9"), "{message}");
}

#[test]
fn files_without_their_folders_are_found_by_their_names() {
    let options = SceneOptions::default();
    let obj = format!("mtllib lib/a.mtl lib/B.mtl\n{TRIANGLE}usemtl a\n{FACE}usemtl b\n{FACE}");
    let (a, b) = ("newmtl a\nmap_Kd C:\\tex\\Wood.PNG\n", "newmtl b\nmap_Kd /home/me/tex/leaf.png\n");
    let (wood, leaf) = (png(&[[1, 2, 3, 255]]), png(&[[4, 5, 6, 255]]));
    let flat: [(&str, &[u8]); 5] = [
        ("house.obj", obj.as_bytes()),
        ("a.mtl", a.as_bytes()),
        ("b.mtl", b.as_bytes()),
        ("wood.png", &wood),
        ("leaf.png", &leaf),
    ];
    let found = from_memory("house.obj", &flat, &options).unwrap();
    assert_eq!(found.scene.textures().len(), 2);
    // The scene equals the one whose files are at their named paths.
    let (a, b) = (a.replace("C:\\tex\\Wood.PNG", "../wood.png"), b.replace("/home/me/tex/leaf.png", "leaf.png"));
    let placed: [(&str, &[u8]); 5] =
        [flat[0], ("lib/a.mtl", a.as_bytes()), ("lib/B.mtl", b.as_bytes()), flat[3], ("lib/leaf.png", &leaf)];
    assert_eq!(hash(&found), hash(&both(&placed, &options).result.unwrap()));
    // A second picture with this name makes the name ambiguous.
    let twice: Vec<_> = flat.into_iter().chain([("old/Wood.png", &*leaf)]).collect();
    let message = from_memory("house.obj", &twice, &options).unwrap_err().to_string();
    assert_eq!(message, format!("a.mtl:2: map_Kd 'C:\\tex\\Wood.PNG' of material 'a': {MISSING}"));
    // A name with spaces is one name.
    let obj = format!("mtllib lib/my house.mtl\n{TRIANGLE}usemtl a\n{FACE}");
    let files: [(&str, &[u8]); 2] = [("house.obj", obj.as_bytes()), ("My house.mtl", b"newmtl a\nKd 1 0 0\n")];
    assert_eq!(from_memory("house.obj", &files, &options).unwrap().scene.materials().len(), 2);
    // Paths may have the forms that browsers and Windows use. The name of the main file may have any of these forms.
    let (text, buffer, picture) = gltf_files("data/a.bin", "../tex/a%2Bb.png");
    let files: [(&str, &[u8]); 3] = [
        ("/town/house/a.gltf", text.as_bytes()),
        ("town\\house\\data\\a.bin", &buffer),
        ("/town/tex/a+b.png", &picture),
    ];
    for name in ["/town/house/a.gltf", "town/house/a.gltf", "town\\house\\a.gltf", "./town/x/../house/a.gltf"] {
        assert_eq!(from_memory(name, &files, &options).unwrap().scene.textures().len(), 1, "{name}");
    }
}

#[test]
fn a_main_file_that_is_missing_is_an_error() {
    for name in ["a.obj", "a.gltf", "a.ply", "", "/", "..", "A.OBJ/", "b\\a.obj", "\u{0}"] {
        let files: [(&str, &[u8]); 2] = [("", b""), ("sub/a.obj", b"f 1 2 3")];
        for files in [&files[1..], &files[..0]] {
            let error = from_memory(name, files, &SceneOptions::default()).unwrap_err();
            let Error::Io { path, source, .. } = error else { panic!("{error}") };
            assert_eq!((path, source.kind()), (name.replace('\\', "/").into(), ErrorKind::NotFound));
        }
        let _ = from_memory(name, &files, &SceneOptions::default());
    }
}

#[test]
fn pictures_are_read_from_bytes() {
    let folder = Folder::new("memory_pictures");
    let bytes = png(&[[9, 8, 7, 255], [6, 5, 4, 255]]);
    let path = folder.write("a.png", &bytes);
    let read = |bytes: &[u8], limits: &Limits| Texture::from_bytes("a.png", bytes, limits);
    assert_eq!(read(&bytes, &Limits::default()).unwrap(), Texture::open(&path).unwrap());
    let said = |limits: &Limits| {
        let messages =
            [read(&bytes, limits), Texture::open_within(&path, limits)].map(|found| found.unwrap_err().to_string());
        assert!(messages[1].ends_with(&messages[0]), "{messages:?}");
        messages[0].clone()
    };
    assert!(said(&Limits::default().file_bytes(9)).starts_with("a.png: the file has"));
    assert!(said(&Limits::default().texture_pixels(1)).starts_with("a.png: the picture has 2x1 pixels"));
    assert!(read(b"", &Limits::default()).unwrap_err().to_string().starts_with("a.png: can't read the texture"));
    #[cfg(feature = "sky")]
    {
        use stereotrace::SkyMap;

        let read = |limits: &Limits| SkyMap::from_bytes("a.png", &bytes, limits);
        assert!(read(&Limits::default()).unwrap() == SkyMap::open(&path).unwrap());
        for limits in [Limits::default().file_bytes(9), Limits::default().sky_pixels(1)] {
            let messages =
                [read(&limits), SkyMap::open_within(&path, &limits)].map(|found| found.unwrap_err().to_string());
            assert!(messages[0].starts_with("a.png: the ") && messages[1].ends_with(&messages[0]), "{messages:?}");
        }
    }
}
