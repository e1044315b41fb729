//! Connected components of a scene's primitives. Visibility bits are reused within a component only.

use std::collections::HashMap;

use ahash::RandomState;
use glam::Vec3;

use super::Scene;

/// Returns the connected component of each primitive, as its smallest primitive id. Triangles are connected if corners
/// have equal positions; the file's own vertices and groups do not matter. Every sphere, ellipsoid and plane is a
/// component of its own.
pub(crate) fn of(scene: &Scene) -> Vec<u32> {
    let triangles = scene.triangles();
    let mut above: Vec<u32> = (0..scene.primitive_count() as u32).collect();
    let mut first_at = HashMap::with_capacity_and_hasher(triangles.len(), RandomState::new());
    for (id, triangle) in triangles.iter().enumerate().filter(|(_, triangle)| !triangle.is_degenerate()) {
        for corner in triangle.corners {
            let first = *first_at.entry(welded(corner)).or_insert(id as u32);
            if first != id as u32 {
                let (a, b) = (root(&mut above, first), root(&mut above, id as u32));
                above[a.max(b) as usize] = a.min(b);
            }
        }
    }
    for id in 0..above.len() as u32 {
        above[id as usize] = root(&mut above, id);
    }
    above
}

/// Returns a position as a key; 0 and -0 are equal.
pub(super) fn welded(corner: Vec3) -> [u32; 3] {
    corner.to_array().map(|v| (v + 0.0).to_bits())
}

/// Returns the root of a component, with path halving.
fn root(above: &mut [u32], mut id: u32) -> u32 {
    while above[id as usize] != id {
        above[id as usize] = above[above[id as usize] as usize];
        id = above[id as usize];
    }
    id
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MaterialId, Mesh, Sphere};

    #[test]
    fn shared_positions_join_triangles_across_meshes_and_spheres_stay_alone() {
        let mut scene = Scene::new();
        let mut add = |corners: [[f32; 3]; 3]| {
            let positions = corners.map(Vec3::from_array).to_vec();
            scene.add_mesh(&Mesh::new(positions, vec![[0, 1, 2]])).unwrap();
        };
        let (o, x, y, z) = ([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        let far = [9.0; 3];
        add([far, [9.0, 9.0, 8.0], [9.0, 8.0, 8.0]]);
        add([o, x, y]);
        add([[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [5.0, 1.0, 0.0]]);
        add([z, [1.0, 1.0, 1.0], [-0.0, 1.0, 0.0]]); // shares y, although its x is -0
        add([z, [5.0, 1.0, 0.0], [2.0, 2.0, 2.0]]); // joins 2 to 3, and so to 1
        add([o, o, far]); // degenerate: joins nothing
        for _ in 0..2 {
            scene.add_sphere(Sphere::new(Vec3::ZERO, 1.0, MaterialId(0))).unwrap();
        }
        assert_eq!(of(&scene), [0, 1, 1, 1, 1, 5, 6, 7]);
    }

    /// The low bits of these coordinates are zeros, also after a multiplication.
    #[test]
    fn coordinates_that_are_powers_of_two_take_no_square_of_time() {
        let power = |index: u32| f32::from_bits(index << 20);
        let at = |x: u32, y: u32| Vec3::new(power(x), power(y), 1.0);
        let positions: Vec<Vec3> = (0..800 * 800).map(|index| at(1 + index % 800, 1 + index / 800)).collect();
        let corners = (0..800 * 799).filter(|index| index % 800 < 799);
        let triangles: Vec<[u32; 3]> = corners.map(|corner| [corner, corner + 1, corner + 800]).collect();
        let mut scene = Scene::new();
        scene.add_mesh(&Mesh::new(positions, triangles)).unwrap();
        let started = std::time::Instant::now();
        assert!(of(&scene).iter().all(|&component| component == 0));
        assert!(started.elapsed().as_secs() < 10, "{:?}", started.elapsed());
    }
}
