//! Tests pictures in passes against whole frames with as many paths, and against converged pictures.

use std::ops::ControlFlow;

use crate::{
    common::{self, renderer},
    paths::{room, room_camera},
};
use stereotrace::{
    Builtin, Error, Light, Lighting, Method, Options, Passes, Progress, Projection, Renderer, Rig, StereoCamera,
    StereoPair, Update, UploadedScene, View, blocking::Wait, glam::Vec3,
};

fn by_paths(samples: u32) -> Options {
    Options::new(Method::Naive).linear(true).lighting(Lighting::Paths { bounces: 2, samples })
}

fn pass(renderer: &mut Renderer, scene: &UploadedScene, options: &Options, passes: &mut Passes) -> StereoPair {
    renderer.pair(scene, &room_camera()).options(options).add_to(passes).wait().unwrap()
}

/// Returns the root of the mean square of two views' difference.
fn apart(view: &View, other: &View) -> f64 {
    let pairs = view.linear.iter().flatten().zip(other.linear.iter().flatten());
    let squares = pairs.map(|(a, b)| f64::from(a - b).powi(2));
    (squares.sum::<f64>() / view.linear.len() as f64).sqrt()
}

#[test]
fn passes_together_follow_the_paths_of_a_whole_frame() {
    let mut renderer = renderer();
    let scene = renderer.upload(&room()).wait().unwrap();
    let whole = renderer.pair(&scene, &room_camera()).options(&by_paths(16)).read().wait().unwrap();
    let first = renderer.pair(&scene, &room_camera()).options(&by_paths(2)).read().wait().unwrap();
    let mut passes = Passes::new();
    let mut pair = pass(&mut renderer, &scene, &by_paths(2), &mut passes);
    assert_eq!((&pair.left, &pair.right, passes.paths()), (&first.left, &first.right, 2));
    for paths in [2, 4, 8] {
        pair = pass(&mut renderer, &scene, &by_paths(paths), &mut passes);
    }
    assert_eq!((passes.count(), passes.paths()), (4, 16));
    // The paths are the same ones. Only the order of the sums differs.
    for (view, whole) in [(&pair.left, &whole.left), (&pair.right, &whole.right)] {
        assert!(apart(view, whole) < 1e-6, "{}", apart(view, whole));
        assert_eq!((&view.depth, &view.primitive), (&whole.depth, &whole.primitive));
    }
    assert!(apart(&whole.left, &first.left) > 0.01, "{}", apart(&whole.left, &first.left));
    assert_eq!(pair.statistics.right.rays.primary, 4 * whole.statistics.right.rays.primary);
}

/// A pass continues the sequences of its pixels, whatever frames were rendered before.
#[test]
fn passes_recall_no_earlier_frames() {
    let mut renderer = renderer();
    let scene = renderer.upload(&room()).wait().unwrap();
    let plain = by_paths(2).method(Method::BRACKET);
    let recalling = plain.clone().history(64);
    let mut pairs = [&plain, &recalling].map(|options| {
        renderer.pair(&scene, &room_camera()).options(options).read().wait().unwrap();
        let mut passes = Passes::new();
        pass(&mut renderer, &scene, options, &mut passes);
        pass(&mut renderer, &scene, options, &mut passes)
    });
    pairs.iter_mut().for_each(|pair| pair.statistics = Default::default());
    assert_eq!(pairs[0], pairs[1]);
}

#[test]
fn passes_approach_the_converged_picture_in_both_eyes() {
    let mut renderer = renderer();
    let scene = renderer.upload(&room()).wait().unwrap();
    let fine = by_paths(2048);
    let converged = renderer.pair(&scene, &room_camera()).options(&fine).read().wait().unwrap();
    let options = by_paths(8).method(Method::BRACKET);
    let mut passes = Passes::new();
    let mut errors = Vec::new();
    for _ in 0..16 {
        let pair = pass(&mut renderer, &scene, &options, &mut passes);
        errors.push([apart(&pair.left, &converged.left), apart(&pair.right, &converged.right)]);
    }
    println!("{errors:?}");
    // Independent passes would bring a quarter.
    for eye in 0..2 {
        assert!(errors[15][eye] < 0.4 * errors[0][eye], "{errors:?}");
    }
}

#[test]
fn soft_light_has_other_rays_in_each_pass() {
    let mut renderer = renderer();
    let mut scene = Builtin::Hall.scene();
    scene.lights = vec![Light::sphere(Vec3::new(0.0, 5.0, 0.0), 0.5, Vec3::ONE)];
    let scene = renderer.upload(&scene).wait().unwrap();
    let camera = Builtin::Hall.camera(40, 30);
    let options = |rays| Options::new(Method::Naive).linear(true).shadow_rays(rays);
    let mut own = Passes::new();
    let mut pairs = Vec::new();
    for _ in 0..9 {
        pairs.push(renderer.pair(&scene, &camera).options(&options(2)).add_to(&mut own).wait().unwrap());
    }
    let mut many = Passes::new();
    let mut reference = None;
    for _ in 0..32 {
        reference = Some(renderer.pair(&scene, &camera).options(&options(32)).add_to(&mut many).wait().unwrap());
    }
    let reference = reference.unwrap();
    let errors = [0, 8].map(|passes| apart(&pairs[passes].left, &reference.left));
    assert!(errors[1] < 0.5 * errors[0], "{errors:?}");
    assert_eq!(own.paths(), 0);
}

