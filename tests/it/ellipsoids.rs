//! Tests ellipsoids against double precision, against spheres, and each method against `Naive`.

use crate::common;
use crate::truth;

use common::{RandomScene, is_exact, random::Random, random_ellipsoid, renderer, renderer_by, traversals};
use stereotrace::{
    BvhBuild, Ellipsoid, Light, Material, MaterialId, Mesh, Method, Options, Ray, Scene, Sky, Sphere, StereoCamera,
    Update,
    blocking::Wait,
    glam::{Affine3A, Mat3, Quat, Vec3},
    scene::MAX_ASPECT,
};
use truth::{Truth, judged};

fn camera() -> StereoCamera {
    StereoCamera::look_at(Vec3::new(0.3, 0.4, 3.0), Vec3::ZERO).screen_distance(3.0).size(93, 62).interaxial_pixels(7.0)
}

/// Returns a floor, two lights, and the given ellipsoids.
fn stage(ellipsoids: &[Ellipsoid]) -> Scene {
    let mut scene = Scene::new();
    let red = scene.add_material(Material::new(Vec3::new(0.7, 0.2, 0.1)));
    let corners = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)].map(|(x, z)| Vec3::new(x, -1.5, z));
    scene.add_mesh(&Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])).unwrap();
    for one in ellipsoids {
        scene.add_ellipsoid(Ellipsoid::new(one.center, one.axes, red)).unwrap();
    }
    scene.ambient = Some(Vec3::splat(0.1));
    scene.sky = Sky::Constant(Vec3::new(0.2, 0.4, 0.9));
    scene.lights = [Vec3::new(2.0, 5.0, 3.0), Vec3::new(-4.0, 3.0, 1.0)]
        .map(|position| Light::point(position, Vec3::splat(0.4)))
        .to_vec();
    scene
}

#[test]
fn ellipsoids_with_their_shadows_are_as_by_formula() {
    let aligned = Ellipsoid::aligned(Vec3::new(0.2, -0.3, 0.0), Vec3::new(0.9, 0.3, 0.6), MaterialId(0));
    let mut random = Random::new(31);
    let many: Vec<Ellipsoid> = (0..25).map(|index| random_ellipsoid(&mut random, index % 2 == 1, 0.5)).collect();
    for scene in [stage(&[aligned]), stage(&many)] {
        for judged in judged(&mut renderer(), &scene, &camera(), 0.05) {
            println!("{judged:?}");
            assert!(judged.others <= 1 && judged.seen > 2500, "{judged:?}");
            assert!(judged.depth_by_slope < 1e-6 && judged.color < 5e-5, "{judged:?}");
        }
    }
}

#[test]
fn of_equal_axes_they_are_spheres_to_the_last_bit() {
    let only = RandomScene { seed: 8, triangles: 30, spheres: 25, ..RandomScene::default() };
    let mut renderer = renderer();
    let exact = is_exact(&renderer);
    for (scale, offset) in [(1.0, 0.0), (1e4, 0.0), (1.0, 1e4)] {
        let spheres = RandomScene { scale, offset, ..only }.build();
        let mut round = RandomScene { scale, offset, spheres: 0, ..only }.build();
        let mut some = round.clone();
        for (index, sphere) in spheres.spheres().iter().enumerate() {
            let one = Ellipsoid::aligned(sphere.center, Vec3::splat(sphere.radius), sphere.material);
            round.add_ellipsoid(one).unwrap();
            // In `some`, the first 20 primitives are spheres. Spheres precede ellipsoids, so the ids stay the same.
            if index < 20 { some.add_sphere(*sphere).unwrap() } else { some.add_ellipsoid(one).unwrap() }
        }
        let place = |v: Vec3| v * scale + Vec3::splat(offset);
        for eye in [Vec3::new(0.3, 0.4, 3.0), spheres.spheres()[0].center / scale - Vec3::splat(offset / scale)] {
            let camera = StereoCamera::look_at(place(eye), place(Vec3::splat(0.1))).size(93, 62).interaxial_pixels(7.0);
            let mut lit = [&spheres, &round, &some].map(Clone::clone);
            lit.iter_mut().for_each(|scene| scene.place_lights(2, &camera).unwrap());
            let [expected, of_round, of_some] = lit.map(|scene| {
                let uploaded = renderer.upload(&scene).wait().unwrap();
                let pair = renderer
                    .pair(&uploaded, &camera)
                    .options(&Options::new(Method::BRACKET_RAYS))
                    .read()
                    .wait()
                    .unwrap();
                (pair.left, pair.right)
            });
            assert!(expected.0.object.iter().any(|object| *object > 0));
            assert!(!exact || of_round == expected, "scale {scale}, offset {offset}, eye {eye}");
            assert!(!exact || of_some == expected, "scale {scale}, offset {offset}, eye {eye}, mixed");
        }
    }
}

