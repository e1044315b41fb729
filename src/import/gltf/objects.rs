//! Adds the meshes of nodes to a scene, with their skins and morph targets.

use glam::{BVec3, DAffine3, DVec3};

use super::{Placed, animations::Clip, document::Document, meshes::Meshes};
use crate::{
    Error, Scene,
    import::origin::bounds_of,
    message::counted,
    scene::animation::{Actor, NodeTree, Property},
};

/// Meshes, nodes and animations from which the objects of a file are made.
pub(super) struct Objects<'a> {
    pub(super) document: &'a Document<'a>,
    pub(super) meshes: &'a Meshes<'a>,
    /// Place of each node in the tree.
    pub(super) places: &'a [Option<usize>],
    pub(super) clips: &'a [Clip],
}

impl Objects<'_> {
    /// Returns the skin of each shown mesh.
    pub(super) fn skins_of(
        &self,
        shown: &[Placed<(usize, usize)>],
        tree: &NodeTree,
    ) -> Result<Vec<Option<usize>>, Error> {
        shown.iter().map(|&((node, mesh), _)| self.skin_of(node, mesh, tree)).collect()
    }

    /// Returns a box around the shown meshes at rest, in world coordinates. It holds the transformed boxes of meshes
    /// without a skin.
    pub(super) fn bounds(
        &self,
        shown: &[Placed<(usize, usize)>],
        skins: &[Option<usize>],
        tree: &NodeTree,
    ) -> Option<(DVec3, DVec3)> {
        let (own, joints) = (self.meshes.boxes(), tree.joints(&tree.rest_places(), DAffine3::IDENTITY));
        let boxes = shown.iter().zip(skins).filter_map(|(&((node, mesh), place), skin)| match skin {
            Some(skin) => {
                let weights = &tree.nodes[self.places[node]?].weights;
                let posed = self.meshes.body(mesh).posed(weights, Some(&joints[*skin]), place, false);
                bounds_of(posed.positions.iter().map(|position| position.as_dvec3()))
            }
            None => {
                let (low, high) = own[&mesh]?;
                bounds_of((0..8).map(|corner| {
                    let is_high = [0, 1, 2].map(|axis| corner >> axis & 1 == 1);
                    place.transform_point3(DVec3::select(BVec3::from_array(is_high), high, low))
                }))
            }
        });
        bounds_of(boxes.flat_map(|(low, high)| [low, high]))
    }

    /// Adds all objects at rest to the scene. Those that an animation moves are added to the tree.
    pub(super) fn add(
        &self,
        shown: &[Placed<(usize, usize)>],
        skins: &[Option<usize>],
        scene: &mut Scene,
        tree: &mut NodeTree,
    ) -> Result<(), Error> {
        let to_origin = DAffine3::from_translation(-scene.origin());
        let joints = tree.joints(&tree.rest_places(), to_origin);
        let moved = self.moved(tree);
        let moved_skins: Vec<bool> =
            tree.skins.iter().map(|skin| skin.joints.iter().any(|&joint| moved[joint])).collect();
        for (object, (&((node, mesh), place), &skin)) in (0..).zip(shown.iter().zip(skins)) {
            let (body, name) = (self.meshes.body(mesh).clone(), self.meshes.name_of(mesh, node));
            let place = to_origin * place;
            let joints = skin.map(|skin| &*joints[skin]);
            let first_place = joints.map_or(place, |joints| joints[0]);
            let mirrored = first_place.matrix3.determinant() < 0.0;
            let at = self.places[node].unwrap_or_default();
            let posed = body.posed(&tree.nodes[at].weights, joints, place, mirrored).name(name.clone());
            scene
                .push_mesh(&posed)
                .map_err(|error| Error::parse_from(self.document.path, None, error.to_string(), error))?;
            if moved[at] || skin.is_some_and(|skin| moved_skins[skin]) {
                tree.actors.push(Actor { object, node: at, skin, body, name, mirrored });
            }
        }
        Ok(())
    }

    /// Returns, for each node of the tree, whether an animation changes its transform or its morph weights.
    pub(super) fn moved(&self, tree: &NodeTree) -> Vec<bool> {
        let mut own = vec![[false; 2]; tree.nodes.len()];
        for track in self.clips.iter().flat_map(|(_, tracks)| tracks) {
            own[track.node][usize::from(track.property == Property::Weights)] = true;
        }
        // Parents come first, so their transforms are decided.
        for node in 0..own.len() {
            own[node][0] |= tree.nodes[node].parent.is_some_and(|parent| own[parent][0]);
        }
        own.into_iter().map(|[place, weights]| place || weights).collect()
    }

    /// Returns the skin of a node's mesh. Skins without joints in the scene are ignored.
    fn skin_of(&self, node: usize, mesh: usize, tree: &NodeTree) -> Result<Option<usize>, Error> {
        let Some(skin) = self.document.root.nodes[node].skin else { return Ok(None) };
        let index = skin.value();
        self.document.item(("skins", &self.document.root.skins), index, format_args!("nodes[{node}]"))?;
        let joints = tree.skins[index].joints.len();
        match self.meshes.body(mesh).influences.iter().map(|(joint, _)| *joint).max() {
            Some(joint) if joints > 0 && joint as usize >= joints => {
                let joints = counted(joints, "joint", "joints");
                let reason =
                    format!("nodes[{node}]: meshes[{mesh}] has joint {joint}, but skins[{index}] has {joints}");
                Err(self.document.fault(reason))
            }
            most => Ok((joints > 0 && most.is_some()).then_some(index)),
        }
    }
}
