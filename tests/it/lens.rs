//! Lenses with distortion: rays, matches and maps against formulas that share no code with the library.

use std::ops::ControlFlow;

use stereotrace::{
    Adaptive, Builtin, Channel, Distortion, Error, FlowClass, Lens, Lighting, MISS, MatchClass, Material, MaterialId,
    Method, Moment, Occlusion, Options, Plane, Pose, Projection, Renderer, Rig, Scene, StereoCamera, StereoPair, View,
    Visibility,
    blocking::Wait,
    camera::Intrinsics,
    glam::{Affine3A, DVec3, Vec3},
    output::Remap,
    testing::cpu::intersect::closest_hit,
};

use crate::common::{cases, gpu, is_exact, render, renderer, warnings};

const SIZE: [u32; 2] = [120, 88];

fn lens(f: f64, distortion: Distortion) -> Lens {
    Lens::new([f, 1.04 * f], [61.3, 42.6]).distortion(distortion)
}

fn opencv(coefficients: &[f64]) -> Distortion {
    Distortion::opencv(coefficients).unwrap()
}

/// Lenses of all models: barrels, a pincushion, a strong tangential part, rational ones and fisheyes.
fn kinds() -> Vec<(&'static str, Lens)> {
    vec![
        ("barrel", lens(75.0, opencv(&[-0.28, 0.07, 1e-3, -5e-4]))),
        ("wide fisheye", lens(52.0, Distortion::fisheye([-0.02, 0.003, -1e-3, 2e-4]))),
        ("rational", lens(60.0, opencv(&[0.4, 0.05, 1e-3, 2e-3, 0.002, 0.8, 0.18, 0.01]))),
        ("strong tangential", lens(70.0, opencv(&[-0.05, 0.02, 0.06, -0.08]))),
        ("pincushion", lens(90.0, opencv(&[0.25, 0.1, 0.0, 0.0, 0.05]))),
        ("fisheye", lens(110.0, Distortion::fisheye([0.05, 0.01, 0.0, 0.0]))),
        ("near a fold", lens(75.0, opencv(&[-0.145, 0.0, 0.0, 0.0]))),
    ]
}

/// Projects a direction by the formulas of the `OpenCV` manual.
fn place(lens: &Lens, x: f64, y: f64) -> [f64; 2] {
    let r = x.hypot(y);
    let (x, y) = match lens.distortion {
        Distortion::RadialTangential { k, p: [p1, p2] } => {
            let top = 1.0 + k[0] * r.powi(2) + k[1] * r.powi(4) + k[2] * r.powi(6);
            let bottom = 1.0 + k[3] * r.powi(2) + k[4] * r.powi(4) + k[5] * r.powi(6);
            let radial = top / bottom;
            (
                x * radial + 2.0 * p1 * x * y + p2 * (r.powi(2) + 2.0 * x.powi(2)),
                y * radial + p1 * (r.powi(2) + 2.0 * y.powi(2)) + 2.0 * p2 * x * y,
            )
        }
        Distortion::Fisheye { k } => {
            let angle = r.atan();
            let powers = [3, 5, 7, 9].map(|power| angle.powi(power));
            let bent = angle + k.iter().zip(powers).map(|(k, power)| k * power).sum::<f64>();
            if r == 0.0 { (x, y) } else { (x * bent / r, y * bent / r) }
        }
    };
    [lens.fx * x + lens.cx, lens.fy * y + lens.cy]
}

fn centre(index: usize) -> [f64; 2] {
    let width = SIZE[0] as usize;
    [index % width, index / width].map(|at| at as f64 + 0.5)
}

fn views(pair: &StereoPair) -> [(f32, &View); 2] {
    [(-1.0, &pair.left), (1.0, &pair.right)]
}

/// The tangents of a pixel's direction, to the right and down.
fn tangents(lens: &Lens, place: [f64; 2]) -> [f64; 2] {
    lens.tangents_of(place).unwrap()
}

/// A pixel's direction of length 1 along the view axis, in the world.
fn direction(pose: &Pose, lens: &Lens, at: [f64; 2]) -> DVec3 {
    let [x, y] = tangents(lens, at);
    pose.right.as_dvec3() * x - pose.up.as_dvec3() * y + pose.forward.as_dvec3()
}

