//! The library's errors as Python exceptions. The class says what a program may do; the text is the library's.

use std::io::ErrorKind;

use pyo3::{
    create_exception,
    exceptions::{PyFileNotFoundError, PyOSError, PyPermissionError, PyRuntimeError, PyValueError},
    prelude::*,
};
use stereotrace::Error;

create_exception!(
    stereotrace,
    AdapterError,
    PyRuntimeError,
    "No graphics adapter is suitable, or its driver refused a request."
);
create_exception!(
    stereotrace,
    LimitError,
    AdapterError,
    "A picture or scene exceeds a limit or the memory of the adapter; the message names the limit."
);
create_exception!(
    stereotrace,
    DeviceLostError,
    AdapterError,
    "The device was lost: make a new Renderer and try again."
);

/// Converts an error of the library to an exception.
pub(crate) fn raised(error: Error) -> PyErr {
    let text = error.to_string();
    exception(&error, text)
}

fn exception(error: &Error, text: String) -> PyErr {
    match error {
        Error::DataSetScene { source, .. } => exception(source, text),
        Error::NoAdapter { .. } | Error::Gpu(_) => AdapterError::new_err(text),
        Error::DeviceLost(_) => DeviceLostError::new_err(text),
        Error::Limit { .. } | Error::OutOfMemory(_) => LimitError::new_err(text),
        Error::Io { source, .. } => match source.kind() {
            ErrorKind::NotFound => PyFileNotFoundError::new_err(text),
            ErrorKind::PermissionDenied => PyPermissionError::new_err(text),
            // The data can't be written in the file's format.
            ErrorKind::InvalidInput if source.raw_os_error().is_none() => PyValueError::new_err(text),
            _ => PyOSError::new_err(text),
        },
        _ => PyValueError::new_err(text),
    }
}

/// Returns the exception for input that this package itself refuses.
pub(crate) fn refused(text: impl Into<String>) -> PyErr {
    PyValueError::new_err(text.into())
}
