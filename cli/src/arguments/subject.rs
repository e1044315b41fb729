//! What is rendered and how, as every command that renders takes it, and what becomes of it before the first picture.

use std::{
    error::Error,
    path::PathBuf,
    sync::Arc,
    time::{Duration, Instant},
};

use clap::Args;
use stereotrace::{
    Builtin, Convergence, GBuffer, Method, Options, Renderer, Scene, SceneFile, StereoCamera, UploadedScene,
};

use super::{CameraArguments, Global, LightArguments, PictureArguments, ReadingArguments};
use crate::{shown, studio};

/// Lights of a scene that brings none and is not flattered.
const DEFAULT_LIGHTS: usize = 5;
/// A scene file's own cameras, with their names.
type Cameras = Vec<(Arc<str>, StereoCamera)>;

/// How far ambient occlusion reaches where nothing is said, as a share of the scene's diagonal.
const REACH: f32 = 0.1;

#[derive(Clone, Debug, Args)]
pub(crate) struct Subject {
    /// An OBJ, glTF (.gltf, .glb) or PLY file, or builtin:NAME with one of the built-in scenes, which `stereotrace
    /// info` lists
    #[arg(default_value = "builtin:hall")]
    scene: PathBuf,
    /// Show a file without what flatters it: seen from the front in the light of points before black, a sample a pixel
    #[arg(long)]
    plain: bool,
    #[command(flatten)]
    pub(crate) picture: PictureArguments,
    #[command(flatten)]
    camera: CameraArguments,
    #[command(flatten)]
    light: LightArguments,
    #[command(flatten)]
    pub(crate) reading: ReadingArguments,
}

/// All that pictures are made of.
pub(crate) struct Stage {
    /// The scene's name, for tables and files.
    pub(crate) name: String,
    pub(crate) scene: Scene,
    pub(crate) camera: StereoCamera,
    pub(crate) options: Options,
    pub(crate) renderer: Renderer,
    pub(crate) uploaded: UploadedScene,
    /// Time to read or make the scene.
    pub(crate) read: Duration,
    /// Time to build the BVH and to upload it.
    pub(crate) build: Duration,
}

/// Width in pixels of the picture by which depths are found.
const PREVIEW: u32 = 320;

/// Depths of the nearest and the farthest that either eye sees; the latter is infinite where there is sky.
pub(crate) fn depths(
    renderer: &mut Renderer,
    uploaded: &UploadedScene,
    camera: &StereoCamera,
) -> Result<(f32, f32), stereotrace::Error> {
    let pose = camera.pose()?;
    let [width, height] = pose.size;
    let rows = (u64::from(PREVIEW) * u64::from(height) / u64::from(width)).clamp(1, 16 * u64::from(PREVIEW)) as u32;
    let options = Options::new(Method::Naive).g_buffer(GBuffer::Depth);
    // By focal lengths and principal points, whatever the camera was given by.
    let scales = [f64::from(PREVIEW) / f64::from(width), f64::from(rows) / f64::from(height)];
    let camera = camera.convergence(Convergence::OffAxis).interaxial(pose.interaxial).size(PREVIEW, rows);
    let camera = camera.intrinsics(pose.intrinsics().scaled(scales));
    let pair = renderer.render(uploaded, &camera, &options)?;
    let ranges = [&pair.left, &pair.right].map(|view| view.depth_range());
    Ok((ranges[0].0.min(ranges[1].0), ranges[0].1.max(ranges[1].1)))
}

impl Subject {
    /// Reads all that is named, then opens the device.
    pub(crate) fn open(&self, global: &Global) -> Result<Stage, Box<dyn Error>> {
        let begin = Instant::now();
        let (mut scene, cameras) = self.scene()?;
        let camera = self.stereo_camera(&scene, &cameras)?;
        self.place_lights(&mut scene, &camera)?;
        let (picture, reach) = match self.is_flattered() {
            true => (self.picture.flattered(self.light.are_said(), &scene), studio::REACH),
            false => (self.picture.clone(), REACH),
        };
        let options = picture.options(&scene, reach);
        let read = begin.elapsed();

        let gpu = global.gpu()?;
        let begin = Instant::now();
        match self.light.sky(self.reading.limits(), &gpu)? {
            Some(sky) => scene.sky = sky,
            None if self.is_flattered() => scene.sky = studio::backdrop(),
            None => {}
        }
        let read = read + begin.elapsed();

        let mut renderer = Renderer::new(gpu);
        let begin = Instant::now();
        let uploaded = renderer.upload(&scene)?;
        let build = begin.elapsed();
        let camera = match &self.camera.comfort {
            None => camera,
            Some(display) => {
                let depths = depths(&mut renderer, &uploaded, &camera)?;
                let chosen = camera.comfortable(depths, display)?;
                log::info!("interaxial {}, screen at {}", chosen.interaxial, chosen.screen_distance);
                chosen.camera
            }
        };
        Ok(Stage { name: self.name(), scene, camera, options, renderer, uploaded, read, build })
    }

