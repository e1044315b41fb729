//! What pictures can show, together: planes, mirrors, glass, textures, highlights, soft lamps, the sky's light, and several samples a pixel.

mod common;

use common::renderer;
use stereotrace::{Adaptive, Builtin, Filter, Light, Method, Options, Rig, glam::Vec3};

#[test]
fn bracket_rays_are_naive_to_the_last_bit() {
    let mut renderer = renderer();
    let options = |method| Options::new(method).linear(true).shadow_rays(3).seed(5);
    let several: [fn(Options) -> Options; 4] = [
        |options| options.samples(4).sky_rays(2),
        |options| options.samples(9).filter(Filter::Tent),
        |options| options.adaptive(Adaptive::new(3, 10.0)).sky_rays(3),
        |options| options.samples(4).jitter(false),
    ];
    for (builtin, size) in [(Builtin::ThreeSpheresTextured, [70, 47]), (Builtin::HallFinished, [45, 31])] {
        let mut scene = builtin.scene();
        scene.lights.push(Light::sphere(Vec3::new(2.0, 5.0, 1.0), 0.2, Vec3::splat(0.2)));
        let uploaded = renderer.upload(&scene).unwrap();
        let camera = builtin.camera(size[0], size[1]);
        let rig = Rig::at(camera, vec![-0.5, 0.5, 0.1]).traced(vec![0]);
        // Each of them once: kernels of each are compiled anew.
        let first = usize::from(builtin == Builtin::HallFinished);
        for (index, several) in several.into_iter().enumerate().skip(first).step_by(2) {
            let mut render = |method| renderer.render_views(&uploaded, &rig, &several(options(method))).unwrap().views;
            let (naive, rays) = (render(Method::Naive), render(Method::BRACKET_RAYS));
            let bracket = render(Method::BRACKET);
            for ((naive, rays), bracket) in naive.iter().zip(&rays).zip(&bracket) {
                let off = naive.view.linear.iter().zip(&rays.view.linear).filter(|(a, b)| a != b).count();
                assert!(naive.view == rays.view, "{builtin}, {index}: {off} pixels differ");
                assert!(bracket.view.primitive == naive.view.primitive, "{builtin}, {index}");
                assert!(bracket.view.depth == naive.view.depth, "{builtin}, {index}");
            }
        }
    }
}