/// A camera at the origin that looks along -z.
fn facing() -> StereoCamera {
    StereoCamera::look_at(Vec3::ZERO, -Vec3::Z).size(SIZE[0], SIZE[1]).interaxial(0.0)
}

/// A scene in which an eye far above the plane `n · p = -1` sees nothing else.
fn plane(normal: Vec3) -> Scene {
    let mut scene = Scene::new();
    let material = scene.add_material(Material::new(Vec3::ONE));
    let point = -normal / normal.length_squared();
    scene.add_plane(Plane::new(point, normal, material)).unwrap();
    scene
}

#[test]
fn inverses_lead_back_to_their_pixels() {
    for (name, lens) in kinds() {
        let mut worst = 0.0_f64;
        for index in 0..(SIZE[0] * SIZE[1]) as usize {
            let (at, [x, y]) = (centre(index), tangents(&lens, centre(index)));
            let [column, row] = place(&lens, x, y);
            worst = worst.max((column - at[0]).hypot(row - at[1]));
            let [column, row] = lens.pixel_of([x, y]).unwrap();
            worst = worst.max((column - at[0]).hypot(row - at[1]));
        }
        println!("{name}: {worst:e} px");
        assert!(worst < 1e-10, "{name}: {worst:e} px");
    }
}

/// The depths of planes give the directions of the kernels' rays: 1/Z is minus the product of direction and normal.
#[test]
fn kernel_rays_are_those_of_double_precision() {
    for (name, lens) in kinds() {
        let camera = facing().lens(lens);
        // Both planes are in front of all rays, however far these are from the axis.
        let farthest = [0.5, 0.0, 88.0].map(|row| tangents(&lens, [0.5, row])[0].abs());
        let tilt = (0.5 / (1.0 + farthest.into_iter().fold(0.0, f64::max))) as f32;
        let depths = [Vec3::new(tilt, 0.0, 1.0), Vec3::new(0.0, tilt, 1.0)].map(|normal| {
            let plane = plane(normal);
            let exact = plane.planes()[0].normal.as_dvec3() / f64::from(tilt);
            (exact, render(&plane, &camera, Method::Naive).left.depth)
        });
        let mut worst = 0.0_f64;
        for index in 0..depths[0].1.len() {
            let [x, up] = [0, 1].map(|axis| {
                let (_, depth) = &depths[axis];
                // 1/Z = n·(0,0,1) - tilt * tangent.
                (1.0 - 1.0 / f64::from(depth[index])) / f64::from(tilt)
            });
            let (found, at) = (place(&lens, x, -up), centre(index));
            worst = worst.max((found[0] - at[0]).hypot(found[1] - at[1]));
        }
        println!("{name}: {worst:e} px");
        assert!(worst < 5e-4, "{name}: {worst:e} px");
    }
}

#[test]
fn hits_are_those_of_a_search_through_all_primitives() {
    for (name, lens) in cases(kinds(), 2) {
        for builtin in cases([Builtin::Near, Builtin::ThreeSpheres], 2) {
            let scene = builtin.scene();
            let camera = builtin.camera(SIZE[0], SIZE[1]).interaxial(0.3).lens(lens);
            let pair = render(&scene, &camera, Method::Naive);
            for (side, view) in views(&pair) {
                let eye = (pair.pose.eye_position(side) - scene.origin()).as_vec3();
                let mut others = 0;
                for index in 0..view.depth.len() {
                    let ray = direction(&pair.pose, &lens, centre(index)).as_vec3();
                    let (t, id) = closest_hit(&scene, eye, ray, 0.0, stereotrace::FAR);
                    let depth = view.depth[index];
                    let is_near = id == MISS || (depth / t - 1.0).abs() < 1e-4;
                    others += usize::from(!(id == view.primitive[index] && is_near));
                }
                println!("{name} {builtin} {side}: {others} pixels differ");
                assert!(others <= 12, "{name} {builtin}: {others} pixels differ");
            }
        }
    }
}

