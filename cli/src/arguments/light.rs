//! Defines the options of lights, ambient light and sky.

use std::path::PathBuf;

use clap::{
    Args,
    builder::{PathBufValueParser, TypedValueParser},
};
use stereotrace::{Gpu, Light, LightShape, Limits, Scene, Sky, SkyMap, StereoCamera, glam::Vec3};

use super::values::{SkyArgument, above_zero, ambient, light, sky};

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "How it is lit")]
pub(crate) struct LightArguments {
    /// Replace the scene's lights by a light with this position in world units and linear colour. A radius makes the
    /// light a sphere with soft shadows. Repeat the option for more lights
    #[arg(
        long,
        value_name = "X,Y,Z[:R,G,B[:RADIUS]]",
        value_parser = light,
        allow_hyphen_values = true,
        conflicts_with = "lights"
    )]
    light: Vec<Light>,
    /// Replace the scene's lights by N lights around the eyes [default: the scene's own lights; for a file without
    /// lights, one soft light, or 5 with --plain or --cameras]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=1000), allow_hyphen_values = true)]
    lights: Option<u32>,
    /// Turn point lights into spheres of this radius, in world units, so that shadows get a penumbra
    #[arg(long, value_name = "R", value_parser = above_zero, allow_hyphen_values = true)]
    light_radius: Option<f32>,
    /// Ambient light in linear units: one number, or red, green and blue [default: the scene's value; else
    /// 0.36,0.38,0.41 with the automatic light of a file, 0.15 with other lights, and 1 without lights]
    #[arg(long, value_name = "V|R,G,B", value_parser = ambient, allow_hyphen_values = true)]
    ambient: Option<Vec3>,
    /// Sky: an equirectangular PNG, JPEG, HDR or EXR file (HDRI, environment map), `procedural`, or linear light: one
    /// number, or red, green and blue
    ///
    /// By default it is the scene's sky. A file without one gets a grey backdrop, or black with --plain or --cameras.
    #[arg(long, value_name = "FILE|V|R,G,B", value_parser = PathBufValueParser::new().try_map(sky))]
    sky: Option<SkyArgument>,
    /// Turn the sky to the right, in degrees about the world's y axis
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    sky_turn: Option<f64>,
    /// Multiply the sky's light, 0 or more
    #[arg(long, value_name = "FACTOR", allow_hyphen_values = true)]
    sky_gain: Option<f32>,
}

impl LightArguments {
    /// Returns whether --lights or --light is given.
    pub(crate) fn are_said(&self) -> bool {
        self.lights.is_some() || !self.light.is_empty()
    }

    /// Returns whether --lights is given.
    #[cfg(feature = "view")]
    pub(crate) fn are_counted(&self) -> bool {
        self.lights.is_some()
    }

    /// Replaces the scene's lights by the lights of the options, and sets radius and ambient light. If no option gives
    /// lights, `otherwise` places them.
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

    /// Returns the file that the sky is read from.
    pub(super) fn file(&self) -> Option<PathBuf> {
        if let Some(SkyArgument::File(file)) = &self.sky { Some(file.clone()) } else { None }
    }

    /// Reads or makes the sky of --sky, within the adapter's limits, or takes the scene's own sky.
    pub(crate) fn sky(&self, own: Sky, limits: Limits, gpu: &Gpu) -> Result<Sky, stereotrace::Error> {
        let sky = match &self.sky {
            None => own,
            Some(SkyArgument::Color(light)) => Sky::Constant(*light),
            Some(SkyArgument::Procedural) => Sky::Map(SkyMap::procedural(1024)?),
            Some(SkyArgument::File(file)) => Sky::Map(SkyMap::open_within(file, &limits.gpu(gpu))?),
        };
        let (turn, gain) = (self.sky_turn.unwrap_or(0.0), self.sky_gain.unwrap_or(1.0));
        Ok(match sky {
            Sky::Map(map) => Sky::Map(map.turned(turn)?.scaled(gain)?),
            Sky::Constant(light) => Sky::Constant(light * gain),
            Sky::Gradient { nadir, zenith } => Sky::Gradient { nadir: nadir * gain, zenith: zenith * gain },
            _ => sky,
        })
    }
}
