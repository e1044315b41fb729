//! Tests adaptive samples against Whitted's recursion over a picture of all samples, and against very many samples.
//! Also tests which options are refused together with adaptive samples.

use crate::common;

use std::ops::ControlFlow;

use common::{cases, random_stage, renderer, sampling::camera};
use stereotrace::{
    Adaptive, AmbientOcclusion, Builtin, Error, Filter, GBuffer, Light, Method, Options, Renderer, Rig, Rows, Scene,
    StereoCamera, UploadedScene, View, blocking::Wait, glam::Vec3,
};

/// Returns a camera with one pixel per sample. Its pixels stand for samples at the corners of the given camera's
/// pixels, with `side` samples along the side of a pixel.
fn lattice(camera: StereoCamera, side: u32) -> StereoCamera {
    let pose = camera.pose().unwrap();
    let [width, height] = pose.size.map(|pixels| pixels * side);
    let screen_width = f64::from(pose.screen_size[0]) * (1.0 + 1.0 / f64::from(width));
    camera.size(width + 1, height + 1).screen_width(screen_width as f32).interaxial(pose.interaxial)
}

/// Returns a cell's colour by Whitted's recursion. `all` has a sample for each place that the recursion may need.
fn divided(all: &View, [x, y]: [u32; 2], side: u32, tolerance: u8) -> [f64; 3] {
    let corners = [[x, y], [x + side, y], [x, y + side], [x + side, y + side]];
    let places = corners.map(|[x, y]| (y * all.width + x) as usize);
    let differs = (0..3).any(|channel| {
        let values = places.map(|place| all.rgba8[place][channel]);
        values.iter().max().unwrap() - values.iter().min().unwrap() > tolerance
    });
    let four = if differs && side > 1 {
        let half = side / 2;
        [[x, y], [x + half, y], [x, y + half], [x + half, y + half]].map(|at| divided(all, at, half, tolerance))
    } else {
        places.map(|place| [0, 1, 2].map(|channel| f64::from(all.linear[place][channel])))
    };
    [0, 1, 2].map(|channel| four.iter().map(|color| color[channel]).sum::<f64>() / 4.0)
}

/// Tests views that are not the source of other views, so that only their own samples decide which cells are divided.
#[test]
fn a_view_is_what_the_recursion_makes_of_all_samples() {
    let mut renderer = renderer();
    for (levels, tolerance, scene) in [(2, 0, random_stage(4)), (4, 20, random_stage(4)), (3, 8, random_stage(5))] {
        let uploaded = renderer.upload(&scene).wait().unwrap();
        // The picture has several bands of rows. At some levels a band has several rows of cells.
        let camera = camera(90, 71);
        let side = 1 << (levels - 1);
        let options = Options::new(Method::Naive).linear(true).g_buffer(GBuffer::None);
        let all = renderer.pair(&uploaded, &lattice(camera, side)).options(&options).read().wait().unwrap();
        let adaptive = options.clone().adaptive(Adaptive::new(levels, tolerance.into()));
        for (offset, all) in [(-0.5, &all.left), (0.5, &all.right)] {
            let found =
                renderer.views(&uploaded, &Rig::at(camera, vec![offset])).options(&adaptive).read().wait().unwrap();
            let found = &found.views[0];
            let mut off = 0;
            for (place, color) in found.view.linear.iter().enumerate() {
                let [x, y] = [place as u32 % 90, place as u32 / 90].map(|pixel| pixel * side);
                let expected = divided(all, [x, y], side, tolerance);
                // Sample positions are rounded differently in a larger picture, so a few samples fall on the other side
                // of an edge.
                off += u32::from((0..3).any(|channel| (f64::from(color[channel]) - expected[channel]).abs() > 1e-4));
            }
            println!("{levels} levels: {off} pixels off, {} samples", found.work.rays.primary);
            assert!(off <= 12, "{levels}: {off}");
            let pixels = u64::from(90 * 71_u32);
            let most = u64::from(all.width) * u64::from(all.height + 8);
            assert!(found.work.rays.primary > pixels && found.work.rays.primary < most, "{:?}", found.work.rays);
        }
    }
}

fn views(renderer: &mut Renderer, uploaded: &UploadedScene, rig: &Rig, options: Options) -> Vec<stereotrace::RigView> {
    renderer.views(uploaded, rig).options(&options).read().wait().unwrap().views
}

