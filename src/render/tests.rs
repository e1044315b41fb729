use crate::blocking::Wait;
use std::{num::NonZeroU32, ops::ControlFlow};

use glam::Vec3;

use crate::{
    BufferDepth, Calibration, Check, Equirectangular, Error, Finish, GBuffer, Gpu, Light, Lighting, Material, Method,
    Options, Plane, PoleMerge, Progress, Projection, Renderer, Rows, Scene, Sky, SkyMap, Span, Sphere, Statistics,
    StereoCamera, StereoPair, Texture, Traversal, UploadedScene, Visibility,
    frame::{
        Bands,
        driver::{Driver, Setting},
        history::Recall,
        plan::{Search, Stage},
        targets::Shape,
        wanted::{Mask, Part, Wanted},
    },
    kernel::Resource,
    kernel::layout,
    methods,
    random::Random,
    truth::occlusion::Pixels,
    view::camera::Intrinsics,
    view::rig::Eyes,
};

#[test]
fn the_parts_that_rows_are_dealt_to_change_no_picture() {
    let builtin = crate::scene::builtin::Builtin::Hall;
    let mut renderer = renderer(USUAL);
    let uploaded = renderer.upload(&builtin.scene()).wait().unwrap();
    for size in [[130, 71], [77, 8], [65, 200]] {
        let camera = builtin.camera(size[0], size[1]);
        for method in [Method::Naive, Method::ATOMIC, Method::BRACKET] {
            let [expected, dealt @ ..] = [1, 2, 3, 32].map(|runs| {
                renderer.runs = runs;
                let pair = renderer.pair(&uploaded, &camera).options(&Options::new(method)).read().wait().unwrap();
                StereoPair { statistics: Statistics { times: None, ..pair.statistics }, ..pair }
            });
            assert!(dealt.iter().all(|pair| *pair == expected), "{method} {size:?}");
        }
    }
}

const USUAL: u32 = 1 << 18;

fn renderer(band_pixels: u32) -> Renderer {
    let mut renderer = Renderer::new(Gpu::under_test());
    renderer.band_pixels = band_pixels;
    renderer
}

#[test]
fn bands_change_nothing_but_the_number_of_dispatches() {
    let builtin = crate::scene::builtin::Builtin::Hall;
    let camera = builtin.camera(130, 271);
    let mut renderer = renderer(USUAL);
    let uploaded = renderer.upload(&builtin.scene()).wait().unwrap();
    // Counting kernels trace one ray per lane. The search of tiles is also tested without counting.
    let shipped = [Method::BRACKET, Method::VERIFIED, Method::BRACKET_RAYS];
    let all = Method::ALL.iter().copied().chain(["buffer-edges".parse().unwrap(), "buffer-3".parse().unwrap()]);
    let counted = all.map(|method| Options::new(method).count(true).cost_map(true).linear(true));
    let paths = Options::new(Method::BRACKET).lighting(Lighting::Paths { bounces: 2, samples: 2 }).linear(true);
    for options in counted.chain(shipped.map(Options::new)).chain([paths]) {
        let method = options.method;
        let [whole, banded] = [USUAL, 130 * 64].map(|band_pixels| {
            renderer.band_pixels = band_pixels;
            let mut calls = 0;
            let mut count = |_| {
                calls += 1;
                ControlFlow::Continue(())
            };
            let mut pair =
                renderer.pair(&uploaded, &camera).options(&options).progress(&mut count).read().wait().unwrap();
            pair.statistics.times = None;
            pair.statistics.intermediate_bytes = 0;
            pair.statistics.buffer_depth = 0; // a band's may be smaller
            (pair, calls)
        });
        let [(a, _), (b, _)] = [&whole, &banded];
        assert_eq!(a.statistics, b.statistics, "{method}");
        assert!(whole.0 == banded.0, "{method}");
        // The many steps of paths are submitted in two parts per band of the usual size, and each reports progress.
        let parts = if options.follows_paths() { 2 } else { 1 };
        assert_eq!([whole.1, banded.1], [1, 5 * parts], "{method}");
    }
}

