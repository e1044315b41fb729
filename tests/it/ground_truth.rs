//! Tests ground truth against closed forms, and against light that shows the direction of surfaces.

use crate::common;

use common::{folder::Folder, nearest::nearest, renderer};
use stereotrace::{
    Builtin, Channel, Ellipsoid, Error, EyeTruth, GBuffer, GroundTruth, Light, MISS, Material, MaterialId, Mesh,
    Method, Occlusion, Options, Plane, Pose, Scene, Sphere, StereoCamera, StereoPair, View,
    blocking::Wait,
    glam::{DVec3, Mat3, Vec3},
    output::{Batch, save_ids_pfm},
};

fn truth_of(scene: &Scene, camera: &StereoCamera) -> (StereoPair, GroundTruth) {
    let mut renderer = renderer();
    let uploaded = renderer.upload(scene).wait().unwrap();
    let pair = renderer.pair(&uploaded, camera).options(&Options::new(Method::BRACKET_RAYS)).read().wait().unwrap();
    let truth = renderer.ground_truth(&uploaded, scene, &pair).wait().unwrap();
    (pair, truth)
}

/// Returns an eye (-1 left, 1 right) and the direction through a pixel's centre. The direction has length 1 along the
/// view axis. Both are computed from the fields of [`Pose`] alone.
fn ray(pose: &Pose, side: f64, column: usize, row: usize) -> (DVec3, DVec3) {
    let [right, up, forward] = [pose.right, pose.up, pose.forward].map(|axis| axis.as_dvec3());
    let eye = pose.eye + right * (0.5 * side * f64::from(pose.interaxial));
    let [w, h] = pose.size.map(f64::from);
    let x = ((column as f64 + 0.5) / w - 0.5) * f64::from(pose.screen_size[0]);
    let y = (0.5 - (row as f64 + 0.5) / h) * f64::from(pose.screen_size[1]);
    let d = f64::from(pose.screen_distance);
    let on_screen = pose.eye + forward * d + right * x + up * y;
    (eye, (on_screen - eye) / d)
}

fn eyes<'a>(pair: &'a StereoPair, truth: &'a GroundTruth) -> [(f64, &'a View, &'a EyeTruth); 2] {
    [(-1.0, &pair.left, &truth.left), (1.0, &pair.right, &truth.right)]
}

fn vector(of: [f32; 3]) -> DVec3 {
    DVec3::from_array(of.map(f64::from))
}

/// Returns a scene of all kinds of primitives: a mesh with normals, a ball and a rotated ellipsoid, on a plane, in
/// front of the sky.
fn still_life() -> Scene {
    let mut scene = Scene::new();
    let materials = [(); 4].map(|()| scene.add_material(Material::new(Vec3::ONE)));
    let mut mesh = common::ball(Vec3::new(-1.1, 0.9, 0.2), 0.8, 6);
    let outward = |point: &Vec3| (*point - Vec3::new(-1.1, 0.9, 0.2)).normalize();
    let normals: Vec<Vec3> = mesh.positions.iter().map(outward).collect();
    mesh.normals = mesh.triangles.iter().map(|corners| corners.map(|corner| normals[corner as usize])).collect();
    scene.add_mesh(&mesh.materials(vec![materials[0]])).unwrap();
    let corners = vec![Vec3::new(-3.0, 0.1, -2.0), Vec3::new(3.0, 0.4, -2.5), Vec3::new(0.0, 2.5, -2.2)];
    scene.add_mesh(&Mesh::new(corners, vec![[0, 1, 2]])).unwrap();
    scene.add_sphere(Sphere::new(Vec3::new(0.4, 0.5, 0.9), 0.45, materials[1])).unwrap();
    let axes = Mat3::from_rotation_z(0.6) * Mat3::from_diagonal(Vec3::new(0.9, 0.3, 0.5));
    scene.add_ellipsoid(Ellipsoid::new(Vec3::new(1.5, 0.9, -0.3), axes, materials[2])).unwrap();
    scene.add_plane(Plane::new(Vec3::ZERO, Vec3::new(0.0, 1.0, 0.02), materials[3])).unwrap();
    scene
}

fn still_life_camera() -> StereoCamera {
    StereoCamera::look_at(Vec3::new(0.2, 1.4, 5.0), Vec3::new(0.0, 0.7, 0.0)).size(161, 97).interaxial(0.3)
}