/// Checks the matches of a view, and returns the largest error of a place, and the number of pixels whose class
/// differs.
fn check_matches(
    scene: &Scene,
    pair: &StereoPair,
    (side, view): (f32, &View),
    lenses: [Lens; 2],
    matches: &stereotrace::EyeMatches,
) -> (f64, usize) {
    let [own, other] = if side < 0.0 { lenses } else { [lenses[1], lenses[0]] };
    let [eye, other_eye] = [side, -side].map(|side| pair.pose.eye_position(side));
    let axes = [pair.pose.right, -pair.pose.up, pair.pose.forward].map(|axis| axis.as_dvec3());
    let (mut worst, mut differ) = (0.0_f64, 0);
    for index in 0..view.depth.len() {
        let ray = direction(&pair.pose, &own, centre(index));
        let is_sky = view.primitive[index] == MISS;
        let to = if is_sky { ray } else { eye + ray * f64::from(view.depth[index]) - other_eye };
        let [x, y, z] = axes.map(|axis| axis.dot(to));
        let expected = place(&other, x / z, y / z);
        let found = matches.place[index].map(f64::from);
        let is_inside = (0..2).all(|axis| (0.0..f64::from(SIZE[axis])).contains(&expected[axis]));
        if is_inside {
            worst = worst.max((found[0] - expected[0]).hypot(found[1] - expected[1]));
        }
        let start = (other_eye - scene.origin()).as_vec3();
        let (t, id) = closest_hit(scene, start, to.as_vec3(), 0.0, stereotrace::FAR);
        let is_seen = if is_sky { id == MISS } else { t > 0.9999 };
        let class = match (is_inside, is_seen) {
            (false, _) => MatchClass::OutOfFrame,
            (true, true) => MatchClass::Visible,
            (true, false) => MatchClass::Hidden,
        };
        differ += usize::from(matches.class[index] != class);
    }
    (worst, differ)
}

#[test]
fn matches_are_where_both_eyes_see_a_point() {
    let mut renderer = renderer();
    let kinds = kinds();
    let pairs = [[0, 0], [0, 3], [1, 1], [2, 4], [5, 5], [6, 6]];
    for [left, right] in cases(pairs, 2) {
        let (name, lenses) = (kinds[left].0, [kinds[left].1, kinds[right].1]);
        let builtin = Builtin::Near;
        let scene = builtin.scene();
        let camera = builtin.camera(SIZE[0], SIZE[1]).interaxial(0.4).lenses(lenses[0], lenses[1]);
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let options = Options::new(Method::Naive);
        let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
        let found = renderer.correspondence(&uploaded, &pair).wait().unwrap();
        for (eye, matches) in views(&pair).into_iter().zip([&found.left, &found.right]) {
            let (worst, differ) = check_matches(&scene, &pair, eye, lenses, matches);
            let hidden = matches.class.iter().filter(|class| **class == MatchClass::Hidden).count();
            println!("{name}: {worst:e} px, {differ} classes differ, {hidden} hidden");
            assert!(worst < 2e-5 && differ <= 5, "{name}: {worst:e} px, {differ} classes");
            assert!(hidden > 20, "{name}: {hidden} hidden");
        }
        let truth = renderer.ground_truth(&uploaded, &scene, &pair).wait().unwrap();
        assert!(truth.left.disparity.is_empty() && pair.disparity().is_empty() && pair.occlusion().is_empty());
        let visible = |found: &Occlusion| *found == Occlusion::Visible;
        assert_eq!(truth.right.occlusion.iter().map(visible).collect::<Vec<_>>(), found.right.visible());
    }
}

/// Planar and toed-in pairs have correspondences too.
#[test]
fn matches_of_planar_pairs_are_their_disparities() {
    let mut renderer = renderer();
    let (scene, camera) = (Builtin::Near.scene(), Builtin::Near.camera(SIZE[0], SIZE[1]));
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let pair = renderer.pair(&uploaded, &camera).read().wait().unwrap();
    let found = renderer.correspondence(&uploaded, &pair).wait().unwrap();
    let truth = renderer.ground_truth(&uploaded, &scene, &pair).wait().unwrap();
    for (index, disparity) in truth.left.disparity.iter().enumerate() {
        let ([x, y], [column, row]) = (found.left.place[index], centre(index).map(|at| at as f32));
        assert!((column - x - disparity).abs() < 2e-4 && (y - row).abs() < 2e-4, "{x} {y} {disparity}");
    }
    let classes = found.left.class.iter().zip(&truth.left.occlusion);
    let differ = classes.filter(|(class, occlusion)| **class as u8 != **occlusion as u8).count();
    assert!(differ <= truth.left.disparity.len() / 1000, "{differ} classes differ");
    let camera = camera.projection(Projection::ToeIn);
    let pair = renderer.pair(&uploaded, &camera).read().wait().unwrap();
    let found = renderer.correspondence(&uploaded, &pair).wait().unwrap();
    // A visible point is as far from the other eye as that eye's picture says.
    let seen = (0..pair.left.depth.len()).filter(|&index| found.left.class[index] == MatchClass::Visible);
    let same = |&index: &usize| {
        let [x, y] = found.left.place[index].map(|at| at as usize);
        pair.right.object[y * SIZE[0] as usize + x] == pair.left.object[index]
    };
    let (all, same) = (seen.clone().count(), seen.filter(same).count());
    assert!(all > 5000 && same * 20 > all * 19, "{same} of {all}");
}

