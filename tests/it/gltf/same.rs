//! Tests that a mesh gives the same picture from all formats, byte for byte.

use std::fmt::Write;

use serde_json::json;
use stereotrace::{
    MaterialId, Method, Options, Scene, SceneFile, SceneOptions, StereoCamera,
    blocking::Wait,
    glam::{Vec2, Vec3},
};

use super::{
    common::{ball, folder::Folder, renderer},
    gltf::Builder,
};

#[test]
fn obj_ply_and_gltf_of_one_mesh_are_one_picture() {
    let folder = Folder::new("same");
    let mesh = ball(Vec3::new(0.1, 0.2, 0.3), 1.3, 12);
    let normals: Vec<Vec3> =
        mesh.positions.iter().map(|position| (*position - Vec3::new(0.1, 0.2, 0.3)).normalize()).collect();
    let (mut obj, mut ply) = (String::from("mtllib scene.mtl\nusemtl red\n"), String::new());
    for (position, normal) in mesh.positions.iter().zip(&normals) {
        let ([x, y, z], [nx, ny, nz]) = (position.to_array(), normal.to_array());
        writeln!(obj, "v {x} {y} {z}\nvn {nx} {ny} {nz}").unwrap();
        writeln!(ply, "{x} {y} {z} {nx} {ny} {nz}").unwrap();
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(ply, "3 {a} {b} {c}").unwrap();
        writeln!(obj, "f {0}//{0} {1}//{1} {2}//{2}", a + 1, b + 1, c + 1).unwrap();
    }
    folder.write("scene.mtl", "newmtl red\nKd 0.8 0.2 0.1\nillum 1\n");
    let header = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nproperty \
        float nx\nproperty \
         float ny\nproperty float nz\nelement face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    );
    let mut binary = header.replace("ascii", "binary_little_endian").into_bytes();
    for (position, normal) in mesh.positions.iter().zip(&normals) {
        binary.extend(position.to_array().into_iter().chain(normal.to_array()).flat_map(f32::to_le_bytes));
    }
    for corners in &mesh.triangles {
        binary.push(3);
        binary.extend(corners.iter().flat_map(|corner| corner.to_le_bytes()));
    }
    let mut builder = Builder::new();
    let red = json!({ "baseColorFactor": [0.8, 0.2, 0.1, 1], "metallicFactor": 0, "roughnessFactor": 1 });
    let red = json!({ "pbrMetallicRoughness": red });
    let red = builder.push("materials", red);
    let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|position| position.to_array()).collect();
    let accessor = builder.floats(&normals.iter().map(|normal| normal.to_array()).collect::<Vec<_>>());
    let indices = builder.indices(mesh.triangles.as_flattened());
    let mesh =
        builder.mesh(&positions, json!({ "material": red, "indices": indices, "attributes": { "NORMAL": accessor } }));
    builder.node(json!({ "mesh": mesh }));

    let files = [
        folder.write("scene.obj", obj),
        folder.write("scene.gltf", builder.text()),
        folder.write("scene.glb", builder.binary()),
        folder.write("scene.ply", header + &ply),
        folder.write("binary.ply", binary),
    ];
    let camera = StereoCamera::look_at(Vec3::new(0.5, 1.0, 4.0), Vec3::ZERO).size(97, 61);
    let mut pictures = Vec::new();
    for file in &files {
        let mut scene = SceneFile::open(file, &SceneOptions::default()).unwrap().scene;
        if file.extension().is_some_and(|ending| ending == "ply") {
            // PLY has no materials, so the mesh's default grey is replaced by the red of the other files.
            scene = painted(&scene);
        }
        scene.place_lights(2, &camera).unwrap();
        let mut renderer = renderer();
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let pair = renderer.pair(&uploaded, &camera).options(&Options::new(Method::BRACKET)).read().wait().unwrap();
        pictures.push((pair.left.rgba8, pair.right.rgba8));
    }
    for (picture, file) in pictures.iter().zip(&files) {
        assert!(*picture == pictures[0], "{}", file.display());
    }
    let colors: std::collections::HashSet<_> = pictures[0].0.iter().collect();
    assert!(colors.len() > 100, "a picture of {} colours says nothing", colors.len());
}

/// Returns the scene with one more material, which all triangles have.
fn painted(scene: &Scene) -> Scene {
    let mut painted = Scene::new();
    let red = painted.add_material(stereotrace::Material::new(Vec3::new(0.8, 0.2, 0.1)));
    assert_eq!(red, MaterialId(1));
    let positions = scene.triangles().iter().flat_map(|triangle| triangle.corners).collect();
    let triangles =
        (0..scene.triangles().len() as u32).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect();
    let normals = scene.triangles().iter().map(|triangle| triangle.normals).collect();
    let mesh = stereotrace::Mesh::new(positions, triangles).normals(normals).materials(vec![red]);
    painted.add_mesh(&mesh).unwrap();
    painted
}

/// OBJ and glTF have opposite directions of the vertical texture coordinate.
#[cfg(feature = "textures")]
#[test]
fn a_picture_lies_the_same_way_in_both_formats() {
    use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};

    let folder = Folder::new("same_way");
    let pixels = [[255u8, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 255]];
    let mut png = Vec::new();
    PngEncoder::new(&mut png).write_image(pixels.as_flattened(), 2, 2, ExtendedColorType::Rgba8).unwrap();
    folder.write("skin.png", &png);
    folder.write("scene.mtl", "newmtl skin\nKd 1 1 1\nmap_Kd skin.png\n");
    let obj = "mtllib scene.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl skin\nf 1/1 2/2 3/3\n";
    let mut builder = Builder::triangle(json!({ "pbrMetallicRoughness": { "metallicFactor": 0 } }));
    builder.push("images", json!({ "uri": "skin.png" }));
    builder.push("textures", json!({ "source": 0 }));
    builder.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
    let open = |name: &str, content: String| {
        SceneFile::open(folder.write(name, content), &SceneOptions::default()).unwrap().scene
    };
    let [obj, gltf] = [open("scene.obj", obj.into()), open("scene.gltf", builder.text())];
    assert_eq!(obj.uv(), [[Vec2::ZERO, Vec2::X, Vec2::Y]]);
    let camera = StereoCamera::look_at(Vec3::new(0.3, 0.3, 1.0), Vec3::new(0.3, 0.3, 0.0)).size(40, 40);
    let mut renderer = renderer();
    let [one, other] = [obj, gltf].map(|scene| {
        let uploaded = renderer.upload(&scene).wait().unwrap();
        renderer.pair(&uploaded, &camera).options(&Options::new(Method::Naive)).read().wait().unwrap().left.rgba8
    });
    assert!(one == other);
}
