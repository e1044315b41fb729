//! The projector of a rig: a light that moves with the cameras.

use glam::Vec3;

use super::{
    draws::Draws,
    spec::{ProjectorEntry, Spec},
};
use crate::{Error, Light, Pose, Texture, TextureId};

/// A projector with the values of an item.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projector {
    texture: TextureId,
    /// Horizontal field of view in radians.
    fov: f32,
    intensity: f32,
    /// Place to the right of the rig's middle, above it and in front of it.
    offset: [f64; 3],
}

/// Reads or makes the picture of the spec's projector.
pub(super) fn picture(spec: &Spec) -> Result<Option<Texture>, Error> {
    let Some(entry) = &spec.rig.projector else { return Ok(None) };
    match (&entry.picture, entry.size, entry.dots) {
        (Some(file), ..) => Texture::open(spec.path_of(file)).map(Some),
        (None, Some([width, height]), Some(dots)) => Texture::dots(width, height, dots, spec.seed).map(Some),
        _ => Ok(None),
    }
}

impl Projector {
    pub(super) fn drawn(entry: &ProjectorEntry, draws: &Draws, texture: TextureId) -> Self {
        let draw = |value, name: &str| draws.draw(value, &format!("rig.projector.{name}"));
        let fov = draw(&entry.fov, "fov").to_radians() as f32;
        Self { texture, fov, intensity: draw(&entry.intensity, "intensity") as f32, offset: entry.offset }
    }

    /// Returns the light for a rig at this pose.
    pub(super) fn at(&self, pose: &Pose) -> Light {
        let axes = [pose.right, pose.up, pose.forward].map(|axis| axis.as_dvec3());
        let place = axes.iter().zip(self.offset).fold(pose.eye, |place, (axis, step)| place + *axis * step);
        Light::point(place, Vec3::splat(self.intensity)).with_quadratic_falloff().with_projector(
            self.texture,
            pose.forward,
            pose.up,
            self.fov,
        )
    }
}
