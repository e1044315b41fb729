//! Builds trees over boxes like obvhs, but with bounded depth and in O(n log n) time for any boxes.
//!
//! In each pass, obvhs merges the nodes that are each other's best partners (PLOC, Meister and Bittner 2018). If boxes
//! are equal, nested, or in a line at equal distances, a pass may merge a single pair. The time is then quadratic, and
//! the tree of nested boxes is a chain. This module therefore runs the passes itself and counts them. Afterwards obvhs
//! optimises the tree by reinsertion and collapses leaves.

use std::cmp::Ordering;

use glam::DVec3;
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{
        Bvh2, DEFAULT_MAX_STACK_DEPTH, leaf_collapser::collapse, node::Bvh2Node, reinsertion::ReinsertionOptimizer,
    },
    ploc::{
        PlocSearchDistance, SortPrecision,
        morton::{morton_encode_u64_unorm, morton_encode_u128_unorm},
    },
};
#[cfg(not(target_arch = "wasm32"))]
use rayon::{
    iter::{IndexedParallelIterator, ParallelIterator},
    slice::ParallelSliceMut,
};

/// Maximum number of node pairs on a path from the root.
pub(crate) const MAX_DEPTH: u32 = 240;
/// Maximum number of nodes that the passes may visit: `WORK` per box, plus `WORK_BESIDES`. Scenes need 3 to 5 per box,
/// and random large boxes need 9. A few hundred equal boxes need more per box, but far less than `WORK_BESIDES`.
const WORK: usize = 32;
const WORK_BESIDES: usize = 1 << 21;
/// Number of PLOC passes if a tree came out too deep and is built again. Later passes merge neighbours in pairs. This
/// is the smallest number that keeps most of PLOC's choices.
const PASSES_OF_DEEP: usize = 48;
/// If sampled nodes lie deeper than this, the depth of the tree is measured before each round of reinsertion. A round
/// may double the depth.
const DEEP: u32 = 48;
/// Depth of deep trees that is reported to obvhs, which allocates a stack for twice this depth. A round of reinsertion
/// starts from a shallower tree, so the stack suffices even if the depth doubles.
const STACK: usize = 256;
/// Maximum length of a run of equal Morton codes that is not sorted further. Longer runs are sorted by finer codes.
const LONG_RUN: usize = 8;
/// With fewer nodes than this, one thread is faster than several, as in obvhs. wasm32 has one thread only.
#[cfg(not(target_arch = "wasm32"))]
const PARALLEL: usize = 4000;

/// Builds a tree over boxes. If `compare` finds primitives equal, only the box of the first primitive is in the tree.
pub(crate) fn build(boxes: &[Aabb], params: BvhBuildParams, compare: &impl Fn(u32, u32) -> Ordering) -> Bvh2 {
    let extent = boxes.iter().fold(Aabb::empty(), |sum, one| sum.union(one)).diagonal().max_element();
    if extent > 0.0 && extent < 1e-9 {
        // In f32, areas of such small boxes are 0. Scaling by a power of two changes nothing else.
        let scaled = |factor: f32| move |one: &Aabb| Aabb::new(one.min * factor, one.max * factor);
        let factor = 2_f32.powi(100);
        let mut tree = build_of_size(&boxes.iter().map(scaled(factor)).collect::<Vec<_>>(), params, compare);
        tree.nodes.iter_mut().for_each(|node| node.set_aabb(scaled(1.0 / factor)(node.aabb())));
        return tree;
    }
    build_of_size(boxes, params, compare)
}