/// Without shadows, the brightness of a white surface under a lamp is `max(0, n · l)`. So three lamps along the axes
/// show n.
#[test]
fn shading_normals_are_those_that_surfaces_are_lit_by() {
    let mut scene = still_life();
    scene.shadows = false;
    scene.ambient = Some(Vec3::ZERO);
    let (pair, truth) = truth_of(&scene, &still_life_camera());
    let (mut smooth, mut worst) = (0, 0.0_f32);
    for sign in [-1.0, 1.0] {
        // The lamp is so far away that its direction is the same from everywhere.
        let lamp = |axis: Vec3| Light::point(sign * 1e7 * axis, axis);
        scene.lights = [Vec3::X, Vec3::Y, Vec3::Z].map(lamp).to_vec();
        let lit = common::render(&scene, &still_life_camera(), Method::Naive);
        for ((_, view, eye), lit) in eyes(&pair, &truth).into_iter().zip([&lit.left, &lit.right]) {
            assert_eq!((&lit.primitive, &lit.depth), (&view.primitive, &view.depth));
            for (index, light) in lit.linear.iter().enumerate() {
                let (shading, geometric) = (eye.shading_normal[index], eye.geometric_normal[index]);
                if eye.primitive[index] == MISS {
                    assert_eq!((shading, geometric, eye.material[index]), ([0.0; 3], [0.0; 3], MISS));
                    continue;
                }
                for axis in 0..3 {
                    // A triangle that faces away from the lamp is dark.
                    let faces = sign * geometric[axis] > 0.0;
                    let albedo = if eye.material[index] == 0 { 0.7 } else { 1.0 };
                    let expected = if faces { albedo * (sign * shading[axis]).max(0.0) } else { 0.0 };
                    // If a surface is edge-on to the lamp, rounding decides whether it faces the lamp.
                    let off = if geometric[axis].abs() < 1e-4 { 0.0 } else { (expected - light[axis]).abs() };
                    worst = worst.max(off);
                    // Vertex normals are stored in 32 bits. The measured error is 2.4e-5.
                    assert!(off < 1e-4, "pixel {index}, axis {axis}: {expected} and {}", light[axis]);
                }
                smooth += usize::from(shading != geometric);
            }
        }
    }
    println!("{smooth} pixels of smooth triangles; light off by {worst:e}");
    assert!(smooth > 1000, "{smooth} pixels of smooth triangles");
}

#[test]
fn depth_distance_disparity_and_normals_are_those_of_closed_forms() {
    let scene = still_life();
    let (pair, truth) = truth_of(&scene, &still_life_camera());
    let pose = &pair.pose;
    let width = pose.size[0] as usize;
    let (sphere, spheres) = (scene.spheres()[0], scene.triangles().len() as u32);
    let center = sphere.center.as_dvec3();
    let mut counts = [0; 3];
    let mut worst = [0.0_f64; 4];
    for (side, _, eye) in eyes(&pair, &truth) {
        for index in 0..eye.depth.len() {
            let (origin, direction) = ray(pose, side, index % width, index / width);
            let to_viewer = vector(eye.geometric_normal[index]).dot(direction) < 0.0;
            let point = origin + direction * f64::from(eye.depth[index]);
            let (z, normal) = match eye.primitive[index] {
                id if id == spheres => {
                    let offset = origin - center;
                    let (middle, squared) = (offset.dot(direction), direction.length_squared());
                    let rest = offset.length_squared() - f64::from(sphere.radius).powi(2);
                    let z = (-middle - (middle * middle - squared * rest).sqrt()) / squared;
                    counts[0] += 1;
                    (z, (origin + direction * z - center).normalize())
                }
                id if id == spheres + 1 => {
                    // The expected normal is the gradient of |A⁻¹ (p - c)|², with the inverse of the axes in f64.
                    let ellipsoid = scene.ellipsoids()[0];
                    let inverse = ellipsoid.axes.as_dmat3().inverse();
                    let gradient = inverse.transpose() * (inverse * (point - ellipsoid.center.as_dvec3()));
                    counts[1] += 1;
                    (f64::from(eye.depth[index]), gradient.normalize())
                }
                id if id == spheres + 2 => {
                    let normal = DVec3::new(0.0, 1.0, f64::from(0.02_f32)).normalize();
                    counts[2] += 1;
                    (-origin.dot(normal) / direction.dot(normal), normal)
                }
                MISS => {
                    assert!(eye.depth[index].is_infinite() && eye.distance[index].is_infinite());
                    assert_eq!(eye.disparity[index], -pose.interaxial_px);
                    continue;
                }
                _ => continue,
            };
            let slope = normal.dot(direction).abs();
            let f = f64::from(pose.screen_distance) * f64::from(pose.size[0]) / f64::from(pose.screen_size[0]);
            let e = f64::from(pose.interaxial);
            let disparity = f * e / z - f * e / f64::from(pose.screen_distance);
            let off = [
                (f64::from(eye.depth[index]) / z - 1.0).abs() * slope,
                (f64::from(eye.distance[index]) / (z * direction.length()) - 1.0).abs() * slope,
                (f64::from(eye.disparity[index]) - disparity).abs() * slope,
                vector(eye.geometric_normal[index]).distance(normal),
            ];
            worst = std::array::from_fn(|which| worst[which].max(off[which]));
            assert!(to_viewer && eye.shading_normal[index] == eye.geometric_normal[index], "{index}");
        }
    }
    println!("depth, distance, disparity in px, normal: off by {worst:?}");
    assert!(counts.iter().all(|count| *count > 300), "{counts:?}");
    // The first two errors are relative to depth, times the sine of the angle to the surface. The measured errors are
    // 2.4e-7, 2.6e-7, 2.4e-6 and 1.1e-5. The last one is the error of the ellipsoid's normal. Its expected normal is
    // computed from the rounded depth.
    let bounds = [1e-6, 1e-6, 1e-5, 3e-5];
    assert!(worst.iter().zip(bounds).all(|(off, bound)| *off < bound), "{worst:?}");
}

