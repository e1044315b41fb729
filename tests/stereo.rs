//! The methods against each other and against `Naive` of the same run.

mod common;

use common::{gpu, gpu_with_limits, render, renderer};
use stereotrace::{
    BufferDepth, BvhBuild, Error, Fetch, GBuffer, Gpu, MISS, Method, Options, Overlap, PixelSource, PointLight,
    RaysPerLane, Renderer, Scene, StereoCamera, StereoPair, Traversal, Verify,
    glam::Vec3,
    method::lemma1,
    metrics::{Difference, compare},
    scene::builtin::Builtin,
    wgpu,
};

const BUFFER_2E: Method = Method::Reuse { overlap: Overlap::Buffer(BufferDepth::TwiceInteraxial), verify: Verify::All };
const TRUSTING: Method = Method::Reuse { overlap: Overlap::Atomic, verify: Verify::None };

/// Not a multiple of the workgroup either way.
const SIZE: (u32, u32) = (190, 107);

fn render_builtin(builtin: Builtin, method: Method) -> StereoPair {
    render(&builtin.scene(), &builtin.camera(SIZE.0, SIZE.1), method)
}

#[test]
fn ideal_copies_the_left_view() {
    let pair = render_builtin(Builtin::Spheres, Method::Ideal);
    assert_eq!(pair.left, pair.right);
    assert!(pair.source.iter().all(|source| *source == PixelSource::Reused));
}

#[test]
fn zero_interaxial_gives_identical_eyes_by_every_method() {
    let scene = Builtin::Spheres.scene();
    let camera = Builtin::Spheres.camera(63, 65).interaxial(0.0);
    for (name, method) in Method::ALL {
        let pair = render(&scene, &camera, method);
        assert_eq!(pair.left, pair.right, "{name}");
    }
}

#[test]
fn left_differs_from_right_and_every_method_has_the_same_left() {
    let naive = render_builtin(Builtin::Hall, Method::Naive);
    assert_ne!(naive.left.rgba8, naive.right.rgba8);
    for (name, method) in Method::ALL {
        assert_eq!(render_builtin(Builtin::Hall, method).left, naive.left, "{name}");
    }
}

#[test]
fn atomic_and_buffer_choose_the_same_candidate_everywhere() {
    for builtin in Builtin::ALL {
        let atomic = render_builtin(builtin, Method::ATOMIC);
        let buffer = render_builtin(builtin, Method::BUFFER);
        assert_eq!(atomic.source, buffer.source, "{builtin}");
        assert_eq!(atomic.right, buffer.right, "{builtin}");
        assert_eq!(buffer.statistics.lost_candidates, 0, "{builtin}: Lemma 1's depth never loses one");
    }
}

#[test]
fn a_buffer_of_2e_slots_loses_candidates_nearer_than_half_the_screen_and_one_slot_more_than_fits_does_not() {
    let near = render_builtin(Builtin::Near, BUFFER_2E);
    assert!(near.statistics.lost_candidates > 0, "nearest surface at d/7");
    // With atomicMax the farther ones are lost, so the picture stands.
    assert_eq!(near.right, render_builtin(Builtin::Near, Method::BUFFER).right);
    let far = render_builtin(Builtin::Fence, BUFFER_2E);
    assert_eq!(far.statistics.lost_candidates, 0, "nothing nearer than 0.65 d");
    let shallow = Method::Reuse { overlap: Overlap::Buffer(BufferDepth::Fixed(2)), verify: Verify::All };
    let shallow = render_builtin(Builtin::Near, shallow);
    assert!(shallow.statistics.lost_candidates > near.statistics.lost_candidates);
    assert_eq!(shallow.statistics.buffer_depth, 2);
}

