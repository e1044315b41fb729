//! Tests frames: kept results, counters and progress, and that a frame does not change the next one.

use stereotrace::{
    Check, Error, GBuffer, Light, Method, Options, PixelSource, blocking::Wait, metrics::compare,
    scene::builtin::Builtin,
};

use super::{
    SIZE,
    common::{render, renderer},
    render_builtin,
};

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
    let spheres = renderer.upload(&Builtin::Spheres.scene()).wait().unwrap();
    let fence = renderer.upload(&Builtin::Fence.scene()).wait().unwrap();
    let options = Options::default();
    let first = renderer.pair(&spheres, &Builtin::Spheres.camera(64, 48)).options(&options).read().wait().unwrap();
    renderer.pair(&fence, &Builtin::Fence.camera(33, 90)).options(&options).read().wait().unwrap();
    let again = renderer.pair(&spheres, &Builtin::Spheres.camera(64, 48)).options(&options).read().wait().unwrap();
    assert_eq!(first.right, again.right);
}

#[test]
fn equal_eyes_with_noise_of_their_own_are_both_traced() {
    let mut scene = Builtin::Near.scene();
    for light in &mut scene.lights {
        *light = Light::sphere(light.position, 0.4, light.intensity);
    }
    let camera = Builtin::Near.camera(64, 48).interaxial(0.0);
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let mut pair = |method, by_view| {
        let options = Options::new(method).shadow_rays(4).noise_by_view(by_view);
        renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap()
    };
    let naive = pair(Method::Naive, true);
    assert!(naive.left.rgba8 != naive.right.rgba8, "nothing in the picture is noise");
    for method in [Method::BRACKET_RAYS, Method::BRACKET, Method::Auto, Method::ATOMIC] {
        let found = pair(method, true);
        assert!(found.left == naive.left && found.right == naive.right, "{method}");
        let copied = pair(method, false);
        assert!(copied.left.rgba8 == copied.right.rgba8, "{method}");
    }
}

#[test]
fn render_stereo_takes_one_call() {
    let pair = stereotrace::render_stereo(&Builtin::Spheres.scene(), &Builtin::Spheres.camera(40, 30)).unwrap();
    assert_eq!(pair.right.rgba8.len(), 1200);
}

#[test]
fn progress_runs_up_to_one_and_may_cancel() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&Builtin::Spheres.scene()).wait().unwrap();
    let camera = Builtin::Spheres.camera(64, 64);
    let mut seen = Vec::new();
    let mut watch = |progress: stereotrace::Progress| {
        seen.push((progress.pass, progress.done));
        std::ops::ControlFlow::Continue(())
    };
    renderer.pair(&uploaded, &camera).progress(&mut watch).read().wait().unwrap();
    assert!(seen.is_sorted_by_key(|(_, done)| *done) && seen.last().unwrap().1 == 1.0, "{seen:?}");
    let names: Vec<_> = seen.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, ["trace_right"], "one band, by its last step");
    let mut stop = |_| std::ops::ControlFlow::Break(());
    let error = renderer.pair(&uploaded, &camera).progress(&mut stop).read().wait().unwrap_err();
    assert!(matches!(error, Error::Cancelled));
    for &method in Method::ALL {
        let mut last = 0.0;
        let mut watch = |progress: stereotrace::Progress| {
            assert!(progress.done > last, "{method}");
            last = progress.done;
            std::ops::ControlFlow::Continue(())
        };
        renderer.pair(&uploaded, &camera).options(&Options::new(method)).progress(&mut watch).read().wait().unwrap();
        assert_eq!(last, 1.0, "{method}");
    }
}

#[test]
fn a_smaller_g_buffer_changes_no_picture() {
    let camera = Builtin::Fence.camera(61, 45);
    let mut renderer = renderer();
    let uploaded = renderer.upload(&Builtin::Fence.scene()).wait().unwrap();
    for &method in Method::ALL {
        let mut render = |g_buffer| {
            renderer
                .pair(&uploaded, &camera)
                .options(&Options::new(method).linear(true).g_buffer(g_buffer))
                .read()
                .wait()
                .unwrap()
        };
        let [full, depth, none] = [GBuffer::Ids, GBuffer::Depth, GBuffer::None].map(&mut render);
        for less in [&depth, &none] {
            assert_eq!((&less.left.linear, &less.right.linear), (&full.left.linear, &full.right.linear), "{method}");
            assert_eq!((&less.left.rgba8, &less.right.rgba8), (&full.left.rgba8, &full.right.rgba8), "{method}");
            assert_eq!(less.source, full.source, "{method}");
            assert!(less.left.primitive.is_empty() && less.right.object.is_empty(), "{method}");
        }
        assert_eq!((&depth.left.depth, &depth.right.depth), (&full.left.depth, &full.right.depth), "{method}");
        assert!(none.left.depth.is_empty() && none.right.depth.is_empty(), "{method}");
        let error = compare(&none.right, &full.right, &full.pose).unwrap_err().to_string();
        assert!(error.contains("0 pixels"), "{error}");
    }
}

#[test]
fn a_map_of_costs_adds_up_to_the_counts_and_changes_no_picture() {
    let camera = Builtin::Hall.camera(61, 45);
    let mut renderer = renderer();
    let uploaded = renderer.upload(&Builtin::Hall.scene()).wait().unwrap();
    for &method in Method::ALL {
        let plain =
            renderer.pair(&uploaded, &camera).options(&Options::new(method).linear(true)).read().wait().unwrap();
        let pair = renderer
            .pair(&uploaded, &camera)
            .options(&Options::new(method).linear(true).cost_map(true))
            .read()
            .wait()
            .unwrap();
        assert_eq!((&pair.left.linear, &pair.right.linear), (&plain.left.linear, &plain.right.linear), "{method}");
        assert!(plain.left.cost.is_empty() && plain.left.cost_picture(100).is_none());
        for (view, work) in [(&pair.left, pair.statistics.left), (&pair.right, pair.statistics.right)] {
            let sum: u64 = view.cost.iter().map(|&cost| u64::from(cost)).sum();
            assert_eq!(sum, work.nodes + work.primitive_tests, "{method}");
        }
        // A traced pixel has a cost, and a reused one has none.
        let checked = matches!(
            method,
            Method::Auto | Method::Atomic(Check::All) | Method::Buffer(_, Check::All) | Method::Bracket(_)
        );
        for (source, cost) in pair.source.iter().zip(&pair.right.cost) {
            assert_eq!(*cost > 0, *source != PixelSource::Reused || checked, "{method} {source:?}");
        }
        let picture = pair.left.cost_picture(pair.left.cost.iter().copied().max().unwrap()).unwrap();
        assert!(picture.rgba8.contains(&[255; 4]) && picture.rgba8.iter().any(|pixel| pixel[0] < 128));
    }
}

#[test]
fn the_picture_that_the_device_encodes_is_the_linear_one_clamped() {
    // The host computes these pictures from right_source itself.
    for &method in Method::ALL {
        let pair = render_builtin(Builtin::Hall, method);
        for view in [&pair.left, &pair.right] {
            for (encoded, linear) in view.rgba8.iter().zip(&view.linear) {
                for (byte, value) in encoded.iter().zip(&linear[..3]) {
                    let shown = value.min(1.0);
                    let srgb = if shown <= 0.0031308 { 12.92 * shown } else { 1.055 * shown.powf(1.0 / 2.4) - 0.055 };
                    assert!((f32::from(*byte) - 255.0 * srgb).abs() <= 0.51, "{method}: {byte} for {value}");
                }
            }
        }
    }
}
