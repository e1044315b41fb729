//! Prints the summary at the end of a command.

use std::{
    error::Error,
    io::{self, Write},
};

use serde_json::Value;

use crate::arguments::Global;

/// Result of a command, as text and as JSON.
#[derive(Default)]
pub(crate) struct Summary {
    /// Text of complete lines.
    pub(crate) text: String,
    /// JSON object, or null if there is no result.
    pub(crate) json: Value,
    /// Whether to print to standard error, because standard output carries pictures.
    pub(crate) to_stderr: bool,
    /// Whether the command found faults, so that its exit status is 1.
    pub(crate) has_failed: bool,
}

impl Summary {
    /// Prints the result.
    pub(crate) fn print(&self, global: &Global) -> Result<(), Box<dyn Error>> {
        let text = match (global.json, &self.json) {
            (true, json) if !json.is_null() => format!("{json}\n"),
            _ if global.quiet => return Ok(()),
            _ => self.text.clone(),
        };
        let written = match self.to_stderr {
            true => io::stderr().write_all(text.as_bytes()),
            false => io::stdout().write_all(text.as_bytes()),
        };
        match written {
            // A program that reads only the first lines, such as `head`, closes the pipe. This is not an error.
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(format!("standard output: {error}").into()),
            _ => Ok(()),
        }
    }
}
