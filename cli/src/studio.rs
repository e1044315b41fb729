//! How an OBJ file is shown of which nothing is said: seen from a corner, in soft light before a plain backdrop.
//! `--plain` does without, and what is asked for by name takes its place.

use stereotrace::{
    Light, Pose, Scene, Sky, StereoCamera,
    glam::{DVec3, Vec3},
};

/// From the object to the eyes: right, up and towards the front.
const CORNER: Vec3 = Vec3::new(0.62, 0.42, 0.8);
/// From the object to the light, as the eyes see it: right, up and towards them.
const KEY: Vec3 = Vec3::new(-0.55, 0.8, 0.6);
/// Of the light, in distances between it and the object.
const KEY_RADIUS: f32 = 0.2;
const KEY_INTENSITY: Vec3 = Vec3::new(0.78, 0.75, 0.7);
/// What comes from all around, but for what stands in the way within this share of the object's diagonal.
const FILL: Vec3 = Vec3::new(0.36, 0.38, 0.41);
pub(crate) const REACH: f32 = 0.3;
/// Few, since there are as many for each sample.
pub(crate) const SAMPLES: u32 = 4;
pub(crate) const RAYS: u32 = 4;

/// The camera moved around the object, as far as numbers allow.
pub(crate) fn from_a_corner(camera: StereoCamera) -> StereoCamera {
    let Ok(pose) = camera.pose() else { return camera };
    let moved = camera.eye(center(&pose) + (CORNER.normalize() * pose.subject_distance).as_dvec3());
    if moved.pose().is_ok() { moved } else { camera }
}

/// Lights the object, unless its own lights do.
pub(crate) fn light(scene: &mut Scene, camera: &StereoCamera) -> Result<(), stereotrace::Error> {
    let pose = camera.pose()?;
    let way = pose.right * KEY.x + pose.up * KEY.y - pose.forward * KEY.z;
    let radius = KEY_RADIUS * pose.subject_distance;
    let place = center(&pose) + (way.normalize() * pose.subject_distance).as_dvec3();
    scene.lights = vec![Light::sphere(place, radius, KEY_INTENSITY)];
    scene.ambient.get_or_insert(FILL);
    Ok(())
}

/// The middle of what the camera looks at, where the object is.
fn center(pose: &Pose) -> DVec3 {
    pose.eye + (pose.forward * pose.subject_distance).as_dvec3()
}

pub(crate) fn backdrop() -> Sky {
    Sky::Gradient { nadir: Vec3::new(0.26, 0.27, 0.29), zenith: Vec3::new(0.52, 0.56, 0.62) }
}
