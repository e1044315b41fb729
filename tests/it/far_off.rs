//! Tests scenes far from the origin. f32 rounds their coordinates, which becomes visible in pictures beyond some
//! distance.

use crate::common;

use common::{ball, folder::Folder, gpu, random::Random, render, scenes_with, warnings};
use serde_json::Value;
use stereotrace::{
    EyeTruth, GroundTruth, Light, MISS, Mesh, Method, Options, Origin, Renderer, Scene, SceneFile, SceneOptions,
    StereoCamera, View,
    blocking::Wait,
    glam::{BVec3, DMat4, DVec3, Quat, Vec3},
};

/// Returns two boxes and a ball on a floor of one unit, under three lights, all moved by an offset.
fn still_life(by: Vec3) -> Scene {
    let mut scene = Scene::new();
    let corner = |x: f32, z: f32| by + Vec3::new(x, 0.0, z);
    let floor = vec![corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
    scene.add_mesh(&Mesh::new(floor, vec![[0, 2, 1], [0, 3, 2]])).unwrap();
    for (center, half, turn) in [(Vec3::new(-0.15, 0.12, -0.1), 0.12, 0.4), (Vec3::new(0.2, 0.07, 0.1), 0.07, 1.1)] {
        let sides = |bits: u32| [0, 1, 2].map(|axis| if bits >> axis & 1 == 1 { half } else { -half });
        let corner = |bits: u32| by + center + Quat::from_rotation_y(turn) * Vec3::from_array(sides(bits));
        let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        scene.add_mesh(&Mesh::new((0..8).map(corner).collect(), triangles)).unwrap();
    }
    scene.add_mesh(&ball(by + Vec3::new(0.1, 0.1, -0.25), 0.1, 24)).unwrap();
    scene.ambient = Some(Vec3::splat(0.15));
    for at in [[0.6, 0.9, 0.5], [-0.5, 0.8, 0.6], [0.1, 1.2, -0.3]] {
        scene.lights.push(Light::point(by + Vec3::from_array(at), Vec3::splat(0.3)));
    }
    scene
}

const DIRECTION: Vec3 = Vec3::new(1.0, 0.37, -0.71);

/// Returns the number of pixels without a similar pixel, within 8 levels, among the nine around them in the other view.
/// If an edge moves by less than a pixel, its pixels still have a similar pixel.
fn broken(view: &View, other: &View, width: i32, height: i32) -> usize {
    let pixel = |view: &View, row: i32, column: i32| view.rgba8[(row * width + column) as usize];
    let alike = |a: [u8; 4], b: [u8; 4]| a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 8);
    let all = (0..height).flat_map(|row| (0..width).map(move |column| (row, column)));
    all.filter(|&(row, column)| {
        let rows = (row - 1).max(0)..(row + 2).min(height);
        let mut about = rows.flat_map(|row| ((column - 1).max(0)..(column + 2).min(width)).map(move |c| (row, c)));
        !about.any(|(r, c)| alike(pixel(view, row, column), pixel(other, r, c)))
    })
    .count()
}

#[test]
fn as_far_off_as_nothing_is_said_pictures_are_those_at_the_origin() {
    let seen = |distance: f32| {
        let by = distance * DIRECTION;
        let camera = StereoCamera::look_at(by + Vec3::new(0.3, 0.7, 1.2), by + Vec3::new(0.0, 0.05, 0.0));
        render(&still_life(by), &camera.size(200, 150).interaxial_pixels(8.0), Method::Naive).left
    };
    let here = seen(0.0);
    let [near, far] = [1000.0, 1e5].map(|distance| broken(&seen(distance), &here, 200, 150));
    println!("of 30000 pixels {near} are broken at 1000 units, {far} at 1e5");
    // The measured numbers are 0 pixels at 1000 units, and 306 at 1e5.
    assert!(near <= 10 && far >= 150, "{near} and {far}");
}

