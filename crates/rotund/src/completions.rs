//! `completions SHELL`: a script that teaches a shell the commands and their options.
//!
//! `cargo xtask` is an alias of cargo, which completes its own words; so the script is for a name of
//! its own, `xtask`, that stands for the same.

use anyhow::Result;
use clap::CommandFactory as _;
use clap_complete::Shell;
use rotund_report::console::say;

const EXAMPLES: &str = "\
Examples:
  cargo xtask completions zsh > ~/.zfunc/_xtask

For bash, both lines in ~/.bashrc:
  alias xtask='cargo xtask'
  source <(cargo xtask completions bash)";

/// Options of `completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The shell.
    shell: Shell,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let mut script = Vec::new();
    let mut command = crate::Cli::command().name(NAME).bin_name(NAME);
    clap_complete::generate(args.shell, &mut command, NAME, &mut script);
    say(String::from_utf8(script)?.trim_end())
}

const NAME: &str = "xtask";
