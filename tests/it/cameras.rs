//! Tests cameras other than two eyes with a centred screen: parallel, calibrated and toed-in cameras, and single eyes.

use crate::common;

use common::{cases, is_exact, random::Random, render, renderer};
use stereotrace::{
    Adaptive, AmbientOcclusion, Builtin, Error, FAR, Method, Occlusion, Options, PixelSource, Projection, Ray, Rig,
    ShadowBuffer, StereoCamera, StereoPair, View, Visibility,
    blocking::Wait,
    camera::Intrinsics,
    glam::{DMat3, DVec3, Vec3},
    testing::cpu::{Eye, Frame, adelson_hodges::sweep, reproject::reproject},
};

/// Returns a built-in scene's camera as parallel cameras and as three calibrated cameras. The calibrated cameras are
/// one off-centre with pixels that are not square, one with a screen, and one with a principal point outside the
/// picture.
fn kinds(camera: StereoCamera) -> [(&'static str, StereoCamera); 4] {
    let pose = camera.pose().unwrap();
    let [w, h] = pose.size.map(f64::from);
    let [f, _] = pose.focal_px().unwrap();
    let fov = 2.0 * (0.5 * h / f).atan().to_degrees();
    let apart = camera.interaxial(pose.interaxial).vertical_fov_degrees(fov as f32);
    let off_centre = Intrinsics::new([f, 0.8 * f], [0.42 * w, 0.61 * h]);
    let before = Intrinsics::new([0.9 * f, 1.1 * f], [0.55 * w, 0.5 * h]).right_cx(0.58 * w);
    let outside = Intrinsics::new([f; 2], [-0.5 * w, 1.3 * h]);
    [
        ("parallel", apart.screen_distance(f32::INFINITY)),
        ("off centre", apart.intrinsics(off_centre)),
        ("before a screen", apart.intrinsics(before)),
        ("outside", apart.intrinsics(outside).screen_distance(2.0 * pose.screen_distance)),
    ]
}

/// Returns the values by which pixels are compared.
fn pixels(view: &View) -> Vec<(u32, u32, [u32; 4], [u8; 4])> {
    let linear = |index: usize| view.linear.get(index).map_or([0; 4], |color| color.map(f32::to_bits));
    let pixel = |index: usize| {
        let depth = view.depth.get(index).map_or(0, |depth| depth.to_bits());
        (depth, view.primitive.get(index).copied().unwrap_or(0), linear(index), view.rgba8[index])
    };
    (0..view.rgba8.len()).map(pixel).collect()
}

fn assert_same(found: &View, expected: &View, exact: bool, what: &str) {
    let other = pixels(found).iter().zip(pixels(expected)).filter(|(a, b)| **a != *b).count();
    let allowed = if exact { 0 } else { expected.rgba8.len() / 100 };
    assert!(other <= allowed, "{what}: {other} of {} pixels differ", expected.rgba8.len());
}

/// The projection K [R | t] X in f64, computed from the parameters of the camera.
struct Pinhole {
    k: DMat3,
    r: DMat3,
    t: DVec3,
}

impl Pinhole {
    /// Makes the projection of an eye at a distance `aside` to the right of `eye`.
    fn new(eye: DVec3, target: DVec3, up: DVec3, aside: f64, [fx, fy]: [f64; 2], [cx, cy]: [f64; 2]) -> Self {
        let z = (target - eye).normalize();
        let x = z.cross(up).normalize();
        let y = z.cross(x);
        let r = DMat3::from_cols(x, y, z).transpose();
        let k = DMat3::from_cols(DVec3::X * fx, DVec3::Y * fy, DVec3::new(cx, cy, 1.0));
        Self { k, r, t: -(r * (eye + x * aside)) }
    }

    fn of(&self, point: DVec3) -> [f64; 3] {
        let at = self.k * (self.r * point + self.t);
        [at.x / at.z, at.y / at.z, at.z]
    }
}

#[test]
fn points_are_projected_by_k_r_t_for_any_intrinsics() {
    let mut random = Random::new(31);
    let mut worst = 0.0_f64;
    for _ in 0..20_000 {
        let point = |random: &mut Random, size: f32| random.point(size);
        let (eye, target) = (point(&mut random, 3.0), point(&mut random, 3.0));
        let up = (point(&mut random, 1.0) + Vec3::splat(0.01)).normalize();
        let [w, h] = [1 + random.below(4000), 1 + random.below(3000)];
        let focal = [0, 1].map(|_| f64::from(10_f32.powf(random.between(0.5, 3.6))));
        // f32 represents these numbers exactly, as for typical calibrations.
        let centre = [w, h].map(|side| f64::from(random.between(-1.0, 2.0) * side as f32));
        let doffs =
            if random.below(2) == 0 { 0.0 } else { f64::from((random.between(0.0, 100.0) * 64.0).round() / 64.0) };
        let interaxial = random.between(0.01, 0.5);
        let cx1 = f64::from((centre[0] + doffs) as f32);
        let intrinsics = Intrinsics::new(focal, centre).right_cx(cx1);
        let camera = StereoCamera::look_at(eye, target).up(up).size(w as u32, h as u32);
        let camera = camera.intrinsics(intrinsics).interaxial(interaxial);
        let Ok(pose) = camera.pose() else { continue };
        for side in [-1.0_f32, 1.0] {
            let aside = 0.5 * f64::from(side * interaxial);
            let cx = if side > 0.0 { cx1 } else { centre[0] };
            let [e, t, u] = [eye, target, up].map(|v| v.as_dvec3());
            let exact = Pinhole::new(e, t, u, aside, focal, [cx, centre[1]]);
            let x = eye + (target - eye).normalize() * random.between(0.5, 20.0) + random.point(1.0);
            let expected = exact.of(x.as_dvec3());
            if expected[2] < 0.3 {
                continue;
            }
            let found = pose.project(x, side).map(f64::from);
            // The pose's axes are rounded to f32, which turns them by up to 1e-7. So the error is relative to the focal
            // length and to the distances from the centre and from the corner.
            for (axis, found) in found.into_iter().enumerate() {
                let reach = focal[axis.min(1)] + (expected[axis] - centre[axis.min(1)]).abs() + expected[axis].abs();
                worst = worst.max((found - expected[axis]).abs() / reach);
            }
        }
        let back = pose.intrinsics().unwrap();
        let numbers = |i: Intrinsics| [i.fx, i.fy, i.cx0, i.cx1, i.cy];
        for (back, given) in numbers(back).into_iter().zip(numbers(intrinsics)) {
            assert!((back - given).abs() < 1e-11 * (f64::from(w as u32) + given.abs()), "{back} {given}");
            assert_eq!(back as f32, given as f32);
        }
    }
    println!("off by {worst:.1e} of the distances at most");
    assert!(worst > 0.0 && worst < 1e-6, "{worst:e}");
}

#[test]
fn rays_go_where_points_are_projected_from() {
    for (what, camera) in kinds(Builtin::Hall.camera(160, 90)) {
        let pose = camera.pose().unwrap();
        let frame = Frame::new(&pose);
        for (eye, side) in [(Eye::Left, -1.0), (Eye::Right, 1.0)] {
            for (column, row) in [(0, 0), (159, 0), (70, 33), (159, 89)] {
                for z in [0.7_f32, 5.0, 200.0] {
                    let point = frame.eye(eye) + frame.direction(eye, column, row) * z;
                    let [x, y, depth] = pose.project(point, side);
                    let off = (x - column as f32 - 0.5).abs().max((y - row as f32 - 0.5).abs());
                    assert!(off < 1e-3 && (depth / z - 1.0).abs() < 1e-5, "{what}: {off} px, {depth} for {z}");
                }
            }
        }
    }
}

#[test]
fn bracket_rays_are_naive_by_every_camera_and_every_kind_of_frame() {
    let mut renderer = renderer();
    let exact = is_exact(&renderer);
    for builtin in cases([Builtin::Near, Builtin::ThreeSpheresTextured], 2) {
        let uploaded = renderer.upload(&builtin.scene()).wait().unwrap();
        for (kind, camera) in kinds(builtin.camera(75, 50)) {
            let plain = Options::default().linear(true);
            let frames = [
                ("one sample", plain.clone()),
                ("samples", plain.clone().samples(4)),
                ("adaptive samples", plain.clone().adaptive(Adaptive::new(3, 8.0))),
                ("soft light", plain.clone().ambient_occlusion(AmbientOcclusion::new(4, 1.0)).shadow_rays(4)),
                ("a T-buffer", plain.clone().visibility(Visibility::TBuffer)),
                ("shadow-buffers", plain.clone().shadow_buffer(ShadowBuffer::new(128))),
            ];
            for (frame, options) in frames {
                let what = format!("{builtin}, {kind}, {frame}");
                let mut render = |method| {
                    renderer.pair(&uploaded, &camera).options(&options.clone().method(method)).read().wait().unwrap()
                };
                let naive = render(Method::Naive);
                let bracket = render(Method::BRACKET_RAYS);
                assert_same(&bracket.left, &naive.left, exact, &what);
                assert_same(&bracket.right, &naive.right, exact, &what);
                assert_ne!(naive.left.rgba8, naive.right.rgba8, "{what}");
            }
        }
    }
}

#[test]
fn every_method_carries_over_what_its_twin_does() {
    for builtin in [Builtin::Spheres, Builtin::Near] {
        let scene = builtin.scene();
        for (kind, camera) in kinds(builtin.camera(90, 60)) {
            let what = format!("{builtin}, {kind}");
            let naive = render(&scene, &camera, Method::Naive);
            let exact = is_exact(&renderer());
            let of = |method: &str| render(&scene, &camera, method.parse().unwrap());
            let [atomic, buffer, es_isler, host] = ["atomic", "buffer", "es-isler", "adelson-hodges"].map(of);
            for pair in [&atomic, &buffer, &es_isler, &host] {
                assert!(pair.left == naive.left, "{what}");
            }
            assert_eq!((&buffer.source, &buffer.right), (&atomic.source, &atomic.right), "{what}");
            assert_eq!((&host.source, &host.right), (&es_isler.source, &es_isler.right), "{what}");
            assert_eq!(buffer.statistics.lost_candidates, 0, "{what}");
            let frame = Frame::new(&naive.pose);
            let depths: Vec<f32> = naive.left.depth.iter().map(|depth| depth.min(FAR)).collect();
            let count = |sources: &[u32], pair: &StereoPair| {
                let is_missed = |source: &PixelSource| *source == PixelSource::Missed;
                sources.iter().zip(&pair.source).filter(|(key, source)| (**key == 0) != is_missed(source)).count()
            };
            let allowed = if exact { 0 } else { depths.len() / 100 };
            assert!(count(&reproject(&frame, &depths), &atomic) <= allowed, "{what}");
            assert!(count(&sweep(&frame, &depths), &es_isler) <= allowed, "{what}");
            for method in ["atomic", "atomic-edges", "es-isler", "bracket", "verified"] {
                let pair = of(method);
                let [reused, usual] = [&pair, &render(&scene, &builtin.camera(90, 60), method.parse().unwrap())]
                    .map(|pair| 1.0 - pair.statistics.retraced_share());
                // Samples that leave the picture on one side are not reused. With a screen, fewer leave it.
                assert!(reused > usual - 0.25, "{what}, {method}: {reused} of {usual}");
                let colors = pair.right.rgba8.iter().zip(&naive.right.rgba8);
                let alike = colors.filter(|(a, b)| a.iter().zip(*b).all(|(a, b)| a.abs_diff(*b) < 16)).count();
                println!(
                    "{what}, {method}: {reused:.2} reused of {usual:.2}, {:.2} alike",
                    alike as f32 / depths.len() as f32
                );
                if method == "bracket" || method == "verified" {
                    assert!(pair.right.depth == naive.right.depth || !exact, "{what}, {method}");
                }
            }
        }
    }
}

#[test]
fn views_of_a_rig_and_those_that_stay_on_the_device_are_those_of_naive() {
    let mut renderer = renderer();
    let exact = is_exact(&renderer);
    let builtin = Builtin::Near;
    let uploaded = renderer.upload(&builtin.scene()).wait().unwrap();
    for (kind, camera) in kinds(builtin.camera(72, 48)) {
        let rig = Rig::at(camera, vec![0.5, -0.7, 0.1, 1.3, -0.5]).traced(vec![1, 3]);
        let mut render = |method| {
            let options = Options::new(method).linear(true);
            renderer.views(&uploaded, &rig).options(&options).read().wait().unwrap().views
        };
        let (naive, rays, bracket) = (render(Method::Naive), render(Method::BRACKET_RAYS), render(Method::BRACKET));
        for (index, naive) in naive.iter().enumerate() {
            assert_same(&rays[index].view, &naive.view, exact, &format!("{kind}, view {index}"));
            assert!(!exact || bracket[index].view.depth == naive.view.depth, "{kind}, view {index}");
        }
        // A pair consists of two of the views, and a single eye is one of them.
        let pair =
            renderer.pair(&uploaded, &camera).options(&Options::new(Method::Naive).linear(true)).read().wait().unwrap();
        assert_same(&naive[0].view, &pair.right, exact, kind);
        assert_same(&naive[4].view, &pair.left, exact, kind);
        for offset in [-0.7, 0.5] {
            let one = Rig::at(camera, vec![offset]);
            let alone =
                renderer.views(&uploaded, &one).options(&Options::default().linear(true)).read().wait().unwrap().views;
            let same = naive.iter().find(|view| view.offset == offset).unwrap();
            assert_eq!((alone.len(), alone[0].method), (1, Method::Naive));
            assert_same(&alone[0].view, &same.view, exact, kind);
        }
        let mut encoder = renderer.gpu().device().create_command_encoder(&Default::default());
        let encoded = renderer
            .views(&uploaded, &rig)
            .options(&Options::new(Method::BRACKET_RAYS))
            .encode(&mut encoder)
            .wait()
            .unwrap();
        assert_eq!(encoded.views.len(), 5);
    }
    let mono = renderer.views(&uploaded, &Rig::mono(builtin.camera(72, 48))).read().wait().unwrap();
    assert_eq!((mono.views.len(), mono.views[0].offset, mono.views[0].made_from), (1, 0.0, 0));
}

/// Returns the point at depth `z` on the ray through a position of an eye's picture, from the intrinsics alone.
fn seen_at(pose: &stereotrace::Pose, side: f64, [x, y]: [f64; 2], z: f64) -> DVec3 {
    let i = pose.intrinsics().unwrap();
    let cx = if side < 0.0 { i.cx0 } else { i.cx1 };
    let [right, up, forward] = [pose.right, pose.up, pose.forward].map(|axis| axis.as_dvec3());
    let eye = pose.eye + right * (0.5 * side * f64::from(pose.interaxial));
    eye + forward * z + right * ((x - cx) / i.fx * z) - up * ((y - i.cy) / i.fy * z)
}

#[test]
fn disparity_is_f_e_over_z_and_occlusions_are_what_the_other_eye_s_rays_meet() {
    for builtin in [Builtin::Spheres, Builtin::Fence] {
        let scene = builtin.scene();
        for (kind, camera) in kinds(builtin.camera(90, 60)) {
            let pair = render(&scene, &camera, Method::BRACKET_RAYS);
            let (pose, i) = (&pair.pose, pair.pose.intrinsics().unwrap());
            let renderer = renderer();
            let uploaded = renderer.upload(&scene).wait().unwrap();
            let occlusions = renderer.occlusions(&uploaded, &pair).wait().unwrap();
            let (mut worst, mut wrong, mut guessed, mut hidden) = (0.0_f64, 0, 0, 0);
            let by_depths = pair.occlusion();
            let place = |index: usize| [index % 90, index / 90].map(|at| at as f64 + 0.5);
            let back = |(index, &z): (usize, &f32)| {
                let eye = seen_at(pose, 1.0, place(index), 0.0);
                let to = if z.is_finite() { seen_at(pose, -1.0, place(index), z.into()) - eye } else { DVec3::X };
                Ray::new(eye.as_vec3(), to.as_vec3()).t_max(1.0 - 1e-3)
            };
            let back: Vec<Ray> = pair.left.depth.iter().enumerate().map(back).collect();
            let blocked = renderer.any_hits(&uploaded, &back).wait().unwrap().hits;
            for (index, (&d, &z)) in pair.disparity().iter().zip(&pair.left.depth).enumerate() {
                let exact = i.fx * f64::from(pose.interaxial) / f64::from(z) - i.doffs();
                worst = worst.max((f64::from(d) - exact).abs());
                let x = place(index)[0] - exact;
                let truth = match z.is_finite() && blocked[index] {
                    _ if !(0.0..90.0).contains(&x) => Occlusion::OutOfFrame,
                    true => Occlusion::Hidden,
                    false => Occlusion::Visible,
                };
                hidden += usize::from(truth == Occlusion::Hidden);
                wrong += usize::from(z.is_finite() && truth != occlusions.left[index]);
                guessed += usize::from(z.is_finite() && truth != by_depths[index]);
            }
            println!(
                "{builtin}, {kind}: disparity off by {worst:.1e} px, {hidden} hidden, {wrong} and {guessed} otherwise"
            );
            assert!(worst < 2e-5 && wrong < 20 && guessed < 300, "{builtin}, {kind}");
        }
    }
}

fn toed_in(builtin: Builtin) -> StereoCamera {
    builtin.camera(90, 60).projection(Projection::ToeIn)
}

#[test]
fn eyes_that_are_toed_in_meet_on_the_screen_and_see_keystones() {
    let camera = StereoCamera::look_at(5.0 * Vec3::Z, Vec3::ZERO).size(400, 300).vertical_fov_degrees(50.0);
    let (e, d) = (0.4_f64, 5.0_f64);
    let pose = camera.screen_distance(5.0).interaxial(0.4).projection(Projection::ToeIn).pose().unwrap();
    let f = 150.0 / 25.0_f64.to_radians().tan();
    let (sin, cos) = (0.5 * e / d).atan().sin_cos();
    for point in [[0.0, 0.0, 5.0], [1.1, 0.7, 5.0], [-2.0, -1.5, 3.0], [0.3, 4.0, 40.0_f64]] {
        let [x, y, z] = point;
        let world = Vec3::new(x as f32, y as f32, (5.0 - z) as f32);
        for side in [-1.0, 1.0] {
            // The left eye turns to the right.
            let from = x - 0.5 * side * e;
            let depth = z * cos - side * from * sin;
            let across = from * cos + side * z * sin;
            let expected = [200.0 + f * across / depth, 150.0 - f * y / depth, depth];
            let found = pose.project(world, side as f32).map(f64::from);
            let of_eye = pose.of_eye(side as f32).project(world, 0.0).map(f64::from);
            for found in [found, of_eye] {
                assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 2e-4), "{found:?} {expected:?}");
            }
        }
    }
    for z in [2.0_f32, 5.0, 80.0] {
        let [left, right] = [-1.0, 1.0].map(|side| pose.project(Vec3::new(0.0, 0.0, 5.0 - z), side)[0]);
        assert!((pose.parallax_px(z) - (right - left)).abs() < 1e-3, "{z}");
        assert!((pose.disparity_px(z) - f64::from(left - right)).abs() < 1e-3, "{z}");
    }
}

