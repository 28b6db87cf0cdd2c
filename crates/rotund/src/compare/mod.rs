//! `compare <scenes>`: two pictures of a scene that differ in one thing, and what changed.
//!
//! Renders a scene vanilla and enhanced with equal seeds, or enhanced with overlapping elements
//! separate and united. Then the faster render continues until it has taken as long as the other,
//! for a comparison at equal time. The folder of a scene gets both pictures (PNG and EXR),
//! `difference.png`, `flip.png`, `metrics.json` and `report.html`. Several scenes get a page
//! `index.html` above their folders.

use crate::built_in;
use crate::output::{check_distinct, prepare_folder, write_text};
use crate::shot::PictureArgs;
#[cfg(feature = "view")]
use crate::{kinds::Kind, shot::Shot};
use anyhow::{Result, bail};
use comparison::Comparison;
use rotund_report::compare::index::{self, Entry};
use rotund_report::console::say;
#[cfg(feature = "view")]
use rotund_trace::Options;
use serde_json::Value;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use subject::Subject;

mod comparison;
mod subject;

const EXAMPLES: &str = "\
Examples:
  rotund compare shapes4
  rotund compare shapes4 --camera front --samples 256 --resolution 2160
  rotund compare path/to/scene.json --kinds lines --out out/only-lines
  rotund compare vessels --overlap
  rotund compare --all --samples 16";

/// Files in the folder of a scene.
const FILES: [&str; 8] = [
    "vanilla.png",
    "vanilla.exr",
    "enhanced.png",
    "enhanced.exr",
    "difference.png",
    "flip.png",
    "metrics.json",
    "report.html",
];

/// Options of `compare`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Names of built-in scenes, or paths of JSON, PLY, OBJ, SWC, TCK, TRK, XYZ, TXT, CSV,
    /// PTS or ASC files.
    #[arg(value_name = "SCENE", required_unless_present = "all")]
    scenes: Vec<OsString>,
    /// Compare all built-in scenes.
    #[arg(long, conflicts_with = "scenes")]
    all: bool,
    /// The folder to write to; several scenes get a folder each in it. Default: `out/` and the name
    /// of the scene.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Instead of the methods, compare points and lines that keep their whole surfaces where they
    /// overlap with those that are one body. Both pictures are enhanced.
    #[arg(long)]
    overlap: bool,
    /// Do not continue the faster render until both have taken equal time.
    #[arg(long)]
    no_equal_time: bool,
    /// Print the content of `metrics.json` instead of a table, as a list for several scenes.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    picture: PictureArgs,
}

pub(crate) fn run(args: Args) -> Result<()> {
    let names = if args.all {
        built_in::names().map(OsString::from).collect()
    } else {
        args.scenes.clone()
    };
    if let [name] = &names[..] {
        let (metrics, page, _) = one(&args, name, args.out.clone())?;
        return if args.json {
            say(serde_json::to_string_pretty(&metrics)?)
        } else {
            say(format!("\nopen {}", page.display()))
        };
    }
    let folder = args.out.clone().unwrap_or_else(|| PathBuf::from("out"));
    let (mut all, mut entries) = (Vec::new(), Vec::<Entry>::new());
    for name in &names {
        // The folder of a scene is named after it.
        let stem = Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if entries.iter().any(|entry| entry.scene == stem) {
            bail!("two scenes are called {stem:?}: compare them one by one, with --out");
        }
        let (metrics, _, entry) = one(&args, name, Some(folder.join(&stem)))?;
        all.push(metrics);
        entries.push(entry);
    }
    let page = folder.join("index.html");
    write_text(&page, &index::page(Subject::pair_of(args.overlap), &entries))?;
    if args.json {
        say(serde_json::to_string_pretty(&Value::Array(all))?)
    } else {
        say(format!("\nopen {}", page.display()))
    }
}

/// Returns the page about two films of a scene, the first vanilla, the second with these kinds
/// enhanced.
#[cfg(feature = "view")]
pub(crate) fn page_of(
    scene: &str,
    camera: &str,
    options: &Options,
    kinds: Vec<Kind>,
    shots: [Shot; 2],
) -> Result<String> {
    Comparison::new(scene, camera, options, Subject::new(false, kinds), shots)?.report()
}

/// Compares one scene and prints its table; returns its metrics, its page and its card in the
/// index.
fn one(args: &Args, name: &OsStr, folder: Option<PathBuf>) -> Result<(Value, PathBuf, Entry)> {
    let (mut scene, camera, options) = args.picture.load(name)?;
    let folder = folder.unwrap_or_else(|| Path::new("out").join(&scene.name));
    let files = FILES.map(|name| folder.join(name));
    let outputs: Vec<_> = files.iter().map(|path| ("--out", path.as_path())).collect();
    check_distinct(&outputs, &scene.files)?;
    prepare_folder(&folder)?;
    let subject = Subject::new(args.overlap, args.picture.kinds.kinds());
    let equal_time = !args.no_equal_time;
    let comparison = args.picture.shot.with_threads(|| {
        Comparison::render(&mut scene, camera, &options, subject, equal_time, &folder)
    })?;
    comparison.write(&folder)?;
    if !args.json {
        say(comparison.table().to_string())?;
    }
    Ok((comparison.metrics(), folder.join("report.html"), comparison.entry()?))
}