#[test]
fn every_traversal_gives_the_same_pair() {
    use crate::scene::builtin::Builtin;
    let spheres_and_triangles = Builtin::Near;
    for builtin in [Builtin::Hall, Builtin::Spheres, spheres_and_triangles] {
        let camera = builtin.camera(65, 40);
        let pairs = Vec::from_iter(Traversal::ALL.iter().map(|&traversal| {
            let mut renderer = Renderer::with_traversal(renderer(USUAL).gpu, traversal);
            let uploaded = renderer.upload(&builtin.scene()).wait().unwrap();
            let mut pair = renderer.pair(&uploaded, &camera).read().wait().unwrap();
            // The traversal determines which of several occluders is kept, and thus how many rays it saves.
            pair.statistics = Statistics::default();
            pair
        }));
        // Other adapters contract operations of one kernel and not of another.
        let is_exact = renderer(USUAL).gpu.is_exact();
        for (traversal, pair) in Traversal::ALL.iter().zip(&pairs) {
            let differing = pair.right.primitive.iter().zip(&pairs[0].right.primitive).filter(|(a, b)| a != b).count();
            assert!(differing * 100 <= pair.right.primitive.len(), "{builtin} {traversal:?}: {differing}");
            assert!(!is_exact || *pair == pairs[0], "{builtin} {traversal:?}");
        }
    }
}

#[test]
fn a_tile_searched_by_a_workgroup_has_the_lists_of_one_searched_by_a_thread() {
    let rendered = |builtin: crate::scene::builtin::Builtin, method: Method, searches_together: bool| {
        let mut renderer = renderer(USUAL);
        renderer.searches_together = searches_together;
        let uploaded = renderer.upload(&builtin.scene()).wait().unwrap();
        let camera = builtin.camera(165, 100);
        let options = Options::new(method).count(true).cost_map(true);
        let mut pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
        pair.statistics.times = None;
        pair
    };
    // Tiles that are given up are not searched in the same order to the end.
    let cost = |pair: &crate::StereoPair| pair.statistics.right.cost() as f64;
    for name in ["hall", "spheres", "fence", "near", "grazing", "random-1000"] {
        let builtin = name.parse().unwrap();
        for method in [Method::BRACKET, Method::Auto] {
            let [together, alone] = [true, false].map(|together| rendered(builtin, method, together));
            assert!((cost(&together) / cost(&alone) - 1.0).abs() < 0.02, "{name}, {method}");
            assert_eq!(together.statistics.right.rays, alone.statistics.right.rays, "{name}, {method}");
            let views =
                |pair: crate::StereoPair| (pair.left.rgba8, pair.right.rgba8, pair.right.primitive, pair.source);
            assert!(views(together) == views(alone), "{name}, {method}");
        }
    }
}

#[test]
fn auto_chooses_by_the_calibration() {
    let builtin = crate::scene::builtin::Builtin::Near;
    let (mut renderer, camera) = (renderer(USUAL), builtin.camera(80, 60));
    let uploaded = renderer.upload(&builtin.scene()).wait().unwrap();
    let choice = |renderer: &mut Renderer| {
        let pair = renderer.pair(&uploaded, &camera).options(&Options::new(Method::Auto)).trace().wait().unwrap();
        pair.choice.unwrap()
    };
    let usual = renderer.calibration();
    for (search, method) in [(0.0, Method::BRACKET), (1e6, Method::Naive), (usual.search, Method::BRACKET)] {
        renderer.set_calibration(Calibration { search, ..usual });
        assert_eq!(choice(&mut renderer).method, method, "{search}");
    }
    // A calibration measures what `Auto` sees.
    let found = renderer.calibrate().wait().unwrap();
    assert!(found.search.abs() < 20.0 && found.shadow >= 0.1 && found.shadow <= 1.0, "{found:?}");
    assert_eq!(renderer.calibration(), found);
    let on_it = renderer.calibrate_on(&uploaded, &camera, &Options::default()).wait().unwrap();
    assert_eq!((renderer.calibration(), on_it.shadow), (on_it, found.shadow));
    let chosen = choice(&mut renderer);
    let cheaper = if chosen.bracket < chosen.naive { Method::BRACKET } else { Method::Naive };
    assert_eq!(chosen.method, cheaper, "{chosen}");
    // Eyes without common rows have one method.
    let toed_in = camera.projection(Projection::ToeIn);
    assert_eq!(renderer.calibrate_on(&uploaded, &toed_in, &Options::default()).wait().unwrap(), on_it);
}

