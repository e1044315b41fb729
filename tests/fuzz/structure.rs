//! Tests small files in which many parts refer to one large item, or which declare much more content than they have.
//! Each file is made by a rule with random choices. A separate process reads it, with bounds on memory and time.

use std::{
    fmt::Write,
    fs,
    path::Path,
    process::{Command, Stdio},
    time::{Duration, Instant},
};

use serde_json::{Value, json};
use stereotrace::{Limits, MissingTextures, SceneFile, SceneOptions};

use crate::{
    Files, below,
    folder::Folder,
    gltf::{Builder, binary, data_uri},
    random::{Random, pcg},
    status, write,
};

/// Size of the files, limits on the decoded triangles and pixels, and maximum time to read a file.
struct Size {
    bytes: usize,
    triangles: u64,
    pixels: u64,
    longest: Duration,
}

const SMALL: Size = Size { bytes: 64 << 10, triangles: 20_000, pixels: 1 << 16, longest: Duration::from_secs(5) };
const LARGE: Size = Size { bytes: 1 << 20, triangles: 1 << 18, pixels: 1 << 22, longest: Duration::from_secs(10) };

/// Allowed memory per byte of a file, in addition to the memory of the decoded content.
const BYTES_PER_BYTE: u64 = 200;
/// Allowed memory per triangle. A triangle takes some 140 bytes with normals, colours and texture coordinates. It takes
/// twice as much while triangles are moved into the scene.
const TRIANGLE_BYTES: u64 = 300;
/// Allowed memory per pixel while it is decoded.
const PIXEL_BYTES: u64 = 24;
/// Memory that the allocator keeps.
const SPARE_BYTES: u64 = 8 << 20;
/// Maximum memory of the reading process. The system ends a process that needs more.
const MOST_KIBIBYTES: u64 = 6 << 20;

/// A rule that makes files of about `Size::bytes` bytes, with a picture of `Size::pixels` pixels.
type Make = fn(&mut Random, &Size) -> Files;

const STRUCTURES: [(&str, Make); 40] = [
    ("obj: objects", obj_objects),
    ("obj: one long name, many sections", obj_long_name),
    ("obj: materials of one picture", obj_materials),
    ("obj: materials of one broken picture", obj_broken_picture),
    ("obj: a material of a long name with many faults", obj_faults),
    ("obj: libraries", obj_libraries),
    ("obj: polygons", obj_polygons),
    ("obj: curves and unknown lines", obj_lines),
    ("gltf: a mesh of a long name at many nodes", |random, size| gltf_long_name(random, size, "mesh")),
    ("gltf: a camera of a long name at many nodes", |random, size| gltf_long_name(random, size, "camera")),
    ("gltf: alpha cut-offs of one picture", gltf_cutoffs),
    ("gltf: veils of one picture", gltf_veils),
    ("gltf: images of one picture", gltf_images),
    ("gltf: images of pieces of one picture", gltf_pieces),
    ("gltf: materials of one broken picture", gltf_broken_pictures),
    ("gltf: pictures that are not there", gltf_missing_pictures),
    ("gltf: a sparse accessor without data", gltf_sparse),
    ("gltf: empty objects", gltf_empty),
    ("gltf: values without a meaning", gltf_values),
    ("gltf: primitives of one accessor", gltf_primitives),
    ("gltf: meshes of one accessor", gltf_meshes),
    ("gltf: vertices without triangles", gltf_vertices),
    ("gltf: nodes of one mesh", gltf_nodes),
    ("gltf: buffers of one file", gltf_buffers),
    ("gltf: a child many times", gltf_children),
    ("gltf: nodes in nodes", gltf_nested),
    ("gltf: lights and extensions", gltf_lights),
    ("gltf: morph targets of one accessor", gltf_targets),
    ("gltf: nodes of one mesh with many morph targets", gltf_weights),
    ("gltf: nodes of one skin with many joints", gltf_skins),
    ("gltf: channels of one sampler", gltf_channels),
    ("gltf: sets of joints of one accessor", gltf_joint_sets),
    ("gltf: morph targets of overlapping accessors", gltf_overlapping_targets),
    ("gltf: samplers of overlapping accessors", gltf_overlapping_samplers),
    ("ply: names of properties", ply_properties),
    ("ply: names of elements", ply_elements),
    ("ply: small faces", ply_faces),
    ("ply: polygons", ply_polygons),
    ("ply: elements of nothing", ply_nothing),
    ("ply: lists", ply_lists),
];

#[test]
fn many_small_things_that_name_a_large_one() {
    try_all(2, &SMALL);
}

/// This takes some minutes: `cargo test --test fuzz large_structures -- --ignored --nocapture`.
/// `STEREOTRACE_FUZZ_ROUNDS` sets the number of rounds, 3 by default. `STEREOTRACE_FUZZ_STRUCTURE` chooses structures
/// by a part of their names.
#[test]
#[ignore = "minutes; its small form is the test above"]
fn large_structures() {
    let rounds = std::env::var("STEREOTRACE_FUZZ_ROUNDS").map_or(3, |rounds| rounds.parse().expect("a number"));
    try_all(rounds, &LARGE);
}