#[test]
fn what_is_farther_off_is_warned_of_once_a_renderer_with_the_remedy() {
    warnings::collect();
    let warnings = || {
        let all = warnings::of_this_thread();
        all.into_iter().filter(|warning| warning.starts_with("the scene")).collect::<Vec<_>>()
    };
    let first = Renderer::new(gpu());
    for distance in [0.0, 1000.0] {
        first.upload(&still_life(distance * DIRECTION)).wait().unwrap();
    }
    assert_eq!(warnings(), Vec::<String>::new());
    for distance in [1100.0, 1e6, 1100.0] {
        first.upload(&still_life(distance * DIRECTION)).wait().unwrap();
    }
    Renderer::new(gpu()).upload(&still_life(1e6 * DIRECTION)).wait().unwrap();
    let text = |near: &str, step: &str, side: &str| {
        format!(
            "the scene's coordinates near {near} are rounded to steps of {step}, and its longest side is {side}: \
             detail and shadows break up; set an origin nearer to it"
        )
    };
    let expected = [text("1.1005e3", "0.00012207031", "1"), text("1.0000005e6", "0.0625", "1")];
    assert_eq!(warnings(), expected);
}

/// Offsets of scene files from the origin: none, a city in a national grid, UTM coordinates, and the documented limit.
const PLACES: [DVec3; 4] = [
    DVec3::ZERO,
    DVec3::new(45_123.0, 0.0, 12_456.0),
    DVec3::new(500_000.0, 120.0, 5_400_000.0),
    DVec3::new(1e7, 0.0, -1e7),
];

/// A mesh of triangles in double precision, as a file stores it.
struct Model {
    name: &'static str,
    positions: Vec<DVec3>,
    triangles: Vec<[usize; 3]>,
    /// Midpoint between the eyes, and the point that they look at.
    view: [DVec3; 2],
    baseline: f32,
}

impl Model {
    fn new(name: &'static str, view: [DVec3; 2], baseline: f32) -> Self {
        Self { name, positions: Vec::new(), triangles: Vec::new(), view, baseline }
    }

    fn add_box(&mut self, low: DVec3, high: DVec3) {
        let first = self.positions.len();
        let corner = |bits: usize| DVec3::select(BVec3::new(bits & 1 == 1, bits & 2 == 2, bits & 4 == 4), high, low);
        self.positions.extend((0..8).map(corner));
        let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
        self.triangles.extend(
            quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|corners| corners.map(|c| first + c)),
        );
    }

    /// Returns houses on both sides of a road of 240 metres, seen from a car.
    fn street() -> Self {
        let mut model = Self::new("street", [DVec3::new(0.3, 1.65, 110.0), DVec3::new(0.0, 1.2, 60.0)], 0.54);
        model.add_box(DVec3::new(-40.0, -0.5, -120.0), DVec3::new(40.0, 0.0, 120.0));
        let mut random = Random::new(3);
        for row in -10..10 {
            for side in [-1.0, 1.0] {
                let from = side * f64::from(random.between(6.0, 9.0));
                let [width, height] = [8.0, 12.0].map(|most| f64::from(random.between(4.0, most)));
                let z = 12.0 * f64::from(row);
                let (a, b) = (DVec3::new(from, 0.0, z), DVec3::new(from + side * width, height, z + 9.3));
                model.add_box(a.min(b), a.max(b));
            }
        }
        model
    }

    /// Returns crossed squares on a ground of 60 metres.
    fn forest() -> Self {
        let mut model = Self::new("forest", [DVec3::new(0.0, 1.7, 26.0), DVec3::new(0.0, 1.5, 0.0)], 0.12);
        model.add_box(DVec3::new(-30.0, -1.0, -30.0), DVec3::new(30.0, 0.0, 30.0));
        let mut random = Random::new(5);
        for _ in 0..400 {
            let [x, z, half, height] =
                [(-28.0, 28.0), (-28.0, 23.0), (0.2, 1.0), (1.0, 6.0)].map(|(a, b)| f64::from(random.between(a, b)));
            for [dx, dz] in [[half, 0.0], [0.0, half], [0.7 * half, 0.7 * half]] {
                let first = model.positions.len();
                let at = |side: f64, y: f64| DVec3::new(x + side * dx, y, z + side * dz);
                model.positions.extend([at(-1.0, 0.0), at(1.0, 0.0), at(1.0, height), at(-1.0, height)]);
                model.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|c: usize| first + c)));
            }
        }
        model
    }

    /// Returns Stanford's bunny, of some 0.15 units, if its file is found.
    fn bunny() -> Option<Self> {
        let text = std::fs::read_to_string(scenes_with("bunny/bunny.obj")?.join("bunny/bunny.obj")).unwrap();
        let mut model = Self::new("bunny", [DVec3::ZERO; 2], 0.0);
        for line in text.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            match words.first() {
                Some(&"v") => model.positions.push(DVec3::from_array([1, 2, 3].map(|at| words[at].parse().unwrap()))),
                Some(&"f") => model.triangles.push([1, 2, 3].map(|at| {
                    let corner = words[at].split('/').next().unwrap();
                    corner.parse::<usize>().unwrap() - 1
                })),
                _ => {}
            }
        }
        let (low, high) = model.positions.iter().fold((DVec3::MAX, DVec3::MIN), |(a, b), p| (a.min(*p), b.max(*p)));
        let (middle, size) = (low.midpoint(high), (high - low).max_element());
        model.view = [middle + size * DVec3::new(0.4, 0.3, 1.5), middle];
        model.baseline = (0.06 * size) as f32;
        Some(model)
    }

    /// Returns the text of a file with the mesh at a place, and the vertices as they are read from the file's digits.
    fn text(&self, place: DVec3) -> (String, Vec<DVec3>) {
        let mut text = String::new();
        let mut read = Vec::new();
        for position in &self.positions {
            let words = (*position + place).to_array().map(|value| format!("{value:.7}"));
            text += &format!("v {}\n", words.join(" "));
            read.push(DVec3::from_array(words.map(|word| word.parse().unwrap())));
        }
        for [a, b, c] in &self.triangles {
            text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
        }
        (text, read)
    }
}