#[test]
fn lemma_1_bounds_the_columns_that_meet() {
    // All that land on one right column, over random depths in [near, far]: fewer than B + 1 columns apart.
    let mut random = common::random::Random::new(5);
    for case in 0..200 {
        let camera = StereoCamera::look_at(Vec3::Z, Vec3::ZERO)
            .size(400, 1)
            .screen_distance(1.0)
            .interaxial_pixels(random.between(0.0, 60.0));
        let pose = camera.pose().unwrap();
        let near = random.between(0.05, 2.0);
        let far = if case % 3 == 0 { f32::INFINITY } else { near * random.between(1.0, 20.0) };
        let bound = lemma1(&pose, near, far);
        let frame = stereotrace::cpu::Frame::new(&pose);
        let mut first = vec![None; 400];
        for column in 0..400 {
            let z = match random.unit() {
                u if u < 0.2 => near,
                u if u > 0.8 => far.min(stereotrace::FAR),
                _ => (near * random.between(1.0, 20.0)).min(far),
            };
            if let Some(right) = stereotrace::cpu::reproject::right_column(&frame, column, z) {
                let first = *first[right].get_or_insert(column);
                // f32 rounding of X, a few ulps of 400 px.
                assert!(((column - first) as f64) < bound + 1.0 + 1e-4, "case {case}: {first} {column} {bound}");
            }
        }
    }
}

/// How `Atomic`'s right view differs from `Naive`'s.
fn accuracy(builtin: Builtin, method: Method) -> Difference {
    let naive = render_builtin(builtin, Method::Naive);
    compare(&render_builtin(builtin, method).right, &naive.right, &naive.pose).unwrap()
}

#[test]
fn atomic_is_as_accurate_as_measured_and_trust_without_verification_is_not() {
    // (scene, wrong surface %, MSE) measured on llvmpipe at 190x107; the bounds are 1.5 times that.
    let measured = [
        (Builtin::Spheres, 1.928, 112.26),
        (Builtin::Hall, 2.120, 264.24),
        (Builtin::Fence, 6.040, 326.35),
        (Builtin::Hidden, 0.000, 9.91),
        (Builtin::Near, 0.044, 11.11),
        (Builtin::Grazing, 2.095, 84.52),
    ];
    for (builtin, wrong_surface, mse) in measured {
        let atomic = accuracy(builtin, Method::ATOMIC);
        assert!(atomic.wrong_surface_percent <= 1.5 * wrong_surface, "{builtin}: {atomic:?}");
        assert!(atomic.mse <= 1.5 * mse, "{builtin}: {atomic:?}");
        let trusting = accuracy(builtin, TRUSTING);
        // Elsewhere an occluder that only the right eye sees is rare, and trust costs less than half more.
        if matches!(builtin, Builtin::Fence | Builtin::Near | Builtin::Grazing) {
            assert!(trusting.wrong_surface_percent > 1.5 * wrong_surface, "{builtin}: {trusting:?}");
        }
        if matches!(builtin, Builtin::Fence | Builtin::Grazing) {
            assert!(trusting.mse > 1.5 * mse, "{builtin}: {trusting:?}");
        }
    }
}

#[test]
fn the_right_view_follows_the_map_and_the_counts_follow_both() {
    for builtin in Builtin::ALL {
        let naive = render_builtin(builtin, Method::Naive);
        let mut renderer = renderer();
        let uploaded = renderer.upload(&builtin.scene()).unwrap();
        let camera = builtin.camera(SIZE.0, SIZE.1);
        let pair = renderer.render(&uploaded, &camera, &Options::new(Method::ATOMIC).counting()).unwrap();
        let count = |kind| pair.source.iter().filter(|source| **source == kind).count() as u64;
        let (s, pixels) = (&pair.statistics, u64::from(SIZE.0 * SIZE.1));
        let fates = [PixelSource::Reused, PixelSource::Bad, PixelSource::Missed].map(count);
        assert_eq!([s.reused, s.bad, s.missed], fates);
        assert_eq!(fates.iter().sum::<u64>(), pixels);
        assert_eq!((s.left.rays.primary, s.left.rays.verification), (pixels, 0));
        assert_eq!((s.right.rays.primary, s.right.rays.verification), (s.bad + s.missed, pixels - s.missed));
        assert!(s.left.rays.shadow > 0 && s.left.nodes > pixels && s.left.primitive_tests > 0);
        assert!(s.right.cost() < s.left.cost());
        for (index, source) in pair.source.iter().enumerate() {
            match source {
                PixelSource::Reused => {
                    let row = index / SIZE.0 as usize * SIZE.0 as usize;
                    let reused = pair.right.linear[index];
                    assert!(pair.left.linear[row..row + SIZE.0 as usize].contains(&reused), "pixel {index}");
                }
                _ => assert_eq!(pair.right.linear[index], naive.right.linear[index], "pixel {index}"),
            }
        }
        // Depth, primitive and object of a miss go together.
        for view in [&pair.left, &pair.right] {
            for index in 0..pixels as usize {
                let hit = view.primitive[index] != MISS;
                assert_eq!((view.depth[index].is_finite(), view.object[index] != MISS), (hit, hit));
            }
        }
    }
}