#[test]
fn bracket_rays_are_naive_to_the_last_bit() {
    let mut renderer = renderer();
    let mut soft = Builtin::Random125Both.scene();
    soft.lights.push(Light::sphere(Vec3::new(1.0, 6.0, 3.0), 0.3, Vec3::splat(0.5)));
    let rows: [(Scene, StereoCamera, u32); 3] = [
        (random_stage(4), camera(150, 77), 4),
        (random_stage(7), camera(1100, 40), 2),
        (soft, Builtin::Random125Both.camera(90, 70), 3),
    ];
    for (scene, camera, levels) in cases(rows, 2) {
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let rig = Rig::at(camera, vec![-0.5, 0.5, 1.5, -1.5]).traced(vec![1]);
        let options = |method| {
            let options = Options::new(method).linear(true).adaptive(Adaptive::new(levels, 12.0)).shadow_rays(4);
            options.ambient_occlusion(AmbientOcclusion::new(4, 2.0))
        };
        let naive = views(&mut renderer, &uploaded, &rig, options(Method::Naive));
        let rays = views(&mut renderer, &uploaded, &rig, options(Method::BRACKET_RAYS));
        let bracket = views(&mut renderer, &uploaded, &rig, options(Method::BRACKET));
        for index in 0..4 {
            let (naive, rays, bracket) = (&naive[index], &rays[index], &bracket[index]);
            assert!(rays.view == naive.view, "{levels}, view {index}");
            assert!(bracket.view.primitive == naive.view.primitive && bracket.view.depth == naive.view.depth);
            let primary = [rays, bracket].map(|view| view.work.rays.primary as f64 / naive.work.rays.primary as f64);
            println!("{levels}, view {index}: {primary:?} of {}", naive.work.rays.primary);
            // The bounds apply to the share of traced primary rays. In a view that reuses another view, the share is at
            // most 0.04. In the source view, the corners of divided cells are traced again.
            let bounds = if index == 1 { 1.0..1.5 } else { 0.0..0.08 };
            assert!(primary.iter().all(|share| bounds.contains(share)), "{levels}, view {index}: {primary:?}");
            let shadow = bracket.work.rays.shadow as f64 / naive.work.rays.shadow as f64;
            // The measured share is at most 0.574. Divided cells lie at edges. Shadows are narrow there, so lights are
            // traced again.
            println!("{levels}, view {index}: {shadow:.3} of the shadow rays");
            assert!(index == 1 || shadow < 0.7, "{levels}, view {index}: {shadow}");
        }
    }
}

/// Returns the root mean square difference from a reference, in 8-bit values.
fn error(view: &View, reference: &[[u8; 4]]) -> f64 {
    let pairs = view.rgba8.iter().flatten().zip(reference.iter().flatten());
    let sum: f64 = pairs.map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
    (sum / (3.0 * view.rgba8.len() as f64)).sqrt()
}

/// Returns both views with 64x64 samples per pixel.
fn reference(renderer: &mut Renderer, uploaded: &UploadedScene, camera: StereoCamera) -> [Vec<[u8; 4]>; 2] {
    let pose = camera.pose().unwrap();
    let [width, height] = pose.size;
    let finer = camera.interaxial(pose.interaxial).size(8 * width, 8 * height);
    let options = Options::new(Method::Naive).samples(64).linear(true).g_buffer(GBuffer::None);
    let pair = renderer.pair(uploaded, &finer).options(&options).read().wait().unwrap();
    [pair.left, pair.right].map(|view| {
        let mean = |place: u32| -> [u8; 4] {
            let [x, y] = [place % width, place / width];
            let samples = (0..64).map(|sample| (8 * y + sample / 8) * view.width + 8 * x + sample % 8);
            let sum = samples.map(|place| Vec3::from_slice(&view.linear[place as usize])).sum::<Vec3>() / 64.0;
            let shown = sum.to_array().map(|value| {
                let value = value.clamp(0.0, 1.0);
                let encoded = if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 };
                (255.0 * encoded).round() as u8
            });
            [shown[0], shown[1], shown[2], 255]
        };
        (0..width * height).map(mean).collect()
    })
}

#[test]
fn the_more_levels_the_nearer_to_64x64_samples_in_both_eyes() {
    let mut renderer = renderer();
    let (scene, camera) = (Builtin::Random20.scene(), Builtin::Random20.camera(32, 32));
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let truth = reference(&mut renderer, &uploaded, camera);
    let mut before = [f64::INFINITY; 2];
    for levels in 2..=5 {
        let options = Options::new(Method::BRACKET).adaptive(Adaptive::new(levels, 4.0)).g_buffer(GBuffer::None);
        let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
        let errors = [error(&pair.left, &truth[0]), error(&pair.right, &truth[1])];
        let rays = [pair.statistics.left.rays, pair.statistics.right.rays];
        println!("{levels} levels: off by {errors:?}, {rays:?}");
        // The measured error is 0.40 to 0.48 times the error with one level less.
        assert!(errors.iter().zip(before).all(|(error, before)| *error < 0.6 * before), "{levels}: {errors:?}");
        before = errors;
    }
    // For comparison, this prints the errors with 64 samples per pixel.
    let all = Options::new(Method::BRACKET).samples(64).g_buffer(GBuffer::None);
    let all = renderer.pair(&uploaded, &camera).options(&all).read().wait().unwrap();
    println!("64 samples: off by {:?}", [error(&all.left, &truth[0]), error(&all.right, &truth[1])]);
}

