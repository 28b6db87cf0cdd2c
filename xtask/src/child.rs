//! Commands that run as programs of their own, so that no other command compiles what they need: a
//! server and a client of WebSockets.

use crate::workspace;
use std::env;
use std::ffi::OsString;
use std::process::{Command, ExitCode};

/// A command of `xtask` that is a program.
struct Program {
    name: &'static str,
    about: &'static str,
    package: &'static str,
    /// Arguments before those of the person.
    arguments: &'static [&'static str],
}

const PROGRAMS: [Program; 2] = [
    Program {
        name: "view",
        about: "Show a scene in the browser, where it can be turned and switched",
        package: "rotund",
        arguments: &["view"],
    },
    Program {
        name: "browser-test",
        about: "Drive the viewer in headless Chromium, check and measure it",
        package: "rotund-browser",
        arguments: &[],
    },
];

/// Adds the commands to a command line, for its help.
pub(crate) fn add_to(program: clap::Command) -> clap::Command {
    PROGRAMS.iter().fold(program, |program, child| {
        if program.find_subcommand(child.name).is_some() {
            // A build of the whole workspace has the viewer in the program.
            return program;
        }
        let arguments = clap::Arg::new("arguments").num_args(0..).allow_hyphen_values(true);
        let arguments = arguments.trailing_var_arg(true).help("What `--help` lists");
        program.subcommand(clap::Command::new(child.name).about(child.about).arg(arguments))
    })
}

/// Runs the program that the arguments ask for (the first names `xtask`); `None` if they ask for
/// none of these.
pub(crate) fn run(arguments: &[OsString]) -> Option<ExitCode> {
    let name = arguments.get(1)?;
    let child = PROGRAMS.iter().find(|child| name == child.name)?;
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.args(["run", "--quiet", "--release", "--package", child.package]);
    command.args(["--bin", child.package, "--manifest-path"]);
    command.arg(workspace::root().join("Cargo.toml"));
    command.arg("--").args(child.arguments).args(&arguments[2..]);
    Some(replace_by(command))
}

/// Becomes that program, so that signals and exit codes are its own.
#[cfg(unix)]
fn replace_by(mut command: Command) -> ExitCode {
    use std::os::unix::process::CommandExt as _;
    rotund::report(Err(anyhow::Error::from(command.exec()).context("cannot run cargo")))
}

#[cfg(not(unix))]
fn replace_by(mut command: Command) -> ExitCode {
    match command.status() {
        Ok(status) => ExitCode::from(u8::try_from(status.code().unwrap_or(1)).unwrap_or(1)),
        Err(error) => rotund::report(Err(anyhow::Error::from(error).context("cannot run cargo"))),
    }
}
