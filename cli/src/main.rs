//! The command `stereotrace`: stereo pairs, films, quilts and ground truth for stereo vision from scene files.
//!
//! `arguments` reads the command line; `commands` has a file for each command, which begins with what it takes. What
//! pictures are made of comes from `arguments::Subject`, where they go from `target`. `view` is the window, of builds
//! with that feature.

#![allow(clippy::doc_markdown, reason = "help is printed as it stands")]

mod arguments;
mod commands;
#[cfg(all(test, feature = "view"))]
#[path = "../../tests/it/common/folder.rs"]
#[allow(dead_code, reason = "unit tests use a part of it")]
mod folder;
mod progress;
mod record;
mod stop;
mod studio;
mod summary;
mod target;
#[cfg_attr(not(feature = "view"), path = "no_view.rs")]
mod view;

use std::{
    error::Error,
    io::{self, Write},
    path::Path,
    process::ExitCode,
};

use clap::{CommandFactory, Parser, error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand};
use stereotrace::message;

use crate::{
    arguments::{Cli, Command},
    commands::{compare, dataset, info, render, sequence, views},
    stop::{INTERRUPTED, Interrupted},
    summary::Summary,
};

/// Of a command line that says nothing that can be done.
const USAGE: u8 = 2;

fn main() -> ExitCode {
    #[cfg(target_os = "linux")]
    keep_mesa_quiet();
    env_logger::Builder::from_env(env_logger::Env::default().default_filter_or("error,stereotrace=warn")).init();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        // Help, asked for or for want of a command, has lines of its own.
        Err(error) if !error.use_stderr() || error.kind() == DisplayHelpOnMissingArgumentOrSubcommand => error.exit(),
        Err(error) => {
            complain(&format!("{}; --help lists what there is", usage_fault(&error)));
            return ExitCode::from(USAGE);
        }
    };
    match run(&cli).and_then(|summary| summary.print(&cli.global)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            complain(&error.to_string());
            if error.is::<Interrupted>() { ExitCode::from(INTERRUPTED) } else { ExitCode::FAILURE }
        }
    }
}

fn run(cli: &Cli) -> Result<Summary, Box<dyn Error>> {
    let global = &cli.global;
    match &cli.command {
        Command::Render(arguments) => render::run(arguments, global),
        Command::Sequence(arguments) => sequence::run(arguments, global),
        Command::Dataset(arguments) => dataset::run(arguments, global),
        Command::Views(arguments) => views::run(arguments, global),
        Command::View(arguments) => view::run(arguments, global),
        Command::Compare(arguments) => compare::run(arguments, global),
        Command::Info(arguments) => info::run(arguments, global),
        Command::Completions { shell } => {
            clap_complete::generate(*shell, &mut Cli::command(), "stereotrace", &mut io::stdout());
            Ok(Summary::default())
        }
        Command::Man => {
            manual(&mut io::stdout())?;
            Ok(Summary::default())
        }
    }
}

/// The manual page, and behind it one of each command.
fn manual(out: &mut impl Write) -> io::Result<()> {
    let mut whole = Cli::command();
    whole.build();
    clap_mangen::Man::new(whole.clone()).render(out)?;
    for command in whole.get_subcommands().filter(|command| command.get_name() != "help") {
        clap_mangen::Man::new(command.clone()).render(out)?;
    }
    Ok(())
}

/// What is wrong with a command line, and what may have been meant; the other paragraphs are advice on usage.
fn usage_fault(error: &clap::Error) -> String {
    let text = error.to_string();
    let mut paragraphs = text.split("\n\n");
    let first = paragraphs.next().unwrap_or(&text).trim_start_matches("error: ");
    let tips = paragraphs.filter_map(|paragraph| paragraph.trim_start().strip_prefix("tip: "));
    [first].into_iter().chain(tips.flat_map(|tip| tip.lines().take(1))).collect::<Vec<_>>().join("; ")
}

/// Prints an error as one line that does not steer the terminal; messages of the graphics driver have several.
fn complain(text: &str) {
    let _ = writeln!(io::stderr(), "error: {}", error_line(text));
}

fn error_line(text: &str) -> String {
    let lines: Vec<_> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    message::escaped(&lines.join(" "))
}

/// A path as it is printed: names must not steer the terminal.
fn shown(path: &Path) -> String {
    message::escaped(&path.to_string_lossy())
}

/// Without a user's session, Mesa prints `error: XDG_RUNTIME_DIR is invalid or not set in the environment.`, which
/// means nothing here and looks like an error of ours. What stops it must be in the environment before the program
/// starts, so it starts itself again.
#[cfg(target_os = "linux")]
fn keep_mesa_quiet() {
    use std::{env, os::unix::process::CommandExt, process};

    let in_session = env::var_os("XDG_RUNTIME_DIR").is_some_and(|folder| Path::new(&folder).is_dir());
    if in_session || env::var_os("NODEVICE_SELECT").is_some() {
        return;
    }
    if let Ok(program) = env::current_exe() {
        // This comes back only where it fails, and then the line does no harm.
        let _ = process::Command::new(program).args(env::args_os().skip(1)).env("NODEVICE_SELECT", "1").exec();
    }
}