#[test]
fn rows_are_those_of_the_whole_and_counts_are_of_all_samples() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&random_stage(6)).wait().unwrap();
    let rig = Rig::pair(camera(301, 77));
    for g_buffer in [GBuffer::Ids, GBuffer::None] {
        let options = Options::new(Method::Auto).adaptive(Adaptive::new(3, 10.0)).cost_map(true).g_buffer(g_buffer);
        let whole = renderer.views(&uploaded, &rig).options(&options).read().wait().unwrap();
        let (mut next, mut rgba8, mut cost, mut shares) = (0, Vec::<[u8; 4]>::new(), Vec::<u32>::new(), Vec::new());
        let mut progress = |progress: stereotrace::Progress| {
            shares.push(progress.done);
            ControlFlow::Continue(())
        };
        let mut on_rows = |rows: Rows| {
            assert_eq!(rows.first, next);
            next += rows.views[1].view.height;
            assert_eq!(rows.views[1].source.len() as u32, 301 * rows.views[1].view.height);
            rgba8.extend(&rows.views[1].view.rgba8);
            cost.extend(&rows.views[1].view.cost);
            Ok(())
        };
        let done = renderer.views(&uploaded, &rig).options(&options).progress(&mut progress).rows(&mut on_rows);
        let rest = pollster::block_on(done).unwrap();
        assert!(shares.is_sorted() && shares.last() == Some(&1.0), "{shares:?}");
        let right = &whole.views[1];
        assert_eq!((next, rest.views[1].work), (77, right.work));
        assert!(rgba8 == right.view.rgba8 && cost == right.view.cost);
        let sum: u64 = cost.iter().map(|&cost| u64::from(cost)).sum();
        assert_eq!(sum, right.work.nodes + right.work.primitive_tests);
        assert_eq!(right.view.depth.is_empty(), g_buffer == GBuffer::None);
        assert!(right.view.linear.is_empty() && right.source.len() == 301 * 77);
        // A frame with adaptive samples must not change later frames.
        let usual = Options::new(Method::BRACKET);
        let one = renderer.pair(&uploaded, &camera(301, 77)).options(&usual).read().wait().unwrap();
        assert!(g_buffer == GBuffer::None || one.right.depth == right.view.depth);
        let stopped = renderer
            .pair(&uploaded, &camera(301, 77))
            .options(&options)
            .progress(&mut |_| ControlFlow::Break(()))
            .read()
            .wait();
        assert!(matches!(stopped, Err(Error::Cancelled)));
    }
}

#[test]
fn what_it_does_not_go_with_is_refused_by_name() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&random_stage(4)).wait().unwrap();
    let mut refused = |options: Options| {
        let error = renderer.pair(&uploaded, &camera(16, 16)).options(&options).read().wait().unwrap_err();
        assert!(matches!(error, Error::Options { .. }), "{error:?}");
        error.to_string()
    };
    let with = |levels, tolerance| Options::new(Method::BRACKET).adaptive(Adaptive::new(levels, tolerance));
    for (options, says) in [
        (with(1, 4.0), "1 levels; it must be 2 to 5"),
        (with(6, 4.0), "6 levels"),
        (with(3, -1.0), "a tolerance of -1; it must be 0 to 255"),
        (with(3, f32::NAN), "a tolerance of NaN"),
        (with(3, 4.0).samples(4), "it does not support 4 samples per pixel; use 1"),
        (with(3, 4.0).filter(Filter::Tent), "it does not support the filter tent; use box"),
        (
            with(3, 4.0).method(Method::ATOMIC),
            "it does not support the method atomic; use naive, ideal, a bracket method or auto",
        ),
    ] {
        let message = refused(options);
        assert!(message.contains("adaptive") && message.contains(says), "{message}");
    }
    let mut encoder = renderer.gpu().clone().device().create_command_encoder(&Default::default());
    let encoded =
        renderer.views(&uploaded, &Rig::pair(camera(16, 16))).options(&with(3, 4.0)).encode(&mut encoder).wait();
    assert!(encoded.unwrap_err().to_string().contains("adaptive sampling can't be encoded in advance"));
    let far = camera(400, 300).screen_width(0.01);
    let message = renderer.pair(&uploaded, &far).options(&with(4, 4.0)).read().wait().unwrap_err().to_string();
    assert!(message.contains("64 per pixel; for 400x300 pixels they are"), "{message}");
}
