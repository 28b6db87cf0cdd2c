//! `tidy`: prints what `rotund-tidy` finds in the workspace, and fails if there is anything.

use crate::workspace;
use anyhow::{Result, bail};
use rotund_report::console::say;

/// Options of `tidy`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}

pub(crate) fn run(_: Args) -> Result<()> {
    let checked = rotund_tidy::check(&workspace::root())?;
    for finding in &checked.findings {
        say(finding)?;
    }
    match checked.findings.len() {
        0 => say(format!("{} files are tidy", checked.files)),
        1 => bail!("1 thing is not tidy"),
        count => bail!("{count} things are not tidy"),
    }
}
