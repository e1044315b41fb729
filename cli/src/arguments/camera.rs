//! Defines the options of the camera.

use std::{error::Error, fs, path::PathBuf, sync::Arc};

use clap::Args;
use stereotrace::{
    CameraPath, Equirectangular, Limits, Projection, Scene, Span, StereoCamera,
    camera::{Display, HUMAN_INTERAXIAL, MIN_EXTENT},
    glam::{DVec3, Vec3},
};

use super::values::{
    LensArgument, PoleMergeArgument, ProjectionArgument, above_zero, display, field_of_view, interaxial, lens, point,
    pole_merge, projection, screen,
};
use crate::{shown, studio, usage::Usage};

/// Heading of the options that decide how deep the picture looks.
const DEPTH: &str = "How deep the picture is";

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Where the camera is")]
pub(crate) struct CameraArguments {
    /// JSON file of cameras by name. The options below replace parts of the chosen camera
    #[arg(long, value_name = "FILE")]
    pub(super) cameras: Option<PathBuf>,
    /// Name of the camera in the file of --cameras [default: the scene's name], or without that file, in the scene file
    /// [default: its first camera]
    #[arg(long, value_name = "NAME")]
    pub(super) camera: Option<String>,
    /// Midpoint between the eyes, in world coordinates
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    eye: Option<DVec3>,
    /// Point that the camera looks at, in world coordinates
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    target: Option<DVec3>,
    /// Up direction of the picture, in world coordinates
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    up: Option<DVec3>,
    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEG", value_parser = field_of_view, allow_hyphen_values = true)]
    fov: Option<f32>,
    /// Distance of the screen, the plane of zero parallax, in world units (convergence distance); inf for parallel
    /// cameras
    #[arg(long, help_heading = DEPTH, value_name = "D|inf", value_parser = screen, allow_hyphen_values = true)]
    pub(super) screen: Option<f32>,
    /// Distance between the eyes in world units (baseline, interpupillary distance, IPD)
    #[arg(long, help_heading = DEPTH, value_name = "E", value_parser = interaxial, allow_hyphen_values = true)]
    interaxial: Option<f32>,
    /// Distance between the eyes in pixels; equals the parallax at infinity
    #[arg(
        long,
        help_heading = DEPTH,
        value_name = "E",
        value_parser = interaxial,
        allow_hyphen_values = true,
        conflicts_with = "interaxial"
    )]
    interaxial_px: Option<f32>,
    /// Turn the eyes towards each other (toed-in convergence). Both views are then traced, and points have vertical
    /// parallax
    #[arg(long, help_heading = DEPTH)]
    toe_in: bool,
    /// Projection: planar, or 360 or 180 for equirectangular pictures of so many degrees, for headsets. Their eyes turn
    /// with the direction of view. Middle of the picture is the target's direction, and its vertical axis is --up
    #[arg(long, value_name = "planar|360|180", value_parser = projection, conflicts_with_all = ["toe_in", "calib"])]
    projection: Option<ProjectionArgument>,
    /// Elevations in degrees between which the eyes of an equirectangular pair approach each other
    #[arg(long, value_name = "FROM:TO|off", default_value = "60:75", value_parser = pole_merge)]
    pole_merge: PoleMergeArgument,
    /// World units per metre. The default interaxial of an equirectangular pair is 0.065 metres
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = above_zero, allow_hyphen_values = true)]
    unit: f32,
    /// Lens with distortion of both eyes: a JSON file, or JSON that begins with a brace, with fx, fy, cx and cy in
    /// pixels and OpenCV's coefficients radial_tangential or fisheye. Or two lenses, left and right. The eyes are
    /// parallel, and both views are traced
    #[arg(
        long,
        value_name = "FILE|JSON",
        value_parser = lens,
        conflicts_with_all = ["fov", "screen", "interaxial_px", "toe_in", "projection", "calib", "comfort"]
    )]
    lens: Option<LensArgument>,
    /// Calibration file of a rectified pair in Middlebury's or KITTI's format. It sets focal lengths, principal points,
    /// baseline and size
    #[arg(long, value_name = "FILE", conflicts_with_all = ["fov", "screen", "interaxial", "interaxial_px", "toe_in"])]
    pub(super) calib: Option<PathBuf>,
    /// World units per unit of length in the calibration file, which is a millimetre for Middlebury and a metre for
    /// KITTI
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = above_zero, allow_hyphen_values = true)]
    calib_scale: f32,
    /// Choose interaxial and screen distance for the strongest comfortable depth on a display of WIDTH metres seen from
    /// DISTANCE metres
    #[arg(
        long,
        help_heading = DEPTH,
        value_name = "WIDTH:DISTANCE",
        value_parser = display,
        conflicts_with_all = ["screen", "interaxial", "interaxial_px", "calib"]
    )]
    pub(super) comfort: Option<Display>,
}

