//! Tests grounds much larger than the objects on them, against a tracer in double precision that follows the same f32
//! rays.

use crate::common;
use crate::truth;

use common::{is_exact, random::Random, renderer};
use stereotrace::{
    Ellipsoid, Light, Material, MaterialId, Mesh, Method, Options, PixelSource, Scene, Sky, Sphere, StereoCamera,
    StereoPair, View,
    blocking::Wait,
    glam::{Mat3, Quat, Vec3},
    testing::cpu::{Eye, Frame},
};
use truth::{Seen, Truth};

const WIDTH: u32 = 200;
const HEIGHT: u32 = 150;

/// Maximum share of the ground's pixels with a wrong colour, and maximum relative error of a depth.
const WRONG_SHARE: f64 = 1e-3;
/// The second is for adapters that contract operations: 1.06e-5 on an NVIDIA H200.
const DEPTH_ERROR: [f64; 2] = [1e-5, 1.5e-5];
/// Smallest sine of the angle between ray and tilted ground for which the depth bound holds. Rounding a unit normal to
/// f32 moves a hit by up to some 1e-7 of its depth over that sine. At smaller sines, the bound grows in the same way.
const GRAZING: f64 = 0.02;
/// Maximum error of the colour of a floor's pixel, in steps of 255.
const STEPS: u8 = 3;

/// Methods whose right pixels show the hits of their own rays. The other methods reuse some samples from up to half a
/// pixel away.
const OWN_RAYS: [&str; 4] = ["bracket", "verified", "bracket-rays", "auto"];
const COPIED: [&str; 6] = ["atomic", "buffer", "buffer-2e", "es-isler", "adelson-hodges", "atomic-edges"];

/// The ground of a scene: a square, or a sphere or an ellipsoid that touches the origin from below.
#[derive(Clone, Copy, Debug)]
enum Ground {
    Quad { half_side: f32, tilt_degrees: f32 },
    Sphere { radius: f32 },
    Ellipsoid { radius: f32, height: f32, tilt_degrees: f32 },
}

impl Ground {
    /// Returns the rotation from the level world to the tilted world.
    fn turn(self) -> Quat {
        match self {
            Self::Quad { tilt_degrees, .. } | Self::Ellipsoid { tilt_degrees, .. } => {
                Quat::from_axis_angle(Vec3::new(1.0, 0.0, 0.3).normalize(), tilt_degrees.to_radians())
            }
            Self::Sphere { .. } => Quat::IDENTITY,
        }
    }

    /// Returns a dozen boxes on the ground, lit by three lamps alone.
    fn scene(self, boxes: bool) -> Scene {
        let mut scene = Scene::new();
        let grey = scene.add_material(Material::new(Vec3::splat(0.6)).name("grey"));
        let red = scene.add_material(Material::new(Vec3::new(0.8, 0.3, 0.2)));
        match self {
            Self::Quad { half_side, .. } => {
                let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
                let corners = corners.map(|(x, z)| self.turn() * Vec3::new(x * half_side, 0.0, z * half_side));
                let mut quad = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
                quad.materials = vec![grey];
                scene.add_mesh(&quad).unwrap();
            }
            Self::Sphere { radius } => {
                scene.add_sphere(Sphere::new(-radius * Vec3::Y, radius, grey)).unwrap();
            }
            Self::Ellipsoid { radius, height, .. } => {
                let axes = Mat3::from_quat(self.turn()) * Mat3::from_diagonal(Vec3::new(radius, height, radius));
                scene.add_ellipsoid(Ellipsoid::new(-axes.y_axis, axes, grey)).unwrap();
            }
        }
        let mut random = Random::new(5);
        for index in 0..if boxes { 12 } else { 0 } {
            let center = Vec3::new(1.6 * (index % 4) as f32 - 2.4, 0.1, 1.7 * (index / 4) as f32 - 2.6);
            let half = Vec3::new(random.between(0.2, 0.5), random.between(0.2, 0.9), random.between(0.2, 0.5));
            add_box(&mut scene, center, half, random.between(0.0, 1.5), self.turn(), red);
        }
        scene.ambient = Some(Vec3::splat(0.15));
        scene.sky = Sky::Constant(Vec3::new(0.2, 0.4, 0.9));
        let lamps = [Vec3::new(-4.0, 6.0, 3.0), Vec3::new(3.5, 4.0, -2.0), Vec3::new(1.0, 9.0, 5.0)];
        scene.lights = lamps.map(|lamp| Light::point(self.turn() * lamp, Vec3::new(0.32, 0.28, 0.26))).to_vec();
        scene
    }