/// A point is occluded if the other eye's ray to it is blocked, or if it leaves the other picture. This is tested in
/// double precision, for every kind of primitive.
#[test]
fn occlusion_is_what_the_other_eyes_rays_meet() {
    let scene = still_life();
    let (pair, truth) = truth_of(&scene, &still_life_camera());
    let pose = &pair.pose;
    let width = pose.size[0] as usize;
    let (mut found, mut other) = ([0; 3], 0);
    for (side, _, eye) in eyes(&pair, &truth) {
        let other_eye = ray(pose, -side, 0, 0).0;
        for (index, &occlusion) in eye.occlusion.iter().enumerate() {
            let (origin, direction) = ray(pose, side, index % width, index / width);
            let z = nearest(&scene, origin, direction);
            let towards = if z.is_finite() { origin + direction * z - other_eye } else { direction };
            let limit = if z.is_finite() { 1.0 - 1e-6 } else { f64::INFINITY };
            let disparity = pose.disparity_px(z as f32);
            let x = (index % width) as f64 + 0.5 + side * disparity;
            let expected = match nearest(&scene, other_eye, towards) < limit {
                _ if !(0.0..width as f64).contains(&x) => Occlusion::OutOfFrame,
                true => Occlusion::Hidden,
                false => Occlusion::Visible,
            };
            found[expected as usize] += 1;
            other += usize::from(expected != occlusion);
        }
    }
    println!("{found:?} seen, hidden and out of the picture; {other} otherwise");
    assert!(found.iter().all(|count| *count > 500), "{found:?}");
    assert!(other <= 4, "{other}");
}

#[test]
fn ids_are_the_scenes_own_and_normals_turn_with_the_camera() {
    let scene = still_life();
    let (pair, truth) = truth_of(&scene, &still_life_camera());
    let mut seen = [0; 5];
    for (_, view, eye) in eyes(&pair, &truth) {
        assert_eq!((&eye.primitive, &eye.object), (&view.primitive, &view.object));
        for (&object, &material) in eye.object.iter().zip(&eye.material) {
            // The second mesh has the default grey material of every scene.
            let expected = [1, 0, 2, 3, 4, MISS][(object as usize).min(5)];
            assert_eq!(material, expected, "{object}");
            if object < 5 {
                seen[object as usize] += 1;
            }
        }
        assert!(eye.sky().iter().zip(eye.surfaces()).all(|(sky, surface)| *sky != surface));
        for (turned, normal) in truth.pose.in_camera(&eye.shading_normal).into_iter().zip(&eye.shading_normal) {
            let (turned, normal) = (vector(turned), vector(*normal));
            let back = turned.x * truth.pose.right.as_dvec3() - turned.y * truth.pose.up.as_dvec3()
                + turned.z * truth.pose.forward.as_dvec3();
            assert!(back.distance(normal) < 1e-6);
        }
    }
    assert!(seen.iter().all(|count| *count > 100), "{seen:?}");
}

