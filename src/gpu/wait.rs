//! Waiting for the device. No other module waits for it.

pub(crate) use self::target::Submission;
use super::Gpu;
use crate::Error;

impl Gpu {
    /// Waits until a submission and all earlier ones are complete.
    ///
    /// # Errors
    /// [`Error::DeviceLost`].
    pub(crate) async fn finished(&self, submission: Submission) -> Result<(), Error> {
        self.counted.waits.add(1);
        let waited = self.wait(submission).await;
        match self.loss() {
            Some(reason) => Err(Error::DeviceLost(reason)),
            None => waited.map_err(Error::DeviceLost),
        }
    }
}

#[cfg(not(target_arch = "wasm32"))]
mod target {
    use std::{future::poll_fn, task::Poll, time::Duration};

    use super::Gpu;
    use crate::gpu::lock;

    /// Maximum time for which one poll of a future blocks its thread.
    const SLICE: Duration = Duration::from_millis(5);

    /// Commands that were submitted to the device.
    pub(crate) struct Submission(wgpu::SubmissionIndex);

    impl Gpu {
        /// Submits commands to the device.
        pub(crate) fn submit(&self, commands: impl IntoIterator<Item = wgpu::CommandBuffer>) -> Submission {
            self.counted.submissions.add(1);
            Submission(self.queue.submit(commands))
        }

        /// Waits by polling the device, since no other code polls it. Other futures of the thread run between slices.
        pub(super) async fn wait(&self, submission: Submission) -> Result<(), String> {
            loop {
                let index = Some(submission.0.clone());
                let waiting = wgpu::PollType::Wait { submission_index: index, timeout: Some(SLICE) };
                let polled = {
                    // wgpu 30 panics if the queue becomes empty by another thread's poll after a wait has timed out.
                    // Polls by the caller, or by another `Gpu` of the same device, remain possible.
                    let _alone = lock(&self.polling);
                    self.device.poll(waiting)
                };
                match polled {
                    Ok(_) => return Ok(()),
                    Err(wgpu::PollError::Timeout) => let_others_run().await,
                    Err(error) => return Err(error.to_string()),
                }
            }
        }
    }

    /// Returns `Pending` once, so that other futures of the thread run.
    async fn let_others_run() {
        let mut is_ready = false;
        poll_fn(|context| {
            if std::mem::replace(&mut is_ready, true) {
                return Poll::Ready(());
            }
            context.waker().wake_by_ref();
            Poll::Pending
        })
        .await;
    }
}

#[cfg(target_arch = "wasm32")]
mod target {
    use futures_channel::oneshot::{Receiver, channel};

    use super::Gpu;

    /// Commands that were submitted to the device.
    pub(crate) struct Submission(Receiver<()>);

    impl Gpu {
        /// Submits commands to the device.
        pub(crate) fn submit(&self, commands: impl IntoIterator<Item = wgpu::CommandBuffer>) -> Submission {
            self.counted.submissions.add(1);
            self.queue.submit(commands);
            let (sender, done) = channel();
            self.queue.on_submitted_work_done(move || {
                let _ = sender.send(());
            });
            Submission(done)
        }

        /// Waits without polling. The browser drives the device while this code is not running.
        pub(super) async fn wait(&self, submission: Submission) -> Result<(), String> {
            submission.0.await.map_err(|error| error.to_string())
        }
    }
}
