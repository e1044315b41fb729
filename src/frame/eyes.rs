//! Uniform of a source eye and a target eye.

mod circle;
mod lens;

use crate::{
    Pose,
    kernel::layout,
    view::{
        camera::{Circle, Field, Frustum, least_pixel_angle},
        rig::Eyes,
    },
};

/// Minimum guard band of a tile's search, in pixels. Pixels of ordinary pictures span at least 2e-5 radians. For them
/// the guard band far exceeds the rounding of a projection.
const WIDER: f32 = 0.05;

/// Returns the uniform of two eyes of a planar pose. `source` and `target` are offsets from the midpoint along
/// `pose.right`, in interaxials. Directions have length 1 along the view axis, so a ray's t is the depth Z.
pub(crate) fn eyes_uniform(pose: &Pose, frustum: &Frustum, source: f32, target: f32) -> layout::Eyes {
    let corner = |offset: f32| frustum.corner(pose, offset.into()).as_vec3().to_array();
    let [step_x, step_y] = frustum.pixel_steps(pose).map(|step| step.as_vec3().to_array());
    // Tangents of the direction to the outermost corner of the picture, from either eye.
    let far = f64::from(source.abs().max(target.abs()));
    let [aside, above] = frustum.aside(far);
    let longest = (1.0_f64.hypot(aside.hypot(above)) * 1.001) as f32;
    let parallax = pose.planar_parallax(frustum).times(target - source);
    layout::Eyes {
        source_eye: pose.eye_in_scene(2.0 * source).to_array(),
        target_eye: pose.eye_in_scene(2.0 * target).to_array(),
        source_corner: corner(source),
        target_corner: corner(target),
        step_x,
        step_y,
        right_axis: pose.right.to_array(),
        forward: pose.forward.to_array(),
        longest,
        parallax_px: parallax.scale_px,
        parallax_distance: parallax.distance,
        at_infinity: parallax.at_infinity,
        shift: (target - source) * pose.interaxial,
        same_parallax: same_parallax(pose, target - source),
        wider: wider(pose, far),
        pixel_side: pixel_side(frustum.steps(pose.size)),
        ..layout::Eyes::default()
    }
}

/// Returns the square root of a pixel's height over its width. Pixels that differ from squares only by rounding count
/// as square.
fn pixel_side([x, y]: [f64; 2]) -> f32 {
    if (y / x - 1.0).abs() < 1e-6 { 1.0 } else { (y / x).sqrt() as f32 }
}

/// Returns the limit `STEEPEST` as a difference of parallaxes in pixels, at the camera's subject. `apart` is the
/// distance between the eyes in interaxials. The limit does not depend on the picture's size. With twice as many
/// pixels, neighbours are half as far apart, and a pixel of parallax corresponds to half as much depth. The limit
/// reaches its maximum, 0.75, for eyes 15 pixels of 600 apart and 45 degrees of view.
pub(crate) fn same_parallax(pose: &Pose, apart: f32) -> f32 {
    layout::MOST_PARALLAX.min(layout::STEEPEST * (apart * pose.interaxial).abs() / pose.subject_distance)
}

/// Returns the guard band of a tile's search, in pixels. It is four times the rounding of directions in the picture's
/// corners, and at least `WIDER`. `far` is the eyes' largest offset in interaxials.
fn wider(pose: &Pose, far: f64) -> f32 {
    WIDER.max((f64::from(f32::EPSILON) * 8.0 / least_pixel_angle(pose, far)) as f32)
}

impl Eyes {
    /// Returns the uniform that describes a view and its source to kernels. Samples lie up to `aside` columns beside
    /// their cells' centres; the guard band of a tile's search is wider by as much.
    pub(crate) fn uniform(&self, view: usize, aside: f32) -> layout::Eyes {
        match self.pose.field {
            Field::Screen(frustum) => {
                let eyes = self.planar(&frustum, view);
                layout::Eyes { wider: eyes.wider + aside, ..eyes }
            }
            Field::Sphere(sphere) => circle::uniform(self, &Circle::of(&self.pose, &sphere), view, aside),
            Field::Lenses([lens, _]) => lens::uniform(&self.pose, &lens),
        }
    }

    fn planar(&self, frustum: &Frustum, view: usize) -> layout::Eyes {
        let apart = self.offsets[view] - self.offsets[self.seconds[view]];
        layout::Eyes {
            second_parallax_px: self.pose.planar_parallax(frustum).times(apart).scale_px,
            second_same_parallax: same_parallax(&self.pose, apart),
            ..eyes_uniform(&self.pose, frustum, self.offsets[self.sources[view]], self.offsets[view])
        }
    }
}
