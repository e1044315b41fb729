//! Tests scenes that change after the upload: their pictures must equal the pictures of the same scene uploaded anew.

use crate::common;

use common::{ball, gpu, own_gpu, renderer, renderer_by};
use stereotrace::{
    Boxes, BvhBuild, Error, Fetch, Light, Material, MaterialId, Mesh, Method, Options, RaysPerLane, Renderer, Scene,
    Sky, SkyMap, Sphere, StereoCamera, Traversal, Update,
    blocking::Wait,
    glam::{Affine3A, Quat, Vec3},
};

/// A change of a scene, with its name.
type Change = (&'static str, fn(&mut Scene));

/// Ids of the objects of [`scene`].
const GROUND: u32 = 0;
const FLAT: u32 = 1;
const SMOOTH: u32 = 2;
const FIRST_SPHERE: u32 = 3;

fn flat() -> Mesh {
    ball(Vec3::new(-0.8, 0.1, 0.0), 0.6, 6)
}

fn smooth() -> Mesh {
    let mesh = ball(Vec3::new(0.7, 0.0, 0.3), 0.5, 8);
    let normal = |corner: u32| (mesh.positions[corner as usize] - Vec3::new(0.7, 0.0, 0.3)).normalize();
    let normals = mesh.triangles.iter().map(|corners| corners.map(normal)).collect();
    mesh.normals(normals)
}

fn ground() -> Mesh {
    let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, z)| Vec3::new(4.0 * x, -0.7, 4.0 * z));
    Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3], [1, 1, 2]])
}

fn camera() -> StereoCamera {
    StereoCamera::look_at(Vec3::new(0.0, 0.5, 5.0), Vec3::ZERO).screen_distance(5.0).size(50, 37).interaxial_pixels(6.0)
}

/// Returns a ground with a triangle without area, a flat and a smooth ball, spheres, and two lights.
fn scene() -> Scene {
    let mut scene = Scene::new();
    let red = scene.add_material(Material::new(Vec3::new(0.8, 0.2, 0.1)));
    for mesh in [ground(), flat().materials(vec![red]), smooth()] {
        scene.add_mesh(&mesh).unwrap();
    }
    for index in 0..12 {
        let at = Vec3::new(0.4 * index as f32 - 2.2, 0.8 - 0.1 * (index % 3) as f32, -0.5);
        scene.add_sphere(Sphere::new(at, 0.2, if index % 2 == 0 { red } else { MaterialId(0) })).unwrap();
    }
    scene.place_lights(2, &camera()).unwrap();
    scene
}

fn shift(x: f32, y: f32, z: f32) -> Affine3A {
    Affine3A::from_translation(Vec3::new(x, y, z))
}

fn about(center: Vec3, transform: Affine3A) -> Affine3A {
    Affine3A::from_translation(center) * transform * Affine3A::from_translation(-center)
}

/// Successive changes that a refit can follow. The first five need no other kernels.
const CHANGES: &[Change] = &[
    ("nothing", |_| {}),
    ("a ball moves", |scene| scene.transform_object(FLAT, &shift(0.3, 0.2, 0.4)).unwrap()),
    ("two balls touch", |scene| {
        let turn = Affine3A::from_scale_rotation_translation(Vec3::splat(1.3), Quat::from_rotation_z(0.5), Vec3::ZERO);
        scene.transform_object(SMOOTH, &about(Vec3::new(0.7, 0.0, 0.3), turn)).unwrap();
    }),
    ("a sphere leaves the bounds", |scene| {
        scene.transform_object(FIRST_SPHERE + 4, &shift(0.0, 30.0, -90.0)).unwrap();
        let near = Affine3A::from_scale_rotation_translation(Vec3::splat(2.0), Quat::IDENTITY, 0.6 * Vec3::Z);
        scene.transform_object(FIRST_SPHERE + 7, &near).unwrap();
    }),
    ("a ball shrinks to a point", |scene| {
        scene.transform_object(FLAT, &about(Vec3::new(0.0, 9.0, 0.0), Affine3A::from_scale(Vec3::ZERO))).unwrap();
    }),
    ("lights, sky and materials change", |scene| {
        scene.lights.push(Light::point(Vec3::new(-2.0, 3.0, 1.0), Vec3::splat(0.3)));
        scene.lights[0].position.x += 1.0;
        scene.sky = Sky::Gradient { nadir: Vec3::splat(0.1), zenith: Vec3::new(0.2, 0.4, 0.8) };
        scene.set_material(MaterialId(1), Material::new(Vec3::new(0.1, 0.7, 0.2))).unwrap();
    }),
    ("the smooth ball becomes a line, and no normals are left", |scene| {
        scene.transform_object(SMOOTH, &Affine3A::from_scale(Vec3::new(1.0, 0.0, 0.0))).unwrap();
        assert!(!scene.has_normals());
    }),
    ("no triangle is left", |scene| {
        scene.transform_object(GROUND, &Affine3A::from_scale(Vec3::ZERO)).unwrap();
    }),
    ("all are back", |scene| {
        for (object, mesh) in [(GROUND, ground()), (FLAT, flat()), (SMOOTH, smooth())] {
            scene.set_mesh(object, &mesh).unwrap();
        }
    }),
    ("one lies flat", |scene| {
        let flat = about(-0.3 * Vec3::Y, Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0)));
        scene.transform_object(FLAT, &flat).unwrap();
    }),
    ("two primitives become the same", |scene| {
        scene.set_sphere(FIRST_SPHERE + 2, scene.spheres()[1]).unwrap();
    }),
    ("boxes get world coordinates, and shadow rays another direction", |scene| {
        scene.transform_object(GROUND, &Affine3A::from_scale(Vec3::new(1e7, 1.0, 1e7))).unwrap();
        scene.lights[0].position.y = 9e7;
    }),
    ("a large ground under the eyes", |scene| {
        scene.transform_object(GROUND, &shift(0.0, 1.15, 0.0)).unwrap();
    }),
];

