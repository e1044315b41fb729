//! Stops the program cleanly between two pictures on SIGINT or SIGTERM.

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

/// A flag that SIGINT and SIGTERM set.
pub(crate) struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Installs the handlers. The first signal sets the flag, the second ends the program at once.
    pub(crate) fn on_signals() -> Result<Self, Box<dyn Error>> {
        let asked = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // The order matters: the first signal must find the flag unset.
            flag::register_conditional_shutdown(signal, INTERRUPTED.into(), asked.clone())?;
            flag::register(signal, asked.clone())?;
        }
        Ok(Self(asked))
    }

    pub(crate) fn is_asked_for(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Error of a run that a signal ended early.
#[derive(Debug)]
pub(crate) enum Interrupted {
    /// Nothing that was made is of use to another run.
    AtAll,
    /// The same command can make the remaining ones of so many pairs or pictures, as `many` calls them.
    After { done: usize, of: usize, many: &'static str },
    /// All pictures are there, and the same command can make the film of them.
    InFilm,
}

impl fmt::Display for Interrupted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AtAll => f.write_str("interrupted"),
            Self::After { done, of, many } => {
                let advice = "run the same command again to make the rest";
                write!(f, "interrupted after {done} of {of} {many}; {advice}")
            }
            Self::InFilm => f.write_str("interrupted while FFmpeg made the film; run the same command again"),
        }
    }
}

impl Error for Interrupted {}