#[test]
fn a_pair_that_is_toed_in_is_two_eyes_alone_and_says_so() {
    let (scene, camera) = (Builtin::Spheres.scene(), toed_in(Builtin::Spheres));
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let mut progress = Vec::new();
    let mut watch = |step: stereotrace::Progress| {
        progress.push(step.done);
        std::ops::ControlFlow::Continue(())
    };
    let options = Options::new(Method::BRACKET).linear(true).count(true);
    let pair = renderer.pair(&uploaded, &camera).options(&options).progress(&mut watch).read().wait().unwrap();
    assert!(progress.is_sorted() && progress.last() == Some(&1.0), "{progress:?}");
    assert_eq!((pair.statistics.method, pair.pose.projection), (Method::Naive, Projection::ToeIn));
    assert!(pair.source.iter().all(|source| *source == PixelSource::Traced));
    assert_eq!((pair.source.len(), pair.statistics.retraced_share()), (90 * 60, 1.0));
    assert!(pair.statistics.left.cost() > 0 && pair.statistics.right.cost() > 0);
    let traced = renderer.pair(&uploaded, &camera).options(&options).trace().wait().unwrap();
    assert_eq!((traced.left, traced.right), (pair.statistics.left, pair.statistics.right));
    for (offset, view) in [(-0.5, &pair.left), (0.5, &pair.right)] {
        let rig = Rig::at(camera, vec![offset]);
        let alone = renderer.views(&uploaded, &rig).options(&Options::default().linear(true)).read().wait().unwrap();
        assert_eq!(pixels(&alone.views[0].view), pixels(view));
        // The point that each pixel shows is projected back to the pixel.
        let pose = pair.pose.of_eye(2.0 * offset);
        for index in (0..view.depth.len()).filter(|index| view.depth[*index].is_finite()) {
            let place = [index % 90, index / 90].map(|at| at as f64 + 0.5);
            let point = seen_at(&pose, -1.0, place, view.depth[index].into()).as_vec3();
            let [x, y, _] = pair.pose.project(point, 2.0 * offset);
            assert!((f64::from(x) - place[0]).abs() < 1e-3 && (f64::from(y) - place[1]).abs() < 1e-3);
        }
    }
    // Image rows are not epipolar lines here, so functions that need epipolar lines return an error or nothing.
    assert!(pair.disparity().is_empty() && pair.right_disparity().is_empty() && pair.occlusion().is_empty());
    let refused =
        |error: Error| assert!(matches!(&error, Error::Rig { reason, .. } if reason.contains("toed in")), "{error}");
    refused(renderer.occlusions(&uploaded, &pair).wait().unwrap_err());
    let default = Options::default();
    refused(renderer.views(&uploaded, &Rig::pair(camera)).options(&default).read().wait().unwrap_err());
    refused(renderer.views(&uploaded, &Rig::row(camera, 5)).options(&default).read().wait().unwrap_err());
    refused(renderer.views(&uploaded, &Rig::pair(camera)).options(&default).rows(&mut |_| Ok(())).wait().unwrap_err());
    let mut encoder = renderer.gpu().device().create_command_encoder(&Default::default());
    refused(renderer.views(&uploaded, &Rig::pair(camera)).options(&default).encode(&mut encoder).wait().unwrap_err());
    // Frames with several samples per pixel can be rendered too.
    for options in [default.clone().samples(4), default.adaptive(Adaptive::new(2, 8.0))] {
        let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
        assert_eq!((pair.right.rgba8.len(), pair.statistics.method), (90 * 60, Method::Naive));
    }
}

