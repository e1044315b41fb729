//! Tests pictures against closed forms: spheres and planes by formula, closed meshes without cracks, shadows at every
//! scale.

use crate::common;

use common::{ball, random::Random, render, renderer};
use stereotrace::{
    Light, Material, MaterialId, Mesh, Method, Options, Scene, Sky, Sphere, StereoCamera, StereoPair,
    blocking::Wait,
    glam::{DVec3, Vec3},
    scene::builtin::Builtin,
};

#[test]
fn a_red_sphere_at_plus_x_is_right_of_the_centre_and_further_left_for_the_right_eye_the_nearer_it_is() {
    let columns = |pair: &StereoPair| {
        let mean = |view: &stereotrace::View| {
            let hit = view.rgba8.iter().enumerate().filter(|(_, c)| c[0] > 40 && c[1] < 20);
            let columns: Vec<f32> = hit.map(|(index, _)| (index % 128) as f32 + 0.5).collect();
            assert!(columns.len() > 20);
            columns.iter().sum::<f32>() / columns.len() as f32
        };
        (mean(&pair.left), mean(&pair.right))
    };
    let mut last = f32::INFINITY;
    for z in [-6.0, -3.0, 0.0, 2.0] {
        let mut scene = Scene::new();
        let red = scene.add_material(Material::new(Vec3::new(0.8, 0.0, 0.0)));
        scene.add_sphere(Sphere::new(Vec3::new(0.8, 0.0, z), 0.5, red)).unwrap();
        let camera =
            StereoCamera::look_at(5.0 * Vec3::Z, Vec3::ZERO).size(128, 96).screen_distance(5.0).interaxial_pixels(12.0);
        let pair = render(&scene, &camera, Method::Naive);
        let (left, right) = columns(&pair);
        assert!(left > 64.0, "left eye sees it at column {left}");
        // The silhouette's centre has the parallax of the sphere's centre, up to the sphere's extent in depth.
        let expected = pair.pose.parallax_px(5.0 - z);
        assert!((right - left - expected).abs() < 1.0, "z {z}: {left} {right}, expected {expected}");
        assert!(right - left < last, "nearer is further left");
        last = right - left;
    }
}

/// Returns the surface that a ray sees in a scene of a sphere over a plane: 0 sky, 1 the lit plane, 2 the plane in
/// shadow, 3 the lit sphere, 4 the unlit sphere. Also returns the hit's depth and the cosine of the light's angle.
fn sphere_over_plane(origin: DVec3, direction: DVec3, light: DVec3) -> (u32, f64, f64) {
    let (center, radius) = (DVec3::new(0.0, 1.0, 0.0), 1.0);
    let sphere = |o: DVec3, d: DVec3| {
        let (a, b, c) = (d.dot(d), d.dot(o - center), (o - center).length_squared() - radius * radius);
        let root = b * b - a * c;
        (root > 0.0).then(|| (-b - root.sqrt()) / a).filter(|&t| t > 1e-9)
    };
    let plane = (direction.y < 0.0).then(|| (-0.5 - origin.y) / direction.y).filter(|t| {
        let point = origin + direction * *t;
        point.x.abs() < 20.0 && point.z.abs() < 20.0
    });
    match (sphere(origin, direction), plane) {
        (Some(t), plane) if plane.is_none_or(|p| t < p) => {
            let point = origin + direction * t;
            let normal = (point - center) / radius;
            let to_light = (light - point).normalize();
            let cosine = normal.dot(to_light);
            if cosine > 0.0 { (3, t, cosine) } else { (4, t, 0.0) }
        }
        (_, Some(t)) => {
            let point = origin + direction * t;
            let to_light = (light - point).normalize();
            if sphere(point, light - point).is_some() { (2, t, 0.0) } else { (1, t, to_light.y) }
        }
        _ => (0, f64::INFINITY, 0.0),
    }
}

