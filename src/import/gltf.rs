//! Reads glTF 2.0 files, as text (.gltf) and binary (.glb).
//!
//! The crate `gltf-json` gives the JSON its types. Its parent crate `gltf` trusts indices, lengths and camera types,
//! and panics if they are wrong, even in its own validation. So here each index goes through [`Document`], and each
//! length through accessors.rs. The walk over the nodes is iterative, and each node may be reached only once.

mod accessors;
mod cameras;
mod document;
mod lights;
mod materials;
mod meshes;
mod more;
mod nodes;
mod textures;

use std::path::Path;

use glam::DAffine3;

use self::{document::Document, materials::Surfaces, meshes::Meshes, nodes::walk};
use super::{
    SceneFile, SceneOptions,
    warnings::{Place, Warnings},
};
use crate::scene::{Scene, smooth::check_crease};
use crate::{Error, import::input::Files, message::counted};

/// An item with its transform to world coordinates.
type Placed<T> = (T, DAffine3);

/// Reads a scene, see [`Scene::from_gltf_with`].
pub(crate) fn read(files: Files, path: &Path, options: &SceneOptions) -> Result<SceneFile, Error> {
    let crease = options.crease_angle.map_or(Ok(()), check_crease);
    crease.map_err(|reason| Error::Scene { element: "crease angle".into(), reason })?;
    let document = Document::open(files, path, options.limits)?;
    let mut warnings = Warnings::new(path);
    document.check_extensions(&warnings)?;
    note_left_out(&document, &mut warnings);

    let mut scene = Scene::new();
    let mut surfaces = Surfaces::new(&document, options);
    let mut meshes = Meshes::new(&document, options);
    let (mut shown, mut cameras, mut lights) = (Vec::new(), Vec::new(), Vec::new());
    walk(&document, |index, node, place| {
        if let Some(mesh) = node.mesh {
            meshes.read(mesh.value(), index, (&mut surfaces, &mut warnings))?;
            shown.push(((index, mesh.value()), place));
        }
        if let Some(camera) = node.camera {
            cameras.push(((index, camera.value()), place));
        }
        let light = node.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
        lights.extend(light.map(|light| ((index, light.light.value()), place)));
        Ok(())
    })?;
    // Materials come first, since meshes are checked against them.
    surfaces.move_to(&mut scene);
    let origin = options.origin.choose(|| meshes.bounds(&shown));
    scene.set_origin(origin).map_err(|error| Error::parse_from(path, None, error.to_string(), error))?;
    let to_origin = DAffine3::from_translation(-scene.origin());
    for &((node, mesh), place) in &shown {
        let mesh = meshes.instance(mesh, node, to_origin * place);
        scene.push_mesh(&mesh).map_err(|error| Error::parse_from(path, None, error.to_string(), error))?;
    }
    surfaces.warn_of_ranges(&warnings);
    if scene.triangles.is_empty() {
        let nodes = counted(document.root.nodes.len(), "node", "nodes");
        return Err(document.fault(format!("no triangles in its scene and {nodes}; a scene needs meshes of triangles")));
    }
    warnings.warn_of_dropped(&scene);
    lights::read(&document, &lights, &mut scene, &mut warnings)?;
    let cameras = cameras::read(&document, &cameras, scene.bounds(), &mut warnings)?;
    Ok(SceneFile { scene, cameras })
}

/// Counts unsupported items.
fn note_left_out(document: &Document, warnings: &mut Warnings) {
    let root = &document.root;
    let lists = [
        ("animations", root.animations.len()),
        ("skins", root.skins.len()),
        ("scenes other than the default or the first one", root.scenes.len().saturating_sub(1)),
    ];
    for (what, count) in lists {
        (0..count).for_each(|_| warnings.left_out(what, Place::File));
    }
}
