//! Features that improve a picture and make its first eye more expensive.

use stereotrace::{
    AmbientOcclusion, Error, Finish, Light, Material, Method, Options, Scene, Sky, SkyMap, Sphere, glam::Vec3,
};

use crate::common::scenes::BenchScene;

/// A scene with its rendering options.
pub(crate) struct Finished {
    pub(crate) name: &'static str,
    pub(crate) scene: Scene,
    pub(crate) options: Options,
}

/// Radius of spherical lights and reach of occlusion, as shares of the scene's diagonal.
const RADIUS: f32 = 0.01;
const REACH: f32 = 0.1;
/// Width of the sky map in pixels.
const SKY_WIDTH: u32 = 1024;

/// Returns variants of a scene: without lights, with point lights, and with one further feature each. The last one
/// combines several.
pub(crate) fn finishes(bench: &BenchScene) -> Result<Vec<Finished>, Error> {
    let plain = Options::new(Method::Naive);
    let points = &bench.scene;
    let diagonal = points.bounds().map_or(1.0, |(low, high)| low.distance(high) as f32);
    let mut unlit = points.clone();
    unlit.lights.clear();
    let mut soft = points.clone();
    soften(&mut soft, diagonal);
    let mut sky = points.clone();
    sky.sky = Sky::Map(SkyMap::procedural(SKY_WIDTH)?);
    let mirror = Material::new(Vec3::ZERO).specular(Vec3::splat(0.9)).finish(Finish::Mirror { fresnel: false });
    let transmission = Vec3::splat(0.95);
    let glass = Material::new(Vec3::ZERO).specular(Vec3::splat(1.0)).finish(Finish::Glass {
        index: 1.5,
        transmission,
        fresnel: true,
    });
    let (mirror, glass) = (with_ball(points, bench, mirror)?, with_ball(points, bench, glass)?);
    let mut all = mirror.clone();
    soften(&mut all, diagonal);
    let occlusion = AmbientOcclusion::new(16, REACH * diagonal);
    let of = |name, scene: &Scene, options: Options| Finished { name, scene: scene.clone(), options };
    Ok(vec![
        of("no lights", &unlit, plain.clone()),
        of("points", points, plain.clone()),
        of("points, 4 samples", points, plain.clone().samples(4)),
        of("points, 9 samples", points, plain.clone().samples(9)),
        of("balls, 16 rays", &soft, plain.clone()),
        of("points, occlusion", points, plain.clone().ambient_occlusion(occlusion)),
        of("points, sky's light", &sky, plain.clone().sky_rays(16)),
        of("points, mirror ball", &mirror, plain.clone()),
        of("points, glass ball", &glass, plain.clone()),
        of("balls, occlusion, mirror", &all, plain.ambient_occlusion(occlusion)),
    ])
}

fn soften(scene: &mut Scene, diagonal: f32) {
    for light in &mut scene.lights {
        *light = Light::sphere(light.position, RADIUS * diagonal, light.intensity);
    }
}

/// Adds a sphere in the middle of the picture, a third of its height.
fn with_ball(scene: &Scene, bench: &BenchScene, material: Material) -> Result<Scene, Error> {
    let pose = bench.camera.pose()?;
    let mut scene = scene.clone();
    let material = scene.add_material(material);
    let center = pose.eye.as_vec3() + pose.forward * pose.screen_distance;
    scene.add_sphere(Sphere::new(center, pose.screen_size[1] / 6.0, material))?;
    Ok(scene)
}