/// The picture of the rectified camera is what the maps fetch from the picture of the lens.
#[test]
fn rectified_truth_is_the_remapped_raw_truth() {
    let builtin = Builtin::Hall;
    let scene = builtin.scene();
    for (name, lens) in cases(kinds(), 3) {
        let camera = builtin.camera(SIZE[0], SIZE[1]).interaxial(0.3).lens(lens);
        let rectified = camera.rectified();
        let [raw, ideal] = [camera, rectified].map(|camera| render(&scene, &camera, Method::Naive));
        assert_eq!(
            [-1.0, 1.0].map(|side| raw.pose.eye_position(side)),
            [-1.0, 1.0].map(|s| ideal.pose.eye_position(s))
        );
        let (mut inside, mut same) = (0, 0);
        for ((side, raw), (_, ideal)) in views(&raw).into_iter().zip(views(&ideal)) {
            let maps = Remap::new(&camera, side).unwrap();
            for index in 0..maps.x.len() {
                let [column, row] = centre(index);
                let expected = place(&lens, (column - lens.cx) / lens.fx, (row - lens.cy) / lens.fy);
                let found = [maps.x[index], maps.y[index]].map(|at| f64::from(at) + 0.5);
                if found[0].is_nan() {
                    continue;
                }
                assert!((found[0] - expected[0]).abs().max((found[1] - expected[1]).abs()) < 1e-4, "{name}");
                let at = found.map(|at| at.floor() as i64);
                if (0..2).all(|axis| (0..i64::from(SIZE[axis])).contains(&at[axis])) {
                    inside += 1;
                    let there = at[1] as usize * SIZE[0] as usize + at[0] as usize;
                    let is_near = (raw.depth[there] / ideal.depth[index] - 1.0).abs() < 0.05;
                    same += usize::from(raw.object[there] == ideal.object[index] && is_near);
                }
            }
        }
        println!("{name}: {same} of {inside} pixels agree");
        assert!(inside > 5000 && same * 10 > inside * 9, "{name}: {same} of {inside} pixels agree");
    }
    let error = Remap::new(&builtin.camera(40, 30), 1.0).unwrap_err().to_string();
    assert!(error.contains("set the camera's lens"), "{error}");
}

#[test]
fn a_lens_without_distortion_is_the_plain_camera() {
    for builtin in [Builtin::Hall, Builtin::Spheres] {
        let camera = builtin.camera(SIZE[0], SIZE[1]).interaxial(0.3);
        let Lens { fx, fy, cx, cy, .. } = lens(80.0, Distortion::NONE);
        let plain = camera.intrinsics(Intrinsics::new([fx, fy], [cx, cy]));
        let [found, expected] = [camera.lens(lens(80.0, Distortion::NONE)), plain]
            .map(|camera| render(&builtin.scene(), &camera, Method::Naive));
        let exact = is_exact(&renderer());
        for ((_, found), (_, expected)) in views(&found).into_iter().zip(views(&expected)) {
            let bits = |view: &View| view.depth.iter().map(|z| z.to_bits()).collect::<Vec<_>>();
            if exact {
                assert!(bits(found) == bits(expected) && found.rgba8 == expected.rgba8, "{builtin}");
            }
            let other = found.primitive.iter().zip(&expected.primitive).filter(|(a, b)| a != b).count();
            assert!(other <= found.primitive.len() / 1000, "{builtin}: {other} pixels differ");
        }
    }
}