/// Reads the file named by the environment variable, as the child process of [`try_one`].
#[test]
#[ignore = "a process of its own, which the tests above start"]
fn read_one() {
    let Ok(path) = std::env::var("STEREOTRACE_FUZZ_FILE") else { return };
    let number = |name: &str| std::env::var(name).ok().and_then(|value| value.parse().ok());
    let mut limits = Limits::default();
    if let Some(triangles) = number("STEREOTRACE_FUZZ_TRIANGLES") {
        limits = limits.triangles(triangles);
    }
    if let Some(pixels) = number("STEREOTRACE_FUZZ_PIXELS") {
        limits = limits.texture_pixels(pixels);
    }
    let options =
        SceneOptions::default().limits(limits).missing_textures(MissingTextures::Warn).crease_angle(Some(30.0));
    let before = memory("VmRSS:");
    let started = Instant::now();
    let outcome = match SceneFile::open(&path, &options) {
        Ok(file) => {
            // This also tests `content`, which programs call to hash a scene.
            let mut bytes = 0;
            file.scene.content(|piece| bytes += piece.len());
            let triangles = file.scene.triangles().len();
            crate::play(file);
            format!("a scene of {triangles} triangles and {bytes} bytes")
        }
        Err(error) => error.to_string(),
    };
    let taken = memory("VmHWM:").saturating_sub(before);
    // Processor time is used, since it does not depend on the load by other programs.
    let time = processor_time().unwrap_or(started.elapsed());
    println!("\nread in {} ms by {taken} bytes: {outcome}", time.as_millis());
}

/// Returns the processor time of this process, if the system reports it. Its resolution is a hundredth of a second.
fn processor_time() -> Option<Duration> {
    let stat = fs::read_to_string("/proc/self/stat").ok()?;
    let mut fields = stat.rsplit_once(") ")?.1.split(' ').skip(11).map(|field| field.parse::<u64>());
    Some(Duration::from_millis(10 * (fields.next()?.ok()? + fields.next()?.ok()?)))
}

/// Returns a memory figure of this process, or 0 if the system doesn't report it.
fn memory(field: &str) -> u64 {
    if cfg!(target_os = "linux") { status(field) } else { 0 }
}

fn try_all(rounds: u32, size: &Size) {
    let chosen = std::env::var("STEREOTRACE_FUZZ_STRUCTURE").unwrap_or_default();
    let folder = Folder::new("fuzz_structure");
    let (mut count, mut faults) = (0, Vec::new());
    for (number, (name, make)) in (0..).zip(STRUCTURES).filter(|(_, (name, _))| name.contains(&chosen)) {
        for round in 0..rounds {
            let files = make(&mut Random(pcg(1000 * number + round)), size);
            count += 1;
            if let Err(fault) = try_one(&folder, &files, size) {
                faults.push(format!("{name}, round {round}: {fault}"));
            }
        }
    }
    println!("{count} files; {} at fault", faults.len());
    assert!(faults.is_empty() && count > 0, "{}", faults.join("\n"));
}

/// Reads files in a separate process, within the bounds.
fn try_one(folder: &Folder, files: &Files, size: &Size) -> Result<(), String> {
    let (path, bytes) = write(folder, files);
    let output = folder.file("output.txt");
    let mut child = reader(&path, size, &output).spawn().expect("this test's own program");
    let started = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if started.elapsed() > 4 * size.longest {
            child.kill().unwrap();
            child.wait().unwrap();
            return Err(format!("{bytes} bytes are not read in {:?}", started.elapsed()));
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let said = fs::read_to_string(&output).unwrap();
    let line = said.lines().find(|line| line.starts_with("read in "));
    let line = line.filter(|_| status.success()).ok_or_else(|| format!("{bytes} bytes: {status}: {said}"))?;
    let line: String = line.chars().take(300).collect();
    let number = |word: usize| line.split(' ').nth(word).unwrap().parse::<u64>().unwrap();
    let (milliseconds, taken) = (number(2), number(5));
    println!("  {bytes} bytes {line}");
    let most = BYTES_PER_BYTE * bytes + TRIANGLE_BYTES * size.triangles + PIXEL_BYTES * size.pixels + SPARE_BYTES;
    match (taken <= most, u128::from(milliseconds) <= size.longest.as_millis()) {
        (true, true) => Ok(()),
        _ => Err(format!("{bytes} bytes, at most {most} of memory: {line}")),
    }
}

fn reader(path: &Path, size: &Size, output: &Path) -> Command {
    let own = std::env::current_exe().unwrap();
    let mut command = if cfg!(target_os = "linux") {
        let mut command = Command::new("sh");
        command.arg("-c").arg(format!("ulimit -v {MOST_KIBIBYTES}; exec \"$0\" \"$@\"")).arg(own);
        command
    } else {
        Command::new(own)
    };
    let both = fs::File::create(output).unwrap();
    command.args(["--exact", "structure::read_one", "--ignored", "--nocapture"]);
    command.env("STEREOTRACE_FUZZ_FILE", path).env("RUST_BACKTRACE", "0");
    command.env("STEREOTRACE_FUZZ_TRIANGLES", size.triangles.to_string());
    command.env("STEREOTRACE_FUZZ_PIXELS", size.pixels.to_string());
    command.stdin(Stdio::null()).stderr(both.try_clone().unwrap()).stdout(both);
    command
}

/// Returns a square picture with as many pixels as the limit allows, in bands of every alpha value. The file is about a
/// thousand times smaller than its pixels.
fn picture(size: &Size) -> Vec<u8> {
    let side = size.pixels.isqrt() as usize;
    let pixels: Vec<u8> = (0..side).flat_map(|row| [200, (256 * row / side) as u8].repeat(side)).collect();
    let mut bytes = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new_with_quality(
        &mut bytes,
        image::codecs::png::CompressionType::Best,
        image::codecs::png::FilterType::NoFilter,
    );
    let side = side as u32;
    image::ImageEncoder::write_image(encoder, &pixels, side, side, image::ExtendedColorType::La8).unwrap();
    bytes
}

/// Returns a picture that ends before its last pixels.
fn broken_picture(size: &Size) -> Vec<u8> {
    let mut bytes = picture(size);
    bytes.truncate(bytes.len() * 9 / 10);
    bytes
}

/// Returns a name that takes at most half of the allowed bytes.
fn long_name(random: &mut Random, size: &Size) -> String {
    let letter = ["a", "é", " x", "\u{1}"][below(random, 4)];
    letter.repeat(((size.bytes / 2) >> below(random, 4)) / letter.len())
}

fn one_of<'a>(random: &mut Random, words: &[&'a str]) -> &'a str {
    words[below(random, words.len())]
}