/// Returns scenes that are hard for the search for a tile's primitives. They have ellipsoids of all shapes, among them
/// discs, needles, and grains of half a pixel. Some ellipsoids enclose the eyes or cross the plane of the eyes.
fn scenes() -> Vec<(String, Scene, StereoCamera)> {
    let mut scenes = Vec::new();
    for seed in 0..3 {
        let smooth = seed == 1;
        let base = RandomScene { seed: 40 + seed, ellipsoids: 30, spheres: 10, smooth, ..RandomScene::default() };
        scenes.push((format!("random {seed}"), base.build(), camera()));
        let only = RandomScene { triangles: 0, spheres: 0, ..base };
        scenes.push((format!("ellipsoids {seed}"), only.build(), camera().interaxial_pixels(20.0)));
    }
    let mut random = Random::new(17);
    let mut extreme = |radii: Vec3, count: usize, spread: f32| {
        let mut scene = Scene::new();
        for _ in 0..count {
            let turn = Mat3::from_axis_angle(random.point(1.0).normalize(), random.between(0.0, 6.0));
            let axes = turn * Mat3::from_diagonal(radii * random.between(0.5, 1.0));
            scene.add_ellipsoid(Ellipsoid::new(random.point(spread), axes, MaterialId(0))).unwrap();
        }
        scene
    };
    scenes.push(("discs".into(), extreme(Vec3::new(0.5, 0.0005, 0.5), 60, 1.0), camera()));
    scenes.push(("leaves".into(), extreme(Vec3::new(0.9, 0.0001, 0.9), 40, 1.0), camera()));
    scenes.push(("needles".into(), extreme(Vec3::new(0.002, 0.002, 1.0), 200, 1.0), camera()));
    scenes.push(("grains".into(), extreme(Vec3::new(0.012, 0.006, 0.01), 3000, 1.0), camera()));
    scenes.push(("about the eyes".into(), extreme(Vec3::new(6.0, 0.8, 3.0), 12, 3.0), camera()));
    scenes.push(("vast".into(), extreme(Vec3::new(900.0, 1.0, 1200.0), 4, 3.0), camera()));
    for (_, scene, camera) in &mut scenes {
        scene.place_lights(2, camera).unwrap();
    }
    scenes
}

#[test]
fn visibility_is_naive_s_by_every_traversal() {
    let scenes = scenes();
    for (number, traversal) in traversals().into_iter().enumerate() {
        let mut renderer = renderer_by(traversal);
        let exact = is_exact(&renderer);
        // The adapter's own traversal renders all scenes, the other traversals some of them.
        let some = scenes.iter().enumerate().filter(|(index, _)| number == 0 || index % 4 == number % 4);
        for (_, (name, scene, camera)) in some {
            let uploaded = renderer.upload(scene).wait().unwrap();
            let mut render =
                |method| renderer.pair(&uploaded, camera).options(&Options::new(method)).read().wait().unwrap();
            let naive = render(Method::Naive);
            assert!(naive.left.object.iter().any(|object| *object != stereotrace::MISS), "{name}: nothing is seen");
            for method in [Method::BRACKET_RAYS, Method::BRACKET, Method::VERIFIED] {
                let pair = render(method);
                let hits = |pair: &stereotrace::StereoPair| (pair.right.depth.clone(), pair.right.primitive.clone());
                assert!(!exact || pair.left == naive.left, "{name} {method} {traversal}");
                assert!(!exact || hits(&pair) == hits(&naive), "{name} {method} {traversal}");
                assert!(!exact || method != Method::BRACKET_RAYS || pair.right == naive.right, "{name} {traversal}");
            }
        }
    }
}

