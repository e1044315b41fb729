//! The BVH (bounding volume hierarchy). The crate `obvhs` builds it on the host, and this module packs it for
//! shaders/shared/bvh.wgsl.

mod flat;
mod primitive;
mod refit;

use std::sync::Arc;

pub(crate) use primitive::{pack_normal, reach_bits};
#[cfg(any(test, feature = "testing"))]
pub(crate) use primitive::{shortest_edge, shortest_edge_first};
pub(crate) use refit::TreeShape;

use glam::{DVec3, Vec3};
use obvhs::{BvhBuildParams, aabb::Aabb, bvh2::Bvh2};

use self::primitive::{geometry, push_primitive};
use crate::{
    Boxes, Error, Scene, accel::cutouts::masks_of, accel::tree, gpu::Texel, kernel::layout, scene::components,
};

/// Effort of building the BVH; docs/TRAVERSAL.md has costs and benefits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum BvhBuild {
    /// Fast build: for scenes that change with every picture.
    Fast,
    /// Compromise of build and traversal time, for scenes rendered once or a few times.
    #[default]
    Balanced,
    /// Slow build of a better tree, for scenes rendered many times.
    Best,
    /// A list instead of a tree, as in a classical ray tracer. It is a baseline for measurements and holds at most
    /// [`BvhBuild::MAX_FLAT`] primitives. A closest-hit ray tests every primitive in the scene's order, exact copies
    /// included. A shadow ray stops at its first hit. The picture is the same as with a tree. It is identical to the
    /// bit if the driver does not contract f32 operations.
    ///
    /// For every eight primitives, a ray also tests a pair of boxes that enclose everything. The only primitive of a
    /// scene is tested twice. A ray that starts over 1.2e8 units from the world's origin and leads away from it tests
    /// no primitive.
    Flat,
}

impl BvhBuild {
    /// All efforts that build a tree, from the fastest to the slowest.
    pub const ALL: &'static [Self] = &[Self::Fast, Self::Balanced, Self::Best];

    /// Maximum number of primitives of [`BvhBuild::Flat`]. A ray and its shadow rays to five lights then still finish
    /// within the 65,535 loop rounds that Mesa's software driver grants a thread.
    pub const MAX_FLAT: usize = 8192;

    /// Returns obvhs's preset, or `None` for a list. Leaves hold up to eight primitives, the maximum that a link can
    /// encode.
    pub(crate) fn params(self) -> Option<BvhBuildParams> {
        let preset = match self {
            Self::Fast => BvhBuildParams::very_fast_build(),
            Self::Balanced => BvhBuildParams::medium_build(),
            Self::Best => BvhBuildParams::slow_build(),
            Self::Flat => return None,
        };
        Some(BvhBuildParams { max_prims_per_leaf: MAX_LEAF, ..preset })
    }
}

/// Flag of a link to a leaf. Bits 28 to 30 of the link hold the number of primitives minus 1. The lower bits hold the
/// slot of the first primitive, which is its index in packed order.
pub(crate) const LEAF: u32 = 0x8000_0000;
const MAX_LEAF: u32 = 8;
const MAX_SLOTS: usize = (1 << 28) - 8;
/// Maximum number of materials, which have 16-bit indices.
const MAX_MATERIALS: usize = 1 << 16;
/// Number of grid steps along each axis, for boxes with 16-bit corners.
const GRID: f64 = 65535.0;
/// Size of fine detail, as a fraction of the scene's extent. If detail is smaller, each box is widened in proportion to
/// its distance from the ray's origin.
const FINE_DETAIL: f32 = 1.0 / 65536.0;

