//! The commands of the workspace: those that measure and check it, and all of the program `rotund`.

use clap::{CommandFactory, Parser, Subcommand};
use std::ffi::OsString;
use std::process::ExitCode;

mod moved;
mod tidy;

/// What developers of the workspace run, beside every command of the program `rotund`.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version, after_help = rotund_commands())]
#[command(args_override_self = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Measure speed against error of every intersector.
    Accuracy(rotund_study::accuracy::Args),
    /// Measure how fast trees are built and walked.
    Rays(RaysArgs),
    /// Render a scene far from the origin, tiny and huge, and say what changed.
    Moved(moved::Args),
    /// Check what no compiler checks: directions, sizes, leftovers, scenes.
    Tidy(tidy::Args),
    #[command(external_subcommand)]
    Rotund(Vec<OsString>),
}

#[derive(Debug, clap::Args)]
struct RaysArgs {
    #[command(flatten)]
    rays: rotund_study::rays::Args,
    #[command(flatten)]
    load: rotund::scene_source::LoadArgs,
}

/// The commands of the program, for the help of this one.
fn rotund_commands() -> String {
    rotund::commands()
        .into_iter()
        .fold(String::from("Commands of the program rotund:\n"), |text, (name, about)| {
            text + &format!("  {name:<12}{about}\n")
        })
}

impl Command {
    fn run(self) -> anyhow::Result<()> {
        match self {
            Self::Accuracy(args) => rotund_study::accuracy::run(args),
            Self::Rays(RaysArgs { rays, load }) => rotund_study::rays::run(rays, &|scene| {
                let named = rotund::scene_source::load(scene, &load)?;
                Ok((named.name, named.scene))
            }),
            Self::Moved(args) => moved::run(args),
            Self::Tidy(args) => tidy::run(args),
            Self::Rotund(arguments) => {
                rotund::run(std::iter::once("rotund".into()).chain(arguments))
            }
        }
    }
}

/// Parses `arguments` (the first names the program), runs the command, reports failure on
/// standard error and returns the exit code.
pub fn main(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> ExitCode {
    rotund::report(run(arguments))
}

/// Runs a command as [`main`] does, but returns the error instead of printing it.
///
/// # Errors
///
/// What the command line or the command itself complains about.
pub fn run(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> anyhow::Result<()> {
    match Cli::try_parse_from(arguments)?.command {
        Some(command) => command.run(),
        None => Ok(Cli::command().print_help()?),
    }
}
