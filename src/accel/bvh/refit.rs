//! Refits a tree to primitives that moved. A refit keeps the links and computes the boxes from the leaves up. obvhs
//! could refit its own tree, but that tree takes eight times the memory of the packed tree's links.

use std::{collections::HashMap, sync::Arc};

use ahash::RandomState;
use obvhs::aabb::Aabb;

use super::{
    BvhBuild, Grid, LEAF, PackedBvh, boxes_of, check_materials, child_texels, has_fine_detail, is_empty,
    primitive::{geometry, push_primitive, texels_of_each},
};
use crate::{
    Boxes, Error, Scene,
    accel::cutouts::masks_of,
    scene::{Stamp, components},
};

/// Data of a packed tree that a refit needs.
#[derive(Clone, Debug)]
pub(crate) struct TreeShape {
    /// Links of the two sibling nodes of each pair. A pair comes after the pairs of its ancestors.
    links: Arc<Vec<[u32; 2]>>,
    /// Scene id of each primitive, planes first, then in leaf order.
    ids: Arc<Vec<u32>>,
    /// Primitives that the tree leaves out as exact copies, each with the primitive that it copied.
    copies: Arc<Vec<(u32, u32)>>,
    stack_size: u32,
    /// Numbers of triangles, spheres, ellipsoids and planes.
    counts: [usize; 4],
    pub(crate) components: Arc<Vec<u32>>,
    stamps: [Stamp; 2],
    /// Whether the tree represents a list ([`BvhBuild::Flat`]). A list is rebuilt instead of refitted.
    flat: bool,
}

fn stamps(scene: &Scene) -> [Stamp; 2] {
    [scene.triangles_stamp, scene.spheres_stamp]
}

/// Returns the numbers of triangles, spheres, ellipsoids and planes.
fn counts(scene: &Scene) -> [usize; 4] {
    [scene.triangles().len(), scene.spheres().len(), scene.ellipsoids().len(), scene.planes().len()]
}

impl TreeShape {
    /// Returns the shape of the tree built from this scene.
    pub(crate) fn of(scene: &Scene, packed: &PackedBvh) -> Self {
        let has_pairs = packed.ids.len() > scene.planes().len();
        let pairs = packed.nodes.chunks_exact(packed.pair_texels).filter(|_| has_pairs);
        Self {
            links: Arc::new(pairs.map(|pair| [pair[0][3], pair[packed.pair_texels / 2][3]]).collect()),
            ids: Arc::new(packed.ids.clone()),
            copies: Arc::new(copies(scene, &packed.ids)),
            stack_size: packed.stack_size,
            counts: counts(scene),
            components: packed.components.clone(),
            stamps: stamps(scene),
            flat: packed.flat,
        }
    }

    /// Returns the shape after a refit to this scene.
    pub(crate) fn refitted(&self, scene: &Scene, packed: &PackedBvh) -> Self {
        if self.flat {
            return Self::of(scene, packed);
        }
        Self { components: packed.components.clone(), stamps: stamps(scene), ..self.clone() }
    }

    /// Returns whether the scene's primitives have not changed since the last build or refit.
    pub(crate) fn is_of(&self, scene: &Scene) -> bool {
        self.stamps == stamps(scene)
    }

    /// Returns the tree with the same links, refitted to the current scene. If a triangle became degenerate, its slot
    /// gets a copy of another primitive. A ray may test that primitive twice, which changes no hit.
    ///
    /// # Errors
    /// [`Error::Scene`] if the tree lacks a primitive that is traced now, or a list has become too long.
    pub(crate) fn refit(&self, scene: &Scene, kind: Boxes) -> Result<PackedBvh, Error> {
        if self.flat {
            return super::build(scene, BvhBuild::Flat, kind);
        }
        let boxes: Vec<Aabb> = boxes_of(scene).collect();
        self.check(scene, &boxes)?;
        check_materials(scene)?;
        let same_triangles = self.stamps[0] == scene.triangles_stamp && self.counts == counts(scene);
        let components = if same_triangles { self.components.clone() } else { Arc::new(components::of(scene)) };
        let Some(&stand_in) = self.ids.iter().find(|&&id| !is_empty(&boxes[id as usize])) else {
            return Ok(PackedBvh::without_tree(scene, kind, components));
        };
        let pairs = self.pair_boxes(&boxes);
        let root = pairs[0][0].union(&pairs[0][1]);
        let traced = || boxes.iter().filter(|one| !is_empty(one)).copied();
        let grid = Grid::around(&root, kind == Boxes::F32 && has_fine_detail(traced()));
        let mut nodes = Vec::with_capacity(2 * pairs.len() * child_texels(kind));
        for (boxes, links) in pairs.iter().zip(&*self.links) {
            for (aabb, &link) in boxes.iter().zip(links) {
                // An empty child becomes a point in the scene's corner, where hardly any ray passes.
                let (low, high) = if is_empty(aabb) { (root.min, root.min) } else { (aabb.min, aabb.max) };
                nodes.extend(grid.pack(kind, low.into(), high.into(), link));
            }
        }
        let is_traced = |id: u32| !is_empty(&boxes[id as usize]) || scene.plane_ids().contains(&id);
        let ids: Vec<u32> = self.ids.iter().map(|&id| if is_traced(id) { id } else { stand_in }).collect();
        let mut primitives = Vec::with_capacity(ids.len() * texels_of_each(scene));
        ids.iter().for_each(|&id| push_primitive(&mut primitives, scene, &components, id));
        Ok(PackedBvh {
            uniform: grid.uniform(),
            nodes,
            pair_texels: 2 * child_texels(kind),
            primitives,
            masks: masks_of(scene),
            ids,
            components,
            world_boxes: grid.world,
            stack_size: self.stack_size,
            flat: false,
        })
    }

