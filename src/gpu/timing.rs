//! Timestamps of compute passes.

use super::{Gpu, Staging};
use std::time::Duration;

use crate::Error;

/// Time of each pass on the device, from timestamp queries.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct PassTimes {
    /// Name and time of each pass, in order.
    pub passes: Vec<(&'static str, Duration)>,
}

impl PassTimes {
    /// Returns the sum of all passes.
    pub fn total(&self) -> Duration {
        self.passes.iter().map(|(_, time)| *time).sum()
    }

    /// Adds the times of passes, by name.
    pub(crate) fn add(&mut self, others: &Self) {
        others.passes.iter().for_each(|&(name, time)| self.add_one(name, time));
    }

    fn add_one(&mut self, name: &'static str, time: Duration) {
        match self.passes.iter_mut().find(|(known, _)| *known == name) {
            Some((_, sum)) => *sum += time,
            None => self.passes.push((name, time)),
        }
    }
}

/// Timestamps of one frame's compute passes: a pair per pass.
#[derive(Debug)]
pub(crate) struct Timestamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// Name of the pass of each pair.
    names: Vec<&'static str>,
    /// Number of these passes that are not of the current band.
    before: usize,
    /// Whether there were more passes than pairs.
    full: bool,
}

/// Maximum number of queries in a query set, which is a limit of WebGPU.
const MAX_QUERIES: u32 = wgpu::QUERY_SET_MAX_QUERIES;

impl Timestamps {
    /// Returns `None` if the adapter has no timestamps.
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
            before: 0,
            full: false,
        })
    }

    /// Forgets the passes of the last frame.
    pub(crate) fn restart(&mut self) {
        self.names.clear();
        self.before = 0;
        self.full = false;
    }

    /// Returns whether one band had more passes than can be timed.
    pub(crate) fn is_full(&self) -> bool {
        self.full
    }

    /// Returns the next pair of timestamps, for a pass of this name. Returns `None` if all pairs are used.
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

    /// Maximum number of bytes that [`Timestamps::resolve`] writes.
    pub(crate) const BYTES: u64 = MAX_QUERIES as u64 * 8;

    /// Ends a band. Returns whether a next band of as many passes finds no room.
    pub(crate) fn end_band(&mut self) -> bool {
        let passes = self.names.len() - self.before;
        self.before = self.names.len();
        2 * (self.names.len() + passes) > MAX_QUERIES as usize
    }

    /// Encodes a copy of all timestamps since the last call into the buffer `to`, from `offset` on. Returns the names
    /// of their passes.
    pub(crate) fn resolve(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        to: &wgpu::Buffer,
        offset: u64,
    ) -> Vec<&'static str> {
        let names = std::mem::take(&mut self.names);
        self.before = 0;
        if !names.is_empty() {
            gpu.counted.timestamp_reads.add(1);
            encoder.resolve_query_set(&self.queries, 0..2 * names.len() as u32, &self.resolved, 0);
            encoder.copy_buffer_to_buffer(&self.resolved, 0, to, offset, Some(16 * names.len() as u64));
        }
        names
    }

    /// Waits for all passes since the last call, and sums their times by name. Returns `None` if there were too many
    /// passes.
    pub(crate) async fn read(&mut self, gpu: &Gpu) -> Result<Option<PassTimes>, Error> {
        let fill = || {
            let staging = Staging::new(gpu, Self::BYTES);
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let names = self.resolve(gpu, &mut encoder, staging.buffer(), 0);
            Ok((names, staging.fill(gpu, encoder.finish())))
        };
        let (names, filling) = gpu.checked(fill).await?;
        let mut times = PassTimes::default();
        filling.read(gpu, |ticks| add_times(&mut times, &names, ticks, gpu)).await?;
        Ok((!self.full).then_some(times))
    }
}

/// Adds the times of a band's passes by name, in order of first use.
pub(crate) fn add_times(times: &mut PassTimes, names: &[&'static str], ticks: &[u8], gpu: &Gpu) {
    let period = f64::from(gpu.queue.get_timestamp_period());
    for (name, pair) in names.iter().zip(ticks.chunks_exact(16)) {
        let [begin, end]: [u64; 2] = bytemuck::pod_read_unaligned(pair);
        times.add_one(name, Duration::from_nanos((end.saturating_sub(begin) as f64 * period) as u64));
    }
}