/// The search must not only find all hits but also test few primitives. Its bounds must be as tight as the projection.
#[test]
fn a_tile_s_pixels_meet_only_what_their_centres_lie_in_the_bounds_of() {
    let mut scene = Scene::new();
    for index in 0..400 {
        let center = Vec3::new((index % 20) as f32 - 9.5, (index / 20) as f32 - 9.5, 0.0) * 0.2;
        scene.add_ellipsoid(Ellipsoid::aligned(center, Vec3::new(0.09, 0.04, 0.09), MaterialId(0))).unwrap();
    }
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let camera = StereoCamera::look_at(5.0 * Vec3::Z, Vec3::ZERO).size(128, 128).interaxial_pixels(3.0);
    let pair =
        renderer.pair(&uploaded, &camera).options(&Options::new(Method::BRACKET).count(true)).read().wait().unwrap();
    let tests = pair.statistics.right.primitive_tests as f64 / 16384.0;
    println!("{tests} tests a pixel");
    // The measured number is 0.55. Each ray tests the ellipsoid at its pixel, and tiles test ellipsoids too.
    assert!(tests < 0.6, "{tests}");
}

/// Returns the largest relative error of t, times the slope, and the number of wrong hits. The rays start at these
/// origins and end at points of the ellipsoid.
fn worst_t(one: &Ellipsoid, aspect: f32, origins: &[Vec3], random: &mut Random) -> (f64, usize) {
    let mut scene = Scene::new();
    scene.add_ellipsoid(*one).unwrap();
    let renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let mut rays = Vec::new();
    for &origin in origins {
        for _ in 0..100 {
            let point = one.center + one.axes * random.point(1.0).normalize();
            rays.push(Ray::new(origin, point - origin));
        }
    }
    // A wrong hit counts only if a change of the ellipsoid's size by a hundredth does not change the hit. For aspect
    // ratios above 1000, the change is a tenth.
    let margin = if aspect > 1000.0 { 0.1 } else { 0.01 };
    let [truth, less, more] = [1.0, 1.0 - margin, 1.0 + margin].map(|scale| {
        let mut scene = Scene::new();
        scene.add_ellipsoid(Ellipsoid::new(one.center, one.axes * scale, one.material)).unwrap();
        Truth::new(&scene)
    });
    let (mut worst, mut lost) = (0.0_f64, 0);
    for (ray, hit) in rays.iter().zip(renderer.closest_hits(&uploaded, &rays).wait().unwrap().hits) {
        let [seen, less, more] = [&truth, &less, &more].map(|truth| truth.see(ray.origin.as_vec3(), ray.direction));
        if hit.primitive != seen.primitive {
            lost += usize::from(less.primitive == more.primitive);
        } else if seen.t.is_finite() {
            worst = worst.max((f64::from(hit.t) / seen.t - 1.0).abs() * seen.slope);
        }
    }
    (worst, lost)
}

