//! Chooses an exposure by what the eyes see.

use crate::{Channel, Error, Lighting, Method, Options, Renderer, StereoCamera, UploadedScene, srgb::BRIGHTNESS};

/// Width of the picture that is measured, in pixels.
const WIDTH: u32 = 96;
/// Number of paths per pixel of that picture.
const PATHS: u32 = 8;
/// Range of the geometric mean of an exposed picture's brightness.
const MIDDLE: [f64; 2] = [0.12, 0.5];
/// Share of the picture that may be brighter than white.
const BURNT: f64 = 0.1;
/// Stops are rounded to this fraction of one, so that noise seldom changes them.
const STEP: f64 = 0.25;
/// Share of the mean that counts as the least brightness of a pixel.
const LEAST: f64 = 1e-3;

impl Renderer {
    /// Returns an exposure in stops for [`Options::exposure`] by which the picture is neither dark nor burnt. It is 0
    /// if no change is needed.
    ///
    /// The rule measures the brightness of small pictures of both eyes under the options' light. Exposed, its geometric
    /// mean is from 0.12 to 0.5, and at most a tenth of it is brighter than white. If both are not possible, the
    /// exposure is halfway between. It is a multiple of a quarter stop.
    ///
    /// ```
    /// use stereotrace::{Builtin, Gpu, Options, Renderer, blocking::Wait, glam::Vec3};
    ///
    /// let (mut scene, camera) = (Builtin::Hall.scene(), Builtin::Hall.camera(640, 480));
    /// scene.lights.iter_mut().for_each(|light| light.intensity /= 64.0);
    /// scene.ambient = Some(Vec3::ZERO);
    /// let mut renderer = Renderer::new(Gpu::new().wait()?);
    /// let uploaded = renderer.upload(&scene).wait()?;
    /// let stops = renderer.suggest_exposure(&uploaded, &camera, &Options::default()).wait()?;
    /// assert!(stops > 3.0);
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`FrameBuilder::read`](crate::FrameBuilder::read).
    pub async fn suggest_exposure(
        &mut self,
        scene: &UploadedScene,
        camera: &StereoCamera,
        options: &Options,
    ) -> Result<f32, Error> {
        let mut options = options.clone().method(Method::Naive).samples(1).adaptive(None).denoise(false).count(false);
        options = options.channels(&[Channel::Linear]).shadow_buffer(None);
        if let Lighting::Paths { bounces, samples } = options.lighting {
            options.lighting = Lighting::Paths { bounces, samples: samples.min(PATHS) };
        }
        let pair = self.pair(scene, &camera.resized(WIDTH)?).options(&options).read().await?;
        let pixels = [&pair.left, &pair.right].into_iter().flat_map(|view| &view.linear);
        let brightness = pixels.map(|color| BRIGHTNESS.dot(glam::Vec3::from_slice(color).as_dvec3()));
        Ok(stops_for(brightness.collect()))
    }
}

/// Returns the exposure for pixels of this brightness.
fn stops_for(mut brightness: Vec<f64>) -> f32 {
    brightness.retain(|value| value.is_finite());
    let count = brightness.len() as f64;
    let mean = brightness.iter().sum::<f64>() / count;
    if brightness.is_empty() || mean <= 0.0 {
        return 0.0;
    }
    let logarithms = brightness.iter().map(|value| value.max(LEAST * mean).log2());
    let middle = logarithms.sum::<f64>() / count;
    brightness.sort_by(f64::total_cmp);
    let bright = brightness[((1.0 - BURNT) * (count - 1.0)) as usize].max(LEAST * mean).log2();
    let least = MIDDLE[0].log2() - middle;
    let most = (MIDDLE[1].log2() - middle).min(-bright);
    let stops = if least <= most { 0.0_f64.clamp(least, most) } else { 0.5 * (least + most) };
    ((stops / STEP).round() * STEP).clamp(-64.0, 64.0) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_in_range_stay_as_they_are() {
        for brightness in [vec![0.2; 100], vec![0.5; 100], vec![0.13; 7]] {
            assert_eq!(stops_for(brightness), 0.0);
        }
        assert_eq!(stops_for(vec![0.0; 9]), 0.0);
        assert_eq!(stops_for(vec![f64::NAN, f64::INFINITY]), 0.0);
        assert_eq!(stops_for(Vec::new()), 0.0);
    }

    #[test]
    fn dark_pictures_become_brighter_and_bright_ones_darker() {
        // log2(0.12 / 0.015) = 3, and log2(0.5 / 8) = -4.
        assert_eq!(stops_for(vec![0.015; 50]), 3.0);
        assert_eq!(stops_for(vec![8.0; 50]), -4.0);
        // A fifth of the picture is bright, which limits the exposure: 2^-1 * 2 is white.
        let mut window = vec![0.3; 80];
        window.extend([2.0; 20]);
        assert_eq!(stops_for(window), -1.0);
        // A small window may burn.
        let mut window = vec![0.03; 95];
        window.extend([2.0; 5]);
        assert!((1.0..2.0).contains(&stops_for(window)));
        // The dark part needs 2.75 stops more, the bright part 4 less.
        let mut both = vec![0.01; 60];
        both.extend([16.0; 40]);
        let middle = (0.6 * 0.01_f64.log2() + 0.4 * 16.0_f64.log2()).exp2();
        assert!(middle < 0.5 && stops_for(both) < 0.0);
    }

    #[test]
    fn the_suggestion_scales_with_light() {
        for factor in [1.0 / 64.0, 1.0, 64.0] {
            let picture = |place: usize| factor * (0.001 + (place as f64 * 0.37).sin().abs());
            let stops = f64::from(stops_for((0..500).map(picture).collect()));
            let exposed: Vec<f64> = (0..500).map(|place| picture(place) * stops.exp2()).collect();
            let burnt = exposed.iter().filter(|value| **value > 1.0).count();
            assert!(burnt <= 50 + 10, "{burnt} {stops}");
        }
    }
}
