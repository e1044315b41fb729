//! Uniforms of a frame, for each view.

use super::{bands::Band, executor::Held};
use crate::kernel::layout;

/// Distance between two uniforms in bytes: WebGPU's default alignment of uniform offsets.
const STRIDE: u64 = 256;

/// Returns the size of the uniforms of all views, in bytes.
pub(crate) fn uniforms_bytes(views: usize, parts: u32) -> u64 {
    views as u64 * u64::from(parts) * STRIDE
}

/// The rays that a dispatch traces, for steps with several dispatches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Rays to a soft light.
    Soft {
        /// Index among all lights. Ambient light, or the sky light that replaces it, follows the last light.
        light: u32,
        /// Index among the sources that are not point lights.
        slot: u32,
        /// Index of the first ray.
        first: u32,
    },
    /// The rays of this number along all paths. Rays from eyes have the number 0.
    Paths { ray: u32 },
    /// A round of secondary rays. Round 0 shades first hits.
    Bounced { round: u32 },
}

/// The uniforms of all views.
#[derive(Debug)]
pub(crate) struct Uniforms {
    views: Vec<layout::Frame>,
    /// Parts of soft light, then of paths or of secondary rays. Each part has its own uniform.
    parts: Vec<Part>,
}

impl Uniforms {
    /// Creates the uniforms of all views. [`Uniforms::set_rows`] sets their rows for each band.
    pub(crate) fn new(views: Vec<layout::Frame>, parts: Vec<Part>) -> Self {
        Self { views, parts }
    }

    /// Returns the band of a view's uniform, with the rows of the current dispatch.
    pub(crate) fn band(&self, view: usize) -> layout::Band {
        self.views[view].band
    }

    /// Returns the band of a view's uniform for modification.
    pub(crate) fn band_mut(&mut self, view: usize) -> &mut layout::Band {
        &mut self.views[view].band
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

    /// Returns all uniforms, in the layout of the uniform buffer.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mut bytes = vec![0; uniforms_bytes(self.views.len(), self.each() as u32) as usize];
        for (index, place) in bytes.chunks_exact_mut(STRIDE as usize).enumerate() {
            let mut frame = self.views[index / self.each()];
            match self.parts.get(index % self.each()) {
                Some(&Part::Soft { light, slot, first }) => {
                    frame.lighting = layout::Lighting { light, slot, first_ray: first, ..frame.lighting };
                }
                Some(&(Part::Paths { ray } | Part::Bounced { round: ray })) => frame.paths.ray = ray,
                None => {}
            }
            place[..size_of::<layout::Frame>()].copy_from_slice(bytemuck::bytes_of(&frame));
        }
        bytes
    }

    /// Returns the number of uniforms per view.
    fn each(&self) -> usize {
        self.parts.len().max(1)
    }

    /// Returns the uniform of a view and a part of soft light, as a part of `buffer`.
    pub(crate) fn held(&self, view: usize, part: usize, buffer: &wgpu::Buffer) -> Held {
        let offset = (view * self.each() + part) as u64 * STRIDE;
        Held::Uniform { buffer: buffer.clone(), offset, bytes: size_of::<layout::Frame>() as u64 }
    }
}