/// Returns balls of glass in a ball of glass, a veil and a mirror under lights. Many pixels have more rays than there
/// are rounds.
fn glass_in_glass() -> (Scene, StereoCamera) {
    let mut scene = Scene::new();
    let clear = Finish::Glass { index: 1.3, transmission: Vec3::new(0.97, 0.99, 1.0), fresnel: false };
    let glass = scene.add_material(Material::new(Vec3::ZERO).specular(Vec3::splat(0.4)).finish(clear));
    let silver = Material::new(Vec3::splat(0.1)).specular(Vec3::splat(0.8));
    let silver = scene.add_material(silver.finish(Finish::Mirror { fresnel: true }));
    let veil = scene.add_material(Material::new(Vec3::X).opacity(0.4).specular(Vec3::splat(0.5)));
    let clear_veil = Material::new(Vec3::ZERO).opacity(0.5).specular(Vec3::splat(0.3));
    let clear_veil = scene.add_material(clear_veil.finish(clear));
    let mut random = Random::new(3);
    let specks = (0..64 * 64).map(|_| [200, 90, 40, random.below(256) as u8]).collect();
    let specks = scene.add_texture(Texture::image(64, 64, specks).unwrap());
    let specked = scene.add_material(Material::new(Vec3::ONE).texture(specks).alpha_blend(true));
    scene.add_sphere(Sphere::new(Vec3::new(0.0, 2.3, 1.0), 0.8, specked)).unwrap();
    scene.add_sphere(Sphere::new(Vec3::ZERO, 2.2, glass)).unwrap();
    for index in 0..27 {
        let place = [index % 3, index / 3 % 3, index / 9].map(|axis| axis as f32 - 1.0);
        let material = [glass, silver, glass, veil, clear_veil][index % 5];
        scene.add_sphere(Sphere::new(Vec3::from(place), 0.45, material)).unwrap();
    }
    let ground = scene.add_material(Material::new(Vec3::splat(0.6)));
    scene.add_plane(Plane::new(-2.3 * Vec3::Y, Vec3::Y, ground)).unwrap();
    scene.lights = vec![
        Light::point(Vec3::new(3.0, 5.0, 4.0), Vec3::splat(0.6)),
        Light::sphere(Vec3::new(-3.0, 4.0, 3.0), 0.5, Vec3::splat(0.5)),
    ];
    (scene, StereoCamera::look_at(6.0 * Vec3::Z, Vec3::ZERO).interaxial_pixels(5.0))
}

#[test]
fn secondary_rays_in_rounds_bring_what_they_bring_at_once() {
    let of = |builtin: crate::scene::builtin::Builtin| (builtin.scene(), builtin.camera(64, 48));
    let [glass, hall, random] =
        [glass_in_glass(), of("hall-finished".parse().unwrap()), of("random-125-both".parse().unwrap())];
    let deep = |method| Options::new(method).bounces(8);
    let occluded = deep(Method::BRACKET).ambient_occlusion(Some(crate::AmbientOcclusion::new(4, 1.0)));
    let cases = [
        (&glass, Traversal::GPU, deep(Method::BRACKET).linear(true)),
        (&glass, Traversal::ALL[0], deep(Method::Naive).count(true).cost_map(true)),
        (&glass, Traversal::ALL[0], occluded.samples(4).linear(true)),
        (&glass, Traversal::ALL[0], Options::new(Method::ATOMIC).bounces(1)),
        (&glass, Traversal::ALL[0], Options::new(Method::Auto).bounces(0)),
        (&hall, Traversal::ALL[0], Options::new(Method::BRACKET).linear(true)),
        (&random, Traversal::ALL[0], Options::new(Method::BRACKET).samples(4)),
    ];
    let mut most = 0.0_f64;
    for ((scene, camera), traversal, options) in cases {
        let mut renderer = Renderer::with_traversal(renderer(USUAL).gpu, traversal);
        renderer.band_pixels = 41 * 64;
        let uploaded = renderer.upload(scene).wait().unwrap();
        let camera = camera.size(41, 83);
        let [apart, together] = [true, false].map(|apart| {
            renderer.shades_apart = apart;
            let mut pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
            let kept = pair.statistics.intermediate_bytes;
            (pair.statistics.times, pair.statistics.intermediate_bytes) = (None, 0);
            (pair, kept)
        });
        let what = format!("{traversal:?}, {options:?}");
        let secondary = together.0.statistics.left.rays.secondary;
        assert_eq!(secondary > 0, options.bounces > 0, "{what}");
        assert_eq!(apart.0.statistics, together.0.statistics, "{what}");
        if options.samples == 1 {
            most = most.max(secondary as f64 / (41.0 * 83.0));
            let more = (41 * 64 * size_of::<layout::BouncedPixel>()) as u64 + layout::BOUNCED_HEADS;
            assert_eq!(apart.1, together.1 + more, "{what}");
        }
        assert!(!renderer.gpu.is_exact() || apart.0 == together.0, "{what}");
    }
    assert!(most > f64::from(layout::BOUNCED_ROUNDS), "no pixel is left after the last round: {most} rays");
}

