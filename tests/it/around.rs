//! Equirectangular pairs: the second eye is exact whatever the rows, the seam and the poles show.

use stereotrace::{
    Adaptive, AmbientOcclusion, Builtin, Equirectangular, Error, Lighting, Material, Mesh, Method, Occlusion, Options,
    Plane, PoleMerge, Projection, Rig, Rows, Scene, ShadowBuffer, Span, StereoCamera, StereoPair, UploadedScene,
    Visibility,
    blocking::Wait,
    glam::{DVec3, Vec3},
    metrics::compare,
    testing::suite::Trial,
};

use crate::common::{Lent, cases, is_exact, renderer};

const FULL: Equirectangular = Equirectangular { span: Span::Full, merge: None };

fn around(camera: StereoCamera, projection: Equirectangular) -> StereoCamera {
    camera.projection(Projection::Equirectangular(projection))
}

fn merged(span: Span) -> Equirectangular {
    Equirectangular { span, merge: Some(PoleMerge::default()) }
}

fn rendered(renderer: &mut Lent, scene: &UploadedScene, camera: &StereoCamera, method: Method) -> StereoPair {
    renderer.pair(scene, camera).options(&Options::new(method).count(true)).read().wait().unwrap()
}

/// Compares `bracket-rays` and `bracket` with `naive`. Returns the share of pixels whose own ray was traced, and the
/// second eye's cost, both of `bracket`.
fn check(renderer: &mut Lent, scene: &UploadedScene, camera: &StereoCamera, what: &str) -> [f64; 2] {
    let naive = rendered(renderer, scene, camera, Method::Naive);
    let exact = is_exact(renderer);
    let rays = rendered(renderer, scene, camera, Method::BRACKET_RAYS);
    for (found, expected) in [(&rays.left, &naive.left), (&rays.right, &naive.right)] {
        let difference = compare(found, expected, &naive.pose).unwrap();
        assert_eq!(difference.wrong_surface_percent, 0.0, "{what}: {difference:?}");
        if exact {
            assert!(found.rgba8 == expected.rgba8 && found.primitive == expected.primitive, "{what}");
            let bits = |depths: &[f32]| depths.iter().map(|depth| depth.to_bits()).collect::<Vec<_>>();
            assert!(bits(&found.depth) == bits(&expected.depth), "{what}");
        }
    }
    let bracket = rendered(renderer, scene, camera, Method::BRACKET);
    let difference = compare(&bracket.right, &naive.right, &naive.pose).unwrap();
    assert_eq!(difference.wrong_surface_percent, 0.0, "{what}: {difference:?}");
    let statistics = &bracket.statistics;
    [statistics.right.rays.primary as f64 / bracket.right.depth.len() as f64, statistics.second_eye()]
}

#[test]
fn built_in_scenes_from_within() {
    let mut renderer = renderer();
    for builtin in cases([Builtin::Hall, Builtin::Spheres, Builtin::HallFinished], 3) {
        let uploaded = renderer.upload(&builtin.scene()).wait().unwrap();
        let inside = builtin.camera(160, 80).interaxial(0.3);
        let kinds = [
            (merged(Span::Full), inside.up(Vec3::new(0.3, 1.0, -0.2))),
            (FULL, inside.size(203, 61).interaxial(1e-3)),
            (merged(Span::Half), inside.size(80, 80)),
            (FULL, inside),
            (merged(Span::Full), inside.interaxial(3.0)),
        ];
        for (projection, camera) in cases(kinds, 2) {
            let what = format!("{builtin:?} {projection:?}");
            let [traced, cost] = check(&mut renderer, &uploaded, &around(camera, projection), &what);
            println!("{what}: {traced:.3} of the pixels traced, cost {cost:.3}");
            assert!(traced < 0.5, "{what}: {traced}");
        }
    }
}

#[test]
fn the_stability_suite_from_within() {
    let mut renderer = renderer();
    for &trial in cases(Trial::ALL, 6) {
        let uploaded = renderer.upload(&trial.scene()).wait().unwrap();
        let camera = trial.camera(160, 80);
        let camera = camera.interaxial(camera.pose().unwrap().interaxial);
        for projection in [FULL, merged(Span::Half)] {
            let what = format!("{trial} {projection:?}");
            let [traced, cost] = check(&mut renderer, &uploaded, &around(camera, projection), &what);
            println!("{what}: {traced:.3} of the pixels traced, cost {cost:.3}");
        }
    }
}

