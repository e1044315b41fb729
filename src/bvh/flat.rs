//! All primitives in one list, which every ray goes through from its first one on: the classical ray tracer, as a
//! baseline.
//!
//! The list is a tree whose boxes all hold everything, so that the kernels that go through trees go through it too: by
//! the same text, with the same functions for primitives, in another order alone. A leaf holds eight primitives at
//! most, so a ray visits a pair of boxes for every eight of them besides.

use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, node::Bvh2Node},
};

use super::{BvhBuild, MAX_LEAF};
use crate::Error;

/// How far the boxes reach from the world's origin to each side: a fifth farther than a scene's coordinates, and so far
/// from an eye's that its distance times the largest reciprocal of a direction, 1e30, is a number in f32.
const REACH: f32 = 1.2e8;

/// A balanced tree over so many primitives in their order, whose boxes all hold everything.
///
/// # Errors
/// [`Error::Scene`] for more primitives than [`BvhBuild::MAX_FLAT`].
pub(super) fn tree(count: usize) -> Result<Bvh2, Error> {
    if count > BvhBuild::MAX_FLAT {
        let reason = format!(
            "{count} primitives, over the {} that BvhBuild::Flat takes, since every ray is tested against each; build a tree",
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
        // The first half is no larger than the second one: so a leaf never stands behind what is deeper, and slots are
        // in order.
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
