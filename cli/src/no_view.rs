//! Replaces `view` in builds without the feature `view` by an error that says how to build it.

use std::{error::Error, ffi::OsString};

use clap::Args;

use crate::{
    arguments::{Global, Subject},
    summary::Summary,
};

#[derive(Clone, Debug, Args)]
pub(crate) struct Arguments {
    /// All arguments, which are ignored
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    _all: Vec<OsString>,
}

impl Arguments {
    /// Returns no subject, since nothing is rendered.
    pub(crate) fn subject(&self) -> Option<&Subject> {
        None
    }
}

pub(crate) fn run(_: &Arguments, _: &Global) -> Result<Summary, Box<dyn Error>> {
    Err("view: this build has no window; build the command with its default features to get one".into())
}
