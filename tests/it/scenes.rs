//! Tests real meshes, if they are unpacked: against obvhs's own traversal, and by their triangle counts.

use crate::common;

use common::{compares_bits, is_exact, renderer, scenes_with};
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2},
    ray,
};
use stereotrace::{
    FAR, MISS, Method, Options, Ray, RayHit, Renderer, Scene, SceneOptions, StereoCamera, StereoPair, Triangle,
    UploadedScene,
    blocking::Wait,
    glam::Vec3,
    metrics::compare,
    testing::cpu::{Eye, Frame, intersect::intersect_triangle},
};

/// obvhs's tree and traversal, with the library's triangle test as its closure. Its box test has no margin, so it
/// sometimes loses a hit at the very edge of a box.
struct Theirs<'a> {
    scene: &'a Scene,
    tree: Bvh2,
}

impl<'a> Theirs<'a> {
    fn of(scene: &'a Scene) -> Self {
        let around = |t: &Triangle| {
            let [a, b, c] = t.corners;
            Aabb::new(a.min(b).min(c).into(), a.max(b).max(c).into())
        };
        let boxes: Vec<Aabb> = scene.triangles().iter().map(around).collect();
        let tree = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut std::time::Duration::default());
        Self { scene, tree }
    }

    /// Returns t of the ray's nearest hit, or `t_max` or infinity for a miss.
    fn closest(&self, origin: Vec3, direction: Vec3, t_min: f32, t_max: f32) -> f32 {
        let intersect = |index: usize| {
            let triangle = &self.scene.triangles()[self.tree.primitive_indices[index] as usize];
            let t = (!triangle.is_degenerate()).then(|| intersect_triangle(origin, direction, triangle.corners));
            t.flatten().filter(|t| *t >= t_min).unwrap_or(f32::INFINITY)
        };
        let ray = ray::Ray::new(origin.into(), direction.into(), t_min, t_max);
        let mut hit = ray::RayHit::none();
        self.tree.ray_traverse(ray, &mut hit, |_, index| intersect(index));
        hit.t.min(t_max) // infinite if the ray misses the whole tree, else at most its t_max
    }
}

fn check(name: &str, triangles: usize) {
    let Some(folder) = scenes_with(&format!("{name}/{name}.obj")) else { return };
    let scene = Scene::from_obj(folder.join(name).join(format!("{name}.obj"))).unwrap();
    assert_eq!(scene.primitive_count(), triangles);
    let camera = StereoCamera::from_json(folder.join("cameras.json"), name, 201, 151).unwrap();
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let pair = renderer.pair(&uploaded, &camera).options(&Options::new(Method::Naive)).read().wait().unwrap();
    if !compares_bits(&renderer) {
        return;
    }

    let searched =
        renderer.pair(&uploaded, &camera).options(&Options::new(Method::BRACKET_RAYS)).read().wait().unwrap();
    assert!(searched.right == pair.right, "the tiles' search loses something");

    let theirs = Theirs::of(&scene);
    check_views(&theirs, &pair);
    check_intervals(&mut renderer, &uploaded, &theirs, &pair);
    let mut lit = scene.clone();
    lit.place_lights(2, &camera).unwrap();
    for light in &lit.lights {
        check_shadows(&mut renderer, &uploaded, &theirs, &pair, light.position.as_vec3());
    }
}

/// Checks every pixel of both views.
fn check_views(theirs: &Theirs<'_>, pair: &StereoPair) {
    let frame = Frame::new(&pair.pose);
    let [width, height] = frame.size();
    let (mut lost, mut hits) = (0, 0);
    for (eye, view) in [(Eye::Left, &pair.left), (Eye::Right, &pair.right)] {
        for (row, column) in (0..height).flat_map(|row| (0..width).map(move |column| (row, column))) {
            let (origin, direction) = (frame.eye(eye), frame.direction(eye, column, row));
            let found = view.depth[row * width + column].min(FAR);
            let theirs = theirs.closest(origin, direction, 0.0, FAR);
            assert!(found <= theirs, "({column}, {row}): obvhs hits at {theirs}, the kernel at {found}");
            lost += usize::from(found < theirs);
            hits += usize::from(found < FAR);
        }
    }
    // None of 60,702 rays differs on sponza_4x and dragon.
    assert!(lost <= 6, "{lost} of {} rays differ from obvhs's", 2 * width * height);
    assert!(hits > width * height / 2, "{hits}");
}

/// Returns every third pixel of the left view: column, row and depth.
fn samples(pair: &StereoPair) -> impl Iterator<Item = (usize, usize, f32)> + '_ {
    let [width, height] = pair.pose.size.map(|side| side as usize);
    let pixels = (0..height).flat_map(move |row| (0..width).map(move |column| (column, row))).step_by(3);
    pixels.map(move |(column, row)| (column, row, pair.left.depth[row * width + column].min(1e5)))
}