#[test]
fn what_no_ground_truth_can_be_made_of_is_refused_by_name() {
    let (scene, camera) = (Builtin::Fence.scene(), Builtin::Fence.camera(24, 16));
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let mut message = |scene: &Scene, options: &Options| {
        let pair = renderer.pair(&uploaded, &camera).options(options).read().wait().unwrap();
        renderer.ground_truth(&uploaded, scene, &pair).wait().map_err(|error| error.to_string())
    };
    let naive = Options::new(Method::Naive);
    for g_buffer in [GBuffer::Depth, GBuffer::None] {
        let found = message(&scene, &naive.clone().g_buffer(g_buffer)).unwrap_err();
        assert!(found.contains("g_buffer: ground truth needs depths and ids"), "{found}");
    }
    for method in [Method::ATOMIC, Method::ES_ISLER, Method::Ideal] {
        let found = message(&scene, &Options::new(method)).unwrap_err();
        assert!(found.contains(&format!("{method} shows points up to half a pixel off")), "{found}");
    }
    let found = message(&Builtin::Hall.scene(), &naive).unwrap_err();
    assert!(
        found.contains("the ground truth's scene: neither it nor the scene it was cloned from was uploaded"),
        "{found}"
    );
    let mut moved = scene.clone();
    moved.add_sphere(Sphere::new(Vec3::ZERO, 1.0, MaterialId(0))).unwrap();
    assert!(message(&moved, &naive).is_err());
    // Methods that show the same surfaces have the same ground truth.
    let truth = message(&scene.clone(), &naive).unwrap();
    for method in [Method::BRACKET, Method::VERIFIED, Method::Auto] {
        assert!(message(&scene, &Options::new(method)).unwrap() == truth, "{method}");
    }
}

/// Tests extreme scenes and cameras: no value may be NaN, and every file can be written.
#[test]
fn channels_refuse_the_ground_truth_of_another_shape() {
    let (wide, truth) = truth_of(&still_life(), &still_life_camera().size(16, 12));
    let tall = truth_of(&still_life(), &still_life_camera().size(12, 16)).0;
    for channel in [Channel::Distance, Channel::Normal, Channel::Disparity] {
        assert!(wide.left_channels(Some(&truth)).get(channel).is_ok(), "{channel}");
        let message = tall.right_channels(Some(&truth)).get(channel).unwrap_err().to_string();
        assert!(message.contains("16x12 and 12x16"), "{channel}: {message}");
    }
}

