//! Shared parts of the command's tests, which run the command as a user does.
#![allow(dead_code, reason = "each test uses a part of it")]

#[path = "../../../tests/it/common/folder.rs"]
pub(crate) mod folder;

use std::process::{Command, Output};

/// Control characters that would clear the screen and reverse the direction of the text.
pub(crate) const STEERING: &str = "\u{1b}[2J\u{202e}";
pub(crate) const ESCAPED: &str = r"\u{1b}[2J\u{202e}";

/// Runs the command with these arguments.
pub(crate) fn run(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stereotrace"));
    // Without a calibration that a user keeps.
    command.args(arguments).env("NODEVICE_SELECT", "1").env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"));
    command.output().expect("the command runs")
}

/// Runs a command that must succeed, and returns its standard output.
pub(crate) fn printed(arguments: &[&str]) -> String {
    let output = run(arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {error}");
    String::from_utf8(output.stdout).expect("text")
}

/// Runs a command that must fail, and returns the last line of its message without `error: `.
pub(crate) fn error_of(arguments: &[&str]) -> String {
    let output = run(arguments);
    assert!(!output.status.success(), "{arguments:?} succeeded: {}", String::from_utf8_lossy(&output.stdout));
    assert!(output.stdout.is_empty(), "{arguments:?} prints {}", String::from_utf8_lossy(&output.stdout));
    let text = String::from_utf8(output.stderr).expect("text");
    let line = text.lines().last().unwrap_or_default();
    line.strip_prefix("error: ").unwrap_or_else(|| panic!("{arguments:?}: no error, but {text}")).to_owned()
}
