//! The command line, and the scene and the camera that it asks for.

use std::{error::Error, path::PathBuf};

use crate::{
    studio,
    values::{
        CreaseAngle, OcclusionArgument, above_zero, adaptive, crease_angle, missing_textures, occlusion, point,
        shadow_buffer, size, tone,
    },
};
use clap::{Args, Parser};
use stereotrace::{
    Adaptive, AmbientOcclusion, Filter, Gpu, Light, LightShape, Limits, MAX_BOUNCES, Method, MissingTextures,
    ObjOptions, Options, Scene, ShadowBuffer, Sky, SkyMap, StereoCamera, Tone, Visibility,
    glam::Vec3,
    output::{Anaglyph, Packing},
    scene::builtin::Builtin,
};

/// Lights of a scene that brings none.
const DEFAULT_LIGHTS: u32 = 5;

const ENVIRONMENT: &str =
    "STEREOTRACE_ADAPTER=software, or a part of an adapter's name, chooses the adapter; else it is the fastest one.";

/// Renders a stereo pair and an anaglyph of it
#[derive(Clone, Debug, Parser)]
#[command(name = "anaglyph", after_help = ENVIRONMENT)]
pub(crate) struct Arguments {
    /// An OBJ file, or builtin:NAME with spheres, hall, fence, hidden, near, grazing, random-20, random-100,
    /// random-125, random-125-both, random-1000, three-spheres, three-spheres-mirrors or three-spheres-textured
    #[arg(default_value = "builtin:hall")]
    scene: PathBuf,
    /// Folder to write into
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub(crate) out: PathBuf,
    /// Picture size in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size, allow_hyphen_values = true)]
    size: [u32; 2],
    /// How the right view is made: auto (bracket or naive, whichever is likely cheaper), naive, ideal, atomic, buffer, buffer-2e, buffer-N (slots), es-isler,
    /// adelson-hodges, atomic-edges, buffer-edges, bracket, verified or bracket-rays
    #[arg(long, default_value_t)]
    pub(crate) method: Method,
    /// How the first hits of traced views are found: by rays, or by drawing each primitive over the pixels that it may cover, t-buffer
    #[arg(long, value_name = "KIND", default_value_t)]
    visibility: Visibility,
    /// Show an OBJ file without what flatters it: seen from the front in the light of points before black, a sample a pixel
    #[arg(long)]
    plain: bool,
    /// Samples a pixel, which smooth edges: 1, 4, 9, 16, 25, 36, 49 or 64 [default: 4 for an OBJ file, else 1]
    #[arg(long, value_name = "N")]
    samples: Option<u32>,
    /// In their place more samples only where those in a pixel's corners differ by more than TOL of 255, at up to LEVELS levels, 2 to 5
    #[arg(long, value_name = "TOL[:LEVELS]", value_parser = adaptive, conflicts_with = "samples", allow_hyphen_values = true)]
    adaptive: Option<Adaptive>,
    /// How samples are weighed: box, tent or gauss
    #[arg(long, value_name = "KIND", default_value_t)]
    filter: Filter,
    /// Whether rows of samples stand aside of their grid, which gives edges that are nearly upright more steps: true or false
    #[arg(long, value_name = "BOOL", default_value_t = true, action = clap::ArgAction::Set)]
    jitter: bool,
    /// Surfaces that a ray may come from, one behind the other, by reflection or refraction: 0 to 8
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(..=i64::from(MAX_BOUNCES)))]
    bounces: u32,
    /// Count BVH nodes and primitive tests (slower)
    #[arg(long)]
    pub(crate) count: bool,
    /// Render by naive too, and say how exact the right eye is
    #[arg(long)]
    pub(crate) compare: bool,

    /// Colours: dubois, dubois-lcd, grey, colour, half-colour, green-magenta or amber-blue
    #[arg(long, value_name = "KIND", default_value_t)]
    pub(crate) anaglyph: Anaglyph,
    /// Write both eyes as one picture: side-by-side, half-side-by-side, cross-eyed, top-bottom or half-top-bottom
    #[arg(long, value_name = "KIND")]
    pub(crate) packing: Option<Packing>,
    /// Exchange the eyes in everything that is written, except the re-trace and shadow maps
    #[arg(long)]
    pub(crate) swap: bool,
    /// Write depths and primitive ids of both eyes (PFM), the right eye's re-trace map, its shadow map where a bracket
    /// method made it, and both eyes' time views (PNG)
    #[arg(long)]
    pub(crate) dump: bool,
    /// Sky: a PNG, JPEG or HDR file (equirectangular), or `procedural` [default: the scene's]
    #[arg(long, value_name = "FILE")]
    sky: Option<PathBuf>,
    /// Render N pictures of builtin:spheres, which turn once about their axis, into numbered files
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10000))]
    pub(crate) frames: Option<u32>,
    /// Render N views from left to right in place of a pair, the interaxial between neighbours
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024),
        conflicts_with_all = ["frames", "packing", "swap", "dump", "anaglyph"])]
    pub(crate) views: Option<u32>,
    /// Write the views as one picture for light-field displays, so many across and down, the first at the bottom left
    #[arg(long, value_name = "CxR", value_parser = size, requires = "views", allow_hyphen_values = true)]
    pub(crate) quilt: Option<[u32; 2]>,
    /// Width in metres of the display for which comfort is judged
    #[arg(long, value_name = "METRES", default_value_t = 0.6, value_parser = above_zero, allow_hyphen_values = true)]
    pub(crate) display_width: f32,
    /// Place N lights around the eyes [default: a built-in scene's own, a soft one for an OBJ file, 5 with --plain]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=1000), allow_hyphen_values = true)]
    lights: Option<u32>,
    /// Make lights balls of this radius, in world units: shadows get a penumbra
    #[arg(long, value_name = "R", value_parser = above_zero, allow_hyphen_values = true)]
    light_radius: Option<f32>,
    /// Rays of a sample to each light that is not a point, 1 to 32 [default: 16; 4 where an OBJ file's samples are not said]
    #[arg(long, value_name = "N")]
    shadow_rays: Option<u32>,
    /// Ask tables of directions around point lights, of so many rows, in place of shadow rays: by the nearest object alone, by its depth, or (hybrid) where
    /// they prove something, but for a margin, with rays elsewhere
    #[arg(long, value_name = "ROWS[:object|depth[=BIAS]|hybrid[=MARGIN]]", value_parser = shadow_buffer)]
    shadow_buffer: Option<ShadowBuffer>,
    /// Let what stands near keep ambient light off: by N rays a sample, 1 to 32, as far as RADIUS world units [default: a tenth of the scene's diagonal]
    #[arg(long, value_name = "N[:RADIUS]", value_parser = occlusion)]
    occlusion: Option<OcclusionArgument>,
    /// Light surfaces by the sky in place of ambient light: by N rays a sample, 1 to 32. What they meet keeps its light off
    #[arg(long, value_name = "N", conflicts_with = "occlusion")]
    sky_light: Option<u32>,
    /// Brighten pictures by so many stops, or darken them
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_hyphen_values = true)]
    exposure: f32,
    /// What becomes of what is too bright: clamp, or filmic
    #[arg(long, value_name = "clamp|filmic", default_value = "clamp", value_parser = tone)]
    tone: Tone,
    /// Where an OBJ file has no normals, edges are smooth that turn by less than DEG degrees, or none: off
    #[arg(long, value_name = "DEG|off", default_value = "30", value_parser = crease_angle, allow_hyphen_values = true)]
    crease_angle: CreaseAngle,
    /// What becomes of an OBJ file's textures that can't be read: error, or warn and go on without them
    #[arg(long, value_name = "error|warn", default_value = "error", value_parser = missing_textures)]
    missing_textures: MissingTextures,

    /// Largest OBJ, JSON, texture or sky file that is read, and largest sum of MTL files, in MiB [default: 1024, 16 for JSON]
    #[arg(long, value_name = "MIB")]
    max_file: Option<u32>,
    /// Largest sky in millions of pixels, as far as the adapter can hold it [default: 8.4, which is 4096x2048]
    #[arg(long, value_name = "MILLIONS")]
    max_sky: Option<u32>,
    /// Largest texture, and largest sum of an OBJ file's, in millions of pixels [default: 67.1, which is 8192x8192]
    #[arg(long, value_name = "MILLIONS")]
    max_texture: Option<u32>,

    #[command(flatten)]
    camera: CameraArguments,
}

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Camera")]
struct CameraArguments {
    /// JSON file of cameras by name; the options below replace parts of its camera
    #[arg(long, value_name = "FILE")]
    cameras: Option<PathBuf>,
    /// Name in that file [default: the scene's name]
    #[arg(long, value_name = "NAME", requires = "cameras")]
    camera: Option<String>,
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

impl Arguments {
    /// Reads the command line; `--help` ends the program. A fault comes back as a single line.
    pub(crate) fn read() -> Result<Self, Box<dyn Error>> {
        Self::try_parse().map_err(|error| {
            if !error.use_stderr() {
                error.exit();
            }
            // The paragraphs after the first are advice on usage.
            let text = error.to_string();
            let first = text.split("\n\n").next().unwrap_or(&text).trim_start_matches("error: ");
            format!("{}; --help lists the options", crate::single_line(first)).into()
        })
    }