#[test]
fn bracket_rays_are_naive_by_every_kind_of_frame() {
    let mut renderer = renderer();
    let exact = is_exact(&renderer);
    let plain = Options::default().linear(true);
    let paths = Lighting::Paths { bounces: 2, samples: 2 };
    let frames = [
        (Builtin::HallFinished, "mirrors and glass", plain.clone()),
        (Builtin::ThreeSpheresTextured, "samples", plain.clone().samples(4)),
        (Builtin::ThreeSpheresTextured, "samples in a grid", plain.clone().samples(9).jitter(false)),
        (Builtin::Random20, "adaptive samples", plain.clone().adaptive(Adaptive::new(3, 8.0))),
        (Builtin::Random20, "soft light", plain.clone().ambient_occlusion(AmbientOcclusion::new(4, 1.0))),
        (Builtin::ThreeSpheresTextured, "sky light", plain.clone().sky_rays(4)),
        (Builtin::Random20, "shadow-buffers", plain.clone().shadow_buffer(ShadowBuffer::new(128))),
        (Builtin::ThreeSpheresMirrors, "paths", plain.clone().lighting(paths)),
    ];
    for (builtin, what, options) in cases(frames, 2) {
        let uploaded = renderer.upload(&builtin.scene()).wait().unwrap();
        let inside = builtin.camera(80, 40);
        let camera = around(inside.interaxial(inside.pose().unwrap().interaxial), merged(Span::Full));
        let [naive, bracket] = [Method::Naive, Method::BRACKET_RAYS].map(|method| {
            let options = options.clone().method(method);
            renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap()
        });
        assert_eq!(bracket.statistics.method, Method::BRACKET_RAYS);
        // Light of paths is taken over.
        let same_light = options.lighting != Lighting::Direct || bracket.right.linear == naive.right.linear;
        let same = bracket.left == naive.left && same_light && bracket.right.object == naive.right.object;
        assert!(same || !exact, "{builtin}, {what}");
        assert_ne!(naive.left.rgba8, naive.right.rgba8, "{builtin}, {what}");
    }
}

/// Rows as they are made are those of the whole picture, also where it has several bands.
#[test]
fn bands_and_rows_are_the_whole_picture() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&Builtin::Spheres.scene()).wait().unwrap();
    // Four bands on software adapters.
    let camera = around(Builtin::Spheres.camera(1024, 640).interaxial(0.2), merged(Span::Full));
    let pair = rendered(&mut renderer, &uploaded, &camera, Method::BRACKET);
    let mut rows = Vec::new();
    let mut keep = |part: Rows| {
        rows.extend(part.views[1].view.rgba8.iter().copied());
        Ok(())
    };
    renderer.pair(&uploaded, &camera).options(&Options::new(Method::BRACKET)).rows(&mut keep).wait().unwrap();
    assert!(rows == pair.right.rgba8);
}

/// A room with a ball, and the eye close to a wall.
fn room() -> Scene {
    let mut scene = Scene::new();
    let white = scene.add_material(Material::new(Vec3::splat(0.7)));
    let mut mesh = Mesh::default();
    let corners = (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 4.0 - 2.0);
    mesh.positions = corners.collect();
    let sides = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    mesh.triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    mesh.materials = vec![white; mesh.triangles.len()];
    scene.add_mesh(&mesh).unwrap();
    scene.add_sphere(stereotrace::Sphere::new(Vec3::new(0.3, -0.4, 0.8), 0.5, white)).unwrap();
    scene
}