    /// The scene's name.
    pub(crate) fn name(&self) -> String {
        match self.builtin_name() {
            Some(name) => name.to_owned(),
            None => self.scene.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        }
    }

    /// Whether it is said where the screen is.
    pub(crate) fn screen_is_said(&self) -> bool {
        self.camera.screen.is_some() || self.camera.cameras.is_some() || self.camera.calib.is_some()
    }

    /// The files that are read.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        let scene = self.builtin_name().is_none().then(|| self.scene.clone());
        scene.into_iter().chain(self.camera.cameras.clone()).chain(self.light.file()).collect()
    }

    /// Whether lights are placed around the camera, as it is when the scene is read.
    #[cfg(feature = "view")]
    pub(crate) fn lights_stand_by_camera(&self) -> bool {
        self.light.are_counted() || !self.light.are_said() && self.builtin_name().is_none()
    }

    fn builtin_name(&self) -> Option<&str> {
        self.scene.to_str()?.strip_prefix("builtin:")
    }

    fn builtin(&self) -> Result<Option<Builtin>, stereotrace::Error> {
        self.builtin_name().map(str::parse).transpose()
    }

    /// Whether it is a file that may be shown at its best.
    fn is_flattered(&self) -> bool {
        self.builtin_name().is_none() && !self.plain && self.camera.cameras.is_none()
    }

    /// Reads or builds the scene, without its sky, and the cameras that a file has.
    fn scene(&self) -> Result<(Scene, Cameras), Box<dyn Error>> {
        if let Some(builtin) = self.builtin()? {
            return Ok((builtin.scene(), Vec::new()));
        }
        if self.scene.is_dir() || !self.scene.exists() {
            let fault = if self.scene.is_dir() { "is a folder" } else { "no such file" };
            let names = Builtin::ALL.iter().map(|builtin| format!("builtin:{builtin}"));
            let names = Vec::from_iter(names).join(", ");
            return Err(format!("{}: {fault}; give a scene file, or one of {names}", shown(&self.scene)).into());
        }
        let SceneFile { scene, cameras, .. } = SceneFile::open(&self.scene, &self.reading.options(&self.scene))?;
        Ok((scene, cameras))
    }

    /// The camera of the file of cameras, of the scene file, of the built-in scene, or one that fits the object, with
    /// those parts replaced that have an option of their own.
    fn stereo_camera(
        &self,
        scene: &Scene,
        cameras: &[(Arc<str>, StereoCamera)],
    ) -> Result<StereoCamera, Box<dyn Error>> {
        let [width, height] = self.picture.size();
        let camera = match self.camera.read(&self.name(), self.picture.size(), &self.reading.limits())? {
            Some(camera) => camera,
            None => match (self.builtin()?, self.camera.of_scene_file(cameras)?) {
                (Some(builtin), _) => builtin.camera(width, height),
                (None, Some(camera)) => camera.size(width, height),
                (None, None) => self.camera.fitting(scene, self.picture.size(), self.is_flattered())?,
            },
        };
        let camera = self.camera.replace_parts(camera);
        let camera = self.camera.calibrated(camera, self.picture.size_said, &self.reading.limits())?;
        camera.pose()?; // faults now, not after the scene is on the device
        Ok(camera)
    }

    /// Places the lights: those that are asked for, or those of the file of cameras, or of the scene, or some that show
    /// it well.
    fn place_lights(&self, scene: &mut Scene, camera: &StereoCamera) -> Result<(), Box<dyn Error>> {
        let builtin = self.builtin()?;
        let otherwise = |scene: &mut Scene| {
            if let Some(file) = &self.camera.cameras
                && scene.light_from_json_within(file, self.camera.name(&self.name()), &self.reading.limits())?
            {
                return Ok(());
            }
            match builtin {
                Some(_) => Ok(()),
                None if !scene.lights.is_empty() => Ok(()),
                None if self.is_flattered() => studio::light(scene, camera),
                None => scene.place_lights(DEFAULT_LIGHTS, camera),
            }
        };
        Ok(self.light.place(scene, camera, otherwise)?)
    }
}
