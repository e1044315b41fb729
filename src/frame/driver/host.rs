//! Work on the host between steps.

use web_time::Instant;

use super::{Driver, sweep::Sweep};
use crate::{
    BufferDepth, Error,
    frame::plan::{Host, Step},
    kernel::{Resource, layout},
};

impl Driver<'_> {
    pub(super) async fn run_on_host(&mut self, host: &Host) -> Result<(), Error> {
        match host {
            Host::Sweep(view) => self.sweep(*view).await,
            Host::Slots(depth, view, steps) => self.reproject_by_slots(*depth, *view, steps).await,
        }
    }

    /// Runs pass 2 of `AdelsonHodges`, row by row.
    async fn sweep(&mut self, view: usize) -> Result<(), Error> {
        let (gpu, targets, band) = (self.gpu, self.targets, self.uniforms.band(view));
        let submission = gpu.checked(|| Ok(gpu.submit([]))).await?;
        gpu.finished(submission).await?;
        let begin = Instant::now();
        let width = band.size[0] as usize;
        let rows = band.row_begin as usize * width..band.row_end as usize * width;
        let source = targets.get(Resource::View, self.eyes.sources[view]);
        let source: Vec<layout::Pixel> = gpu.read(source, rows.end).await?;
        let depths: Vec<f32> = source[rows.clone()].iter().map(|pixel| pixel.depth).collect();
        let keys = Sweep::of(self.eyes, view, &band).keys(&depths);
        let marked: Vec<_> = keys.into_iter().map(|marks| layout::Pixel { marks, ..Default::default() }).collect();
        let offset = (rows.start * size_of::<layout::Pixel>()) as u64;
        gpu.queue.write_buffer(targets.get(Resource::View, view), offset, bytemuck::cast_slice(&marked));
        self.host += begin.elapsed();
        Ok(())
    }

    /// Reprojects with the 3D buffer. Each submission covers as many rows as fit one binding.
    async fn reproject_by_slots(&mut self, depth: BufferDepth, view: usize, steps: &[Step]) -> Result<(), Error> {
        let range = match depth {
            BufferDepth::Adaptive => self.depth_range(view).await?,
            _ => (f32::INFINITY, f32::INFINITY),
        };
        let depth = depth.slots(&self.eyes.pair_of(view), range);
        let gpu = self.gpu;
        let rows = self.rows_of(view);
        let band = layout::Band { buffer_depth: depth, ..self.uniforms.band(view) };
        let (rows, slots) = self.slots.size(gpu, band.size[0], rows, depth).await?;
        self.resources[view].set(Resource::Slots, slots);
        for begin in (band.row_begin..band.row_end).step_by(rows as usize) {
            let run = || {
                let row_end = band.row_end.min(begin + rows);
                *self.uniforms.band_mut(view) = layout::Band { row_begin: begin, row_end, ..band };
                self.upload_uniforms();
                let mut encoder = self.encoder();
                self.encode_all(&mut encoder, steps);
                gpu.submit([encoder.finish()]);
                Ok(())
            };
            gpu.checked(run).await?;
        }
        *self.uniforms.band_mut(view) = band;
        self.upload_uniforms();
        Ok(())
    }

    /// Returns the nearest and farthest depth of a view's source in the current rows. The farthest depth is infinite if
    /// any pixel shows the sky.
    async fn depth_range(&mut self, view: usize) -> Result<(f32, f32), Error> {
        let band = self.uniforms.band(view);
        let words = band.row_end as usize * layout::COUNTERS;
        let counters = self.targets.get(Resource::Counters, self.eyes.sources[view]);
        let words: Vec<u32> = self.gpu.read(counters, words).await?;
        let rows = words.chunks_exact(layout::COUNTERS).skip(band.row_begin as usize);
        Ok(rows.fold((f32::INFINITY, 0.0), |(nearest, farthest), row| {
            let far = match f32::from_bits(row[layout::FARTHEST_DEPTH]) {
                far if far >= crate::FAR => f32::INFINITY,
                far => far,
            };
            (nearest.min(f32::from_bits(row[layout::NEAREST_DEPTH])), farthest.max(far))
        }))
    }
}
