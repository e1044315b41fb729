//! The scenes: built-in ones, those of the stability suite, OBJ files unpacked beside the build, and any scene file by
//! its path.

use super::files::root;
use std::path::{Path, PathBuf};

use stereotrace::{
    Error, Scene, SceneFile, SceneOptions, Sky, SkyMap, StereoCamera,
    glam::Vec3,
    scene::builtin::{Builtin, spheres_turned},
    testing::suite::Trial,
};

/// Names the folder that holds NAME/NAME.obj and cameras.json, in place of target/scenes.
pub const FOLDER_VARIABLE: &str = "STEREOTRACE_SCENES";
/// Lights of a scene that has none of its own, placed by the library's rule.
const LIGHTS: usize = 5;
/// How far the animated spheres have turned in the picture that is measured, radians.
const TURN: f32 = std::f32::consts::FRAC_PI_3;
/// Columns of the sky that the thesis's scenes get.
const SKY_WIDTH: u32 = 1024;

/// A scene and the camera that it is measured with.
pub struct BenchScene {
    pub name: String,
    pub scene: Scene,
    pub camera: StereoCamera,
}

/// The scene of this name, or that of the file at this path; `None` if there is none of a name. `lights` are placed by
/// the library's rule; without a number built-in scenes, trials and files keep their own, and files without any get
/// five. A file is seen by its first camera, and without one so that all of it fits the picture.
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

/// A scene file and a camera that sees it.
fn open(path: &Path, [width, height]: [u32; 2]) -> Result<(Scene, StereoCamera), Error> {
    let SceneFile { scene, cameras, .. } = SceneFile::open(path, &SceneOptions::default())?;
    let camera = match (cameras.first(), scene.bounds()) {
        (Some((_, camera)), _) => camera.size(width, height),
        (None, Some(bounds)) => StereoCamera::fitting(bounds, width, height),
        (None, None) => StereoCamera::look_at(Vec3::Z, Vec3::ZERO).size(width, height),
    };
    Ok((scene, camera))
}

/// A scene of the thesis, with camera and lights from scenes/thesis.json and a sky, or `None` if no such file is there.
/// `spheres-turned` is a picture out of the animation. Another number of lights is placed by the library's rule.
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

/// What a figure calls a scene: meshes by their own name, where a test's name could pass for a better-known one.
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

/// What to say of a scene that is not there.
pub fn skipped(name: &str) -> String {
    format!(
        "{name}: skipped: scene not found; put {name}/{name}.obj and cameras.json under target/scenes or set \
        {FOLDER_VARIABLE}, or give a file's path"
    )
}
