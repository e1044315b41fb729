//! Checks packed trees by reading them as kernels do.

use glam::Affine3A;

use super::{primitive::pack_normal, *};
use crate::{MaterialId, Mesh, random::Random};

fn scene_of(corners: Vec<Vec3>) -> Scene {
    let triangles = (0..corners.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let mut scene = Scene::new();
    scene.add_mesh(&Mesh::new(corners, triangles)).unwrap();
    scene
}

/// Decodes boxes as the kernel does, but in f64, and traverses the whole tree.
fn check_boxes(packed: &PackedBvh, kind: Boxes, stride: usize) -> (usize, u32) {
    let bvh = &packed.uniform;
    let origin = DVec3::from_array(bvh.grid_origin.map(f64::from));
    let cell = DVec3::from_array(bvh.grid_cell.map(f64::from));
    let of_grid = |q: [u32; 3]| origin + DVec3::from_array(q.map(f64::from)) * cell;
    let of_f32 = |[x, y, z, _]: Texel| origin + DVec3::from_array([x, y, z].map(|w| f64::from(f32::from_bits(w))));
    let (mut found, mut deepest) = (0, 0);
    let mut pending = vec![(0_u32, 1, vec![])];
    while let Some((pair, depth, above)) = pending.pop() {
        deepest = deepest.max(depth);
        for child in 0..2 {
            let texel = (2 * pair + child) as usize * child_texels(kind);
            let [x, y, z, link] = packed.nodes[texel];
            let mut boxes: Vec<(DVec3, DVec3)> = above.clone();
            boxes.push(match kind {
                Boxes::Grid16 => (of_grid([x & 0xffff, x >> 16, y & 0xffff]), of_grid([y >> 16, z & 0xffff, z >> 16])),
                Boxes::F32 => (of_f32(packed.nodes[texel]), of_f32(packed.nodes[texel + 1])),
            });
            if link & LEAF == 0 {
                pending.push((link, depth + 1, boxes));
                continue;
            }
            for slot in 0..(link >> 28 & 7) + 1 {
                found += 1;
                let texel = ((link & 0x0fff_ffff) + slot) as usize * stride;
                for corner in &packed.primitives[texel..texel + 3] {
                    let point = Vec3::from_array([0, 1, 2].map(|k| f32::from_bits(corner[k]))).as_dvec3();
                    for (low, high) in &boxes {
                        assert!(point.cmpge(*low).all() && point.cmple(*high).all(), "{point} {low} {high}");
                    }
                }
            }
        }
    }
    (found, deepest)
}

#[test]
fn boxes_hold_their_primitives_at_every_scale_and_place() {
    let mut random = Random::new(1);
    for (scale, offset) in [(1.0, 0.0), (1e-3, 0.0), (1e6, 0.0), (1.0, 1e5), (1e-3, 10.0), (1e7, 5e7)] {
        let mut point = || 0.5 * Vec3::new(1.0, 1.0, 0.01) * (random.point(1.0) + 1.0);
        let corners: Vec<Vec3> = (0..600)
            .flat_map(|_| {
                let at = point();
                [at, at + 0.1 * point(), at + 0.1 * point()]
            })
            .map(|p| p * scale + Vec3::splat(offset))
            .collect();
        let scene = scene_of(corners);
        for kind in [Boxes::Grid16, Boxes::F32] {
            let packed = build(&scene, BvhBuild::Balanced, kind).unwrap();
            let (found, depth) = check_boxes(&packed, kind, 3);
            assert_eq!(found, scene.primitive_count() - scene.degenerate_count());
            assert!(depth < packed.stack_size, "{depth} {}", packed.stack_size);
        }
    }
}

#[test]
fn small_and_flat_scenes_have_a_pair_at_the_root() {
    for count in 1..20 {
        let corners = (0..count).flat_map(|i| [Vec3::ZERO, Vec3::X, Vec3::Y].map(|p| p + Vec3::X * i as f32)).collect();
        let packed = build(&scene_of(corners), BvhBuild::Balanced, Boxes::Grid16).unwrap();
        let (found, _) = check_boxes(&packed, Boxes::Grid16, 3);
        assert_eq!(found, if count == 1 { 2 } else { count }, "a single primitive stands in both children");
    }
    assert_eq!(build(&Scene::new(), BvhBuild::Balanced, Boxes::Grid16).unwrap().nodes.len(), 2);
}

#[test]
fn a_deep_tree_gets_its_stack() {
    // Each triangle is larger than all before it together, so every tree over them is a chain.
    let corners = (0..120).flat_map(|i| [Vec3::ZERO, Vec3::X, Vec3::ONE].map(|p| p * 1e-30 * 2_f32.powi(i))).collect();
    let deep = build(&scene_of(corners), BvhBuild::Balanced, Boxes::Grid16).unwrap();
    let (_, depth) = check_boxes(&deep, Boxes::Grid16, 3);
    assert!(depth > 40, "a chain, not a balanced tree: {depth}");
    assert!(depth < deep.stack_size && deep.stack_size <= 256, "{depth} {}", deep.stack_size);
}

#[test]
fn of_copies_the_first_is_traced_and_turned_copies_stay() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    for (copies, scale) in [(2, 1.0), (20, 1e-30), (3000, 1.0), (3000, 1e-30)] {
        let turned = (0..3 * copies).map(|copy| [0, 1, 2].map(|k| scale * corners[(copy + k) % 3]));
        let apart = (0..40).map(|k| corners.map(|p| scale * (p + Vec3::Z * k as f32 + Vec3::X)));
        let mut scene = scene_of(apart.chain(turned).flatten().collect());
        for radius in [1.0, 2.0, 1.0, 1.0] {
            scene.add_sphere(crate::Sphere::new(Vec3::X, radius, MaterialId(0))).unwrap();
        }
        let spheres = scene.triangles().len() as u32;
        for &build_kind in BvhBuild::ALL {
            let mut ids = build(&scene, build_kind, Boxes::F32).unwrap().ids;
            ids.sort_unstable();
            assert_eq!(ids, (0..43).chain([spheres, spheres + 1]).collect::<Vec<_>>(), "{copies} at {scale}");
        }
    }
}

