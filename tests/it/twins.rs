//! Tests kernels against their twins. A twin is independent code in plain Rust, which searches all primitives without a
//! tree.

use crate::common;

use common::{RandomScene, is_exact, random::Random, random_foliage, renderer};
use stereotrace::{
    FAR, MISS, Mesh, Method, Options, PixelSource, Rig, Scene, Sphere, StereoCamera, StereoPair,
    blocking::Wait,
    glam::Vec3,
    testing::cpu::{Eye, Frame, reproject::reproject, resolve_right::resolve_right, trace_left::trace_left},
};

fn camera(width: u32, height: u32) -> StereoCamera {
    StereoCamera::look_at(Vec3::new(0.3, 0.4, 3.0), Vec3::ZERO)
        .size(width, height)
        .vertical_fov_degrees(50.0)
        .screen_distance(3.0)
        .interaxial_pixels(width as f32 / 12.0)
}

/// Returns the number of pixels whose primitive or depth differ. On adapters that are not exact, a depth may differ by
/// 1e-5 of itself, and either of two coincident surfaces may be nearer.
fn differing(view: &stereotrace::View, twin: &[(f32, u32)], exact: bool) -> usize {
    let tolerance = if exact { 0.0 } else { 1e-5 };
    let pixels = view.depth.iter().zip(&view.primitive).zip(twin);
    let differs = |((depth, id), twin): &((&f32, &u32), &(f32, u32))| {
        (exact && **id != twin.1) || (depth.min(FAR) - twin.0).abs() > tolerance * twin.0
    };
    pixels.filter(differs).count()
}

fn check(scene: &Scene, camera: &StereoCamera) {
    let mut renderer = renderer();
    let exact = is_exact(&renderer);
    let uploaded = renderer.upload(scene).wait().unwrap();
    let naive = renderer.pair(&uploaded, camera).options(&Options::new(Method::Naive)).read().wait().unwrap();
    let frame = Frame::new(&naive.pose);
    let allowed = if exact { 0 } else { naive.source.len() / 500 };
    let [left, right] = [Eye::Left, Eye::Right].map(|eye| trace_left(scene, &frame, eye));
    for (view, twin) in [(&naive.left, &left), (&naive.right, &right)] {
        let differing = differing(view, twin, exact);
        assert!(differing <= allowed, "{differing} of {} pixels differ", twin.len());
    }

    let atomic: StereoPair =
        renderer.pair(&uploaded, camera).options(&Options::new(Method::ATOMIC)).read().wait().unwrap();
    let left_depth: Vec<f32> = left.iter().map(|(depth, _)| *depth).collect();
    let source = reproject(&frame, &left_depth);
    let fates = resolve_right(scene, &frame, &left, &source);
    let wrong = atomic.source.iter().zip(&fates).filter(|(gpu, twin)| gpu != twin).count();
    assert!(wrong <= allowed, "{wrong} of {} right pixels resolved otherwise", fates.len());
    if exact {
        let width = camera.pose().unwrap().size[0] as usize;
        for (index, fate) in fates.iter().enumerate() {
            let expected = match fate {
                PixelSource::Reused => left[index / width * width + source[index] as usize - 1],
                _ => right[index],
            };
            let found = (atomic.right.depth[index].min(FAR), atomic.right.primitive[index]);
            assert_eq!(found, expected, "pixel {index}, {fate:?}");
        }
    }
    // In the other direction, the right view is the source.
    let rig = Rig::at(*camera, vec![0.5, -0.5]).traced(vec![0]);
    let views = renderer.views(&uploaded, &rig).options(&Options::new(Method::ATOMIC)).read().wait().unwrap();
    let mirrored = Frame::between(&naive.pose, 0.5, -0.5);
    let depths: Vec<f32> = right.iter().map(|(depth, _)| *depth).collect();
    let fates = resolve_right(scene, &mirrored, &right, &reproject(&mirrored, &depths));
    let wrong = views.views[1].source.iter().zip(&fates).filter(|(gpu, twin)| gpu != twin).count();
    assert!(wrong <= allowed, "{wrong} of {} left pixels resolved otherwise", fates.len());
    let seen = left.iter().filter(|(_, id)| *id != MISS).count();
    assert!(seen > 0 || scene.primitive_count() == 0, "the test must see something");
}

