//! Lights, ambient light and where lights are placed: what is refused, and what is rendered where nothing is said.

mod common;

use common::renderer;
use stereotrace::{Error, PointLight, Scene, Sky, glam::Vec3};

#[test]
fn negative_light_and_reflectance_are_refused_by_name() {
    let negative = Vec3::new(0.5, -0.1, 0.5);
    let refused = |element: &str, reason: &str, spoil: &dyn Fn(&mut Scene)| {
        let mut scene = Scene::new();
        spoil(&mut scene);
        let Err(error @ Error::Scene { .. }) = renderer().upload(&scene) else { panic!("{element} is not refused") };
        let expected =
            format!("invalid scene: {element}: {reason} is [0.5, -0.1, 0.5]; it must be finite and not negative");
        assert_eq!(error.to_string(), expected);
    };
    let light = PointLight { position: Vec3::splat(-1.0), intensity: negative };
    refused("ambient", "it", &|scene| scene.ambient = negative);
    refused("light 0", "intensity", &|scene| scene.lights.push(light));
    refused("material 1 'tar'", "albedo", &|scene| assert_eq!(scene.add_material("tar", negative).0, 1));
    refused("sky", "it", &|scene| scene.sky = Sky::Constant(negative));
    refused("sky", "nadir", &|scene| scene.sky = Sky::Gradient { nadir: negative, zenith: Vec3::ONE });
    refused("sky", "zenith", &|scene| scene.sky = Sky::Gradient { nadir: Vec3::ONE, zenith: negative });
    let mut scene = Scene::new();
    scene.ambient = Vec3::NEG_ONE * 0.0; // no less than nothing
    scene.lights.push(PointLight { intensity: Vec3::ONE, ..light });
    assert!(renderer().upload(&scene).is_ok());
}