#[test]
fn intermediate_buffers_of_atomic_stay_within_48_bytes_a_pixel() {
    for (width, height) in [(640, 480), SIZE] {
        let camera = Builtin::Spheres.camera(width, height);
        let pair = render(&Builtin::Spheres.scene(), &camera, Method::ATOMIC);
        let pixels = u64::from(width * height);
        assert!(pair.statistics.intermediate_bytes <= 48 * pixels, "{}", pair.statistics.intermediate_bytes);
    }
}

#[test]
fn the_same_call_twice_gives_the_same_bytes() {
    for method in [Method::Naive, Method::ATOMIC, Method::BUFFER] {
        let (mut a, mut b) = (render_builtin(Builtin::Hall, method), render_builtin(Builtin::Hall, method));
        (a.statistics.times, b.statistics.times) = (None, None);
        assert_eq!(a, b, "{method}");
    }
}

#[test]
fn one_renderer_takes_scenes_and_sizes_in_any_order() {
    let mut renderer = renderer();
    let spheres = renderer.upload(&Builtin::Spheres.scene()).unwrap();
    let fence = renderer.upload(&Builtin::Fence.scene()).unwrap();
    let options = Options::default();
    let first = renderer.render(&spheres, &Builtin::Spheres.camera(64, 48), &options).unwrap();
    renderer.render(&fence, &Builtin::Fence.camera(33, 90), &options).unwrap();
    let again = renderer.render(&spheres, &Builtin::Spheres.camera(64, 48), &options).unwrap();
    assert_eq!(first.right, again.right);
}

#[test]
fn render_stereo_takes_one_call() {
    let pair = stereotrace::render_stereo(&Builtin::Spheres.scene(), &Builtin::Spheres.camera(40, 30)).unwrap();
    assert_eq!(pair.right.rgba8.len(), 1200);
}

#[test]
fn progress_runs_up_to_one_and_may_cancel() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&Builtin::Spheres.scene()).unwrap();
    let camera = Builtin::Spheres.camera(64, 64);
    let mut seen = Vec::new();
    let mut watch = |progress: stereotrace::Progress| {
        seen.push((progress.pass, progress.done));
        std::ops::ControlFlow::Continue(())
    };
    renderer.render_with(&uploaded, &camera, &Options::default(), &mut watch).unwrap();
    assert!(seen.is_sorted_by_key(|(_, done)| *done) && seen.last().unwrap().1 == 1.0, "{seen:?}");
    let names: Vec<_> = seen.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, ["bound_tiles", "compose"], "a band of the left view, then one of the right");
    let mut stop = |_| std::ops::ControlFlow::Break(());
    let error = renderer.render_with(&uploaded, &camera, &Options::default(), &mut stop).unwrap_err();
    assert!(matches!(error, Error::Cancelled));
    for (name, method) in Method::ALL {
        let mut last = 0.0;
        let mut watch = |progress: stereotrace::Progress| {
            assert!(progress.done > last, "{name}");
            last = progress.done;
            std::ops::ControlFlow::Continue(())
        };
        renderer.render_with(&uploaded, &camera, &Options::new(method), &mut watch).unwrap();
        assert_eq!(last, 1.0, "{name}");
    }
}