#[test]
fn paths_of_separate_kernels_bring_what_those_of_one_bring() {
    let paths = |method| Options::new(method).lighting(Lighting::Paths { bounces: 4, samples: 2 }).linear(true);
    let lamp = |(mut scene, camera): (Scene, StereoCamera)| {
        let lamp = scene.add_material(Material::new(Vec3::ZERO).emission(Vec3::new(3.0, 2.0, 1.0)));
        scene.add_sphere(Sphere::new(Vec3::new(2.5, 2.0, 1.0), 0.4, lamp)).unwrap();
        scene.sky = Sky::Map(SkyMap::procedural(64).unwrap());
        (scene, camera)
    };
    let hall: crate::scene::builtin::Builtin = "hall-finished".parse().unwrap();
    let (glass, hall) = (lamp(glass_in_glass()), (hall.scene(), hall.camera(64, 48)));
    let cases = [
        (&glass, Traversal::GPU, paths(Method::BRACKET)),
        (&glass, Traversal::ALL[0], paths(Method::Naive).count(true).cost_map(true)),
        (&hall, Traversal::ALL[0], paths(Method::BRACKET).samples(4)),
        (&hall, Traversal::ALL[0], paths(Method::BRACKET).history(4)),
    ];
    for ((scene, camera), traversal, options) in cases {
        let mut renderer = Renderer::with_traversal(renderer(USUAL).gpu, traversal);
        renderer.band_pixels = 41 * 64;
        let uploaded = renderer.upload(scene).wait().unwrap();
        let camera = camera.size(41, 83);
        let [apart, together] = [true, false].map(|apart| {
            renderer.shades_apart = apart;
            renderer.forget();
            // The second frame recalls light of the first.
            let frames = [0, 1].map(|_| {
                let mut pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
                (pair.statistics.times, pair.statistics.intermediate_bytes) = (None, 0);
                pair
            });
            frames.map(|pair| (pair.statistics.clone(), pair))
        });
        for ((apart, of_apart), (together, of_together)) in apart.iter().zip(&together) {
            let what = format!("{traversal:?}, {options:?}");
            assert!(together.left.rays.secondary > 1000, "{what}: {:?}", together.left.rays);
            assert_eq!(apart, together, "{what}");
            assert!(!renderer.gpu.is_exact() || of_apart == of_together, "{what}");
        }
    }
}

const TRUSTING: Method = Method::Atomic(Check::None);

fn buffer(depth: BufferDepth) -> Method {
    Method::Buffer(depth, Check::None)
}

/// Pins what a frame gives to an adapter that is no CPU: one submission per band, and no wait before the last one.
/// Timestamps are copied once.
#[test]
fn a_gpu_gets_a_submission_per_band_and_is_waited_for_at_the_end() {
    let builtin = crate::scene::builtin::Builtin::Spheres;
    let mut renderer = Renderer::with_traversal(renderer(USUAL).gpu, Traversal::GPU);
    (renderer.band_pixels, renderer.read_back_bytes, renderer.searches_together) = (1 << 21, 1 << 28, true);
    let mut scene = builtin.scene();
    scene.lights.truncate(1);
    let uploaded = renderer.upload(&scene).wait().unwrap();
    for (size, method, bands, dispatches) in [
        ([1920, 1080], Method::Naive, 1, [4, 0]),
        ([1920, 1080], Method::BRACKET, 1, [6, 5]),
        ([3840, 2160], Method::BRACKET, 4, [24, 20]),
    ] {
        let camera = builtin.camera(size[0], size[1]);
        let options = Options::new(method).g_buffer(GBuffer::None);
        let gpu = renderer.gpu.clone();
        let before = gpu.work();
        let mut at_first = None;
        let mut landed = |_| {
            at_first.get_or_insert(gpu.work());
            ControlFlow::Continue(())
        };
        renderer.pair(&uploaded, &camera).options(&options).progress(&mut landed).read().wait().unwrap();
        let (work, at_first) = (gpu.work() - before, at_first.unwrap() - before);
        assert_eq!((at_first.submissions, at_first.waits), (bands, 1), "{method} {size:?}: {work:?}");
        assert_eq!((work.submissions, work.waits), (bands, bands), "{method} {size:?}: {work:?}");
        let dispatched = [work.dispatches, work.indirect_dispatches];
        assert_eq!(dispatched, dispatches, "{method} {size:?}: {work:?}");
        let pixels = 2 * u64::from(size[0] * size[1]) * 4;
        assert!((pixels..pixels * 11 / 10).contains(&work.bytes_read), "{method} {size:?}: {work:?}");
        let has_times = u64::from(gpu.timestamps);
        assert_eq!(work.timestamp_reads, has_times, "{method} {size:?}: {work:?}");
    }
}