/// Samples lie where the pixels of a larger picture lie, through the same lens.
#[test]
fn samples_pass_through_the_lens() {
    let mut renderer = renderer();
    let scene = Builtin::Hall.scene();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    for (name, lens) in cases(kinds(), 3) {
        let camera = Builtin::Hall.camera(SIZE[0], SIZE[1]).interaxial(0.3).lens(lens);
        let twice = camera.resized(2 * SIZE[0]).unwrap();
        let options = Options::new(Method::Naive).linear(true);
        let mut made = |camera: &StereoCamera, options: &Options| {
            renderer.pair(&uploaded, camera).options(options).read().wait().unwrap().right
        };
        let large = made(&twice, &options);
        let sampled = made(&camera, &options.clone().samples(4).jitter(false));
        let width = SIZE[0] as usize;
        let worst = (0..sampled.linear.len()).map(|index| {
            let first = 2 * (index / width) * 2 * width + 2 * (index % width);
            let four = [first, first + 1, first + 2 * width, first + 2 * width + 1].map(|at| large.linear[at][0]);
            (four.iter().sum::<f32>() / 4.0 - sampled.linear[index][0]).abs()
        });
        let worst = worst.fold(0.0, f32::max);
        assert!(worst < 1e-3, "{name}: {worst}");
        let jittered = made(&camera, &options.clone().samples(4));
        assert!(jittered.linear != sampled.linear && jittered.primitive == sampled.primitive, "{name}");
        // Adaptive samples differ from these where they stop early, but by little.
        let adaptive = made(&camera, &options.clone().adaptive(Adaptive::new(4, 4.0)));
        let apart = adaptive.linear.iter().zip(&sampled.linear).filter(|(a, b)| (a[0] - b[0]).abs() > 0.25).count();
        assert!(apart < sampled.linear.len() / 50, "{name}: {apart} pixels differ");
        let paths = options.clone().lighting(Lighting::Paths { bounces: 2, samples: 2 }).denoise(true);
        assert_eq!(made(&camera, &paths).linear.len(), sampled.linear.len());
    }
}

#[test]
fn every_method_traces_both_eyes_and_says_so() {
    warnings::collect();
    // A renderer warns once.
    let mut renderer = Renderer::new(gpu());
    let scene = Builtin::Spheres.scene();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let camera = Builtin::Spheres.camera(SIZE[0], SIZE[1]).interaxial(0.3).lens(kinds()[0].1);
    let mut made = |method| renderer.pair(&uploaded, &camera).options(&Options::new(method)).read().wait().unwrap();
    let naive = made(Method::Naive);
    for &method in Method::ALL {
        let pair = made(method);
        assert_eq!(pair.statistics.method, Method::Naive);
        assert!(pair.left == naive.left && pair.right == naive.right, "{method}");
    }
    let said = warnings::of_this_thread().iter().filter(|line| line.contains("eyes with lenses share no rows")).count();
    assert_eq!(said, 1, "{said} warnings");
    for (offset, view) in [(-0.5, &naive.left), (0.5, &naive.right)] {
        let views = renderer.views(&uploaded, &Rig::at(camera, vec![offset])).read().wait().unwrap();
        assert!(views.views[0].view == *view);
    }
}

