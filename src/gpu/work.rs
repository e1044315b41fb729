//! Counts of what a device was given.

use std::{
    ops::Sub,
    sync::atomic::{AtomicU64, Ordering::Relaxed},
};

/// Work that a device was given ([`Gpu::work`](crate::Gpu::work)). The work of a frame is the difference of the counts
/// after it and before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct GpuWork {
    /// Number of submissions to the queue.
    pub submissions: u64,
    /// Number of times that the host waited for a submission.
    pub waits: u64,
    /// Number of dispatches with a number of workgroups from the host. Dispatches of frames that are encoded count when
    /// they are encoded.
    pub dispatches: u64,
    /// Number of dispatches with a number of workgroups from the device.
    pub indirect_dispatches: u64,
    /// Number of times that timestamps were copied to a buffer.
    pub timestamp_reads: u64,
    /// Number of bytes in buffers that the host mapped to read them.
    pub bytes_read: u64,
}

impl Sub for GpuWork {
    type Output = Self;

    fn sub(self, before: Self) -> Self {
        Self {
            submissions: self.submissions - before.submissions,
            waits: self.waits - before.waits,
            dispatches: self.dispatches - before.dispatches,
            indirect_dispatches: self.indirect_dispatches - before.indirect_dispatches,
            timestamp_reads: self.timestamp_reads - before.timestamp_reads,
            bytes_read: self.bytes_read - before.bytes_read,
        }
    }
}

/// The counts behind [`GpuWork`], which all clones of a `Gpu` share.
#[derive(Debug, Default)]
pub(crate) struct Counted {
    pub(crate) submissions: Count,
    pub(crate) waits: Count,
    pub(crate) dispatches: Count,
    pub(crate) indirect_dispatches: Count,
    pub(crate) timestamp_reads: Count,
    pub(crate) bytes_read: Count,
}

#[derive(Debug, Default)]
pub(crate) struct Count(AtomicU64);

impl Count {
    pub(crate) fn add(&self, count: u64) {
        self.0.fetch_add(count, Relaxed);
    }

    fn get(&self) -> u64 {
        self.0.load(Relaxed)
    }
}

impl Counted {
    pub(super) fn so_far(&self) -> GpuWork {
        GpuWork {
            submissions: self.submissions.get(),
            waits: self.waits.get(),
            dispatches: self.dispatches.get(),
            indirect_dispatches: self.indirect_dispatches.get(),
            timestamp_reads: self.timestamp_reads.get(),
            bytes_read: self.bytes_read.get(),
        }
    }
}