/// Returns both views by a method, with linear colours.
fn shown(renderer: &mut Renderer, scene: &stereotrace::UploadedScene, method: Method) -> impl PartialEq + use<> {
    let pair = renderer.pair(scene, &camera()).options(&Options::new(method).linear(true)).read().wait().unwrap();
    (pair.left, pair.right)
}

fn assert_as_new(
    renderer: &mut Renderer,
    uploaded: &stereotrace::UploadedScene,
    scene: &Scene,
    methods: &[Method],
    what: &str,
) {
    let new = renderer.upload(scene).wait().unwrap();
    for &method in methods {
        let (found, expected) = (shown(renderer, uploaded, method), shown(renderer, &new, method));
        assert!(found == expected, "{what}: {method}");
    }
    let (found, expected) = (uploaded.info(), new.info());
    assert_eq!(found.dropped_triangles, expected.dropped_triangles, "{what}");
}

const SAME_KERNELS: usize = 5;

/// Applies changes and compares after each of them.
fn go_through(changes: &[Change], traversal: Traversal, methods: &[Method]) {
    let mut renderer = renderer_by(traversal);
    let mut scene = scene();
    let hows = [Update::Refit, Update::Rebuild(BvhBuild::Fast)];
    let mut states = hows.map(|how| (how, renderer.upload(&scene).wait().unwrap()));
    for (name, change) in changes {
        change(&mut scene);
        for (how, uploaded) in &mut states {
            renderer.update(uploaded, &scene, *how).wait().unwrap();
            assert_as_new(&mut renderer, uploaded, &scene, methods, &format!("{name}, {how:?}, {traversal}"));
        }
    }
}

#[test]
fn by_every_method_a_changed_scene_looks_as_uploaded_anew() {
    go_through(&CHANGES[..SAME_KERNELS], Traversal::of(&gpu()), Method::ALL);
}

#[test]
fn whatever_changes_a_scene_looks_as_uploaded_anew() {
    go_through(CHANGES, Traversal::of(&gpu()), &[Method::Naive, Method::BRACKET]);
}

#[test]
fn by_every_way_to_read_it_a_changed_scene_looks_as_uploaded_anew() {
    let of = |fetch, boxes, rays| Traversal::of(&gpu()).fetch(fetch).boxes(boxes).rays(rays);
    go_through(CHANGES, of(Fetch::Buffer, Boxes::Grid16, RaysPerLane::One), &[Method::Naive]);
    for traversal in
        [of(Fetch::Texture, Boxes::Grid16, RaysPerLane::Four), of(Fetch::Buffer, Boxes::F32, RaysPerLane::Four)]
    {
        go_through(&CHANGES[..SAME_KERNELS], traversal, &[Method::Naive, Method::BRACKET]);
    }
}

/// The scene grows and shrinks across the ends of texture rows, with and without spare room.
#[test]
fn a_scene_that_grows_and_shrinks_is_rebuilt_into_what_room_there_is() {
    let mut renderer = renderer();
    let (mut scene, mut skies) =
        (scene(), [64, 256].map(|width| Sky::Map(SkyMap::procedural(width).unwrap())).into_iter());
    let mut uploaded = renderer.upload(&scene).wait().unwrap();
    let mut update = |scene: &Scene, how, what: &str| {
        renderer.update(&mut uploaded, scene, how).wait().unwrap();
        assert_as_new(&mut renderer, &uploaded, scene, &[Method::Naive, Method::BRACKET], what);
    };
    let build = Update::Rebuild(BvhBuild::Balanced);
    for rings in [30, 90, 3] {
        scene.set_mesh(FLAT, &ball(Vec3::new(-0.8, 0.1, 0.0), 0.6, rings)).unwrap();
        update(&scene, build, &format!("{rings} rings"));
    }
    scene.sky = skies.next().unwrap();
    update(&scene, Update::Refit, "a sky map");
    scene.lights[0].intensity *= 0.5;
    update(&scene, Update::Refit, "a light beside the same map");
    scene.transform_object(SMOOTH, &shift(0.0, 0.1, 0.0)).unwrap();
    scene.lights.pop();
    update(&scene, Update::Refit, "the same map elsewhere");
    scene.sky = skies.next().unwrap();
    update(&scene, Update::Refit, "a larger map");
    scene.add_sphere(Sphere::new(Vec3::Y, 0.1, MaterialId(0))).unwrap();
    scene.sky = Sky::Constant(Vec3::ONE);
    update(&scene, build, "one sphere more");
    scene.lights.clear();
    update(&scene, Update::Refit, "no light");
    update(&Scene::new(), build, "nothing left");
    update(&scene, build, "all back");
}

