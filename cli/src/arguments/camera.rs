//! Where scenes are seen from.

use std::{error::Error, fs, path::PathBuf, sync::Arc};

use clap::Args;
use stereotrace::{Convergence, Limits, Scene, StereoCamera, camera::Display, glam::DVec3};

use super::values::{above_zero, display, point};
use crate::{shown, studio};

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Camera")]
pub(crate) struct CameraArguments {
    /// JSON file of cameras by name; the options below replace parts of its camera
    #[arg(long, value_name = "FILE")]
    pub(super) cameras: Option<PathBuf>,
    /// Name in that file [default: the scene's name], or of one of the scene file's own cameras [default: its first]
    #[arg(long, value_name = "NAME")]
    pub(super) camera: Option<String>,
    /// Midpoint between the eyes, in world coordinates
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    eye: Option<DVec3>,
    /// Point to look at, in world coordinates
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    target: Option<DVec3>,
    /// Direction that is up in the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    up: Option<DVec3>,
    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    fov: Option<f32>,
    /// Distance of the screen, where parallax is zero, in world units; inf for parallel cameras
    #[arg(long, value_name = "D|inf", allow_hyphen_values = true)]
    pub(super) screen: Option<f32>,
    /// Distance between the eyes in world units
    #[arg(long, value_name = "E", allow_hyphen_values = true)]
    interaxial: Option<f32>,
    /// Distance between the eyes in pixels: the parallax at infinity
    #[arg(long, value_name = "E", allow_hyphen_values = true, conflicts_with = "interaxial")]
    interaxial_px: Option<f32>,
    /// Turn the eyes towards each other: both are traced, and points stand higher in one picture than in the other
    #[arg(long)]
    toe_in: bool,
    /// Calibration of a rectified pair, Middlebury's calib.txt or KITTI's: focal lengths, principal points, baseline
    /// and size are the file's
    #[arg(long, value_name = "FILE", conflicts_with_all = ["fov", "screen", "interaxial", "interaxial_px", "toe_in"])]
    pub(super) calib: Option<PathBuf>,
    /// World units of one of that file's units of length, millimetres or metres
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = above_zero, allow_hyphen_values = true)]
    calib_scale: f32,
    /// Choose interaxial and screen for a display WIDTH metres wide that is seen from DISTANCE metres, so that depth
    /// is as strong as it may be
    #[arg(long, value_name = "WIDTH:DISTANCE", value_parser = display, conflicts_with_all = ["screen", "interaxial", "interaxial_px", "calib"])]
    pub(super) comfort: Option<Display>,
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

    /// The camera of that name among a scene file's own, or the first; none where it is said where the eyes are.
    pub(super) fn of_scene_file(&self, cameras: &[(Arc<str>, StereoCamera)]) -> Result<Option<StereoCamera>, String> {
        let Some(name) = &self.camera else {
            let is_said = self.eye.is_some() || self.target.is_some();
            return Ok(cameras.first().filter(|_| !is_said).map(|(_, camera)| *camera));
        };
        if let Some((_, camera)) = cameras.iter().find(|(own, _)| **own == **name) {
            return Ok(Some(*camera));
        }
        // A message has no place for more.
        let names: Vec<&str> = cameras.iter().take(20).map(|(name, _)| &**name).collect();
        match &*names {
            [] => Err(format!("--camera {name}: the scene has no cameras of its own; --cameras gives a file of some")),
            names => Err(format!("--camera {name}: the scene file has {}", names.join(", "))),
        }
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
        let (low, high) = scene.bounds().unwrap_or((DVec3::NEG_ONE, DVec3::ONE));
        let camera = StereoCamera::fitting((low, high), width, height);
        if self.eye.is_none() && self.target.is_none() {
            return Ok(if flattered { studio::from_a_corner(camera) } else { camera });
        }
        let eye = self.eye.unwrap_or(camera.pose()?.eye);
        let distance = eye.distance(self.target.unwrap_or(low.midpoint(high))) as f32;
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
            camera = camera.up(up.as_vec3());
        }
        if let Some(degrees) = self.fov {
            camera = camera.vertical_fov_degrees(degrees);
        }
        if let Some(distance) = self.screen {
            // Pixels are the parallax at infinity, which parallel cameras have none of: what the camera had stays, in
            // world units. What is wrong with it is said later.
            if let (true, Ok(pose)) = (distance.is_infinite() && self.interaxial_px.is_none(), camera.pose()) {
                camera = camera.interaxial(pose.interaxial);
            }
            camera = camera.screen_distance(distance);
        }
        if let Some(distance) = self.interaxial {
            camera = camera.interaxial(distance);
        }
        if let Some(pixels) = self.interaxial_px {
            camera = camera.interaxial_pixels(pixels);
        }
        if self.toe_in {
            camera = camera.convergence(Convergence::ToeIn);
        }
        camera
    }

    /// A calibrated pair where one is given, which stands where the camera does.
    pub(super) fn calibrated(
        &self,
        camera: StereoCamera,
        size: Option<[u32; 2]>,
        limits: &Limits,
    ) -> Result<StereoCamera, Box<dyn Error>> {
        let Some(file) = &self.calib else { return Ok(camera) };
        let text = fs::read_to_string(file).unwrap_or_default(); // what is wrong with it is said below
        let is_middlebury = text.lines().any(|line| line.trim_start().starts_with("cam0"));
        let calibrated = match (is_middlebury, size) {
            (true, Some(_)) => {
                return Err(format!("{}: it says how large pictures are; leave --size out", shown(file)).into());
            }
            (true, None) => StereoCamera::from_middlebury_within(file, self.calib_scale, limits)?,
            (false, size) => {
                let size = size.unwrap_or(super::picture::SIZE);
                StereoCamera::from_kitti_within(file, [2, 3], size, self.calib_scale, limits)?
            }
        };
        let pose = camera.pose()?;
        let ahead = pose.forward.as_dvec3() * f64::from(pose.subject_distance);
        Ok(calibrated.eye(pose.eye).target(pose.eye + ahead).up(pose.up))
    }
}