/// Packed geometry of a scene, ready to upload.
pub(crate) struct PackedBvh {
    pub(crate) uniform: layout::Bvh,
    /// Boxes and links of the nodes, in pairs of siblings. The children of the root are the first pair.
    pub(crate) nodes: Vec<Texel>,
    /// Number of texels per pair of nodes: two, or four with f32 boxes.
    pub(crate) pair_texels: usize,
    /// Texels of the primitives. Planes come first, since they are in no leaf, and other primitives follow in the order
    /// of leaves. A primitive has three texels, and a fourth if the scene has vertex normals or ellipsoids. Texture
    /// coordinates and colours take further texels.
    pub(crate) primitives: Vec<Texel>,
    /// Texels of the cut-out masks, made by `cutouts::masks_of`.
    pub(crate) masks: Vec<Texel>,
    /// Scene id of each primitive, in the order of `primitives`.
    pub(crate) ids: Vec<u32>,
    /// Connected component of each primitive, indexed by scene id; see `scene::components`.
    pub(crate) components: Arc<Vec<u32>>,
    /// Whether boxes are in world coordinates, see `shaders/shared/boxes.wgsl`.
    pub(crate) world_boxes: bool,
    /// Maximum number of stack words that a traversal needs, rounded up to a multiple of 8.
    pub(crate) stack_size: u32,
    /// Whether the tree represents a list ([`BvhBuild::Flat`]), in which all boxes enclose everything.
    pub(crate) flat: bool,
}

impl PackedBvh {
    /// Packs a scene in which only planes can be hit.
    fn without_tree(scene: &Scene, kind: Boxes, components: Arc<Vec<u32>>) -> Self {
        let pair_texels = 2 * child_texels(kind);
        let mut primitives = Vec::new();
        scene.plane_ids().for_each(|id| push_primitive(&mut primitives, scene, &components, id));
        Self {
            uniform: layout::Bvh::default(),
            nodes: vec![[0; 4]; pair_texels], // no kernel reads nodes of such a scene
            pair_texels,
            primitives,
            masks: Vec::new(),
            ids: scene.plane_ids().collect(),
            components,
            world_boxes: false,
            stack_size: 8,
            flat: false,
        }
    }
}

/// Returns the bounding boxes of all primitives. Degenerate triangles and planes have empty boxes.
pub(super) fn boxes_of(scene: &Scene) -> impl Iterator<Item = Aabb> {
    let triangles = scene.triangles().iter().map(|triangle| {
        let [a, b, c] = triangle.corners;
        match triangle.is_degenerate() {
            true => Aabb::empty(),
            false => Aabb::new(a.min(b).min(c).into(), a.max(b).max(c).into()),
        }
    });
    let around = |center: Vec3, half: DVec3| {
        // Corners are rounded outwards, since far from the origin a radius can be less than an f32 step.
        let low = (center.as_dvec3() - half).as_vec3().to_array().map(f32::next_down);
        let high = (center.as_dvec3() + half).as_vec3().to_array().map(f32::next_up);
        Aabb::new(Vec3::from_array(low).into(), Vec3::from_array(high).into())
    };
    let spheres = scene.spheres().iter().map(move |one| around(one.center, DVec3::splat(f64::from(one.radius))));
    let ellipsoids = scene.ellipsoids().iter().map(move |one| around(one.center, one.half_extent()));
    // Planes have no box: rays test them separately (shaders/shared/planes.wgsl).
    let planes = std::iter::repeat_n(Aabb::empty(), scene.planes().len());
    triangles.chain(spheres).chain(ellipsoids).chain(planes)
}

fn is_empty(aabb: &Aabb) -> bool {
    aabb.min.x > aabb.max.x
}