/// Pins that no submission of a frame with paths has more steps than rays that its band may trace per pixel. The device
/// always has work while the host waits.
#[test]
fn steps_of_paths_are_submitted_in_parts() {
    let builtin = crate::scene::builtin::Builtin::Spheres;
    let mut renderer = renderer(USUAL);
    let uploaded = renderer.upload(&builtin.scene()).wait().unwrap();
    let camera = builtin.camera(64, 64);
    let lighting = Lighting::Paths { bounces: 3, samples: 8 };
    let options = Options::new(Method::Naive).lighting(lighting).g_buffer(GBuffer::None);
    let gpu = renderer.gpu.clone();
    let mut pictures = Vec::new();
    for (band_pixels, parts) in [(1 << 21, 2), (2 * 64 * 64, 3), (64 * 64, 5)] {
        renderer.band_pixels = band_pixels;
        let before = gpu.work();
        let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
        let work = gpu.work() - before;
        assert_eq!((work.submissions, work.waits), (parts, parts - 1), "{band_pixels}: {work:?}");
        pictures.push(pair.right.rgba8);
    }
    assert!(pictures.windows(2).all(|two| two[0] == two[1]), "pictures depend on the parts");
}

/// Runs reprojection alone on given source depths. Returns the keys of samples, and the number of lost candidates.
fn reproject(eyes: &Eyes, depths: &[f32], method: Method) -> (Vec<u32>, u64) {
    let mut renderer = renderer(64 * 16);
    let scene = renderer.upload(&Scene::new()).wait().unwrap();
    let run = async {
        // The source depths are given, so the step that traces the source is removed.
        let views = methods::Views {
            sources: &eyes.sources,
            mirrors: None,
            paths: None,
            soft: None,
            search: Search::Alone,
            drawn: None,
            recall: Recall::Nothing,
            keeps_light: false,
        };
        let mut plan = methods::plan(method, &views);
        let Stage::Steps(steps) = &mut plan.stages[0] else { panic!("{plan:?}") };
        steps.remove(0);
        let variant = renderer.variant(&scene, eyes, &Options::default(), &plan);
        let bands = Bands::new(eyes.pose.size, USUAL, 2, false);
        let shape = Shape {
            size: eyes.pose.size,
            bands,
            views: 2,
            cost_map: false,
            g_buffer: GBuffer::None,
            soft_sources: 0,
            drawing_bytes: 0,
            parts: 1,
        };
        let used = plan.uses(&renderer.kernels, &variant);
        let targets = renderer.targets(shape, &used).await?;
        let source: Vec<_> = depths.iter().map(|&depth| layout::Pixel { depth, ..Default::default() }).collect();
        renderer.gpu.queue.write_buffer(targets.get(Resource::View, 0), 0, bytemuck::cast_slice(&source));
        let mut go_on = |_| ControlFlow::Continue(());
        let options = &Options::new(Method::Naive);
        let model = scene.cost_model(&renderer.gpu, renderer.calibration, options);
        let shared = scene.resources_for(&renderer.gpu, &used, None).await?;
        let uniforms = renderer.uniforms(&scene, eyes, options, (&model, &targets.shape, 0));
        let setting = Setting { eyes, variant, targets: &targets, uniforms, shared, history: None };
        let mut driver = Driver::new(renderer.engine(true), setting, &mut go_on);
        driver.begin(&plan).await?;
        let commands = driver.band(&plan, &bands.get(0)).await?;
        renderer.gpu.queue.submit([commands.finish()]);
        let rows = eyes.pose.size[1] as usize * layout::COUNTERS;
        let counters: Vec<u32> = renderer.gpu.read(targets.get(Resource::Counters, 1), rows).await?;
        let lost = counters.iter().skip(layout::LOST_CANDIDATES).step_by(layout::COUNTERS).map(|&n| u64::from(n)).sum();
        let target: Vec<layout::Pixel> = renderer.gpu.read(targets.get(Resource::View, 1), depths.len()).await?;
        // Missed pixels were marked after reprojection.
        let empty = |mark| if mark == layout::MISSED { 0 } else { mark };
        Ok::<_, Error>((target.into_iter().map(|pixel| empty(pixel.marks)).collect(), lost))
    };
    pollster::block_on(run).unwrap()
}

