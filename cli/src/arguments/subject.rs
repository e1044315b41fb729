//! Defines the arguments that all rendering commands share: scene, camera, lights and render options. [`Subject::open`]
//! turns them into a [`Stage`].

use std::{
    error::Error,
    f32::consts::TAU,
    path::PathBuf,
    sync::Arc,
    time::{Duration, Instant},
};

use clap::Args;
use stereotrace::{
    Animation, Builtin, CameraPath, GBuffer, Method, Options, Pose, Ray, Renderer, Scene, SceneFile, Sky, StereoCamera,
    StereoPair, Update, UploadedScene, blocking::Wait, glam::Vec3,
};

use super::{CameraArguments, Global, LightArguments, PictureArguments, ReadingArguments, TimeArguments};
use crate::{progress::Progress, shown, studio, usage::Usage};

/// Number of lights placed in a scene without lights, if the automatic look is off.
const DEFAULT_LIGHTS: usize = 5;
/// Names and cameras of a scene file.
type Cameras = Vec<(Arc<str>, StereoCamera)>;

/// Default radius of ambient occlusion, as a share of the scene's diagonal.
const REACH: f32 = 0.1;

#[derive(Clone, Debug, Args)]
pub(crate) struct Subject {
    /// Scene: an OBJ, glTF (.gltf, .glb) or PLY file, or builtin:NAME. `stereotrace info` lists the built-in scenes
    #[arg(default_value = "builtin:hall")]
    scene: PathBuf,
    /// Disable the automatic look of a file: viewpoint from a corner, soft light, ambient occlusion, light by paths for
    /// physically based materials, exposure, grey backdrop and antialiasing. --cameras disables it too
    #[arg(long)]
    plain: bool,
    #[command(flatten)]
    pub(crate) picture: PictureArguments,
    #[command(flatten)]
    camera: CameraArguments,
    #[command(flatten)]
    light: LightArguments,
    #[command(flatten)]
    time: TimeArguments,
    #[command(flatten)]
    pub(crate) reading: ReadingArguments,
}

/// What frames are made for, which decides defaults of the automatic look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// Pictures to look at: light by paths if materials are physically based, and an exposure that suits the scene.
    Pictures,
    /// Measurements and data: direct light, and no change of exposure.
    Data,
}

/// Inputs of a picture: scene, camera, options and device.
pub(crate) struct Stage {
    /// Name of the scene, for tables and file names.
    pub(crate) name: String,
    pub(crate) scene: Scene,
    pub(crate) camera: StereoCamera,
    pub(crate) options: Options,
    /// Whether the automatic look chose light by paths.
    pub(crate) is_by_paths_by_default: bool,
    pub(crate) renderer: Renderer,
    pub(crate) uploaded: UploadedScene,
    /// The animation of the scene's file that the options choose.
    pub(crate) playing: Option<Playing>,
    /// Animations of the scene's file.
    pub(crate) animations: Vec<Animation>,
    /// Time to read or make the scene.
    pub(crate) read: Duration,
    /// Time to build the BVH and to upload it.
    pub(crate) build: Duration,
}

/// An animation that moves a scene.
#[derive(Clone, Debug)]
pub(crate) struct Playing {
    pub(crate) animation: Animation,
    /// Time of --time in seconds, or 0.
    pub(crate) begin: f64,
    /// Camera of the file that makes the pictures, by its place.
    camera: Option<usize>,
    /// Whether the camera's up direction stays, since an option sets it.
    keeps_up: bool,
}

impl Playing {
    /// Moves a camera to its place at a time, if it is a camera of the file.
    pub(crate) fn camera(&self, camera: StereoCamera, seconds: f64) -> Result<StereoCamera, stereotrace::Error> {
        let Some(place) = self.camera else { return Ok(camera) };
        let Some(moved) = self.animation.cameras(seconds)?.get(place).copied() else { return Ok(camera) };
        let camera = camera.eye(moved.eye_position()).target(moved.target_position());
        Ok(if self.keeps_up { camera } else { camera.up(moved.up_direction()) })
    }
}

