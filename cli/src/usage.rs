//! The error of a wrong command line.

use std::{error::Error, fmt};

/// A fault of the command line, which ends the program with the status 2. Most faults are found before any file is
/// read. Some depend on the scene.
#[derive(Debug)]
pub(crate) struct Usage(pub(crate) String);

impl fmt::Display for Usage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Error for Usage {}
