//! Tests the hits of rays against double precision and against twins. A twin is independent code in plain Rust.

use stereotrace::{
    MISS, MaterialId, Mesh, Method, Options, Plane, Ray, Scene, Sky, Sphere, StereoCamera,
    blocking::Wait,
    glam::{Quat, Vec3},
    testing::cpu::{Eye, Frame, intersect::closest_hit, trace_left::trace_left},
};

use super::{
    THINGS, Things, camera,
    common::{is_exact, random::Random, renderer, renderer_by, traversals},
    stage, tilt,
    truth::{Truth, judged},
};

/// Returns a stage with three more planes: a wall, one below the ground, and one above the ground.
fn room(turn: Quat) -> Scene {
    let mut scene = stage(Things::All, turn);
    for (point, normal) in [(-6.0 * Vec3::Z, Vec3::Z), (-Vec3::Y, Vec3::NEG_Y), (6.0 * Vec3::Y, Vec3::Y)] {
        scene.add_plane(Plane::new(turn * point, turn * normal, MaterialId(1))).unwrap();
    }
    scene
}

#[test]
fn planes_with_shadows_on_them_are_as_by_formula() {
    let mut cases: Vec<_> = THINGS.into_iter().map(|things| (format!("{things:?}"), stage(things, tilt()))).collect();
    cases.push(("room".into(), room(tilt())));
    for (name, scene) in cases {
        for judged in judged(&mut renderer(), &scene, &camera(tilt()), 0.01) {
            println!("{name}: {judged:?}");
            assert!(judged.others <= 1 && judged.seen > 2500, "{name}: {judged:?}");
            assert!(judged.depth_by_slope < 5e-7 && judged.color < 5e-5, "{name}: {judged:?}");
        }
    }
}

#[test]
fn eyes_below_beside_and_just_above_a_ground_see_it_as_by_formula() {
    let turn = tilt();
    for (eye, target, seen) in [
        (Vec3::new(0.3, -0.8, 5.0), Vec3::new(0.0, -0.1, 0.0), 1000),
        (Vec3::new(0.3, 1e-3, 5.0), Vec3::new(0.0, 0.3, 0.0), 1000),
        (Vec3::new(0.3, 1e4, 5.0), Vec3::new(0.0, 0.0, -1e4), 3000),
        // The eye looks straight down, straight up, and away from the plane.
        (Vec3::new(0.3, 4.0, 0.1), Vec3::new(0.3, 0.0, 0.0), 5000),
        (Vec3::new(0.3, -4.0, 0.1), Vec3::new(0.3, 0.0, 0.0), 5000),
        (Vec3::new(0.3, 4.0, 0.1), Vec3::new(0.3, 9.0, 0.0), 0),
    ] {
        let camera = camera(turn).eye(turn * eye).target(turn * target).screen_distance(4.0).interaxial_pixels(5.0);
        for judged in judged(&mut renderer(), &stage(Things::All, turn), &camera, 0.01) {
            println!("{eye}: {judged:?}");
            assert!(judged.others <= 1 && judged.seen >= seen && judged.depth_by_slope < 5e-7, "{eye}: {judged:?}");
            assert!(judged.color < 1e-4, "{eye}: {judged:?}");
        }
    }
}

/// The horizon separates rays that go down from the other rays. The ground ends at the largest distance at which planes
/// are hit.
#[test]
fn the_horizon_is_where_rays_stop_to_go_down() {
    for (height, pitch) in [(1.5_f32, 0.1_f32), (1.5, -0.2), (300.0, 0.0), (2e6, -0.02), (-3.0, 0.1)] {
        let mut scene = stage(Things::Nothing, Quat::IDENTITY);
        scene.lights.clear();
        let eye = Vec3::new(10.0, height, 7.0);
        // A sphere behind the eyes gives the scene a tree, which bracket searches.
        let behind = Sphere::new(eye + 3.0 * height.abs() * Vec3::Z, 0.5 * height.abs(), MaterialId(0));
        scene.add_sphere(behind).unwrap();
        let camera = StereoCamera::look_at(eye, eye + Vec3::new(0.1, pitch, -1.0).normalize() * height.abs())
            .size(64, 97)
            .interaxial_pixels(4.0);
        let mut renderer = renderer();
        let uploaded = renderer.upload(&scene).wait().unwrap();
        for method in [Method::Naive, Method::BRACKET, Method::ATOMIC] {
            let pair = renderer.pair(&uploaded, &camera).options(&Options::new(method)).read().wait().unwrap();
            let frame = Frame::new(&pair.pose);
            for (eye, view) in [(Eye::Left, &pair.left), (Eye::Right, &pair.right)] {
                let mut seen = 0;
                for (index, depth) in view.depth.iter().enumerate() {
                    let direction = frame.direction(eye, index % 64, index / 64).as_dvec3();
                    let t = f64::from(-frame.eye(eye).y) / direction.y;
                    let there = t > 0.0 && t * direction.length() <= 1e8;
                    assert_eq!(depth.is_finite(), there, "{height} {pitch} {method}: {eye:?} {index}, {t}");
                    seen += usize::from(there);
                }
                assert!((500..6000).contains(&seen), "{height} {pitch}: {seen}");
            }
        }
    }
}