impl Stage {
    /// Moves the scene to a time of its animation, in seconds, and updates the device.
    pub(crate) fn seek(&mut self, seconds: f64) -> Result<(), stereotrace::Error> {
        let Some(playing) = &self.playing else { return Ok(()) };
        playing.animation.pose(&mut self.scene, seconds)?;
        self.renderer.update(&mut self.uploaded, &self.scene, Update::RefitOrRebuild).wait()
    }

    /// Renders a pair of the scene and shows the progress.
    pub(crate) fn render(
        &mut self,
        camera: StereoCamera,
        options: Options,
        progress: &mut Progress,
    ) -> Result<StereoPair, stereotrace::Error> {
        let mut show = |now| progress.show(now);
        self.renderer.pair(&self.uploaded, &camera).options(&options).progress(&mut show).read().wait()
    }
}

/// Number of directions in which surfaces between equirectangular eyes are looked for.
const AROUND: u32 = 128;

/// Width in pixels of preview pictures, whose depths are measured.
pub(crate) const PREVIEW: u32 = 320;

/// Returns the nearest and the farthest depth that either eye sees, in world units along the view. The farthest is
/// infinite if there is sky.
pub(crate) fn depths(
    renderer: &mut Renderer,
    uploaded: &UploadedScene,
    camera: &StereoCamera,
) -> Result<(f32, f32), stereotrace::Error> {
    let options = Options::new(Method::Naive).g_buffer(GBuffer::Depth);
    let camera = camera.resized(PREVIEW)?;
    let pair = renderer.pair(uploaded, &camera).options(&options).read().wait()?;
    let ranges = [&pair.left, &pair.right].map(|view| view.depth_range());
    Ok((ranges[0].0.min(ranges[1].0), ranges[0].1.max(ranges[1].1)))
}

/// Warns if rays to the sky find no light there.
fn warn_of_a_black_sky(options: &Options, scene: &Scene) {
    if let (Some(_), Sky::Constant(Vec3::ZERO)) = (options.sky_rays, &scene.sky) {
        log::warn!("--sky-rays: the sky is black and gives no light; add --sky, such as --sky procedural");
    }
}

/// Warns if a surface is nearer to the middle of equirectangular eyes than the eyes are. An eye then sees what is
/// behind it in some directions, such as the next room.
fn warn_of_surfaces_between_the_eyes(
    renderer: &Renderer,
    uploaded: &UploadedScene,
    pose: &Pose,
) -> Result<(), stereotrace::Error> {
    if pose.projection.equirectangular().is_none() || pose.interaxial == 0.0 {
        return Ok(());
    }
    let radius = 0.5 * pose.interaxial;
    let to_eye = |turn: u32| {
        let (sin, cos) = (TAU * turn as f32 / AROUND as f32).sin_cos();
        Ray::new(pose.eye, radius * (pose.right * cos + pose.forward * sin)).t_max(1.0)
    };
    let rays = Vec::from_iter((0..AROUND).map(to_eye));
    let hits = renderer.closest_hits(uploaded, &rays).wait()?;
    let nearest = hits.hits.iter().map(|hit| radius * hit.t).fold(f32::INFINITY, f32::min);
    if nearest < radius {
        log::warn!(
            "interaxial {}: a surface is {nearest:.3} from the middle of the eyes, nearer than the eyes ({radius:.3}), \
             which see through it; choose a smaller --interaxial or another --eye",
            pose.interaxial
        );
    }
    Ok(())
}

impl Subject {
    /// Checks what can be checked before a file is read.
    pub(crate) fn check(&self) -> Result<(), Usage> {
        self.builtin().map_err(|error| Usage(error.to_string()))?;
        self.camera.check(self.size())?;
        self.picture.check()
    }

