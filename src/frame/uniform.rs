//! The camera as kernels read it.

use glam::{DVec3, Vec3};

use crate::{Pose, camera::least_pixel_angle, layout};

/// Of an ordinary picture, whose pixels span 2e-5 radians and more: far more than the rounding of a projection.
const WIDER: f32 = 0.05;

/// Two eyes as kernels read them: offsets from the middle along `pose.right`, in interaxials. Directions have length 1 along the
/// view axis: a ray's t is the depth Z.
pub(crate) fn frame_uniform(pose: &Pose, source: f32, target: f32) -> layout::Frame {
    let [w, h] = pose.size.map(f64::from);
    let [screen_width, screen_height] = pose.screen_size.map(f64::from);
    let (d, e) = (f64::from(pose.screen_distance), f64::from(pose.interaxial));
    let [forward, right, up] = [pose.forward, pose.right, pose.up].map(Vec3::as_dvec3);
    let corner = |offset: f32| {
        let x = -0.5 * screen_width - f64::from(offset) * e;
        (forward + right * (x / d) + up * (0.5 * screen_height / d)).as_vec3().to_array()
    };
    let array = |v: DVec3| v.as_vec3().to_array();
    // To the corner of the picture that lies farthest aside, of either eye.
    let far = f64::from(source.abs().max(target.abs()));
    let aside = ((0.5 * screen_width + far * e) / d).hypot(0.5 * screen_height / d);
    let longest = (1.0_f64.hypot(aside) * 1.001) as f32;
    let parallax_px = (target - source) * pose.interaxial_px;
    layout::Frame {
        source_eye: pose.eye_position(2.0 * source).to_array(),
        target_eye: pose.eye_position(2.0 * target).to_array(),
        source_corner: corner(source),
        target_corner: corner(target),
        step_x: array(right * (screen_width / w / d)),
        step_y: array(up * (-screen_height / h / d)),
        right_axis: pose.right.to_array(),
        forward: pose.forward.to_array(),
        longest,
        parallax_px,
        shift: (target - source) * pose.interaxial,
        same_parallax: same_parallax(pose, target - source),
        screen_distance: pose.screen_distance,
        image_size: pose.size,
        row_end: pose.size[1],
        wider: wider(pose, 2.0 * far),
        ..layout::Frame::default()
    }
}

/// A sample vouches for a point beside it, in shadow bits, if the surface between them may be one that recedes by no more than so many
/// pixels a pixel, of a pixel's size on the screen: 88.4 degrees. (Nearer than the screen the angle is larger, beyond it less.)
const STEEPEST: f32 = 36.0;
const MOST_PARALLAX: f32 = 0.75;

/// The same as a difference of parallaxes in pixels. It does not depend on the picture's size: with twice as many pixels neighbours lie
/// half as far apart, and a pixel of parallax is half as much depth. With eyes 15 pixels of 600 apart and 45 degrees of view it is 0.75,
/// and never more.
pub(crate) fn same_parallax(pose: &Pose, apart: f32) -> f32 {
    MOST_PARALLAX.min(STEEPEST * (apart * pose.interaxial).abs() / pose.screen_distance)
}

/// Pixels by which the search of a tile widens projected bounds: four times what the directions of this picture's corners
/// may be rounded by, and never less than in an ordinary picture.
fn wider(pose: &Pose, span: f64) -> f32 {
    let pixel_angle = least_pixel_angle(pose, span * f64::from(pose.interaxial));
    WIDER.max((f64::from(f32::EPSILON) * 8.0 / pixel_angle) as f32)
}