#[test]
fn a_destroyed_device_is_an_error_and_no_panic() {
    let mut renderer = Renderer::new(gpu());
    let scene = Builtin::Spheres.scene();
    let uploaded = renderer.upload(&scene).unwrap();
    let camera = Builtin::Spheres.camera(32, 32);
    renderer.render(&uploaded, &camera, &Options::default()).unwrap();
    renderer.gpu().device().destroy();
    let error = renderer.render(&uploaded, &camera, &Options::default()).unwrap_err();
    assert!(matches!(error, Error::DeviceLost(_)), "{error}");
    let error = renderer.upload(&scene).unwrap_err();
    assert!(matches!(error, Error::DeviceLost(_)), "{error}");
}

#[test]
fn a_device_of_the_caller_with_webgpu_s_default_limits_renders_the_same() {
    let mut theirs = Renderer::new(gpu_with_limits(wgpu::Limits::default()));
    let scene = Builtin::Hall.scene();
    let uploaded = theirs.upload(&scene).unwrap();
    let camera = Builtin::Hall.camera(SIZE.0, SIZE.1);
    let pair = theirs.render(&uploaded, &camera, &Options::new(Method::BUFFER)).unwrap();
    assert!(pair.statistics.times.is_none(), "timestamps were not asked for");
    assert_eq!(pair.right, render_builtin(Builtin::Hall, Method::BUFFER).right);
    theirs.gpu().device().destroy();
    let error = theirs.render(&uploaded, &camera, &Options::default()).unwrap_err();
    assert!(matches!(error, Error::DeviceLost(_)), "{error}");
    let error = Renderer::new(theirs.gpu().clone()).upload(&scene).unwrap_err();
    assert!(matches!(error, Error::DeviceLost(_)), "{error}");
}

#[test]
fn a_picture_over_the_device_s_limits_is_an_error_that_names_the_limit() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&Scene::new()).unwrap();
    let camera = Builtin::Hall.camera(60_000, 60_000);
    let message = renderer.render(&uploaded, &camera, &Options::default()).unwrap_err().to_string();
    assert!(message.starts_with("a 60000x60000 picture needs "), "{message}");
    assert!(message.contains("max_storage_buffer_binding_size"), "{message}");
}

#[test]
fn an_empty_scene_and_one_without_lights_render() {
    let mut scene = Scene::new();
    scene.sky = stereotrace::Sky::Constant(Vec3::new(0.5, 0.25, 0.0));
    let camera = StereoCamera::look_at(Vec3::Z, Vec3::ZERO).size(17, 9);
    for (name, method) in Method::ALL {
        let pair = render(&scene, &camera, method);
        assert!(pair.right.rgba8.iter().all(|pixel| *pixel == [188, 137, 0, 255]), "{name} {:?}", pair.right.rgba8[0]);
    }
    let mut dark = Builtin::Hall.scene();
    dark.lights.clear();
    let pair = render(&dark, &Builtin::Hall.camera(40, 30), Method::ATOMIC);
    assert_eq!(pair.statistics.left.rays.shadow + pair.statistics.right.rays.shadow, 0);
    assert!(pair.left.rgba8.iter().any(|pixel| pixel[..3] != [0; 3]), "ambient light");
}

#[test]
fn a_scene_uploaded_to_another_device_is_refused() {
    let other = Renderer::new(gpu());
    let theirs = other.upload(&Builtin::Spheres.scene()).unwrap();
    let camera = Builtin::Spheres.camera(32, 32);
    let message = renderer().render(&theirs, &camera, &Options::default()).unwrap_err().to_string();
    assert!(message.contains("uploaded by another Gpu"), "{message}");
}

