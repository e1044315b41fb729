//! Motion of an item's camera and objects to its next pair.

use glam::{Affine3A, DQuat, DVec3, Vec3};

use super::{
    draws::Draws,
    spec::{CameraMotion, ObjectMotion},
};
use crate::{Error, Pose, Scene, StereoCamera};

/// Objects whose box has a longer diagonal than this share of the scene's do not move: they are walls and floors.
const LARGEST: f64 = 0.25;

/// Returns the camera moved and turned in its own frame, by a share of the drawn motion. The share is 1 at the next
/// pair.
pub(super) fn moved_camera(
    camera: StereoCamera,
    motion: &CameraMotion,
    draws: &Draws,
    share: f64,
) -> Result<StereoCamera, Error> {
    let draw = |value: &Option<_>, name: &str| {
        share * value.as_ref().map_or(0.0, |value| draws.draw(value, &format!("motion.camera.{name}")))
    };
    let Pose { right, up, forward, .. } = camera.pose()?;
    let [right, up, forward] = [right, up, forward].map(|axis| axis.as_dvec3());
    let step =
        right * draw(&motion.right, "right") + up * draw(&motion.up, "up") + forward * draw(&motion.forward, "forward");
    let about = |axis: DVec3, degrees: f64| DQuat::from_axis_angle(axis.normalize(), degrees.to_radians());
    // A positive turn is to the right, a positive rise upwards, and a positive roll clockwise in the picture.
    let turn = about(up, -draw(&motion.turn, "turn"))
        * about(right, draw(&motion.rise, "rise"))
        * about(forward, draw(&motion.roll, "roll"));
    let (eye, target) = (camera.eye_position(), camera.target_position());
    let moved = camera.eye(eye + step).target(eye + step + turn * (target - eye));
    let moved = moved.up((turn * camera.up_direction().as_dvec3()).as_vec3());
    moved.pose()?;
    Ok(moved)
}

/// Moves some of the scene's objects, each in a drawn direction and about a drawn axis through its middle, by a share
/// of the drawn motion. The share is 1 at the next pair. Objects that can't move stay; without a list, all can.
pub(super) fn move_objects(
    scene: &mut Scene,
    (motion, can_move): (&ObjectMotion, &[bool]),
    draws: &Draws,
    share: f64,
) -> Result<(), Error> {
    let boxes = scene.object_boxes();
    let whole = scene.bounds().map_or(0.0, |(low, high)| low.distance(high));
    for (object, bounds) in (0..).zip(boxes) {
        let name = |what: &str| format!("motion.objects.{object}.{what}");
        let Some((low, high)) = bounds.filter(|(low, high)| f64::from(low.distance(*high)) <= LARGEST * whole) else {
            continue;
        };
        if can_move.get(object as usize) == Some(&false) || draws.unit(&name("share")) >= motion.share {
            continue;
        }
        let (distance, angle) =
            (draws.draw(&motion.distance, &name("distance")), draws.draw(&motion.turn, &name("turn")));
        let step = direction(draws, &name("direction")) * (share * distance);
        let turn = DQuat::from_axis_angle(direction(draws, &name("axis")), share * angle.to_radians());
        let (center, turn) = (low.midpoint(high), turn.as_quat());
        let transform = Affine3A::from_translation(center + step.as_vec3())
            * Affine3A::from_quat(turn)
            * Affine3A::from_translation(-center);
        scene.transform_object(object, &transform)?;
    }
    Ok(())
}

/// Draws a direction, all alike.
fn direction(draws: &Draws, name: &str) -> DVec3 {
    let height = 2.0 * draws.unit(&format!("{name}.height")) - 1.0;
    let (sin, cos) = (std::f64::consts::TAU * draws.unit(&format!("{name}.azimuth"))).sin_cos();
    let around = (1.0 - height * height).sqrt();
    DVec3::new(around * cos, height, around * sin).normalize_or(DVec3::from(Vec3::Y))
}