impl CameraArguments {
    /// Reads the named camera from the file of --cameras. Returns `None` if that option is not given.
    pub(super) fn read(
        &self,
        scene_name: &str,
        [width, height]: [u32; 2],
        limits: &Limits,
    ) -> Result<Option<StereoCamera>, stereotrace::Error> {
        let named = |file| StereoCamera::from_json_within(file, self.name(scene_name), width, height, limits);
        self.cameras.as_ref().map(named).transpose()
    }

    /// Returns the named camera of a scene file, or the first camera if --camera is not given. In that case, --eye or
    /// --target excludes the file's cameras.
    pub(super) fn of_scene_file(&self, cameras: &[(Arc<str>, StereoCamera)]) -> Result<Option<StereoCamera>, String> {
        let Some(name) = &self.camera else {
            let is_said = self.eye.is_some() || self.target.is_some();
            return Ok(cameras.first().filter(|_| !is_said).map(|(_, camera)| *camera));
        };
        if let Some((_, camera)) = cameras.iter().find(|(own, _)| **own == **name) {
            return Ok(Some(*camera));
        }
        // The message lists at most 20 names.
        let names: Vec<&str> = cameras.iter().take(20).map(|(name, _)| &**name).collect();
        match &*names {
            [] => Err(format!("--camera {name}: the scene has no cameras; give a file of cameras with --cameras")),
            names => Err(format!("--camera {name}: the scene file has {}", names.join(", "))),
        }
    }

    /// Checks the options that exclude each other, for pictures of this size.
    pub(super) fn check(&self, size: [u32; 2]) -> Result<(), Usage> {
        if let (Some(eye), Some(target)) = (self.eye, self.target)
            && eye == target
        {
            return Err(Usage(format!("--eye and --target are both at {eye}; they must differ")));
        }
        if self.screen == Some(f32::INFINITY) && self.interaxial_px.is_some() {
            let reason = "parallel cameras have no parallax at infinity; give it in world units, by --interaxial";
            return Err(Usage(format!("--interaxial-px: {reason}")));
        }
        let Some(span) = self.span() else { return Ok(()) };
        let planar = [
            ("--fov", self.fov.is_some()),
            ("--screen", self.screen.is_some()),
            ("--interaxial-px", self.interaxial_px.is_some()),
            ("--comfort", self.comfort.is_some()),
        ];
        if let Some((name, _)) = planar.iter().find(|(_, given)| *given) {
            return Err(Usage(format!("{name} is for planar pictures; equirectangular ones have no screen")));
        }
        // Players expect this shape.
        let [width, height] = size;
        span.shape_fault(size).map_or(Ok(()), |fault| Err(Usage(format!("{width}x{height}: {fault}"))))
    }

    /// Returns whether an option sets the distance between the eyes.
    pub(super) fn interaxial_is_said(&self) -> bool {
        let is_given = self.interaxial.is_some() || self.interaxial_px.is_some();
        is_given || self.comfort.is_some() || self.calib.is_some()
    }

    /// Returns whether an option sets the up direction: --up, or a projection whose vertical axis is the world's.
    pub(super) fn sets_up(&self) -> bool {
        self.up.is_some() || self.span().is_some()
    }

    /// Returns the place of the scene file's camera that makes the pictures, or `None` if an option places the camera.
    pub(super) fn place_in_scene_file(&self, cameras: &[(Arc<str>, StereoCamera)]) -> Option<usize> {
        if self.cameras.is_some() || self.eye.is_some() || self.target.is_some() {
            return None;
        }
        match &self.camera {
            None => (!cameras.is_empty()).then_some(0),
            Some(name) => cameras.iter().position(|(own, _)| **own == **name),
        }
    }

    /// Returns the range of azimuths of equirectangular pictures, or `None` for planar ones.
    fn span(&self) -> Option<Span> {
        self.projection.and_then(|projection| projection.0)
    }

