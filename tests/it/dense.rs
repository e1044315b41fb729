//! Tests scenes with unbounded work for one thread: dense meshes in few pixels, long needles, many lights. An adapter's
//! limit on a thread's loops may cost time but must not change a picture.

use crate::common;
use crate::solids;
use crate::truth;

use std::time::Instant;

use common::{random::Random, renderer};
use stereotrace::{
    Light, MISS, Mesh, Method, Options, Scene, StereoCamera, StereoPair, View,
    blocking::Wait,
    glam::Vec3,
    testing::cpu::{Eye, Frame},
};
use truth::Truth;

/// Returns a sphere of 1.3 million triangles.
fn dense_ball() -> Mesh {
    let (positions, triangles) = solids::icosphere(8);
    Mesh::new(positions, triangles)
}

/// Returns hills of 500,000 triangles.
fn dense_terrain() -> Mesh {
    let side = 500_u32;
    let position = |index: u32| {
        let (x, z) = (index % (side + 1), index / (side + 1));
        let height = 0.1 * ((x as f32 * 0.11).sin() + (z as f32 * 0.07).cos() + 0.3 * (x as f32 * z as f32).sin());
        Vec3::new(2.0 * x as f32 / side as f32 - 1.0, height, 2.0 * z as f32 / side as f32 - 1.0)
    };
    let cells = (0..side * side).map(|cell| cell % side + cell / side * (side + 1));
    let triangles = cells.flat_map(|a| [[a, a + side + 1, a + side + 2], [a, a + side + 2, a + 1]]);
    Mesh::new((0..(side + 1) * (side + 1)).map(position).collect(), triangles.collect())
}

/// Returns needles that reach through a whole cube, so that all their boxes overlap.
fn needles(count: u32) -> Mesh {
    let mut random = Random::new(31);
    let positions = (0..count).flat_map(|_| {
        let (from, to) = (random.point(1.0), random.point(1.0));
        [from, to, to + random.point(0.002)]
    });
    Mesh::new(positions.collect(), (0..count).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect())
}

fn render(scene: &Scene, camera: &StereoCamera, methods: &[Method]) -> Result<Vec<StereoPair>, String> {
    let mut renderer = renderer();
    let uploaded = renderer.upload(scene).wait().map_err(|error| error.to_string())?;
    let pair = |method: &Method| {
        let started = Instant::now();
        let pair = renderer.pair(&uploaded, camera).options(&Options::new(*method)).read().wait();
        println!("{method}: {} after {:.1?}", if pair.is_ok() { "a pair" } else { "no pair" }, started.elapsed());
        pair.map_err(|error| format!("{method}: {error}"))
    };
    methods.iter().map(pair).collect()
}

/// Returns the number of pixels in which two views show other surfaces, and the number of pixels with other colours.
fn differing(view: &View, other: &View) -> [usize; 2] {
    let count = view.depth.len();
    let surface = |&i: &usize| view.depth[i] != other.depth[i] || view.primitive[i] != other.primitive[i];
    [(0..count).filter(surface).count(), (0..count).filter(|&i| view.rgba8[i] != other.rgba8[i]).count()]
}

/// Compares every kind of tile search with naive, on a small picture of the mesh.
fn bracket_is_naive(name: &str, mesh: &Mesh, size: [u32; 2], farther: f32) {
    let mut scene = Scene::new();
    scene.add_mesh(mesh).unwrap();
    let pose = StereoCamera::fitting(scene.bounds().unwrap(), size[0], size[1]).pose().unwrap();
    let camera =
        StereoCamera::look_at(pose.eye * f64::from(farther), Vec3::ZERO).size(size[0], size[1]).interaxial_pixels(2.0);
    scene.place_lights(3, &camera).unwrap();
    let methods = [Method::Naive, Method::BRACKET, Method::VERIFIED, Method::BRACKET_RAYS, Method::Auto];
    let pairs = render(&scene, &camera, &methods).unwrap_or_else(|error| panic!("{name} at {size:?}: {error}"));
    let naive = &pairs[0];
    let seen = naive.right.primitive.iter().filter(|&&id| id != MISS).count();
    assert!(seen >= 4, "{name} at {size:?}: {seen} pixels show it");
    for (method, pair) in methods.iter().zip(&pairs) {
        let [surfaces, colors] = differing(&pair.right, &naive.right);
        println!("{name} at {size:?} by {method}: {surfaces} surfaces and {colors} colours of {seen} differ");
        assert_eq!(surfaces, 0, "{name} at {size:?} by {method}");
        assert!(*method != Method::BRACKET_RAYS || colors == 0, "{name} at {size:?} by {method}: {colors} colours");
        assert_eq!(differing(&pair.left, &naive.left), [0, 0], "{name} at {size:?} by {method}: left");
    }
}

