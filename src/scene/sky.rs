//! Sky maps.

use std::sync::Arc;

use glam::Vec3;

use crate::{Error, message::counted};

/// An equirectangular picture of the surroundings, linear RGB. The top row is straight up, the middle column points to
/// -z, and columns turn to the right. Sampling is bilinear, also across the seam and the poles. Clones share the
/// pixels.
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "super::serialised::GivenSkyMap")
)]
#[derive(Clone, PartialEq)]
pub struct SkyMap {
    width: u32,
    height: u32,
    /// The pixels, row-major. `Arc<[Vec3]>` would copy the list when it is made.
    pixels: Arc<Vec<Vec3>>,
}

impl std::fmt::Debug for SkyMap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "SkyMap {}x{}", self.width, self.height)
    }
}

/// Largest width that [`SkyMap::procedural`] accepts: 1.6 GB.
const MAX_PROCEDURAL_WIDTH: u32 = 16_384;

impl SkyMap {
    /// Makes a sky from `width * height` colours, row-major, linear RGB.
    ///
    /// # Errors
    /// [`Error::Scene`] if the number of colours is wrong, the width is odd, or a colour is negative or not finite. An
    /// odd width has no opposite column half a width away, as the poles require.
    pub fn new(width: u32, height: u32, pixels: Vec<Vec3>) -> Result<Self, Error> {
        let fault = |reason| Err(Error::Scene { element: "sky".into(), reason });
        if !is_map(width, height) || pixels.len() as u64 != u64::from(width) * u64::from(height) {
            let colors = counted(pixels.len(), "colour", "colours");
            return fault(format!("a map of {width}x{height} can't have {colors}; its width must be even"));
        }
        if let Some(index) = pixels.iter().position(|color| !color.is_finite() || color.min_element() < 0.0) {
            let (row, column) = (index / width as usize, index % width as usize);
            return fault(format!(
                "the colour in row {row}, column {column} is {}; it must be finite and not negative",
                pixels[index]
            ));
        }
        Ok(Self { width, height, pixels: Arc::new(pixels) })
    }

    /// Returns whether both maps are clones of one map.
    pub(crate) fn shares_pixels(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.pixels, &other.pixels) && (self.width, self.height) == (other.width, other.height)
    }

    /// Makes a sky with a sun and streaks of cloud over a plain, `width` pixels wide and half as high.
    ///
    /// # Errors
    /// [`Error::Scene`] for a width that is odd, zero or over 16,384.
    pub fn procedural(width: u32) -> Result<Self, Error> {
        if width > MAX_PROCEDURAL_WIDTH {
            let reason = format!("a procedural sky of width {width}; it can be at most {MAX_PROCEDURAL_WIDTH} wide");
            return Err(Error::Scene { element: "sky".into(), reason });
        }
        let height = width / 2;
        let sun = Vec3::new(0.5, 0.45, -0.75).normalize();
        let color = |index: u32| {
            let d = direction(width, height, index % width, index / width);
            if d.y < 0.0 {
                return Vec3::new(0.16, 0.14, 0.11).lerp(Vec3::new(0.3, 0.3, 0.3), (1.0 + 6.0 * d.y).max(0.0));
            }
            let clear = Vec3::new(0.62, 0.72, 0.85).lerp(Vec3::new(0.12, 0.27, 0.6), d.y.sqrt());
            // The ray hits a cloud layer here; distant streaks fade into haze.
            let (x, z) = (d.x / (d.y + 0.15), d.z / (d.y + 0.15));
            let streaks =
                (2.1 * x + (1.3 * z).sin()).sin() * (1.7 * z + (0.9 * x).cos()).sin() + 0.4 * (5.3 * x - 4.1 * z).sin();
            let cloud = (0.5 * streaks).clamp(0.0, 0.7);
            let glow = d.dot(sun).max(0.0).powi(400) * 0.9 + d.dot(sun).max(0.0).powi(12) * 0.2;
            clear.lerp(Vec3::splat(0.85), cloud) + Vec3::new(1.0, 0.9, 0.7) * glow
        };
        Self::new(width, height, (0..width * height).map(color).collect())
    }

    /// Turns the sky about the world's y axis, by an angle in degrees and to the right: at 90 degrees, the middle
    /// column points to +x. The angle is rounded to whole columns, so no highlight is blurred.
    ///
    /// # Errors
    /// [`Error::Scene`] for an angle that is not finite.
    pub fn turned(&self, degrees: f64) -> Result<Self, Error> {
        if !degrees.is_finite() {
            return Err(Error::Scene {
                element: "sky".into(),
                reason: format!("it can't be turned by {degrees} degrees"),
            });
        }
        let columns =
            ((degrees / 360.0).rem_euclid(1.0) * f64::from(self.width)).round() as usize % self.width as usize;
        if columns == 0 {
            return Ok(self.clone());
        }
        let mut pixels = self.pixels.to_vec();
        pixels.chunks_mut(self.width as usize).for_each(|row| row.rotate_right(columns));
        Ok(Self { pixels: Arc::new(pixels), ..*self })
    }

    /// Multiplies the sky's light.
    ///
    /// # Errors
    /// [`Error::Scene`] for a factor that is negative or not finite, or that makes a colour infinite.
    pub fn scaled(&self, factor: f32) -> Result<Self, Error> {
        if factor == 1.0 {
            return Ok(self.clone());
        }
        let pixels = self.pixels.iter().map(|pixel| *pixel * factor).collect();
        Self::new(self.width, self.height, pixels)
    }

    /// Returns width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    pub(crate) fn pixels(&self) -> &[Vec3] {
        &self.pixels
    }
}