#[test]
fn an_eye_in_the_plane_of_a_wall_is_no_fault() {
    // Every hit is at depth 0 or none: Lemma 1's bound is no number.
    let mut scene = Scene::new();
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec();
    scene.add_mesh(&common::mesh(corners, vec![[0, 1, 2], [0, 2, 3]])).unwrap();
    let camera = StereoCamera::look_at(Vec3::ZERO, -Vec3::Z).size(16, 16).interaxial(0.1);
    for (name, method) in Method::ALL {
        let pair = render(&scene, &camera, method);
        assert_eq!(pair.left.depth.len(), 256, "{name}");
    }
}

#[test]
fn many_lights_add_up_to_one() {
    let camera = Builtin::Hall.camera(40, 30);
    let mut scene = Builtin::Hall.scene();
    scene.lights.truncate(1);
    let one = render(&scene, &camera, Method::Naive);
    let light = scene.lights[0];
    for count in [100, 1000] {
        scene.lights = vec![PointLight { intensity: light.intensity / count as f32, ..light }; count];
        let mut renderer = renderer();
        let uploaded = renderer.upload(&scene).unwrap();
        let many = renderer.render(&uploaded, &camera, &Options::new(Method::Naive)).unwrap();
        assert_eq!(many.statistics.left.rays.shadow, count as u64 * one.statistics.left.rays.shadow);
        for (many, one) in many.left.linear.iter().zip(&one.left.linear) {
            // Roundings of a sum below 2.
            assert!((0..3).all(|c| (many[c] - one[c]).abs() < 1e-4), "{many:?} {one:?}");
        }
    }
}

#[test]
fn degenerate_triangles_are_counted_and_not_traced_and_ids_keep_their_numbers() {
    let point = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    let positions = vec![point(-1.0, -1.0), point(1.0, -1.0), point(0.0, 1.0)];
    let mut scene = Scene::new();
    scene.add_mesh(&common::mesh(positions, vec![[0, 0, 1], [0, 1, 1], [0, 1, 2]])).unwrap();
    assert_eq!((scene.degenerate_count(), scene.primitive_count()), (2, 3));
    let camera = StereoCamera::look_at(3.0 * Vec3::Z, Vec3::ZERO).size(21, 21);
    let pair = render(&scene, &camera, Method::Naive);
    assert!(pair.left.primitive.iter().all(|&id| id == 2 || id == MISS));
    assert_eq!(pair.left.primitive[10 * 21 + 10], 2);
    assert_eq!(renderer().upload(&scene).unwrap().info().dropped_triangles, 2);
}

#[test]
fn a_smaller_g_buffer_changes_no_picture() {
    let camera = Builtin::Fence.camera(61, 45);
    let mut renderer = renderer();
    let uploaded = renderer.upload(&Builtin::Fence.scene()).unwrap();
    for (name, method) in Method::ALL {
        let mut render =
            |g_buffer| renderer.render(&uploaded, &camera, &Options::new(method).keeping(g_buffer)).unwrap();
        let [full, depth, none] = [GBuffer::Ids, GBuffer::Depth, GBuffer::None].map(&mut render);
        for less in [&depth, &none] {
            assert_eq!((&less.left.linear, &less.right.linear), (&full.left.linear, &full.right.linear), "{name}");
            assert_eq!((&less.left.rgba8, &less.right.rgba8), (&full.left.rgba8, &full.right.rgba8), "{name}");
            assert_eq!(less.source, full.source, "{name}");
            assert!(less.left.primitive.is_empty() && less.right.object.is_empty(), "{name}");
            // Edges are told by objects, and bracket by primitives: they are kept on the device.
            let bytes = [less, &full].map(|pair| pair.statistics.intermediate_bytes);
            let keeps_all = name == "atomic-edges"
                || matches!(method, Method::Auto | Method::Reuse { overlap: Overlap::Bracket(_), .. });
            assert!(bytes[0] < bytes[1] || (keeps_all && bytes[0] == bytes[1]), "{name}");
        }
        assert_eq!((&depth.left.depth, &depth.right.depth), (&full.left.depth, &full.right.depth), "{name}");
        assert!(none.left.depth.is_empty() && none.right.depth.is_empty(), "{name}");
        let error = compare(&none.right, &full.right, &full.pose).unwrap_err().to_string();
        assert!(error.contains("0 pixels"), "{error}");
    }
}

