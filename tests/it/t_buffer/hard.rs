//! Tests primitives that are hard to draw: across the plane of the eyes, outside the picture, huge, or very many.

use stereotrace::{
    Ellipsoid, MISS, MaterialId, Mesh, Method, Options, Scene, Sphere, StereoCamera,
    blocking::Wait,
    glam::{Mat3, Vec3},
};

use super::{
    common::{RandomScene, ball, random::Random, renderer},
    pair,
};

fn camera() -> StereoCamera {
    StereoCamera::look_at(Vec3::new(0.0, 0.4, 3.0), Vec3::ZERO).size(64, 49).screen_distance(3.0).interaxial_pixels(4.0)
}

/// Checks a pair, and returns the share of both views' pixels that show a surface.
fn check(what: &str, scene: &Scene, camera: &StereoCamera) -> f64 {
    let mut renderer = renderer();
    let uploaded = renderer.upload(scene).wait().unwrap();
    let views = pair(what, &mut renderer, &uploaded, camera, &Options::new(Method::Naive)).views;
    let all: Vec<u32> = views.iter().flat_map(|view| view.view.primitive.clone()).collect();
    all.iter().filter(|&&id| id != MISS).count() as f64 / all.len() as f64
}

fn quad(half_side: f32, height: f32, tilt: f32) -> Mesh {
    let corner = |x: f32, z: f32| half_side * Vec3::new(x, tilt * x, z) + height * Vec3::Y;
    Mesh::new(
        vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)],
        vec![[0, 1, 2], [0, 2, 3]],
    )
}

/// Tests triangles, spheres and ellipsoids around the eyes, from many positions and in many directions.
#[test]
fn what_stands_around_the_eyes_is_that_of_rays() {
    let mut random = Random::new(11);
    let scene = RandomScene { seed: 12, triangles: 200, spheres: 15, ellipsoids: 15, ..RandomScene::default() }.build();
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    for view in 0..24 {
        let eye = random.point(0.8);
        let target = eye + random.point(1.0).normalize();
        let fov = random.between(20.0, 130.0);
        let camera = StereoCamera::look_at(eye, target).up(random.point(1.0)).size(47, 39).vertical_fov_degrees(fov);
        let camera = camera.screen_distance(0.5).interaxial_pixels(random.between(1.0, 12.0));
        pair(&format!("view {view}"), &mut renderer, &uploaded, &camera, &Options::new(Method::Naive));
    }
}

/// Tests balls beside the eye. Their nearest points are just in front of the plane of the eyes, in it or behind it.
#[test]
fn balls_at_the_plane_of_the_eyes_are_those_of_rays_and_so_they_are_by_bracket() {
    let forward = Vec3::new(0.0, -0.4, -3.0).normalize();
    let mut random = Random::new(4);
    for round in [false, true] {
        for away in [-0.3, -0.01, 0.0, 1e-6, 1e-4, 0.01, 0.05, 0.2] {
            let mut scene = Scene::new();
            for _ in 0..30 {
                let radius = random.between(0.05, 0.8);
                let aside = random.point(1.0).reject_from(forward).normalize() * random.between(0.9, 3.0);
                let center = camera().pose().unwrap().eye.as_vec3() + aside + forward * (radius + away);
                let axes = Mat3::from_diagonal(radius * Vec3::new(1.0, random.between(0.1, 1.0), 1.0));
                match round {
                    true => scene.add_sphere(Sphere::new(center, radius, MaterialId(0))).unwrap(),
                    false => scene.add_ellipsoid(Ellipsoid::new(center, axes, MaterialId(0))).unwrap(),
                }
            }
            let wide = camera().vertical_fov_degrees(120.0);
            let what = format!("balls {away} before the plane of the eyes, round: {round}");
            check(&what, &scene, &wide);
            let mut renderer = renderer();
            let uploaded = renderer.upload(&scene).wait().unwrap();
            let mut right =
                |method| renderer.pair(&uploaded, &wide).options(&Options::new(method)).read().wait().unwrap().right;
            assert!(right(Method::BRACKET_RAYS) == right(Method::Naive), "{what}, by bracket");
        }
    }
}

#[test]
fn from_inside_a_sphere_everything_is_that_of_rays() {
    let mut scene = Scene::new();
    let eye = camera().pose().unwrap().eye.as_vec3();
    scene.add_sphere(Sphere::new(eye + Vec3::new(0.1, 0.0, -0.2), 2.0, MaterialId(0))).unwrap();
    scene.add_sphere(Sphere::new(Vec3::new(0.0, 0.4, 1.5), 0.3, MaterialId(0))).unwrap();
    assert_eq!(check("inside a sphere", &scene, &camera()), 1.0);
    scene.add_ellipsoid(Ellipsoid::new(eye, Mat3::from_diagonal(Vec3::new(1.9, 0.4, 5.0)), MaterialId(0))).unwrap();
    assert_eq!(check("inside an ellipsoid", &scene, &camera()), 1.0);
}

