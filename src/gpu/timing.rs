//! Timestamps of compute passes.

use super::Gpu;
use crate::Error;

/// Timestamps of the compute passes of one frame, a pair each.
#[derive(Debug)]
pub(crate) struct Timestamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// The name of each pair's pass.
    names: Vec<&'static str>,
    /// There were more passes than pairs.
    full: bool,
}

/// WebGPU's own bound on a query set.
const MAX_QUERIES: u32 = wgpu::QUERY_SET_MAX_QUERIES;

impl Timestamps {
    /// `None` where the adapter has no timestamps.
    pub(crate) fn new(gpu: &Gpu) -> Option<Self> {
        gpu.timestamps.then(|| Self {
            queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: MAX_QUERIES,
            }),
            resolved: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: u64::from(MAX_QUERIES) * 8,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
            names: Vec::new(),
            full: false,
        })
    }

    /// Forgets the last frame's.
    pub(crate) fn restart(&mut self) {
        self.names.clear();
        self.full = false;
    }

    /// The next pair, for a pass of this name; `None` when all are used up.
    pub(crate) fn next(&mut self, name: &'static str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let first = 2 * self.names.len() as u32;
        if first + 2 > MAX_QUERIES {
            self.full = true;
            return None;
        }
        self.names.push(name);
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        })
    }

    pub(crate) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2 * self.names.len() as u32, &self.resolved, 0);
    }

    /// Sums by name, in order of first use; `None` if there were more passes than could be timed.
    pub(crate) async fn read(&self, gpu: &Gpu) -> Result<Option<crate::PassTimes>, Error> {
        if self.full {
            return Ok(None);
        }
        let ticks: Vec<u64> = gpu.read(&self.resolved, 2 * self.names.len()).await?;
        let period = f64::from(gpu.queue.get_timestamp_period());
        let mut times = crate::PassTimes::default();
        for (name, pair) in self.names.iter().zip(ticks.chunks_exact(2)) {
            let nanoseconds = pair[1].saturating_sub(pair[0]) as f64 * period;
            let time = std::time::Duration::from_nanos(nanoseconds as u64);
            match times.passes.iter_mut().find(|(known, _)| known == name) {
                Some((_, sum)) => *sum += time,
                None => times.passes.push((name, time)),
            }
        }
        Ok(Some(times))
    }
}