// --- OBJ ---

const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvn 0 0 1\n";

fn obj_objects(random: &mut Random, size: &Size) -> Files {
    let mut obj = String::from(CORNERS);
    let keyword = one_of(random, &["o", "g", "o\ng", "usemtl a\no", "o\ns 1"]);
    let named = random.unit() < 0.5;
    let face = one_of(random, &["1 2 3", "1/1 2/1 3/1", "1 1 1", "1//1 2//1 3//1", "1 2 3 4"]);
    for number in 0.. {
        let name = if named { number.to_string() } else { String::new() };
        let _ = writeln!(obj, "{keyword} {name}\nf {face}");
        if obj.len() > size.bytes {
            break;
        }
    }
    vec![("scene.obj".into(), obj.into())]
}

fn obj_long_name(random: &mut Random, size: &Size) -> Files {
    let mut obj = format!("{CORNERS}{} {}\n", one_of(random, &["o", "g"]), long_name(random, size));
    let more = one_of(random, &["", "g\n", "s 1\n", "usemtl a\n"]);
    while obj.len() < size.bytes {
        obj += "f 1 2 3\nf 1//1 2//1 3//1\n";
        obj += more;
    }
    vec![("scene.obj".into(), obj.into())]
}

/// Makes an OBJ with as many materials as the size allows, and an MTL with these lines for each material.
fn obj_with(size: &Size, lines: impl Fn(usize) -> String) -> Files {
    let (mut obj, mut mtl) = (format!("mtllib scene.mtl\n{CORNERS}"), String::new());
    for number in 0.. {
        let _ = writeln!(obj, "usemtl {number}\nf 1/1 2/1 3/1");
        let _ = writeln!(mtl, "newmtl {number}\n{}", lines(number));
        if obj.len() + mtl.len() > size.bytes {
            break;
        }
    }
    vec![("scene.obj".into(), obj.into()), ("scene.mtl".into(), mtl.into())]
}

fn obj_materials(random: &mut Random, size: &Size) -> Files {
    let statement = one_of(random, &["map_Kd", "map_d", "map_Kd a.png\nmap_d"]);
    let by_path = random.unit() < 0.5;
    let mut files = obj_with(size, |number| {
        let option = ["", "-clamp on ", "-s 2 2 ", "-o 0.5 0 "][number % 4];
        let path = if by_path { "./".repeat(number % 50) } else { String::new() };
        format!("{statement} {option}{path}a.png")
    });
    files.push(("a.png".into(), picture(size)));
    files
}

fn obj_broken_picture(random: &mut Random, size: &Size) -> Files {
    let statement = one_of(random, &["map_Kd", "map_d"]);
    let mut files = obj_with(size, |_| format!("{statement} a.png"));
    files.push(("a.png".into(), broken_picture(size)));
    files
}

fn obj_faults(random: &mut Random, size: &Size) -> Files {
    let name = long_name(random, size);
    let mut mtl = format!("newmtl {name}\n");
    let fault = one_of(random, &["Kd x", "Ns nan", "map_Kd", "d", "illum 99", "map_Kd none.png"]);
    while mtl.len() < size.bytes {
        mtl += fault;
        mtl += "\n";
    }
    let obj = format!("mtllib scene.mtl\n{CORNERS}usemtl a\nf 1 2 3\n");
    vec![("scene.obj".into(), obj.into()), ("scene.mtl".into(), mtl.into())]
}

fn obj_libraries(random: &mut Random, size: &Size) -> Files {
    let names = one_of(random, &["a.mtl", "b.mtl", "./a.mtl"]);
    let apart = one_of(random, &[" ", "\nmtllib "]);
    let mut obj = String::from("mtllib a.mtl");
    for number in 0.. {
        let _ = write!(obj, "{apart}{}{names}", "./".repeat(number % 9));
        if obj.len() > size.bytes / 2 {
            break;
        }
    }
    let _ = write!(obj, "\n{CORNERS}f 1 2 3\n");
    let mtl = "newmtl a\nKd 1 1 1\n".repeat(size.bytes / 40);
    vec![("scene.obj".into(), obj.into()), ("a.mtl".into(), mtl.into())]
}