/// Flow of objects that move and of a camera that moves, against the formulas and rays in plain Rust.
#[test]
fn flow_leads_to_the_places_of_points_at_the_other_time() {
    let mut renderer = renderer();
    let kinds = kinds();
    let scene = Builtin::Near.scene();
    let step = Vec3::new(0.15, 0.1, -0.05);
    let mut moved = scene.clone();
    moved.transform_object(0, &Affine3A::from_translation(step)).unwrap();
    let [uploaded, after] = [&scene, &moved].map(|scene| renderer.upload(scene).wait().unwrap());
    for kind in cases([1, 5, 3, 0], 3) {
        let (name, lens) = kinds[kind];
        let camera = Builtin::Near.camera(SIZE[0], SIZE[1]).interaxial(0.4).lens(lens);
        let eye = camera.eye_position() + DVec3::new(0.2, 0.1, -0.1);
        let then = camera.eye(eye).target(camera.target_position() + DVec3::new(-0.1, 0.0, 0.2));
        let pair = renderer.pair(&uploaded, &camera).read().wait().unwrap();
        let moment = Moment { scene: &moved, uploaded: &after, camera: &then };
        let flow = renderer.flow(&pair, &scene, moment).wait().unwrap();
        let pose = then.pose().unwrap();
        let axes = [pose.right, -pose.up, pose.forward].map(|axis| axis.as_dvec3());
        for ((side, view), found) in views(&pair).into_iter().zip([&flow.left, &flow.right]) {
            let (mut worst, mut differ, mut seen) = (0.0_f64, 0, 0);
            for (index, &id) in view.primitive.iter().enumerate() {
                let ray = direction(&pair.pose, &lens, centre(index));
                let moves = id != MISS && scene.object_of(id) == 0;
                let displacement = if moves { step } else { Vec3::ZERO };
                assert!(Vec3::from_array(found.displacement[index]).distance(displacement) < 1e-5);
                let point = pair.pose.eye_position(side) + ray * f64::from(view.depth[index]) + displacement.as_dvec3();
                let to = if id == MISS { ray } else { point - pose.eye_position(side) };
                let [x, y, z] = axes.map(|axis| axis.dot(to));
                let expected = place(&lens, x / z, y / z);
                let is_inside = z > 0.0 && (0..2).all(|axis| (0.0..f64::from(SIZE[axis])).contains(&expected[axis]));
                if is_inside {
                    let [u, v] = found.flow[index].map(f64::from);
                    let [column, row] = centre(index);
                    worst = worst.max((column + u - expected[0]).hypot(row + v - expected[1]));
                }
                let start = (pose.eye_position(side) - moved.origin()).as_vec3();
                let (t, hit) = closest_hit(&moved, start, to.as_vec3(), 0.0, stereotrace::FAR);
                let is_seen = if id == MISS { hit == MISS } else { t > 0.9999 };
                let class = match (z > 0.0, is_inside, is_seen) {
                    (false, ..) => FlowClass::Behind,
                    (_, false, _) => FlowClass::OutOfFrame,
                    (.., true) => FlowClass::Visible,
                    (.., false) => FlowClass::Hidden,
                };
                differ += usize::from(found.class[index] != class);
                seen += usize::from(class == FlowClass::Visible);
            }
            println!("{name} {side}: {worst:e} px, {differ} classes differ, {seen} are visible");
            assert!(worst < 1e-3 && differ <= 10 && seen > 4000, "{name}: {worst:e} px, {differ}, {seen}");
            assert!(found.disparity_change.iter().all(|change| change.is_nan()));
        }
    }
    let pair = renderer.pair(&uploaded, &Builtin::Near.camera(SIZE[0], SIZE[1])).read().wait().unwrap();
    let camera = Builtin::Near.camera(SIZE[0], SIZE[1]).interaxial(0.4).lens(kinds[0].1);
    let moment = Moment { scene: &scene, uploaded: &uploaded, camera: &camera };
    let message = renderer.flow(&pair, &scene, moment).wait().unwrap_err().to_string();
    assert!(message.contains("projection is of lenses"), "{message}");
}

#[test]
fn features_that_need_rows_are_refused_by_name() {
    let mut renderer = renderer();
    let scene = Builtin::Near.scene();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let [first, second] = [kinds()[0].1, kinds()[4].1];
    let camera = Builtin::Near.camera(SIZE[0], SIZE[1]).interaxial(0.3).lenses(first, second);
    let pair = renderer.pair(&uploaded, &camera).read().wait().unwrap();
    let refused = |error: Error, part: &str| {
        assert!(
            matches!(error, Error::Rig { .. } | Error::Options { .. }) && error.to_string().contains(part),
            "{error}"
        );
    };
    let layering = stereotrace::Layering::new(2);
    refused(renderer.layers(&uploaded, &scene, &pair, &layering).wait().unwrap_err(), "eyes with lenses");
    refused(renderer.pair(&uploaded, &camera).rows(&mut |_| Ok(())).wait().unwrap_err(), "as a pair");
    refused(renderer.views(&uploaded, &Rig::row(camera, 3)).read().wait().unwrap_err(), "as a pair");
    refused(renderer.views(&uploaded, &Rig::mono(camera)).read().wait().unwrap_err(), "its lenses differ");
    let mut encoder = renderer.gpu().device().create_command_encoder(&Default::default());
    refused(renderer.pair(&uploaded, &camera).encode(&mut encoder).wait().unwrap_err(), "as a pair");
    let drawn = Options::new(Method::Naive).visibility(Visibility::TBuffer);
    refused(renderer.pair(&uploaded, &camera).options(&drawn).read().wait().unwrap_err(), "straight edges");
    let mut stop = |_| ControlFlow::Break(());
    let stopped = renderer.pair(&uploaded, &camera).progress(&mut stop).read().wait().unwrap_err();
    assert!(matches!(stopped, Error::Cancelled), "{stopped}");
    // Histories are left out.
    let remembered = Options::new(Method::Naive).history(Some(64));
    let again = renderer.pair(&uploaded, &camera).options(&remembered).read().wait().unwrap();
    assert!(again.left.depth == pair.left.depth);
    refused(pair.left_channels(None).get(Channel::Disparity).unwrap_err(), "do not stay in their rows");
}

