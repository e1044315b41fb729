//! Where scenes are seen from.

use std::path::PathBuf;

use clap::Args;
use stereotrace::{Limits, Scene, StereoCamera, glam::Vec3};

use super::values::point;
use crate::studio;

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Camera")]
pub(crate) struct CameraArguments {
    /// JSON file of cameras by name; the options below replace parts of its camera
    #[arg(long, value_name = "FILE")]
    pub(super) cameras: Option<PathBuf>,
    /// Name in that file [default: the scene's name]
    #[arg(long, value_name = "NAME", requires = "cameras")]
    pub(super) camera: Option<String>,
    /// Midpoint between the eyes
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    eye: Option<Vec3>,
    /// Point to look at
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    target: Option<Vec3>,
    /// Direction that is up in the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    up: Option<Vec3>,
    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    fov: Option<f32>,
    /// Distance of the screen, where parallax is zero, in world units
    #[arg(long, value_name = "D", allow_hyphen_values = true)]
    screen: Option<f32>,
    /// Distance between the eyes in world units
    #[arg(long, value_name = "E", allow_hyphen_values = true)]
    interaxial: Option<f32>,
    /// Distance between the eyes in pixels: the parallax at infinity
    #[arg(long, value_name = "E", allow_hyphen_values = true, conflicts_with = "interaxial")]
    interaxial_px: Option<f32>,
}

impl CameraArguments {
    /// The camera of that name in the file of cameras, where one is given.
    pub(super) fn read(
        &self,
        scene_name: &str,
        [width, height]: [u32; 2],
        limits: &Limits,
    ) -> Result<Option<StereoCamera>, stereotrace::Error> {
        let named = |file| StereoCamera::from_json_within(file, self.name(scene_name), width, height, limits);
        self.cameras.as_ref().map(named).transpose()
    }

    /// The camera's name in the file of cameras.
    pub(super) fn name<'a>(&'a self, scene_name: &'a str) -> &'a str {
        self.camera.as_deref().unwrap_or(scene_name)
    }

    /// A camera that fits the object. Seen from or towards another point, it has screen and interaxial as
    /// [`StereoCamera::look_at`] has.
    pub(super) fn fitting(
        &self,
        scene: &Scene,
        [width, height]: [u32; 2],
        flattered: bool,
    ) -> Result<StereoCamera, stereotrace::Error> {
        let (low, high) = scene.bounds().unwrap_or((Vec3::NEG_ONE, Vec3::ONE));
        let camera = StereoCamera::fitting((low, high), width, height);
        if self.eye.is_none() && self.target.is_none() {
            return Ok(if flattered { studio::from_a_corner(camera) } else { camera });
        }
        let eye = self.eye.unwrap_or(camera.pose()?.eye);
        let distance = eye.distance(self.target.unwrap_or(low.midpoint(high)));
        Ok(camera.screen_distance(distance).interaxial(distance / 30.0))
    }

    /// The camera with those parts replaced that have an option of their own.
    pub(crate) fn replace_parts(&self, mut camera: StereoCamera) -> StereoCamera {
        if let Some(eye) = self.eye {
            camera = camera.eye(eye);
        }
        if let Some(target) = self.target {
            camera = camera.target(target);
        }
        if let Some(up) = self.up {
            camera = camera.up(up);
        }
        if let Some(degrees) = self.fov {
            camera = camera.vertical_fov_degrees(degrees);
        }
        if let Some(distance) = self.screen {
            camera = camera.screen_distance(distance);
        }
        if let Some(distance) = self.interaxial {
            camera = camera.interaxial(distance);
        }
        if let Some(pixels) = self.interaxial_px {
            camera = camera.interaxial_pixels(pixels);
        }
        camera
    }
}
