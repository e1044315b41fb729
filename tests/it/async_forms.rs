//! Tests async functions: their results on any thread that polls them, and futures that are dropped.

use crate::common;

use std::{
    future::{Future, poll_fn},
    ops::ControlFlow,
    pin::pin,
    sync::atomic::{AtomicU32, Ordering},
    task::Poll,
    thread,
};

use common::{is_exact, random_stage, renderer};
use stereotrace::{
    Adaptive, AmbientOcclusion, Builtin, BvhBuild, Error, Gpu, Method, Options, Ray, Renderer, ShadowBuffer,
    ShadowBufferWork, StereoCamera, StereoPair, Update, blocking::Wait, glam::Vec3, render_stereo,
};

fn camera() -> StereoCamera {
    StereoCamera::look_at(Vec3::new(0.0, 0.5, 5.0), Vec3::ZERO).screen_distance(5.0).size(50, 37).interaxial_pixels(6.0)
}

/// Removes the statistics that depend on the clock.
fn timeless(mut pair: StereoPair) -> StereoPair {
    pair.statistics.times = None;
    pair
}

#[test]
fn async_forms_give_what_the_blocking_ones_give_on_another_thread() {
    let (scene, camera, eye) = (random_stage(4), camera(), 5.0 * Vec3::Z);
    let rays: Vec<Ray> = (0..300).map(|i| Ray::new(eye, Vec3::new(0.01 * (i % 20) as f32 - 0.1, 0.0, -1.0))).collect();
    let options = [Method::Auto, "adelson-hodges".parse().unwrap()].map(Options::new);
    let wanted = std::env::var("STEREOTRACE_ADAPTER").unwrap_or_else(|_| "software".into());
    let calls = AtomicU32::new(0);
    // The future is made here and polled on another thread. A future that can't be sent there does not compile.
    let there = async {
        let mut renderer = Renderer::new(Gpu::open(wanted).await?);
        let mut uploaded = renderer.upload(&scene).await?;
        renderer.update(&mut uploaded, &scene, Update::Rebuild(BvhBuild::Balanced)).await?;
        let mut count = |_| {
            calls.fetch_add(1, Ordering::Relaxed);
            ControlFlow::Continue(())
        };
        let mut pairs = Vec::new();
        for options in &options {
            pairs.push(timeless(renderer.pair(&uploaded, &camera).options(options).progress(&mut count).read().await?));
        }
        let traced = renderer.pair(&uploaded, &camera).options(&options[0]).trace().await?;
        let closest = renderer.closest_hits(&uploaded, &rays).await?.hits;
        let any = renderer.any_hits(&uploaded, &rays).await?.hits;
        let in_one_call = timeless(renderer.pair(&uploaded, &camera).read().await?);
        Ok::<_, Error>((pairs, traced.left, closest, any, in_one_call))
    };
    let found = thread::scope(|scope| scope.spawn(|| pollster::block_on(there)).join().unwrap()).unwrap();
    assert!(calls.into_inner() > 0);

    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let pairs = options
        .iter()
        .map(|options| timeless(renderer.pair(&uploaded, &camera).options(options).read().wait().unwrap()));
    let pairs = pairs.collect::<Vec<_>>();
    let traced = renderer.pair(&uploaded, &camera).options(&options[0]).trace().wait().unwrap();
    let closest = renderer.closest_hits(&uploaded, &rays).wait().unwrap().hits;
    let any = renderer.any_hits(&uploaded, &rays).wait().unwrap().hits;
    assert!(any.contains(&true) && any.contains(&false));
    let in_one_call = timeless(render_stereo(&scene, &camera).unwrap());
    assert!(found == (pairs, traced.left, closest, any, in_one_call));
}

/// Polls a future at most this many times. Returns its value if it is ready by then.
fn polled<T>(future: impl Future<Output = T>, most: u32) -> (Option<T>, u32) {
    let mut future = pin!(future);
    let mut polls = 0;
    let value = poll_fn(|context| {
        polls += 1;
        match future.as_mut().poll(context) {
            Poll::Pending if polls == most => Poll::Ready(None),
            other => other.map(Some),
        }
    })
    .wait();
    (value, polls)
}

/// The frame takes a fifth of a second. It is rendered in slices, one per poll, so that a timeout can end it. The
/// renderer can then render the next frame.
#[test]
fn a_frame_that_is_dropped_between_two_polls_leaves_no_trace() {
    let (scene, camera) = (Builtin::Hall.scene(), Builtin::Hall.camera(320, 240));
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let options = Options::new(Method::Naive).samples(4);
    let expected = timeless(renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap());
    // Frames of other kinds are dropped in between: in several levels, with tables that are filled, and with host work.
    let others = [
        Options::new(Method::Naive).adaptive(Adaptive::new(3, 8.0)),
        Options::new(Method::Naive).shadow_buffer(ShadowBuffer::new(64)),
        Options::new(Method::ADELSON_HODGES),
        Options::new(Method::BRACKET).shadow_rays(4).ambient_occlusion(AmbientOcclusion::new(4, 1.0)),
    ];
    let small = camera.size(96, 72);
    let mut fresh = Renderer::new(renderer.gpu().clone());
    let mut whole = |options| timeless(fresh.pair(&uploaded, &small).options(options).read().wait().unwrap());
    let mut slices = 0;
    for kept in [1, 3, u32::MAX] {
        for other in &others {
            if let (Some(pair), _) = polled(renderer.pair(&uploaded, &small).options(other).read(), kept) {
                let (mut found, mut expected) = (timeless(pair.unwrap()), whole(other));
                // The first frame fills the tables.
                found.statistics.shadow_buffer = ShadowBufferWork::default();
                expected.statistics.shadow_buffer = ShadowBufferWork::default();
                assert!(found == expected, "{other:?}");
            }
        }
        let (pair, polls) = polled(renderer.pair(&uploaded, &camera).options(&options).read(), kept);
        match pair {
            Some(pair) => assert!(timeless(pair.unwrap()) == expected),
            None => assert_eq!(polls, kept),
        }
        slices = polls;
    } // A software adapter is slow enough for several slices.
    assert!(!is_exact(&renderer) || slices > 3, "{slices}");
}

#[test]
fn a_scene_whose_update_was_dropped_is_refused() {
    let (mut scene, camera) = (Builtin::Hall.scene(), Builtin::Hall.camera(32, 24));
    let mut renderer = renderer();
    let mut uploaded = renderer.upload(&scene).wait().unwrap();
    scene.ambient = Some(Vec3::splat(0.3));
    let (done, _) = polled(renderer.update(&mut uploaded, &scene, Update::Rebuild(BvhBuild::Fast)), 1);
    let again = renderer.pair(&uploaded, &camera).read().wait();
    match done {
        Some(done) => assert!(done.is_ok() && again.is_ok()),
        None => {
            let message = again.unwrap_err().to_string();
            assert!(message.contains("upload it again"), "{message}");
            let update = renderer.update(&mut uploaded, &scene, Update::Refit).wait().unwrap_err().to_string();
            assert_eq!(update, message);
        }
    }
}