#[test]
fn bad_lenses_are_refused_by_name() {
    let camera = Builtin::Hall.camera(640, 480).interaxial(0.1);
    let centred = |distortion| Lens::new([300.0; 2], [320.0, 240.0]).distortion(distortion);
    let refused = |lens: Lens, parts: &[&str]| {
        let error = camera.lens(lens).pose().unwrap_err();
        let text = error.to_string();
        assert!(matches!(error, Error::Camera { field: "lens", .. }), "{text}");
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    };
    // Without tangential part, r - 0.3 r³ is largest at r = 1.054, where it is 0.7027: 210.8 px.
    refused(centred(opencv(&[-0.3, 0.0, 0.0, 0.0])), &["folds at pixel", "210.8 px from the principal point"]);
    refused(centred(Distortion::fisheye([-0.3, 0.0, 0.0, 0.0])), &["folds at pixel", "210.8 px from"]);
    refused(centred(opencv(&[0.0, 0.0, 0.4, 0.4])), &["folds at pixel"]);
    refused(centred(opencv(&[0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 0.0, 0.0])), &["folds at pixel"]);
    refused(centred(opencv(&[f64::NAN, 0.0, 0.0, 0.0])), &["NaN", "finite"]);
    refused(centred(opencv(&[f64::INFINITY, 0.0, 0.0, 0.0])), &["inf", "finite"]);
    refused(centred(Distortion::fisheye([0.0, f64::NAN, 0.0, 0.0])), &["NaN", "finite"]);
    refused(Lens::new([0.0, 300.0], [320.0, 240.0]), &["fx 0", "above 0"]);
    refused(Lens::new([300.0, f64::NAN], [320.0, 240.0]), &["fy NaN"]);
    refused(Lens::new([300.0; 2], [f64::INFINITY, 240.0]), &["cx inf"]);
    refused(Lens::new([200.0; 2], [320.0, 240.0]).distortion(Distortion::fisheye([0.0; 4])), &["114.6 degrees", "89"]);
    refused(Lens::new([1e9; 2], [320.0, 240.0]), &["radians"]);
    let pixels = camera.interaxial_pixels(3.0).lens(centred(Distortion::NONE)).pose().unwrap_err().to_string();
    assert!(pixels.contains("interaxial") && pixels.contains("world units"), "{pixels}");
    for count in [1, 3, 6, 12, 14] {
        let error = Distortion::opencv(&vec![0.0; count]).unwrap_err().to_string();
        assert!(error.contains(&format!("{count} coefficients")), "{error}");
    }
    // Strong lenses that don't fold the picture are rendered.
    for distortion in [
        opencv(&[-0.2, 0.04, 0.03, 0.03]),
        opencv(&[0.0, 0.0, 0.03, 0.03]),
        opencv(&[8.0, 2.0, 1e-3, 1e-3, 0.1, 8.5, 4.0, 0.6]),
        opencv(&[3.0, 5.0, 0.0, 0.0, 7.0]),
        Distortion::fisheye([0.3, -0.05, 0.01, 0.0]),
    ] {
        let found = camera.lens(centred(distortion)).pose();
        assert!(found.is_ok(), "{}", found.unwrap_err());
    }
}