    /// The scene's name, for the table and for the file of cameras.
    pub(crate) fn scene_name(&self) -> String {
        match self.builtin_name() {
            Some(name) => name.to_owned(),
            None => self.scene.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        }
    }

    fn builtin_name(&self) -> Option<&str> {
        self.scene.to_str()?.strip_prefix("builtin:")
    }

    fn builtin(&self) -> Result<Option<Builtin>, stereotrace::Error> {
        self.builtin_name().map(str::parse).transpose()
    }

    /// The same, with what follows from the scene's size.
    pub(crate) fn reaching(&self, scene: &Scene) -> Self {
        let mut settled = self.clone();
        if self.is_flattered() {
            if self.samples.is_none() && self.adaptive.is_none() {
                settled.shadow_rays.get_or_insert(studio::RAYS);
                settled.samples = Some(studio::SAMPLES);
            }
            if self.lights.is_none() && self.occlusion.is_none() && self.sky_light.is_none() {
                let reach =
                    scene.bounds().map(|(low, high)| studio::REACH * low.distance(high)).filter(|reach| *reach > 0.0);
                settled.occlusion =
                    reach.map(|reach| OcclusionArgument(settled.shadow_rays.unwrap_or(16), Some(reach)));
            }
        }
        if let (Some(OcclusionArgument(_, radius)), Some((low, high))) = (&mut settled.occlusion, scene.bounds()) {
            radius.get_or_insert(0.1 * low.distance(high));
        }
        settled
    }

