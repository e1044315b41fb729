//! Reads glTF 2.0 files, as text (.gltf) and binary (.glb).
//!
//! The crate `gltf-json` gives the JSON its types. Its parent crate `gltf` trusts indices, lengths and camera types,
//! and panics if they are wrong, even in its own validation. So here each index goes through [`Document`], and each
//! length through accessors.rs. The walk over the nodes is iterative, and each node may be reached only once.

mod accessors;
mod animations;
mod cameras;
mod document;
mod lights;
mod materials;
mod meshes;
mod more;
mod nodes;
mod objects;
mod textures;

use std::{path::Path, sync::Arc};

use glam::DAffine3;

use self::{
    animations::Numbers,
    cameras::AtNode,
    document::Document,
    materials::Surfaces,
    meshes::Meshes,
    nodes::{Visited, walk},
    objects::Objects,
};
use super::{
    SceneFile, SceneOptions,
    warnings::{Place, Warnings},
};
use crate::{
    Animation, Error, Scene,
    import::input::Files,
    message::counted,
    scene::{
        animation::{Node, NodeTree},
        smooth::check_crease,
    },
};

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
    let mut tree = NodeTree::default();
    let mut places = vec![None; document.root.nodes.len()];
    walk(&document, |Visited { index, node, parent, local, place }| {
        places[index] = Some(tree.nodes.len());
        let parent = parent.and_then(|parent| places[parent]);
        let mut weights = Arc::default();
        if let Some(mesh) = node.mesh {
            meshes.read(mesh.value(), index, (&mut surfaces, &mut warnings))?;
            weights = meshes.weights(mesh.value(), index)?;
            shown.push(((index, mesh.value()), place));
        }
        tree.nodes.push(Node { parent, local, weights });
        if let Some(camera) = node.camera {
            cameras.push(((index, camera.value()), place));
        }
        let light = node.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
        lights.extend(light.map(|light| ((index, light.light.value()), place)));
        Ok(())
    })?;
    let mut numbers = Numbers::new(&document);
    let clips = animations::read(&mut numbers, &places, &tree, &mut warnings)?;
    tree.skins = animations::skins(&mut numbers, &places)?;
    // Materials come first, since meshes are checked against them.
    surfaces.move_to(&mut scene);
    let objects = Objects { document: &document, meshes: &meshes, places: &places, clips: &clips };
    let skins = objects.skins_of(&shown, &tree)?;
    let origin = options.origin.choose(|| objects.bounds(&shown, &skins, &tree));
    scene.set_origin(origin).map_err(|error| Error::parse_from(path, None, error.to_string(), error))?;
    objects.add(&shown, &skins, &mut scene, &mut tree)?;
    surfaces.warn_of_ranges(&warnings);
    if scene.triangles.is_empty() {
        let nodes = counted(document.root.nodes.len(), "node", "nodes");
        return Err(document.fault(format!("no triangles in its scene and {nodes}; a scene needs meshes of triangles")));
    }
    warnings.warn_of_dropped(&scene);
    let lit = lights::read(&document, &lights, &mut scene, &mut warnings)?;
    let cameras = cameras::read(&document, &cameras, scene.bounds(), &mut warnings)?;
    let node = |index: usize| places[index].unwrap_or_default();
    let moved = objects.moved(&tree);
    let lights = lit.into_iter().map(node).zip(scene.lights.iter().copied()).enumerate();
    let lights = lights.filter(|(_, (node, _))| moved[*node]);
    tree.lights = lights.map(|(index, (node, light))| (index, node, light)).collect();
    tree.cameras = cameras.iter().map(|one| (node(one.node), one.camera)).collect();
    let cameras = cameras.into_iter().map(|AtNode { name, camera, .. }| (name, camera)).collect();
    let tree = Arc::new(tree);
    let animations = clips.into_iter().map(|(name, tracks)| Animation::new(name, tracks, tree.clone())).collect();
    Ok(SceneFile { scene, cameras, animations })
}

/// Counts unsupported items.
fn note_left_out(document: &Document, warnings: &mut Warnings) {
    let root = &document.root;
    let lists = [("scenes other than the default or the first one", root.scenes.len().saturating_sub(1))];
    for (what, count) in lists {
        (0..count).for_each(|_| warnings.left_out(what, Place::File));
    }
}
