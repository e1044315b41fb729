//! Tests motion blur against closed forms.

use crate::common;

use common::renderer;
use stereotrace::{
    GBuffer, Light, Material, Mesh, Method, MotionBlur, Options, Scene, Sky, StereoCamera, StereoPair, Update,
    blocking::Wait,
    camera::Intrinsics,
    glam::{Affine3A, Vec3, vec3},
};

const SIZE: [u32; 2] = [64, 8];
const INTERAXIAL: f64 = 0.05;
/// Focal length in pixels, and distance of the bar.
const FOCAL: f64 = 60.0;
const DISTANCE: f64 = 3.0;
/// Edges of the bar in the left picture at the middle of the shutter, and its motion while the shutter is open.
const EDGES: [f64; 2] = [26.3, 31.7];
const MOTION: f64 = 9.0;

/// Returns a white bar before black, lit by ambient light alone.
fn bar() -> Scene {
    let mut scene = Scene::new();
    let white = scene.add_material(Material::new(Vec3::ONE));
    let [left, right] = EDGES.map(|edge| ((edge - 32.0) * DISTANCE / FOCAL - INTERAXIAL / 2.0) as f32);
    let z = -DISTANCE as f32;
    let corners = [vec3(left, -9.0, z), vec3(right, -9.0, z), vec3(right, 9.0, z), vec3(left, 9.0, z)];
    scene.add_mesh(&Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).materials(vec![white; 2])).unwrap();
    scene.sky = Sky::Constant(Vec3::ZERO);
    scene.ambient = Some(Vec3::ONE);
    scene.lights = vec![Light::point(vec3(0.0, 0.0, 1.0), Vec3::ZERO)];
    scene
}

fn camera() -> StereoCamera {
    let intrinsics = Intrinsics::new([FOCAL; 2], [32.0, 4.0]);
    let camera = StereoCamera::look_at(Vec3::ZERO, -Vec3::Z).size(SIZE[0], SIZE[1]);
    camera.intrinsics(intrinsics).interaxial(INTERAXIAL as f32)
}

fn options() -> Options {
    Options::new(Method::Naive).linear(true).g_buffer(GBuffer::Ids)
}

/// Renders the bar in the middle of the shutter, and the mean of all times.
fn blurred(times: u32) -> (StereoPair, StereoPair) {
    let (mut renderer, at_rest) = (renderer(), bar());
    let mut uploaded = renderer.upload(&at_rest).wait().unwrap();
    let sharp = renderer.pair(&uploaded, &camera()).options(&options()).read().wait().unwrap();
    let mut blur = MotionBlur::new();
    for offset in MotionBlur::offsets(MOTION, times) {
        let mut moved = at_rest.clone();
        let step = Vec3::X * (offset * DISTANCE / FOCAL) as f32;
        moved.transform_object(0, &Affine3A::from_translation(step)).unwrap();
        renderer.update(&mut uploaded, &moved, Update::RefitOrRebuild).wait().unwrap();
        blur.add(&renderer.pair(&uploaded, &camera()).options(&options()).read().wait().unwrap()).unwrap();
    }
    assert_eq!(blur.count(), times);
    let mut pair = sharp.clone();
    blur.apply(&mut pair, &options()).unwrap();
    (sharp, pair)
}

/// Each pixel's light is the part of the time in which the bar covers its centre. N times give it within 1/N.
#[test]
fn a_moving_bar_is_a_ramp_in_both_eyes_and_its_truth_stays() {
    for times in [8, 32] {
        let (sharp, pair) = blurred(times);
        let disparity = FOCAL * INTERAXIAL / DISTANCE;
        for (view, shift) in [(&pair.left, 0.0), (&pair.right, disparity)] {
            let mut covered = 0.0;
            for (index, color) in view.linear.iter().enumerate() {
                let x = (index % SIZE[0] as usize) as f64 + 0.5 + shift;
                let [enters, leaves] = EDGES.map(|edge| ((x - edge) / MOTION + 0.5).clamp(0.0, 1.0));
                let expected = enters - leaves;
                let off = f64::from(color[0]) - expected;
                assert!(off.abs() <= 1.0 / f64::from(times) + 1e-6, "{times} times, {x}: {color:?}, not {expected}");
                covered += off;
            }
            // The errors cancel, unless the times lie to one side.
            let mean = covered / view.linear.len() as f64;
            assert!(mean.abs() < 0.1 / f64::from(times), "{times} times: {mean}");
        }
        let of = |pair: &StereoPair| {
            [&pair.left, &pair.right].map(|view| (view.depth.clone(), view.primitive.clone(), view.object.clone()))
        };
        assert_eq!(of(&pair), of(&sharp));
        assert_ne!(pair.left.rgba8, sharp.left.rgba8);
    }
}

#[test]
fn the_mean_of_one_picture_is_this_picture() {
    let mut renderer = renderer();
    let scene = bar();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    for options in [options(), options().exposure(-0.7).tone(stereotrace::Tone::Filmic).samples(4)] {
        let pair = renderer.pair(&uploaded, &camera()).options(&options).read().wait().unwrap();
        let mut blur = MotionBlur::new();
        blur.add(&pair).unwrap();
        let mut found = pair.clone();
        blur.apply(&mut found, &options).unwrap();
        assert_eq!(found.left.linear, pair.left.linear);
        assert_eq!(found.right.rgba8, pair.right.rgba8);
    }
}

#[test]
fn pictures_that_have_no_mean_are_refused_and_none_changes_nothing() {
    let mut renderer = renderer();
    let scene = bar();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let mut of = |camera: StereoCamera, options: &Options| {
        renderer.pair(&uploaded, &camera).options(options).read().wait().unwrap()
    };
    let pair = of(camera(), &options());
    let small = of(camera().size(32, 8), &options());
    let shown = of(camera(), &Options::new(Method::Naive));
    let mut blur = MotionBlur::new();
    let mut same = pair.clone();
    blur.apply(&mut same, &options()).unwrap();
    assert_eq!(same.left, pair.left);
    let message = blur.add(&shown).unwrap_err().to_string();
    assert!(message.contains("motion blur: it needs linear light"), "{message}");
    blur.add(&pair).unwrap();
    let message = blur.add(&small).unwrap_err().to_string();
    assert!(message.contains("the pictures have different sizes"), "{message}");
    assert!(blur.apply(&mut small.clone(), &options()).is_err());
    assert_eq!(blur.count(), 1);
}
