//! Work in steps: threads of a kernel do a limited part of their work in each dispatch. This serves rays and lights
//! that need more loop rounds than an adapter grants a thread (`shaders/shared/in_steps.wgsl`).

use crate::{
    Error,
    gpu::{Gpu, check_bytes},
    kernel::variant::Variant,
};

/// Parameters of work in steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Steps {
    /// Approximate number of loop rounds of a thread per dispatch.
    pub(crate) rounds: u32,
    /// Approximate number of threads of a dispatch.
    pub(crate) threads: u32,
    /// Whether all work is done in steps, for tests. Otherwise steps repeat only work that an adapter cut short.
    pub(crate) always: bool,
}

impl Default for Steps {
    /// Returns parameters for llvmpipe, which limits the rounds of a vector of 8 or 16 threads to 65,535. A vector
    /// takes at most the sum of its threads' rounds. The sum of these rounds and of the rounds until each traversal can
    /// pause stays below the limit. A dispatch takes about ten million rounds, which take a second on two cores.
    fn default() -> Self {
        Self { rounds: 1024, threads: 1 << 14, always: false }
    }
}

/// Number of dispatches between two checks of the number of unfinished threads.
pub(crate) const DISPATCHES: u32 = 4;

/// Offset of the lanes in `Lanes`, in words.
const HEAD_WORDS: u64 = 4;

/// Returns the size of a `Lane`, in bytes.
pub(crate) fn lane_bytes(with: &Variant) -> u64 {
    let rays = u64::from(with.traversal.rays.block().pow(2));
    // A lane has twelve numbers per ray, three more numbers, and its stack.
    4 * (12 * rays + 3 + u64::from(with.stack_size)).next_multiple_of(rays)
}

/// State that the threads of a launch keep between dispatches.
#[derive(Debug)]
pub(crate) struct Lanes {
    pub(crate) buffer: wgpu::Buffer,
}

impl Lanes {
    /// Allocates the state for launches of up to this many threads.
    ///
    /// # Errors
    /// [`Error::Limit`] if they do not fit one binding.
    pub(crate) async fn new(gpu: &Gpu, with: &Variant, threads: u32) -> Result<Self, Error> {
        let bytes = 4 * HEAD_WORDS + lane_bytes(with) * u64::from(threads);
        check_bytes("tracing in steps", bytes, gpu.binding_limit(), "render a smaller picture")?;
        gpu.checked(|| Ok(Self { buffer: gpu.storage_buffer("lanes", bytes) })).await
    }

    /// Prepares the first dispatch of a launch in which `threads` threads have work.
    pub(crate) async fn begin(&self, gpu: &Gpu, threads: u32, rounds: u32) -> Result<(), Error> {
        let clear = || {
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.clear_buffer(&self.buffer, 0, None);
            gpu.submit([encoder.finish()]);
            gpu.queue.write_buffer(&self.buffer, 0, bytemuck::cast_slice(&[threads, rounds]));
            Ok(())
        };
        gpu.checked(clear).await
    }

    /// Returns the number of threads that have work left.
    pub(crate) async fn unfinished(&self, gpu: &Gpu) -> Result<u32, Error> {
        Ok(gpu.read(&self.buffer, 1).await?[0])
    }
}
