//! `completions SHELL`: a script that teaches a shell the commands and their options.

use anyhow::Result;
use clap_complete::Shell;
use rotund_report::console::say;

const EXAMPLES: &str = "\
Examples:
  rotund completions zsh > ~/.zfunc/_rotund
  rotund completions fish > ~/.config/fish/completions/rotund.fish

For bash, in ~/.bashrc:
  source <(rotund completions bash)";

/// Options of `completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The shell.
    shell: Shell,
}

/// Prints the script for `program`, under the name that it has as a clap command.
pub(crate) fn run(args: &Args, mut program: clap::Command) -> Result<()> {
    let mut script = Vec::new();
    let name = program.get_name().to_owned();
    clap_complete::generate(args.shell, &mut program, name, &mut script);
    say(String::from_utf8(script)?.trim_end())
}
