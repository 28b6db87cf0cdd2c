//! The inside of the program `rotund`: its command line, for `main.rs`, tests and the workspace's
//! own tasks.
//!
//! This is no library to build on: the crates below it are, from `rotund-geometry` to
//! `rotund-golden`. Each command is a module with a clap `Args` and a function `run`; this file
//! parses and dispatches. Commands compose functions of the other crates and print; no formula of
//! intersection or shading lives here.
//!
//! # Exit codes
//!
//! | code | meaning |
//! | --- | --- |
//! | 0 | the command succeeded |
//! | 1 | the command failed, and will again; standard error has one line, `error: ...` |
//! | 2 | the command line was not understood; standard error says what was expected |
//! | 3 | the picture was written, its checkpoint was not; standard error has a line `warning: ...` |
//! | 4 | `merge` lacks shards, or some are not finished |
//! | 5 | a file could not be written, or memory ran out |
//! | 130 | Ctrl-C, SIGTERM or SIGHUP interrupted the command; standard error says what was written |
//!
//! A reader that closes standard output early (`rotund info shapes4 | head -1`) is not an error.

#![expect(clippy::print_stderr, reason = "this crate is the one that talks to people")]

use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use rotund_bvh::Isa;
use rotund_report::console::printable;
use std::ffi::OsString;
use std::io;
use std::process::ExitCode;

mod background;
mod built_in;
mod cancel;
mod checkpoint;
mod choice;
mod compare;
mod completions;
mod denoised;
mod diff;
mod exit;
mod golden;
mod info;
mod kinds;
mod memory;
mod merge;
mod message;
mod noise;
mod origin;
mod output;
mod progress;
mod render;
mod scene_source;
mod shot;
#[cfg(feature = "view")]
mod view;

pub use exit::{Cancelled, EXIT_CODES};
pub use kinds::enhance;
pub use output::{prepare_folder, write_text};
pub use scene_source::{LoadArgs, NamedScene, load};
pub use shot::{PictureArgs, Shot, take};

const EXAMPLES: &str = "\
Examples:
  rotund compare shapes4
  rotund view shapes4
  rotund compare --all --samples 16
  rotund render shapes4 --mode vanilla --out vanilla.png
  rotund render cloud.ply --radius 0.01 --out cloud.png
  rotund diff out/shapes4/enhanced.exr out/shapes4/vanilla.exr
  rotund COMMAND --help";

/// Render points as spheres, lines as rounded cones and quads as bilinear patches, exactly and by
/// the usual approximations, and compare the pictures.
#[derive(Debug, Parser)]
#[command(name = "rotund", bin_name = "rotund", version, args_override_self = true)]
#[command(after_help = format!("{EXAMPLES}\n\n{EXIT_CODES}"))]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

/// A command of the program with its arguments.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene by both methods, vanilla and enhanced, and show what changed.
    Compare(compare::Args),
    /// Render one picture of a scene.
    Render(render::Args),
    /// Show a scene in the browser, where it can be turned and switched.
    #[cfg(feature = "view")]
    View(view::Args),
    /// Merge the shards of a render into one picture.
    Merge(merge::Args),
    /// Measure the difference of two images.
    Diff(diff::Args),
    /// Plot noise against render time for both samplers.
    Noise(noise::Args),
    /// List the content of a scene and its cost in memory.
    Info(info::Args),
    /// Check small pictures against stored references by statistical tests.
    Golden(golden::Args),
    /// Print the completion script of a shell.
    Completions(completions::Args),
}

impl Command {
    /// Runs the command. `program` is the command line that it was parsed by, for which
    /// `completions` writes a script.
    ///
    /// # Errors
    ///
    /// Returns the reason why the command failed, for [`report`].
    pub fn run(self, program: clap::Command) -> anyhow::Result<()> {
        match self {
            Self::Compare(args) => compare::run(args),
            Self::Render(args) => render::run(args),
            #[cfg(feature = "view")]
            Self::View(args) => view::run(args),
            Self::Merge(args) => merge::run(args),
            Self::Diff(args) => diff::run(args),
            Self::Noise(args) => noise::run(args),
            Self::Info(args) => info::run(args),
            Self::Golden(args) => golden::run(args),
            Self::Completions(args) => completions::run(&args, program),
        }
    }
}