/// Returns a number of one eye from the camera file.
fn number(file: &Value, eye: &str, name: &str) -> f64 {
    file[eye][name].as_f64().unwrap()
}

fn matrix(file: &Value, eye: &str, name: &str) -> DMat4 {
    let rows: Vec<[f64; 4]> = serde_json::from_value(file[eye][name].clone()).unwrap();
    DMat4::from_cols_slice(&rows.concat()).transpose()
}

/// Returns the largest errors of both views' disparities and rows in pixels. The reference is computed in double
/// precision from the digits of the scene file and the camera file alone. The third value is the number of pixels that
/// show a triangle although their ray misses it by more than 0.01 pixels.
fn errors(model: &Model, positions: &[DVec3], truth: &GroundTruth) -> (f64, f64, usize) {
    let file: Value = serde_json::from_str(&truth.pose.to_json()).unwrap();
    let left = errors_of(model, positions, (&file, "left", "right"), &truth.left);
    let right = errors_of(model, positions, (&file, "right", "left"), &truth.right);
    (left.0.max(right.0), left.1.max(right.1), left.2 + right.2)
}

fn errors_of(
    model: &Model,
    positions: &[DVec3],
    (file, own, other): (&Value, &str, &str),
    truth: &EyeTruth,
) -> (f64, f64, usize) {
    let to_world = matrix(file, own, "camera_to_world");
    let to_other = matrix(file, other, "world_to_camera");
    let [fx, fy, cx, cy] = ["fx", "fy", "cx", "cy"].map(|name| number(file, own, name));
    let sign = if own == "left" { 1.0 } else { -1.0 };
    let eye = to_world.transform_point3(DVec3::ZERO);
    let (mut of_disparity, mut of_row, mut missed) = (0.0_f64, 0.0_f64, 0);
    let width = truth.width as usize;
    for (index, &id) in truth.primitive.iter().enumerate().filter(|(_, id)| **id != MISS) {
        let [x, y] = [(index % width) as f64 + 0.5, (index / width) as f64 + 0.5];
        let direction = to_world.transform_vector3(DVec3::new((x - cx) / fx, (y - cy) / fy, 1.0));
        let [a, b, c] = model.triangles[id as usize].map(|corner| positions[corner] - eye);
        let normal = (b - a).cross(c - a);
        let z = normal.dot(a) / normal.dot(direction);
        let point = direction * z;
        // This is the distance by which the ray passes outside the triangle, in pixels.
        let outside =
            [(a, b), (b, c), (c, a)].map(|(p, q)| -normal.normalize().dot((q - p).normalize().cross(point - p)));
        missed += usize::from(outside.into_iter().fold(0.0, f64::max) * fx / z > 0.01);
        let seen = to_other.transform_point3(eye + point);
        let [column, row] = [fx * seen.x / seen.z + number(file, other, "cx"), fy * seen.y / seen.z + cy];
        of_disparity = of_disparity.max((sign * (x - column) - f64::from(truth.disparity[index])).abs());
        of_row = of_row.max((row - y).abs());
    }
    (of_disparity, of_row, missed)
}