    /// Returns a camera six units away, with the horizon in the picture.
    fn camera(self) -> StereoCamera {
        let turn = self.turn();
        StereoCamera::look_at(turn * Vec3::new(0.7, 1.9, 5.7), turn * Vec3::new(0.0, 0.4, 0.0))
            .up(turn * Vec3::Y)
            .size(WIDTH, HEIGHT)
            .interaxial_pixels(7.0)
    }
}

/// Adds a box that is rotated around its own upright axis, then with the ground.
fn add_box(scene: &mut Scene, center: Vec3, half: Vec3, around: f32, turn: Quat, material: MaterialId) {
    let corner = |index: usize| {
        let sign = |bit: usize| if index >> bit & 1 == 0 { -1.0 } else { 1.0 };
        turn * (center + Quat::from_rotation_y(around) * (half * Vec3::new(sign(0), sign(1), sign(2))))
    };
    let faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mut boxed = Mesh::new((0..8).map(corner).collect(), triangles);
    boxed.materials = vec![material];
    scene.add_mesh(&boxed).unwrap();
}

fn far_apart(found: [u8; 4], expected: [u8; 3]) -> bool {
    found.iter().zip(expected).any(|(a, b)| a.abs_diff(b) > STEPS)
}

/// Difference of a view from the truth on the floor.
#[derive(Debug, Default)]
struct Judged {
    floor: usize,
    wrong_colors: usize,
    /// Largest relative error of the depth. For the second value, errors at angles below [`GRAZING`] are scaled to that
    /// angle.
    depth_error: f64,
    scaled_depth_error: f64,
    least_slope: f64,
    /// Largest error of the parallax that follows from the depth.
    parallax_error: f64,
    /// Largest distance of a hit from the floor's surface.
    off_surface: f64,
}

impl Judged {
    /// Compares the pixels for which `counts` holds and in which the truth shows the floor.
    fn new(pair: &StereoPair, view: &View, truth: &[Seen], scene: &Scene, counts: impl Fn(usize) -> bool) -> Self {
        let mut judged = Self { least_slope: 1.0, ..Self::default() };
        let on_floor = |seen: &Seen| seen.primitive != stereotrace::MISS && is_floor(scene, seen.primitive);
        for (index, seen) in truth.iter().enumerate().filter(|&(index, seen)| on_floor(seen) && counts(index)) {
            judged.floor += 1;
            judged.wrong_colors += usize::from(far_apart(view.rgba8[index], seen.srgb()));
            let found = view.primitive[index];
            if found == stereotrace::MISS || !is_floor(scene, found) {
                continue; // The pixel shows another surface's edge, which the colours test.
            }
            let error = (f64::from(view.depth[index]) - seen.t).abs();
            let parallax = f64::from(pair.pose.interaxial_px) * f64::from(pair.pose.screen_distance);
            let parallax_error = parallax * (1.0 / f64::from(view.depth[index]) - 1.0 / seen.t).abs();
            judged.least_slope = judged.least_slope.min(seen.slope);
            judged.depth_error = judged.depth_error.max(error / seen.t);
            let scaled = error / seen.t * (seen.slope / GRAZING).min(1.0);
            judged.scaled_depth_error = judged.scaled_depth_error.max(scaled);
            judged.parallax_error = judged.parallax_error.max(parallax_error);
            judged.off_surface = judged.off_surface.max(error * seen.slope);
        }
        judged
    }

    fn wrong_share(&self) -> f64 {
        self.wrong_colors as f64 / self.floor as f64
    }
}

/// Returns whether a primitive is the floor. The floor is the quad, which comes first, or the sphere or ellipsoid,
/// which comes last.
fn is_floor(scene: &Scene, primitive: u32) -> bool {
    let material: &Material = match scene.triangles().get(primitive as usize) {
        Some(triangle) => &scene.materials()[triangle.material.0 as usize],
        None => &scene.materials()[1],
    };
    material.name == "grey"
}

