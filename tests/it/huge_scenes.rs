//! Tests fine detail in huge scenes, and primitives that no box can separate.

use crate::common;
use crate::truth;

use common::{gpu, random::Random};
use stereotrace::{
    Boxes, Fetch, MISS, MaterialId, Mesh, Method, Options, RaysPerLane, Renderer, Scene, Sphere, StereoCamera,
    StereoPair, Traversal,
    blocking::Wait,
    glam::Vec3,
    testing::cpu::{Eye, Frame},
};
use truth::Truth;

/// Maximum ratio of tests per ray, between a huge ground and a ground that ends just outside the picture. The measured
/// ratio is 1.7, due to the ground's own two triangles. It would be thousands if all boxes were widened equally.
const MORE_TESTS: f64 = 2.0;
/// Maximum ratio of tests by `bracket`. The measured ratio is 3.2, since the huge ground has a larger depth range.
/// Also, each ray that tests narrow shadows again meets the ground's two triangles.
const MORE_TESTS_BY_BRACKET: f64 = 3.8;

fn quad(half_side: f32, height: f32) -> Mesh {
    let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
    Mesh::new(
        corners.map(|(x, z)| half_side * Vec3::new(x, 0.0, z) + height * Vec3::Y).to_vec(),
        vec![[0, 1, 2], [0, 2, 3]],
    )
}

/// Kind of the pebbles.
#[derive(Clone, Copy, Debug)]
enum Pebble {
    Octahedra,
    Spheres,
}

/// Returns 1500 pebbles of up to 2 mm within half a metre, on a ground of any size, in metres.
fn pebbles(kind: Pebble, half_side: f32) -> Scene {
    let mut scene = Scene::new();
    scene.add_mesh(&quad(half_side, 0.0)).unwrap();
    let mut random = Random::new(9);
    let mut positions = Vec::new();
    for _ in 0..1500 {
        let center = Vec3::new(random.between(-0.25, 0.25), 0.0007, random.between(-0.25, 0.25));
        let radius = random.between(0.0006, 0.001);
        match kind {
            Pebble::Spheres => scene.add_sphere(Sphere::new(center, radius, MaterialId(0))).unwrap(),
            Pebble::Octahedra => {
                positions.extend(
                    [Vec3::X, Vec3::Y, Vec3::Z]
                        .into_iter()
                        .flat_map(|axis| [axis, -axis].map(|end| center + radius * end)),
                );
            }
        }
    }
    let faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let count = positions.len() as u32 / 6;
    let triangles = (0..count).flat_map(|index| faces.map(|face| face.map(|corner| 6 * index + corner)));
    scene.add_mesh(&Mesh::new(positions, triangles.collect())).unwrap();
    let camera = looking_at_pebbles();
    scene.place_lights(2, &camera).unwrap();
    scene
}

fn looking_at_pebbles() -> StereoCamera {
    StereoCamera::look_at(Vec3::new(0.02, 0.3, 0.25), Vec3::ZERO).size(64, 64).vertical_fov_degrees(35.0)
}

fn renderer(boxes: Boxes) -> Renderer {
    let gpu = gpu();
    let traversal = Traversal::of(&gpu).fetch(Fetch::Texture).boxes(boxes).rays(RaysPerLane::Four);
    Renderer::with_traversal(gpu, traversal)
}

fn counted(renderer: &mut Renderer, scene: &Scene, camera: &StereoCamera, method: Method) -> StereoPair {
    let uploaded = renderer.upload(scene).wait().unwrap();
    renderer.pair(&uploaded, camera).options(&Options::new(method).count(true)).read().wait().unwrap()
}

/// Returns the number of pixels whose hit differs from a trace of the same ray in double precision. Pixels within 0.01
/// pixels of an edge don't count, since f32 may see either side.
fn wrong_hits(scene: &Scene, pair: &StereoPair) -> usize {
    let truth = Truth::new(scene);
    let frame = Frame::new(&pair.pose);
    let [width, height] = frame.size();
    let origin = frame.eye(Eye::Left);
    let wrong = |&index: &usize| {
        let (column, row) = (index % width, index / width);
        let direction = frame.direction(Eye::Left, column, row);
        let hit = |direction| truth.closest(origin.as_dvec3(), direction);
        let (t, primitive) = hit(direction.as_dvec3());
        let same = pair.left.primitive[index] == primitive;
        // A hit on the other half of the ground's quad is also correct at this depth, since rounding of a far corner
        // moves the line between the halves.
        let close = (f64::from(pair.left.depth[index]) - t).abs() < 1e-5 * t;
        if close || (same && primitive == MISS) {
            return false;
        }
        let pixel = (frame.direction(Eye::Left, column + 1, row) - direction).as_dvec3();
        let down = (frame.direction(Eye::Left, column, row + 1) - direction).as_dvec3();
        let around = [pixel, -pixel, down, -down].map(|aside| hit(direction.as_dvec3() + 0.01 * aside).1);
        same || around.iter().all(|&hit| hit == primitive)
    };
    (0..width * height).filter(wrong).count()
}