fn eyes(size: [u32; 2], interaxial_px: f32) -> Eyes {
    let camera = StereoCamera::look_at(4.0 * Vec3::Z, Vec3::ZERO).screen_distance(4.0);
    Eyes::pair(&camera.size(size[0], size[1]).interaxial_pixels(interaxial_px).pose().unwrap())
}

/// Parallel cameras with a focal length of 32 px.
fn parallel(size: [u32; 2], interaxial: f32) -> Eyes {
    let camera = StereoCamera::look_at(4.0 * Vec3::Z, Vec3::ZERO).size(size[0], size[1]);
    let centre = size.map(|side| 0.5 * f64::from(side));
    Eyes::pair(&camera.intrinsics(Intrinsics::new([32.0; 2], centre)).interaxial(interaxial).pose().unwrap())
}

#[test]
fn the_index_buffer_equals_a_sequential_computation() {
    let size = [131, 37];
    let mut random = Random::new(9);
    let through_screens = [0.5, 7.0, 40.0].map(|e_px| (e_px, eyes(size, e_px)));
    let parallel = [0.5, 7.0, 40.0].map(|e_px| (-e_px, parallel(size, e_px / 8.0)));
    let sides = [[-0.5, 0.5], [1.5, 0.0]];
    for ((e_px, eyes), offsets) in
        through_screens.iter().chain(&parallel).flat_map(|eyes| sides.map(|offsets| (eyes, offsets)))
    {
        let eyes = Eyes { offsets: offsets.to_vec(), ..eyes.clone() };
        let depths: Vec<f32> = (0..size[0] * size[1])
            .map(|index| match index % 7 {
                0 => crate::FAR,
                1 => eyes.pose.subject_distance,
                2 => 0.5 * eyes.pose.subject_distance,
                3 => 1e-6 * random.unit(),
                _ => random.between(1.0, 10.0),
            })
            .collect();
        let expected = crate::testing::cpu::reproject::reproject(&eyes.cpu_frame(1), &depths);
        assert!(expected.contains(&0) && expected.iter().any(|&source| source > 0));
        for method in [TRUSTING, buffer(BufferDepth::Adaptive)] {
            assert_eq!(reproject(&eyes, &depths, method).0, expected, "{method} {e_px} {offsets:?}");
        }
    }
}

#[test]
fn samples_land_where_the_closed_form_says_ties_included() {
    // e_px = 8 and d = 4: parallax 8 (1 - 4/z).
    let eyes = eyes([40, 1], 8.0);
    let land = |column: usize, z: f32| {
        let mut depths = vec![1e-9; 40]; // so near that all other samples leave the picture
        depths[column] = z;
        let source = reproject(&eyes, &depths, TRUSTING).0;
        source.iter().position(|&source| source == column as u32 + 1)
    };
    assert_eq!(land(20, 4.0), Some(20), "on the screen");
    assert_eq!(land(20, 2.0), Some(12), "at d/2: e to the left");
    assert_eq!(land(20, crate::FAR), Some(28), "sky: e to the right");
    assert_eq!(land(20, 8.0), Some(24), "at 2d: half of e");
    // 8 (1 - 4/z) = 0.5 exactly at z = 64/15, which f32 rounds up: X = 21.0 or just above lands in 21.
    assert_eq!(land(20, 64.0 / 15.0), Some(21), "a tie goes to the right");
    // Parallax -0.5 exactly: X = 20.0 stays in 20.
    assert_eq!(land(20, 64.0 / 17.0), Some(20));
    assert_eq!(land(35, crate::FAR), None, "past the right edge");
    assert_eq!(land(7, 2.0), None, "past the left edge");
    assert_eq!(land(8, 2.0), Some(0), "X = 0.5");
    assert_eq!(land(8, 32.0 / 16.5), Some(0), "X = 0 exactly is inside");
}