#[test]
fn without_shadows_every_light_in_front_of_a_surface_reaches_it() {
    let camera = Builtin::Hall.camera(80, 60);
    let mut scene = Builtin::Hall.scene();
    let with = render(&scene, &camera, Method::Naive);
    scene.shadows = false;
    let without = render(&scene, &camera, Method::Naive);
    assert!(with.statistics.left.rays.shadow > 0);
    assert_eq!(without.statistics.left.rays.shadow + without.statistics.right.rays.shadow, 0);
    let pairs = || with.left.linear.iter().zip(&without.left.linear);
    assert!(pairs().all(|(with, without)| (0..3).all(|c| without[c] >= with[c])));
    assert!(pairs().filter(|(with, without)| with != without).count() > 500);
    assert_eq!(with.left.depth, without.left.depth);
    // A surface that no light is hidden from looks the same: a lone sphere lit from the eye.
    let mut lone = Scene::new();
    let grey = lone.add_material("grey", Vec3::splat(0.5));
    lone.add_sphere(stereotrace::Sphere { center: Vec3::ZERO, radius: 1.0, material: grey }).unwrap();
    lone.lights = vec![PointLight { position: 5.0 * Vec3::Z, intensity: Vec3::ONE }];
    let camera = StereoCamera::look_at(5.0 * Vec3::Z, Vec3::ZERO).size(48, 48);
    let with = render(&lone, &camera, Method::Naive);
    lone.shadows = false;
    assert_eq!(render(&lone, &camera, Method::Naive).left.linear, with.left.linear);
}

#[test]
fn every_effort_at_the_tree_gives_the_same_picture() {
    let camera = Builtin::Hall.camera(64, 48);
    let mut renderer = renderer();
    let exact = common::is_exact(&renderer);
    let pairs = BvhBuild::ALL.map(|build| {
        let uploaded = renderer.upload_with(&Builtin::Hall.scene(), build).unwrap();
        let info = uploaded.info();
        assert!(info.node_bytes > 0 && info.primitive_bytes > 0 && !info.build.is_zero() && !info.upload.is_zero());
        let pair = renderer.render(&uploaded, &camera, &Options::new(Method::Naive).counting()).unwrap();
        (pair.left.linear, pair.right.primitive, pair.statistics.left.nodes)
    });
    for (build, pair) in BvhBuild::ALL.iter().zip(&pairs) {
        assert!(!exact || (&pair.0, &pair.1) == (&pairs[0].0, &pairs[0].1), "{build:?}");
    }
    assert!(pairs[2].2 < pairs[0].2, "more effort, fewer nodes: {} {}", pairs[2].2, pairs[0].2);
}

/// A device of the tests' adapter with lower limits.
fn limited(bytes: u64, side: u32) -> Gpu {
    let mut limits = gpu().device().limits();
    limits.max_storage_buffer_binding_size = bytes;
    limits.max_texture_dimension_2d = side;
    limits.max_texture_dimension_1d = limits.max_texture_dimension_1d.min(side);
    gpu_with_limits(limits)
}

