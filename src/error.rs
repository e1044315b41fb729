//! The error type of the library.

use std::{
    fmt,
    path::{Path, PathBuf},
};

use crate::message::{counted, escaped, tidy};

/// Remedy if no adapter is found. Browsers provide their own adapters.
const ADAPTER_REMEDY: &str = if cfg!(target_arch = "wasm32") {
    ""
} else {
    ". On Debian, `apt-get install mesa-vulkan-drivers` installs a software one"
};

/// Any error of the library. A message names the object, the value and, if known, the remedy. Text quoted from files
/// has control characters escaped and words over 80 characters cut; the fields hold the full text.
///
/// A message already includes the text of its [`source`](std::error::Error::source): print the message, not the chain.
/// Programs can inspect the type of a source. (Sources of device errors are text, since they can't cross threads in a
/// browser.)
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No graphics driver offers an adapter that fits.
    #[non_exhaustive]
    #[error("no graphics adapter found{}: {}{ADAPTER_REMEDY}", tidy(wanted), tidy(reason))]
    NoAdapter {
        /// The requested adapter, as ` for the name '…', WGPU_BACKEND=…`, or empty.
        wanted: String,
        /// The driver loader's message, or the list of adapters.
        reason: String,
    },
    /// The device was lost (driver reset, unplugged, or destroyed by the program).
    #[error("the graphics device was lost: {0}; create a new Gpu and try again")]
    DeviceLost(String),
    /// The device has no memory left for this picture or scene.
    #[error("the graphics device is out of memory: {0}; use a smaller picture or scene")]
    OutOfMemory(String),
    /// The driver refused a request of this library, because of a defect in the driver or the library.
    #[error("the graphics driver refused a request: {0}")]
    Gpu(String),
    /// The scene was uploaded by another device.
    #[error("the scene was uploaded by another Gpu; upload it with this renderer")]
    ForeignScene,
    /// A resource is larger than the adapter allows.
    #[non_exhaustive]
    #[error("{what} needs {needed} but this adapter's {limit} is {allowed}; {remedy}")]
    Limit {
        /// The resource that is too large.
        what: String,
        /// Its size, with its unit.
        needed: String,
        /// Name of the adapter's limit.
        limit: &'static str,
        /// The limit's value, with its unit.
        allowed: String,
        /// How to avoid the error.
        remedy: &'static str,
    },
    /// A file, or the picture in it, exceeds one of the [`Limits`](crate::Limits) and was not read.
    #[non_exhaustive]
    #[error("{}: {size}, over the limit of {limit}; {remedy}", shown(path))]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Description of the size.
        size: String,
        /// The limit.
        limit: u64,
        /// How to raise the limit.
        remedy: String,
    },
    /// A camera that can't be rendered.
    #[non_exhaustive]
    #[error("invalid camera: {field} is {value}; {reason}")]
    Camera {
        /// The field at fault.
        field: &'static str,
        /// Its value.
        value: String,
        /// The requirement that the value violates.
        reason: &'static str,
    },
    /// An unsupported number of samples per pixel, or samples too close together for directions in f32.
    #[non_exhaustive]
    #[error("invalid samples: {samples} per pixel; {reason}")]
    Samples {
        /// The requested number.
        samples: u32,
        /// The reason.
        reason: String,
    },
    /// A rig that can't be rendered, or a quilt that its views don't fill.
    #[non_exhaustive]
    #[error("invalid rig: {reason}")]
    Rig {
        /// The reason.
        reason: String,
    },
    /// Views, or a view and its camera, differ in size.
    #[non_exhaustive]
    #[error("sizes do not match: {sizes}; {reason}")]
    Sizes {
        /// The sizes.
        sizes: String,
        /// The requirement that the sizes violate.
        reason: &'static str,
    },
    /// A method or option that can't be encoded ahead of its execution.
    #[non_exhaustive]
    #[error("{what} can't be encoded in advance: {reason}; render it instead")]
    Encoding {
        /// The method or option.
        what: String,
        /// Why it can't be encoded.
        reason: &'static str,
    },
    /// A ray that can't be traced.
    #[non_exhaustive]
    #[error("invalid ray {index}: {reason}")]
    Ray {
        /// Its index in the list.
        index: usize,
        /// The reason.
        reason: String,
    },
    /// A scene element that can't be rendered.
    #[non_exhaustive]
    #[error("invalid scene: {}: {}", tidy(element), tidy(reason))]
    Scene {
        /// The element, as `mesh 'table', vertex 12`.
        element: String,
        /// The reason.
        reason: String,
    },
    /// An option with an invalid value.
    #[non_exhaustive]
    #[error("invalid options: {option}: {reason}")]
    Options {
        /// The option's name.
        option: &'static str,
        /// The reason.
        reason: String,
    },
    /// An invalid value in the spec of a data set.
    #[non_exhaustive]
    #[error("{}{}{}", escaped(key), if key.is_empty() { "" } else { ": " }, escaped(reason))]
    Spec {
        /// Path of the value's key, such as `scenes[0].weight`; empty for the whole spec.
        key: String,
        /// The reason.
        reason: String,
    },
    /// A scene of a data set that can't be read.
    #[non_exhaustive]
    #[error("scenes[{index}]: {source}")]
    DataSetScene {
        /// Its index in the spec.
        index: usize,
        /// The reason. Later pairs of the scene fail with the same one.
        source: std::sync::Arc<Self>,
    },
    /// An unknown name.
    #[non_exhaustive]
    #[error("unknown {what} '{}'; use one of {}", tidy(name), tidy(known))]
    UnknownName {
        /// The kind of name, as `method`.
        what: &'static str,
        /// The name as given.
        name: String,
        /// The known names, separated by commas.
        known: String,
    },
    /// A file with invalid content.
    #[non_exhaustive]
    #[error("{}", located(path, *line, reason))]
    Parse {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1, if known.
        line: Option<usize>,
        /// The reason.
        reason: String,
        /// The error of a parser, a decoder or a content check.
        source: Option<Source>,
    },
    /// A file could not be read or written. The system refused, the path is not a regular file, the file is not among
    /// those in memory, or its type can't hold the content.
    #[non_exhaustive]
    #[error("{}: {source}", shown(path))]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The progress callback asked to stop.
    #[error("cancelled by the progress callback")]
    Cancelled,
}

