//! Skies with sun and clouds, and the light that comes from them.

use std::f32::consts::{PI, TAU};

use glam::Vec3;

use super::{assets::Assets, dice::Dice, materials::hsv, noise::smooth_noise};
use crate::{Error, Light, Sky, SkyMap};

/// Width of a made sky in pixels.
const WIDTH: u32 = 512;
/// Mean brightness of the upper half of a sky from a file.
const MEAN: f32 = 0.42;

/// A sky, the direction of its sun, and the light of both.
pub(super) struct Heaven {
    pub(super) sky: Sky,
    pub(super) sun: Sun,
    /// Light from all of the sky.
    pub(super) ambient: Vec3,
}

/// The sun's direction, of unit length, and its light.
#[derive(Clone, Copy)]
pub(super) struct Sun {
    towards: Vec3,
    intensity: Vec3,
}

impl Sun {
    /// Returns a light far outside a scene of this size in metres. A point is faster than a light at infinity, whose
    /// shadows are computed as those of soft lights.
    pub(super) fn light(self, size: f32) -> Light {
        /// Distance as a multiple of the scene's size.
        const FAR: f32 = 12.0;
        Light::point((self.towards * FAR * size).as_dvec3(), self.intensity)
    }
}

/// Makes a sky, or takes one of the user's folder.
pub(super) fn heaven(assets: &Assets, dice: &mut Dice) -> Result<Heaven, Error> {
    match assets.sky_count() {
        0 => made(dice),
        count => of_file(&assets.sky(dice.below(count))?, dice),
    }
}

fn made(dice: &mut Dice) -> Result<Heaven, Error> {
    let (azimuth, elevation) = (dice.angle(), dice.between(0.25, 1.25));
    let towards = Vec3::new(elevation.cos() * azimuth.sin(), elevation.sin(), -elevation.cos() * azimuth.cos());
    let low = (1.0 - elevation / 0.9).clamp(0.0, 1.0);
    let haze = dice.between(0.0, 1.0);
    let zenith = hsv(0.6 + dice.between(-0.03, 0.03), 0.75 - 0.45 * haze, dice.between(0.55, 0.9));
    let horizon = hsv(0.58, 0.25 - 0.2 * haze, 0.93).lerp(hsv(0.08, 0.35, 0.97), 0.7 * low);
    let ground = hsv(dice.between(0.05, 0.3), dice.between(0.05, 0.35), dice.between(0.25, 0.5));
    let (cover, scale) = (dice.between(0.35, 0.75), dice.between(0.05, 0.16));
    let shift = glam::Vec2::new(dice.unit(), dice.unit());
    let warm = Vec3::new(1.0, 0.93 - 0.18 * low, 0.82 - 0.4 * low);
    let color = |index: u32| {
        let d = direction(index % WIDTH, index / WIDTH);
        if d.y < 0.0 {
            return ground.lerp(horizon, (1.0 + 9.0 * d.y).max(0.0).powi(2));
        }
        let clear = horizon.lerp(zenith, d.y.powf(0.45));
        let cloud = smooth_noise(shift + glam::Vec2::new(d.x, d.z) * scale / (d.y + 0.12));
        let cloud = ((cloud - cover) * 5.0).clamp(0.0, 1.0) * (6.0 * d.y).min(1.0);
        let toward = d.dot(towards).max(0.0);
        let glow = 2.5 * toward.powi(900) + 0.25 * toward.powi(24);
        clear.lerp(Vec3::splat(0.92 - 0.25 * cloud), 0.9 * cloud) + warm * glow
    };
    let map = SkyMap::new(WIDTH, WIDTH / 2, (0..WIDTH * WIDTH / 2).map(color).collect())?;
    let sun = Sun { towards, intensity: warm * dice.between(0.65, 0.95) };
    Ok(Heaven { sky: Sky::Map(map), sun, ambient: 0.38 * zenith + 0.28 * horizon })
}

/// Turns a sky and scales its brightness. The sun is where the sky is brightest.
fn of_file(sky: &SkyMap, dice: &mut Dice) -> Result<Heaven, Error> {
    let sky = sky.turned(f64::from(dice.between(0.0, 360.0)))?;
    let [width, height] = sky.size().map(|side| side as usize);
    let upper = &sky.pixels()[..width * height.div_ceil(2)];
    // A sun's pixels would hide the brightness of the rest.
    let mean = upper.iter().map(|color| color.min(Vec3::splat(4.0))).sum::<Vec3>() / upper.len() as f32;
    let sky = sky.scaled((MEAN / mean.element_sum().max(1e-4) * 3.0).min(100.0))?;
    let bright = |place: usize| sky.pixels()[place].element_sum();
    let brightest = (0..upper.len()).max_by(|&one, &other| bright(one).total_cmp(&bright(other))).unwrap_or(0);
    let (column, row) = (brightest % width, brightest / width);
    let around = ((column as f32 + 0.5) / width as f32 - 0.5) * TAU;
    let down = ((row as f32 + 0.5) / height as f32 * PI).min(1.3);
    let towards = Vec3::new(down.sin() * around.sin(), down.cos(), -down.sin() * around.cos());
    let strength = if bright(brightest) > 12.0 { 0.75 } else { 0.35 };
    let sun = Sun { towards, intensity: Vec3::new(1.0, 0.96, 0.9) * strength };
    let tint = mean / mean.max_element().max(1e-4);
    Ok(Heaven { ambient: tint * (0.95 - strength), sky: Sky::Map(sky), sun })
}

/// Returns the direction of a pixel's centre, as sky maps have it.
fn direction(column: u32, row: u32) -> Vec3 {
    let around = ((column as f32 + 0.5) / WIDTH as f32 - 0.5) * TAU;
    let down = (row as f32 + 0.5) / (WIDTH / 2) as f32 * PI;
    Vec3::new(down.sin() * around.sin(), down.cos(), -down.sin() * around.cos())
}
