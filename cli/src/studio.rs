//! Sets the automatic look of a scene file: a view from a corner, soft light and a plain backdrop. `--plain` disables
//! the automatic look, and options replace its settings.

use stereotrace::{
    Light, Pose, Scene, Sky, StereoCamera,
    glam::{DVec3, Vec3},
};

/// Direction from the object to the eyes: right, up and towards the front.
const CORNER: Vec3 = Vec3::new(0.62, 0.42, 0.8);
/// Direction from the object to the light, in the frame of the eyes: right, up and towards the eyes.
const KEY: Vec3 = Vec3::new(-0.55, 0.8, 0.6);
/// Radius of the light, as a share of its distance from the object.
const KEY_RADIUS: f32 = 0.2;
const KEY_INTENSITY: Vec3 = Vec3::new(0.78, 0.75, 0.7);
/// Linear red, green and blue of the ambient light.
const FILL: Vec3 = Vec3::new(0.36, 0.38, 0.41);
/// Default radius of ambient occlusion, as a share of the object's diagonal.
pub(crate) const REACH: f32 = 0.3;
/// Number of samples per pixel, and of shadow rays per sample. Both numbers are small, since they multiply.
pub(crate) const SAMPLES: u32 = 4;
pub(crate) const RAYS: u32 = 4;
/// Light by paths: their number per sample, and their bounces.
pub(crate) const PATHS: &str = "paths=4:3";

/// Returns the camera moved around the object to a corner, or unchanged if the moved camera is out of range.
pub(crate) fn from_a_corner(camera: StereoCamera) -> StereoCamera {
    let Ok(pose) = camera.pose() else { return camera };
    let moved = camera.eye(center(&pose) + (CORNER.normalize() * pose.subject_distance).as_dvec3());
    if moved.pose().is_ok() { moved } else { camera }
}

/// Replaces the scene's lights by one soft light, and sets ambient light if the scene has none.
pub(crate) fn light(scene: &mut Scene, camera: &StereoCamera) -> Result<(), stereotrace::Error> {
    let pose = camera.pose()?;
    let way = pose.right * KEY.x + pose.up * KEY.y - pose.forward * KEY.z;
    let radius = KEY_RADIUS * pose.subject_distance;
    let place = center(&pose) + (way.normalize() * pose.subject_distance).as_dvec3();
    scene.lights = vec![Light::sphere(place, radius, KEY_INTENSITY)];
    scene.ambient.get_or_insert(FILL);
    Ok(())
}

/// Returns the point that the camera looks at, the middle of the object, in world coordinates.
fn center(pose: &Pose) -> DVec3 {
    pose.eye + (pose.forward * pose.subject_distance).as_dvec3()
}

pub(crate) fn backdrop() -> Sky {
    Sky::Gradient { nadir: Vec3::new(0.26, 0.27, 0.29), zenith: Vec3::new(0.52, 0.56, 0.62) }
}