#[test]
fn a_sphere_over_a_plane_with_one_shadow_is_as_by_formula() {
    let light = Vec3::new(2.0, 5.0, 3.0);
    let mut scene = Scene::new();
    let (red, grey) = (
        scene.add_material(Material::new(Vec3::new(0.7, 0.2, 0.1))),
        scene.add_material(Material::new(Vec3::splat(0.5))),
    );
    scene.add_sphere(Sphere::new(Vec3::Y, 1.0, red)).unwrap();
    let corner = |x: f32, z: f32| Vec3::new(20.0 * x, -0.5, 20.0 * z);
    let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let mut floor = Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]);
    floor.materials = vec![grey];
    scene.add_mesh(&floor).unwrap();
    scene.ambient = Some(Vec3::splat(0.1));
    scene.sky = Sky::Constant(Vec3::new(0.2, 0.4, 0.9));
    scene.lights = vec![Light::point(light, Vec3::splat(0.9))];
    let camera = StereoCamera::look_at(Vec3::new(0.5, 2.0, 6.0), Vec3::new(0.0, 0.7, 0.0))
        .size(160, 120)
        .vertical_fov_degrees(45.0)
        .screen_distance(6.0)
        .interaxial_pixels(8.0);
    let pair = render(&scene, &camera, Method::Naive);
    let pose = pair.pose;
    let mut kinds = [0; 5];
    for (view, side) in [(&pair.left, -1.0), (&pair.right, 1.0)] {
        let origin = pose.eye_position(side);
        let ray = |x: f64, y: f64| {
            let [w, h] = pose.screen_size.map(f64::from);
            let screen = pose.eye
                + pose.forward.as_dvec3() * f64::from(pose.screen_distance)
                + pose.right.as_dvec3() * (w * (x / 160.0 - 0.5))
                + pose.up.as_dvec3() * (h * (0.5 - y / 120.0));
            (screen - origin) / f64::from(pose.screen_distance)
        };
        for row in 0..120 {
            for column in 0..160 {
                let (x, y) = (f64::from(column) + 0.5, f64::from(row) + 0.5);
                let see = |dx: f64, dy: f64| sphere_over_plane(origin, ray(x + dx, y + dy), light.as_dvec3());
                let (kind, z, cosine) = see(0.0, 0.0);
                // Within 0.02 pixels of an edge, f32 may see either side.
                let edge = [(0.02, 0.0), (-0.02, 0.0), (0.0, 0.02), (0.0, -0.02)];
                if edge.iter().any(|&(dx, dy)| see(dx, dy).0 != kind) {
                    continue;
                }
                kinds[kind as usize] += 1;
                let lit = 0.1 + 0.9 * cosine;
                let expected = match kind {
                    0 => DVec3::new(0.2, 0.4, 0.9),
                    1 | 2 => DVec3::splat(0.5) * lit,
                    _ => DVec3::new(0.7, 0.2, 0.1) * lit,
                };
                let index = (row * 160 + column) as usize;
                let found = DVec3::from_array([0, 1, 2].map(|c| f64::from(view.linear[index][c])));
                // The bound is four times the measured 1.2e-5, which comes from the shadow ray's offset.
                assert!((found - expected).abs().max_element() < 5e-5, "({column}, {row}): {found} {expected}");
                let depth = f64::from(view.depth[index]);
                assert!(depth == z || (depth - z).abs() < 1e-5 * z, "({column}, {row}): {depth} {z}");
            }
        }
    }
    assert!(kinds.iter().all(|&count| count > 50), "every case is there: {kinds:?}");
}