    /// Reads all files, then opens the device and uploads the scene.
    pub(crate) fn open(&self, purpose: Purpose, global: &Global) -> Result<Stage, Box<dyn Error>> {
        let begin = Instant::now();
        let (mut scene, mut cameras, animations) = self.scene()?;
        let animation = self.time.animation(&animations)?;
        if let (Some(animation), Some(seconds)) = (&animation, self.time.seconds()) {
            animation.pose(&mut scene, seconds)?;
            for ((_, camera), moved) in cameras.iter_mut().zip(animation.cameras(seconds)?) {
                *camera = moved;
            }
        }
        let playing = animation.map(|animation| Playing {
            animation,
            begin: self.time.seconds().unwrap_or_default(),
            camera: self.camera.place_in_scene_file(&cameras),
            keeps_up: self.camera.sets_up(),
        });
        let camera = self.stereo_camera(&scene, &cameras)?;
        let by_paths = purpose != Purpose::Data && self.is_flattered() && self.suits_paths(&scene);
        self.place_lights(&mut scene, &camera, by_paths)?;
        let (picture, reach) = match self.is_flattered() {
            true => (self.picture.flattered(self.light.are_said(), &scene, by_paths), studio::REACH),
            false => (self.picture.clone(), REACH),
        };
        let mut options = picture.options(&scene, reach)?;
        let read = begin.elapsed();

        let gpu = global.gpu()?;
        let begin = Instant::now();
        let own = if self.is_flattered() { studio::backdrop() } else { scene.sky };
        scene.sky = self.light.sky(own, self.reading.limits(), &gpu)?;
        warn_of_a_black_sky(&options, &scene);
        let read = read + begin.elapsed();

        let mut renderer = global.renderer(gpu)?;
        let begin = Instant::now();
        let uploaded = renderer.upload(&scene).wait()?;
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
        warn_of_surfaces_between_the_eyes(&renderer, &uploaded, &camera.pose()?)?;
        if self.picture.chooses_exposure(purpose != Purpose::Data && self.is_flattered()) {
            options.exposure = renderer.suggest_exposure(&uploaded, &camera, &options).wait()?;
        }
        Ok(Stage {
            name: self.name(),
            scene,
            camera,
            options,
            is_by_paths_by_default: by_paths,
            renderer,
            uploaded,
            playing,
            animations,
            read,
            build,
        })
    }

    /// Returns whether paths of light show more of a scene's materials than direct light does, and no option decides.
    fn suits_paths(&self, scene: &Scene) -> bool {
        self.picture.leaves_light_open() && scene.materials().iter().any(|material| material.principled.is_some())
    }

    /// Returns the size of an eye's picture: width and height in pixels.
    pub(crate) fn size(&self) -> [u32; 2] {
        self.picture.size_said.unwrap_or_else(|| self.camera.default_size())
    }

    /// Returns these arguments with another size of an eye's picture.
    pub(crate) fn sized(&self, size: [u32; 2]) -> Self {
        let mut sized = self.clone();
        sized.picture.size_said = Some(size);
        sized
    }

    /// Returns the scene's name: the name of a built-in scene, or the file name without its extension.
    pub(crate) fn name(&self) -> String {
        match self.builtin_name() {
            Some(name) => name.to_owned(),
            None => self.scene.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        }
    }

    /// Returns the scene's name in data sets: its file, or `builtin:NAME`.
    pub(crate) fn scene_name(&self) -> String {
        self.scene.to_string_lossy().into_owned()
    }

    /// Returns a path of cameras with the projection of --projection.
    pub(crate) fn projected_path(&self, path: CameraPath) -> CameraPath {
        self.camera.projected_path(path)
    }

