//! Reads cameras.

use std::{collections::HashMap, sync::Arc};

use glam::DVec3;
use gltf_json::{camera::Type, validation::Checked};

use super::{Placed, document::Document};
use crate::{
    Error, StereoCamera,
    import::warnings::{Place, Warnings},
};

/// Default height of a camera's picture in pixels.
const HEIGHT: u32 = 480;
/// Largest ratio of a picture's sides.
const MOST_ASPECT: f32 = 16.0;

/// A camera with its node and its name.
pub(super) struct AtNode {
    pub(super) node: usize,
    pub(super) name: Arc<str>,
    pub(super) camera: StereoCamera,
}

/// Reads perspective cameras with their nodes' names. A glTF camera has no screen. The screen is placed at the centre
/// of the scene's box, but at least a quarter of the box's diagonal away. The interaxial is a thirtieth of that
/// distance.
pub(super) fn read(
    document: &Document,
    places: &[Placed<(usize, usize)>],
    bounds: Option<(DVec3, DVec3)>,
    warnings: &mut Warnings,
) -> Result<Vec<AtNode>, Error> {
    let root = &document.root;
    let (low, high) = bounds.unwrap_or_default();
    let mut cameras = Vec::new();
    // All nodes of a camera share its name, since it may be long and the nodes many.
    let mut names: HashMap<usize, Arc<str>> = HashMap::new();
    for &((node, index), place) in places {
        let description = document.item(("cameras", &root.cameras), index, format_args!("nodes[{node}]"))?;
        let fault = |reason: String| document.fault(format!("cameras[{index}]: {reason}"));
        match description.type_ {
            Checked::Valid(Type::Perspective) => {}
            Checked::Valid(Type::Orthographic) => {
                warnings.left_out("orthographic cameras", Place::Item("cameras", index));
                continue;
            }
            Checked::Invalid => return Err(fault("its type is unknown".into())),
        }
        let perspective = description.perspective.as_ref().ok_or_else(|| fault("it has no perspective".into()))?;
        let (eye, forward) = (place.translation, place.transform_vector3(DVec3::NEG_Z).normalize_or_zero());
        let distance = (low.midpoint(high) - eye).dot(forward).max(0.25 * low.distance(high)).max(1e-6);
        let aspect = perspective.aspect_ratio.unwrap_or(4.0 / 3.0);
        if !(1.0 / MOST_ASPECT..=MOST_ASPECT).contains(&aspect) {
            return Err(fault(format!("its aspectRatio is {aspect}; it must be within 1/16 to 16")));
        }
        let camera = StereoCamera::look_at(eye, eye + distance * forward)
            .at_node(place, distance)
            .vertical_fov_degrees(perspective.yfov.to_degrees())
            .screen_distance(distance as f32)
            .interaxial((distance / 30.0) as f32)
            .size((HEIGHT as f32 * aspect).round() as u32, HEIGHT);
        camera.pose().map_err(|error| fault(format!("at nodes[{node}]: {error}")))?;
        let own = || description.name.as_deref().map_or_else(|| format!("camera {index}").into(), Arc::from);
        let name = match root.nodes[node].name.as_deref() {
            Some(name) => name.into(),
            None => names.entry(index).or_insert_with(own).clone(),
        };
        cameras.push(AtNode { node, name, camera });
    }
    Ok(cameras)
}