#[test]
fn denoised_passes_are_as_good_as_a_denoised_frame() {
    let mut renderer = renderer();
    let scene = renderer.upload(&room()).wait().unwrap();
    let converged = renderer.pair(&scene, &room_camera()).options(&by_paths(2048)).read().wait().unwrap();
    let frame = renderer.pair(&scene, &room_camera()).options(&by_paths(16).denoise(true)).read().wait().unwrap();
    let mut passes = Passes::new();
    let pairs: Vec<_> = (0..4).map(|_| pass(&mut renderer, &scene, &by_paths(4).denoise(true), &mut passes)).collect();
    let errors = [&pairs[0], &pairs[3], &frame].map(|pair| apart(&pair.left, &converged.left));
    println!("{errors:?}");
    assert!(errors[1] < 0.8 * errors[0] && (errors[1] / errors[2] - 1.0).abs() < 0.1, "{errors:?}");
    // Denoising is timed, and can be stopped.
    let names =
        |pair: &StereoPair| pair.statistics.times.iter().flat_map(|times| &times.passes).map(|pass| pass.0).collect();
    let names: Vec<&str> = names(&frame);
    assert!(names.is_empty() || names.contains(&"smooth_light_once"), "{names:?}");
    let mut stop =
        |now: Progress| if now.pass == "denoise" { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let options = by_paths(2).denoise(true);
    let stopped = renderer.pair(&scene, &room_camera()).options(&options).progress(&mut stop).read().wait();
    assert!(matches!(stopped, Err(Error::Cancelled)), "{stopped:?}");
}

#[test]
fn a_stopped_pass_leaves_the_others_and_rigs_have_passes_too() {
    let mut renderer = renderer();
    let scene = renderer.upload(&room()).wait().unwrap();
    let rig = Rig::row(room_camera(), 3);
    let mut passes = Passes::new();
    let first = renderer.views(&scene, &rig).options(&by_paths(4)).add_to(&mut passes).wait().unwrap();
    let mut stop = |_| ControlFlow::Break(());
    let stopped = renderer.views(&scene, &rig).options(&by_paths(4)).progress(&mut stop).add_to(&mut passes).wait();
    assert!(matches!(stopped, Err(Error::Cancelled)) && passes.paths() == 4, "{stopped:?}");
    let second = renderer.views(&scene, &rig).options(&by_paths(4)).add_to(&mut passes).wait().unwrap();
    let whole = renderer.views(&scene, &rig).options(&by_paths(8)).read().wait().unwrap();
    for ((view, whole), first) in second.views.iter().zip(&whole.views).zip(&first.views) {
        assert!(apart(&view.view, &whole.view) < 1e-6 && apart(&view.view, &first.view) > 0.01);
    }
    // Toed-in eyes are traced one after the other.
    let crossed = room_camera().projection(Projection::ToeIn);
    let mut passes = Passes::new();
    let mut pair = None;
    for _ in 0..2 {
        pair = Some(renderer.pair(&scene, &crossed).options(&by_paths(4)).add_to(&mut passes).wait().unwrap());
    }
    let whole = renderer.pair(&scene, &crossed).options(&by_paths(8)).read().wait().unwrap();
    assert!(apart(&pair.unwrap().right, &whole.right) < 1e-6);
}

#[test]
fn what_differs_between_passes_is_named() {
    let mut renderer = renderer();
    let mut scene = room();
    let mut uploaded = renderer.upload(&scene).wait().unwrap();
    let mut passes = Passes::new();
    let mut refusal = |uploaded: &UploadedScene, camera: &StereoCamera, options: &Options| {
        let done = renderer.pair(uploaded, camera).options(options).add_to(&mut passes).wait();
        done.err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert_eq!(refusal(&uploaded, &room_camera(), &by_paths(2)), "");
    let wider = room_camera().interaxial(0.2);
    assert!(refusal(&uploaded, &wider, &by_paths(2)).contains("cameras"));
    assert!(refusal(&uploaded, &room_camera(), &by_paths(2).seed(1)).contains("options"));
    assert!(refusal(&uploaded, &room_camera(), &by_paths(2).denoise(true)).contains("options"));
    assert!(refusal(&uploaded, &room_camera(), &Options::default()).contains("options"));
    // How light is shown may change.
    assert_eq!(refusal(&uploaded, &room_camera(), &by_paths(4).exposure(1.0).linear(false)), "");
    scene.lights.clear();
    common::renderer().update(&mut uploaded, &scene, Update::Refit).wait().unwrap();
    assert!(refusal(&uploaded, &room_camera(), &by_paths(2)).contains("scene"));
    let adaptive = by_paths(2).adaptive(stereotrace::Adaptive::new(3, 8.0));
    assert!(refusal(&uploaded, &room_camera(), &adaptive).contains("adaptive"));
}