#[test]
fn eyes_close_to_walls_and_above_a_ground_plane() {
    let mut renderer = renderer();
    let mut scene = room();
    for (eye, interaxial) in [
        (DVec3::new(0.0, 0.0, 1.999), 1e-3),
        (DVec3::new(0.0, 0.0, 1.9), 0.19),
        (DVec3::new(-1.5, -1.5, -1.5), 0.9),
        (DVec3::ZERO, 1.0),
        (DVec3::ZERO, 2.0),
    ] {
        let camera = StereoCamera::look_at(eye, eye + DVec3::new(1.0, 0.0, 0.2)).size(160, 80).interaxial(interaxial);
        scene.lights.clear();
        scene.place_lights(2, &camera).unwrap();
        let uploaded = renderer.upload(&scene).wait().unwrap();
        for projection in [FULL, merged(Span::Full)] {
            check(&mut renderer, &uploaded, &around(camera, projection), &format!("{eye} {interaxial} {projection:?}"));
        }
    }
    let mut ground = Scene::new();
    let white = ground.add_material(Material::new(Vec3::splat(0.7)));
    ground.add_plane(Plane::new(Vec3::new(0.0, -1.0, 0.0), Vec3::Y, white)).unwrap();
    ground.add_sphere(stereotrace::Sphere::new(Vec3::new(1.0, -0.4, -2.0), 0.6, white)).unwrap();
    let camera = StereoCamera::look_at(DVec3::ZERO, DVec3::X).size(160, 80).interaxial(0.2);
    ground.place_lights(1, &camera).unwrap();
    let uploaded = renderer.upload(&ground).wait().unwrap();
    check(&mut renderer, &uploaded, &around(camera, FULL), "ground");
}

/// A picture of a camera that is turned by some columns is the picture, moved by these columns round the seam.
#[test]
fn the_seam_is_nowhere() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&Builtin::Hall.scene()).wait().unwrap();
    let camera = around(Builtin::Hall.camera(192, 96).interaxial(0.3), merged(Span::Full));
    let (eye, pose) = (camera.pose().unwrap().eye, camera.pose().unwrap());
    let moved = 50;
    let (sin, cos) = (moved as f64 / 192.0 * std::f64::consts::TAU).sin_cos();
    let turned = camera.target(eye + pose.forward.as_dvec3() * cos + pose.right.as_dvec3() * sin);
    for method in
        [Method::Naive, Method::BRACKET, Method::ATOMIC, Method::ES_ISLER, Method::ADELSON_HODGES, Method::BUFFER]
    {
        let [straight, turned] = [&camera, &turned].map(|camera| rendered(&mut renderer, &uploaded, camera, method));
        for (straight, turned) in [(&straight.left, &turned.left), (&straight.right, &turned.right)] {
            let same = straight.object.iter().enumerate().filter(|(index, object)| {
                let (column, row) = (index % 192, index / 192);
                turned.object[row * 192 + (column + 192 - moved) % 192] == **object
            });
            let share = same.count() as f64 / straight.object.len() as f64;
            // Measured: at least 0.9995. Pixels differ whose rays graze an edge.
            assert!(share > 0.998, "{method}: {share}");
        }
    }
}

/// The thesis's methods show points up to half a pixel off, and no worse at the seam or at the poles than elsewhere.
#[test]
fn methods_that_move_samples_show_the_right_surfaces() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&Builtin::Hall.scene()).wait().unwrap();
    let camera = around(Builtin::Hall.camera(384, 192).interaxial(0.3), merged(Span::Full));
    let naive = rendered(&mut renderer, &uploaded, &camera, Method::Naive);
    for (method, bound) in [
        (Method::ATOMIC, 1.2),
        (Method::BUFFER, 1.2),
        (Method::ES_ISLER, 1.4),
        (Method::ADELSON_HODGES, 1.4),
        (Method::VERIFIED, 0.0),
    ] {
        let pair = rendered(&mut renderer, &uploaded, &camera, method);
        assert_eq!(pair.statistics.method, method);
        let wrong = compare(&pair.right, &naive.right, &naive.pose).unwrap().wrong_surface_percent;
        println!("{method}: {wrong:.3}%");
        assert!(wrong <= bound, "{method}: {wrong}");
    }
}