/// Rewrites the examples in the help of all commands for a program that is called otherwise than
/// `rotund`, such as `cargo xtask`.
#[must_use]
pub fn with_examples_of(invocation: &str, program: clap::Command) -> clap::Command {
    program.mut_subcommands(|command| {
        let Some(help) = command.get_after_help().map(ToString::to_string) else { return command };
        command.after_help(help.replace("rotund ", &format!("{invocation} ")))
    })
}

/// Parses `arguments` (the first names the program), runs the command, reports failure on standard
/// error and returns the exit code.
pub fn main(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> ExitCode {
    check_environment();
    report(run(arguments))
}

/// Runs a command as [`main`] does, but returns the error instead of printing it.
///
/// # Errors
///
/// Returns a [`clap::Error`] if the command line is wrong, and else the reason why the command
/// failed.
pub fn run(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> anyhow::Result<()> {
    let mut program = Cli::command();
    let matches = program.try_get_matches_from_mut(arguments)?;
    match Cli::from_arg_matches(&matches)?.command {
        Some(command) => command.run(program),
        None => Ok(program.print_help()?),
    }
}

/// Prints a failure on standard error and returns the exit code of the result.
pub fn report(result: anyhow::Result<()>) -> ExitCode {
    let Err(error) = result else { return ExitCode::SUCCESS };
    if let Some(error) = error.downcast_ref::<clap::Error>() {
        if error.use_stderr() {
            // Without colours: the message quotes arguments, which may hold escapes of their own.
            eprint!("{}", printable(&error.render().to_string()));
        } else {
            // If standard output is closed, nobody can be told.
            let _ = error.print();
        }
        return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
    }
    if is_broken_pipe(&error) {
        return ExitCode::SUCCESS;
    }
    let code = exit::code(&error);
    let text = message::one_line(&error);
    if code == exit::NO_CHECKPOINT {
        message::warn(text);
    } else {
        eprintln!("error: {text}");
    }
    ExitCode::from(code)
}

/// Warns about environment variables that have no meaning, on standard error.
pub fn check_environment() {
    let Some(name) = std::env::var_os("ROTUND_ISA").filter(|name| !name.is_empty()) else { return };
    if let Err(error) = name.to_string_lossy().parse::<Isa>() {
        let used = Isa::default_set().name();
        message::warn(format!("the variable ROTUND_ISA is ignored: {error}; {used} is used"));
    }
}

/// Returns true if the only failure is that nobody reads standard output any more.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        cause.downcast_ref::<io::Error>().is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
    })
}

#[cfg(test)]
mod tests {
    use super::{Cli, with_examples_of};
    use clap::CommandFactory as _;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn help_fits_in_80_columns() {
        for program in [Cli::command(), with_examples_of("cargo xtask", Cli::command())] {
            let mut program = program.term_width(80);
            program.build();
            let texts = program
                .get_subcommands()
                .map(|command| (command.get_name().to_owned(), command.clone().render_long_help()))
                .chain([("the program".to_owned(), program.clone().render_long_help())]);
            for (name, text) in texts {
                for line in text.to_string().lines() {
                    assert!(line.chars().count() <= 80, "{name}: {line:?}");
                }
            }
        }
    }

    #[test]
    fn examples_are_one_line_each_and_name_the_program() {
        for (invocation, other) in [("rotund", "cargo"), ("cargo xtask", "rotund ")] {
            let program = with_examples_of(invocation, Cli::command());
            for command in program.get_subcommands() {
                let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
                let example = format!("{invocation} {}", command.get_name());
                assert!(help.contains(&example) && !help.contains(other), "{help}");
                for line in help.lines() {
                    assert!(line.chars().count() <= 80, "wrapped in 80 columns: {line}");
                }
            }
        }
    }
}
