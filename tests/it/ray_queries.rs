//! Tests ray queries on adapters that have them: they find what the kernels' own traversal finds.

use crate::common;

use common::{Lent, cases, renderer, renderer_by, scenes_with, skipped};
use stereotrace::{
    AmbientOcclusion, Builtin, BvhBuild, Error, Gpu, Light, Lighting, Material, Method, Options, Plane, Renderer,
    Scene, Sphere, StereoCamera, StereoPair, Tracing, Traversal, Update, UploadedScene, View,
    blocking::Wait,
    glam::{Affine3A, Vec3},
    testing::suite::Trial,
};

/// Returns renderers that trace by ray queries and by kernels. Without ray queries, says that a test is skipped.
fn both() -> Option<[Lent; 2]> {
    let gpu = common::gpu();
    if !gpu.has_ray_queries() {
        skipped("no ray queries: run `sh scripts/check_ray_queries.sh`");
        return None;
    }
    let usual = Traversal::of(&gpu);
    assert_eq!(usual.tracing, Tracing::RayQueries);
    Some([renderer(), renderer_by(usual.tracing(Tracing::Kernels))])
}

fn render(renderer: &mut Renderer, scene: &UploadedScene, camera: &StereoCamera, options: &Options) -> StereoPair {
    renderer.pair(scene, camera).options(options).read().wait().unwrap()
}

/// Returns the number of pixels of two views that differ in primitive, depth or colour.
fn differing(a: &View, b: &View) -> usize {
    let differs = |at: &usize| {
        (a.primitive[*at], a.depth[*at].to_bits(), a.rgba8[*at])
            != (b.primitive[*at], b.depth[*at].to_bits(), b.rgba8[*at])
    };
    (0..a.primitive.len()).filter(differs).count()
}

/// Asserts that with queries `bracket` and `bracket-rays` find what `naive` finds. Returns the number of pixels in
/// which queries find something else than kernels.
fn differs(renderers: &mut [Lent; 2], name: &str, scene: &Scene, camera: &StereoCamera) -> usize {
    let [queries, kernels] = renderers.each_mut().map(|renderer| {
        let uploaded = renderer.upload(scene).wait().unwrap();
        let pair = render(renderer, &uploaded, camera, &Options::new(Method::Naive));
        (uploaded, pair)
    });
    let ((uploaded, naive), (_, by_kernels)) = (queries, kernels);
    let off = [(&naive.left, &by_kernels.left), (&naive.right, &by_kernels.right)].map(|(a, b)| differing(a, b));
    println!("{name}: {off:?} of {} pixels differ", naive.left.primitive.len());
    let rays = render(&mut renderers[0], &uploaded, camera, &Options::new(Method::BRACKET_RAYS));
    assert!(rays.right == naive.right, "{name}: bracket-rays is not naive");
    let bracket = render(&mut renderers[0], &uploaded, camera, &Options::new(Method::BRACKET));
    assert!(bracket.right.primitive == naive.right.primitive, "{name}: bracket shows a wrong surface");
    off.iter().sum()
}

#[test]
fn built_in_scenes_are_seen_as_by_kernels() {
    let Some(mut renderers) = both() else { return };
    for builtin in cases(Builtin::ALL.iter().copied(), 4) {
        assert_eq!(differs(&mut renderers, builtin.name(), &builtin.scene(), &builtin.camera(120, 90)), 0, "{builtin}");
    }
}

#[test]
fn the_suite_is_seen_as_by_kernels() {
    let Some(mut renderers) = both() else { return };
    let of = |trial: &Trial| differs(&mut renderers, trial.name(), &trial.scene(), &trial.camera(120, 90));
    let all: Vec<usize> = cases(Trial::ALL, 4).into_iter().map(of).collect();
    assert_eq!(all.iter().sum::<usize>(), 0, "{all:?}");
}

