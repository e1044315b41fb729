//! Light that is sampled: lights with a size, and paths.

use std::error::Error;

use stereotrace::{Light, Lighting, Method, Options};

use super::scenes::BenchScene;

const BOUNCES: u32 = 2;

/// Numbers of samples of light.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sampled {
    /// Rays to each light, if all lights are spheres.
    pub soft: Option<u32>,
    /// Paths per pixel.
    pub paths: Option<u32>,
}

impl Sampled {
    pub fn is_any(self) -> bool {
        self.soft.is_some() || self.paths.is_some()
    }

    /// Returns the samples as text, which is empty without any.
    pub fn text(self) -> String {
        let soft = self.soft.map_or(String::new(), |rays| format!(", {rays} rays to each light"));
        soft + &self.paths.map_or(String::new(), |paths| format!(", {paths} paths per pixel"))
    }

    pub fn options(self, method: Method) -> Options {
        let options = Options::new(method).shadow_rays(self.soft.unwrap_or(1)).linear(self.is_any());
        match self.paths {
            Some(samples) => options.lighting(Lighting::Paths { bounces: BOUNCES, samples }),
            None => options,
        }
    }
}

/// Makes all lights spheres.
pub fn soften(BenchScene { scene, camera, .. }: &mut BenchScene) -> Result<(), Box<dyn Error>> {
    let radius = 0.05 * camera.target_position().distance(camera.pose()?.eye) as f32;
    for light in &mut scene.lights {
        *light = Light::sphere(light.position, radius, light.intensity);
    }
    Ok(())
}
