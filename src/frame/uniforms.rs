//! A frame's uniforms, for each view.

use super::{bands::Band, executor::Held};
use crate::{
    Options, Tone, kernel::layout, methods::auto::CostModel, sampling::Jitter, steps::soft::Part, view::rig::Eyes,
};

/// Bytes from one uniform to the next: WebGPU's default alignment of uniform offsets.
pub(crate) const STRIDE: u64 = 256;

/// Returns the bytes of the uniforms of all views.
pub(crate) fn uniforms_bytes(views: usize, parts: u32) -> u64 {
    views as u64 * u64::from(parts) * STRIDE
}

/// The uniforms of all views.
#[derive(Debug)]
pub(crate) struct Uniforms {
    views: Vec<layout::Frame>,
    /// Parts of soft light, one per dispatch. Each has a uniform.
    parts: Vec<Part>,
}

impl Uniforms {
    /// Makes the uniforms of a frame's views.
    pub(crate) fn new(
        eyes: &Eyes,
        options: &Options,
        model: &CostModel,
        (parts, sources): (Vec<Part>, u32),
        (words_read, runs): (u32, u32),
    ) -> Self {
        let jitter = Jitter::of(options);
        let view = |view| layout::Frame {
            eyes: jitter.beside(eyes.uniform(view)),
            band: layout::Band {
                size: eyes.pose.size,
                row_end: eyes.pose.size[1],
                runs,
                jitter_seed: jitter.seed(),
                ..Default::default()
            },
            lighting: layout::Lighting {
                bounces: options.bounces,
                sources,
                seed: options.seed.wrapping_add(if options.noise_by_view { view as u32 } else { 0 }),
                occlusion_radius: options.surroundings().map_or(0.0, |occlusion| occlusion.radius),
                share_tolerance: options.penumbra.tolerance(),
                ..Default::default()
            },
            display: layout::Display {
                exposure: options.exposure.exp2(),
                filmic: u32::from(options.tone == Tone::Filmic),
                words_read,
                _pad: 0,
            },
            costs: layout::Costs {
                least_spared: model.least_spared(),
                listed: model.listed,
                disagreed: model.disagreed,
                _pad: 0,
            },
        };
        Self { views: (0..eyes.sources.len()).map(view).collect(), parts }
    }

    /// Returns the rows at work of a view.
    pub(crate) fn band(&self, view: usize) -> layout::Band {
        self.views[view].band
    }

    /// Returns the same, to change.
    pub(crate) fn band_mut(&mut self, view: usize) -> &mut layout::Band {
        &mut self.views[view].band
    }

    /// Returns the number of parts of soft light.
    pub(crate) fn parts(&self) -> usize {
        self.parts.len()
    }

    /// Sets the rows of a band for each view. For sources these include the rows above and below that steps read.
    pub(crate) fn set_rows(&mut self, sources: &[usize], band: &Band) {
        for (frame, (view, source)) in self.views.iter_mut().zip(sources.iter().enumerate()) {
            let rows = if *source == view { &band.seen } else { &band.rows };
            frame.band.first_row = band.first;
            frame.band.size[1] = band.seen.end - band.first;
            (frame.band.row_begin, frame.band.row_end) = (rows.start - band.first, rows.end - band.first);
        }
    }

    /// Returns all uniforms, as laid out in the buffer.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mut bytes = vec![0; uniforms_bytes(self.views.len(), self.each() as u32) as usize];
        for (index, place) in bytes.chunks_exact_mut(STRIDE as usize).enumerate() {
            let mut frame = self.views[index / self.each()];
            if let Some(Part { light, slot, first }) = self.parts.get(index % self.each()) {
                frame.lighting = layout::Lighting { light: *light, slot: *slot, first_ray: *first, ..frame.lighting };
            }
            place[..size_of::<layout::Frame>()].copy_from_slice(bytemuck::bytes_of(&frame));
        }
        bytes
    }

    /// Returns the number of a view's uniforms.
    fn each(&self) -> usize {
        self.parts.len().max(1)
    }

    /// Returns the uniform of a view and a part of soft light, in this buffer.
    pub(crate) fn held(&self, view: usize, part: usize, buffer: &wgpu::Buffer) -> Held {
        let offset = (view * self.each() + part) as u64 * STRIDE;
        Held::Uniform { buffer: buffer.clone(), offset, bytes: size_of::<layout::Frame>() as u64 }
    }
}
