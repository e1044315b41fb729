//! Uniform of the eyes of a viewing circle.

use std::f64::consts::FRAC_PI_2;

use super::wider;
use crate::{
    kernel::layout,
    view::{
        camera::{Circle, FROM_POLE},
        rig::Eyes,
    },
};

const _: () = assert!(size_of::<layout::CircleEyes>() == size_of::<layout::Eyes>());

/// Elevations of a merge that no ray reaches, for circles of one radius.
const NO_MERGE: [f64; 2] = [4.0, 5.0];

/// Returns the uniform that describes a view and its source to kernels.
pub(super) fn uniform(eyes: &Eyes, circle: &Circle, view: usize, aside: f32) -> layout::Eyes {
    let pose = &eyes.pose;
    let merge = if circle.merge[0].is_finite() { circle.merge } else { NO_MERGE };
    let [column_step, row_step] = circle.steps.map(|step| step as f32);
    bytemuck::cast(layout::CircleEyes {
        centre: pose.eye_in_scene(0.0).to_array(),
        right_axis: pose.right.to_array(),
        // Offsets are in interaxials, which are two radii.
        target_radius: (f64::from(2.0 * eyes.offsets[view]) * circle.radius) as f32,
        up_axis: pose.up.to_array(),
        column_step,
        forward: pose.forward.to_array(),
        row_step,
        middle: circle.middle.map(|place| place as f32),
        merge: merge.map(|angle| angle as f32),
        wider: wider(pose, 0.0) + aside,
        turn: circle.turn.map_or(pose.size[0], |turn| turn.round() as u32),
        wraps: circle.turn.is_some().into(),
        most_elevation: (FRAC_PI_2 - FROM_POLE * circle.steps[1]) as f32,
        ..Default::default()
    })
}
