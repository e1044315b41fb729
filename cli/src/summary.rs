//! What is said at the end.

use std::{
    error::Error,
    io::{self, Write},
};

use serde_json::Value;

use crate::arguments::Global;

/// What a command did, for people and for programs.
#[derive(Default)]
pub(crate) struct Summary {
    /// Whole lines.
    pub(crate) text: String,
    /// One object; null where there is nothing to tell.
    pub(crate) json: Value,
    /// Standard output has been taken by pictures.
    pub(crate) to_stderr: bool,
}

impl Summary {
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
            // Who reads only the first lines (`| head`) closes the pipe: no fault.
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(format!("standard output: {error}").into()),
            _ => Ok(()),
        }
    }
}
