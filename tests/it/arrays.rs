//! Tests pairs of views of camera arrays against pairs rendered by themselves, and against closed forms.

use crate::common;

use common::renderer;
use stereotrace::{
    Builtin, Method, Occlusion, Options, Rig, Scene, StereoCamera, StereoPair, Views, blocking::Wait, glam::DVec3,
};

fn camera(screen: f32) -> StereoCamera {
    Builtin::Near.camera(96, 64).vertical_fov_degrees(45.0).screen_distance(screen).interaxial(0.1)
}

fn views(scene: &Scene, rig: &Rig, method: Method) -> Views {
    let mut renderer = renderer();
    let uploaded = renderer.upload(scene).wait().unwrap();
    renderer.views(&uploaded, rig).options(&Options::new(method)).read().wait().unwrap()
}

#[test]
fn two_views_of_a_rig_are_the_pair_of_their_eyes() {
    let scene = Builtin::Near.scene();
    let offsets = vec![-2.0, -0.5, 0.5, 3.0];
    for screen in [f32::INFINITY, 4.0] {
        let rig = Rig::at(camera(screen), offsets.clone());
        let views = views(&scene, &rig, Method::BRACKET_RAYS);
        let renderer = renderer();
        let uploaded = renderer.upload(&scene).wait().unwrap();
        for (left, right) in [(0, 3), (1, 2), (2, 3)] {
            let pair = views.pair(left, right).unwrap();
            let camera = pair.pose.camera().unwrap().pose().unwrap();
            // The same eyes, each at its own place.
            for (side, offset) in [(-1.0, offsets[left]), (1.0, offsets[right])] {
                let eye = views.pose.eye_position(2.0 * offset);
                assert!(pair.pose.eye_position(side).distance(eye) < 1e-6);
                for point in [DVec3::new(0.3, 0.2, -1.0), DVec3::new(-0.5, 0.4, 0.3)] {
                    let other = views.pose.project(point, 2.0 * offset);
                    for one in [pair.pose.project(point, side), camera.project(point, side)] {
                        assert!(one.iter().zip(other).all(|(a, b)| (a - b).abs() < 1e-4 * b.abs().max(1.0)), "{one:?}");
                    }
                }
            }
            let truth = renderer.ground_truth(&uploaded, &scene, &pair).wait().unwrap();
            check_correspondence(&pair, &truth.left.disparity, &truth.left.occlusion);
        }
    }
}

/// Checks that points which both eyes see have nearly one depth at the places that the disparities give.
fn check_correspondence(pair: &StereoPair, disparity: &[f32], occlusion: &[Occlusion]) {
    let width = pair.left.width as usize;
    let (mut checked, mut same) = (0, 0);
    for (pixel, (&d, &found)) in disparity.iter().zip(occlusion).enumerate() {
        if found != Occlusion::Visible || !pair.left.depth[pixel].is_finite() {
            continue;
        }
        let column = ((pixel % width) as f32 + 0.5 - d).floor().clamp(0.0, width as f32 - 1.0) as usize;
        let there = pixel / width * width + column;
        checked += 1;
        same += usize::from((pair.right.depth[there] / pair.left.depth[pixel] - 1.0).abs() < 0.03);
    }
    // Half a pixel aside, another surface may be seen at edges.
    assert!(checked > 1000 && same * 100 > checked * 93, "{same} of {checked}");
}

#[test]
fn cameras_one_above_the_other_are_a_pair_that_is_turned() {
    let scene = Builtin::Near.scene();
    let camera = camera(f32::INFINITY);
    let rows = [camera.raised(0.08).unwrap(), camera.raised(-0.08).unwrap()];
    let [upper, lower] = rows.map(|camera| views(&scene, &Rig::row(camera, 3), Method::BRACKET_RAYS));
    let pair = upper.pair_below(2, (&lower, 2)).unwrap();
    assert_eq!((pair.left.width, pair.left.height), (64, 96));
    for (column, row) in [(0, 0), (5, 17), (63, 95)] {
        let at = (row * 64 + column, column * 96 + 95 - row);
        assert_eq!(pair.left.rgba8[at.0], upper.views[2].view.rgba8[at.1]);
        assert_eq!(pair.right.depth[at.0], lower.views[2].view.depth[at.1]);
    }
    // The vertical disparity of a point is f B / Z.
    let fy = camera.pose().unwrap().focal_px().unwrap()[1];
    for (d, z) in pair.disparity().into_iter().zip(&pair.left.depth).filter(|(_, z)| z.is_finite()) {
        assert!((f64::from(d) - fy * 0.16 / f64::from(*z)).abs() < 1e-4, "{d} at {z}");
    }
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let truth = renderer.ground_truth(&uploaded, &scene, &pair).wait().unwrap();
    check_correspondence(&pair, &truth.left.disparity, &truth.left.occlusion);
    // A turned camera renders the same pictures.
    let turned = StereoCamera::look_at(pair.pose.eye, pair.pose.eye + pair.pose.forward.as_dvec3())
        .up(pair.pose.up)
        .size(64, 96)
        .intrinsics(pair.pose.intrinsics().unwrap())
        .interaxial(pair.pose.interaxial)
        .screen_distance(f32::INFINITY);
    let again = renderer.pair(&uploaded, &turned).options(&Options::new(Method::Naive)).read().wait().unwrap();
    for (one, other) in [(&pair.left, &again.left), (&pair.right, &again.right)] {
        let same = one.primitive.iter().zip(&other.primitive).filter(|(a, b)| a == b).count();
        assert!(same * 1000 > one.primitive.len() * 998, "{same} of {}", one.primitive.len());
    }
}

#[test]
fn views_that_are_no_pair_are_refused() {
    let scene = Builtin::Near.scene();
    let views = views(&scene, &Rig::row(camera(4.0), 3), Method::Naive);
    let said = |pair: Result<StereoPair, stereotrace::Error>| pair.unwrap_err().to_string();
    assert!(said(views.pair(0, 3)).contains("there is no view 3; there are 3"));
    assert!(said(views.pair(2, 1)).contains("view 2 is not to the left of view 1"));
    assert!(said(views.pair_below(0, (&views, 0))).contains("the second view must be below the first one"));
}