#[test]
fn flat_and_thin_ones_are_met_where_they_are_from_near_and_far() {
    let mut random = Random::new(23);
    for aspect in [1.0, 10.0, 100.0, 1000.0, 0.999 * MAX_ASPECT] {
        let mut worst = [(0.0_f64, 0); 3];
        for index in 0..12 {
            let turn = Mat3::from_axis_angle(random.point(1.0).normalize(), random.between(0.0, 6.0));
            let radii = if index % 2 == 0 {
                Vec3::new(1.0, 1.0 / aspect, 1.0)
            } else {
                Vec3::new(1.0 / aspect, 1.0, 1.0 / aspect)
            };
            let one = Ellipsoid::new(random.point(2.0), turn * Mat3::from_diagonal(radii), MaterialId(0));
            for (place, away) in [0.02, 2.0, 100.0].into_iter().enumerate() {
                // Origins are outside the ellipsoid, at up to this distance from points of its surface.
                let normal = |v: Vec3| (one.axes.inverse().transpose() * v).normalize();
                let origins: Vec<Vec3> = (0..6)
                    .map(|_| {
                        let v = random.point(1.0).normalize();
                        one.center + one.axes * v + normal(v) * (away * random.between(0.2, 1.0))
                    })
                    .collect();
                let (error, lost) = worst_t(&one, aspect, &origins, &mut random);
                worst[place] = (worst[place].0.max(error), worst[place].1 + lost);
            }
        }
        println!("aspect {aspect}: near, beside, far {worst:?}");
        assert!(worst.iter().all(|(error, lost)| *error < 1e-5 && *lost == 0), "aspect {aspect}: {worst:?}");
    }
}

/// Returns how many pixels are dark and how many show the ellipsoid, in the light of one lamp. A dark pixel is shadow
/// acne if the lamp is beside the eye. Only pixels whose neighbours show the ellipsoid count.
fn dark(one: Ellipsoid, camera: &StereoCamera, lamp: Vec3) -> (usize, usize) {
    let mut scene = Scene::new();
    scene.add_ellipsoid(one).unwrap();
    scene.ambient = Some(Vec3::ZERO);
    scene.lights = vec![Light::point(lamp, Vec3::ONE)];
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let camera = camera.size(160, 120).interaxial(0.0);
    let view = renderer.pair(&uploaded, &camera).options(&Options::new(Method::Ideal)).read().wait().unwrap().left;
    let inner = (1..119).flat_map(|row| (1..159).map(move |column| row * 160 + column));
    let seen = inner.filter(|&at| [at, at - 1, at + 1, at - 160, at + 160].iter().all(|&at| view.primitive[at] == 0));
    seen.fold((0, 0), |(dark, seen), at| (dark + usize::from(view.rgba8[at][0] == 0), seen + 1))
}

#[test]
fn no_ellipsoid_shadows_what_faces_the_light() {
    for (scale, offset) in [(1.0, 0.0), (1e-3, 0.0), (1e6, 0.0), (1.0, 1e3), (1e-3, 1.0)] {
        for radii in [Vec3::new(1.0, 0.3, 0.6), Vec3::new(1.0, 0.001, 1.0), Vec3::new(0.15, 0.15, 1.0)] {
            let center = Vec3::splat(offset);
            let turn = Mat3::from_quat(Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 0.7));
            let one = Ellipsoid::new(center, turn * Mat3::from_diagonal(radii * scale), MaterialId(0));
            let camera = StereoCamera::look_at(center + Vec3::new(1.0, 2.0, 4.0) * scale, center);
            let (dark, seen) = dark(one, &camera, camera.pose().unwrap().eye.as_vec3());
            assert!(
                seen > 100 && dark == 0,
                "{radii} at {scale} and {offset}: {dark} of {seen} pixels shadow themselves"
            );
        }
    }
}