/// Disparities and occlusions against geometry: a ball hides a part of the wall behind it from the other eye.
#[test]
fn the_other_eye_sees_what_is_not_behind_the_ball() {
    let mut renderer = renderer();
    let scene = room();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let camera = StereoCamera::look_at(DVec3::ZERO, DVec3::Z).size(240, 120).interaxial(0.4);
    for projection in [FULL, merged(Span::Full), merged(Span::Half)] {
        let pair = rendered(&mut renderer, &uploaded, &around(camera, projection), Method::Naive);
        let truth = renderer.ground_truth(&uploaded, &scene, &pair).wait().unwrap();
        let turn = if projection.span == Span::Full { std::f64::consts::TAU } else { std::f64::consts::PI };
        for (view, truth, side) in [(&pair.left, &truth.left, 1.0), (&pair.right, &truth.right, -1.0)] {
            let mut hidden = 0;
            for (index, &s) in view.depth.iter().enumerate() {
                let (column, row) = ((index % 240) as f64 + 0.5, (index / 240) as f64 + 0.5);
                let elevation = (0.5 - row / 120.0) * std::f64::consts::PI;
                let above = (elevation.abs().to_degrees() - 60.0) / 15.0;
                let share = match projection.merge {
                    Some(_) if above > 0.0 => (above.min(1.0) * std::f64::consts::FRAC_PI_2).cos(),
                    _ => 1.0,
                };
                let angle = 2.0 * (0.2 * share / f64::from(s)).atan();
                assert!((f64::from(truth.disparity[index]) - angle / turn * 240.0).abs() < 1e-4);
                let point = f64::from(s) / elevation.cos();
                assert!((f64::from(truth.distance[index]) - point).abs() < 1e-4 * point);
                // The other eye's ray to the point, and whether the ball is before it.
                let azimuth = (column - 120.0) / 240.0 * turn - side * angle;
                let (sin, cos) = azimuth.sin_cos();
                // Looking along +z, right is -x.
                let along = |aside: f64, ahead: f64, up: f64| DVec3::new(-aside, up, ahead);
                let origin = along(cos, -sin, 0.0) * (side * 0.2 * share);
                let direction = along(sin, cos, elevation.tan());
                let to_centre = Vec3::new(0.3, -0.4, 0.8).as_dvec3() - origin;
                let at = to_centre.dot(direction) / direction.length_squared();
                let off = (to_centre - direction * at).length() - 0.5;
                let is_ball = view.primitive[index] == 12;
                let is_before = off < 0.0 && at > 0.0 && at < f64::from(s) && !is_ball;
                let is_out = projection.span == Span::Half && azimuth.abs() > 0.5 * turn;
                let found = truth.occlusion[index];
                if is_out {
                    assert_eq!(found, Occlusion::OutOfFrame);
                } else if off.abs() > 1e-3 && !is_ball {
                    assert_eq!(found == Occlusion::Hidden, is_before, "{index} {azimuth} {elevation} {off} {at}");
                    hidden += usize::from(is_before);
                }
            }
            assert!(hidden > 100, "{hidden}");
        }
    }
}

#[test]
fn what_has_no_equirectangular_form_is_refused_by_name() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&room()).wait().unwrap();
    let camera = StereoCamera::look_at(DVec3::ZERO, DVec3::Z).size(64, 32).interaxial(0.1);
    let mut refused = |options: Options| {
        let found = renderer.pair(&uploaded, &around(camera, FULL)).options(&options).read().wait();
        found.map(|_| ()).unwrap_err().to_string()
    };
    assert!(refused(Options::default().visibility(Visibility::TBuffer)).contains("T-buffer"));
    let rig = Rig::row(around(camera, FULL), 3);
    let error = renderer.views(&uploaded, &rig).read().wait().map(|_| ()).unwrap_err();
    assert!(matches!(&error, Error::Rig { reason, .. } if reason.contains("equirectangular")), "{error}");
    let refused = |camera: StereoCamera| camera.pose().unwrap_err().to_string();
    assert!(refused(around(camera.interaxial_pixels(2.0), FULL)).contains("in world units"));
    assert!(refused(around(camera.interaxial(f32::NAN), FULL)).contains("interaxial is NaN"));
    assert!(refused(around(camera.up(Vec3::Z), FULL)).contains("up is"));
    let merge = |from, to| Equirectangular { span: Span::Full, merge: Some(PoleMerge { from, to }) };
    for (from, to) in [(80.0, 70.0), (-1.0, 60.0), (60.0, 91.0), (f32::NAN, 70.0), (60.0, 60.0)] {
        assert!(refused(around(camera, merge(from, to))).contains("pole merge is"), "{from} {to}");
    }
}