#[test]
fn a_ball_of_a_million_triangles_in_few_pixels_is_naives() {
    let ball = dense_ball();
    for (size, farther) in [([64, 48], 1.0), ([30, 30], 1.0), ([100, 100], 1.0), ([100, 100], 10.0), ([8, 8], 1.0)] {
        bracket_is_naive("ball", &ball, size, farther);
    }
}

#[test]
fn a_terrain_of_half_a_million_triangles_in_few_pixels_is_naives() {
    let terrain = dense_terrain();
    for (size, farther) in [([30, 30], 1.0), ([64, 48], 1.0), ([100, 100], 10.0)] {
        bracket_is_naive("terrain", &terrain, size, farther);
    }
}

/// Compares every `every`-th pixel with double precision. Counts depths that differ by more than a ten-thousandth, and
/// colours that differ by more than 3 steps of 255.
fn wrong(scene: &Scene, pair: &StereoPair, every: usize) -> [usize; 2] {
    let truth = Truth::new(scene);
    let frame = Frame::new(&pair.pose);
    let width = frame.size()[0];
    let mut wrong = [0, 0];
    for (view, eye) in [(&pair.left, Eye::Left), (&pair.right, Eye::Right)] {
        for index in (0..view.rgba8.len()).step_by(every) {
            let seen = truth.see(frame.eye(eye), frame.direction(eye, index % width, index / width));
            let depth = f64::from(view.depth[index]);
            wrong[0] += usize::from(depth != seen.t && (depth - seen.t).abs() > 1e-4 * seen.t);
            wrong[1] += usize::from(view.rgba8[index].iter().zip(seen.srgb()).any(|(a, b)| a.abs_diff(b) > 3));
        }
    }
    println!("one pixel in {every} judged: {} depths and {} colours are wrong", wrong[0], wrong[1]);
    wrong
}

/// Shadows are not compared here. Between so many needles, most shadow rays end within an ulp of an edge.
#[test]
fn four_hundred_thousand_long_needles_with_five_lights_are_rendered() {
    let mut scene = Scene::new();
    scene.add_mesh(&needles(400_000)).unwrap();
    let camera = StereoCamera::look_at(Vec3::new(1.0, 1.5, 4.0), Vec3::ZERO).size(24, 24).vertical_fov_degrees(40.0);
    scene.place_lights(5, &camera).unwrap();
    let methods = [Method::Naive, Method::BRACKET_RAYS];
    let pairs = render(&scene, &camera, &methods).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(wrong(&scene, &pairs[0], 7)[0], 0);
    assert_eq!(differing(&pairs[0].right, &pairs[1].right), [0, 0]);
}

#[test]
fn a_thousand_lights_are_rendered() {
    let mut scene = Scene::new();
    let floor = [(-4.0, -4.0), (-4.0, 4.0), (4.0, 4.0), (4.0, -4.0)].map(|(x, z)| Vec3::new(x, -0.5, z));
    scene.add_mesh(&Mesh::new(floor.to_vec(), vec![[0, 1, 2], [0, 2, 3]])).unwrap();
    scene.add_mesh(&common::ball(Vec3::ZERO, 0.5, 12)).unwrap();
    let camera = StereoCamera::look_at(Vec3::new(0.5, 1.5, 4.0), Vec3::ZERO).size(48, 36).interaxial_pixels(3.0);
    let mut random = Random::new(8);
    scene.ambient = Some(Vec3::splat(0.1));
    scene.lights =
        (0..1000).map(|_| Light::point(random.point(3.0) + 4.0 * Vec3::Y, Vec3::splat(0.9 / 1000.0))).collect();
    let pairs =
        render(&scene, &camera, &[Method::Naive, Method::BRACKET_RAYS]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(wrong(&scene, &pairs[0], 3), [0, 0]);
    assert_eq!(differing(&pairs[0].right, &pairs[1].right), [0, 0]);
}