#[test]
fn samples_of_parallel_cameras_move_left_by_f_e_over_z() {
    // f = 32 and e = 1 give a parallax of -32/z.
    let eyes = parallel([40, 1], 1.0);
    let land = |column: usize, z: f32| {
        let mut depths = vec![1e-9; 40];
        depths[column] = z;
        let source = reproject(&eyes, &depths, TRUSTING).0;
        source.iter().position(|&source| source == column as u32 + 1)
    };
    assert_eq!(land(20, 4.0), Some(12));
    assert_eq!(land(20, 32.0), Some(19));
    assert_eq!(land(20, 64.0), Some(20), "X = 20.0");
    assert_eq!(land(20, crate::FAR), Some(20), "sky stays where it is");
    assert_eq!(land(39, crate::FAR), Some(39));
    assert_eq!(land(7, 4.0), None, "past the left edge");
    assert_eq!(land(8, 4.0), Some(0));
    // Lemma 1: columns of depths between 2 and infinity meet if they are up to 16 apart. Twice the disparity at the
    // target, 4 away, gives 16 slots.
    let mut depths = vec![1e-9; 40];
    (depths[10], depths[26]) = (crate::FAR, 2.0);
    let (source, lost) = reproject(&eyes, &depths, buffer(BufferDepth::TwiceInteraxial));
    assert_eq!((source[10], lost), (27, 1), "as through a screen at the target");
    assert_eq!(crate::frame::driver::slots::lemma1(&eyes.pose, 2.0, f32::INFINITY), 16.0);
}

#[test]
fn twice_e_is_one_slot_short_at_half_the_screen_s_distance() {
    // Lemma 1 with equality: B = e d (1/(d/2) - 0) = 2e. Columns 2e apart meet in the same slot, i mod 2e.
    let eyes = eyes([40, 1], 8.0);
    let mut depths = vec![1e-9; 40];
    (depths[10], depths[26]) = (crate::FAR, 2.0);
    let (source, lost) = reproject(&eyes, &depths, buffer(BufferDepth::TwiceInteraxial));
    assert_eq!((source[18], lost), (27, 1), "the nearer one stands, the other is lost");
    // The adaptive depth would be 40, since the depth range includes samples that leave the picture. So the depth is
    // fixed here.
    let (source, lost) = reproject(&eyes, &depths, buffer(BufferDepth::Fixed(NonZeroU32::new(18).unwrap())));
    assert_eq!((source[18], lost), (27, 0), "floor(B) + 2 slots hold both");
}

#[test]
fn renderer_and_scene_may_cross_threads() {
    fn check<T: Send + Sync>() {}
    check::<Renderer>();
    check::<UploadedScene>();
    check::<Gpu>();
    check::<Error>();
}

