//! Tests the counters of a T-buffer.

use stereotrace::{
    MaterialId, Mesh, Method, Options, Scene, Sphere, StereoCamera, Visibility, blocking::Wait, glam::Vec3,
};

use super::common::{RandomScene, renderer};

/// Returns a camera that looks straight ahead. A pixel spans a tenth of a unit on the screen.
fn camera() -> StereoCamera {
    StereoCamera::look_at(Vec3::new(0.0, 0.0, 10.0), Vec3::ZERO)
        .size(60, 40)
        .screen_distance(10.0)
        .screen_width(6.0)
        .interaxial(0.0)
}

fn counted() -> Options {
    Options::new(Method::Naive).visibility(Visibility::TBuffer).count(true)
}

/// Returns how many of `count` columns or rows have their middle between two positions on the screen, with a small
/// margin on both sides. A pixel is a tenth of a unit wide.
fn middles(count: u32, [low, high]: [f64; 2]) -> u64 {
    let all = (0..count).map(|pixel| 0.1 * (f64::from(pixel) + 0.5 - 0.5 * f64::from(count)));
    all.filter(|at| *at > low - 0.005 && *at < high + 0.005).count() as u64
}

/// A sphere is tested by the rays of the rectangle around its projection, whose sides are the slopes of its tangents.
/// Each ray tests it twice.
#[test]
fn a_sphere_is_tested_by_the_rays_of_its_bounds() {
    let mut scene = Scene::new();
    let (center, radius) = (Vec3::new(0.83, -0.41, 1.0), 0.37);
    scene.add_sphere(Sphere::new(center, radius, MaterialId(0))).unwrap();
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let view = renderer.pair(&uploaded, &camera()).options(&counted()).read().wait().unwrap();
    let z = 9.0_f64;
    let slopes = |across: f64| {
        let (angle, half) = (across.atan2(z), (f64::from(radius) / across.hypot(z)).asin());
        [10.0 * (angle - half).tan(), 10.0 * (angle + half).tan()]
    };
    let [x, y] = [slopes(f64::from(center.x)), slopes(-f64::from(center.y))];
    let expected = middles(60, x) * middles(40, y);
    let left = view.statistics.left;
    println!("{expected} rays, {left:?}");
    assert_eq!(left.primitive_tests, 2 * expected);
    assert_eq!((left.nodes, left.rays.primary), (1, 0));
}

/// Counters do not depend on the order of threads. The cost map contains all tests.
#[test]
fn counts_repeat_and_are_those_of_the_map_of_costs() {
    let scene = RandomScene { triangles: 200, spheres: 20, ellipsoids: 10, ..RandomScene::default() }.build();
    let camera = StereoCamera::look_at(Vec3::new(0.3, 0.4, 3.0), Vec3::ZERO).size(90, 70).interaxial_pixels(5.0);
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let options = counted().cost_map(true);
    let first = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
    for (view, work) in [(&first.left, first.statistics.left), (&first.right, first.statistics.right)] {
        let costs: u64 = view.cost.iter().map(|&cost| u64::from(cost)).sum();
        assert_eq!(costs, work.primitive_tests);
        assert_eq!((work.rays.primary, work.rays.shadow), (0, 0));
        // One of two equal primitives is left out of the tree.
        assert!(work.nodes > 100 && work.nodes <= scene.primitive_count() as u64, "{work:?}");
    }
    for _ in 0..3 {
        let mut again = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
        again.statistics.times = first.statistics.times.clone();
        assert!(again == first);
    }
    let names: Vec<&str> = first.statistics.times.iter().flat_map(|times| &times.passes).map(|pass| pass.0).collect();
    if !names.is_empty() {
        for name in ["project_primitives", "draw_few", "draw_more", "draw_parts", "read_t_buffer", "shade_hits"] {
            assert!(names.contains(&name), "{names:?}");
        }
    }
}

/// Primitives behind the eye or beside the picture are projected, but no ray tests them. The same holds for primitives
/// between pixels' centres that are smaller than the distance between the centres.
#[test]
fn what_covers_no_centre_is_tested_by_no_ray() {
    let mut scene = Scene::new();
    for index in 0..50 {
        // The triangle has the size of a twentieth of a pixel and lies at a corner of four pixels.
        let at = Vec3::new(0.1 * (index % 10) as f32, 0.1 * (index / 10) as f32, 0.0);
        let corners = [Vec3::X, Vec3::Y, Vec3::NEG_ONE].map(|corner| at + 0.0025 * corner * Vec3::new(1.0, 1.0, 0.0));
        scene.add_mesh(&Mesh::new(corners.to_vec(), vec![[0, 1, 2]])).unwrap();
        scene.add_sphere(Sphere::new(Vec3::new(0.0, 0.0, 20.0 + index as f32), 0.3, MaterialId(0))).unwrap();
        scene.add_sphere(Sphere::new(Vec3::new(50.0, index as f32, 0.0), 0.3, MaterialId(0))).unwrap();
    }
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let view = renderer.pair(&uploaded, &camera()).options(&counted()).read().wait().unwrap();
    assert_eq!(view.statistics.left.primitive_tests, 0);
    assert_eq!(view.statistics.left.nodes, scene.primitive_count() as u64);
}