fn build_of_size(boxes: &[Aabb], params: BvhBuildParams, compare: &impl Fn(u32, u32) -> Ordering) -> Bvh2 {
    let order = in_order(boxes, params.sort_precision, compare);
    let mut tree = merged(boxes, &order, &params, usize::MAX);
    if tree.max_depth == DEFAULT_MAX_STACK_DEPTH || depth(&tree) <= MAX_DEPTH {
        let mut optimizer = ReinsertionOptimizer::default();
        let ratio = params.reinsertion_batch_ratio;
        reinsert(&mut tree, &mut optimizer, ratio);
        collapse(&mut tree, params.max_prims_per_leaf, params.collapse_traversal_cost);
        reinsert(&mut tree, &mut optimizer, ratio * params.post_collapse_reinsertion_batch_ratio_multiplier);
    }
    if depth(&tree) > MAX_DEPTH {
        tree = merged(boxes, &order, &params, PASSES_OF_DEEP);
        collapse(&mut tree, params.max_prims_per_leaf, params.collapse_traversal_cost);
    }
    tree
}

/// Returns the number of node pairs on the longest path from the root.
fn depth(tree: &Bvh2) -> u32 {
    let mut deepest = 0;
    let mut pending = vec![(0, 0)];
    while let Some((index, depth)) = pending.pop() {
        let node: &Bvh2Node = &tree.nodes[index];
        deepest = deepest.max(depth);
        if !node.is_leaf() {
            let first = node.first_index as usize;
            pending.extend([(first, depth + 1), (first + 1, depth + 1)]);
        }
    }
    deepest
}

/// Runs obvhs's rounds of reinsertion one by one. With nested boxes each round may double the depth, but obvhs's stack
/// does not grow.
fn reinsert(tree: &mut Bvh2, optimizer: &mut ReinsertionOptimizer, batch_ratio: f32) {
    for divisor in (1..32).step_by(2) {
        if looks_deep(tree) && depth(tree) > MAX_DEPTH {
            return;
        }
        optimizer.run(tree, batch_ratio, Some(vec![1.0 / divisor as f32]));
    }
}

/// Returns whether the tree took many passes, or some of about a hundred sampled nodes lie deep. Measuring all nodes
/// would take longer.
fn looks_deep(tree: &Bvh2) -> bool {
    let level = |mut index: usize| {
        let mut level = 0;
        while index > 0 {
            index = tree.parents[index] as usize;
            level += 1;
        }
        level
    };
    let step = tree.parents.len() / 128 + 1;
    tree.max_depth > DEFAULT_MAX_STACK_DEPTH || (0..tree.parents.len()).step_by(step).any(|index| level(index) > DEEP)
}

/// Returns the indices of boxes in the Morton order of their centres, without copies of earlier primitives.
fn in_order(boxes: &[Aabb], precision: SortPrecision, compare: &impl Fn(u32, u32) -> Ordering) -> Vec<u32> {
    let total = boxes.iter().fold(Aabb::empty(), |sum, one| sum.union(one));
    let scale = 1.0 / total.diagonal().as_dvec3();
    let offset = -total.min.as_dvec3() * scale;
    let place = |one: &Aabb| one.center().as_dvec3() * scale + offset;
    let places = (0..).zip(boxes).map(|(index, one)| (place(one), index));
    let mut order = Vec::with_capacity(boxes.len());
    match precision {
        SortPrecision::U64 => {
            let codes = places.map(|(place, index)| (morton_encode_u64_unorm(place), index)).collect();
            push_sorted(boxes, codes, compare, &mut order);
        }
        SortPrecision::U128 => {
            let codes = places.map(|(place, index)| (morton_encode_u128_unorm(place), index)).collect();
            push_sorted(boxes, codes, compare, &mut order);
        }
    }
    order
}

fn push_sorted<C: Ord + Copy + Send>(
    boxes: &[Aabb],
    mut codes: Vec<(C, u32)>,
    compare: &impl Fn(u32, u32) -> Ordering,
    order: &mut Vec<u32>,
) {
    #[cfg(not(target_arch = "wasm32"))]
    codes.par_sort_unstable_by_key(|&(code, _)| code);
    #[cfg(target_arch = "wasm32")]
    codes.sort_unstable_by_key(|&(code, _)| code);
    for run in codes.chunk_by(|a, b| a.0 == b.0) {
        match run {
            [(_, index)] => order.push(*index),
            _ if run.len() <= LONG_RUN => {
                let copy = |of: u32| run.iter().any(|&(_, index)| index < of && compare(index, of).is_eq());
                order.extend(run.iter().map(|&(_, index)| index).filter(|&index| !copy(index)));
            }
            _ => push_run(boxes, run.iter().map(|&(_, index)| index).collect(), compare, order),
        }
    }
}

