//! The one error type.

use std::path::{Path, PathBuf};

use crate::message::{escaped, tidy};

/// A browser brings its own.
const ADAPTER_REMEDY: &str = if cfg!(target_arch = "wasm32") {
    ""
} else {
    ". On Debian, `apt-get install mesa-vulkan-drivers` installs a software one"
};

/// Everything that can go wrong. Each message names the thing, the value and, where there is one, the remedy. In what it
/// quotes of files, control characters are escaped and words over 80 characters cut; the fields hold all of it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No graphics driver offers an adapter that fits.
    #[error("no graphics adapter found{wanted}: {reason}{ADAPTER_REMEDY}")]
    NoAdapter {
        /// What was asked for, as ` for the name '…', WGPU_BACKEND=…`, or empty.
        wanted: String,
        /// What the driver loader said, or which adapters there are.
        reason: String,
    },
    /// The device went away (driver reset, unplugged, or destroyed by the program).
    #[error("the graphics device was lost: {0}; create a new Gpu and try again")]
    DeviceLost(String),
    /// The device has no memory left for this picture or scene.
    #[error("the graphics device is out of memory: {0}; use a smaller picture or scene")]
    OutOfMemory(String),
    /// The driver refused something this library asked for: a defect here or there.
    #[error("the graphics driver refused a request: {0}")]
    Gpu(String),
    /// Something is larger than this adapter allows.
    #[error("{what} needs {needed} but this adapter's {limit} is {allowed}; {remedy}")]
    Limit {
        /// What is too large.
        what: String,
        /// How large it is, with its unit.
        needed: String,
        /// The name of the adapter's limit.
        limit: &'static str,
        /// The limit's value, with its unit.
        allowed: String,
        /// What to do about it.
        remedy: &'static str,
    },
    /// A camera that has no picture.
    #[error("invalid camera: {field} is {value}; {reason}")]
    Camera {
        /// The field at fault.
        field: &'static str,
        /// Its value.
        value: String,
        /// What is expected of it.
        reason: &'static str,
    },
    /// A method made of choices that don't go together.
    #[error("no such method: overlap {overlap} does not go with verification {verify}, but with {fitting}")]
    Choices {
        /// Which left samples are looked at.
        overlap: String,
        /// How reused pixels are to be checked.
        verify: String,
        /// What goes with the overlap.
        fitting: &'static str,
    },
    /// A ray that can't be traced.
    #[error("invalid ray {index}: {reason}")]
    Ray {
        /// Its place in the list.
        index: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// A scene with an element that cannot be rendered.
    #[error("invalid scene: {}: {}", tidy(element), tidy(reason))]
    Scene {
        /// The element, as `mesh 'table', vertex 12`.
        element: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A name that is none of those known.
    #[error("unknown {what} '{}'; use one of {}", tidy(name), tidy(known))]
    UnknownName {
        /// What it should name, as `method`.
        what: &'static str,
        /// The name as given.
        name: String,
        /// The names there are, separated by commas.
        known: String,
    },
    /// A file whose content is wrong.
    #[error("{}{}: {}", shown(path), line.map(|line| format!(":{line}")).unwrap_or_default(), tidy(reason))]
    File {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1, where it is known.
        line: Option<usize>,
        /// What is wrong there.
        reason: String,
    },
    /// A file that could not be read or written.
    #[error("{}: {source}", shown(path))]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The progress callback asked to stop.
    #[error("cancelled by the progress callback")]
    Cancelled,
}

/// A path as messages show it: whole, since that is how it is found.
fn shown(path: &Path) -> String {
    escaped(&path.to_string_lossy())
}

impl Error {
    pub(crate) fn file(path: impl Into<PathBuf>, line: Option<usize>, reason: impl Into<String>) -> Self {
        Self::File { path: path.into(), line, reason: reason.into() }
    }

    pub(crate) fn unknown_name<T: ToString>(what: &'static str, name: &str, all: &[T]) -> Self {
        let known = all.iter().map(T::to_string).collect::<Vec<_>>().join(", ");
        Self::UnknownName { what, name: name.to_owned(), known }
    }

    pub(crate) fn io(path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Self::Io { path: path.into(), source }
    }
}

impl Error {
    /// A driver ended a kernel's loops before their work was done.
    pub(crate) fn cut_short(count: u64, what: &str) -> Self {
        Self::Limit {
            what: format!("the tracing of {count} {what}"),
            needed: "more rounds of its loops".into(),
            limit: "bound on the loops of a thread",
            allowed: "reached (llvmpipe's is 65535)".into(),
            remedy: "use fewer lights or a simpler scene",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_quote_files_tidily_whatever_their_kind() {
        let odd = format!("\u{1b}[2J{}", "n".repeat(100));
        let errors = [
            Error::file(&odd, Some(3), &*odd),
            Error::Scene { element: odd.clone(), reason: odd.clone() },
            Error::unknown_name("method", &odd, &[&odd]),
            Error::io(&odd, std::io::Error::other("full")),
        ];
        for error in errors {
            let message = error.to_string();
            assert!(message.contains(r"\u{1b}[2J") && !message.contains('\u{1b}'), "{message}");
            let path_alone = matches!(error, Error::Io { .. });
            assert_eq!(message.contains('…'), !path_alone, "{message}");
        }
    }
}
