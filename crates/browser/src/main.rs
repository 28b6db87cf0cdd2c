//! Drives the page of `rotund view` in headless Chromium: checks what it does, measures how fast it
//! answers, and takes pictures of it.
//!
//! A crate of its own, so that no other command compiles a client for WebSockets. It knows the
//! viewer as a person does: by its command line and its page.

use crate::chromium::Chromium;
use crate::viewer::Viewer;
use anyhow::{Context as _, Result, bail};
use clap::Parser;
use rotund_report::console::say;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};

mod checks;
mod chromium;
mod devtools;
mod many;
mod measure;
mod page;
mod proxy;
mod screenshots;
mod spheres;
mod viewer;

/// There is no browser, so nothing was tested: the code by which test harnesses know that.
const SKIPPED: u8 = 77;

/// Test and measure the viewer in headless Chromium.
#[derive(Debug, Parser)]
#[command(name = "browser-test", bin_name = "cargo xtask browser-test", version)]
struct Args {
    /// Only the checks, without measurements: what every change must pass.
    #[arg(long)]
    short: bool,
    /// Only the measurements.
    #[arg(long, conflicts_with = "short")]
    measure: bool,
    /// Only the memory of the viewer while it shows this many spheres.
    #[arg(long, value_name = "N", conflicts_with_all = ["short", "measure"])]
    spheres: Option<u32>,
    /// Only the memory of the viewer while a scene is dragged for so many minutes.
    #[arg(
        long,
        value_name = "MINUTES",
        value_parser = minutes,
        conflicts_with_all = ["short", "measure", "spheres"]
    )]
    drag: Option<Duration>,
    /// Only the checks whose names contain this text.
    #[arg(long, value_name = "TEXT", default_value = "")]
    only: String,
    /// The program to test. Default: `rotund` of this workspace, built for release.
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
    /// The folder for screenshots.
    #[arg(long, value_name = "DIR", default_value = "out/browser")]
    out: PathBuf,
}

fn minutes(text: &str) -> Result<Duration, String> {
    let minutes = text.parse().ok().filter(|minutes: &f64| *minutes > 0.0);
    let time = minutes.and_then(|minutes| Duration::try_from_secs_f64(60.0 * minutes).ok());
    time.ok_or_else(|| "a positive number of minutes".to_owned())
}

fn main() -> ExitCode {
    let args = Args::parse();
    let Some(browser) = chromium::find() else {
        let _ = say("skipped: there is no Chromium; `apt install chromium` installs it, or \
             ROTUND_CHROMIUM names it");
        return ExitCode::from(SKIPPED);
    };
    match run(&args, &browser) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = say(format!("failed: {error:#}"));
            ExitCode::FAILURE
        }
    }
}

fn run(args: &Args, browser: &Path) -> Result<()> {
    let program = std::path::absolute(args.program.clone().map_or_else(build, Ok)?)?;
    let chromium = Chromium::start(browser)?;
    if let Some(count) = args.spheres {
        return many::run(&program, &chromium, count);
    }
    if let Some(time) = args.drag {
        return measure::memory(&program, &chromium, time);
    }
    if args.measure {
        return measure::run(&program, &chromium);
    }
    let mut failures = Vec::new();
    let chosen = checks::ALL.iter().filter(|(name, _)| name.contains(&args.only));
    for (name, check) in chosen {
        let start = Instant::now();
        match check(&program, &chromium) {
            Ok(()) => say(format!("ok      {:5.1} s  {name}", start.elapsed().as_secs_f64()))?,
            Err(error) => {
                say(format!("FAILED  {:5.1} s  {name}: {error:#}", start.elapsed().as_secs_f64()))?;
                failures.push(*name);
            }
        }
    }
    if !args.only.is_empty() {
        return verdict(&failures);
    }
    screenshots::take(&program, &chromium, &args.out)?;
    say(format!("screenshots are in {}", args.out.display()))?;
    if !args.short {
        measure::run(&program, &chromium)?;
    }
    verdict(&failures)
}

fn verdict(failures: &[&str]) -> Result<()> {
    match failures.len() {
        0 => Ok(()),
        1 => bail!("a check"),
        count => bail!("{count} checks"),
    }
}

/// Builds the program, and returns its path.
fn build() -> Result<PathBuf> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let arguments = ["build", "--quiet", "--release", "--package", "rotund", "--bin", "rotund"];
    let status = Command::new(cargo).args(arguments).status().context("cannot run cargo")?;
    if !status.success() {
        bail!("the program rotund does not build");
    }
    // This program lies beside it.
    let own = std::env::current_exe()?;
    let program = own.with_file_name(Viewer::PROGRAM);
    if !program.is_file() {
        bail!("cargo made no {}", program.display());
    }
    Ok(program)
}
