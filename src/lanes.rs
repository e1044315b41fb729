//! Work in steps: kernels whose threads do a bounded part of their work in each dispatch, for rays and lights that take
//! more rounds of a thread's loops than an adapter grants it (`shaders/shared/in_steps.wgsl`).

use crate::{
    Error,
    gpu::{Gpu, check_bytes},
    variant::Variant,
};

/// How work in steps is done.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Steps {
    /// Rounds of a thread's loops in a dispatch, about.
    pub(crate) rounds: u32,
    /// Threads of a dispatch, about.
    pub(crate) threads: u32,
    /// All work is done in steps, for tests; else only what an adapter cuts short.
    pub(crate) always: bool,
}

impl Default for Steps {
    /// llvmpipe counts the rounds of a vector of threads, which are at most those of its 8 or 16 threads together: as
    /// many times these and what follows them until a traversal can stop stay below its 65,535. All together are
    /// some ten million, a second on two cores.
    fn default() -> Self {
        Self { rounds: 1024, threads: 1 << 14, always: false }
    }
}

/// Dispatches between two looks at how many threads are unfinished.
pub(crate) const DISPATCHES: u32 = 4;

/// Words of `Lanes` before its lanes.
const HEAD_WORDS: u64 = 4;

/// Bytes of a `Lane`.
pub(crate) fn lane_bytes(with: &Variant) -> u64 {
    let rays = u64::from(with.traversal.rays.block().pow(2));
    // Twelve numbers of each ray, three of the lane, and its stack.
    4 * (12 * rays + 3 + u64::from(with.stack_size)).next_multiple_of(rays)
}

/// What the threads of a launch keep from step to step.
#[derive(Debug)]
pub(crate) struct Lanes {
    pub(crate) buffer: wgpu::Buffer,
}

impl Lanes {
    /// For launches of up to so many threads.
    ///
    /// # Errors
    /// [`Error::Limit`] if they don't fit one binding.
    pub(crate) async fn new(gpu: &Gpu, with: &Variant, threads: u32) -> Result<Self, Error> {
        let bytes = 4 * HEAD_WORDS + lane_bytes(with) * u64::from(threads);
        check_bytes("tracing in steps", bytes, gpu.binding_limit(), "render a smaller picture")?;
        gpu.checked(|| Ok(Self { buffer: gpu.storage_buffer("lanes", bytes) })).await
    }

    /// Before the first step of a launch in which so many threads have work.
    pub(crate) async fn begin(&self, gpu: &Gpu, threads: u32, rounds: u32) -> Result<(), Error> {
        let clear = || {
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.clear_buffer(&self.buffer, 0, None);
            gpu.queue.submit([encoder.finish()]);
            gpu.queue.write_buffer(&self.buffer, 0, bytemuck::cast_slice(&[threads, rounds]));
            Ok(())
        };
        gpu.checked(clear).await
    }

    /// How many of them have work left.
    pub(crate) async fn unfinished(&self, gpu: &Gpu) -> Result<u32, Error> {
        Ok(gpu.read(&self.buffer, 1).await?[0])
    }
}