/// Counts reused floor pixels whose colour does not occur nearby in the true view. Reused samples come from up to a
/// pixel away, so all nine pixels around each pixel are compared. Also returns the number of reused floor pixels.
fn acne_of_copies(pair: &StereoPair, truth: &[Seen], scene: &Scene) -> (usize, usize) {
    let (width, height) = (WIDTH as usize, HEIGHT as usize);
    let inner = (1..height - 1).flat_map(|row| (1..width - 1).map(move |column| row * width + column));
    let reused: Vec<_> = inner
        .filter(|&index| pair.source[index] == PixelSource::Reused)
        .filter(|&index| truth[index].primitive != stereotrace::MISS && is_floor(scene, truth[index].primitive))
        .collect();
    let acne = reused.iter().filter(|&&index| {
        let beside = [0, 1, 2].into_iter().flat_map(|y| [0, 1, 2].map(|x| index + y * width + x - width - 1));
        beside.into_iter().all(|other| far_apart(pair.right.rgba8[index], truth[other].srgb()))
    });
    (acne.count(), reused.len())
}

/// Renders a ground by every method, prints the errors of each, and returns the errors beyond the bounds.
fn faults(ground: Ground, judge: impl Fn(&Judged) -> Option<String>, boxes: bool) -> Vec<String> {
    let (scene, camera) = (ground.scene(boxes), ground.camera());
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let mut pair_by = |method: &str| {
        let method: Method = method.parse().unwrap();
        renderer.pair(&uploaded, &camera).options(&Options::new(method)).read().wait().unwrap()
    };
    let naive = pair_by("naive");
    let frame = Frame::new(&naive.pose);
    let truth = Truth::new(&scene);
    let [left, right] = [Eye::Left, Eye::Right].map(|eye| truth.view(&frame, eye));
    let mut faults = Vec::new();
    let mut report = |name: &str, judged: &Judged| {
        let Judged { wrong_colors, floor, depth_error, scaled_depth_error, .. } = judged;
        println!(
            "{ground:?} {name}: {wrong_colors} of {floor} floor pixels wrong ({:.2}%), depth {depth_error:.1e} \
             (scaled {scaled_depth_error:.1e}, slopes from {:.1e}), parallax {:.1e} px, {:.1e} off the surface",
            100.0 * judged.wrong_share(),
            judged.least_slope,
            judged.parallax_error,
            judged.off_surface
        );
        faults.extend(judge(judged).map(|fault| format!("{ground:?} {name}: {fault}")));
    };
    report("left", &Judged::new(&naive, &naive.left, &left, &scene, |_| true));
    report("naive", &Judged::new(&naive, &naive.right, &right, &scene, |_| true));
    let mut others = Vec::new();
    for name in OWN_RAYS {
        let pair = pair_by(name);
        report(name, &Judged::new(&pair, &pair.right, &right, &scene, |_| true));
        others.push((name, pair));
    }
    let mut acne = Vec::new();
    for name in COPIED {
        let pair = pair_by(name);
        let traced = Judged::new(&pair, &pair.right, &right, &scene, |index| pair.source[index] != PixelSource::Reused);
        // Few pixels are traced, most of them at edges. So the allowed share refers to all pixels of the picture.
        let share = Judged { floor: WIDTH as usize * HEIGHT as usize, ..traced };
        report(name, &share);
        acne.push((name, acne_of_copies(&pair, &right, &scene)));
        others.push((name, pair));
    }
    for (name, (acne, reused)) in acne {
        println!("{ground:?} {name}: {acne} of {reused} reused floor pixels have acne");
        if acne as f64 > WRONG_SHARE * reused as f64 {
            faults.push(format!("{ground:?} {name}: {acne} of {reused} reused floor pixels have acne"));
        }
    }
    for (name, pair) in others {
        if pair.left.rgba8 != naive.left.rgba8 || pair.left.depth != naive.left.depth {
            faults.push(format!("{ground:?} {name}: the left view is not naive's"));
        }
    }
    faults
}

fn most_depth_error() -> f64 {
    DEPTH_ERROR[usize::from(!is_exact(&renderer()))]
}

/// Checks a level floor, whose normal is not rounded, or a sphere. Depths are within the bound at grazing angles too.
fn exact(judged: &Judged) -> Option<String> {
    let good = judged.depth_error <= most_depth_error();
    within(judged).or_else(|| (!good).then(|| format!("{judged:?}")))
}

/// Checks that a floor's colours, depths and parallaxes are within the bounds.
fn within(judged: &Judged) -> Option<String> {
    let good = judged.wrong_share() <= WRONG_SHARE
        && judged.scaled_depth_error <= most_depth_error()
        && judged.parallax_error <= 0.01;
    (!good).then(|| format!("{judged:?}"))
}