/// The world's origin is on the surface of a flat disc, between its centre and its rim. The products that give the
/// point's position then cancel.
#[test]
fn a_tilted_disc_whose_centre_is_far_does_not_shadow_itself() {
    let mut faults = Vec::new();
    for aspect in [30.0, 1000.0, 0.99 * MAX_ASPECT] {
        for (index, radius) in [1.0, 1.0, 1e5, 1e6].into_iter().enumerate() {
            let turn = Mat3::from_quat(Quat::from_axis_angle(Vec3::new(0.6, 0.3, 0.8).normalize(), 0.7 + index as f32));
            let axes = turn * Mat3::from_diagonal(Vec3::new(radius, radius / aspect, radius));
            let point = Vec3::new(0.4, 0.3_f32.sqrt(), 0.54_f32.sqrt());
            let one = Ellipsoid::new(-(axes * point), axes, MaterialId(0));
            let normal = (axes.inverse().transpose() * point).normalize();
            // Heights of the eye are multiples of the disc's thickness and fractions of its radius. At about the
            // thickness, f32 begins to be precise enough for spheres.
            for height in [0.3, 1.0, 3.0, 10.0].map(|lengths| lengths / aspect).into_iter().chain([0.03, 0.1, 0.3]) {
                let eye = normal * (height * radius);
                let camera = StereoCamera::look_at(eye, Vec3::ZERO).up(axes.x_axis).vertical_fov_degrees(30.0);
                for lamp in [1.0, 10.0] {
                    let (dark, seen) = dark(one, &camera, camera.pose().unwrap().eye.as_vec3() * lamp);
                    assert!(seen > 1000, "{seen}");
                    if dark > 0 {
                        faults.push(format!("{aspect} to 1, {radius} from {height}, lamp {lamp}: {dark} of {seen}"));
                    }
                }
            }
        }
    }
    assert!(faults.is_empty(), "pixels that shadow themselves: {faults:#?}");
}

#[test]
fn changed_ellipsoids_look_as_uploaded_anew() {
    let mut renderer = renderer();
    let mut scene = RandomScene { ellipsoids: 6, ..RandomScene::default() }.build();
    scene.place_lights(2, &camera()).unwrap();
    let first = scene.object_count() as u32 - 12;
    let mut refitted = renderer.upload(&scene).wait().unwrap();
    let mut rebuilt = renderer.upload(&scene).wait().unwrap();
    let changes: [fn(&mut Scene, u32); 3] = [
        |scene, first| {
            let shear = Mat3::from_cols(Vec3::X, Vec3::new(0.5, 2.0, 0.0), Vec3::Z);
            for object in [first, first + 1, first + 4, first + 5] {
                scene
                    .transform_object(object, &Affine3A::from_mat3_translation(shear, Vec3::new(0.3, 0.2, 0.0)))
                    .unwrap();
            }
        },
        |scene, first| {
            let near = Ellipsoid::aligned(Vec3::new(0.2, 0.3, 1.5), Vec3::new(0.4, 0.1, 0.2), MaterialId(0));
            scene.set_ellipsoid(first + 2, near).unwrap();
            scene.set_ellipsoid(first + 3, near).unwrap();
        },
        // Two ellipsoids become a large ground below the eyes, for which kernels need the second test.
        |scene, first| {
            let ground = Ellipsoid::aligned(Vec3::new(0.0, -1001.0, 0.0), Vec3::new(9e5, 1e3, 9e5), MaterialId(0));
            scene.set_ellipsoid(first + 4, ground).unwrap();
            scene.set_ellipsoid(first + 5, ground).unwrap();
        },
    ];
    for (number, change) in changes.into_iter().enumerate() {
        change(&mut scene, first);
        renderer.update(&mut refitted, &scene, Update::Refit).wait().unwrap();
        renderer.update(&mut rebuilt, &scene, Update::Rebuild(BvhBuild::Fast)).wait().unwrap();
        let new = renderer.upload(&scene).wait().unwrap();
        for method in [Method::Naive, Method::BRACKET] {
            let mut shown = |uploaded| {
                let pair = renderer
                    .pair(uploaded, &camera())
                    .options(&Options::new(method).linear(true))
                    .read()
                    .wait()
                    .unwrap();
                (pair.left, pair.right)
            };
            let expected = shown(&new);
            assert!(shown(&refitted) == expected && shown(&rebuilt) == expected, "change {number}, {method}");
        }
    }
    scene.add_ellipsoid(scene.ellipsoids()[0]).unwrap();
    let message = renderer.update(&mut refitted, &scene, Update::Refit).wait().unwrap_err().to_string();
    assert!(message.contains("40 spheres and 12 ellipsoids, but the scene now has"), "{message}");
    scene.add_sphere(Sphere::new(Vec3::ZERO, 0.1, MaterialId(0))).unwrap();
    renderer.update(&mut refitted, &scene, Update::Rebuild(BvhBuild::Fast)).wait().unwrap();
}
