//! An end between two pictures: where the user asks for it, or the system.

use std::{
    error::Error,
    fmt,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

use signal_hook::{
    consts::{SIGINT, SIGTERM},
    flag,
};

/// Exit status of a program that SIGINT ends.
pub(crate) const INTERRUPTED: u8 = 130;

/// Whether SIGINT or SIGTERM has come.
pub(crate) struct Stop(Arc<AtomicBool>);

impl Stop {
    /// From now on the first of these signals is only remembered. The second one ends the program at once.
    pub(crate) fn on_signals() -> Result<Self, Box<dyn Error>> {
        let asked = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // In this order, so that the first signal finds the flag down.
            flag::register_conditional_shutdown(signal, INTERRUPTED.into(), asked.clone())?;
            flag::register(signal, asked.clone())?;
        }
        Ok(Self(asked))
    }

    pub(crate) fn is_asked_for(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// The work was ended before it was done.
#[derive(Debug)]
pub(crate) struct Interrupted {
    pub(crate) done: usize,
    pub(crate) of: usize,
    /// Whether the same command goes on with the rest.
    pub(crate) can_go_on: bool,
}

impl fmt::Display for Interrupted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let advice = if self.can_go_on { "; the same command makes the rest" } else { "" };
        write!(f, "interrupted after {} of {} pairs{advice}", self.done, self.of)
    }
}

impl Error for Interrupted {}