#[test]
fn a_closed_mesh_shows_no_crack_where_rays_go_exactly_through_its_vertices_and_edges() {
    // Steps of a power of two make every direction and every product exact. All rays go through lattice points of the
    // front wall, which are vertices, or points on edges and diagonals.
    for spacing in [0.25_f32, 0.5, 1.0] {
        let count = (36.0 / spacing) as u32;
        let point = |i: u32, j: u32, z: f32| Vec3::new(i as f32 * spacing - 18.0, j as f32 * spacing - 18.0, z);
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        for z in [-4.0, -9.0] {
            let base = positions.len() as u32;
            positions.extend((0..=count).flat_map(|j| (0..=count).map(move |i| point(i, j, z))));
            let at = |i: u32, j: u32| base + j * (count + 1) + i;
            for (i, j) in (0..count).flat_map(|j| (0..count).map(move |i| (i, j))) {
                // Diagonals in both directions make edges of every direction meet.
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                triangles.extend(if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
            }
        }
        let mut scene = Scene::new();
        scene.add_mesh(&Mesh::new(positions, triangles)).unwrap();
        let camera = StereoCamera::look_at(Vec3::ZERO, -Vec3::Z)
            .size(64, 64)
            .screen_width(8.0)
            .screen_distance(1.0)
            .interaxial(0.25);
        let pair = render(&scene, &camera, Method::Naive);
        for view in [&pair.left, &pair.right] {
            let wrong: Vec<_> =
                view.depth.iter().enumerate().filter(|(_, z)| (**z - 4.0).abs() > 1e-5).take(3).collect();
            assert!(wrong.is_empty(), "rays slipped through a wall of {spacing}: {wrong:?}");
        }
    }
}

#[test]
fn a_closed_ball_shows_no_crack_at_any_scale_or_place() {
    let mut random = Random::new(11);
    for (scale, offset) in [(1e-3, 0.0), (1.0, 0.0), (1e6, 0.0), (1.0, 1000.0)] {
        for rings in [16, 90] {
            let center = Vec3::splat(offset) + random.point(1.0) * scale;
            let mut scene = Scene::new();
            scene.add_mesh(&ball(center, scale, rings)).unwrap();
            // One view is straight at a pole, where 2 * rings triangles meet. The other is from the side.
            for from in [Vec3::new(1e-3, 3.0, 0.0), Vec3::new(1.0, 0.5, 3.0)] {
                let camera = StereoCamera::look_at(center + from * scale, center)
                    .size(129, 129)
                    .vertical_fov_degrees(30.0)
                    .interaxial_pixels(4.0);
                let pair = render(&scene, &camera, Method::Naive);
                let behind = camera.pose().unwrap().eye.as_vec3().distance(center);
                for view in [&pair.left, &pair.right] {
                    let cracks = view.depth.iter().filter(|&&z| z.is_finite() && z > behind + 0.2 * scale).count();
                    let seen = view.depth.iter().filter(|z| z.is_finite()).count();
                    assert_eq!(cracks, 0, "rays through the near side at scale {scale}, offset {offset}");
                    assert!(seen > 1000, "{seen}");
                }
            }
        }
    }
}

/// Counts dark pixels with a light at the eye, which lights everything that the eye sees. A dark pixel is shadow acne.
/// Pixels at a silhouette don't count, since the surface may be edge-on to the light there.
fn acne(scene: &Scene, camera: &StereoCamera) -> (usize, usize) {
    let mut scene = scene.clone();
    scene.ambient = Some(Vec3::ZERO);
    let position = camera.pose().unwrap().eye;
    scene.lights = vec![Light::point(position, Vec3::ONE)];
    let camera = camera.interaxial(0.0);
    let pair = render(&scene, &camera, Method::Ideal);
    let view = &pair.left;
    let (width, height) = (view.width as usize, view.height as usize);
    let inner = (1..height - 1).flat_map(|row| (1..width - 1).map(move |column| row * width + column));
    let smooth = inner.filter(|&index| {
        let neighbours = [index - 1, index + 1, index - width, index + width];
        let flat = |other: &usize| (view.depth[*other] / view.depth[index] - 1.0).abs() < 0.03;
        view.depth[index].is_finite() && neighbours.iter().all(flat)
    });
    let dark = smooth.clone().filter(|&index| view.linear[index][..3] == [0.0; 3]).count();
    (dark, smooth.count())
}

#[test]
fn shadow_rays_leave_their_surface_at_every_scale_and_far_from_the_origin() {
    for (scale, offset) in [(1.0, 0.0), (1e-3, 0.0), (1e6, 0.0), (1.0, 1000.0), (1e-3, 1.0), (1e3, 1e6)] {
        let center = Vec3::splat(offset);
        let mut scene = Scene::new();
        scene.add_mesh(&ball(center, scale, 60)).unwrap();
        scene.add_sphere(Sphere::new(center + Vec3::X * 2.5 * scale, scale, MaterialId(0))).unwrap();
        let floor = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)]
            .map(|(x, z)| center + Vec3::new(x, -1.5, z) * scale)
            .to_vec();
        scene.add_mesh(&Mesh::new(floor, vec![[0, 1, 2], [0, 2, 3]])).unwrap();
        let camera = StereoCamera::look_at(center + Vec3::new(1.0, 2.0, 7.0) * scale, center).size(160, 120);
        let (dark, seen) = acne(&scene, &camera);
        assert!(seen > 10_000, "{seen}");
        assert_eq!(dark, 0, "scale {scale}, offset {offset}: {dark} of {seen} pixels shadow themselves");
    }
}

#[test]
fn shadows_reach_to_their_casters_at_every_scale_and_place() {
    // A wall stands on a floor, lit from above. The floor is in shadow from the wall to x = 0.26, unless shadow rays
    // start above the wall. This test complements the acne test. The distances of the farther lights are 20 and 10,000
    // times the scene's side.
    let places = [(1.0, 0.0), (1e-3, 0.0), (1e6, 0.0), (1.0, 1e3), (1.0, 1e5), (1e-3, 1.0)];
    for ((scale, offset), away) in places.into_iter().flat_map(|place| [1.0, 30.0, 2e4].map(|away| (place, away))) {
        let place = |x: f32, y: f32, z: f32| Vec3::new(x, y, z) * scale + Vec3::splat(offset);
        if 10.0 * away * scale > 1e8 {
            continue; // the library refuses this light
        }
        let mut scene = Scene::new();
        let floor = vec![place(-9.0, 0.0, -9.0), place(9.0, 0.0, -9.0), place(9.0, 0.0, 9.0), place(-9.0, 0.0, 9.0)];
        scene.add_mesh(&Mesh::new(floor, vec![[0, 1, 2], [0, 2, 3]])).unwrap();
        let wall = vec![place(0.0, 0.0, -9.0), place(0.0, 0.5, -9.0), place(0.0, 0.5, 9.0), place(0.0, 0.0, 9.0)];
        scene.add_mesh(&Mesh::new(wall, vec![[0, 1, 2], [0, 2, 3]])).unwrap();
        scene.ambient = Some(Vec3::ZERO);
        scene.lights = vec![Light::point(place(-5.0 * away, 10.0 * away, 0.0), Vec3::ONE)];
        let camera = StereoCamera::look_at(place(0.1, 4.0, 0.0), place(0.1, 0.0, 0.0))
            .up(Vec3::Z)
            .size(64, 64)
            .vertical_fov_degrees(2.0)
            .interaxial(0.0);
        let pair = render(&scene, &camera, Method::Ideal);
        let floor = pair.left.object.iter().zip(&pair.left.linear).filter(|(object, _)| **object == 0);
        let lit = floor.clone().filter(|(_, color)| color[..3] != [0.0; 3]).count();
        assert!(floor.count() > 3000);
        assert_eq!(lit, 0, "scale {scale}, offset {offset}, light {away}: light leaks under the wall");
    }
}