    /// What to render with, by the method asked for or another one.
    pub(crate) fn options(&self, method: Method) -> Options {
        let occlusion = self
            .occlusion
            .map(|OcclusionArgument(rays, radius)| AmbientOcclusion::new(rays, radius.unwrap_or(f32::INFINITY)));
        let options = Options::new(method).visibility(self.visibility);
        let options = options.samples(self.samples.unwrap_or(1)).filter(self.filter).jitter(self.jitter);
        let options = options.adaptive(self.adaptive).bounces(self.bounces);
        let options = options.shadow_rays(self.shadow_rays.unwrap_or(16)).occlusion(occlusion).sky_rays(self.sky_light);
        options.exposure(self.exposure).tone(self.tone).shadow_buffer(self.shadow_buffer)
    }

    fn limits(&self) -> Limits {
        let mut limits = Limits::default().option_names("--max-file", "--max-sky").texture_option_name("--max-texture");
        if let Some(mebibytes) = self.max_file {
            let bytes = u64::from(mebibytes) << 20;
            limits = limits.file_bytes(bytes).json_bytes(bytes);
        }
        if let Some(millions) = self.max_sky {
            limits = limits.sky_pixels(1_000_000 * u64::from(millions));
        }
        if let Some(millions) = self.max_texture {
            limits = limits.texture_pixels(1_000_000 * u64::from(millions));
        }
        limits
    }

    /// Whether it is an OBJ file that may be shown at its best.
    fn is_flattered(&self) -> bool {
        self.builtin_name().is_none() && !self.plain && self.camera.cameras.is_none()
    }

