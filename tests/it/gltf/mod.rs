//! Tests glTF files: the results of `SceneFile::open` and `Scene::from_gltf`, and the messages about unsupported or
//! invalid content.
use crate::common;
mod animations;
mod faults;
use crate::common::gltf;
mod materials;
mod meshes;
mod places;
#[cfg(all(feature = "obj", feature = "ply"))]
mod same;
#[cfg(feature = "textures")]
mod textures;

use common::folder::Folder;
use stereotrace::{Error, Material, Scene, SceneFile, SceneOptions, glam::Vec3};

fn open_with(content: impl AsRef<[u8]>, options: &SceneOptions) -> Result<SceneFile, Error> {
    let folder = Folder::new("gltf");
    SceneFile::open(folder.write("scene.gltf", content), options)
}

fn open(content: impl AsRef<[u8]>) -> SceneFile {
    open_with(content, &SceneOptions::default()).unwrap()
}

fn scene(content: impl AsRef<[u8]>) -> Scene {
    open(content).scene
}

fn corners(scene: &Scene) -> Vec<[Vec3; 3]> {
    scene.triangles().iter().map(|triangle| triangle.corners).collect()
}

/// Returns the material of the first triangle.
fn material(scene: &Scene) -> &Material {
    &scene.materials()[scene.triangles()[0].material.0 as usize]
}

#[track_caller]
fn assert_near(found: Vec3, expected: Vec3) {
    assert!((found - expected).length() < 1e-5 * (1.0 + expected.length()), "{found} and not {expected}");
}