#[test]
fn vertical_parallax_is_what_points_have_and_none_without_toe_in() {
    for builtin in [Builtin::Spheres, Builtin::Near, Builtin::Hall] {
        let camera = toed_in(builtin);
        let pair = render(&builtin.scene(), &camera, Method::Naive);
        let mut most = 0.0_f32;
        for (side, view) in [(-1.0, &pair.left), (1.0, &pair.right)] {
            let eye = pair.pose.of_eye(side);
            for (index, &z) in view.depth.iter().enumerate().filter(|(_, z)| z.is_finite()) {
                let place = [index % 90, index / 90].map(|at| at as f64 + 0.5);
                let [x, y, _] = pair.pose.project(seen_at(&eye, -1.0, place, z.into()).as_vec3(), -side);
                if (0.0..90.0).contains(&x) {
                    most = most.max((f64::from(y) - place[1]).abs() as f32);
                }
            }
        }
        let ranges = [&pair.left, &pair.right].map(|view| view.depth_range());
        let (near, far) = (ranges[0].0.min(ranges[1].0), ranges[0].1.max(ranges[1].1));
        let bound = pair.pose.comfort(near, far, 1.0).vertical_parallax_px;
        println!("{builtin}: {most:.2} px found, {bound:.2} px at most");
        assert!(most > 0.05 && most <= bound && bound < 1.5 * most, "{builtin}: {most} {bound}");
        let off_axis = camera.projection(Projection::OffAxis).pose().unwrap();
        assert_eq!(off_axis.comfort(near, far, 1.0).vertical_parallax_px, 0.0);
        // Parallel axes never meet.
        let parallel = kinds(builtin.camera(90, 60))[0].1.projection(Projection::ToeIn);
        assert!(parallel.pose().unwrap().comfort(near, far, 1.0).vertical_parallax_px < 1e-4);
    }
}