#[test]
fn triangles_are_hit_as_by_brute_force() {
    check(
        &RandomScene { seed: 1, triangles: 300, spheres: 0, smooth: false, ..RandomScene::default() }.build(),
        &camera(63, 65),
    );
    check(
        &RandomScene { seed: 2, triangles: 40, spheres: 0, smooth: true, ..RandomScene::default() }.build(),
        &camera(130, 64),
    );
}

#[test]
fn spheres_are_hit_as_by_brute_force() {
    check(
        &RandomScene { seed: 3, triangles: 0, spheres: 60, smooth: false, ..RandomScene::default() }.build(),
        &camera(65, 63),
    );
}

#[test]
fn triangles_and_spheres_together_are_hit_as_by_brute_force() {
    check(
        &RandomScene { seed: 4, triangles: 150, spheres: 40, smooth: false, ..RandomScene::default() }.build(),
        &camera(64, 64),
    );
    check(
        &RandomScene { seed: 5, triangles: 150, spheres: 40, smooth: true, ..RandomScene::default() }.build(),
        &camera(71, 33),
    );
}

#[test]
fn ellipsoids_are_hit_as_by_brute_force() {
    let only = RandomScene { seed: 6, triangles: 0, spheres: 0, ellipsoids: 40, ..RandomScene::default() };
    check(&only.build(), &camera(65, 63));
    check(&RandomScene { spheres: 20, ..only }.build(), &camera(64, 64));
    for smooth in [false, true] {
        check(&RandomScene { triangles: 100, spheres: 10, smooth, ..only }.build(), &camera(71, 33));
    }
}

#[test]
fn what_is_cut_out_is_hit_as_by_brute_force() {
    for spheres in [false, true] {
        check(&random_foliage(3, spheres), &camera(75, 54));
    }
}

#[test]
fn one_triangle_one_sphere_one_pixel_and_nothing_at_all() {
    let mut triangle = Scene::new();
    triangle.add_mesh(&Mesh::new(vec![-Vec3::ONE, Vec3::new(2.0, -0.5, 0.2), Vec3::Y], vec![[0, 1, 2]])).unwrap();
    let mut sphere = Scene::new();
    let material = stereotrace::MaterialId(0);
    sphere.add_sphere(Sphere::new(Vec3::ZERO, 0.9, material)).unwrap();
    for scene in [&triangle, &sphere, &Scene::new()] {
        check(scene, &camera(1, 1));
        check(scene, &camera(33, 17));
    }
}

#[test]
fn spheres_far_from_the_origin_lose_nothing_to_their_boxes() {
    let offset = Vec3::splat(1e5);
    let mut random = Random::new(21);
    let mut scene = Scene::new();
    for _ in 0..40 {
        let center = offset + random.point(1.0);
        let material = stereotrace::MaterialId(0);
        scene.add_sphere(Sphere::new(center, random.between(0.05, 0.3), material)).unwrap();
    }
    let camera = StereoCamera::look_at(offset + 3.0 * Vec3::Z, offset).size(64, 64).interaxial(0.25);
    check(&scene, &camera);
}

#[test]
fn smooth_triangles_that_are_dropped_leave_spheres_as_they_are() {
    let mut scene =
        RandomScene { seed: 12, triangles: 0, spheres: 20, smooth: false, ..RandomScene::default() }.build();
    let mut flat = Mesh::new(vec![Vec3::ZERO, Vec3::X], vec![[0, 1, 1]]);
    flat.normals = vec![[Vec3::Y; 3]];
    scene.add_mesh(&flat).unwrap();
    check(&scene, &camera(64, 48));
}

#[test]
fn axis_parallel_rays_and_boxes_are_right() {
    // The picture has odd sides, so the central ray is exactly the axis. Walls are in planes through the eye and the
    // centre.
    let mut scene = Scene::new();
    for axis in 0..3 {
        for offset in [-1.0, -0.5, 0.0, 0.5, 1.0] {
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(u, v)| {
                let mut point = [u, v, v];
                point[(axis + 1) % 3] = u;
                point[axis] = offset;
                Vec3::from_array(point)
            });
            scene.add_mesh(&Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])).unwrap();
        }
    }
    for eye in [Vec3::new(0.0, 0.0, 4.0), Vec3::new(4.0, 0.0, 0.0), Vec3::new(0.5, 0.5, 4.0)] {
        let target = if eye.x > 1.0 { Vec3::ZERO } else { eye * Vec3::new(1.0, 1.0, 0.0) };
        let camera = StereoCamera::look_at(eye, target).size(65, 33).screen_width(2.0).interaxial(0.125);
        check(&scene, &camera);
    }
}
