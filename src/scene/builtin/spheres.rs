//! A cloud of a thousand spheres, fixed or turned, and three spheres on an infinite ground.

use glam::Vec3;

use super::{lamp, paint};
#[cfg(any(test, feature = "testing"))]
use crate::Error;
use crate::{Finish, Plane, Scene, Sky, Sphere, StereoCamera, Texture, random::Random};

pub(crate) const SPHERE_COUNT: usize = 1000;
const SPHERE_RADII: [f32; 2] = [0.12, 0.45];
/// The cloud fills a cylinder around the y axis, so turning it about this axis does not bring it nearer to the eyes.
const CLOUD_RADIUS: f32 = 6.0;
const CLOUD_HALF_HEIGHT: f32 = 4.2;
/// The screen is at the cloud's axis, so the cloud begins at half its distance.
pub(crate) const CLOUD_SCREEN: f32 = 2.0 * CLOUD_RADIUS;

/// Returns [`Builtin::Spheres`](super::Builtin::Spheres), turned about the y axis by an angle in radians, for the
/// frames of a film.
///
/// # Errors
/// [`Error::Scene`] for an angle that is not finite.
#[cfg(any(test, feature = "testing"))]
pub fn spheres_turned(angle: f32) -> Result<Scene, Error> {
    if !angle.is_finite() {
        return Err(Error::Scene { element: "spheres".into(), reason: format!("the angle {angle} is not finite") });
    }
    let still = spheres();
    let turn = glam::Mat3::from_rotation_y(angle);
    let mut scene = Scene { spheres: Vec::new(), ..still.clone() };
    for &sphere in still.spheres() {
        scene.add_sphere(Sphere { center: turn * sphere.center, ..sphere })?;
    }
    Ok(scene)
}

pub(crate) fn spheres() -> Scene {
    let mut scene = Scene::new();
    scene.sky = Sky::Gradient { nadir: Vec3::new(0.55, 0.42, 0.34), zenith: Vec3::new(0.09, 0.22, 0.5) };
    const PALETTE: [[u8; 3]; 10] = [
        [214, 69, 65],
        [242, 140, 56],
        [246, 200, 80],
        [122, 176, 90],
        [38, 138, 123],
        [66, 150, 200],
        [60, 84, 160],
        [136, 84, 150],
        [232, 226, 212],
        [224, 130, 150],
    ];
    let colors = PALETTE.map(|color| paint(&mut scene, "", color));
    let mut random = Random(2012);
    let mut placed: Vec<Sphere> = Vec::with_capacity(SPHERE_COUNT);
    while placed.len() < SPHERE_COUNT {
        // Large spheres come first, since later there is no room for them.
        let share = placed.len() as f32 / SPHERE_COUNT as f32;
        let radius = SPHERE_RADII[1] + (SPHERE_RADII[0] - SPHERE_RADII[1]) * share;
        let [x, z] = [0; 2].map(|_| random.between(-CLOUD_RADIUS, CLOUD_RADIUS));
        let center = Vec3::new(x, random.between(-CLOUD_HALF_HEIGHT, CLOUD_HALF_HEIGHT), z);
        let material = colors[(random.unit() * colors.len() as f32) as usize];
        let inside = x * x + z * z <= (CLOUD_RADIUS - radius) * (CLOUD_RADIUS - radius);
        let touches = |other: &Sphere| {
            let reach = other.radius + radius;
            other.center.distance_squared(center) < reach * reach
        };
        if inside && !placed.iter().any(touches) {
            placed.push(Sphere::new(center, radius, material));
        }
    }
    for sphere in placed {
        scene.add_sphere(sphere).expect("radii are above 0 and centres finite");
    }
    scene.ambient = Some(Vec3::splat(0.15));
    scene.lights = vec![
        lamp([-9.0, 12.0, 14.0], 0.5, [1.0, 0.95, 0.86]),
        lamp([14.0, 6.0, 8.0], 0.25, [1.0, 0.9, 0.8]),
        lamp([-14.0, 0.0, 4.0], 0.15, [0.75, 0.85, 1.0]),
        lamp([3.0, -12.0, 10.0], 0.1, [0.9, 0.8, 0.7]),
        lamp([0.0, 3.0, 16.0], 0.2, [1.0, 1.0, 1.0]),
    ];
    scene
}

/// Builds two spheres side by side on an infinite ground and a third one on both, under one lamp. Raghuvanshi and
/// Dhande use three configurations: with shadows alone, with reflections too, and also with textures.
pub(crate) fn three_spheres(reflecting: bool, textured: bool) -> Scene {
    const RADIUS: f32 = 1.0;
    let mut scene = Scene::new();
    scene.sky = Sky::Gradient { nadir: Vec3::new(0.62, 0.68, 0.74), zenith: Vec3::new(0.16, 0.32, 0.62) };
    let white = Vec3::splat(0.85);
    let colors = [[178, 42, 38], [40, 96, 168], [214, 160, 48]];
    for (color, [x, y]) in colors.into_iter().zip([[-1.0, 1.0], [1.0, 1.0], [0.0, 1.0 + 3.0_f32.sqrt()]]) {
        let id = paint(&mut scene, "sphere", color);
        let texture = textured.then(|| scene.add_texture(squares(scene.materials[id.0 as usize].albedo, white, 16)));
        let material = &mut scene.materials[id.0 as usize];
        if let Some(texture) = texture {
            *material = material.clone().texture(texture);
            material.albedo = Vec3::ONE;
        }
        (material.specular, material.exponent) = (Vec3::splat(0.35), 60.0);
        if reflecting {
            material.finish = Finish::Mirror { fresnel: false };
            material.albedo *= 0.6;
        }
        let center = RADIUS * Vec3::new(x, y, 0.0);
        scene.add_sphere(Sphere::new(center, RADIUS, id)).expect("it has a radius");
    }
    let mut ground = paint(&mut scene, "ground", [150, 156, 142]);
    if textured {
        let paved = scene.add_texture(squares(Vec3::splat(0.75), Vec3::new(0.12, 0.16, 0.14), 2));
        ground = scene.add_material(super::Material::new(Vec3::ONE).texture(paved).name("ground"));
    }
    scene.add_plane(Plane::new(Vec3::ZERO, Vec3::Y, ground).tile(3.0)).expect("it has a normal");
    scene.ambient = Some(Vec3::splat(0.15));
    scene.lights = vec![lamp([-4.0, 7.0, 5.0], 1.15, [1.0, 0.97, 0.9])];
    scene
}

fn squares(first: Vec3, second: Vec3, squares: u32) -> Texture {
    Texture::checkerboard(first, second, squares).expect("colours are within 0 to 1")
}

/// Returns the camera of the three spheres. Its picture contains the horizon.
pub(crate) fn three_camera() -> StereoCamera {
    StereoCamera::look_at(Vec3::new(1.2, 2.4, 8.5), Vec3::new(0.0, 1.5, 0.0))
        .screen_distance(8.0)
        .vertical_fov_degrees(35.0)
}