fn obj_polygons(random: &mut Random, size: &Size) -> Files {
    let mut obj = String::new();
    let vertices = 3 + below(random, 200);
    for _ in 0..vertices {
        let _ = writeln!(obj, "v {:.2} {:.2} 0", random.unit(), random.unit());
    }
    let corners = 3 + below(random, size.bytes);
    while obj.len() < size.bytes {
        obj += "f";
        for _ in 0..corners {
            let _ = write!(obj, " {}", 1 + below(random, vertices));
            if obj.len() > size.bytes {
                break;
            }
        }
        obj += " 1 2 3\n";
    }
    vec![("scene.obj".into(), obj.into())]
}

fn obj_lines(random: &mut Random, size: &Size) -> Files {
    let line =
        one_of(random, &["l 1 2", "p 1", "curv 1", "x", "s 3", "f 1 2", "usemtl", "mtllib", "\\", "vt 1", "v 0 0 0"]);
    let obj = format!("{CORNERS}f 1 2 3\n{}", format!("{line}\n").repeat(size.bytes / (line.len() + 1)));
    vec![("scene.obj".into(), obj.into())]
}

// --- glTF ---

/// Returns the files of a scene. They are a text file with the buffer in a URI, a binary file, or a text file with the
/// buffer in a separate file.
fn file_of(random: &mut Random, builder: &Builder) -> Files {
    match below(random, 3) {
        0 => vec![("scene.gltf".into(), builder.text().into())],
        1 => vec![("scene.glb".into(), builder.binary())],
        _ => {
            let mut json = builder.json.clone();
            json["buffers"] = json!([{ "byteLength": builder.bytes.len(), "uri": "scene.bin" }]);
            vec![("scene.gltf".into(), serde_json::to_vec(&json).unwrap()), ("scene.bin".into(), builder.bytes.clone())]
        }
    }
}

/// Returns how many items of `each` bytes fit in the remaining bytes.
fn count(size: &Size, taken: usize, each: usize) -> usize {
    size.bytes.saturating_sub(taken) / each
}

fn list(item: Value, count: usize) -> Value {
    Value::Array(vec![item; count])
}

fn gltf_long_name(random: &mut Random, size: &Size, what: &str) -> Files {
    let name = long_name(random, size);
    let mut builder = Builder::triangle(json!({}));
    let item = match what {
        "camera" => builder.push(
            "cameras",
            json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 }, "name": name }),
        ),
        _ => {
            builder.json["meshes"][0]["name"] = json!(name);
            0
        }
    };
    for _ in 0..count(size, name.len(), 40) {
        builder.node(json!({ what: item }));
    }
    file_of(random, &builder)
}

/// Adds a triangle for each of `count` materials.
fn gltf_of_materials(builder: &mut Builder, count: usize, material: impl Fn(usize) -> Value) {
    let primitive = builder.json["meshes"][0]["primitives"][0].clone();
    for number in 0..count {
        let material = builder.push("materials", material(number));
        let mut primitive = primitive.clone();
        primitive["material"] = json!(material);
        builder.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
    }
}

fn gltf_cutoffs(random: &mut Random, size: &Size) -> Files {
    let mut builder = Builder::triangle(json!({}));
    let texture = builder.texture(&picture(size));
    let materials = count(size, builder.bytes.len(), 400).min(250);
    let factor = random.unit() < 0.5;
    gltf_of_materials(&mut builder, materials, |number| {
        let share = (number as f32 + 0.5) / 255.0;
        let texture = json!({ "index": texture });
        match factor {
            true => json!({
                "alphaMode": "MASK", "alphaCutoff": share, "pbrMetallicRoughness": { "baseColorTexture": texture }
            }),
            false => json!({
                "alphaMode": "MASK", "pbrMetallicRoughness":
                    { "baseColorTexture": texture, "baseColorFactor": [1, 1, 1, 0.5 + 0.4 * share] }
            }),
        }
    });
    file_of(random, &builder)
}

fn gltf_veils(random: &mut Random, size: &Size) -> Files {
    let mut builder = Builder::triangle(json!({}));
    let texture = builder.texture(&picture(size));
    let materials = count(size, builder.bytes.len(), 350);
    gltf_of_materials(&mut builder, materials, |_| {
        json!({ "alphaMode": "BLEND", "pbrMetallicRoughness":
            { "baseColorTexture": { "index": texture }, "metallicRoughnessTexture": { "index": texture } },
            "emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": texture } })
    });
    file_of(random, &builder)
}

/// Adds a material with a texture for each of these images. All materials use the texture in the same place, which is
/// chosen at random.
fn gltf_of_images(random: &mut Random, builder: &mut Builder, images: Vec<Value>) {
    let place = one_of(random, &["baseColorTexture", "metallicRoughnessTexture"]);
    builder.json["samplers"] =
        [10497, 33071, 33648].iter().map(|wrap| json!({ "wrapS": wrap, "wrapT": 10497 })).collect();
    let first = builder.json["textures"].as_array().map_or(0, Vec::len);
    let count = images.len();
    for (number, image) in images.into_iter().enumerate() {
        let source = builder.push("images", image);
        builder.push("textures", json!({ "source": source, "sampler": number % 3 }));
    }
    gltf_of_materials(
        builder,
        count,
        |number| json!({ "pbrMetallicRoughness": { place: { "index": first + number } } }),
    );
}

