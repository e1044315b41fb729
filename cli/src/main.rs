//! The command `stereotrace` renders stereo pairs, films, quilts and ground truth for stereo vision from scene files.
//!
//! `arguments` reads the command line. `commands` has one file for each command, which begins with its arguments.
//! `arguments::Subject` gives scene, camera and options; `target` writes the pictures. `view` is the window, in builds
//! with the feature `view`.

#![allow(clippy::doc_markdown, reason = "help is printed as it stands")]

mod arguments;
mod calibration;
mod commands;
#[cfg(all(test, feature = "view"))]
#[path = "../../tests/it/common/folder.rs"]
#[allow(dead_code, reason = "unit tests use a part of it")]
mod folder;
mod manifest;
mod pictures;
mod progress;
mod record;
mod stop;
mod studio;
mod summary;
mod target;
mod truth;
mod usage;
#[cfg_attr(not(feature = "view"), path = "no_view.rs")]
mod view;

use std::{
    error::Error,
    io::{self, Write},
    path::Path,
    process::ExitCode,
};

use clap::{FromArgMatches, error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand};
use stereotrace::message;

use crate::{
    arguments::{Cli, Command, Subject},
    commands::{bench, compare, dataset, info, render, sequence, views},
    stop::{INTERRUPTED, Interrupted},
    summary::Summary,
    usage::Usage,
};

/// Exit status of a wrong command line.
const USAGE: u8 = 2;

fn main() -> ExitCode {
    #[cfg(target_os = "linux")]
    keep_mesa_quiet();
    log_to_stderr();
    let parsed = arguments::command().try_get_matches().and_then(|matches| Cli::from_arg_matches(&matches));
    let cli = match parsed {
        Ok(cli) => cli,
        // Help keeps its line breaks, whether requested or printed for a missing command.
        Err(error) if !error.use_stderr() || error.kind() == DisplayHelpOnMissingArgumentOrSubcommand => error.exit(),
        Err(error) => {
            complain(&format!("{}; see --help", usage_fault(&error)));
            return ExitCode::from(USAGE);
        }
    };
    match run(&cli).and_then(|summary| summary.print(&cli.global).map(|()| summary.has_failed)) {
        Ok(false) => ExitCode::SUCCESS,
        Ok(true) => ExitCode::FAILURE,
        Err(error) => {
            complain(&error.to_string());
            match () {
                () if error.is::<Interrupted>() => ExitCode::from(INTERRUPTED),
                () if error.is::<Usage>() => ExitCode::from(USAGE),
                () => ExitCode::FAILURE,
            }
        }
    }
}

fn run(cli: &Cli) -> Result<Summary, Box<dyn Error>> {
    let global = &cli.global;
    cli.command.subject().map_or(Ok(()), Subject::check)?;
    match &cli.command {
        Command::Render(arguments) => render::run(arguments, global),
        Command::Sequence(arguments) => sequence::run(arguments, global),
        Command::Dataset(arguments) => dataset::run(arguments, global),
        Command::Views(arguments) => views::run(arguments, global),
        Command::View(arguments) => view::run(arguments, global),
        Command::Compare(arguments) => compare::run(arguments, global),
        Command::Bench(arguments) => bench::run(arguments, global),
        Command::Info(arguments) => info::run(arguments, global),
        Command::Completions { shell } => {
            clap_complete::generate(*shell, &mut arguments::command(), "stereotrace", &mut io::stdout());
            Ok(Summary::default())
        }
        Command::Man => {
            manual(&mut io::stdout())?;
            Ok(Summary::default())
        }
    }
}

/// Writes the manual page, followed by one page for each command.
fn manual(out: &mut impl Write) -> io::Result<()> {
    let mut whole = arguments::whole_command();
    whole.build();
    clap_mangen::Man::new(whole.clone()).render(out)?;
    for command in whole.get_subcommands().filter(|command| command.get_name() != "help") {
        clap_mangen::Man::new(command.clone()).render(out)?;
    }
    Ok(())
}

/// Returns the error of a command line and clap's tips, without the message's paragraphs about usage.
fn usage_fault(error: &clap::Error) -> String {
    let text = error.to_string();
    let mut paragraphs = text.split("\n\n");
    let first = paragraphs.next().unwrap_or(&text).trim_start_matches("error: ");
    let tips = paragraphs.filter_map(|paragraph| paragraph.trim_start().strip_prefix("tip: "));
    [first].into_iter().chain(tips.flat_map(|tip| tip.lines().take(1))).collect::<Vec<_>>().join("; ")
}

/// Prints an error as one line without control characters. Messages of graphics drivers may have several lines.
fn complain(text: &str) {
    let _ = writeln!(io::stderr(), "error: {}", error_line(text));
}

fn error_line(text: &str) -> String {
    let lines: Vec<_> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    message::escaped(&lines.join(" "))
}

/// Returns a path for printing, with control characters escaped.
fn shown(path: &Path) -> String {
    message::escaped(&path.to_string_lossy())
}

/// Prints log records in the format of errors: `warning: …`.
fn log_to_stderr() {
    let filter = env_logger::Env::default().default_filter_or("error,stereotrace=warn");
    let mut builder = env_logger::Builder::from_env(filter);
    builder.format(|out, record| {
        let level = match record.level() {
            log::Level::Warn => "warning".into(),
            level => level.as_str().to_lowercase(),
        };
        writeln!(out, "{level}: {}", record.args())
    });
    builder.init();
}

/// Suppresses Mesa's line `error: XDG_RUNTIME_DIR is invalid or not set in the environment.`, which Mesa prints outside
/// a user's session and which does not affect rendering. The variable that suppresses it must be set before the program
/// starts, so the program starts itself again.
#[cfg(target_os = "linux")]
fn keep_mesa_quiet() {
    use std::{env, os::unix::process::CommandExt, process};

    let in_session = env::var_os("XDG_RUNTIME_DIR").is_some_and(|folder| Path::new(&folder).is_dir());
    if in_session || env::var_os("NODEVICE_SELECT").is_some() {
        return;
    }
    if let Ok(program) = env::current_exe() {
        // `exec` returns only if it fails. Then the program continues, and Mesa prints its line.
        let _ = process::Command::new(program).args(env::args_os().skip(1)).env("NODEVICE_SELECT", "1").exec();
    }
}
