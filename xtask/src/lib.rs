//! The commands of the workspace: those that measure and check it, and all of the program `rotund`.

use clap::builder::ArgPredicate;
use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use rotund_scene::Scene;
use std::ffi::OsString;
use std::process::ExitCode;

mod child;
mod farm_check;
mod moved;
mod tidy;
mod workspace;

const EXAMPLES: &str = "\
Examples:
  cargo xtask compare shapes4
  cargo xtask render shapes4 --mode vanilla --out vanilla.png
  cargo xtask view shapes4
  cargo xtask golden
  cargo xtask accuracy
  cargo xtask rays spheres-1M cones-1M patches-1M
  cargo xtask COMMAND --help";

const GOLDEN_EXAMPLES: &str = "\
Without --dir, checks the pictures of the workspace: all scenes in tests/golden.

Examples:
  cargo xtask golden
  cargo xtask golden --isa all
  cargo xtask golden --bless
  cargo xtask golden --dir goldens --bless a.json b.json
  cargo xtask golden --dir goldens a.json b.json";

const COMPLETIONS_EXAMPLES: &str = "\
Cargo completes its own words, so the script is for a name of its own, xtask.

Examples:
  cargo xtask completions zsh > ~/.zfunc/_xtask

For bash, both lines in ~/.bashrc:
  alias xtask='cargo xtask'
  source <(cargo xtask completions bash)";

/// Run a command of the program rotund, built from this workspace, or a task of its developers.
#[derive(Debug, Parser)]
#[command(name = "xtask", bin_name = "cargo xtask", version, args_override_self = true)]
#[command(after_help = format!("{EXAMPLES}\n\n{}", rotund::EXIT_CODES))]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    #[command(flatten)]
    Rotund(rotund::Command),
    /// Measure speed against error of every intersector.
    Accuracy(AccuracyArgs),
    /// Measure how fast trees are built and traversed.
    Rays(RaysArgs),
    /// Render a scene far from the origin, tiny and huge, and measure what changed.
    Moved(moved::Args),
    /// Kill, interrupt and spread renders as a farm does, and compare the bits.
    FarmCheck(farm_check::Args),
    /// Check dependencies, circles between files, formulas, sizes, leftovers and scenes.
    Tidy(tidy::Args),
}

#[derive(Debug, clap::Args)]
struct AccuracyArgs {
    #[command(flatten)]
    accuracy: rotund_study::accuracy::Args,
    #[command(flatten)]
    load: rotund::LoadArgs,
}

#[derive(Debug, clap::Args)]
struct RaysArgs {
    #[command(flatten)]
    rays: rotund_study::rays::Args,
    #[command(flatten)]
    load: rotund::LoadArgs,
}

/// The command line: the commands of `rotund` with examples for `cargo xtask`, and with defaults
/// for the workspace.
fn program() -> clap::Command {
    let golden = workspace::root().join("tests/golden");
    let program = rotund::with_examples_of("cargo xtask", Cli::command())
        .mut_subcommand("golden", |command| {
            command.after_help(GOLDEN_EXAMPLES).mut_arg("dir", |dir| {
                // Custom scenes need a folder of their own.
                dir.required(false)
                    .hide_default_value(true)
                    .default_value(golden.into_os_string())
                    .default_value_if("scenes", ArgPredicate::IsPresent, None)
            })
        })
        .mut_subcommand("completions", |command| command.after_help(COMPLETIONS_EXAMPLES));
    child::add_to(program)
}

/// Loads a scene for a measurement.
fn named(scene: &str, load: &rotund::LoadArgs) -> anyhow::Result<(String, Scene)> {
    let named = rotund::load(scene.as_ref(), load)?;
    Ok((named.name, named.scene))
}

impl Command {
    fn run(self, program: clap::Command) -> anyhow::Result<()> {
        match self {
            Self::Rotund(command) => command.run(program),
            Self::Accuracy(AccuracyArgs { accuracy, load }) => {
                rotund_study::accuracy::run(accuracy, &|scene| named(scene, &load))
            }
            Self::Rays(RaysArgs { rays, load }) => {
                rotund_study::rays::run(rays, &|scene| named(scene, &load))
            }
            Self::Moved(args) => moved::run(args),
            Self::FarmCheck(args) => farm_check::run(args),
            Self::Tidy(args) => tidy::run(args),
        }
    }
}

/// Parses `arguments` (the first names the program), runs the command, reports failure on
/// standard error and returns the exit code.
pub fn main(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> ExitCode {
    let arguments: Vec<OsString> = arguments.into_iter().map(Into::into).collect();
    if let Some(code) = child::run(&arguments) {
        return code;
    }
    rotund::check_environment();
    rotund::report(run(arguments))
}

/// Runs a command as [`main`] does, but returns the error instead of printing it.
///
/// # Errors
///
/// What the command line or the command itself complains about.
pub fn run(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> anyhow::Result<()> {
    let mut program = program();
    let matches = program.try_get_matches_from_mut(arguments)?;
    match Cli::from_arg_matches(&matches)?.command {
        Some(command) => command.run(program),
        None => Ok(program.print_help()?),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Parses a command line and returns the command.
    fn parse(line: &str) -> Result<Command, clap::Error> {
        let matches = program().try_get_matches_from(line.split_whitespace())?;
        Ok(Cli::from_arg_matches(&matches)?.command.expect("the line has a command"))
    }

    #[test]
    fn every_command_of_the_program_is_passed_on() {
        program().debug_assert();
        let rotund = [
            "compare",
            "render",
            "view",
            "merge",
            "diff",
            "noise",
            "info",
            "golden",
            "completions",
        ];
        let names: Vec<_> = program().get_subcommands().map(|c| c.get_name().to_owned()).collect();
        for name in rotund {
            assert!(names.iter().any(|found| found == name), "{name}");
        }
        assert!(matches!(parse("xtask compare shapes4"), Ok(Command::Rotund(_))));
        assert!(matches!(parse("xtask tidy"), Ok(Command::Tidy(_))));
    }

    #[test]
    fn help_names_cargo_xtask_and_fits_in_80_columns() {
        let mut program = program().term_width(80);
        program.build();
        for command in program.get_subcommands_mut().filter(|c| c.get_name() != "help") {
            let name = command.get_name().to_owned();
            let help = command.render_long_help().to_string();
            assert!(help.contains(&format!("Usage: cargo xtask {name}")), "{help}");
            assert!(!help.contains("  rotund "), "{help}");
            for line in help.lines() {
                assert!(line.chars().count() <= 80, "{name}: {line}");
            }
        }
    }

    #[test]
    fn golden_takes_the_pictures_of_the_workspace_unless_told_otherwise() {
        let folder = |line: &str| -> Option<String> {
            let matches = program().try_get_matches_from(line.split_whitespace()).ok()?;
            let (_, golden) = matches.subcommand()?;
            let folder = golden.get_one::<std::path::PathBuf>("dir")?;
            Some(folder.to_string_lossy().into_owned())
        };
        assert!(folder("xtask golden").is_some_and(|folder| folder.ends_with("tests/golden")));
        assert_eq!(folder("xtask golden --dir mine a.json").as_deref(), Some("mine"));
        assert_eq!(folder("xtask golden a.json"), None, "refused without --dir");
    }
}