fn tests_per_ray(pair: &StereoPair) -> [f64; 2] {
    [&pair.statistics.left, &pair.statistics.right].map(|work| work.primitive_tests as f64 / work.rays.total() as f64)
}

#[test]
fn pebbles_on_a_huge_ground_cost_no_more_tests_than_on_a_small_one() {
    let camera = looking_at_pebbles();
    let mut renderer = renderer(Boxes::F32);
    let mut red = Vec::new();
    for kind in [Pebble::Octahedra, Pebble::Spheres] {
        // Both grounds fill the picture, so that the rays are the same.
        let small = pebbles(kind, 1.0);
        for (name, method) in [("naive", Method::Naive), ("bracket", Method::BRACKET)] {
            let pair = counted(&mut renderer, &small, &camera, method);
            let [left, right] = tests_per_ray(&pair);
            assert_eq!(wrong_hits(&small, &pair), 0, "{kind:?} on ±1 by {name}");
            for half_side in [100.0, 1e4, 1e5, 1e6] {
                let huge = pebbles(kind, half_side);
                let uploaded = renderer.upload(&huge).wait().unwrap();
                let pair =
                    match renderer.pair(&uploaded, &camera).options(&Options::new(method).count(true)).read().wait() {
                        Ok(pair) => pair,
                        Err(error) => {
                            println!("{kind:?} on ±{half_side} by {name}: {error}");
                            red.push(format!("{kind:?} on ±{half_side} by {name}: {error}"));
                            continue;
                        }
                    };
                let [huge_left, huge_right] = tests_per_ray(&pair);
                let ratios = [huge_left / left, huge_right / right];
                let wrong = wrong_hits(&huge, &pair);
                let line = format!(
                    "{kind:?} on ±{half_side} by {name}: {huge_left:.1} tests a ray on the left, {huge_right:.1} on \
                     the right, {:.2} and {:.2} times those on ±1; {wrong} of 4096 hits wrong",
                    ratios[0], ratios[1]
                );
                println!("{line}");
                let few_on_the_right = match method {
                    Method::Naive => huge_right <= right + MORE_TESTS,
                    _ => ratios[1] <= MORE_TESTS_BY_BRACKET,
                };
                if huge_left > left + MORE_TESTS || !few_on_the_right || wrong > 0 {
                    red.push(line);
                }
            }
        }
    }
    assert!(red.is_empty(), "{} of 16 are wrong:\n{}", red.len(), red.join("\n"));
}

/// Builds and renders a scene and returns a description of the first fault. `expected` must hold for the pair.
fn fault(name: &str, scene: &Scene, camera: &StereoCamera, expected: impl Fn(&StereoPair) -> bool) -> Option<String> {
    let mut renderer = renderer(Boxes::F32);
    let uploaded = match renderer.upload(scene).wait() {
        Ok(uploaded) => uploaded,
        Err(error) => return Some(format!("{name}: refused: {error}")),
    };
    let mut faults = Vec::new();
    for method in [Method::Naive, Method::BRACKET] {
        match renderer.pair(&uploaded, camera).options(&Options::new(method)).read().wait() {
            Ok(pair) if expected(&pair) => {}
            Ok(_) => faults.push(format!("{method} sees other primitives")),
            Err(error) => faults.push(format!("{method}: {error}")),
        }
    }
    (!faults.is_empty()).then(|| format!("{name}: {}", faults.join("; ")))
}

fn copies(count: u32, scale: f32) -> Mesh {
    let corners = [Vec3::new(-0.1, -0.1, 0.0), Vec3::new(0.1, -0.1, 0.0), Vec3::new(0.0, 0.1, 0.0)];
    Mesh::new(corners.map(|corner| corner * scale).to_vec(), vec![[0, 1, 2]; count as usize])
}