/// Sorts boxes of equal codes by finer codes within the bounds of their centres. If all centres are equal, boxes are
/// sorted by area.
fn push_run(boxes: &[Aabb], mut run: Vec<u32>, compare: &impl Fn(u32, u32) -> Ordering, order: &mut Vec<u32>) {
    let center = |index: u32| boxes[index as usize].min.as_dvec3() + boxes[index as usize].max.as_dvec3();
    let around = |(low, high): (DVec3, DVec3), &index: &u32| (low.min(center(index)), high.max(center(index)));
    let (low, high) = run.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), around);
    if low == high {
        let area = |index: u32| {
            let side = boxes[index as usize].max.as_dvec3() - boxes[index as usize].min.as_dvec3();
            side.dot(DVec3::new(side.y, side.z, side.x))
        };
        run.sort_unstable_by(|&a, &b| area(a).total_cmp(&area(b)).then_with(|| compare(a, b)).then(a.cmp(&b)));
        run.dedup_by(|later, first| compare(*later, *first).is_eq());
        order.append(&mut run);
        return;
    }
    // The factor is below 1, since 1 would get the same code as 0. Each round thus separates at least two centres.
    let scale = 0.999 / (high - low).max_element();
    let code = |index: u32| morton_encode_u64_unorm((center(index) - low) * scale);
    push_sorted(boxes, run.iter().map(|&index| (code(index), index)).collect(), compare, order);
}

/// Runs PLOC over ordered boxes: each pass merges the nodes that are each other's best partners. Once the allowed work
/// or passes are used up, neighbours are merged in pairs, so each pass halves the number of nodes.
fn merged(boxes: &[Aabb], order: &[u32], params: &BvhBuildParams, max_passes: usize) -> Bvh2 {
    let mut nodes: Vec<_> = order.iter().map(|&index| Bvh2Node::new(boxes[index as usize], 1, index)).collect();
    let mut next = nodes.clone();
    let mut partners = vec![0; nodes.len()];
    let mut tree = Bvh2::zeroed(nodes.len());
    tree.primitive_indices = (0..boxes.len() as u32).collect();
    tree.children_are_ordered_after_parents = true;
    let mut unused = tree.nodes.len();
    let mut work = WORK * nodes.len() + WORK_BESIDES;
    let mut pass = 0;
    while nodes.len() > 1 {
        let partners = &mut partners[..nodes.len()];
        if work < nodes.len() || pass >= max_passes {
            pair_neighbours(partners);
        } else {
            work -= nodes.len();
            let quick = pass < params.search_depth_threshold;
            find_partners(
                &nodes,
                if quick { PlocSearchDistance::Minimum } else { params.ploc_search_distance },
                partners,
            );
        }
        next.clear();
        for (index, &node) in nodes.iter().enumerate() {
            let other = index.wrapping_add_signed(partners[index]);
            if other.wrapping_add_signed(partners[other]) != index {
                next.push(node);
            } else if other < index {
                unused -= 2;
                tree.nodes[unused] = node;
                tree.nodes[unused + 1] = nodes[other];
                next.push(Bvh2Node::new(node.aabb().union(nodes[other].aabb()), 0, unused as u32));
            }
        }
        std::mem::swap(&mut nodes, &mut next);
        pass += 1;
    }
    tree.nodes[0] = nodes[0];
    if pass > DEFAULT_MAX_STACK_DEPTH {
        tree.max_depth = STACK;
    }
    tree
}

