//! Cameras, which are plain objects in JavaScript.

use serde::{Deserialize, Serialize};
use stereotrace::{
    Equirectangular, PoleMerge, Projection, Span, StereoCamera,
    glam::{DVec3, Vec3},
};
use wasm_bindgen::JsValue;

use crate::{
    errors::{raised, refused},
    values,
};

/// `Camera` of `types.d.ts`.
#[derive(Deserialize, Serialize)]
#[serde(rename_all = "camelCase")]
struct Camera {
    eye: [f64; 3],
    target: [f64; 3],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    up: Option<[f32; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    size: Option<[u32; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    fov: Option<f32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    screen_distance: Option<f32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    interaxial: Option<f32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    interaxial_pixels: Option<f32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    toe_in: Option<bool>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    projection: Option<u32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pole_merge: Option<Merge>,
}

/// `poleMerge` of `types.d.ts`: two elevations in degrees, or false.
#[derive(Deserialize, Serialize)]
#[serde(untagged)]
enum Merge {
    Angles([f32; 2]),
    On(bool),
}

impl Merge {
    fn read(&self) -> Option<PoleMerge> {
        match *self {
            Self::Angles([from, to]) => Some(PoleMerge { from, to }),
            Self::On(on) => on.then(PoleMerge::default),
        }
    }

    fn written(merge: Option<PoleMerge>) -> Self {
        merge.map_or(Self::On(false), |PoleMerge { from, to }| Self::Angles([from, to]))
    }
}

/// Converts a plain object to a camera.
pub(crate) fn read(value: JsValue) -> Result<StereoCamera, JsValue> {
    let Camera {
        eye,
        target,
        up,
        size,
        fov,
        screen_distance,
        interaxial,
        interaxial_pixels,
        toe_in,
        projection,
        pole_merge,
    } = values::read("camera", value)?;
    let mut camera = StereoCamera::look_at(DVec3::from_array(eye), DVec3::from_array(target));
    if interaxial.is_some() && interaxial_pixels.is_some() {
        return Err(refused("camera: interaxial and interaxialPixels set the same value; give one of them"));
    }
    camera = up.map_or(camera, |up| camera.up(Vec3::from_array(up)));
    camera = size.map_or(camera, |[width, height]| camera.size(width, height));
    camera = fov.map_or(camera, |degrees| camera.vertical_fov_degrees(degrees));
    camera = screen_distance.map_or(camera, |distance| camera.screen_distance(distance));
    camera = interaxial.map_or(camera, |distance| camera.interaxial(distance));
    camera = interaxial_pixels.map_or(camera, |pixels| camera.interaxial_pixels(pixels));
    if toe_in == Some(true) {
        camera = camera.projection(Projection::ToeIn);
    }
    if let Some(degrees) = projection {
        let span = Span::from_degrees(degrees.into());
        let span = span.ok_or_else(|| refused(&format!("camera: projection: {degrees}; use 360 or 180")))?;
        let merge = pole_merge.map_or_else(|| Some(PoleMerge::default()), |merge| merge.read());
        camera = camera.projection(Projection::Equirectangular(Equirectangular { span, merge }));
    }
    camera.pose().map_err(raised)?;
    Ok(camera)
}

/// Converts a camera to a plain object. Its principal point must be the picture's middle, as for all scenes' cameras.
pub(crate) fn written(camera: &StereoCamera) -> Result<JsValue, JsValue> {
    let pose = camera.pose().map_err(raised)?;
    let focal = pose.focal_px().map(|[_, focal]| focal);
    let around = pose.projection.equirectangular();
    values::written(&Camera {
        eye: pose.eye.to_array(),
        target: camera.target_position().to_array(),
        up: Some(camera.up_direction().to_array()),
        size: Some(pose.size),
        fov: focal.map(|focal| (2.0 * (0.5 * f64::from(pose.size[1]) / focal).atan()).to_degrees() as f32),
        screen_distance: around.is_none().then_some(pose.screen_distance),
        interaxial: Some(pose.interaxial),
        interaxial_pixels: None,
        toe_in: (pose.projection == Projection::ToeIn).then_some(true),
        projection: around.map(|around| around.span.degrees() as u32),
        pole_merge: around.map(|around| Merge::written(around.merge)),
    })
}
