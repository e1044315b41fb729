//! How a benchmark ends.

use std::{error::Error, process::ExitCode};

/// The exit status of what was done; an error is printed.
pub fn status(result: Result<(), Box<dyn Error>>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
