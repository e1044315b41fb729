//! The async forms: they give what the blocking ones give, on whatever thread they are polled.

use crate::common;

use std::{
    ops::ControlFlow,
    sync::atomic::{AtomicU32, Ordering},
    thread,
};

use common::{random_stage, renderer};
use stereotrace::{
    BvhBuild, Error, Gpu, Method, Options, Ray, Renderer, StereoCamera, StereoPair, Update, glam::Vec3, render_stereo,
    render_stereo_async,
};

fn camera() -> StereoCamera {
    StereoCamera::look_at(Vec3::new(0.0, 0.5, 5.0), Vec3::ZERO).screen_distance(5.0).size(50, 37).interaxial_pixels(6.0)
}

/// But for what depends on the clock.
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
    // Made here and polled there: a future that can't go there does not compile.
    let there = async {
        let mut renderer = Renderer::new(Gpu::open_async(wanted).await?);
        let mut uploaded = renderer.upload_async(&scene, BvhBuild::Balanced).await?;
        renderer.update_async(&mut uploaded, &scene, Update::Rebuild(BvhBuild::Balanced)).await?;
        let mut count = |_| {
            calls.fetch_add(1, Ordering::Relaxed);
            ControlFlow::Continue(())
        };
        let mut pairs = Vec::new();
        for options in &options {
            pairs.push(timeless(renderer.render_async(&uploaded, &camera, options, &mut count).await?));
        }
        let traced = renderer.trace_async(&uploaded, &camera, &options[0]).await?;
        let closest = renderer.closest_hits_async(&uploaded, &rays).await?.hits;
        let any = renderer.any_hits_async(&uploaded, &rays).await?.hits;
        let in_one_call = timeless(render_stereo_async(&scene, &camera).await?);
        Ok::<_, Error>((pairs, traced.left, closest, any, in_one_call))
    };
    let found = thread::scope(|scope| scope.spawn(|| pollster::block_on(there)).join().unwrap()).unwrap();
    assert!(calls.into_inner() > 0);

    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).unwrap();
    let pairs = options.iter().map(|options| timeless(renderer.render(&uploaded, &camera, options).unwrap()));
    let pairs = pairs.collect::<Vec<_>>();
    let traced = renderer.trace(&uploaded, &camera, &options[0]).unwrap();
    let closest = renderer.closest_hits(&uploaded, &rays).unwrap().hits;
    let any = renderer.any_hits(&uploaded, &rays).unwrap().hits;
    assert!(any.contains(&true) && any.contains(&false));
    let in_one_call = timeless(render_stereo(&scene, &camera).unwrap());
    assert!(found == (pairs, traced.left, closest, any, in_one_call));
}
