//! What scenes are lit by.

use std::path::PathBuf;

use clap::Args;
use stereotrace::{Gpu, Light, LightShape, Limits, Scene, Sky, SkyMap, StereoCamera, glam::Vec3};

use super::values::{above_zero, ambient, light};

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Light")]
pub(crate) struct LightArguments {
    /// Place a light, in world units and linear light, in place of the scene's own; with a radius it is a ball. May be
    /// given again
    #[arg(long, value_name = "X,Y,Z[:R,G,B[:RADIUS]]", value_parser = light, allow_hyphen_values = true, conflicts_with = "lights")]
    light: Vec<Light>,
    /// Place N lights around the eyes [default: the scene's own; a soft one for a file without, 5 with --plain]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=1000), allow_hyphen_values = true)]
    lights: Option<u32>,
    /// Make lights balls of this radius, in world units: shadows get a penumbra
    #[arg(long, value_name = "R", value_parser = above_zero, allow_hyphen_values = true)]
    light_radius: Option<f32>,
    /// Light from all around, linear: one number, or red, green and blue [default: the scene's; 0.15, or 1 where there
    /// are no lights]
    #[arg(long, value_name = "V|R,G,B", value_parser = ambient, allow_hyphen_values = true)]
    ambient: Option<Vec3>,
    /// Sky: a PNG, JPEG, HDR or EXR file (equirectangular), or `procedural` [default: the scene's]
    #[arg(long, value_name = "FILE")]
    sky: Option<PathBuf>,
}

impl LightArguments {
    /// Whether it is said which lights there are.
    pub(crate) fn are_said(&self) -> bool {
        self.lights.is_some() || !self.light.is_empty()
    }

    /// Whether so many are to be placed around the camera.
    #[cfg(feature = "view")]
    pub(crate) fn are_counted(&self) -> bool {
        self.lights.is_some()
    }

    /// Puts the lights that are asked for in place of the scene's, by `otherwise` where none are, and gives all their
    /// size.
    pub(crate) fn place(
        &self,
        scene: &mut Scene,
        camera: &StereoCamera,
        otherwise: impl FnOnce(&mut Scene) -> Result<(), stereotrace::Error>,
    ) -> Result<(), stereotrace::Error> {
        match self.lights {
            Some(count) => scene.place_lights(count as usize, camera)?,
            None if self.light.is_empty() => otherwise(scene)?,
            None => scene.lights.clone_from(&self.light),
        }
        if let Some(radius) = self.light_radius {
            for light in scene.lights.iter_mut().filter(|light| light.shape == LightShape::Point) {
                *light = Light::sphere(light.position, radius, light.intensity);
            }
        }
        scene.ambient = self.ambient.or(scene.ambient);
        Ok(())
    }

    /// The file that the sky is read from.
    pub(super) fn file(&self) -> Option<PathBuf> {
        self.sky.clone().filter(|name| name.as_os_str() != "procedural")
    }

    /// The sky that is asked for, once it is known what the adapter can hold.
    pub(crate) fn sky(&self, limits: Limits, gpu: &Gpu) -> Result<Option<Sky>, stereotrace::Error> {
        Ok(match &self.sky {
            None => None,
            Some(name) if name.as_os_str() == "procedural" => Some(Sky::Map(SkyMap::procedural(1024)?)),
            Some(file) => Some(Sky::Map(SkyMap::open_within(file, &limits.gpu(gpu))?)),
        })
    }
}
