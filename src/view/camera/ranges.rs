//! Limits of cameras in f32. Values outside them are rejected by an error that names the field (DESIGN, section 2, has
//! the measurements).

use std::ops::RangeInclusive;

use glam::DVec3;

use super::{Aperture, Circle, Field, Lenses, Pose, StereoCamera, lens::least_lens_angle};
use crate::Error;

/// Longest side of a picture in pixels. In larger pictures f32 can't distinguish the pixels' directions at any field of
/// view: see [`MIN_PIXEL_ANGLE`].
pub const MAX_SIDE: u32 = 1 << 17;

/// Largest coordinate relative to [`Scene::origin`](crate::Scene::origin), in world units. Larger coordinates are
/// rejected, since they overflow f32 in the traversal's box tests.
pub const MAX_COORDINATE: f32 = 1e8;

/// Least length of a scene's longest side, in world units. In smaller scenes the products of an intersection vanish in
/// f32. A larger scene may contain smaller objects.
pub const MIN_EXTENT: f32 = 1e-6;

/// Largest world coordinate of the eyes and of the target. Beyond it, f64 rounds positions by more than 1e-3.
pub const MAX_WORLD_COORDINATE: f64 = 1e13;

/// Largest distance of the rendered eyes from [`Scene::origin`](crate::Scene::origin), along each axis. It is twice the
/// limit of a scene's coordinates, so every scene can be seen from outside. Farther off, the traversal's box tests
/// overflow f32.
pub const MAX_EYE_COORDINATE: f32 = 2e8;

/// Range of finite screen distances in world units. Below it, primitives of a pixel's size are so small that the
/// products of an intersection vanish in f32.
pub const SCREEN_DISTANCES: RangeInclusive<f32> = 1e-6..=1e9;

/// Least angle in radians that a pixel must span as seen from its eye: 2⁻¹⁸, or 0.8 seconds of arc. The error of an f32
/// direction is about a tenth of it.
///
/// Pixels in the picture's corners span the least angle, `s d / (d² + c²)`. Here `d` is the screen's distance, and
/// `s` is the shorter side of a pixel on the screen. `c` is the corner's distance from the screen point straight ahead
/// of the eye. If the screen is at infinity, the formula holds for any plane in front of the eyes.
///
/// The angle is too small if the field of view is too narrow or too wide, or if there are too many pixels. Eyes too far
/// apart and principal points too far outside the picture also make it too small.
pub const MIN_PIXEL_ANGLE: f32 = 1.0 / 262_144.0;

/// Largest change of the interaxial by rounding of the eyes' positions to f32, as a share of the interaxial.
pub const MAX_EYE_SHIFT: f32 = 0.25;

/// Returns an [`Error::Camera`].
pub(super) fn fault<T>(field: &'static str, value: String, reason: &'static str) -> Result<T, Error> {
    Err(Error::Camera { field, value, reason })
}

/// Checks size, eye, target and up.
pub(super) fn check_fields(camera: &StereoCamera) -> Result<(), Error> {
    let (width, height) = (camera.width, camera.height);
    if width == 0 || height == 0 {
        return fault("size", format!("{width}x{height}"), "width and height must be at least 1");
    }
    if width.max(height) > MAX_SIDE {
        return fault("size", format!("{width}x{height}"), "width and height must be at most 131072 (2^17)");
    }
    for (field, value) in [("eye", camera.eye), ("target", camera.target)] {
        if !(value.is_finite() && value.abs().max_element() <= MAX_WORLD_COORDINATE) {
            return fault(field, format!("{:?}", value.to_array()), "its coordinates must be numbers within ±1e13");
        }
    }
    if !camera.up.is_finite() {
        return fault("up", camera.up.to_string(), "its coordinates must be finite numbers");
    }
    Ok(())
}

pub(super) fn check_screen_distance(distance: f32) -> Result<(), Error> {
    if SCREEN_DISTANCES.contains(&distance) || distance == f32::INFINITY {
        return Ok(());
    }
    fault("screen_distance", format!("{distance:?}"), "it must lie between 1e-6 and 1e9, or be infinite")
}

/// Checks that f32 can distinguish the directions of neighbouring pixels.
pub(super) fn check_pixel_angles(camera: &StereoCamera, pose: &Pose) -> Result<(), Error> {
    let too_small = |angle: f64| angle.is_nan() || angle < f64::from(MIN_PIXEL_ANGLE);
    let angle = least_pixel_angle(pose, 0.0);
    if too_small(angle) {
        let [w, h] = pose.size;
        let (field, value) = match camera.aperture {
            _ if matches!(pose.field, Field::Lenses(_)) => ("lens", "of these focal lengths".into()),
            Aperture::VerticalFov(degrees) => ("vertical_fov", format!("{degrees:?}")),
            Aperture::ScreenWidth(width) => ("screen_width", format!("{width:?}")),
            Aperture::Lenses(Lenses { focal: [fx, fy], principal: [cx, cy] }) => {
                ("intrinsics", format!("fx {fx}, fy {fy}, cx {cx}, cy {cy}"))
            }
        };
        let reason = "pixels must span at least 3.8e-6 radians (2^-18) in the picture's corners: use fewer pixels, a \
                      less extreme field of view, or a principal point nearer to the picture";
        return fault(field, format!("{value}, so a pixel of the {w}x{h} picture spans {angle:.1e} radians"), reason);
    }
    let angle = least_pixel_angle(pose, 0.5);
    if too_small(angle) {
        let reason = "the eyes are so far apart that they see the screen at too flat an angle: pixels must span at \
                      least 3.8e-6 radians (2^-18)";
        let interaxial = camera.interaxial_text();
        return fault("interaxial", format!("{interaxial}, and pixels span {angle:.1e} radians"), reason);
    }
    Ok(())
}

/// Checks that f32 can represent the eyes of a rendered pose.
pub(super) fn check_eyes(camera: &StereoCamera, pose: &Pose) -> Result<(), Error> {
    let farthest = DVec3::splat(f64::from(MAX_EYE_COORDINATE));
    if pose.local(pose.eye).abs().cmpgt(farthest).any() {
        let reason = "its coordinates must lie within ±2e8 of the scene's origin";
        return fault("eye", format!("{:?}", pose.eye.to_array()), reason);
    }
    let eyes = [-1.0, 1.0].map(|side| pose.eye_in_scene(side).as_dvec3());
    if eyes.iter().any(|eye| eye.abs().cmpgt(farthest).any()) {
        let reason = "it moves an eye's coordinates beyond ±2e8 of the scene's origin";
        return fault("interaxial", camera.interaxial_text(), reason);
    }
    if pose.baseline_rounding().length() > f64::from(MAX_EYE_SHIFT * pose.interaxial) {
        let reason = "so far from the scene's origin, rounding to f32 moves the eyes by more than a quarter of it: \
                      increase it, or set a scene origin nearer to the camera";
        return fault("interaxial", camera.interaxial_text(), reason);
    }
    Ok(())
}

/// Returns the least angle in radians that a corner pixel spans, for eyes up to `offset` interaxials to either side of
/// the midpoint.
pub(crate) fn least_pixel_angle(pose: &Pose, offset: f64) -> f64 {
    match pose.field {
        Field::Screen(frustum) => {
            let [x, y] = frustum.aside(offset);
            let [across, down] = frustum.steps(pose.size);
            across.min(down) / (1.0 + x * x + y * y)
        }
        Field::Sphere(sphere) => {
            let [across, down] = Circle::of(pose, &sphere).steps;
            across.min(down)
        }
        Field::Lenses(lenses) => least_lens_angle(&lenses, pose.size),
    }
}