fn gltf_images(random: &mut Random, size: &Size) -> Files {
    let mut builder = Builder::triangle(json!({}));
    let picture = picture(size);
    let in_file = random.unit() < 0.5;
    let view = if in_file { 0 } else { builder.view(&picture) };
    let images = (0..count(size, picture.len(), 450)).map(|number| match in_file {
        true => json!({ "uri": format!("{}a.png", "./".repeat(number % 20)) }),
        false => json!({ "bufferView": view }),
    });
    gltf_of_images(random, &mut builder, images.collect());
    let mut files = file_of(random, &builder);
    if in_file {
        files.push(("a.png".into(), picture));
    }
    files
}

/// Makes buffer views that all begin with one picture, and end at different places after it.
fn gltf_pieces(random: &mut Random, size: &Size) -> Files {
    let mut builder = Builder::triangle(json!({}));
    let picture = picture(size);
    let count = count(size, picture.len(), 550);
    let view = builder.view(&[&*picture, &vec![0; count]].concat());
    let views = (0..count).map(|number| {
        let mut piece = builder.json["bufferViews"][view].clone();
        piece["byteLength"] = json!(picture.len() + number);
        json!({ "bufferView": builder.push("bufferViews", piece) })
    });
    let images = views.collect();
    gltf_of_images(random, &mut builder, images);
    file_of(random, &builder)
}

fn gltf_broken_pictures(random: &mut Random, size: &Size) -> Files {
    let mut builder = Builder::triangle(json!({}));
    let view = builder.view(&broken_picture(size));
    let apart = random.unit() < 0.5;
    let images = (0..count(size, builder.bytes.len(), 550)).map(|number| {
        let mut piece = builder.json["bufferViews"][view].clone();
        let length = piece["byteLength"].as_u64().unwrap() - if apart { number as u64 % 100 } else { 0 };
        piece["byteLength"] = json!(length);
        json!({ "bufferView": builder.push("bufferViews", piece) })
    });
    let images = images.collect();
    gltf_of_images(random, &mut builder, images);
    file_of(random, &builder)
}

fn gltf_missing_pictures(random: &mut Random, size: &Size) -> Files {
    let mut builder = Builder::triangle(json!({}));
    let uri = format!("{}.png", long_name(random, size));
    let first = builder.push("images", json!({ "uri": uri }));
    let texture = builder.push("textures", json!({ "source": first }));
    let materials = count(size, uri.len(), 300);
    gltf_of_materials(
        &mut builder,
        materials,
        |_| json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } }),
    );
    file_of(random, &builder)
}

fn gltf_sparse(random: &mut Random, size: &Size) -> Files {
    let mut builder = Builder::triangle(json!({}));
    let view = builder.view(&[0; 16]);
    let count = [3 * size.triangles, size.triangles, 1 << 40][below(random, 3)];
    let accessor = builder.push(
        "accessors",
        json!({
            "componentType": 5126, "type": "VEC3", "count": count,
            "sparse": {
                "count": 1,
                "indices": { "bufferView": view, "componentType": 5123 },
                "values": { "bufferView": view }
            }
        }),
    );
    let attribute = one_of(random, &["POSITION", "NORMAL", "COLOR_0"]);
    builder.json["meshes"][0]["primitives"][0]["attributes"][attribute] = json!(accessor);
    let primitive = builder.json["meshes"][0]["primitives"][0].clone();
    builder.json["meshes"][0]["primitives"] = list(primitive, 1 + below(random, 100));
    file_of(random, &builder)
}

/// Makes a scene in which this JSON replaces a list.
fn gltf_with(list: &str, items: &str) -> Files {
    let builder = Builder::triangle(json!({}));
    let json = serde_json::to_string(&builder.json).unwrap();
    let json = json.replacen(
        "{\"",
        &format!("{{\"{list}\":{items},\"buffers\":[{{\"byteLength\":{}}}],\"", builder.bytes.len()),
        1,
    );
    // If the builder already has a list of this name, the duplicate is an error once both are read.
    vec![("scene.glb".into(), binary(json.into_bytes(), &builder.bytes))]
}

fn gltf_empty(random: &mut Random, size: &Size) -> Files {
    let (list, item) = [
        ("nodes", "{}"),
        ("materials", "{}"),
        ("samplers", "{}"),
        ("textures", "{}"),
        ("images", "{}"),
        ("scenes", "{}"),
        ("meshes", "{\"primitives\":[{\"attributes\":{}}]}"),
        ("meshes", "{\"primitives\":[]}"),
        ("skins", "{\"joints\":[]}"),
        ("animations", "{\"channels\":[],\"samplers\":[]}"),
        ("extensionsUsed", "\"\""),
        ("cameras", "{\"type\":0}"),
        ("bufferViews", "{\"buffer\":0,\"byteLength\":0}"),
    ][below(random, 13)];
    let items = vec![item; size.bytes / (item.len() + 1)].join(",");
    gltf_with(list, &format!("[{items}]"))
}

