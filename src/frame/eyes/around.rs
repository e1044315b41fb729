//! Omnidirectional eyes on a circle, whose rays are tangents of the circle (Ishiguro 1992; Peleg & Ben-Ezra 1999). Only
//! `naive` renders them, in a test. The test shows that a further camera model needs only this file and the sections
//! `camera is around` of camera.wgsl.

use std::f32::consts::{PI, TAU};

use glam::Vec3;

use crate::{kernel::layout, view::rig::Eyes};

/// Returns the uniform of a view. `target_eye` is the circle's centre, and `shift` is its radius, negative for a left
/// eye. A picture of w x h pixels has columns of `step_x.x` radians and rows of `step_y.y` radians.
pub(super) fn uniform(eyes: &Eyes, view: usize) -> layout::Eyes {
    let [width, height] = eyes.pose.size.map(|side| side as f32);
    layout::Eyes {
        target_eye: eyes.pose.eye_in_scene(0.0).to_array(),
        shift: eyes.offsets[view] * eyes.pose.interaxial,
        step_x: [TAU / width, 0.0, 0.0],
        step_y: [0.0, PI / height, 0.0],
        right_axis: Vec3::X.to_array(),
        forward: Vec3::NEG_Z.to_array(),
        pixel_side: 1.0,
        ..Default::default()
    }
}