/// Tests a ground from above, from within and from below, level and tilted.
#[test]
fn a_ground_a_thousand_times_its_object_is_that_of_rays() {
    for (tilt, height) in [(0.0, -0.5), (0.3, -0.5), (0.0, 0.4), (0.01, 0.39999), (0.0, 0.7)] {
        let mut scene = Scene::new();
        scene.add_mesh(&quad(1000.0, height, tilt)).unwrap();
        scene.add_mesh(&ball(Vec3::ZERO, 0.5, 12)).unwrap();
        check(&format!("ground at {height} tilted by {tilt}"), &scene, &camera());
        check(&format!("large ground at {height} tilted by {tilt}"), &scene, &camera().size(211, 150));
    }
}

/// Tests many triangles that each cover the whole picture.
#[test]
fn layers_of_grounds_are_those_of_rays() {
    let mut scene = Scene::new();
    for layer in 0..60 {
        scene.add_mesh(&quad(50.0, -0.4 - 0.01 * layer as f32, 0.001 * layer as f32)).unwrap();
    }
    check("60 grounds", &scene, &camera().size(300, 200));
}

/// Tests a ball of many triangles, as large as a few pixels. Most triangles cover no pixel's centre, and each pixel's
/// centre is covered by many.
#[test]
fn a_hundred_thousand_triangles_in_ten_pixels_are_those_of_rays() {
    let mut scene = Scene::new();
    scene.add_mesh(&ball(Vec3::ZERO, 0.5, 160)).unwrap();
    let mut random = Random::new(3);
    let positions: Vec<Vec3> = (0..60_000).map(|_| random.point(0.3)).collect();
    let triangles = (0..20_000).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect();
    scene.add_mesh(&Mesh::new(positions, triangles)).unwrap();
    for distance in [10.0, 30.0, 100.0] {
        // The middle of a pixel is in the middle of the ball.
        let far = StereoCamera::look_at(Vec3::new(0.0, 0.0, distance), Vec3::ZERO).size(65, 49).interaxial_pixels(2.0);
        let share = check(&format!("from {distance}"), &scene, &far);
        assert!(share > 0.0, "{distance}: {share}");
    }
}

/// Tests needles from corner to corner, whose bounds are the whole picture. Together they have more parts than there is
/// room for. A wall before most of them keeps rays short.
#[test]
fn needles_across_the_picture_are_those_of_rays() {
    let mut random = Random::new(8);
    let mut scene = Scene::new();
    let wall = [(-3.0, -3.0), (1.0, -3.0), (1.0, 3.0), (-3.0, 3.0)].map(|(x, y)| Vec3::new(x, y, 1.0));
    scene.add_mesh(&Mesh::new(wall.to_vec(), vec![[0, 1, 2], [0, 2, 3]])).unwrap();
    let count = 7000;
    let mut positions = Vec::new();
    for _ in 0..count {
        let low = Vec3::new(-3.0, -2.5, 0.0) + random.point(0.4);
        positions.extend([low, -low, random.point(0.002) - low]);
    }
    let triangles = (0..count).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect();
    scene.add_mesh(&Mesh::new(positions, triangles)).unwrap();
    let share = check("needles", &scene, &camera().size(240, 180));
    assert!(share > 0.5, "{share}");
}

/// Tests triangles whose copies, with the corners in another order, come first. They have equal t, and their ids are in
/// any order in the tree. The smallest id is visible.
#[test]
fn of_equal_t_the_smaller_id_is_seen() {
    let mut random = Random::new(21);
    let mut scene = Scene::new();
    let base: Vec<[Vec3; 3]> = (0..60)
        .map(|_| {
            let at = random.point(1.0);
            [(); 3].map(|()| at + random.point(0.5))
        })
        .collect();
    for turn in [1, 2, 0] {
        let positions = base.iter().flat_map(|corners| {
            let mut corners = *corners;
            corners.rotate_left(turn);
            corners
        });
        let triangles = (0..60).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect();
        scene.add_mesh(&Mesh::new(positions.collect(), triangles)).unwrap();
    }
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let views = pair("copies", &mut renderer, &uploaded, &camera(), &Options::new(Method::Naive)).views;
    let seen: Vec<u32> = views.iter().flat_map(|view| view.view.primitive.clone()).filter(|&id| id != MISS).collect();
    assert!(seen.len() > 500 && seen.iter().all(|&id| id < 60), "{}", seen.len());
}

/// Every primitive is beside the picture, above it, below it or behind the eyes, so nothing is visible.
#[test]
fn what_lies_beside_the_picture_leaves_nothing() {
    let mut scene = Scene::new();
    for at in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z] {
        scene.add_mesh(&ball(40.0 * at + 2.0 * Vec3::Z, 3.0, 6)).unwrap();
        scene.add_sphere(Sphere::new(30.0 * at, 2.0, MaterialId(0))).unwrap();
    }
    assert_eq!(check("beside", &scene, &camera()), 0.0);
}

/// Tests pictures of one row, one column and one pixel, and sizes that are multiples of nothing.
#[test]
fn odd_sizes_are_those_of_rays() {
    let mut scene =
        RandomScene { seed: 9, triangles: 120, spheres: 20, ellipsoids: 5, ..RandomScene::default() }.build();
    scene.add_mesh(&quad(100.0, -1.0, 0.1)).unwrap();
    for size in [[1, 1], [1, 57], [73, 1], [2, 3], [7, 9], [8, 8], [65, 17], [333, 5]] {
        check(&format!("{size:?}"), &scene, &camera().size(size[0], size[1]).interaxial_pixels(1.0));
    }
}