/// On software Vulkan, hits are equal to the last bit in every variant of the traversal.
#[test]
fn hits_are_the_twins_in_every_traversal() {
    let scenes = [stage(Things::Nothing, tilt()), stage(Things::Spheres, tilt()), room(tilt())];
    for traversal in traversals() {
        let mut renderer = renderer_by(traversal);
        let exact = is_exact(&renderer);
        for scene in &scenes {
            let uploaded = renderer.upload(scene).wait().unwrap();
            let options = Options::new(Method::Naive);
            let pair = renderer.pair(&uploaded, &camera(tilt()).size(41, 29)).options(&options).read().wait().unwrap();
            let twin = trace_left(scene, &Frame::new(&pair.pose), Eye::Left);
            let found = pair.left.depth.iter().zip(&pair.left.primitive);
            let differ = |((depth, id), twin): &((&f32, &u32), &(f32, u32))| {
                let near = (depth.min(stereotrace::FAR) - twin.0).abs() <= if exact { 0.0 } else { 1e-4 * twin.0 };
                **id != twin.1 || !near
            };
            let differing = found.zip(&twin).filter(differ).count();
            assert!(differing <= if exact { 0 } else { 2 }, "{traversal}: {differing}");
        }
    }
}

#[test]
fn lists_of_rays_meet_planes_within_their_limits() {
    let scene = room(tilt());
    let truth = Truth::new(&scene);
    let mut random = Random::new(9);
    let mut rays = Vec::new();
    for index in 0..4000 {
        let length = 10.0_f32.powf(random.between(-6.0, 6.0));
        let ray = Ray::new(random.point(4.0), length * random.point(1.0));
        rays.push(match index % 3 {
            0 => ray,
            1 => ray.t_min(random.between(0.0, 6.0) / length),
            _ => ray.t_min(0.5 / length).t_max(random.between(1.0, 9.0) / length),
        });
    }
    let renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let closest = renderer.closest_hits(&uploaded, &rays).wait().unwrap().hits;
    let any = renderer.any_hits(&uploaded, &rays).wait().unwrap().hits;
    let mut on_planes = 0;
    for ((ray, hit), any) in rays.iter().zip(&closest).zip(any) {
        let (t, id) =
            closest_hit(&scene, ray.origin.as_vec3(), ray.direction, ray.t_min, ray.t_max.min(stereotrace::FAR));
        assert_eq!((hit.primitive, any), (id, id != MISS), "{ray:?}: {hit:?} {t}");
        if ray.t_min == 0.0 && ray.t_max.is_infinite() {
            let (expected, primitive) = truth.closest(ray.origin, ray.direction.as_dvec3());
            assert_eq!(hit.primitive, primitive, "{ray:?}");
            let close = |t: f32| (f64::from(t) / expected - 1.0).abs() < 1e-3;
            assert!(primitive == MISS || close(hit.t), "{ray:?}: {} {expected}", hit.t);
        }
        on_planes += usize::from(scene.primitive_count() - scene.planes().len() <= id as usize && id != MISS);
    }
    assert!(on_planes > 1000, "{on_planes}");
}

