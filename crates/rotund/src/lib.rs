//! The commands of the Rotund workspace: `cargo xtask --help` lists them.
//!
//! Each command is a module with a clap `Args` and a `run(Args) -> anyhow::Result<()>`; this file
//! only parses and dispatches. Commands compose functions of the crates and print; no formula of
//! intersection or shading lives here.
//!
//! # Exit codes
//!
//! | code | meaning |
//! | --- | --- |
//! | 0 | done |
//! | 1 | the command failed; standard error has one line, `error: ...` |
//! | 2 | the command line was not understood; standard error says what was expected |
//! | 130 | interrupted by Ctrl-C; standard error says what was written |
//!
//! A reader that closes standard output early (`cargo xtask ... | head`) is not an error.

#![expect(clippy::print_stderr, reason = "this crate is the one that talks to people")]

use clap::{CommandFactory, Parser, Subcommand};
use std::ffi::OsString;
use std::io;
use std::process::ExitCode;

pub mod cancel;
mod checkpoint;
mod compare;
mod completions;
mod diff;
mod golden;
mod info;
pub mod kinds;
mod merge;
mod noise;
pub mod output;
mod progress;
mod render;
pub mod scene_source;
pub mod shot;
pub mod workspace;

const EXIT_CODES: &str = "\
Exit codes:
  0    done
  1    the command failed; standard error says why in one line
  2    the command line was not understood
  130  interrupted by Ctrl-C; standard error says what was written

Examples:
  cargo xtask compare shapes4
  cargo xtask compare --all --samples 16
  cargo xtask render shapes4 --mode vanilla --out vanilla.png
  cargo xtask diff out/shapes4/enhanced.exr out/shapes4/vanilla.exr
  cargo xtask golden
  cargo xtask COMMAND --help

Colours and progress bars are for terminals only; NO_COLOR turns colours off there too.";

/// Points as spheres, lines as rounded cones, quads as bilinear patches: render, compare, measure.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version, after_help = EXIT_CODES)]
#[command(args_override_self = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a scene vanilla and enhanced, and show what changed.
    Compare(compare::Args),
    /// Render one picture of a scene.
    Render(render::Args),
    /// Make one picture of the shards of a render.
    Merge(merge::Args),
    /// Say in numbers how far two images are apart.
    Diff(diff::Args),
    /// Plot how noise falls with time, for both samplers.
    Noise(noise::Args),
    /// List what a scene holds.
    Info(info::Args),
    /// Check that the golden pictures look as they did.
    Golden(golden::Args),
    /// Print what a shell needs to complete commands.
    Completions(completions::Args),
}

impl Cli {
    /// Without a command, says which there are.
    fn run(self) -> anyhow::Result<()> {
        match self.command {
            Some(command) => command.run(),
            None => Ok(Self::command().print_help()?),
        }
    }
}

impl Command {
    fn run(self) -> anyhow::Result<()> {
        match self {
            Self::Compare(args) => compare::run(args),
            Self::Render(args) => render::run(args),
            Self::Merge(args) => merge::run(args),
            Self::Diff(args) => diff::run(args),
            Self::Noise(args) => noise::run(args),
            Self::Info(args) => info::run(args),
            Self::Golden(args) => golden::run(args),
            Self::Completions(args) => completions::run(&args),
        }
    }
}

/// The names of all commands, each with what it does.
#[must_use]
pub fn commands() -> Vec<(String, String)> {
    let about = |command: &clap::Command| {
        let about = command.get_about().map(ToString::to_string).unwrap_or_default();
        (command.get_name().to_owned(), about)
    };
    Cli::command().get_subcommands().map(about).collect()
}

/// Parses `arguments` (the first names the program), runs the command, reports failure on
/// standard error and returns the exit code.
pub fn main(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> ExitCode {
    report(run(arguments))
}

/// The exit code of a command that ended like this; a failure is printed on standard error.
pub fn report(result: anyhow::Result<()>) -> ExitCode {
    let Err(error) = result else { return ExitCode::SUCCESS };
    if let Some(error) = error.downcast_ref::<clap::Error>() {
        // If even this cannot be printed there is nobody left to tell.
        let _ = error.print();
        return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
    }
    if is_broken_pipe(&error) {
        return ExitCode::SUCCESS;
    }
    eprintln!("error: {error:#}");
    let interrupted = error.is::<cancel::Cancelled>();
    if interrupted { ExitCode::from(cancel::EXIT_CODE) } else { ExitCode::FAILURE }
}

/// Runs a command as [`main`] does, but returns the error instead of printing it.
///
/// # Errors
///
/// What the command line or the command itself complains about.
pub fn run(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> anyhow::Result<()> {
    Cli::try_parse_from(arguments)?.run()
}

/// Whether all that went wrong is that nobody reads standard output any more.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        cause.downcast_ref::<io::Error>().is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
    })
}
