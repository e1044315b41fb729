//! Removes noise from the light of paths, on whole pictures. Diffuse light before the albedo and glossy light are
//! smoothed apart, guided by the surfaces that pixels show and by the variances of their paths' light (DESIGN,
//! section 3).

use super::frame::Done;
use crate::{
    Error, OnProgress, Options, Progress, Renderer,
    frame::{
        ViewRows,
        executor::{Executor, Resources, Workgroups},
    },
    kernel::layout::{Frame, Guide, LightParts, NO_LIGHT, NO_NORMAL, Noisy, WORKGROUP},
    kernel::{Kernel, Resource, Role, kernel, variant::Variant},
};

pub(crate) const SMOOTH_VARIANCES: Kernel = kernel!("denoise", "smooth_variances", Role::Pixels);
pub(crate) const SMOOTH_LIGHT_ONCE: Kernel = kernel!("denoise", "smooth_light_once", Role::Pixels);

/// Distances between the pixels that each pass averages, in pixels.
const STEPS: [u32; 5] = [1, 2, 4, 8, 16];
/// Number of rows above and below a strip that its pixels depend on: the reach of all passes.
const REACH: usize = 3 + 2 * (STEPS[0] + STEPS[1] + STEPS[2] + STEPS[3] + STEPS[4]) as usize;
/// Number of pixels of a strip, without the rows beside it.
const STRIP: usize = 1 << 21;
/// Largest variance; sums of larger ones could overflow.
const MOST_VARIANCE: f32 = 1e30;

impl Renderer {
    /// Uses light in parts: replaces the colours of pictures by those of denoised light, and keeps the albedo. Adds the
    /// time of the passes to the frame's.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if the progress callback stops it, which is called before each strip of rows.
    pub(super) async fn use_parts(
        &mut self,
        (done, views): (&mut Done, &mut [ViewRows]),
        options: &Options,
        progress: &mut OnProgress<'_>,
    ) -> Result<(), Error> {
        if let Some(timestamps) = &mut self.timestamps {
            timestamps.restart();
        }
        for rows in views.iter_mut().filter(|rows| !rows.parts.is_empty()) {
            let parts = std::mem::take(&mut rows.parts);
            if options.albedo {
                rows.view.albedo = parts.iter().map(LightParts::whole_albedo).collect();
            }
            if !options.denoise {
                continue;
            }
            let size = [rows.view.width as usize, rows.view.height as usize];
            let smooth = self.smoothed(&parts, size, STRIP, progress).await?;
            let linear: Vec<[f32; 3]> = parts.iter().zip(&smooth).map(|(parts, light)| parts.lit_by(light)).collect();
            rows.view.rgba8 = linear.iter().map(|&color| options.tone.rgba8(color, options.exposure.exp2())).collect();
            if options.linear {
                rows.view.linear = linear.into_iter().map(|[red, green, blue]| [red, green, blue, 1.0]).collect();
            }
        }
        if let (true, Some(timestamps), Some(times)) = (options.denoise, &mut self.timestamps, &mut done.times) {
            match timestamps.read(&self.gpu).await? {
                Some(own) => times.add(&own),
                None => done.times = None, // too many passes
            }
        }
        Ok(())
    }

    /// Smooths a picture in strips of rows with about this number of pixels. A strip's result does not depend on the
    /// others.
    async fn smoothed(
        &mut self,
        parts: &[LightParts],
        [width, height]: [usize; 2],
        strip_pixels: usize,
        progress: &mut OnProgress<'_>,
    ) -> Result<Vec<Noisy>, Error> {
        let mut all = Vec::with_capacity(parts.len());
        let fitting = (self.gpu.binding_limit() / size_of::<Noisy>() as u64) as usize / width;
        if fitting <= 2 * REACH {
            return Err(Error::Limit {
                what: format!("denoising a picture {width} pixels wide"),
                needed: format!("{} MiB", ((2 * REACH + 1) * width * size_of::<Noisy>()) >> 20),
                limit: "max_storage_buffer_binding_size",
                allowed: format!("{} MiB", self.gpu.binding_limit() >> 20),
                remedy: "render a narrower picture",
            });
        }
        let strip = (strip_pixels / width).clamp(1, fitting - 2 * REACH);
        for first in (0..height).step_by(strip) {
            if progress(Progress { pass: "denoise", done: 1.0 }).is_break() {
                return Err(Error::Cancelled);
            }
            let end = (first + strip).min(height);
            let [top, bottom] = [first.saturating_sub(REACH), (end + REACH).min(height)];
            let smooth = self.smoothed_strip(&parts[top * width..bottom * width], width as u32).await?;
            all.extend_from_slice(&smooth[(first - top) * width..(end - top) * width]);
        }
        Ok(all)
    }

