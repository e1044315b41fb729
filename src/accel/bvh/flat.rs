//! A list of all primitives, which every ray traverses from the start. It represents a classical ray tracer and serves
//! as a baseline for measurements.
//!
//! The list is stored as a tree whose boxes all enclose everything. Kernels traverse it with the same code and
//! primitive tests as any other tree, only in another order. A leaf holds at most eight primitives, so a ray also tests
//! a pair of boxes for every eight primitives.

use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, node::Bvh2Node},
};

use super::{BvhBuild, MAX_LEAF};
use crate::Error;

/// Distance of all box faces from the world's origin, a fifth more than the largest coordinate of a scene. The distance
/// from an eye to a face, times the largest reciprocal of a direction (1e30), stays finite in f32.
const REACH: f32 = 1.2e8;

/// Builds a balanced tree over `count` primitives in order, whose boxes all enclose everything.
///
/// # Errors
/// [`Error::Scene`] for more primitives than [`BvhBuild::MAX_FLAT`].
pub(super) fn tree(count: usize) -> Result<Bvh2, Error> {
    if count > BvhBuild::MAX_FLAT {
        let reason = format!(
            "{count} primitives, over the limit of {} for BvhBuild::Flat, where every ray tests each one; build a tree",
            BvhBuild::MAX_FLAT
        );
        return Err(Error::Scene { element: "geometry".into(), reason });
    }
    let count = count as u32;
    let everywhere = Aabb::new([-REACH; 3].into(), [REACH; 3].into());
    let node = |held: u32, first: u32| Bvh2Node::new(everywhere, held, first);
    let mut nodes = vec![node(0, 0)];
    let mut pending = vec![(0, 0..count.div_ceil(MAX_LEAF))];
    while let Some((place, leaves)) = pending.pop() {
        let first = leaves.start * MAX_LEAF;
        if leaves.len() <= 1 {
            nodes[place] = node(MAX_LEAF.min(count - first), first);
            continue;
        }
        // The first half has no more leaves than the second. So no leaf follows a deeper subtree, and primitives keep
        // their order.
        let middle = leaves.start.midpoint(leaves.end);
        let children = nodes.len();
        nodes[place] = node(0, children as u32);
        nodes.extend([node(0, 0); 2]);
        pending.extend([(children, leaves.start..middle), (children + 1, middle..leaves.end)]);
    }
    let mut tree = Bvh2::zeroed(0);
    (tree.nodes, tree.primitive_indices) = (nodes, (0..count).collect());
    Ok(tree)
}
