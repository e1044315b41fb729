//! The one error type.

use std::path::{Path, PathBuf};

use crate::message::{counted, escaped, tidy};

/// A browser brings its own.
const ADAPTER_REMEDY: &str = if cfg!(target_arch = "wasm32") {
    ""
} else {
    ". On Debian, `apt-get install mesa-vulkan-drivers` installs a software one"
};

/// Everything that can go wrong. Each message names the thing, the value and, where there is one, the remedy. In what
/// it quotes of files, control characters are escaped and words over 80 characters cut; the fields hold all of it.
///
/// A message is whole without its [`source`](std::error::Error::source), whose words it has: print the message, not the
/// chain. Sources are there to be asked for their kind. (Those of a device are text: in a browser they can't cross
/// threads.)
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No graphics driver offers an adapter that fits.
    #[non_exhaustive]
    #[error("no graphics adapter found{}: {}{ADAPTER_REMEDY}", tidy(wanted), tidy(reason))]
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
    /// A scene is on another device than the renderer.
    #[error("the scene was uploaded by another Gpu; upload it with this renderer")]
    ForeignScene,
    /// Something is larger than this adapter allows.
    #[non_exhaustive]
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
    /// A file, or the picture in it, is over one of the [`Limits`](crate::Limits), and was not read.
    #[non_exhaustive]
    #[error("{}: {size}, over the limit of {limit}; {remedy}", shown(path))]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What is too large, with its size.
        size: String,
        /// The limit.
        limit: u64,
        /// What raises it.
        remedy: String,
    },
    /// A camera that has no picture.
    #[non_exhaustive]
    #[error("invalid camera: {field} is {value}; {reason}")]
    Camera {
        /// The field at fault.
        field: &'static str,
        /// Its value.
        value: String,
        /// What is expected of it.
        reason: &'static str,
    },
    /// A number of samples that no pixel has, or more of them than directions in f32 tell apart.
    #[non_exhaustive]
    #[error("invalid samples: {samples} a pixel; {reason}")]
    Samples {
        /// The number asked for.
        samples: u32,
        /// What is wrong with it.
        reason: String,
    },
    /// A rig of eyes that can't be rendered, or a quilt that its views don't fill.
    #[non_exhaustive]
    #[error("invalid rig: {reason}")]
    Rig {
        /// What is wrong with it.
        reason: String,
    },
    /// Views, or a view and its camera, that don't have one size.
    #[non_exhaustive]
    #[error("sizes that don't fit: {sizes}; {reason}")]
    Sizes {
        /// The sizes.
        sizes: String,
        /// What is expected of them.
        reason: &'static str,
    },
    /// What no frame can be encoded with.
    #[non_exhaustive]
    #[error("{what} can't be encoded ahead: {reason}; render it instead")]
    Encoding {
        /// The method, or what was asked for.
        what: String,
        /// Why not.
        reason: &'static str,
    },
    /// A ray that can't be traced.
    #[non_exhaustive]
    #[error("invalid ray {index}: {reason}")]
    Ray {
        /// Its place in the list.
        index: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// A scene with an element that cannot be rendered.
    #[non_exhaustive]
    #[error("invalid scene: {}: {}", tidy(element), tidy(reason))]
    Scene {
        /// The element, as `mesh 'table', vertex 12`.
        element: String,
        /// What is wrong with it.
        reason: String,
    },
    /// An option that nothing can be rendered with.
    #[non_exhaustive]
    #[error("invalid options: {option}: {reason}")]
    Options {
        /// Which one.
        option: &'static str,
        /// What is wrong with its value.
        reason: String,
    },
    /// A name that is none of those known.
    #[non_exhaustive]
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
    #[non_exhaustive]
    #[error("{}", located(path, *line, reason))]
    Parse {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1, where it is known.
        line: Option<usize>,
        /// What is wrong there.
        reason: String,
        /// What a parser, a decoder or a check of the content said.
        source: Option<Source>,
    },
    /// A file that could not be read or written: the system refused, it is no regular file, it is not among those in
    /// memory, or what is to be written makes no file of its kind.
    #[non_exhaustive]
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

type Source = Box<dyn std::error::Error + Send + Sync>;

/// A path as messages show it: whole, since that is how it is found.
fn shown(path: &Path) -> String {
    escaped(&path.to_string_lossy())
}

/// What is to be said of a file or of one of its lines.
pub(crate) fn located(path: &Path, line: Option<usize>, text: &str) -> String {
    format!("{}{}: {}", shown(path), line.map(|line| format!(":{line}")).unwrap_or_default(), tidy(text))
}

impl Error {
    #[cfg(any(test, feature = "scene-files", feature = "sky", feature = "textures", feature = "json"))]
    pub(crate) fn parse(path: impl Into<PathBuf>, line: Option<usize>, reason: impl Into<String>) -> Self {
        Self::Parse { path: path.into(), line, reason: reason.into(), source: None }
    }

    /// The same of what another error says.
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

    /// Without the path, for a message that says it otherwise: messages cut long words.
    #[cfg(feature = "obj")]
    pub(crate) fn without_path(&self) -> String {
        match self {
            Self::Io { source, .. } => source.to_string(),
            Self::Parse { reason, .. } => reason.clone(),
            Self::TooLarge { size, limit, remedy, .. } => format!("{size}, over the limit of {limit}; {remedy}"),
            other => other.to_string(),
        }
    }

    /// Of what is to be written to a file and can't be.
    pub(crate) fn unwritable(path: impl Into<PathBuf>, reason: impl Into<Source>) -> Self {
        Self::io(path, std::io::Error::new(std::io::ErrorKind::InvalidInput, reason))
    }

    /// A driver ended a kernel's loops before their work was done.
    pub(crate) fn cut_short(threads: u64) -> Self {
        Self::Limit {
            what: format!("the tracing of {}", counted(threads, "thread", "threads")),
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
