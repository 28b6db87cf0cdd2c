//! `farm-check`: do renders that are killed, interrupted and spread over a farm keep every bit?
//!
//! Renders a picture in one run. Then renders it again in ways that a farm does, and compares the
//! bytes of the EXR files:
//!
//! - in one process that is killed at random moments and started again;
//! - as shards, each a process of this machine, of which one is interrupted in the middle;
//! - by GNU parallel, with the line of `docs/large-renders.md`;
//! - as an array job of Slurm, with the script of `docs/large-renders.md`, of which one task is put
//!   back into the queue in the middle; a second job merges after the first one.
//!
//! Nothing is installed or configured. Where GNU parallel or Slurm is absent, the command says so.

use anyhow::{Context as _, Result, bail, ensure};
use rotund_report::console::say;
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Instant;

mod local;
mod page;
mod slurm;

const EXAMPLES: &str = "\
Examples:
  cargo xtask farm-check
  cargo xtask farm-check --kills 50 --samples 512";

/// Options of `farm-check`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The scene to render.
    #[arg(default_value = "shapes4")]
    scene: String,
    /// Samples per pixel.
    #[arg(long, default_value_t = 256, value_parser = clap::value_parser!(u32).range(4..))]
    samples: u32,
    /// Pixels along the longer side.
    #[arg(long, default_value_t = 160)]
    resolution: u32,
    /// How often a render is killed.
    #[arg(long, default_value_t = 10)]
    kills: u32,
    /// The folder to work in, which every node of the farm must see; it is emptied before.
    #[arg(long, value_name = "DIR", default_value = "out/farm-check")]
    out: PathBuf,
}

pub(crate) fn run(args: Args) -> Result<()> {
    let farm = Farm::new(&args)?;
    let start = Instant::now();
    farm.succeed(farm.render().args(["--out", "plain.exr"]))?;
    local::kill(&farm, args.kills, start.elapsed())?;
    local::shards(&farm)?;
    local::parallel(&farm)?;
    slurm::array(&farm)
}

/// The folder that all renders work in, and what they render.
struct Farm {
    folder: PathBuf,
    /// Scene and options that decide the picture.
    picture: Vec<String>,
    /// The search path with a folder in front that has this program under the name `rotund`.
    path: std::ffi::OsString,
}

impl Farm {
    fn new(args: &Args) -> Result<Self> {
        rotund::prepare_folder(&args.out)?;
        let folder = args.out.canonicalize()?;
        for entry in fs::read_dir(&folder)? {
            let path = entry?.path();
            if path.is_dir() { fs::remove_dir_all(&path)? } else { fs::remove_file(&path)? }
        }
        let programs = folder.join("bin");
        fs::create_dir(&programs)?;
        // This program has all commands of `rotund`.
        fs::copy(env::current_exe()?, programs.join("rotund"))
            .context("cannot copy the program")?;
        let others = env::var_os("PATH").unwrap_or_default();
        let path = env::join_paths([programs].into_iter().chain(env::split_paths(&others)))?;
        let [samples, resolution] = [args.samples, args.resolution].map(|n| n.to_string());
        let picture = [&args.scene, "--samples", &samples, "--resolution", &resolution];
        Ok(Self { folder, picture: picture.map(ToOwned::to_owned).to_vec(), path })
    }

    /// Returns a command that runs in the folder.
    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.current_dir(&self.folder).env("PATH", &self.path).stdin(Stdio::null());
        command
    }

    /// Returns the command that renders the picture, without the file to write.
    fn render(&self) -> Command {
        let mut command = self.command("rotund");
        command.arg("render").args(&self.picture);
        command
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Runs a command that must succeed; returns what it printed.
    fn succeed(&self, command: &mut Command) -> Result<String> {
        let Output { status, stdout, stderr } =
            command.output().with_context(|| format!("cannot start {command:?}"))?;
        if !status.success() {
            bail!("{command:?}: {status}: {}", String::from_utf8_lossy(&stderr));
        }
        Ok(String::from_utf8_lossy(&stdout).trim().to_owned())
    }

    /// Returns true if a program is on the search path.
    fn has(&self, program: &str) -> bool {
        env::split_paths(&self.path).any(|folder| folder.join(program).is_file())
    }

    /// Compares a picture with the one that was rendered in one run, and prints that it is equal.
    fn compare(&self, name: &str, how: &str) -> Result<()> {
        let [plain, other] = ["plain.exr", name].map(|name| fs::read(self.path(name)));
        ensure!(plain? == other?, "{how}: {name} is not plain.exr");
        let left = files_of_killed_runs(&self.folder)?;
        ensure!(left.is_empty(), "{how}: temporary files are left: {left:?}");
        say(format!("{how}: equal to the bit"))
    }
}

fn files_of_killed_runs(folder: &Path) -> Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        if name.starts_with(".rotund-") {
            names.push(name);
        }
    }
    Ok(names)
}
