//! What is rendered and how, as every command that renders takes it, and what becomes of it before the first picture.

use std::{
    error::Error,
    path::PathBuf,
    time::{Duration, Instant},
};

use clap::Args;
use stereotrace::{Builtin, Options, Renderer, Scene, StereoCamera};

use super::{CameraArguments, Global, LightArguments, PictureArguments, ReadingArguments};
use crate::{shown, studio};

/// Lights of a scene that brings none and is not flattered.
const DEFAULT_LIGHTS: usize = 5;
/// How far ambient occlusion reaches where nothing is said, as a share of the scene's diagonal.
const REACH: f32 = 0.1;

#[derive(Clone, Debug, Args)]
pub(crate) struct Subject {
    /// An OBJ file, or builtin:NAME with one of the built-in scenes, which `stereotrace info` lists
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
    /// Time to read or make the scene.
    pub(crate) read: Duration,
}

impl Subject {
    /// Reads all that is named, then opens the device.
    pub(crate) fn open(&self, global: &Global) -> Result<Stage, Box<dyn Error>> {
        let begin = Instant::now();
        let mut scene = self.scene()?;
        let camera = self.stereo_camera(&scene)?;
        self.place_lights(&mut scene, &camera)?;
        let (picture, reach) = match self.is_flattered() {
            true => (self.picture.flattered(self.light.are_said()), studio::REACH),
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
        Ok(Stage { name: self.name(), scene, camera, options, renderer: Renderer::new(gpu), read })
    }

    /// The scene's name.
    pub(crate) fn name(&self) -> String {
        match self.builtin_name() {
            Some(name) => name.to_owned(),
            None => self.scene.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        }
    }

    /// The files that are read.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        let scene = self.builtin_name().is_none().then(|| self.scene.clone());
        scene.into_iter().chain(self.camera.cameras.clone()).chain(self.light.file()).collect()
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

    /// Reads or builds the scene, without its sky.
    fn scene(&self) -> Result<Scene, Box<dyn Error>> {
        if let Some(builtin) = self.builtin()? {
            return Ok(builtin.scene());
        }
        if self.scene.is_dir() || !self.scene.exists() {
            let fault = if self.scene.is_dir() { "is a folder" } else { "no such file" };
            let names = Builtin::ALL.iter().map(|builtin| format!("builtin:{builtin}"));
            let names = Vec::from_iter(names).join(", ");
            return Err(format!("{}: {fault}; give an OBJ file, or one of {names}", shown(&self.scene)).into());
        }
        Ok(Scene::from_obj_with(&self.scene, &self.reading.options())?)
    }

    /// The camera of the file of cameras, of the built-in scene, or one that fits the object, with those parts
    /// replaced that have an option of their own.
    fn stereo_camera(&self, scene: &Scene) -> Result<StereoCamera, Box<dyn Error>> {
        let [width, height] = self.picture.size;
        let camera = match self.camera.read(&self.name(), self.picture.size, &self.reading.limits())? {
            Some(camera) => camera,
            None => match self.builtin()? {
                Some(builtin) => builtin.camera(width, height),
                None => self.camera.fitting(scene, self.picture.size, self.is_flattered())?,
            },
        };
        let camera = self.camera.replace_parts(camera);
        camera.pose()?; // faults now, not after the scene is on the device
        Ok(camera)
    }

    /// Places the lights: those that are asked for, or those of the file of cameras, or of the scene, or some that show it well.
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
                None if self.is_flattered() => studio::light(scene, camera),
                None => scene.place_lights(DEFAULT_LIGHTS, camera),
            }
        };
        Ok(self.light.place(scene, camera, otherwise)?)
    }
}
