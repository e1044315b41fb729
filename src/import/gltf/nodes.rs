//! Walks over the nodes of a scene.

use glam::{DAffine3, DMat4, DQuat, DVec3};
use gltf_json::{Index, Node, scene::UnitQuaternion};

use serde::Deserialize;

use super::document::Document;
use crate::{Error, scene::animation::Local};

/// Matrix and translation of a node in f64. gltf-json has them in f32, which rounds places far from the world's origin.
#[derive(Deserialize)]
pub(super) struct Shifts {
    matrix: Option<Box<[f64; 16]>>,
    translation: Option<[f64; 3]>,
}

/// Returns the transforms of all nodes in a file that gltf-json has already read.
pub(super) fn shifts(json: &[u8]) -> Result<Vec<Shifts>, serde_json::Error> {
    #[derive(Deserialize)]
    struct File {
        #[serde(default)]
        nodes: Vec<Shifts>,
    }
    serde_json::from_slice::<File>(json).map(|file| file.nodes)
}

/// A node of the scene.
pub(super) struct Visited<'a> {
    pub(super) index: usize,
    pub(super) node: &'a Node,
    pub(super) parent: Option<usize>,
    pub(super) local: Local,
    /// Transform to the world.
    pub(super) place: DAffine3,
}

/// Calls `visit` with each node of the scene, parents before children, in the file's order. Without a default scene the
/// first one is used, and without scenes all nodes without parents.
pub(super) fn walk(document: &Document, mut visit: impl FnMut(Visited) -> Result<(), Error>) -> Result<(), Error> {
    let root = &document.root;
    let scene = root.scene.map(|scene| scene.value()).or((!root.scenes.is_empty()).then_some(0));
    let orphans: Vec<Index<Node>>;
    let roots = match scene {
        Some(scene) => &document.item(("scenes", &root.scenes), scene, "scene")?.nodes,
        None => {
            orphans = orphans_of(&root.nodes);
            &orphans
        }
    };
    let mut visited = vec![false; root.nodes.len()];
    // A stack of child lists, each with its parent and the parent's transform. It holds iterators, since a list may
    // contain a node millions of times.
    let mut lists = vec![(roots.iter(), None::<usize>, DAffine3::IDENTITY)];
    while let Some((list, parent, place)) = lists.last_mut() {
        let (parent, place) = (*parent, *place);
        let Some(index) = list.next().map(|node| node.value()) else {
            lists.pop();
            continue;
        };
        let by = || parent.map_or("the scene".into(), |parent| format!("nodes[{parent}]"));
        let node = document.item(("nodes", &root.nodes), index, by())?;
        if std::mem::replace(&mut visited[index], true) {
            let reason = format!("{}: its child nodes[{index}] has another parent, or is its ancestor", by());
            return Err(document.fault(reason));
        }
        let local = local(node, &document.shifts[index])
            .map_err(|reason| document.fault(format!("nodes[{index}]: {reason}")))?;
        let place = place * local.transform();
        visit(Visited { index, node, parent, local, place })?;
        lists.extend(node.children.as_ref().map(|children| (children.iter(), Some(index), place)));
    }
    Ok(())
}

fn orphans_of(nodes: &[Node]) -> Vec<Index<Node>> {
    let mut is_child = vec![false; nodes.len()];
    for child in nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        if let Some(is_child) = is_child.get_mut(child.value()) {
            *is_child = true;
        }
    }
    (0..nodes.len()).filter(|&index| !is_child[index]).map(|index| Index::new(index as u32)).collect()
}

/// Returns a node's own transform in f64.
fn local(node: &Node, shifts: &Shifts) -> Result<Local, String> {
    let local = match &shifts.matrix {
        Some(matrix) => {
            let matrix = DMat4::from_cols_array(matrix);
            if matrix.row(3) != glam::DVec4::W {
                return Err(format!("the last row of its matrix is {}; it must be 0, 0, 0, 1", matrix.row(3)));
            }
            Local::Matrix(DAffine3::from_mat4(matrix))
        }
        None => {
            let UnitQuaternion(rotation) = node.rotation.unwrap_or_default();
            let rotation = DQuat::from_array(rotation.map(f64::from));
            if !(rotation.length() > 0.0 && rotation.length().is_finite()) {
                return Err(format!("its rotation {rotation} must be finite and not 0"));
            }
            let scale = node.scale.map_or(DVec3::ONE, |scale| DVec3::from_array(scale.map(f64::from)));
            let translation = shifts.translation.map_or(DVec3::ZERO, DVec3::from_array);
            Local::Parts { translation, rotation: rotation.normalize(), scale }
        }
    };
    if local.transform().is_finite() { Ok(local) } else { Err("its transform is not finite".into()) }
}
