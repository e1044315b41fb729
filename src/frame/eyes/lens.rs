//! Uniform of an eye with a lens.

use glam::DVec3;

use crate::{Distortion, Lens, Pose, kernel::layout};

const _: () = assert!(size_of::<layout::LensEyes>() == size_of::<layout::Eyes>());

/// Returns the uniform that describes an eye with a lens to kernels.
pub(super) fn uniform(pose: &Pose, lens: &Lens) -> layout::Eyes {
    let Lens { fx, fy, cx, cy, distortion, .. } = *lens;
    let direction = |x: f64, y: f64, z: f64| pose.in_world(DVec3::new(x, -y, z)).as_vec3().to_array();
    let (radial, divisor, tangential) = match distortion {
        Distortion::RadialTangential { k: [k1, k2, k3, k4, k5, k6], p } => {
            ([k1 - k4, k2 - k5, k3 - k6, 0.0], [k4, k5, k6, 0.0], p)
        }
        Distortion::Fisheye { k } => (k, [0.0; 4], [0.0; 2]),
    };
    bytemuck::cast(layout::LensEyes {
        target_eye: pose.eye_in_scene(0.0).to_array(),
        focal_x: fx as f32,
        target_corner: direction(-cx / fx, -cy / fy, 1.0),
        focal_y: fy as f32,
        step_x: direction(1.0 / fx, 0.0, 0.0),
        principal_x: cx as f32,
        step_y: direction(0.0, 1.0 / fy, 0.0),
        principal_y: cy as f32,
        radial: radial.map(|number| number as f32),
        divisor: divisor.map(|number| number as f32),
        tangential: tangential.map(|number| number as f32),
        ..Default::default()
    })
}