/// A history is of the whole picture, whatever the bands are. Its copies per band are seen in the number of rays only.
#[test]
fn a_history_bounds_the_tiles_of_every_band() {
    let builtin = crate::scene::builtin::Builtin::Hall;
    let (camera, options) = (builtin.camera(130, 271), Options::new(Method::BRACKET_RAYS).history(4));
    let primary = [USUAL, 130 * 64].map(|band_pixels| {
        let mut renderer = renderer(band_pixels);
        let uploaded = renderer.upload(&builtin.scene()).wait().unwrap();
        let mut stop = |progress: Progress| match progress.done > 0.3 {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let mut frame = |options: &Options| renderer.pair(&uploaded, &camera).options(options).trace().wait().unwrap();
        let first = frame(&options).left.rays.primary;
        let repeated = frame(&options).left.rays.primary;
        frame(&options.clone().visibility(Visibility::TBuffer));
        let of_adaptive = frame(&options.clone().adaptive(crate::Adaptive::new(2, 8.0))).left.rays.primary;
        assert!(of_adaptive > first / 2, "adaptive frames have no history");
        let stopped = renderer.pair(&uploaded, &camera).options(&options).progress(&mut stop).trace().wait();
        assert!(matches!(stopped, Err(Error::Cancelled)) || band_pixels == USUAL);
        let after = renderer.pair(&uploaded, &camera).options(&options).trace().wait().unwrap().left.rays.primary;
        assert_eq!(after, repeated, "a stopped frame leaves the history of the frame before");
        [first, repeated]
    });
    assert_eq!(primary[0], primary[1]);
    assert_eq!(primary[0][0], 130 * 271);
    assert!(primary[0][1] < 130 * 271 / 20, "{primary:?}");
}

/// Renders a frame with masks: half of the left view's pixels and all of the right view's pixels.
fn part_of(renderer: &mut Renderer, scene: &UploadedScene, eyes: &Eyes, method: Method) -> Vec<Rows> {
    let [width, height] = eyes.pose.size;
    let rows = (10, height - 3);
    let mut masks = vec![Mask::new(width, rows.0..rows.1); 2];
    for (row, column) in (rows.0..rows.1).flat_map(|row| (0..width).map(move |column| (row, column))) {
        masks[1].want(column, row);
        if column / 16 % 2 == 0 {
            masks[0].want(column, row);
        }
    }
    let wanted = Wanted { pictures: true, part: Some(Part { rows, masks: Some(&masks) }) };
    let mut found = Vec::new();
    let mut keep = |rows| {
        found.push(rows);
        Ok(())
    };
    let mut go_on = |_| ControlFlow::Continue(());
    let options = Options::new(method);
    let frame = renderer.frame(scene, eyes, &options, wanted, &mut go_on, &mut keep);
    let done = pollster::block_on(frame).unwrap();
    assert_eq!(done.tallies[0].work.rays.primary, masks[0].count(rows.0..rows.1));
    found
}

/// Here, half of the samples in the buffers are left over from another frame.
#[test]
fn what_was_not_wanted_vouches_for_nothing() {
    let builtin = crate::scene::builtin::Builtin::Hall;
    let eyes = Eyes::pair(&builtin.camera(130, 83).pose().unwrap());
    let mut scene = builtin.scene();
    let mut used = renderer(USUAL);
    let before = used.upload(&scene).wait().unwrap();
    scene.lights.iter_mut().for_each(|light| light.position.x = -light.position.x);
    let uploaded = used.upload(&scene).wait().unwrap();
    let naive = part_of(&mut used, &uploaded, &eyes, Method::Naive);
    for method in [Method::BRACKET, Method::VERIFIED] {
        let mut fresh = renderer(USUAL);
        let same = fresh.upload(&scene).wait().unwrap();
        let expected = part_of(&mut fresh, &same, &eyes, method);
        // Renders a frame of all pixels into the same buffers.
        let all = Wanted { pictures: true, part: Some(Part { rows: (10, 80), masks: None }) };
        let (mut go_on, mut drop_them) = (|_| ControlFlow::Continue(()), |_| Ok(()));
        let options = Options::new(method);
        let frame = used.frame(&before, &eyes, &options, all, &mut go_on, &mut drop_them);
        pollster::block_on(frame).unwrap();
        let found = part_of(&mut used, &uploaded, &eyes, method);
        for ((found, expected), naive) in found.iter().zip(&expected).zip(&naive) {
            let [found, expected, naive] = [found, expected, naive].map(|rows| &rows.views[1].view);
            assert!(found == expected, "{method}");
            assert!(found.primitive == naive.primitive && found.depth == naive.depth, "{method}");
            let same = found.rgba8.iter().zip(&naive.rgba8).filter(|(a, b)| a == b).count();
            println!("{method}: {same} of {} colours are naive's", naive.rgba8.len());
            assert!(same * 1000 >= naive.rgba8.len() * 997, "{method}: {same}");
        }
    }
}

/// Compares the hits of an equirectangular pair with geometry in f64.
#[test]
fn equirectangular_eyes_see_what_their_rays_meet() {
    use crate::testing::cpu::intersect::closest_hit;

    let builtin = crate::scene::builtin::Builtin::Hall;
    let scene = builtin.scene();
    let mut renderer = renderer(USUAL);
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let [width, height] = [48, 24];
    let tilted = builtin.camera(width, height).up(Vec3::new(0.2, 1.0, -0.1)).interaxial(0.3);
    for (span, merge) in [(Span::Full, None), (Span::Full, Some(PoleMerge::default())), (Span::Half, None)] {
        let camera = tilted.projection(Projection::Equirectangular(Equirectangular { span, merge }));
        let pair = renderer.pair(&uploaded, &camera).options(&Options::new(Method::Naive)).read().wait().unwrap();
        for (view, side) in [(&pair.left, -1.0), (&pair.right, 1.0)] {
            let (mut seen, mut wrong) = (0, 0);
            let pixels = Pixels::of(&pair.pose, 0.5 * side);
            // The CPU reference tests every triangle of the closed hall, so only every eleventh pixel is compared.
            for (index, (&depth, &primitive)) in view.depth.iter().zip(&view.primitive).enumerate().step_by(11) {
                let (origin, direction) = pixels.ray(index % width as usize, index / width as usize);
                let (t, id) = closest_hit(&scene, origin.as_vec3(), direction.as_vec3(), 0.0, f32::INFINITY);
                seen += usize::from(id != crate::MISS);
                wrong += usize::from(id != primitive || (t - depth).abs() > 1e-3 * t);
            }
            assert_eq!((seen, wrong), (105, 0), "{span:?} {merge:?} {side}");
        }
        let apart = pair.left.depth.iter().zip(&pair.right.depth).filter(|(a, b)| a != b).count();
        assert!(apart > 300, "{apart}");
    }
}