#[test]
fn a_scene_over_one_limit_is_read_the_other_way_and_over_both_refused_with_the_count_that_fits() {
    // The hall's primitives take 12 MiB.
    let (scene, camera) = (Builtin::Hall.scene(), Builtin::Hall.camera(33, 20));
    let buffers = Traversal { fetch: Fetch::Buffer, rays: RaysPerLane::One, ..Traversal::of(&gpu()) };
    let whole = {
        let mut renderer = Renderer::with_traversal(gpu(), buffers);
        let uploaded = renderer.upload(&scene).unwrap();
        assert_eq!(uploaded.info().traversal, buffers);
        renderer.render(&uploaded, &camera, &Options::new(Method::ATOMIC)).unwrap()
    };
    let mut small = Renderer::with_traversal(limited(1 << 20, 8192), buffers);
    let uploaded = small.upload(&scene).unwrap();
    assert_eq!(uploaded.info().traversal.fetch, Fetch::Texture);
    let pair = small.render(&uploaded, &camera, &Options::new(Method::ATOMIC)).unwrap();
    assert_eq!(pair.right.primitive, whole.right.primitive);

    let tiny = Renderer::with_traversal(limited(1 << 20, 2048), buffers);
    let error = tiny.upload(&scene).unwrap_err();
    let message = error.to_string();
    assert!(matches!(error, Error::Limit { limit: "max_storage_buffer_binding_size", .. }), "{message}");
    // 1 MiB holds 65,536 texels, four a primitive with normals: a little less for its degenerate triangles, if any.
    assert!(message.starts_with(&format!("a scene of {} primitives needs ", scene.primitive_count())), "{message}");
    assert!(message.contains("enough for 65536, about 16384 primitives"), "{message}");

    // A sky of 2 MiB.
    let mut scene = Builtin::Near.scene();
    scene.sky = stereotrace::Sky::Map(stereotrace::SkyMap::procedural(512).unwrap());
    assert_eq!(small.upload(&scene).unwrap().info().traversal.fetch, Fetch::Texture);
    let message = tiny.upload(&scene).unwrap_err().to_string();
    assert!(message.starts_with("the scene's table of lights, materials and sky needs 131"), "{message}");
    assert!(message.ends_with("enough for 65536; use a smaller sky"), "{message}");
}

#[test]
fn a_thread_a_row_sweeps_as_adelson_and_hodges_do() {
    for builtin in Builtin::ALL {
        let es_isler = render_builtin(builtin, Method::ES_ISLER);
        let adelson_hodges = render_builtin(builtin, Method::ADELSON_HODGES);
        assert_eq!(es_isler.source, adelson_hodges.source, "{builtin}");
        assert_eq!(es_isler.right, adelson_hodges.right, "{builtin}");
        // And both as the sweep over the left view's depths says.
        let frame = stereotrace::cpu::Frame::new(&es_isler.pose);
        let depths: Vec<f32> = es_isler.left.depth.iter().map(|depth| depth.min(stereotrace::FAR)).collect();
        let swept = stereotrace::cpu::adelson_hodges::sweep(&frame, &depths);
        let naive = render_builtin(builtin, Method::Naive);
        for (index, source) in swept.iter().enumerate() {
            let taken = index / SIZE.0 as usize * SIZE.0 as usize + (*source as usize).saturating_sub(1);
            let (fate, color) = match source {
                0 => (PixelSource::Missed, naive.right.linear[index]),
                _ => (PixelSource::Reused, naive.left.linear[taken]),
            };
            assert_eq!((es_isler.source[index], es_isler.right.linear[index]), (fate, color), "{builtin} {index}");
        }
    }
}

#[test]
fn edges_are_traced_and_the_rest_is_trusted() {
    let edges = Method::Reuse { overlap: Overlap::Atomic, verify: Verify::Edges };
    let width = SIZE.0 as usize;
    for builtin in [Builtin::Hall, Builtin::Spheres, Builtin::Fence] {
        let pair = render_builtin(builtin, edges);
        let left = &pair.left;
        let frame = stereotrace::cpu::Frame::new(&pair.pose);
        let depths: Vec<f32> = left.depth.iter().map(|depth| depth.min(stereotrace::FAR)).collect();
        let parallax = |index: usize| pair.pose.parallax_px(left.depth[index]);
        let mut wrong = 0;
        for (index, source) in stereotrace::cpu::reproject::reproject(&frame, &depths).iter().enumerate() {
            let (row, column) = (index / width, (*source as usize).wrapping_sub(1));
            if *source == 0 {
                assert_eq!(pair.source[index], PixelSource::Missed);
                continue;
            }
            let at = row * width + column;
            let beside = [
                (column > 0).then(|| at - 1),
                (column + 1 < width).then_some(at + 1),
                (row > 0).then(|| at - width),
                (row + 1 < SIZE.1 as usize).then_some(at + width),
            ];
            // Two skies are infinitely deep both, and no distance apart.
            let apart = |other: usize| match left.depth[other] == left.depth[at] {
                true => 0.0,
                false => (parallax(other) - parallax(at)).abs(),
            };
            let edge = |limit: f32| {
                let differs = |other: usize| left.object[other] != left.object[at] || apart(other) > limit;
                beside.into_iter().flatten().any(differs)
            };
            // Nearer to the limit than rounding, either is right.
            let bad = pair.source[index] == PixelSource::Bad;
            wrong += usize::from(bad && !edge(1.0 - 1e-4) || !bad && edge(1.0 + 1e-4));
        }
        assert_eq!(wrong, 0, "{builtin}");
        assert!(pair.statistics.bad > 500, "{builtin}: {}", pair.statistics.bad);
        assert_eq!(pair.statistics.right.rays.verification, 0);
        let trusting = render_builtin(builtin, TRUSTING);
        let naive = render_builtin(builtin, Method::Naive);
        let error = |pair: &StereoPair| compare(&pair.right, &naive.right, &naive.pose).unwrap().mse;
        assert!(error(&pair) < 0.8 * error(&trusting), "{builtin}: {} {}", error(&pair), error(&trusting));
    }
}