/// Checks intervals around the left eye's hits, seen from the right eye.
fn check_intervals(renderer: &mut Renderer, uploaded: &UploadedScene, theirs: &Theirs<'_>, pair: &StereoPair) {
    let frame = Frame::new(&pair.pose);
    let right = frame.eye(Eye::Right);
    let interval = |(column, row, z): (usize, usize, f32)| {
        Ray::new(right, frame.direction(Eye::Right, column, row)).t_min(0.9 * z).t_max(1.1 * z)
    };
    let intervals: Vec<_> = samples(pair).map(interval).collect();
    let found = renderer.closest_hits(uploaded, &intervals).wait().unwrap().hits;
    let differs = |(hit, ray): &(&RayHit, &Ray)| {
        let t = if hit.primitive == MISS { ray.t_max } else { hit.t };
        t != theirs.closest(right, ray.direction, ray.t_min, ray.t_max)
    };
    let differing = found.iter().zip(&intervals).filter(differs).count();
    // None of 10,117 rays differs on both scenes.
    assert!(differing <= 1, "{differing} of {} interval rays differ from obvhs's", found.len());
}

/// Checks shadow rays from a light to the left eye's hits.
fn check_shadows(
    renderer: &mut Renderer,
    uploaded: &UploadedScene,
    theirs: &Theirs<'_>,
    pair: &StereoPair,
    origin: Vec3,
) {
    let frame = Frame::new(&pair.pose);
    let left = frame.eye(Eye::Left);
    let point = |(column, row, z): (usize, usize, f32)| left + frame.direction(Eye::Left, column, row) * z;
    let towards = |point: Vec3| Ray::new(origin, point - origin).t_max(0.9999);
    let rays: Vec<_> = samples(pair).map(point).map(towards).collect();
    let found = renderer.any_hits(uploaded, &rays).wait().unwrap().hits;
    let occluded = |ray: &Ray| theirs.closest(origin, ray.direction, 0.0, ray.t_max) < ray.t_max;
    let differing = found.iter().zip(&rays).filter(|(found, ray)| **found != occluded(ray)).count();
    let dark = found.iter().filter(|occluded| **occluded).count();
    // None of 10,117 rays differs on both scenes, for both lights.
    assert!(differing <= 1, "{differing} of {} shadow rays differ from obvhs's", found.len());
    assert!(dark > 100 && dark < found.len(), "{dark}");
}

#[test]
fn sponza_is_hit_as_by_obvhs() {
    check("sponza_4x", 265_816);
}

#[test]
fn the_dragon_is_hit_as_by_obvhs() {
    check("dragon", 871_414);
}

/// Returns whether red, green and blue are a colour of some name.
type IsColor = fn([i32; 3]) -> bool;

/// Checks the colours of a textured mesh from the file's camera under five lights, and that `bracket` shows the same
/// colours. All of the cow's pixels and 99.94% of Sponza's pixels are identical.
fn check_textured(name: &str, colors: &[(&str, IsColor)], least_identical: f64) {
    let Some(folder) = scenes_with(&format!("{name}/{name}.obj")) else { return };
    let options = SceneOptions::default().crease_angle(Some(30.0));
    let mut scene = Scene::from_obj_with(folder.join(name).join(format!("{name}.obj")), &options).unwrap();
    let camera = StereoCamera::from_json(folder.join("cameras.json"), name, 200, 150).unwrap();
    scene.place_lights(5, &camera).unwrap();
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let naive = renderer.pair(&uploaded, &camera).options(&Options::new(Method::Naive)).read().wait().unwrap();
    for (color, is_it) in colors {
        let count = naive.left.rgba8.iter().filter(|[r, g, b, _]| is_it([*r, *g, *b].map(i32::from))).count();
        println!("{name}: {count} pixels are {color}");
        assert!(count > 30, "{name}: {count} pixels are {color}");
    }
    let bracket = renderer.pair(&uploaded, &camera).options(&Options::new(Method::BRACKET)).read().wait().unwrap();
    let identical = compare(&bracket.right, &naive.right, &naive.pose).unwrap().identical_of_surfaces_percent;
    println!("{name}: {identical}% identical");
    assert!(identical >= least_identical, "{name}: {identical}% identical");
    let rays = renderer.pair(&uploaded, &camera).options(&Options::new(Method::BRACKET_RAYS)).read().wait().unwrap();
    assert!(!is_exact(&renderer) || rays.right == naive.right, "{name}: bracket-rays");
}

#[test]
fn the_cow_has_brown_horns_a_pink_mouth_and_dark_spots() {
    let brown = |[r, g, b]: [i32; 3]| r > 70 && r < 200 && 10 * g < 7 * r && 10 * b < 5 * r;
    let pink = |[r, g, b]: [i32; 3]| r > 150 && (60..90).contains(&(100 * g / r)) && (40..80).contains(&(100 * b / r));
    let dark = |[r, g, b]: [i32; 3]| (20..90).contains(&r) && (r - g).abs() < 8 && (r - b).abs() < 8;
    check_textured("spot", &[("brown", brown), ("pink", pink), ("dark", dark)], 99.9);
}

#[test]
fn sponza_is_textured_and_carried_over_as_traced() {
    let warm = |[r, g, b]: [i32; 3]| r > 60 && r > g && g > b && 4 * b < 3 * r;
    let grey = |[r, g, b]: [i32; 3]| r > 60 && (r - g).abs() < 10 && 10 * b > 8 * r;
    check_textured("sponza", &[("warm", warm), ("grey", grey)], 99.7);
}
