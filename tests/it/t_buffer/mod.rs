//! Tests closest hits by a T-buffer: they equal the hits of rays, bit for bit on software Vulkan, for any scene, method
//! and frame.

use crate::common;
mod counts;
mod frames;
mod hard;
mod scenes;

use common::is_exact;
use stereotrace::{
    Method, Options, Renderer, Rig, StereoCamera, UploadedScene, View, Views, Visibility, blocking::Wait,
};

/// Checks that two views have the same colours, depths and ids. On adapters that are not exact, only ids are compared,
/// and few may differ.
fn assert_alike(what: &str, drawn: &View, traced: &View, exact: bool) {
    let others = drawn.primitive.iter().zip(&traced.primitive).filter(|(a, b)| a != b).count();
    if !exact {
        assert!(others * 500 <= traced.primitive.len(), "{what}: {others} pixels show another primitive");
        return;
    }
    let depths = drawn.depth.iter().zip(&traced.depth).filter(|(a, b)| a != b).count();
    let colors = drawn.rgba8.iter().zip(&traced.rgba8).filter(|(a, b)| a != b).count();
    let linear = drawn.linear.iter().zip(&traced.linear).filter(|(a, b)| a != b).count();
    assert_eq!([others, depths, colors, linear], [0; 4], "{what}: others, depths, colours, linear");
    assert_eq!((drawn.width, drawn.height), (traced.width, traced.height), "{what}");
}

/// Renders views of a rig with closest hits of both kinds, and checks that they are alike. Returns the views by
/// T-buffer.
fn both(
    what: &str,
    renderer: &mut Renderer,
    scene: &UploadedScene,
    rig: &Rig,
    options: &Options,
    traced: &[usize],
) -> Views {
    let exact = is_exact(renderer);
    let [by_rays, drawn] = [Visibility::Rays, Visibility::TBuffer].map(|way| {
        let views = renderer.views(scene, rig).options(&options.clone().visibility(way)).read().wait();
        views.unwrap_or_else(|error| panic!("{what}: {error}"))
    });
    assert!(!drawn.in_steps, "{what}");
    for (index, (view, by_rays)) in drawn.views.iter().zip(&by_rays.views).enumerate() {
        let what = format!("{what}, view {index}");
        assert_alike(&what, &view.view, &by_rays.view, exact);
        if exact {
            assert!(view.source == by_rays.source && view.shadow_source == by_rays.shadow_source, "{what}");
            assert_eq!(view.work.rays.shadow, by_rays.work.rays.shadow, "{what}");
            assert_eq!(view.work.rays.secondary, by_rays.work.rays.secondary, "{what}");
            if traced.contains(&index) {
                assert_eq!(view.work.rays.primary, 0, "{what}");
            }
        }
    }
    drawn
}

/// Does the same for a pair by a method.
fn pair(what: &str, renderer: &mut Renderer, scene: &UploadedScene, camera: &StereoCamera, options: &Options) -> Views {
    let traced: &[usize] = if options.method == Method::Naive { &[0, 1] } else { &[0] };
    let what = format!("{what} by {}", options.method);
    both(&what, renderer, scene, &Rig::pair(*camera), options, traced)
}
