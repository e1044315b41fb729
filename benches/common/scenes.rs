//! Loads scenes by name: built-in scenes, trials of the stability suite, and OBJ files under target/scenes. Any scene
//! file can be given by its path.

use super::files::root;
use std::path::{Path, PathBuf};

use stereotrace::{
    Error, Scene, SceneFile, SceneOptions, Sky, SkyMap, StereoCamera,
    glam::Vec3,
    scene::builtin::{Builtin, spheres_turned},
    testing::suite::Trial,
};

/// Environment variable with the folder that holds NAME/NAME.obj and cameras.json. The default is target/scenes.
pub const FOLDER_VARIABLE: &str = "STEREOTRACE_SCENES";
/// Number of lights in a scene that has none of its own, placed by the library's rule.
const LIGHTS: usize = 5;
/// Rotation of the animated spheres in the measured picture, in radians.
const TURN: f32 = std::f32::consts::FRAC_PI_3;
/// Width in pixels of the sky of the thesis's scenes.
const SKY_WIDTH: u32 = 1024;

/// A scene and its camera.
pub struct BenchScene {
    pub name: String,
    pub scene: Scene,
    pub camera: StereoCamera,
}

/// Loads the scene of this name, or the scene file at this path. Returns `None` if no scene has the name. If `lights`
/// is given, the library's rule places this number of lights. Otherwise scenes keep their own lights, and scenes
/// without lights get five. The camera is the file's first one. For a file without cameras, the whole scene fits the
/// picture.
pub fn load(
    name: &str,
    [width, height]: [u32; 2],
    e_px: f32,
    lights: Option<usize>,
) -> Result<Option<BenchScene>, Error> {
    let path = Path::new(name);
    let (title, (mut scene, camera)) = if path.extension().is_some() {
        (path.file_stem().unwrap_or_default().to_string_lossy(), open(path, [width, height])?)
    } else if let Ok(builtin) = name.parse::<Builtin>() {
        (name.into(), (builtin.scene(), builtin.camera(width, height)))
    } else if let Ok(trial) = name.parse::<Trial>() {
        (name.into(), (trial.scene(), trial.camera(width, height)))
    } else {
        let folder = folder();
        let (obj, cameras) = (folder.join(name).join(format!("{name}.obj")), folder.join("cameras.json"));
        if !obj.is_file() || !cameras.is_file() {
            return Ok(None);
        }
        (name.into(), (Scene::from_obj(obj)?, StereoCamera::from_json(cameras, name, width, height)?))
    };
    let camera = camera.interaxial_pixels(e_px);
    if let Some(lights) = lights.or(scene.lights.is_empty().then_some(LIGHTS)) {
        scene.place_lights(lights, &camera)?;
    }
    Ok(Some(BenchScene { name: title.into(), scene, camera }))
}

/// Opens a scene file, and returns it with a camera.
fn open(path: &Path, [width, height]: [u32; 2]) -> Result<(Scene, StereoCamera), Error> {
    let SceneFile { scene, cameras, .. } = SceneFile::open(path, &SceneOptions::default())?;
    let camera = match (cameras.first(), scene.bounds()) {
        (Some((_, camera)), _) => camera.size(width, height),
        (None, Some(bounds)) => StereoCamera::fitting(bounds, width, height),
        (None, None) => StereoCamera::look_at(Vec3::Z, Vec3::ZERO).size(width, height),
    };
    Ok((scene, camera))
}

/// Loads a scene of the thesis with the camera and lights of scenes/thesis.json and a sky. Returns `None` if its file
/// is missing. `spheres-turned` is one picture of the animation. If `lights` is given, the library's rule places this
/// number of lights.
pub fn load_thesis(
    name: &str,
    [width, height]: [u32; 2],
    e_px: f32,
    lights: Option<usize>,
) -> Result<Option<BenchScene>, Error> {
    let data = &root().join("scenes/thesis.json");
    let (mut scene, entry) = match name {
        "spheres" => (Builtin::Spheres.scene(), name),
        "spheres-turned" => (spheres_turned(TURN)?, "spheres"),
        _ => {
            let obj = folder().join(name).join(format!("{name}.obj"));
            if !obj.is_file() {
                return Ok(None);
            }
            (Scene::from_obj(obj)?, name)
        }
    };
    let camera = StereoCamera::from_json(data, entry, width, height)?.interaxial_pixels(e_px);
    match lights {
        Some(lights) => scene.place_lights(lights, &camera)?,
        None => drop(scene.light_from_json(data, entry)?),
    }
    scene.sky = Sky::Map(SkyMap::procedural(SKY_WIDTH)?);
    Ok(Some(BenchScene { name: name.into(), scene, camera }))
}

/// Returns the title of a scene in figures. Meshes have their full names here, since a short name could be mistaken for
/// a better-known mesh.
pub fn title(name: &str) -> &str {
    match name {
        "sponza" => "Dabrovic Sponza",
        "sponza_4x" => "Dabrovic Sponza 4x",
        "dragon" => "Stanford Dragon",
        "buddha_1m2" => "subdivided Buddha",
        "spheres" => "fixed spheres",
        "spheres-turned" => "animated spheres",
        other => other,
    }
}

fn folder() -> PathBuf {
    match std::env::var_os(FOLDER_VARIABLE) {
        Some(folder) => folder.into(),
        None => root().join("target/scenes"),
    }
}

/// Returns the message for a scene that was not found.
pub fn skipped(name: &str) -> String {
    format!(
        "{name}: skipped: scene not found; put {name}/{name}.obj and cameras.json under target/scenes or set \
        {FOLDER_VARIABLE}, or give a file's path"
    )
}