    async fn smoothed_strip(&mut self, parts: &[LightParts], width: u32) -> Result<Vec<Noisy>, Error> {
        let gpu = &self.gpu;
        let size = [width, parts.len() as u32 / width];
        let noisy: Vec<Noisy> = parts.iter().map(LightParts::noisy).collect();
        let guides: Vec<Guide> = parts.iter().map(LightParts::guide).collect();
        let workgroups = Workgroups::Number([size[0].div_ceil(WORKGROUP), size[1].div_ceil(WORKGROUP), 1]);
        let run = || {
            let bytes = size_of_val(&noisy[..]) as u64;
            let mut light = [gpu.storage_buffer("noisy_light", bytes), gpu.storage_buffer("smooth_light", bytes)];
            let surfaces = gpu.storage_buffer("guides", size_of_val(&guides[..]) as u64);
            gpu.queue.write_buffer(&light[0], 0, bytemuck::cast_slice(&noisy));
            gpu.queue.write_buffer(&surfaces, 0, bytemuck::cast_slice(&guides));
            let mut executor = Executor::new(gpu, &self.kernels, None, self.timestamps.as_mut());
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let passes = STEPS.iter().map(|&step| (&SMOOTH_LIGHT_ONCE, step));
            for (kernel, step) in std::iter::once((&SMOOTH_VARIANCES, 0)).chain(passes) {
                let mut frame = Frame::default();
                frame.band.size = size;
                frame.paths.ray = step;
                let frame = gpu.uniform_buffer("frame", bytemuck::bytes_of(&frame));
                let resources = Resources::default()
                    .with(Resource::Frame, &frame)
                    .with(Resource::NoisyLight, &light[0])
                    .with(Resource::SmoothLight, &light[1])
                    .with(Resource::Guides, &surfaces);
                executor.run(&mut encoder, kernel.name, (kernel, Variant::PIXELS), &resources, workgroups);
                light.swap(0, 1);
            }
            gpu.submit([encoder.finish()]);
            Ok((light, surfaces))
        };
        let (light, surfaces) = gpu.checked(run).await?;
        let smooth = gpu.read(&light[0], noisy.len()).await;
        light.iter().chain([&surfaces]).for_each(wgpu::Buffer::destroy);
        smooth
    }
}

impl LightParts {
    fn noisy(&self) -> Noisy {
        // Light that is not finite would spread.
        let usable = |light: [f32; 3], variance: f32| match light.iter().all(|value| value.is_finite()) {
            true => (light, variance.min(MOST_VARIANCE)),
            false => ([0.0; 3], NO_LIGHT),
        };
        let (diffuse, diffuse_variance) = usable(self.diffuse, self.diffuse_variance);
        let (glossy, glossy_variance) = usable(self.glossy, self.glossy_variance);
        Noisy { diffuse, diffuse_variance, glossy, glossy_variance }
    }

    fn guide(&self) -> Guide {
        let point = [self.point_x, self.point_y, self.point_z];
        Guide { point, normal: self.normal, lobe_width: self.lobe_width, _pad: [0; 3] }
    }

    /// Returns the share of light that the pixel's surfaces reflect in any way.
    fn whole_albedo(&self) -> [f32; 3] {
        std::array::from_fn(|k| (self.albedo[k] + self.reflectance[k]).min(1.0))
    }