#[test]
fn cameras_with_lenses_are_written_and_read() {
    let [first, second] = [kinds()[2].1, kinds()[1].1];
    let camera = Builtin::Near.camera(SIZE[0], SIZE[1]).interaxial(0.3).lenses(first, second);
    let text = camera.to_json().unwrap();
    assert_eq!(StereoCamera::from_json_str(&text).unwrap(), camera);
    assert_eq!(camera.pose().unwrap().lens(1.0), Some(second));
    assert_eq!(camera.pose().unwrap().of_eye(1.0).lens(-1.0), Some(second));
    assert!(camera.pose().unwrap().intrinsics().is_none());
    let read = |text: &str| Lens::pair_from_json(text).map_err(|error| error.to_string());
    let both = format!(r#"{{ "left": {0}, "right": {0} }}"#, r#"{ "fx": 3, "fy": 4, "cx": 1, "cy": 2 }"#);
    assert_eq!(read(&both).unwrap(), [Lens::new([3.0, 4.0], [1.0, 2.0]); 2]);
    for (text, part) in [
        ("{", "invalid JSON"),
        ("[]", "must be an object"),
        (r#"{ "fx": 3 }"#, "cx of a lens is missing"),
        (r#"{ "fx": "a", "cx": 1, "cy": 1 }"#, "must be a number"),
        (r#"{ "fx": 3, "cx": 1, "cy": 1, "k1": 0 }"#, "no 'k1'"),
        (r#"{ "fx": 3, "cx": 1, "cy": 1, "fisheye": [0] }"#, "4 coefficients"),
        (r#"{ "fx": 3, "cx": 1, "cy": 1, "radial_tangential": [0, 0, 0] }"#, "4, 5 or 8 coefficients"),
        (r#"{ "fx": 3, "cx": 1, "cy": 1, "fisheye": [0, 0, 0, 0], "radial_tangential": [] }"#, "both are given"),
        (r#"{ "left": {} }"#, "given together"),
    ] {
        let error = read(text).unwrap_err();
        assert!(error.contains(part), "{error}");
    }
}

/// Files hold all channels but disparities.
#[test]
fn files_of_pairs_with_lenses() {
    use stereotrace::output::{Batch, ExrColor};
    let folder = crate::common::folder::Folder::new("lens_files");
    let mut renderer = renderer();
    let scene = Builtin::Near.scene();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let camera = Builtin::Near.camera(SIZE[0], SIZE[1]).interaxial(0.3).lens(kinds()[0].1);
    let options = Options::default().linear(true);
    let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
    let truth = renderer.ground_truth(&uploaded, &scene, &pair).wait().unwrap();
    let mut batch = Batch::new();
    batch.add_exr(folder.file("pair.exr"), &pair, Some(&truth), ExrColor::Half).unwrap();
    batch.add_camera_json(folder.file("camera.json"), &pair.pose).unwrap();
    let calibration = batch.add_calib(folder.file("calib.txt"), &truth).unwrap_err().to_string();
    assert!(calibration.contains("rectified camera"), "{calibration}");
    batch.commit().unwrap();
    let written = std::fs::read_to_string(folder.file("camera.json")).unwrap();
    assert_eq!(Pose::from_json(folder.file("camera.json")).unwrap().lens(-1.0), pair.pose.lens(-1.0));
    let folded = Pose::from_json(folder.write("folded.json", written.replace("-0.28", "-2.8"))).unwrap_err();
    assert!(folded.to_string().contains("folds at pixel"), "{folded}");
    let bytes = std::fs::read(folder.file("pair.exr")).unwrap();
    let has = |name: &str| bytes.windows(name.len()).any(|window| window == name.as_bytes());
    assert!(has("N.X") && !has("disparity"), "{:?}", String::from_utf8_lossy(&bytes[..600]));
}

/// Materials are found by their ids, so that no default is used by accident.
#[test]
fn planes_are_seen_through_lenses() {
    let scene = plane(Vec3::new(0.0, 0.01, 1.0));
    let pair = render(&scene, &facing().lens(kinds()[1].1), Method::Auto);
    assert!(pair.left.primitive.iter().all(|id| *id != MISS));
    assert_eq!(scene.planes()[0].material, MaterialId(1));
}