/// Returns a camera so far away that the copies fill some hundred of 64 x 64 pixels.
fn camera() -> StereoCamera {
    StereoCamera::look_at(Vec3::Z, Vec3::ZERO).size(64, 64)
}

/// Returns the ids of the primitives that both eyes see, sorted, without misses.
fn seen(pair: &StereoPair) -> Vec<u32> {
    let mut seen: Vec<_> = [&pair.left, &pair.right].iter().flat_map(|view| view.primitive.clone()).collect();
    seen.sort_unstable();
    seen.dedup();
    seen.retain(|&id| id != MISS);
    seen
}

/// Runs checks from few primitives to many, up to the first fault. After a fault, quadratic work would take minutes.
fn assert_none<F: FnOnce() -> Option<String>>(searches: impl IntoIterator<Item = F>) {
    let fault = searches.into_iter().find_map(|search| search());
    assert!(fault.is_none(), "{}", fault.unwrap_or_default());
}

#[test]
fn copies_of_one_triangle_build_and_render_and_the_first_is_seen() {
    assert_none([200, 3000, 100_000].map(|count| {
        move || {
            let mut scene = Scene::new();
            scene.add_mesh(&copies(count, 1.0)).unwrap();
            fault(&format!("{count} copies"), &scene, &camera(), |pair| seen(pair) == [0])
        }
    }));
}

/// The copies are in a corner of a scene with other triangles, so that the build needs both kinds of splits.
#[test]
fn copies_beside_other_triangles_build_and_render() {
    assert_none([200, 1000, 20_000].map(|count| {
        move || {
            let mut random = Random::new(2);
            let mut scene = Scene::new();
            scene.add_mesh(&copies(count, 1.0)).unwrap();
            let positions: Vec<Vec3> = (0..30_000).map(|_| random.point(0.4) - 0.6 * Vec3::Z).collect();
            let triangles = (0..10_000).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect();
            scene.add_mesh(&Mesh::new(positions, triangles)).unwrap();
            fault(&format!("{count} copies beside others"), &scene, &camera(), |pair| {
                let seen = seen(pair);
                seen.first() == Some(&0) && seen.get(1).is_some_and(|&second| second >= count)
            })
        }
    }));
}

/// The spheres are concentric, or their centres are on a line such that all spheres touch in one point.
#[test]
fn nested_spheres_build_and_render_and_the_outermost_is_seen() {
    let cases = [200, 2000, 200_000].into_iter().flat_map(|count: u32| [(count, 0.0), (count, 1.0)]);
    assert_none(cases.map(|(count, aside)| {
        move || {
            let mut scene = Scene::new();
            for index in 0..count {
                let radius = 0.02 + 0.08 * index as f32 / count as f32;
                let center = aside * radius * Vec3::X;
                scene.add_sphere(Sphere::new(center, radius, MaterialId(0))).unwrap();
            }
            let name = if aside == 0.0 { "concentric" } else { "tangent" };
            // Where spheres touch, rounding may decide which sphere is shown.
            fault(&format!("{count} {name} spheres"), &scene, &camera(), |pair| {
                let seen = seen(pair);
                seen.contains(&(count - 1)) && (aside > 0.0 || seen.len() == 1)
            })
        }
    }));
}

/// Products of such small coordinates are 0 in f32. The primitives are far too small to be seen, and objects beside
/// them look the same as without them.
#[test]
fn scenes_of_a_scale_of_1e_30_build_and_render() {
    let mesh_of = |count: u32, alike: bool| {
        let mut random = Random::new(4);
        let positions: Vec<Vec3> = (0..3 * count).map(|_| random.point(1e-30)).collect();
        let different =
            Mesh::new(positions, (0..count).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect());
        if alike { copies(count, 1e-30) } else { different }
    };
    let cases = [200, 3000, 100_000].into_iter().flat_map(|count| [(count, true), (count, false)]);
    assert_none(cases.map(|(count, alike)| {
        move || {
            let name = format!("{count} {} triangles at 1e-30", if alike { "equal" } else { "different" });
            let mut scene = Scene::new();
            scene.add_mesh(&mesh_of(count, alike)).unwrap();
            let center = Vec3::new(0.2, 0.0, 0.0);
            scene.add_sphere(Sphere::new(center, 0.1, MaterialId(0))).unwrap();
            fault(&name, &scene, &camera(), |pair| seen(pair).contains(&count))
        }
    }));
}