/// Builds the tree of a scene's primitives. The tree leaves out degenerate triangles and exact copies of earlier
/// primitives. Copies of cut-out triangles must also have the same holes. At equal t the primitive with the smaller id
/// wins, so no ray would hit a copy. A list ([`BvhBuild::Flat`]) keeps copies.
///
/// # Errors
/// [`Error::Scene`] if there are more primitives than a link can address, or more than [`BvhBuild::Flat`] allows.
pub(crate) fn build(scene: &Scene, build: BvhBuild, kind: Boxes) -> Result<PackedBvh, Error> {
    let (ids, boxes): (Vec<u32>, Vec<Aabb>) = (0..).zip(boxes_of(scene)).filter(|(_, aabb)| !is_empty(aabb)).unzip();
    let components = Arc::new(components::of(scene));
    check_materials(scene)?;
    if ids.is_empty() {
        return Ok(PackedBvh::without_tree(scene, kind, components));
    }
    if ids.len() > MAX_SLOTS {
        let reason = format!("{} primitives; a tree can have at most {MAX_SLOTS}", ids.len());
        return Err(Error::Scene { element: "geometry".into(), reason });
    }
    let compare = |a: u32, b: u32| geometry(scene, ids[a as usize]).cmp(&geometry(scene, ids[b as usize]));
    let flat = build == BvhBuild::Flat;
    let tree = match build.params() {
        Some(params) => tree::build(&boxes, params, &compare),
        None => flat::tree(ids.len())?,
    };
    let world = kind == Boxes::F32 && !flat && has_fine_detail(boxes.iter().copied());
    let grid = Grid::around(tree.nodes[0].aabb(), world);
    let mut packer = Packer {
        scene,
        tree: &tree,
        ids: &ids,
        components: &components,
        kind,
        grid,
        nodes: Vec::new(),
        primitives: Vec::new(),
        packed: Vec::new(),
    };
    scene.plane_ids().for_each(|id| packer.push(id));
    let depth = packer.pack_nodes();
    // The stack holds a sentinel for the root, one link per level, and the rest of an interrupted leaf.
    let stack_size = (depth + 2).next_multiple_of(8);
    Ok(PackedBvh {
        world_boxes: grid.world,
        uniform: packer.grid.uniform(),
        nodes: packer.nodes,
        pair_texels: 2 * child_texels(kind),
        primitives: packer.primitives,
        masks: masks_of(scene),
        ids: packer.packed,
        components,
        stack_size,
        flat,
    })
}

fn check_materials(scene: &Scene) -> Result<(), Error> {
    let count = scene.materials().len();
    if count <= MAX_MATERIALS {
        return Ok(());
    }
    let reason = format!("{count} materials; a scene can have at most {MAX_MATERIALS}");
    Err(Error::Scene { element: "materials".into(), reason })
}

/// Returns the number of texels that hold the box and link of a child.
fn child_texels(boxes: Boxes) -> usize {
    match boxes {
        Boxes::Grid16 => 1,
        Boxes::F32 => 2,
    }
}

/// A grid of 65535 steps per axis over the scene's bounding box. Box corners are rounded outwards to grid points.
#[derive(Clone, Copy)]
struct Grid {
    origin: Vec3,
    cell: Vec3,
    extent: f32,
    /// Whether f32 boxes are stored in world coordinates.
    world: bool,
}

impl Grid {
    fn around(all: &Aabb, world: bool) -> Self {
        let (low, high) = (Vec3::from(all.min), Vec3::from(all.max));
        let sides = high.as_dvec3() - low.as_dvec3();
        let extent = sides.max_element() as f32;
        // A cell needs a positive size even if the scene is flat along an axis. Rounding up makes the last step reach
        // the far corner.
        let least = f64::from(extent.max(f32::MIN_POSITIVE * 1e6)) * 1e-9;
        let cell = (sides / GRID).max(DVec3::splat(least)).as_vec3();
        let cell = Vec3::from_array(cell.to_array().map(|side| side.next_up().next_up()));
        // Boxes in world coordinates are not relative to the grid.
        let (origin, extent) = if world { (Vec3::ZERO, 0.0) } else { (low, extent) };
        Self { origin, cell, extent, world }
    }

    fn uniform(&self) -> layout::Bvh {
        layout::Bvh {
            grid_origin: self.origin.to_array(),
            extent: self.extent,
            grid_cell: self.cell.to_array(),
            zero: 0,
            ..Default::default()
        }
    }

    /// Packs a box and its link into texels, see `shaders/shared/boxes.wgsl`.
    fn pack(&self, kind: Boxes, low: Vec3, high: Vec3, link: u32) -> Vec<Texel> {
        match kind {
            Boxes::Grid16 => {
                let [x, y, z] = self.pack_16bit(low, high);
                vec![[x, y, z, link]]
            }
            Boxes::F32 if self.world => {
                let [low, high] = [low, high].map(|corner| corner.to_array().map(f32::to_bits));
                vec![[low[0], low[1], low[2], link], [high[0], high[1], high[2], 0]]
            }
            Boxes::F32 => {
                let [low, high] = [low, high].map(|corner| corner.as_dvec3() - self.origin.as_dvec3());
                let low = low.as_vec3().to_array().map(|v| v.next_down().to_bits());
                let high = high.as_vec3().to_array().map(|v| v.next_up().to_bits());
                vec![[low[0], low[1], low[2], link], [high[0], high[1], high[2], 0]]
            }
        }
    }

