//! Read-back while the device continues to work.

use futures_channel::oneshot::{Receiver, channel};

use super::{Gpu, wait::Submission};
use crate::Error;

/// A reusable buffer that the host reads. It is freed when dropped.
#[derive(Debug)]
pub(crate) struct Staging(wgpu::Buffer);

/// A staging buffer that a submission is filling.
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

    /// Returns the buffer to copy to.
    pub(crate) fn buffer(&self) -> &wgpu::Buffer {
        &self.0
    }

    /// Submits the commands that fill the buffer.
    pub(crate) fn fill(self, gpu: &Gpu, commands: wgpu::CommandBuffer) -> Filling {
        let submission = gpu.submit([commands]);
        let (sender, mapped) = channel();
        self.0.map_async(wgpu::MapMode::Read, .., move |result| drop(sender.send(result)));
        Filling { staging: self, submission, mapped }
    }
}

impl Filling {
    /// Waits for the bytes, and returns the result of `read` together with the buffer, for reuse.
    ///
    /// # Errors
    /// [`Error::DeviceLost`].
    pub(crate) async fn read<T>(self, gpu: &Gpu, read: impl FnOnce(&[u8]) -> T) -> Result<(T, Staging), Error> {
        gpu.finished(self.submission).await?;
        let lost = |error: &dyn std::fmt::Display| Error::DeviceLost(gpu.loss().unwrap_or(error.to_string()));
        self.mapped.await.map_err(|error| lost(&error))?.map_err(|error| lost(&error))?;
        gpu.counted.bytes_read.add(self.staging.bytes());
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