#[test]
fn the_edges_have_numbers_and_files() {
    let plane_through_the_eyes = {
        let mut scene = still_life();
        scene.add_plane(Plane::new(Vec3::new(0.0, 1.4, 0.0), Vec3::Y, MaterialId(0))).unwrap();
        scene
    };
    let around_the_eyes = {
        let mut scene = Scene::new();
        scene.add_sphere(Sphere::new(Vec3::new(0.2, 1.4, 5.0), 0.4, MaterialId(0))).unwrap();
        scene
    };
    let cases: [(&str, &Scene, StereoCamera); 8] = [
        ("sky alone", &Scene::new(), still_life_camera()),
        ("sky in one pixel", &Scene::new(), still_life_camera().size(1, 1)),
        ("one pixel", &still_life(), still_life_camera().size(1, 1)),
        ("one row", &still_life(), still_life_camera().size(7, 1)),
        ("one column", &still_life(), still_life_camera().size(1, 5)),
        ("eyes in one place", &still_life(), still_life_camera().interaxial(0.0)),
        ("eyes in a plane", &plane_through_the_eyes, still_life_camera()),
        ("eyes within a ball", &around_the_eyes, still_life_camera()),
    ];
    for (name, scene, camera) in cases {
        let (pair, truth) = truth_of(scene, &camera);
        for (_, view, eye) in eyes(&pair, &truth) {
            let count = (view.width * view.height) as usize;
            assert!([eye.depth.len(), eye.distance.len(), eye.disparity.len()].iter().all(|n| *n == count), "{name}");
            assert!([eye.material.len(), eye.occlusion.len(), eye.object.len()].iter().all(|n| *n == count), "{name}");
            assert!(eye.disparity.iter().all(|d| !d.is_nan()), "{name}");
            assert!(eye.depth.iter().chain(&eye.distance).all(|z| *z > 0.0), "{name}");
            for normal in eye.shading_normal.iter().chain(&eye.geometric_normal) {
                let length = vector(*normal).length();
                assert!(length == 0.0 || (length - 1.0).abs() < 1e-6, "{name}: {normal:?}");
            }
            let is_sky = eye.geometric_normal.iter().map(|normal| *normal == [0.0; 3]);
            assert!(is_sky.eq(eye.sky()), "{name}");
            if truth.pose.interaxial == 0.0 {
                assert!(eye.occlusion.iter().all(|found| *found == Occlusion::Visible), "{name}");
                assert!(eye.disparity.iter().all(|d| *d == 0.0), "{name}");
            }
        }
        let folder = Folder::new("truth");
        let mut files = Batch::new();
        let ([width, height], eye) = (truth.pose.size, &truth.right);
        files.add_pfm(folder.file("disparity"), width, height, &eye.disparity).unwrap();
        files.add_pfm_color(folder.file("normals"), width, height, &eye.shading_normal).unwrap();
        files.add_nocc_mask(folder.file("nocc"), eye).unwrap();
        files.add_sky_mask(folder.file("sky"), eye).unwrap();
        files.add_occlusion(folder.file("occlusion"), eye).unwrap();
        files.add_ids_png(folder.file("ids"), width, height, &eye.primitive).unwrap();
        files.add_kitti_disparity(folder.file("kitti"), width, height, &eye.disparity, &eye.sky()).err();
        files.add_calib(folder.file("calib"), &truth).unwrap();
        files.add_camera_json(folder.file("camera"), &truth.pose).unwrap();
        files.commit().unwrap();
        let calib = std::fs::read_to_string(folder.file("calib")).unwrap();
        assert!(!calib.contains("NaN") && !calib.contains("inf"), "{name}: {calib}");
    }
}

/// Off-axis pairs have negative disparities behind the screen, which KITTI's file can't hold. Nothing is written, and
/// the message says what to do.
#[test]
fn kitti_refuses_negative_disparities_and_takes_those_before_a_far_screen() {
    let scene = still_life();
    let folder = Folder::new("kitti_truth");
    let add = |camera: &StereoCamera| {
        let (_, truth) = truth_of(&scene, camera);
        let ([width, height], eye) = (truth.pose.size, truth.left);
        let mut files = Batch::new();
        files.add_kitti_disparity(folder.file("a.png"), width, height, &eye.disparity, &eye.surfaces_of_both())?;
        files.commit()
    };
    let message = add(&still_life_camera()).unwrap_err().to_string();
    assert!(
        message.contains("is not above 0, which KITTI's PNG file can't hold: render the pair with parallel cameras")
    );
    assert!(folder.names().is_empty());
    // The plane extends behind any screen, but its visible part is in front of this screen.
    let low = still_life_camera().target(Vec3::new(0.0, -2.0, 0.0)).vertical_fov_degrees(30.0);
    add(&low.screen_distance(1e3)).unwrap();
    assert_eq!(folder.names(), ["a.png"]);
}

#[test]
fn seventy_thousand_objects_have_ids_in_files_that_hold_them() {
    let mut scene = Scene::new();
    for index in 0..70_000_u32 {
        let (column, row) = ((index % 350) as f32, (index / 350) as f32);
        scene.add_sphere(Sphere::new(Vec3::new(column - 175.0, row - 100.0, 0.0), 0.5, MaterialId(0))).unwrap();
    }
    let camera = StereoCamera::look_at(Vec3::new(0.0, 0.0, 300.0), Vec3::ZERO).size(160, 120).interaxial(1.0);
    let (pair, truth) = truth_of(&scene, &camera);
    let folder = Folder::new("objects");
    let eye = &truth.left;
    let last = eye.object.iter().copied().filter(|id| *id != MISS).max().unwrap();
    assert!(last > 65_534, "{last}");
    let error = Batch::new().add_ids_png(folder.file("a.png"), 160, 120, &eye.object).unwrap_err();
    assert!(matches!(error, Error::Io { .. }), "{error}");
    assert!(error.to_string().contains("an OpenEXR file (Batch::add_exr) holds every id"), "{error}");
    save_ids_pfm(folder.file("a.pfm"), 160, 120, &eye.object).unwrap();
    assert_eq!(folder.names(), ["a.pfm"]);
    assert_eq!(pair.left.object, eye.object);
}