    /// Reads the scene's sky, once it is known what the adapter can hold.
    pub(crate) fn sky(&self, scene: &mut Scene, gpu: &Gpu) -> Result<(), Box<dyn Error>> {
        match &self.sky {
            None if self.is_flattered() => scene.sky = studio::backdrop(),
            None => {}
            Some(name) if name.as_os_str() == "procedural" => scene.sky = Sky::Map(SkyMap::procedural(1024)?),
            Some(file) => scene.sky = Sky::Map(SkyMap::open_within(file, &self.limits().gpu(gpu))?),
        }
        Ok(())
    }

    /// Reads or builds the scene, without its sky.
    pub(crate) fn scene(&self) -> Result<Scene, Box<dyn Error>> {
        if self.frames.is_some() && self.builtin()? != Some(Builtin::Spheres) {
            return Err("--frames turns builtin:spheres only".into());
        }
        if let Some(builtin) = self.builtin()? {
            return Ok(builtin.scene());
        }
        if self.scene.is_dir() || !self.scene.exists() {
            let fault = if self.scene.is_dir() { "is a folder" } else { "no such file" };
            let names = Builtin::ALL.iter().map(|builtin| format!("builtin:{builtin}"));
            let names = Vec::from_iter(names).join(", ");
            return Err(format!("{}: {fault}; give an OBJ file, or one of {names}", crate::shown(&self.scene)).into());
        }
        let options = ObjOptions::default()
            .limits(self.limits())
            .missing_textures(self.missing_textures)
            .crease_angle(self.crease_angle.0);
        Ok(Scene::from_obj_with(&self.scene, &options)?)
    }

    /// The camera of the file of cameras, of the built-in scene, or one that fits the object, with those parts
    /// replaced that have an option of their own.
    pub(crate) fn stereo_camera(&self, scene: &Scene) -> Result<StereoCamera, Box<dyn Error>> {
        let [width, height] = self.size;
        let camera = match (&self.camera.cameras, self.builtin()?) {
            (Some(file), _) => {
                StereoCamera::from_json_within(file, &self.camera_name(), width, height, &self.limits())?
            }
            (None, Some(builtin)) => builtin.camera(width, height),
            (None, None) => self.camera.fitting(scene, width, height, self.is_flattered())?,
        };
        let camera = self.camera.replace_parts(camera);
        camera.pose()?; // faults now, not after the scene is on the device
        Ok(camera)
    }

    /// The camera's name in the file of cameras.
    fn camera_name(&self) -> String {
        self.camera.camera.clone().unwrap_or_else(|| self.scene_name())
    }

    /// Places the lights, and gives them their size.
    pub(crate) fn light(&self, scene: &mut Scene, camera: &StereoCamera) -> Result<(), Box<dyn Error>> {
        self.place_lights(scene, camera)?;
        if let Some(radius) = self.light_radius {
            for light in scene.lights.iter_mut().filter(|light| light.shape == LightShape::Point) {
                *light = Light::sphere(light.position, radius, light.intensity);
            }
        }
        Ok(())
    }

    /// Places the lights, unless the scene or the file of cameras brings its own and no number was asked for.
    fn place_lights(&self, scene: &mut Scene, camera: &StereoCamera) -> Result<(), Box<dyn Error>> {
        if let (None, Some(file)) = (self.lights, &self.camera.cameras)
            && scene.light_from_json_within(file, &self.camera_name(), &self.limits())?
        {
            return Ok(());
        }
        let count = match self.lights {
            None if self.builtin()?.is_some() => return Ok(()),
            None if self.is_flattered() => return Ok(studio::light(scene, camera)?),
            count => count.unwrap_or(DEFAULT_LIGHTS),
        };
        Ok(scene.place_lights(count as usize, camera)?)
    }
}

impl CameraArguments {
    /// A camera that fits the object. Seen from or towards another point, it has screen and interaxial as
    /// [`StereoCamera::look_at`] has.
    fn fitting(
        &self,
        scene: &Scene,
        width: u32,
        height: u32,
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

    fn replace_parts(&self, mut camera: StereoCamera) -> StereoCamera {
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