fn assert_none(faults: &[String]) {
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

fn quads(tilt_degrees: f32, judge: fn(&Judged) -> Option<String>) -> Vec<String> {
    let sizes = [20.0, 200.0, 1000.0, 1e4, 3.5e5, 1e6];
    sizes.into_iter().flat_map(|half_side| faults(Ground::Quad { half_side, tilt_degrees }, judge, true)).collect()
}

#[test]
fn level_grounds_of_any_size_are_as_in_double_precision() {
    assert_none(&quads(0.0, exact));
}

#[test]
fn grounds_tilted_by_1_degree_are_as_in_double_precision() {
    assert_none(&quads(1.0, within));
}

#[test]
fn grounds_tilted_by_30_degrees_are_as_in_double_precision() {
    assert_none(&quads(30.0, within));
}

#[test]
fn ground_spheres_to_a_radius_of_10_000_are_as_in_double_precision() {
    let radii = [20.0, 200.0, 1000.0, 1e4];
    assert_none(&radii.map(|radius| faults(Ground::Sphere { radius }, exact, true)).concat());
}

/// Without boxes there are no shadow edges that could move, so every wrong colour is acne.
#[test]
fn ground_spheres_beyond_have_no_acne_and_are_off_by_at_most_an_ulp_of_the_radius() {
    let beyond = |radius: f32| {
        let ulp = f64::from(radius.next_up() - radius);
        let bound = move |judged: &Judged| {
            let good = judged.wrong_colors == 0 && judged.off_surface <= ulp;
            (!good).then(|| format!("an ulp is {ulp:.1e}: {judged:?}"))
        };
        faults(Ground::Sphere { radius }, bound, false)
    };
    assert_none(&[1e5, 1e6].map(beyond).concat());
}

/// Tests thick and flat ellipsoids along the world's axes. Their matrices are exact or nearly exact.
#[test]
fn ground_ellipsoids_to_10_000_are_as_in_double_precision() {
    let sizes = [(20.0, 5.0), (1000.0, 1.0), (1e4, 5e3), (1e4, 10.0)];
    let ground = |(radius, height)| Ground::Ellipsoid { radius, height, tilt_degrees: 0.0 };
    assert_none(&sizes.map(|size| faults(ground(size), exact, true)).concat());
}

/// The rounding of the matrices moves these ellipsoids by some ulps of their size, but they have no acne.
#[test]
fn tilted_and_vast_ground_ellipsoids_have_no_acne_and_are_off_by_at_most_two_ulps() {
    let beyond = |(radius, height, tilt_degrees): (f32, f32, f32)| {
        let ulp = f64::from(radius.next_up() - radius);
        let bound = move |judged: &Judged| {
            let good = judged.wrong_colors == 0 && judged.off_surface <= 2.0 * ulp;
            (!good).then(|| format!("an ulp is {ulp:.1e}: {judged:?}"))
        };
        faults(Ground::Ellipsoid { radius, height, tilt_degrees }, bound, false)
    };
    let sizes = [(1e4, 10.0, 30.0), (1e6, 1e6, 0.0), (1e6, 1e3, 0.0), (1e5, 1e4, 30.0), (1e6, 1e3, 30.0)];
    assert_none(&sizes.map(beyond).concat());
}

/// Tests the comparison itself. It must detect a wrong shadow bit, one colour step too many, or the depth of another
/// plane.
#[test]
fn a_wrong_pixel_a_wrong_depth_and_a_hole_are_seen() {
    let ground = Ground::Quad { half_side: 20.0, tilt_degrees: 0.0 };
    let (scene, camera) = (ground.scene(true), ground.camera());
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let pair = renderer.pair(&uploaded, &camera).options(&Options::new(Method::Naive)).read().wait().unwrap();
    let truth = Truth::new(&scene).view(&Frame::new(&pair.pose), Eye::Left);
    let judge = |view: &View| Judged::new(&pair, view, &truth, &scene, |_| true);
    let before = judge(&pair.left);
    assert!(before.floor > 10_000, "{before:?}");
    let index = truth.iter().position(|seen| seen.primitive < 2).unwrap();
    let mut view = pair.left.clone();
    view.rgba8[index][1] = truth[index].srgb()[1].wrapping_add(STEPS + 1);
    assert_eq!(judge(&view).wrong_colors, before.wrong_colors + 1);
    view.depth[index] *= 1.0001;
    let after = judge(&view);
    assert!(after.depth_error > 9e-5 && after.parallax_error > before.parallax_error, "{after:?}");
}
