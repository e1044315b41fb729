//! The BVH: built by `obvhs` on the host, and packed for shaders/shared/bvh.wgsl.

mod flat;
mod primitive;
mod refit;

use std::sync::Arc;

pub(crate) use primitive::reach_bits;
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
    /// For one picture or a few.
    #[default]
    Balanced,
    /// The best tree: for scenes rendered many times.
    Best,
    /// A list instead of a tree, as in the classical ray tracer: a baseline for measurements, for at most
    /// [`BvhBuild::MAX_FLAT`] primitives. A closest-hit ray tests every primitive in the scene's order, exact copies
    /// included. A shadow ray stops at its first hit. The picture equals a tree's, bit for bit if f32 is not
    /// contracted.
    ///
    /// A ray also visits a pair of all-enclosing boxes for every eight primitives. A single primitive is tested twice.
    /// A ray from over 1.2e8 units off the world's origin that leads away from it tests none.
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

/// Flag of a leaf's link: bits 28 to 30 hold count - 1, the lower bits the first slot.
pub(crate) const LEAF: u32 = 0x8000_0000;
const MAX_LEAF: u32 = 8;
const MAX_SLOTS: usize = (1 << 28) - 8;
/// Maximum that 16 bits can number.
const MAX_MATERIALS: usize = 1 << 16;
/// Steps per side of the grid that boxes are stored on.
const GRID: f64 = 65535.0;
/// If a scene's detail is smaller than this share of it, each box is widened by its own distance.
const FINE_DETAIL: f32 = 1.0 / 65536.0;

/// Packed geometry of a scene, ready to upload.
pub(crate) struct PackedBvh {
    pub(crate) uniform: layout::Bvh,
    /// Pairs of child boxes, the root's first.
    pub(crate) nodes: Vec<Texel>,
    /// Texels per pair: two, or four with f32 boxes.
    pub(crate) pair_texels: usize,
    /// Texels of the planes, which are in no leaf, then of the primitives in leaf order. A primitive has three texels,
    /// a fourth if the scene has vertex normals or ellipsoids, and more with texture coordinates or colours.
    pub(crate) primitives: Vec<Texel>,
    /// Cut-out masks made by `cutouts::masks_of`.
    pub(crate) masks: Vec<Texel>,
    /// Scene id of each primitive, in the same order.
    pub(crate) ids: Vec<u32>,
    /// Connected component of each primitive, by id, from `scene::components`.
    pub(crate) components: Arc<Vec<u32>>,
    /// Whether boxes are in world coordinates, see `shaders/shared/boxes.wgsl`.
    pub(crate) world_boxes: bool,
    /// Maximum stack words of a traversal, rounded up to a multiple of 8.
    pub(crate) stack_size: u32,
    /// Whether it is a list ([`BvhBuild::Flat`]), whose boxes enclose everything.
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
            nodes: vec![[0; 4]; pair_texels], // no kernel of such a scene reads it
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

/// Returns the boxes of all primitives; empty ones for untraced primitives and for planes.
fn boxes_of(scene: &Scene) -> impl Iterator<Item = Aabb> {
    let triangles = scene.triangles().iter().map(|triangle| {
        let [a, b, c] = triangle.corners;
        match triangle.is_degenerate() {
            true => Aabb::empty(),
            false => Aabb::new(a.min(b).min(c).into(), a.max(b).max(c).into()),
        }
    });
    let around = |center: Vec3, half: DVec3| {
        // Rounded outwards: far from the origin a radius can be less than an f32 step.
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

/// Builds the tree of a scene's primitives. It leaves out degenerate triangles and later copies of a primitive, which
/// must have the same holes if cut out. At equal t the smaller id wins, so no ray hits a copy. (A list,
/// [`BvhBuild::Flat`], keeps copies.)
///
/// # Errors
/// [`Error::Scene`] if there are more primitives than links can number, or than [`BvhBuild::Flat`] allows.
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
    // The root's sentinel, one link per level, and the rest of an interrupted leaf.
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

/// Returns the texels of a child's box and link.
fn child_texels(boxes: Boxes) -> usize {
    match boxes {
        Boxes::Grid16 => 1,
        Boxes::F32 => 2,
    }
}

/// A grid of 65535 steps a side over the scene's box; boxes are rounded outwards to it.
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
        // A flat side needs a cell too. Rounding up makes the last step reach the far corner.
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

    /// Packs low x, y, z and high x, y, z as 16 bits each, in three words.
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
    /// Ids of the packed primitives, in order: planes first.
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
        // (first of two obvhs nodes, texel that receives the link to their pair, depth)
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

    /// Packs a tree of one leaf as two halves, since the root must be a pair. A single primitive is tested twice, which
    /// changes no hit.
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

/// Returns whether one primitive in ten is far smaller than the scene.
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
