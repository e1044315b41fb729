//! Renders natively what the page shows, for comparison: `cargo run --example web_native -- REQUEST.json FOLDER`.
//!
//! The request has `scene` (`{"builtin": NAME}` or `{"file": PATH}`), `camera` as on the page, `methods`, and the
//! number of timed `rounds`. The program writes `METHOD-left.png` and `METHOD-right.png` into the folder. It prints the
//! adapter and the median time of each method's pair as JSON.

use std::{error::Error, fs, path::Path, time::Instant};

use serde_json::{Value, json};
use stereotrace::{
    Builtin, Gpu, Method, Options, Renderer, Scene, SceneFile, SceneOptions, Sky, StereoCamera, blocking::Wait,
    glam::Vec3,
};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let (Some(request), Some(folder)) = (arguments.next(), arguments.next()) else {
        return Err("usage: web_native REQUEST.json FOLDER".into());
    };
    let request: Value = serde_json::from_slice(&fs::read(request)?)?;
    let folder = Path::new(&folder);
    let camera = camera(&request["camera"])?;
    let scene = scene(&request["scene"], &camera)?;
    let mut renderer = Renderer::new(Gpu::new().wait()?);
    let uploaded = renderer.upload(&scene).wait()?;
    let mut times = serde_json::Map::new();
    for name in request["methods"].as_array().ok_or("no methods")? {
        let name = name.as_str().ok_or("a method that is no name")?;
        let options = Options::new(name.parse::<Method>()?);
        let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait()?;
        for (eye, view) in [("left", &pair.left), ("right", &pair.right)] {
            view.picture().save_png(folder.join(format!("{name}-{eye}.png")))?;
        }
        let rounds = request["rounds"].as_u64().unwrap_or(0);
        let mut taken = Vec::new();
        for _ in 0..rounds {
            let begin = Instant::now();
            renderer.pair(&uploaded, &camera).options(&options).read().wait()?;
            taken.push(1e3 * begin.elapsed().as_secs_f64());
        }
        taken.sort_by(f64::total_cmp);
        times.insert(name.into(), json!(taken.get(taken.len() / 2)));
    }
    println!("{}", json!({ "adapter": renderer.gpu().adapter_name(), "ms": times }));
    Ok(())
}

fn camera(given: &Value) -> Result<StereoCamera, Box<dyn Error>> {
    let number = |name: &str| given[name].as_f64().map(|number| number as f32).ok_or(format!("camera: no {name}"));
    let point = |name: &str| -> Result<Vec3, Box<dyn Error>> {
        let numbers: Vec<f32> = serde_json::from_value(given[name].clone())?;
        Ok(Vec3::from_slice(numbers.get(..3).ok_or(format!("camera: no {name}"))?))
    };
    let size: [u32; 2] = serde_json::from_value(given["size"].clone())?;
    Ok(StereoCamera::look_at(point("eye")?, point("target")?)
        .up(point("up")?)
        .size(size[0], size[1])
        .vertical_fov_degrees(number("fov")?)
        .screen_distance(number("screenDistance")?)
        .interaxial(number("interaxial")?))
}

/// Opens a scene like the page: files get the page's backdrop, and three lights beside the eyes if they have none.
fn scene(given: &Value, camera: &StereoCamera) -> Result<Scene, Box<dyn Error>> {
    if let Some(name) = given["builtin"].as_str() {
        return Ok(name.parse::<Builtin>()?.scene());
    }
    let SceneFile { mut scene, .. } =
        SceneFile::open(given["file"].as_str().ok_or("scene: no file")?, &SceneOptions::default())?;
    scene.sky = Sky::Gradient { nadir: Vec3::new(0.26, 0.27, 0.29), zenith: Vec3::new(0.52, 0.56, 0.62) };
    if scene.lights.is_empty() {
        scene.place_lights(3, camera)?;
    }
    Ok(scene)
}