#[test]
fn rays_that_begin_in_a_plane_or_run_along_it_do_not_meet_it() {
    let mut scene = Scene::new();
    scene.add_plane(Plane::new(Vec3::new(1e5, 0.0, -3e4), Vec3::Y, MaterialId(0))).unwrap();
    let renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let along = Ray::new(Vec3::Y, Vec3::new(1.0, 0.0, 0.3));
    let from_it = Ray::new(Vec3::new(5.0, 0.0, 2.0), Vec3::new(0.1, -1.0, 0.2));
    let far = Ray::new(Vec3::Y, Vec3::new(1.0, -1.01e-8, 0.0));
    let farther = Ray::new(Vec3::Y, Vec3::new(1.0, -0.99e-8, 0.0));
    let both = [along, from_it, far, farther, Ray::new(Vec3::Y, Vec3::NEG_Y).t_max(1.0)];
    let hits = renderer
        .closest_hits(&uploaded, &both)
        .wait()
        .unwrap()
        .hits
        .iter()
        .map(|hit| hit.primitive)
        .collect::<Vec<_>>();
    assert_eq!(hits, [MISS, MISS, 0, MISS, 0]);
    assert_eq!(renderer.any_hits(&uploaded, &both).wait().unwrap().hits, [false, false, true, false, true]);
}

/// An eye in a plane sees neither of its sides. Every method shows the objects there.
#[test]
fn an_eye_in_a_plane_sees_past_it() {
    let mut scene = stage(Things::Spheres, Quat::IDENTITY);
    let without = {
        let mut scene = Scene::new();
        let red = scene.add_material(stage(Things::Spheres, Quat::IDENTITY).materials()[1].clone());
        let spheres = stage(Things::Spheres, Quat::IDENTITY);
        spheres.spheres().iter().for_each(|one| {
            scene.add_sphere(Sphere::new(one.center, one.radius, red)).unwrap();
        });
        scene.sky = Sky::Constant(Vec3::ZERO);
        scene
    };
    scene.lights.clear();
    let camera = camera(Quat::IDENTITY).eye(Vec3::new(0.2, 0.0, 5.0)).target(Vec3::new(0.0, 0.3, 0.0));
    let mut renderer = renderer();
    for method in [Method::Naive, Method::BRACKET, Method::ATOMIC, Method::ES_ISLER] {
        let [with, without] = [&scene, &without].map(|scene| {
            let uploaded = renderer.upload(scene).wait().unwrap();
            let pair = renderer.pair(&uploaded, &camera).options(&Options::new(method)).read().wait().unwrap();
            (pair.left.primitive, pair.right.primitive)
        });
        assert_eq!(with, without, "{method}");
    }
}

/// A quad is so wide that its edges lie beyond the picture's horizon. Where both hits are exact, the pictures agree.
#[test]
fn a_plane_is_a_quad_a_million_units_wide() {
    let turn = tilt();
    let plane = stage(Things::Spheres, turn);
    let mut quad = Scene::new();
    for material in &plane.materials()[1..] {
        quad.add_material(material.clone());
    }
    let corners = [(-5e5, -5e5), (-5e5, 5e5), (5e5, 5e5), (5e5, -5e5)].map(|(x, z)| turn * Vec3::new(x, 0.0, z));
    quad.add_mesh(&Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])).unwrap();
    plane.spheres().iter().for_each(|&sphere| quad.add_sphere(sphere).unwrap());
    (quad.lights, quad.sky, quad.ambient) = (plane.lights.clone(), plane.sky.clone(), plane.ambient);
    let mut renderer = renderer();
    let [one, other] = [&plane, &quad].map(|scene| {
        let uploaded = renderer.upload(scene).wait().unwrap();
        renderer
            .pair(&uploaded, &camera(turn))
            .options(&Options::new(Method::Naive).linear(true))
            .read()
            .wait()
            .unwrap()
    });
    let (mut on_ground, mut depth, mut colors) = (0, 0.0_f32, 0);
    for index in 0..one.left.depth.len() {
        let there = [&one.left, &other.left].map(|view| view.depth[index]);
        if one.left.primitive[index] == 3 && there[1] < 100.0 {
            on_ground += 1;
            depth = depth.max((there[0] / there[1] - 1.0).abs());
            let [a, b] = [&one.left, &other.left].map(|view| Vec3::from_slice(&view.linear[index][..3]));
            colors += usize::from((a - b).abs().max_element() > 1e-4);
        }
    }
    println!("{on_ground} on the ground, {depth:e}, {colors} colours");
    assert!(on_ground > 2000 && depth < 2e-4 && colors <= 3, "{on_ground} {depth} {colors}");
}