type Source = Box<dyn std::error::Error + Send + Sync>;

/// Returns a path for messages without shortening it, so that users can find the file.
fn shown(path: &Path) -> String {
    escaped(&path.to_string_lossy())
}

/// Returns a message about a file, or about one of its lines.
pub(crate) fn located(path: &Path, line: Option<usize>, text: &str) -> String {
    format!("{}{}: {}", shown(path), line.map(|line| format!(":{line}")).unwrap_or_default(), tidy(text))
}

/// Prints the message, so that a `main` that returns an error shows it.
impl fmt::Debug for Error {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, formatter)
    }
}

/// Implements `Display` and `FromStr` for an enumeration by its `name()` and `ALL`. Errors call it by the given words.
macro_rules! by_name {
    ($kind:ty, $what:literal) => {
        impl std::fmt::Display for $kind {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.name())
            }
        }

        impl std::str::FromStr for $kind {
            type Err = $crate::Error;

            fn from_str(name: &str) -> Result<Self, Self::Err> {
                let found = Self::ALL.iter().copied().find(|one| one.name() == name);
                found.ok_or_else(|| $crate::Error::unknown_name($what, name, Self::ALL))
            }
        }
    };
}
pub(crate) use by_name;

impl Error {
    #[cfg(any(test, feature = "scene-files", feature = "sky", feature = "textures", feature = "json"))]
    pub(crate) fn parse(path: impl Into<PathBuf>, line: Option<usize>, reason: impl Into<String>) -> Self {
        Self::Parse { path: path.into(), line, reason: reason.into(), source: None }
    }

    /// Returns [`Error::Parse`] with the error that caused it.
    #[cfg(any(feature = "scene-files", feature = "sky", feature = "textures", feature = "json"))]
    pub(crate) fn parse_from(
        path: impl Into<PathBuf>,
        line: Option<usize>,
        reason: impl Into<String>,
        source: impl Into<Source>,
    ) -> Self {
        Self::Parse { path: path.into(), line, reason: reason.into(), source: Some(source.into()) }
    }

    pub(crate) fn unknown_name<T: ToString>(what: &'static str, name: &str, all: &[T]) -> Self {
        let known = all.iter().map(T::to_string).collect::<Vec<_>>().join(", ");
        Self::UnknownName { what, name: name.to_owned(), known }
    }

    pub(crate) fn io(path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Self::Io { path: path.into(), source }
    }

    /// Returns the message without the path, for messages that name the path themselves, since long words are cut.
    #[cfg(feature = "obj")]
    pub(crate) fn without_path(&self) -> String {
        match self {
            Self::Io { source, .. } => source.to_string(),
            Self::Parse { reason, .. } => reason.clone(),
            Self::TooLarge { size, limit, remedy, .. } => format!("{size}, over the limit of {limit}; {remedy}"),
            other => other.to_string(),
        }
    }

    /// Returns [`Error::Io`] for content that can't be written to a file.
    pub(crate) fn unwritable(path: impl Into<PathBuf>, reason: impl Into<Source>) -> Self {
        Self::io(path, std::io::Error::new(std::io::ErrorKind::InvalidInput, reason))
    }

    /// Returns the error for a driver that ended a kernel's loops before their work was done.
    pub(crate) fn cut_short(threads: u64) -> Self {
        Self::Limit {
            what: format!("tracing by {}", counted(threads, "thread", "threads")),
            needed: "more loop iterations".into(),
            limit: "limit on loop iterations per thread",
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
            Error::parse(&odd, Some(3), &*odd),
            Error::Scene { element: odd.clone(), reason: odd.clone() },
            Error::NoAdapter { wanted: odd.clone(), reason: odd.clone() },
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