/// A change that a refit can't follow, and the reason in its error.
type Refused = (fn(&mut Scene), &'static str);

fn refusal(result: Result<(), Error>) -> String {
    let message = result.unwrap_err().to_string();
    assert!(message.starts_with("invalid scene: ") && message.ends_with("use Update::Rebuild"), "{message}");
    message
}

#[test]
fn a_refit_refuses_what_its_tree_does_not_hold_and_leaves_the_scene_as_it_was() {
    let mut renderer = renderer();
    let before = scene();
    let mut uploaded = renderer.upload(&before).wait().unwrap();
    let cases: [Refused; 3] = [
        (
            |scene| scene.add_sphere(Sphere::new(Vec3::ZERO, 1.0, MaterialId(0))).unwrap(),
            "12 spheres, but the scene now has",
        ),
        (|scene| scene.set_mesh(FLAT, &ball(Vec3::ZERO, 1.0, 3)).unwrap(), "triangles and 12 spheres"),
        (
            |scene| {
                let mut mesh = ground();
                mesh.triangles[2] = [1, 2, 3];
                scene.set_mesh(GROUND, &mesh).unwrap();
            },
            "triangle 2: the tree to refit does not contain it, because it had no area",
        ),
    ];
    for (change, words) in cases {
        let mut changed = before.clone();
        change(&mut changed);
        let message = refusal(renderer.update(&mut uploaded, &changed, Update::Refit).wait());
        assert!(message.contains(words), "{message}");
        assert_as_new(&mut renderer, &uploaded, &before, &[Method::Naive], words);
        let mut rebuilt = renderer.upload(&before).wait().unwrap();
        renderer.update(&mut rebuilt, &changed, Update::Rebuild(BvhBuild::Balanced)).wait().unwrap();
        assert_as_new(&mut renderer, &rebuilt, &changed, &[Method::Naive], words);
    }
}

/// Exact copies are left out of the tree. They may move with their original, but not away from it.
#[test]
fn copies_are_refitted_as_long_as_they_are_copies() {
    let mut renderer = renderer();
    let mut scene = scene();
    scene.add_mesh(&flat()).unwrap();
    let copy = SMOOTH + 1;
    let mut uploaded = renderer.upload(&scene).wait().unwrap();
    for object in [FLAT, copy] {
        scene.transform_object(object, &shift(0.3, 0.4, 0.5)).unwrap();
    }
    renderer.update(&mut uploaded, &scene, Update::Refit).wait().unwrap();
    assert_as_new(&mut renderer, &uploaded, &scene, &[Method::Naive, Method::BRACKET], "both move");
    scene.transform_object(copy, &shift(0.0, 0.0, 0.01)).unwrap();
    let message = refusal(renderer.update(&mut uploaded, &scene, Update::Refit).wait());
    assert!(message.contains("because it was an exact copy of primitive "), "{message}");
    // A copy that has lost its area need not be where its original is.
    scene.transform_object(copy, &Affine3A::from_scale(Vec3::ZERO)).unwrap();
    renderer.update(&mut uploaded, &scene, Update::Refit).wait().unwrap();
    assert_as_new(&mut renderer, &uploaded, &scene, &[Method::Naive, Method::BRACKET], "the copy shrinks");
    // It returns elsewhere, which the tree can't follow.
    scene.set_mesh(copy, &flat()).unwrap();
    scene.transform_object(copy, &shift(0.3, 0.4, 0.9)).unwrap();
    refusal(renderer.update(&mut uploaded, &scene, Update::Refit).wait());
    renderer.update(&mut uploaded, &scene, Update::RefitOrRebuild).wait().unwrap();
    assert_as_new(&mut renderer, &uploaded, &scene, &[Method::Naive, Method::BRACKET], "the copy returns");
}

#[test]
fn what_is_wrong_with_a_scene_or_its_device_is_said_by_an_update_too() {
    let renderer = renderer();
    let mut scene = scene();
    let mut uploaded = renderer.upload(&scene).wait().unwrap();
    let other = Renderer::new(own_gpu());
    assert!(matches!(other.update(&mut uploaded, &scene, Update::Refit).wait(), Err(Error::ForeignScene)));
    scene.lights[0].intensity.x = f32::NAN;
    for how in [Update::Refit, Update::Rebuild(BvhBuild::Fast)] {
        let message = renderer.update(&mut uploaded, &scene, how).wait().unwrap_err().to_string();
        assert!(message.contains("light 0"), "{message}");
    }
}
