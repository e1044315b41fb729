//! Tests all features of pictures together: planes, mirrors, glass, textures, highlights, soft lamps, the sky's light,
//! and several samples per pixel.

use crate::common;

use common::renderer;
use stereotrace::{
    Adaptive, Builtin, Filter, Light, Method, Options, Rig, blocking::Wait, glam::Vec3, testing::suite::Trial,
};

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
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let camera = builtin.camera(size[0], size[1]);
        let rig = Rig::at(camera, vec![-0.5, 0.5, 0.1]).traced(vec![0]);
        // Each option is used only once, since every option needs other kernels.
        let first = usize::from(builtin == Builtin::HallFinished);
        for (index, several) in several.into_iter().enumerate().skip(first).step_by(2) {
            let mut render = |method| {
                renderer.views(&uploaded, &rig).options(&several(options(method))).read().wait().unwrap().views
            };
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

#[test]
fn what_is_hard_on_methods_is_no_harder_with_mirrors_soft_light_and_four_samples() {
    // Each scene needs other kernels.
    let few = Trial::ALL.iter().copied().step_by(4);
    few.for_each(is_no_harder_when_rich);
}

#[test]
#[ignore = "the whole suite takes minutes"]
fn nothing_of_the_suite_is_harder_with_mirrors_soft_light_and_four_samples() {
    Trial::ALL.iter().copied().for_each(is_no_harder_when_rich);
}

fn is_no_harder_when_rich(trial: Trial) {
    let mut renderer = renderer();
    let options = |method| Options::new(method).linear(true).samples(4).shadow_rays(4);
    let uploaded = renderer.upload(&trial.rich_scene()).wait().unwrap();
    let camera = trial.camera(45, 31);
    let mut render = |method| renderer.pair(&uploaded, &camera).options(&options(method)).read().wait().unwrap();
    let (naive, rays, bracket) = (render(Method::Naive), render(Method::BRACKET_RAYS), render(Method::BRACKET));
    assert!(naive.statistics.right.rays.secondary > 0 || trial.scene().materials().len() < 2, "{trial}: no mirrors");
    let off = naive.right.linear.iter().zip(&rays.right.linear).filter(|(a, b)| a != b).count();
    assert!(naive.right == rays.right, "{trial}: {off} pixels differ");
    assert!(bracket.right.primitive == naive.right.primitive, "{trial}");
    assert!(bracket.right.depth == naive.right.depth, "{trial}");
    let auto = render(Method::Auto);
    let choice = auto.statistics.choice.expect("auto says why");
    assert_eq!(choice.method == Method::BRACKET, choice.bracket < choice.naive, "{trial}: {choice}");
    assert_eq!(choice.secondary_rays > 0.0, auto.statistics.left.rays.secondary > 0, "{trial}: {choice}");
    assert!(auto.right == if choice.method == Method::BRACKET { &bracket } else { &naive }.right, "{trial}: {choice}");
}
