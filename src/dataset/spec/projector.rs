//! A projector that a rig carries, for active stereo.

use serde::Serialize;
use serde_json::Value;

use super::{
    fields::{Fields, above_zero, array, fault, from_zero, point, text, whole},
    read::drawn,
};
use crate::{Error, Texture, dataset::draws::Drawn};

/// Default picture: this many dots, in a picture of this size.
const DOTS: u32 = 5000;
const SIZE: [u32; 2] = [1280, 800];
/// Default horizontal field of view in degrees.
const FOV: f64 = 75.0;

/// A projector that is fixed to the cameras.
#[derive(Clone, Debug, Serialize)]
pub(in crate::dataset) struct ProjectorEntry {
    /// Number of random dots, the same ones for all items, in a picture of this size.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::dataset) dots: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::dataset) size: Option<[u32; 2]>,
    /// File of another picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::dataset) picture: Option<String>,
    /// Horizontal field of view in degrees.
    pub(in crate::dataset) fov: Drawn<f64>,
    /// Light on a white surface at a distance of one world unit. It falls with the square of the distance.
    pub(in crate::dataset) intensity: Drawn<f64>,
    /// Place to the right of the middle between the eyes, above it and in front of it, in world units.
    pub(in crate::dataset) offset: [f64; 3],
}

pub(super) fn projector(value: &Value, at: &str) -> Result<ProjectorEntry, Error> {
    let fields = Fields::of(value, at)?;
    let intensity = fields.get("intensity", drawn(from_zero()))?;
    let mut found = ProjectorEntry {
        dots: fields.get("dots", whole(1, u32::MAX))?,
        size: fields.get("size", array(whole(1, u32::MAX)))?,
        picture: fields.get("picture", text)?,
        fov: fields.get("fov", drawn(above_zero(180.0)))?.unwrap_or(Drawn::Value(FOV)),
        intensity: fields.needed("intensity", intensity)?,
        offset: fields.get("offset", point)?.unwrap_or_default(),
    };
    fields.end()?;
    if found.picture.is_some() {
        return match found.dots.is_some() || found.size.is_some() {
            true => fault(at, "picture takes the place of dots and size; give it alone"),
            false => Ok(found),
        };
    }
    let ([width, height], dots) = (found.size.unwrap_or(SIZE), found.dots.unwrap_or(DOTS));
    if let Err(error) = Texture::dots(width, height, dots, 0) {
        return fault(at, error.to_string());
    }
    (found.size, found.dots) = (Some([width, height]), Some(dots));
    Ok(found)
}