/// Sets the offset of each node's partner so that neighbours are paired. If the number of nodes is odd, the last node
/// is not paired.
fn pair_neighbours(partners: &mut [isize]) {
    partners.iter_mut().enumerate().for_each(|(index, partner)| *partner = if index % 2 == 0 { 1 } else { -1 });
    if let [.., last] = partners {
        *last = -1;
    }
}

fn find_partners(nodes: &[Bvh2Node], distance: PlocSearchDistance, partners: &mut [isize]) {
    match distance {
        PlocSearchDistance::Minimum => find_within::<1>(nodes, partners),
        PlocSearchDistance::VeryLow => find_within::<2>(nodes, partners),
        PlocSearchDistance::Low => find_within::<6>(nodes, partners),
        PlocSearchDistance::Medium => find_within::<14>(nodes, partners),
        PlocSearchDistance::High => find_within::<24>(nodes, partners),
        PlocSearchDistance::VeryHigh => find_within::<32>(nodes, partners),
    }
}

fn find_within<const DISTANCE: usize>(nodes: &[Bvh2Node], partners: &mut [isize]) {
    #[cfg(not(target_arch = "wasm32"))]
    if nodes.len() >= PARALLEL {
        let length = nodes.len().div_ceil(4 * rayon::current_num_threads());
        let parts = partners.par_chunks_mut(length).enumerate();
        parts.for_each(|(part, partners)| find_part::<DISTANCE>(nodes, part * length, partners));
        return;
    }
    find_part::<DISTANCE>(nodes, 0, partners);
}