/// Tests the same scene in a file at each place. The pictures must be equal, and the disparities must equal those
/// computed from the files in double precision.
#[test]
fn scene_files_far_from_the_origin_lose_nothing() {
    let folder = Folder::new("far_off");
    let [width, height] = [320, 200];
    for model in [Some(Model::street()), Some(Model::forest()), Model::bunny()].into_iter().flatten() {
        let mut at_home = None;
        for place in PLACES {
            let (text, positions) = model.text(place);
            let path = folder.write("scene.obj", text);
            let SceneFile { mut scene, .. } = SceneFile::open(&path, &SceneOptions::default()).unwrap();
            assert_eq!(scene.origin() == DVec3::ZERO, place == DVec3::ZERO, "{}", model.name);
            let [eye, target] = model.view.map(|point| point + place);
            let camera = StereoCamera::look_at(eye, target).size(width, height).screen_distance(f32::INFINITY);
            let camera = camera.interaxial(model.baseline).vertical_fov_degrees(50.0);
            scene.place_lights(3, &camera).unwrap();
            let mut renderer = common::renderer();
            let uploaded = renderer.upload(&scene).wait().unwrap();
            let pair =
                renderer.pair(&uploaded, &camera).options(&Options::new(Method::BRACKET_RAYS)).read().wait().unwrap();
            let naive = renderer.pair(&uploaded, &camera).options(&Options::new(Method::Naive)).read().wait().unwrap();
            assert!(pair.right == naive.right, "{} at {place}", model.name);
            let truth = renderer.ground_truth(&uploaded, &scene, &pair).wait().unwrap();
            let (of_disparity, of_row, missed) = errors(&model, &positions, &truth);
            let home = at_home.get_or_insert_with(|| pair.left.rgba8.clone());
            let others = home.iter().zip(&pair.left.rgba8).filter(|(a, b)| a != b).count();
            println!(
                "{} at {place}, origin {}: disparity {of_disparity:.6} px, rows {of_row:.6} px, {missed} missed, \
                {others} other pixels",
                model.name,
                scene.origin()
            );
            // The measured errors are 2.2e-5 px for disparities and 1.5e-4 px for rows. No triangle is missed, and 4 of
            // 64,000 pixels differ.
            assert!(of_disparity < 1e-4 && of_row < 6e-4 && missed == 0 && others <= 16, "{} at {place}", model.name);
        }
    }
}

/// f32 rounds these eyes by 2 mm, since the scene keeps the world's origin. The files must contain the rounded eyes.
#[test]
fn disparities_are_those_of_the_eyes_that_were_rendered() {
    let folder = Folder::new("far_off_rounded");
    let place = DVec3::new(45_120.0, 0.0, 12_480.0);
    let mut model = Model::street();
    // f32 can represent these vertices exactly, so that only the eyes are rounded.
    model.positions.iter_mut().for_each(|position| *position = (*position * 64.0).round() / 64.0);
    let (text, positions) = model.text(place);
    let path = folder.write("scene.obj", text);
    let SceneFile { scene, .. } = SceneFile::open(&path, &SceneOptions::default().origin(Origin::World)).unwrap();
    assert_eq!(scene.origin(), DVec3::ZERO);
    let [eye, target] = model.view.map(|point| point + place);
    let mut renderer = common::renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    for (screen, toe) in [(f32::INFINITY, 0.0), (30.0, 0.0), (f32::INFINITY, 20.0)] {
        let camera = StereoCamera::look_at(eye, target + toe * DVec3::X).size(320, 200).screen_distance(screen);
        let camera = camera.interaxial(model.baseline).vertical_fov_degrees(50.0);
        let pair = renderer.pair(&uploaded, &camera).options(&Options::new(Method::Naive)).read().wait().unwrap();
        let truth = renderer.ground_truth(&uploaded, &scene, &pair).wait().unwrap();
        let (of_disparity, of_row, missed) = errors(&model, &positions, &truth);
        let pose = &truth.pose;
        let by_interaxial = (pose.baseline() - f64::from(pose.interaxial)).abs() / pose.baseline();
        println!(
            "screen at {screen}, aside {toe}: disparity {of_disparity:.6} px, rows {of_row:.4} px, {missed} missed, \
             baseline off by {:.3}%",
            100.0 * by_interaxial
        );
        assert!(of_disparity < 1e-3, "{of_disparity}");
    }
}
