//! The scenes: built-in ones, and OBJ files that were unpacked beside the build.

use std::path::{Path, PathBuf};

use stereotrace::{Error, Scene, StereoCamera, scene::builtin::Builtin};

use crate::options::Plan;

/// Names the folder that holds NAME/NAME.obj and cameras.json, in place of target/scenes.
pub(crate) const FOLDER_VARIABLE: &str = "STEREOTRACE_SCENES";
/// Lights of a scene that has none of its own, placed by the library's rule.
const LIGHTS: usize = 5;

/// A scene and the camera that it is measured with.
pub(crate) struct BenchScene {
    pub(crate) name: String,
    pub(crate) scene: Scene,
    pub(crate) camera: StereoCamera,
}

/// The scene of this name, or `None` if no such file is there.
pub(crate) fn load(name: &str, plan: &Plan) -> Result<Option<BenchScene>, Error> {
    let [width, height] = plan.size;
    let (mut scene, camera, lights) = match name.parse::<Builtin>() {
        Ok(builtin) => (builtin.scene(), builtin.camera(width, height), plan.lights),
        Err(_) => {
            let folder = folder();
            let (obj, cameras) = (folder.join(name).join(format!("{name}.obj")), folder.join("cameras.json"));
            if !obj.is_file() || !cameras.is_file() {
                return Ok(None);
            }
            let camera = StereoCamera::from_json(cameras, name, width, height)?;
            (Scene::from_obj(obj)?, camera, plan.lights.or(Some(LIGHTS)))
        }
    };
    let camera = camera.interaxial_pixels(plan.e_px);
    if let Some(lights) = lights {
        scene.place_lights(lights, &camera)?;
    }
    Ok(Some(BenchScene { name: name.into(), scene, camera }))
}

/// What a figure calls a scene: meshes by their own name, where a test's name could pass for a better-known one.
pub(crate) fn title(name: &str) -> &str {
    match name {
        "sponza" => "Dabrovic Sponza",
        "sponza_4x" => "Dabrovic Sponza 4x",
        "dragon" => "Stanford Dragon",
        "buddha_1m2" => "subdivided Buddha",
        other => other,
    }
}

fn folder() -> PathBuf {
    match std::env::var_os(FOLDER_VARIABLE) {
        Some(folder) => folder.into(),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("target/scenes"),
    }
}