#[test]
fn a_ball_does_not_shadow_its_lit_side_however_far_the_light() {
    for (scale, offset) in [(1.0, 0.0), (1e-3, 0.0), (1e6, 0.0), (1.0, 1e3)] {
        let center = Vec3::splat(offset);
        let mut scene = Scene::new();
        scene.add_mesh(&ball(center, scale, 60)).unwrap();
        scene.ambient = Some(Vec3::ZERO);
        let camera = StereoCamera::look_at(center + 4.0 * scale * Vec3::Z, center).size(96, 96).interaxial(0.0);
        for away in [3.0, 30.0, 120.0, 1e3, 1e5] {
            let towards = Vec3::new(0.5, 0.7, 0.6).normalize();
            let position = center + towards * (away * scale);
            if position.abs().max_element() > 1e8 {
                continue; // the library refuses this light
            }
            scene.lights = vec![Light::point(position, Vec3::ONE)];
            let pair = render(&scene, &camera, Method::Ideal);
            let frame = stereotrace::testing::cpu::Frame::new(&pair.pose);
            let mut lit = 0;
            for (index, (depth, color)) in pair.left.depth.iter().zip(&pair.left.linear).enumerate() {
                let direction = frame.direction(stereotrace::testing::cpu::Eye::Left, index % 96, index / 96);
                let point = frame.eye(stereotrace::testing::cpu::Eye::Left) + direction * depth.min(1e9);
                // The triangle faces the light by more than the error of its normal.
                let facing = depth.is_finite() && (point - center).dot((position - point).normalize()) > 0.1 * scale;
                lit += usize::from(facing);
                assert!(
                    !facing || color[0] > 0.0,
                    "pixel {index} is dark: scale {scale}, offset {offset}, light {away}"
                );
            }
            assert!(lit > 500, "{lit}");
        }
    }
}

#[test]
fn the_hall_shows_no_acne() {
    let camera = Builtin::Hall.camera(192, 108);
    // Vertex normals are left out, since at a rim they may correctly point away from the light.
    let triangles = Builtin::Hall.scene().triangles().to_vec();
    let corners = triangles.iter().flat_map(|triangle| triangle.corners).collect();
    let faces = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let mut flat = Scene::new();
    flat.add_mesh(&Mesh::new(corners, faces)).unwrap();
    let (dark, seen) = acne(&flat, &camera);
    // The measured number is 0. The bound leaves a pixel or two for concave corners on other adapters.
    assert!(dark <= 2, "{dark} of {seen}");
}

#[test]
fn a_gradient_sky_runs_from_nadir_to_zenith() {
    let mut scene = Scene::new();
    scene.sky = Sky::Gradient { nadir: Vec3::new(1.0, 0.0, 0.0), zenith: Vec3::new(0.0, 0.0, 1.0) };
    let look = |target: Vec3| {
        let camera =
            StereoCamera::look_at(Vec3::ZERO, target).up(Vec3::Z).size(5, 5).vertical_fov_degrees(1.0).interaxial(0.0);
        let mut renderer = renderer();
        let uploaded = renderer.upload(&scene).wait().unwrap();
        renderer
            .pair(&uploaded, &camera)
            .options(&Options::new(Method::Naive).linear(true))
            .read()
            .wait()
            .unwrap()
            .left
            .linear[12]
    };
    for (target, expected) in [(Vec3::Y, [0.0, 1.0]), (-Vec3::Y, [1.0, 0.0]), (Vec3::X, [0.5, 0.5])] {
        let found = look(target);
        assert!((found[0] - expected[0]).abs() < 1e-3 && (found[2] - expected[1]).abs() < 1e-3, "{found:?}");
    }
}