    /// Returns the option that gives another projection than that of eyes that look through one screen.
    pub(super) fn other_projection(&self) -> Option<&'static str> {
        let options =
            [("--projection", self.span().is_some()), ("--lens", self.lens.is_some()), ("--toe-in", self.toe_in)];
        options.into_iter().find(|(_, given)| *given).map(|(name, _)| name)
    }

    /// Returns the default size of an eye's picture: width and height in pixels.
    pub(super) fn default_size(&self) -> [u32; 2] {
        match self.span() {
            None => super::picture::SIZE,
            Some(Span::Full) => [2048, 1024],
            Some(Span::Half) => [1024, 1024],
        }
    }

    fn equirectangular(&self, span: Span) -> Projection {
        Projection::Equirectangular(Equirectangular { span, merge: self.pole_merge.0 })
    }

    /// Returns a path with the projection of --projection.
    pub(super) fn projected_path(&self, path: CameraPath) -> CameraPath {
        match (self.span(), self.lens) {
            (None, None) => path,
            (_, Some(LensArgument([left, right]))) => path.projection(Projection::Lenses([left, right])),
            (Some(span), None) => path.projection(self.equirectangular(span)),
        }
    }

    /// Returns the camera with the lenses of --lens.
    ///
    /// # Errors
    /// Returns the errors of [`StereoCamera::pose`] for the camera without lenses.
    pub(super) fn through_lens(&self, camera: StereoCamera) -> Result<StereoCamera, stereotrace::Error> {
        let Some(LensArgument([left, right])) = self.lens else { return Ok(camera) };
        // Built-in cameras give the interaxial in pixels, which eyes with lenses don't have.
        let interaxial = camera.pose()?.interaxial;
        Ok(camera.interaxial(interaxial).lenses(left, right))
    }

    /// Returns the camera with the projection of --projection. An equirectangular pair is level unless --up is given.
    /// Its eyes are a human's interaxial apart unless an option or the file of --cameras says otherwise.
    pub(super) fn projected(&self, camera: StereoCamera) -> StereoCamera {
        let Some(span) = self.span() else { return camera };
        let projection = self.equirectangular(span);
        let interaxial = match (self.interaxial, &self.cameras) {
            (None, None) => HUMAN_INTERAXIAL * self.unit,
            (None, Some(_)) => camera.pose().map_or(HUMAN_INTERAXIAL * self.unit, |pose| pose.interaxial),
            (Some(interaxial), _) => interaxial,
        };
        let up = self.up.map_or(Vec3::Y, |up| up.as_vec3());
        camera.projection(projection).up(up).interaxial(interaxial)
    }

    /// Returns the camera's name in the file of --cameras.
    pub(super) fn name<'a>(&'a self, scene_name: &'a str) -> &'a str {
        self.camera.as_deref().unwrap_or(scene_name)
    }

    /// Returns a camera that shows the whole scene. With --eye or --target, the screen distance and interaxial follow
    /// the rule of [`StereoCamera::look_at`].
    pub(super) fn fitting(
        &self,
        scene: &Scene,
        [width, height]: [u32; 2],
        flattered: bool,
    ) -> Result<StereoCamera, stereotrace::Error> {
        let (low, high) = scene.bounds().unwrap_or((DVec3::NEG_ONE, DVec3::ONE));
        let camera = StereoCamera::fitting((low, high), width, height);
        if self.span().is_some() && self.target.is_none() {
            // All around, from the middle: ahead is -z.
            let eye = self.eye.unwrap_or(low.midpoint(high));
            let ahead = 0.5 * low.distance(high).max(f64::from(MIN_EXTENT));
            return Ok(StereoCamera::look_at(eye, eye - ahead * DVec3::Z).size(width, height));
        }
        if self.eye.is_none() && self.target.is_none() {
            return Ok(if flattered { studio::from_a_corner(camera) } else { camera });
        }
        let eye = self.eye.unwrap_or(camera.pose()?.eye);
        let distance = eye.distance(self.target.unwrap_or(low.midpoint(high))) as f32;
        Ok(camera.screen_distance(distance).interaxial(distance / 30.0))
    }

    /// Returns the camera with all values replaced that the options set.
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
            // Parallel cameras have no parallax at infinity, so an interaxial in pixels is converted to world units. A
            // later check reports an invalid camera.
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
            camera = camera.projection(Projection::ToeIn);
        }
        camera
    }

    /// Returns the pair of --calib at the pose of `camera`, or `camera` itself if --calib is not given.
    pub(super) fn calibrated(
        &self,
        camera: StereoCamera,
        size: Option<[u32; 2]>,
        limits: &Limits,
    ) -> Result<StereoCamera, Box<dyn Error>> {
        let Some(file) = &self.calib else { return Ok(camera) };
        let text = fs::read_to_string(file).unwrap_or_default(); // the readers below report an unreadable file
        let is_middlebury = text.lines().any(|line| line.trim_start().starts_with("cam0"));
        let calibrated = match (is_middlebury, size) {
            (true, Some(_)) => {
                return Err(format!("{}: it sets the picture size; leave out --size", shown(file)).into());
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