    /// Packs the coordinates of both corners as 16 bits each, in three words.
    fn pack_16bit(&self, low: Vec3, high: Vec3) -> [u32; 3] {
        let steps = |corner: Vec3| (corner.as_dvec3() - self.origin.as_dvec3()) / self.cell.as_dvec3();
        let low = steps(low).floor().clamp(DVec3::ZERO, DVec3::splat(GRID)).as_uvec3();
        let high = steps(high).ceil().clamp(DVec3::ZERO, DVec3::splat(GRID)).as_uvec3();
        [low.x | low.y << 16, low.z | high.x << 16, high.y | high.z << 16]
    }
}

struct Packer<'a> {
    scene: &'a Scene,
    tree: &'a Bvh2,
    ids: &'a [u32],
    components: &'a [u32],
    kind: Boxes,
    grid: Grid,
    nodes: Vec<Texel>,
    primitives: Vec<Texel>,
    /// Scene ids of the packed primitives, in packed order.
    packed: Vec<u32>,
}

impl Packer<'_> {
    /// Packs pairs in depth-first order and returns the number of pairs on the deepest path. A traversal leaves at most
    /// one link per pair on its stack.
    fn pack_nodes(&mut self) -> u32 {
        let root = &self.tree.nodes[0];
        if root.is_leaf() {
            self.pack_single_leaf();
            return 1;
        }
        let mut deepest = 0;
        // An entry has the first of two sibling nodes of obvhs, the texel that receives the link to their pair, and
        // their depth.
        let mut pending: Vec<(usize, Option<usize>, u32)> = vec![(root.first_index as usize, None, 1)];
        while let Some((first, link, depth)) = pending.pop() {
            let child_texels = child_texels(self.kind);
            let pair = self.nodes.len() / (2 * child_texels);
            if let Some(link) = link {
                self.nodes[link][3] = pair as u32;
            }
            deepest = deepest.max(depth);
            for child in [first, first + 1] {
                let node = self.tree.nodes[child];
                let link = if node.is_leaf() { self.pack_leaf(node.first_index, node.prim_count) } else { 0 };
                self.nodes.extend(self.grid.pack(self.kind, node.min, node.max, link));
            }
            for (child, texel) in [(first + 1, (2 * pair + 1) * child_texels), (first, 2 * pair * child_texels)] {
                let node = self.tree.nodes[child];
                if !node.is_leaf() {
                    pending.push((node.first_index as usize, Some(texel), depth + 1));
                }
            }
        }
        deepest
    }

    /// Packs a tree of one leaf as two leaves, since the first nodes must be a pair. Each leaf gets half of the
    /// primitives. A single primitive is in both leaves. A ray tests it twice, which changes no hit.
    fn pack_single_leaf(&mut self) {
        let root = self.tree.nodes[0];
        let half = root.prim_count / 2;
        let second = self.pack_leaf(root.first_index + half, root.prim_count - half);
        let first = if half > 0 { self.pack_leaf(root.first_index, half) } else { second };
        for link in [first, second] {
            self.nodes.extend(self.grid.pack(self.kind, root.min, root.max, link));
        }
    }

    fn pack_leaf(&mut self, first: u32, count: u32) -> u32 {
        let link = LEAF | (count - 1) << 28 | self.packed.len() as u32;
        for index in first..first + count {
            let id = self.ids[self.tree.primitive_indices[index as usize] as usize];
            self.push(id);
        }
        link
    }

    fn push(&mut self, id: u32) {
        self.packed.push(id);
        push_primitive(&mut self.primitives, self.scene, self.components, id);
    }
}

/// Returns whether more than a tenth of the primitives are smaller than [`FINE_DETAIL`] times the scene's extent.
fn has_fine_detail(boxes: impl Iterator<Item = Aabb>) -> bool {
    let side = |aabb: &Aabb| Vec3::from(aabb.max - aabb.min).max_element();
    let mut all = Aabb::empty();
    let mut sides: Vec<f32> = boxes.inspect(|one| all = all.union(one)).map(|one| side(&one)).collect();
    let place = sides.len() / 10;
    let (_, small, _) = sides.select_nth_unstable_by(place, f32::total_cmp);
    *small < side(&all) * FINE_DETAIL
}

#[cfg(test)]
mod tests;