#[test]
fn normals_survive_packing_within_a_16_bit_step() {
    let mut random = Random::new(7);
    for _ in 0..1000 {
        let normal = random.point(1.0).normalize();
        let word = pack_normal(normal);
        let part = |bits: u32| f32::from(bits as u16 as i16) / 32767.0;
        let (x, y) = (part(word & 0xffff), part(word >> 16));
        let z = 1.0 - x.abs() - y.abs();
        let fold = (-z).max(0.0);
        let unfold = |v: f32| v + if v >= 0.0 { -fold } else { fold };
        let back = Vec3::new(unfold(x), unfold(y), z).normalize();
        assert!(back.distance(normal) < 1e-4, "{normal} {back}");
    }
}

/// Refitted boxes are as tight as the boxes of a new tree, since a refit rounds no more than packing does.
#[test]
fn refitted_boxes_hold_what_moved_and_leaves_that_lost_all_are_points() {
    let mut random = Random::new(5);
    let mut scene = Scene::new();
    for _ in 0..3 {
        let corners: Vec<Vec3> = (0..300).map(|_| random.point(1.0)).collect();
        let triangles = (0..100).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        scene.add_mesh(&Mesh::new(corners, triangles)).unwrap();
    }
    for kind in [Boxes::Grid16, Boxes::F32] {
        let mut scene = scene.clone();
        let built = build(&scene, BvhBuild::Balanced, kind).unwrap();
        let shape = TreeShape::of(&scene, &built);
        let same = shape.refit(&scene, kind).unwrap();
        assert!(same.nodes == built.nodes && same.primitives == built.primitives && same.ids == built.ids);
        for step in 0..4 {
            scene.transform_object(step % 2, &Affine3A::from_translation(Vec3::splat(20.0 * step as f32))).unwrap();
            let moved = shape.refit(&scene, kind).unwrap();
            assert_eq!(check_boxes(&moved, kind, 3).0, 300);
        }
        // The corners are rotated, so that the added triangles are no exact copies. They are connected with the
        // triangles that they cover.
        let corners: Vec<Vec3> =
            scene.triangles()[..100].iter().flat_map(|t| [1, 2, 0].map(|k| t.corners[k])).collect();
        let triangles = (0..100).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        scene.set_mesh(1, &Mesh::new(corners, triangles)).unwrap();
        let joined = shape.refit(&scene, kind).unwrap();
        assert_eq!(joined.components, build(&scene, BvhBuild::Balanced, kind).unwrap().components);
        assert_eq!(joined.components[100], 0);
        scene.transform_object(2, &Affine3A::from_scale(Vec3::ZERO)).unwrap();
        let shrunk = shape.refit(&scene, kind).unwrap();
        assert!(shrunk.ids.iter().all(|&id| id < 200) && shrunk.ids.len() == 300);
    }
}

#[test]
fn a_list_has_all_primitives_in_order_in_boxes_that_hold_everything() {
    for (count, kind) in
        [1, 2, 7, 8, 9, 16, 17, 100, 1000, 8192].into_iter().flat_map(|n| [(n, Boxes::Grid16), (n, Boxes::F32)])
    {
        let corners = (0..count).flat_map(|i| [Vec3::ZERO, Vec3::X, Vec3::Y].map(|p| p + Vec3::X * i as f32)).collect();
        let mut scene = scene_of(corners);
        scene.add_plane(crate::Plane::new(Vec3::ZERO, Vec3::Y, MaterialId(0))).unwrap();
        let packed = build(&scene, BvhBuild::Flat, kind).unwrap();
        assert!(packed.flat && !packed.world_boxes && packed.stack_size <= 16, "{count}");
        // The plane has the first slot. The test follows links like a ray that enters both boxes at once: it visits the
        // first child first.
        let (mut found, mut pairs, mut pending) = (Vec::new(), 0, vec![0]);
        while let Some(link) = pending.pop() {
            if link & LEAF == 0 {
                pairs += 1;
                let texel = |child: u32| (2 * link + child) as usize * child_texels(kind);
                pending.extend([1, 0].map(|child| packed.nodes[texel(child)][3]));
                continue;
            }
            let first = link & 0x0fff_ffff;
            found.extend((first..=first + (link >> 28 & 7)).map(|slot| packed.ids[slot as usize]));
        }
        let wanted: Vec<u32> = if count == 1 { vec![0, 0] } else { (0..count as u32).collect() };
        assert_eq!(found, wanted, "{count}");
        assert_eq!(
            pairs,
            (wanted.len().div_ceil(8) - 1).max(1),
            "{count}: a pair for each two leaves, and one at least"
        );
        let bvh = &packed.uniform;
        let reach = |k: usize| match kind {
            Boxes::Grid16 => [bvh.grid_origin[k], bvh.grid_origin[k] + 65535.0 * bvh.grid_cell[k]],
            Boxes::F32 => [0, 1].map(|end| bvh.grid_origin[k] + f32::from_bits(packed.nodes[end][k])),
        };
        for [low, high] in [0, 1, 2].map(reach) {
            assert!(low <= -1.1e8 && high >= 1.1e8, "{count}: {low} {high}");
        }
    }
}