    /// Returns the option that gives another projection than that of eyes that look through one screen.
    pub(crate) fn other_projection(&self) -> Option<&'static str> {
        self.camera.other_projection()
    }

    /// Returns whether an option sets the screen distance.
    pub(crate) fn screen_is_said(&self) -> bool {
        self.camera.screen.is_some() || self.camera.cameras.is_some() || self.camera.calib.is_some()
    }

    /// Returns whether --comfort chooses the screen distance and the distance between the eyes.
    pub(crate) fn comfort_is_said(&self) -> bool {
        self.camera.comfort.is_some()
    }

    /// Returns whether an option sets the distance between the eyes.
    pub(crate) fn interaxial_is_said(&self) -> bool {
        self.camera.interaxial_is_said()
    }

    /// Returns the files that the command line names: scene, cameras and sky.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        let scene = self.builtin_name().is_none().then(|| self.scene.clone());
        scene.into_iter().chain(self.camera.cameras.clone()).chain(self.light.file()).collect()
    }

    /// Returns whether lights are placed around the camera when the scene is read.
    #[cfg(feature = "view")]
    pub(crate) fn lights_stand_by_camera(&self) -> bool {
        self.light.are_counted() || !self.light.are_said() && self.builtin_name().is_none()
    }

    /// Returns whether the scene is built in. Its camera has a screen that suits it.
    pub(crate) fn is_builtin(&self) -> bool {
        self.builtin_name().is_some()
    }

    fn builtin_name(&self) -> Option<&str> {
        self.scene.to_str()?.strip_prefix("builtin:")
    }

    fn builtin(&self) -> Result<Option<Builtin>, stereotrace::Error> {
        self.builtin_name().map(str::parse).transpose()
    }

    /// Returns whether the scene is a file that gets the automatic look.
    fn is_flattered(&self) -> bool {
        self.builtin_name().is_none() && !self.plain && self.camera.cameras.is_none()
    }

    /// Reads or builds the scene without its sky, and reads the file's cameras and animations.
    fn scene(&self) -> Result<(Scene, Cameras, Vec<Animation>), Box<dyn Error>> {
        if let Some(builtin) = self.builtin()? {
            return Ok((builtin.scene(), Vec::new(), Vec::new()));
        }
        if self.scene.is_dir() || !self.scene.exists() {
            let fault = if self.scene.is_dir() { "is a folder" } else { "no such file" };
            let names = Builtin::ALL.iter().map(|builtin| format!("builtin:{builtin}"));
            let names = Vec::from_iter(names).join(", ");
            return Err(format!("{}: {fault}; give a scene file, or one of {names}", shown(&self.scene)).into());
        }
        let file = SceneFile::open(&self.scene, &self.reading.options(&self.scene))?;
        let SceneFile { scene, cameras, animations, .. } = file;
        Ok((scene, cameras, animations))
    }

    /// Returns the camera of --cameras, of the built-in scene or of the scene file, else a camera that shows the whole
    /// scene. Options then replace its values.
    fn stereo_camera(
        &self,
        scene: &Scene,
        cameras: &[(Arc<str>, StereoCamera)],
    ) -> Result<StereoCamera, Box<dyn Error>> {
        let [width, height] = self.size();
        let camera = match self.camera.read(&self.name(), self.size(), &self.reading.limits())? {
            Some(camera) => camera,
            None => match (self.builtin()?, self.camera.of_scene_file(cameras)?) {
                (Some(builtin), _) => builtin.camera(width, height),
                (None, Some(camera)) => camera.size(width, height),
                (None, None) => self.camera.fitting(scene, self.size(), self.is_flattered())?,
            },
        };
        let camera = self.camera.projected(self.camera.replace_parts(camera));
        let camera = self.camera.calibrated(camera, self.picture.size_said, &self.reading.limits())?;
        let camera = self.camera.through_lens(camera)?;
        camera.pose()?; // reports an invalid camera before the scene is uploaded
        Ok(camera)
    }

    /// Sets the lights. The options come first, then the file of --cameras, then the scene's own lights, and surfaces
    /// that emit light if paths find them, then default lights.
    fn place_lights(&self, scene: &mut Scene, camera: &StereoCamera, by_paths: bool) -> Result<(), Box<dyn Error>> {
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
                None if by_paths && scene.materials().iter().any(|one| one.emission != Vec3::ZERO) => Ok(()),
                None if self.is_flattered() => studio::light(scene, camera),
                None => scene.place_lights(DEFAULT_LIGHTS, camera),
            }
        };
        Ok(self.light.place(scene, camera, otherwise)?)
    }
}