    /// Returns the pixel's colour under this light.
    fn lit_by(&self, light: &Noisy) -> [f32; 3] {
        if self.normal == NO_NORMAL {
            return self.rest;
        }
        std::array::from_fn(|k| self.rest[k] + self.albedo[k] * light.diffuse[k] + self.coverage * light.glossy[k])
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::{Gpu, blocking::Wait, random::Random};

    fn go_on(_: Progress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// Returns a floor of two rooms with noisy light: 1 in the left room, 3 in the right one behind a wall's edge.
    fn floor(width: usize, height: usize) -> Vec<LightParts> {
        let mut random = Random::new(7);
        let pixel = |index: usize| {
            let [x, y] = [index % width, index / width].map(|place| place as f32);
            let is_left = index % width < width / 2;
            let light = (if is_left { 1.0 } else { 3.0 }) * 2.0 * random.point(1.0).x.abs();
            // Normals of the two rooms are 90 degrees apart: x and z in octahedral form.
            let normal = if is_left { 0x0000_7fff } else { 0 };
            LightParts {
                diffuse: [light; 3],
                diffuse_variance: 1.0 / 3.0 * (if is_left { 1.0 } else { 9.0 }),
                glossy_variance: NO_LIGHT,
                albedo: [1.0; 3],
                normal,
                coverage: 1.0,
                point_x: if is_left { 0.0 } else { x },
                point_y: y,
                point_z: if is_left { x } else { 0.0 },
                ..LightParts::default()
            }
        };
        (0..width * height).map(pixel).collect()
    }

    #[test]
    fn light_is_smoothed_up_to_edges_and_strips_change_nothing() {
        let (mut renderer, size) = (Renderer::new(Gpu::under_test()), [80, 200]);
        let parts = floor(size[0], size[1]);
        let whole = renderer.smoothed(&parts, size, STRIP, &mut go_on).wait().unwrap();
        let in_strips = renderer.smoothed(&parts, size, 80 * 24, &mut go_on).wait().unwrap();
        assert!(whole == in_strips);
        let light = |is_left: bool, list: &[Noisy]| {
            let own = list.iter().enumerate().filter(|(index, _)| (index % size[0] < size[0] / 2) == is_left);
            let values: Vec<f64> = own.map(|(_, noisy)| f64::from(noisy.diffuse[0])).collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64;
            (mean, variance.sqrt())
        };
        let noisy: Vec<Noisy> = parts.iter().map(LightParts::noisy).collect();
        for is_left in [true, false] {
            let [before, after] = [&noisy, &whole].map(|list| light(is_left, list));
            println!("{before:?} {after:?}");
            // Nothing comes across the edge, where the light is three times as bright or a third.
            assert!((after.0 / before.0 - 1.0).abs() < 0.03 && after.1 < 0.15 * before.1, "{before:?} {after:?}");
        }
    }

    #[test]
    fn a_pixel_without_a_surface_keeps_its_colour() {
        let mut parts = floor(20, 20);
        parts[210] = LightParts { normal: NO_NORMAL, rest: [0.5, 0.25, 0.125], ..LightParts::default() };
        let mut renderer = Renderer::new(Gpu::under_test());
        let smooth = renderer.smoothed(&parts, [20, 20], STRIP, &mut go_on).wait().unwrap();
        assert_eq!(parts[210].lit_by(&smooth[210]), [0.5, 0.25, 0.125]);
        assert!(smooth.iter().all(|noisy| noisy.diffuse.iter().all(|value| value.is_finite())));
        // Light that is not finite, or that a surface does not reflect, reaches no other pixel.
        let mut parts = floor(20, 20);
        parts[205].diffuse = [f32::INFINITY, 1.0, f32::NAN];
        parts[215].diffuse_variance = NO_LIGHT;
        parts[215].diffuse = [0.0; 3];
        let smooth = renderer.smoothed(&parts, [20, 20], STRIP, &mut go_on).wait().unwrap();
        assert!(smooth.iter().all(|noisy| noisy.diffuse.iter().all(|value| value.is_finite())));
        assert_eq!(smooth[215].diffuse, [0.0; 3]);
        assert!((195..235).filter(|index| ![205, 215].contains(index)).all(|index| smooth[index].diffuse[0] > 0.3));
    }
}
