//! What is brought back to the host while the device goes on.

use super::{
    Gpu,
    wait::{Receiver, Submission, oneshot},
};
use crate::Error;

/// A buffer that the host reads, to be used again. Freed when it is dropped.
#[derive(Debug)]
pub(crate) struct Staging(wgpu::Buffer);

/// One that is being filled by a submission.
pub(crate) struct Filling {
    staging: Staging,
    submission: Submission,
    mapped: Receiver<Result<(), wgpu::BufferAsyncError>>,
}

impl Staging {
    pub(crate) fn new(gpu: &Gpu, bytes: u64) -> Self {
        Self(gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read-back"),
            size: bytes,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        }))
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.0.size()
    }

    /// To copy to.
    pub(crate) fn buffer(&self) -> &wgpu::Buffer {
        &self.0
    }

    /// Submits the commands that fill it.
    pub(crate) fn fill(self, gpu: &Gpu, commands: wgpu::CommandBuffer) -> Filling {
        let submission = gpu.submit([commands]);
        let (sender, mapped) = oneshot();
        self.0.map_async(wgpu::MapMode::Read, .., move |result| sender.send(result));
        Filling { staging: self, submission, mapped }
    }
}

impl Filling {
    /// What `read` makes of the bytes, once they are there, and the buffer, to be filled again.
    ///
    /// # Errors
    /// [`Error::DeviceLost`].
    pub(crate) async fn read<T>(self, gpu: &Gpu, read: impl FnOnce(&[u8]) -> T) -> Result<(T, Staging), Error> {
        gpu.finished(self.submission).await?;
        let lost = |error: &dyn std::fmt::Display| Error::DeviceLost(gpu.loss().unwrap_or(error.to_string()));
        self.mapped.await.map_err(|error| lost(&error))?;
        let range = self.staging.0.get_mapped_range(..).map_err(|error| lost(&error))?;
        let value = read(&range);
        drop(range);
        self.staging.0.unmap();
        Ok((value, self.staging))
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        self.0.destroy();
    }
}
