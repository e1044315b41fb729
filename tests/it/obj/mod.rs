//! Tests odd OBJ and MTL files: the results of `Scene::from_obj`, and its messages about unsupported or invalid
//! content.
use crate::common;
mod corners;
mod faces;
mod faults;
mod materials;
#[cfg(feature = "textures")]
mod outside;
mod polygons;
mod surfaces;
#[cfg(feature = "textures")]
mod textures;
mod warnings;

use std::path::PathBuf;

use stereotrace::{Error, Material, MaterialId, Scene, SceneOptions};

/// A folder of one test, for its OBJ files.
pub(crate) struct Folder(common::folder::Folder);

impl Folder {
    pub(crate) fn new(test: &str) -> Self {
        common::warnings::collect();
        Self(common::folder::Folder::new(test))
    }

    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.0.file(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) -> &Self {
        self.0.write(name, content);
        self
    }

    /// Writes `content` to an OBJ file and reads it.
    pub(crate) fn read(&self, content: impl AsRef<[u8]>) -> Result<Scene, Error> {
        self.read_with(content, &SceneOptions::default())
    }

    pub(crate) fn read_with(&self, content: impl AsRef<[u8]>, options: &SceneOptions) -> Result<Scene, Error> {
        self.write("scene.obj", content);
        Scene::from_obj_with(self.file("scene.obj"), options)
    }

    pub(crate) fn scene(&self, content: impl AsRef<[u8]>) -> Scene {
        self.read(content).unwrap()
    }

    /// Returns the line and the reason of the error that `content` gives.
    pub(crate) fn error(&self, content: impl AsRef<[u8]>) -> (Option<usize>, String) {
        match self.read(content) {
            Err(Error::Parse { path, line, reason, .. }) => {
                assert_eq!(path, self.file("scene.obj"));
                (line, reason)
            }
            other => panic!("not a file error: {other:?}"),
        }
    }

    #[track_caller]
    pub(crate) fn fails_on_line(&self, line: usize, expected: &str, content: impl AsRef<[u8]>) {
        let (found, reason) = self.error(content);
        assert!(found == Some(line) && reason.contains(expected), "line {found:?} and not {line}: {reason}");
    }

    /// Returns the warnings that name a file of this folder, from the file's name on.
    pub(crate) fn warnings(&self) -> Vec<String> {
        common::warnings::of(&self.0)
    }
}

/// Six vertices at x = 1 to 6, so that a corner's x shows which vertex it is.
pub(crate) const SIX: &str = "v 1 0 0\nv 2 1 0\nv 3 0 1\nv 4 2 0\nv 5 0 2\nv 6 3 1\n";

/// Six vertices with the same x as in [`SIX`], which form convex polygons in a plane.
pub(crate) const ARC: &str = "v 1 1 0\nv 2 4 0\nv 3 9 0\nv 4 16 0\nv 5 25 0\nv 6 36 0\n";

/// Returns the corners of each triangle as numbers of vertices of [`SIX`] or [`ARC`].
pub(crate) fn corners(scene: &Scene) -> Vec<[u32; 3]> {
    scene.triangles().iter().map(|triangle| triangle.corners.map(|corner| corner.x as u32)).collect()
}

pub(crate) fn materials(scene: &Scene) -> Vec<&str> {
    let name = |MaterialId(id)| scene.materials()[id as usize].name.as_str();
    scene.triangles().iter().map(|triangle| name(triangle.material)).collect()
}

pub(crate) fn material<'a>(scene: &'a Scene, name: &str) -> &'a Material {
    scene.materials().iter().find(|material| material.name == name).unwrap()
}

/// Returns the name and first primitive of each object.
pub(crate) fn objects(scene: &Scene) -> Vec<(&str, u32)> {
    let first = |object| (0..scene.primitive_count() as u32).find(|&id| scene.object_of(id) == object).unwrap();
    (0..scene.object_count() as u32).map(|object| (scene.object_name(object), first(object))).collect()
}
