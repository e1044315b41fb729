//! A cloud of a thousand spheres, at rest and turned.

use glam::Vec3;

use super::{lamp, paint};
use crate::{Error, Scene, Sky, Sphere, random::Random};

pub(super) const SPHERE_COUNT: usize = 1000;
const SPHERE_RADII: [f32; 2] = [0.12, 0.45];
/// The cloud is a cylinder around the y axis, which may turn about it and stay as far from the eyes.
const CLOUD_RADIUS: f32 = 6.0;
const CLOUD_HALF_HEIGHT: f32 = 4.2;
/// The screen is at the cloud's axis, so the cloud begins at half its distance.
pub(super) const CLOUD_SCREEN: f32 = 2.0 * CLOUD_RADIUS;

/// [`Builtin::Spheres`](super::Builtin::Spheres), turned about the y axis by an angle in radians: the frames of a film.
///
/// # Errors
/// [`Error::Scene`] for an angle that is no finite number.
pub fn spheres_turned(angle: f32) -> Result<Scene, Error> {
    if !angle.is_finite() {
        return Err(Error::Scene { element: "spheres".into(), reason: format!("turned by {angle}, no finite number") });
    }
    let still = spheres();
    let turn = glam::Mat3::from_rotation_y(angle);
    let mut scene = Scene { spheres: Vec::new(), ..still.clone() };
    for &sphere in still.spheres() {
        scene.add_sphere(Sphere { center: turn * sphere.center, ..sphere })?;
    }
    Ok(scene)
}

pub(super) fn spheres() -> Scene {
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
        // The large ones first: they find no room later.
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