/// Returns whether a picture of this size can be a map. Its width must be even, so that each column has an opposite
/// one.
pub(crate) fn is_map(width: u32, height: u32) -> bool {
    width > 0 && height > 0 && width.is_multiple_of(2)
}

/// Returns the direction of a pixel's centre.
fn direction(width: u32, height: u32, column: u32, row: u32) -> Vec3 {
    use std::f32::consts::{PI, TAU};
    let around = ((column as f32 + 0.5) / width as f32 - 0.5) * TAU;
    let down = (row as f32 + 0.5) / height as f32 * PI;
    Vec3::new(down.sin() * around.sin(), down.cos(), -down.sin() * around.cos())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocking::Wait;
    use crate::{
        Fetch, Gpu, Method, Options, Renderer, Scene, Sky, StereoCamera, Traversal, UploadedScene, testing::cpu,
    };

    /// Makes a sky whose colour is its direction.
    fn compass(width: u32) -> SkyMap {
        let color = |index| 0.5 + 0.5 * direction(width, width / 2, index % width, index / width);
        SkyMap::new(width, width / 2, (0..width * width / 2).map(color).collect()).unwrap()
    }

    #[test]
    fn a_turned_sky_has_its_colours_to_the_right() {
        let sky = compass(64);
        let pixel = |sky: &SkyMap, column: usize| sky.pixels()[16 * 64 + column];
        let turned = sky.turned(90.0).unwrap();
        // The column that points to -z, before the middle, now points to +x.
        assert_eq!(pixel(&turned, 48), pixel(&sky, 32));
        assert_eq!(pixel(&turned, 0), pixel(&sky, 48));
        assert!(sky.turned(-270.0).unwrap() == turned && sky.turned(810.0).unwrap() == turned);
        assert!(sky.turned(0.0).unwrap() == sky && sky.turned(360.0).unwrap() == sky);
        assert!(sky.turned(359.99).unwrap() == sky);
        assert!(sky.turned(f64::NAN).unwrap_err().to_string().contains("can't be turned by NaN degrees"));
        assert_eq!(pixel(&sky.scaled(4.0).unwrap(), 5), 4.0 * pixel(&sky, 5));
        for factor in [-1.0, f32::NAN, f32::INFINITY] {
            assert!(sky.scaled(factor).unwrap_err().to_string().contains("finite and not negative"), "{factor}");
        }
    }

    #[test]
    fn every_direction_has_its_colour_poles_and_seam_included() {
        let gpu = Gpu::under_test();
        // The larger one is uploaded in several pieces.
        for (width, fetch) in [(256, Fetch::Texture), (2048, Fetch::Texture), (2048, Fetch::Buffer)] {
            let mut renderer = Renderer::with_traversal(gpu.clone(), Traversal::of(&gpu).fetch(fetch));
            let mut scene = Scene::new();
            scene.sky = Sky::Map(compass(width));
            let uploaded = renderer.upload(&scene).wait().unwrap();
            for target in [Vec3::Z, -Vec3::Z, Vec3::X, Vec3::Y, -Vec3::Y, Vec3::new(0.01, -0.3, 1.0)] {
                assert_colours_are_directions(&mut renderer, &uploaded, target);
            }
        }
    }

    fn assert_colours_are_directions(renderer: &mut Renderer, uploaded: &UploadedScene, target: Vec3) {
        let up = if target.y.abs() > 0.9 { Vec3::Z } else { Vec3::Y };
        let camera = StereoCamera::look_at(Vec3::ZERO, target).up(up).size(65, 33).vertical_fov_degrees(60.0);
        let pair =
            renderer.pair(uploaded, &camera).options(&Options::new(Method::Naive).linear(true)).read().wait().unwrap();
        let frame = cpu::Frame::new(&pair.pose);
        for (index, color) in pair.left.linear.iter().enumerate() {
            let d = frame.direction(cpu::Eye::Left, index % 65, index / 65).normalize();
            let found = Vec3::new(color[0], color[1], color[2]);
            // Pixels are 1.4 degrees apart, and a chord is 7.5e-5 short of its arc, in both directions. The limit is
            // twice that.
            assert!((found - (0.5 + 0.5 * d)).abs().max_element() < 3e-4, "{target} {index}: {found} {d}");
        }
    }

    #[test]
    fn maps_that_are_none_are_refused() {
        for (width, height, count) in [(4, 2, 7), (3, 2, 6), (0, 2, 0)] {
            let message = SkyMap::new(width, height, vec![Vec3::ONE; count]).unwrap_err().to_string();
            assert!(
                message
                    .contains(&format!("a map of {width}x{height} can't have {count} colours; its width must be even")),
                "{message}"
            );
        }
        let mut pixels = vec![Vec3::ONE; 8];
        pixels[6].y = f32::NAN;
        let message = SkyMap::new(4, 2, pixels).unwrap_err().to_string();
        assert!(message.contains("row 1, column 2"), "{message}");
    }

    #[test]
    fn the_procedural_sky_has_a_bright_sun_and_no_seam() {
        let sky = SkyMap::procedural(128).unwrap();
        let row = |row: usize| &sky.pixels()[row * 128..(row + 1) * 128];
        for y in 0..64 {
            let step = |a: Vec3, b: Vec3| (a - b).abs().max_element();
            let widest = row(y).windows(2).map(|pair| step(pair[0], pair[1])).fold(0.0, f32::max);
            assert!(step(row(y)[127], row(y)[0]) <= widest.max(0.02), "row {y}");
        }
        assert!(sky.pixels().iter().any(|color| color.min_element() > 1.0));
        for width in [0, 1, 7, 100_000, u32::MAX] {
            let message = SkyMap::procedural(width).unwrap_err().to_string();
            assert!(message.contains("sky") && message.contains(&width.to_string()), "{message}");
        }
    }
}