    /// Returns both boxes of each pair of nodes, computed from the last pair to the first.
    fn pair_boxes(&self, boxes: &[Aabb]) -> Vec<[Aabb; 2]> {
        let mut pairs = vec![[Aabb::empty(); 2]; self.links.len()];
        for pair in (0..pairs.len()).rev() {
            pairs[pair] = self.links[pair].map(|link| {
                if link & LEAF == 0 {
                    let [a, b] = pairs[link as usize];
                    return a.union(&b);
                }
                let (first, count) = ((link & 0x0fff_ffff) as usize, (link >> 28 & 7) as usize + 1);
                let held = self.ids[first..first + count].iter().map(|&id| boxes[id as usize]);
                held.fold(Aabb::empty(), |sum, one| sum.union(&one))
            });
        }
        pairs
    }

    /// Checks that the tree contains every primitive that is traced now.
    fn check(&self, scene: &Scene, boxes: &[Aabb]) -> Result<(), Error> {
        let fault = |element: String, reason: String| {
            Err(Error::Scene { element, reason: format!("{reason}; use Update::Rebuild") })
        };
        let count = |[triangles, spheres, ellipsoids, planes]: [usize; 4]| match (ellipsoids, planes) {
            (0, 0) => format!("{triangles} triangles and {spheres} spheres"),
            (_, 0) => format!("{triangles} triangles, {spheres} spheres and {ellipsoids} ellipsoids"),
            _ => format!("{triangles} triangles, {spheres} spheres, {ellipsoids} ellipsoids and {planes} planes"),
        };
        let now = counts(scene);
        if now != self.counts {
            let (now, then) = (count(now), count(self.counts));
            return fault(
                "geometry".into(),
                format!("the tree to refit was built from {then}, but the scene now has {now}"),
            );
        }
        let mut held = vec![false; boxes.len()];
        self.ids.iter().for_each(|&id| held[id as usize] = true);
        for &(copy, of) in &*self.copies {
            held[copy as usize] = true;
            if !is_empty(&boxes[copy as usize]) && geometry(scene, copy) != geometry(scene, of) {
                let reason =
                    format!("the tree to refit does not contain it, because it was an exact copy of primitive {of}");
                return fault(format!("primitive {copy}"), reason);
            }
        }
        match (0..boxes.len()).find(|&id| !held[id] && !is_empty(&boxes[id])) {
            None => Ok(()),
            Some(id) => {
                let reason = "the tree to refit does not contain it, because it had no area".into();
                fault(format!("triangle {id}"), reason)
            }
        }
    }
}

/// Returns the traced primitives that are not among `ids`, each with the primitive that it copies.
fn copies(scene: &Scene, ids: &[u32]) -> Vec<(u32, u32)> {
    let mut held = vec![false; scene.primitive_count()];
    ids.iter().for_each(|&id| held[id as usize] = true);
    let traced = |id: u32| scene.triangles().get(id as usize).is_none_or(|triangle| !triangle.is_degenerate());
    let copies: Vec<u32> = (0..held.len() as u32).filter(|&id| !held[id as usize] && traced(id)).collect();
    let mut first = HashMap::with_hasher(RandomState::new());
    first.extend(copies.iter().map(|&id| (geometry(scene, id), id)));
    if !copies.is_empty() {
        for &id in ids {
            first.entry(geometry(scene, id)).and_modify(|of| *of = id);
        }
    }
    copies.iter().map(|&id| (id, first[&geometry(scene, id)])).collect()
}