fn gltf_values(random: &mut Random, size: &Size) -> Files {
    let item = one_of(random, &["{\"\":0}", "[]", "0", "{}", "\"\"", "[[0]]"]);
    let items = vec![item; size.bytes / (item.len() + 1)].join(",");
    let key = one_of(
        random,
        &["\"componentType\":5126,\"type\":\"SCALAR\",\"count\":1,\"min\"", "\"count\":1,\"max\"", "\"extras\""],
    );
    gltf_with("accessors", &format!("[{{{key}:[{items}]}}]"))
}

/// Returns a mesh whose triangles take a quarter of the allowed bytes.
fn gltf_mesh(size: &Size) -> (Builder, Value) {
    let mut builder = Builder::new();
    let count = size.bytes / 4 / 36;
    let corners: Vec<[f32; 3]> = (0..3 * count).map(|corner| [corner as f32, (corner % 3) as f32, 0.0]).collect();
    builder.mesh(&corners, json!({}));
    let primitive = builder.json["meshes"][0]["primitives"][0].clone();
    (builder, primitive)
}

fn gltf_primitives(random: &mut Random, size: &Size) -> Files {
    let (mut builder, mut primitive) = gltf_mesh(size);
    if random.unit() < 0.5 {
        primitive["attributes"]["NORMAL"] = primitive["attributes"]["POSITION"].clone();
        primitive["attributes"]["COLOR_0"] = primitive["attributes"]["POSITION"].clone();
    }
    builder.json["meshes"][0]["primitives"] = list(primitive, count(size, builder.bytes.len(), 60));
    builder.node(json!({ "mesh": 0 }));
    file_of(random, &builder)
}

fn gltf_meshes(random: &mut Random, size: &Size) -> Files {
    let (mut builder, primitive) = gltf_mesh(size);
    for _ in 0..count(size, builder.bytes.len(), 100) {
        let mesh = builder.push("meshes", json!({ "primitives": [primitive] }));
        builder.node(json!({ "mesh": mesh }));
    }
    file_of(random, &builder)
}

fn gltf_vertices(random: &mut Random, size: &Size) -> Files {
    let (mut builder, mut primitive) = gltf_mesh(size);
    primitive["indices"] = json!(builder.indices(&[0, 1, 2]));
    if random.unit() < 0.5 {
        primitive["mode"] = json!(5);
        primitive["indices"] = json!(builder.indices(&[0]));
    }
    builder.json["meshes"][0]["primitives"] = list(primitive, count(size, builder.bytes.len(), 60));
    builder.node(json!({ "mesh": 0 }));
    file_of(random, &builder)
}

fn gltf_nodes(random: &mut Random, size: &Size) -> Files {
    let (mut builder, _) = gltf_mesh(size);
    if random.unit() < 0.5 {
        builder = Builder::triangle(json!({}));
    }
    for _ in 0..count(size, builder.bytes.len(), 25) {
        builder.node(json!({ "mesh": 0 }));
    }
    file_of(random, &builder)
}

fn gltf_buffers(random: &mut Random, size: &Size) -> Files {
    let mut builder = Builder::triangle(json!({}));
    let mut content = builder.bytes.clone();
    content.resize(size.bytes / 2, 0);
    let by_path = random.unit() < 0.5;
    let uri = |number: usize| match by_path {
        true => format!("{}scene.bin", "./".repeat(number % 20)),
        false => "scene.bin".into(),
    };
    let buffers = count(size, content.len(), 350);
    builder.json["buffers"] = (0..buffers).map(|number| json!({ "byteLength": 72, "uri": uri(number) })).collect();
    for buffer in 0..buffers {
        let view = builder.push("bufferViews", json!({ "buffer": buffer, "byteLength": 36 }));
        let accessor =
            builder.push("accessors", json!({ "bufferView": view, "componentType": 5126, "type": "VEC3", "count": 3 }));
        let mesh = builder.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": accessor } }] }));
        builder.node(json!({ "mesh": mesh }));
    }
    let json = serde_json::to_vec(&builder.json).unwrap();
    vec![("scene.gltf".into(), json), ("scene.bin".into(), content)]
}

fn gltf_children(random: &mut Random, size: &Size) -> Files {
    let mut builder = Builder::triangle(json!({}));
    let children = vec![[0u32, 1][below(random, 2)]; size.bytes / 2];
    match below(random, 3) {
        0 => builder.json["scenes"][0]["nodes"] = json!(children),
        1 => builder.json["nodes"][0]["children"] = json!(children),
        _ => {
            builder.json["nodes"][0]["children"] = json!(children);
            builder.json.as_object_mut().unwrap().remove("scenes");
            builder.json.as_object_mut().unwrap().remove("scene");
        }
    }
    file_of(random, &builder)
}

fn gltf_nested(random: &mut Random, size: &Size) -> Files {
    let mut builder = Builder::triangle(json!({}));
    let count = size.bytes / 40;
    for node in 1..count {
        builder.push("nodes", json!({ "children": [node + 1], "translation": [1, 0, 0] }));
    }
    builder.push("nodes", json!({ "mesh": 0 }));
    builder.json["nodes"][0]["children"] = json!([1]);
    if random.unit() < 0.5 {
        let content = data_uri(&builder.bytes);
        builder.json["buffers"] = json!([{ "byteLength": builder.bytes.len(), "uri": content }]);
        return vec![("scene.gltf".into(), serde_json::to_vec(&builder.json).unwrap())];
    }
    file_of(random, &builder)
}

