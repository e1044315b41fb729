//! Exit status of the benchmarks.

use std::{error::Error, process::ExitCode};

/// Returns the exit status of a result, and prints its error.
pub fn status(result: Result<(), Box<dyn Error>>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