/// Finds for each node the partner whose union with the node has the smallest area. Among equal candidates the last one
/// is chosen.
fn find_part<const DISTANCE: usize>(nodes: &[Bvh2Node], start: usize, partners: &mut [isize]) {
    // Row i modulo DISTANCE holds the areas of the unions of node i with the nodes after it. When the loop reaches one
    // of those nodes, it reuses the areas.
    let mut areas = [[0.0; DISTANCE]; DISTANCE];
    for index in start.saturating_sub(DISTANCE)..start + partners.len() {
        let mut best = (f32::INFINITY, 0);
        if index >= start {
            for back in (1..=DISTANCE.min(index)).rev() {
                let area = areas[(index - back) % DISTANCE][back - 1];
                if area <= best.0 {
                    best = (area, -(back as isize));
                }
            }
        }
        let own = nodes[index].aabb();
        for ((other, stored), ahead) in nodes[index + 1..].iter().zip(&mut areas[index % DISTANCE]).zip(1..) {
            let area = own.union(other.aabb()).half_area();
            *stored = area;
            if area <= best.0 {
                best = (area, ahead);
            }
        }
        if index >= start {
            partners[index - start] = best.1;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use glam::Vec3;
    use obvhs::bvh2::builder::build_bvh2;

    use super::*;
    use crate::{BvhBuild, random::Random};

    fn cube(center: Vec3, half: f32) -> Aabb {
        Aabb::new((center - half).into(), (center + half).into())
    }

    /// Checks that every box is in exactly one leaf, and within the boxes of all its ancestors. A leaf must have at
    /// most eight boxes. Returns the depth.
    fn check(tree: &Bvh2, boxes: &[Aabb]) -> u32 {
        let mut found = vec![0; boxes.len()];
        let mut pending = vec![0];
        while let Some(index) = pending.pop() {
            let node: &Bvh2Node = &tree.nodes[index];
            let first = node.first_index as usize;
            let holds = |inner: &Aabb| node.min.cmple(inner.min.into()).all() && node.max.cmpge(inner.max.into()).all();
            if node.is_leaf() {
                assert!(node.prim_count <= 8);
                for &held in &tree.primitive_indices[first..first + node.prim_count as usize] {
                    found[held as usize] += 1;
                    assert!(holds(&boxes[held as usize]), "{node:?} {:?}", boxes[held as usize]);
                }
            } else {
                pending.extend([first, first + 1]);
                assert!([first, first + 1].iter().all(|&child| holds(tree.nodes[child].aabb())), "{node:?}");
            }
        }
        assert!(found.iter().all(|&times| times == 1));
        depth(tree)
    }

    /// Formats a tree as text: boxes and leaf contents, depth first.
    fn text(tree: &Bvh2) -> String {
        let mut text = String::new();
        let mut pending = vec![0];
        while let Some(index) = pending.pop() {
            let node = &tree.nodes[index];
            let first = node.first_index as usize;
            let held = first..first + node.prim_count as usize;
            text += &format!("{} {} {:?}\n", node.min, node.max, tree.primitive_indices.get(held));
            if !node.is_leaf() {
                pending.extend([first, first + 1]);
            }
        }
        text
    }

    #[test]
    fn ordinary_boxes_get_the_tree_that_obvhs_builds() {
        let mut random = Random::new(3);
        for count in [1, 2, 3, 8, 9, 20, 300, 3999, 20_000] {
            let boxes: Vec<_> = (0..count).map(|_| cube(random.point(1.0), 0.03 * random.unit())).collect();
            for &build_kind in BvhBuild::ALL {
                let params = build_kind.params().unwrap();
                let ours = build(&boxes, params, &|a, b| a.cmp(&b));
                let theirs = build_bvh2(&boxes, params, &mut Duration::default());
                check(&ours, &boxes);
                assert!(text(&ours) == text(&theirs), "{count} {build_kind:?}");
            }
        }
    }

    /// For these boxes, obvhs alone takes minutes or panics.
    #[test]
    fn boxes_that_prefer_one_partner_are_built_quickly_and_no_deeper_than_kernels_can_go() {
        let mut random = Random::new(5);
        let count = 30_000;
        let mut boxes = |of: &dyn Fn(f32, &mut Random) -> Aabb| -> Vec<Aabb> {
            (0..count).map(|index| of(index as f32, &mut random)).collect()
        };
        let one = Vec3::new(0.3, 0.7, 1.3);
        let size = |index: f32| 0.02 + 0.08 * index / count as f32;
        let ulps = |random: &mut Random| one + Vec3::from_array([(); 3].map(|()| 1.2e-7 * random.below(3) as f32));
        for (name, boxes) in [
            ("equal", boxes(&|_, _| cube(one, 1.0))),
            ("equal and small", boxes(&|_, _| cube(1e-30 * one, 1e-30))),
            ("small", boxes(&|_, random| cube(random.point(1e-30), 1e-32))),
            ("moved by ulps", boxes(&|_, random| cube(ulps(random), 1.0))),
            ("concentric", boxes(&|index, _| cube(one, size(index)))),
            ("in one corner", boxes(&|index, _| cube(Vec3::splat(size(index)), size(index)))),
            ("in a line", boxes(&|index, _| cube(Vec3::X * index, 0.2))),
            ("growing in a line", boxes(&|index, _| cube(Vec3::X * index, size(index)))),
            (
                "beside a huge one",
                boxes(&|index, random| cube(random.point(0.5), if index < 1.0 { 1e5 } else { 1e-3 })),
            ),
        ] {
            for &build_kind in BvhBuild::ALL {
                let started = Instant::now();
                let tree = build(&boxes, build_kind.params().unwrap(), &|a, b| a.cmp(&b));
                let elapsed = started.elapsed();
                let depth = check(&tree, &boxes);
                println!("{name}, {build_kind:?}: {depth} deep, {elapsed:.2?}");
                assert!(depth <= MAX_DEPTH, "{name}, {build_kind:?}: {depth} deep");
                // A build takes up to 1.4 s on a busy machine. With one pass per merged pair it would take a minute or
                // more.
                assert!(elapsed < Duration::from_secs(15), "{name}, {build_kind:?}: {elapsed:?}");
            }
        }
    }
}