#[test]
fn real_scenes_are_seen_as_by_kernels() {
    let Some(mut renderers) = both() else { return };
    for name in cases(["sponza_4x", "sponza", "cornell", "dragon", "teapot", "bunny", "spot"], 3) {
        let Some(folder) = scenes_with(&format!("{name}/{name}.obj")) else { continue };
        let mut scene = Scene::from_obj(folder.join(name).join(format!("{name}.obj"))).unwrap();
        let camera = StereoCamera::from_json(folder.join("cameras.json"), name, 160, 120).unwrap();
        scene.place_lights(2, &camera).unwrap();
        assert_eq!(differs(&mut renderers, name, &scene, &camera), 0, "{name}");
    }
}

/// Mirrors, glass, soft light, occlusion and paths trace other rays than those of eyes and point lights.
#[test]
fn all_light_is_as_by_kernels() {
    let Some(mut renderers) = both() else { return };
    let linear = Options::new(Method::Naive).linear(true).seed(3);
    let soft = linear.clone().shadow_rays(4).ambient_occlusion(AmbientOcclusion::new(4, 2.0));
    let paths = linear.clone().lighting(Lighting::Paths { bounces: 3, samples: 2 });
    let (hall, spheres) = (Builtin::HallFinished, Builtin::ThreeSpheresMirrors);
    for (builtin, options) in cases([(hall, &soft), (hall, &paths), (spheres, &soft), (spheres, &paths)], 3) {
        let mut scene = builtin.scene();
        scene.lights.push(Light::sphere(Vec3::new(2.0, 5.0, 1.0), 0.3, Vec3::splat(0.3)));
        let [queries, kernels] = renderers.each_mut().map(|renderer| {
            let uploaded = renderer.upload(&scene).wait().unwrap();
            render(renderer, &uploaded, &builtin.camera(60, 45), options)
        });
        let off = queries.left.linear.iter().zip(&kernels.left.linear).filter(|(a, b)| a != b).count();
        assert!(queries.left == kernels.left, "{builtin}: {off} pixels differ");
        assert!(queries.right == kernels.right, "{builtin}");
    }
}

#[test]
fn what_has_moved_is_found_where_it_is() {
    let Some(mut renderers) = both() else { return };
    for builtin in [Builtin::Fence, Builtin::Hall] {
        for how in [Update::Refit, Update::Rebuild(BvhBuild::Fast)] {
            let [queries, kernels] = renderers.each_mut().map(|renderer| {
                let mut scene = builtin.scene();
                let mut uploaded = renderer.upload(&scene).wait().unwrap();
                scene.transform_object(0, &Affine3A::from_translation(Vec3::new(0.1, 0.3, -0.2))).unwrap();
                renderer.update(&mut uploaded, &scene, how).wait().unwrap();
                render(renderer, &uploaded, &builtin.camera(80, 60), &Options::new(Method::Naive))
            });
            let off = [(&queries.left, &kernels.left), (&queries.right, &kernels.right)].map(|(a, b)| differing(a, b));
            assert_eq!(off, [0, 0], "{builtin}, {how:?}");
        }
    }
}

#[test]
fn scenes_that_get_their_first_primitive_by_an_update_use_queries() {
    let Some([queries, _]) = both() else { return };
    let mut scene = Scene::new();
    let material = scene.add_material(Material::new(Vec3::ONE));
    scene.add_plane(Plane::new(Vec3::ZERO, Vec3::Y, material)).unwrap();
    let mut uploaded = queries.upload(&scene).wait().unwrap();
    assert_eq!(uploaded.traversal().tracing, Tracing::Kernels);
    scene.add_sphere(Sphere::new(Vec3::Y, 0.5, material)).unwrap();
    queries.update(&mut uploaded, &scene, Update::RefitOrRebuild).wait().unwrap();
    assert_eq!(uploaded.traversal().tracing, Tracing::RayQueries);
}

#[test]
fn an_adapter_without_ray_queries_is_an_error_that_names_it() {
    let wanted = std::env::var("STEREOTRACE_ADAPTER").unwrap_or_else(|_| "software".into());
    match Gpu::open_with_ray_queries(wanted.as_str()).wait() {
        Ok(gpu) => assert!(gpu.has_ray_queries()),
        Err(error) => {
            let message = error.to_string();
            assert!(matches!(error, Error::NoAdapter { .. }), "{message}");
            assert!(message.contains("with ray queries") && message.contains(" has none"), "{message}");
        }
    }
}
