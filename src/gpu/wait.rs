//! Waiting for the device. Nothing else waits for it.

use std::{
    future::Future,
    pin::Pin,
    sync::{Arc, Mutex},
    task::{Context, Poll, Waker},
};

pub(crate) use self::target::Submission;
use super::{Gpu, lock};
use crate::Error;

impl Gpu {
    /// Waits until a submission, and all before it, are done.
    ///
    /// # Errors
    /// [`Error::DeviceLost`].
    pub(crate) async fn finished(&self, submission: Submission) -> Result<(), Error> {
        let waited = self.wait(submission).await;
        match self.loss() {
            Some(reason) => Err(Error::DeviceLost(reason)),
            None => waited.map_err(Error::DeviceLost),
        }
    }
}

#[cfg(not(target_arch = "wasm32"))]
mod target {
    use super::Gpu;

    /// Commands that were submitted to the device.
    pub(crate) struct Submission(wgpu::SubmissionIndex);

    impl Gpu {
        /// Submits commands to the device.
        pub(crate) fn submit(&self, commands: impl IntoIterator<Item = wgpu::CommandBuffer>) -> Submission {
            Submission(self.queue.submit(commands))
        }

        /// Waits by polling the device, which nothing else does here. Blocks the thread.
        pub(super) async fn wait(&self, submission: Submission) -> Result<(), String> {
            let wait = wgpu::PollType::Wait { submission_index: Some(submission.0), timeout: None };
            self.device.poll(wait).map(drop).map_err(|error| error.to_string())
        }
    }
}

#[cfg(target_arch = "wasm32")]
mod target {
    use super::{Gpu, Receiver, oneshot};

    /// Commands that were submitted to the device.
    pub(crate) struct Submission(Receiver<()>);

    impl Gpu {
        /// Submits commands to the device.
        pub(crate) fn submit(&self, commands: impl IntoIterator<Item = wgpu::CommandBuffer>) -> Submission {
            self.queue.submit(commands);
            let (sender, done) = oneshot();
            self.queue.on_submitted_work_done(move || sender.send(()));
            Submission(done)
        }

        /// Waits without polling: the browser drives the device when this code is not running.
        pub(super) async fn wait(&self, submission: Submission) -> Result<(), String> {
            submission.0.await;
            Ok(())
        }
    }
}

/// One value passed from a callback to a future.
#[derive(Debug)]
struct Slot<T> {
    value: Option<T>,
    waker: Option<Waker>,
}

pub(super) struct Sender<T>(Arc<Mutex<Slot<T>>>);

impl<T> Sender<T> {
    pub(super) fn send(self, value: T) {
        let mut slot = lock(&self.0);
        slot.value = Some(value);
        if let Some(waker) = slot.waker.take() {
            waker.wake();
        }
    }
}

pub(super) struct Receiver<T>(Arc<Mutex<Slot<T>>>);

impl<T> Future for Receiver<T> {
    type Output = T;

    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<T> {
        let mut slot = lock(&self.0);
        match slot.value.take() {
            Some(value) => Poll::Ready(value),
            None => {
                slot.waker = Some(context.waker().clone());
                Poll::Pending
            }
        }
    }
}

pub(super) fn oneshot<T>() -> (Sender<T>, Receiver<T>) {
    let slot = Arc::new(Mutex::new(Slot { value: None, waker: None }));
    (Sender(slot.clone()), Receiver(slot))
}