fn gltf_lights(random: &mut Random, size: &Size) -> Files {
    let mut builder = Builder::triangle(json!({}));
    let kind = one_of(random, &["point", "directional"]);
    builder.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": kind }] } });
    builder.json["extensionsUsed"] = list(json!("EXT_x"), size.bytes / 32);
    for _ in 0..size.bytes / 2 / 60 {
        builder.node(json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
    }
    file_of(random, &builder)
}

/// Makes a mesh of many vertices, and many morph targets that share one accessor.
fn gltf_targets(random: &mut Random, size: &Size) -> Files {
    let mut builder = Builder::triangle(json!({}));
    let vertices = size.bytes / 144 * 3;
    let positions = vec![[0.5, 0.25, 1.0]; vertices];
    let moves = builder.floats(&positions);
    let target = json!({ "POSITION": moves });
    let targets = list(target, count(size, size.bytes / 2, 20));
    let mesh = builder.mesh(&positions, json!({ "targets": targets }));
    builder.node(json!({ "mesh": mesh }));
    file_of(random, &builder)
}

fn gltf_weights(random: &mut Random, size: &Size) -> Files {
    let mut builder = Builder::triangle(json!({}));
    let moves = builder.floats(&[[0.5, 0.25, 1.0]; 3]);
    let targets = count(size, size.bytes / 2, 20);
    builder.json["meshes"][0]["primitives"][0]["targets"] = list(json!({ "POSITION": moves }), targets);
    for _ in 0..count(size, size.bytes / 2, 12) {
        builder.node(json!({ "mesh": 0 }));
    }
    file_of(random, &builder)
}

fn gltf_skins(random: &mut Random, size: &Size) -> Files {
    let mut builder = Builder::triangle(json!({}));
    let joints = builder.accessor(&[0; 12], 5121, "VEC4", 3);
    let weights = builder.floats(&[[1.0, 0.0, 0.0, 0.0]; 3]);
    builder.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(joints);
    builder.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
    let skin = builder.push("skins", json!({ "joints": list(json!(0), count(size, size.bytes / 2, 2)) }));
    for _ in 0..count(size, size.bytes / 2, 22) {
        builder.node(json!({ "mesh": 0, "skin": skin }));
    }
    file_of(random, &builder)
}

fn gltf_channels(random: &mut Random, size: &Size) -> Files {
    let mut builder = Builder::triangle(json!({}));
    let keys = size.bytes / 4 / 16;
    let times = builder.floats(&(0..keys).map(|key| [key as f32]).collect::<Vec<_>>());
    let places = builder.floats(&vec![[0.5, 0.25, 1.0]; keys]);
    let nodes = count(size, size.bytes / 4, 90);
    let channels = (0..nodes).map(|_| {
        let node = builder.node(json!({ "mesh": 0 }));
        json!({ "sampler": 0, "target": { "node": node, "path": "translation" } })
    });
    let channels = Value::Array(channels.collect());
    builder.push("animations", json!({ "channels": channels, "samplers": [{ "input": times, "output": places }] }));
    file_of(random, &builder)
}

/// Adds an accessor of the first buffer view's bytes.
fn bytes_accessor(builder: &mut Builder, kind: &str, count: usize) -> usize {
    builder.push("accessors", json!({ "bufferView": 0, "componentType": 5121, "type": kind, "count": count }))
}

/// Makes one primitive that names an accessor of joints and one of weights in many sets.
fn gltf_joint_sets(random: &mut Random, size: &Size) -> Files {
    let mut builder = Builder::new();
    let vertices = size.bytes / 36 * 3;
    builder.view(&vec![1; 4 * vertices]);
    let [positions, four] = ["VEC3", "VEC4"].map(|kind| bytes_accessor(&mut builder, kind, vertices));
    let mut attributes = json!({ "POSITION": positions });
    let most = if random.unit() < 0.5 { 8 } else { usize::MAX };
    for set in 0..count(size, builder.bytes.len(), 32).min(most) {
        attributes[format!("JOINTS_{set}")] = json!(four);
        attributes[format!("WEIGHTS_{set}")] = json!(four);
    }
    let mesh = builder.push("meshes", json!({ "primitives": [{ "attributes": attributes }] }));
    builder.node(json!({ "mesh": mesh }));
    file_of(random, &builder)
}

fn gltf_overlapping_targets(random: &mut Random, size: &Size) -> Files {
    let mut builder = Builder::new();
    let vertices = size.bytes / 24 * 3;
    builder.view(&vec![1; 3 * vertices]);
    let positions = bytes_accessor(&mut builder, "VEC3", vertices);
    let targets = 0..count(size, builder.bytes.len(), 100);
    let targets = targets.map(|_| json!({ "POSITION": bytes_accessor(&mut builder, "VEC3", vertices) }));
    let targets = Value::Array(targets.collect());
    let primitive = json!({ "attributes": { "POSITION": positions }, "targets": targets });
    let mesh = builder.push("meshes", json!({ "primitives": [primitive] }));
    builder.node(json!({ "mesh": mesh }));
    file_of(random, &builder)
}

fn gltf_overlapping_samplers(random: &mut Random, size: &Size) -> Files {
    let mut builder = Builder::new();
    let keys = size.bytes / 12;
    builder.view(&vec![0; 4 * keys]);
    let positions = builder.floats(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let mesh = builder.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": positions } }] }));
    let times = bytes_accessor(&mut builder, "SCALAR", keys);
    let items = (0..count(size, builder.bytes.len(), 180)).map(|sampler| {
        let output = bytes_accessor(&mut builder, "VEC4", keys);
        let node = builder.node(json!({ "mesh": mesh }));
        let channel = json!({ "sampler": sampler, "target": { "node": node, "path": "rotation" } });
        (json!({ "input": times, "output": output }), channel)
    });
    let (samplers, channels): (Vec<Value>, Vec<Value>) = items.unzip();
    builder.push("animations", json!({ "channels": channels, "samplers": samplers }));
    file_of(random, &builder)
}

// --- PLY ---

const VERTICES: &str = "property float x\nproperty float y\nproperty float z\n";

/// Returns a text file with three vertices and one face. `header` and `vertex` are lines of its header. `body` is
/// placed before the face.
fn ply(header: &str, vertex: &str, body: &str) -> Files {
    let text = format!(
        "ply\nformat ascii 1.0\nelement vertex 3\n{VERTICES}{vertex}{header}element face 1\nproperty list uchar int \
        vertex_indices\nend_header\n{body}3 0 1 2\n"
    );
    vec![("scene.ply".into(), text.into())]
}

fn ply_properties(random: &mut Random, size: &Size) -> Files {
    let start = if random.unit() < 0.5 { "" } else { "an_own_name_" };
    let count = size.bytes / (27 + start.len());
    let properties: String = (0..count).map(|number| format!("property uchar {start}{number}\n")).collect();
    let values = " 0".repeat(count);
    match random.unit() < 0.5 {
        true => ply("", &properties, &format!("0 0 0{values}\n1 0 0{values}\n0 1 0{values}\n")),
        false => ply(&format!("element other 1\n{properties}"), "", &format!("0 0 0\n1 0 0\n0 1 0\n{values}\n")),
    }
}

fn ply_elements(random: &mut Random, size: &Size) -> Files {
    let more = one_of(random, &["", "property uchar a\n"]);
    let elements: String =
        (0..size.bytes / (20 + more.len())).map(|number| format!("element e{number} 0\n{more}")).collect();
    ply(&elements, "", "0 0 0\n1 0 0\n0 1 0\n")
}

/// Returns a binary file of 256 vertices, half of the time with every vertex property. `faces` is the number of faces,
/// `count` the type of their corner counts, and `body` the data of the faces.
fn binary_ply(random: &mut Random, count: &str, faces: &str, body: &[u8]) -> Files {
    let more = "nx ny nz red green blue u v".split(' ').map(|name| format!("property float {name}\n"));
    let more: String = if random.unit() < 0.5 { more.collect() } else { String::new() };
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex 256\n{VERTICES}{more}element face {faces}\nproperty list \
        {count} uchar vertex_indices\nend_header\n"
    )
    .into_bytes();
    for _ in 0..256 * if more.is_empty() { 3 } else { 11 } {
        bytes.extend(random.unit().to_le_bytes());
    }
    bytes.extend(body);
    vec![("scene.ply".into(), bytes)]
}

fn ply_faces(random: &mut Random, size: &Size) -> Files {
    let corners = [0u8, 1, 3, 4, 255][below(random, 5)];
    let faces = size.bytes / (usize::from(corners) + 1);
    let body: Vec<u8> = (0..faces).flat_map(|_| std::iter::once(corners).chain(0..corners)).collect();
    binary_ply(random, "uchar", &faces.to_string(), &body)
}

fn ply_polygons(random: &mut Random, size: &Size) -> Files {
    let corners = [size.bytes, 1 << 17, 1 << 14][below(random, 3)].min(size.bytes);
    let mut body = Vec::new();
    let faces = size.bytes / corners;
    let by_chance = random.unit() < 0.5;
    for _ in 0..faces {
        body.extend((corners as u32).to_le_bytes());
        body.extend((0..corners).map(|corner| if by_chance { below(random, 256) as u8 } else { corner as u8 }));
    }
    binary_ply(random, "uint", &faces.to_string(), &body)
}

fn ply_nothing(random: &mut Random, _: &Size) -> Files {
    match below(random, 3) {
        0 => ply("element other 18446744073709551615\n", "", "0 0 0\n1 0 0\n0 1 0\n"),
        1 => ply("element other 1000000000\nproperty list uchar uchar a\n", "", "0 0 0\n1 0 0\n0 1 0\n"),
        _ => binary_ply(random, "uchar", "1000000000000", &[0; 4096]),
    }
}

fn ply_lists(random: &mut Random, size: &Size) -> Files {
    let name = one_of(random, &["vertex_indices", "other", "vertex_index"]);
    let count = size.bytes / 2 / 40;
    let lists: String = (0..count).map(|number| format!("property list uchar uchar {name}{number}\n")).collect();
    let list = "3 0 1 2 ".repeat(count);
    ply(&format!("element other 1\n{lists}"), "", &format!("0 0 0\n1 0 0\n0 1 0\n{list}\n"))
}