#[test]
fn choices_that_do_not_go_together_are_refused() {
    let method = Method::Reuse { overlap: Overlap::Scanline, verify: Verify::All };
    let mut renderer = renderer();
    let uploaded = renderer.upload(&Scene::new()).unwrap();
    let camera = StereoCamera::look_at(Vec3::Z, Vec3::ZERO).size(8, 8);
    let message = renderer.render(&uploaded, &camera, &Options::new(method)).unwrap_err().to_string();
    assert!(message.contains("overlap Scanline does not go with verification All, but with gaps"), "{message}");
}

#[test]
fn a_map_of_costs_adds_up_to_the_counts_and_changes_no_picture() {
    let camera = Builtin::Hall.camera(61, 45);
    let mut renderer = renderer();
    let uploaded = renderer.upload(&Builtin::Hall.scene()).unwrap();
    for (name, method) in Method::ALL {
        let plain = renderer.render(&uploaded, &camera, &Options::new(method)).unwrap();
        let pair = renderer.render(&uploaded, &camera, &Options::new(method).mapping_costs()).unwrap();
        assert_eq!((&pair.left.linear, &pair.right.linear), (&plain.left.linear, &plain.right.linear), "{name}");
        assert!(plain.left.cost.is_empty() && plain.left.cost_picture(100).is_none());
        for (view, work) in [(&pair.left, pair.statistics.left), (&pair.right, pair.statistics.right)] {
            let sum: u64 = view.cost.iter().map(|&cost| u64::from(cost)).sum();
            assert_eq!(sum, work.nodes + work.primitive_tests, "{name}");
        }
        // A pixel that is traced costs; one that is copied does not.
        let checked = matches!(method, Method::Auto | Method::Reuse { verify: Verify::All, .. });
        for (source, cost) in pair.source.iter().zip(&pair.right.cost) {
            assert_eq!(*cost > 0, *source != PixelSource::Reused || checked, "{name} {source:?}");
        }
        let picture = pair.left.cost_picture(pair.left.cost.iter().copied().max().unwrap()).unwrap();
        assert!(picture.rgba8.contains(&[255; 4]) && picture.rgba8.iter().any(|pixel| pixel[0] < 128));
    }
}

#[test]
fn the_picture_that_the_device_composes_is_the_linear_one_encoded() {
    // The host follows right_source on its own.
    for (name, method) in Method::ALL {
        let pair = render_builtin(Builtin::Hall, method);
        for view in [&pair.left, &pair.right] {
            for (encoded, linear) in view.rgba8.iter().zip(&view.linear) {
                for (byte, value) in encoded.iter().zip(&linear[..3]) {
                    let srgb = if *value <= 0.0031308 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 };
                    assert!((f32::from(*byte) - 255.0 * srgb).abs() <= 0.51, "{name}: {byte} for {value}");
                }
            }
        }
    }
}
