//! `accuracy`: speed against error of every intersector, the library's own and the published ones.
//!
//! Rays of families that are hard for a known reason are solved in 106 bits, by formulas that share
//! nothing with the code under test, and every method is compared with that. The command prints
//! tables for each shape and writes a report that opens offline. It exists so that each claim about
//! accuracy or speed can be checked.

mod case;
mod leaving;
mod methods;
mod overview;
mod placed;
mod progress;
mod replay;
mod report;
mod round_trip;
mod sheets;
mod study;
mod tally;
mod targets;
mod timing;
mod unions;

use std::{
    fs,
    io::Write as _,
    path::{Path, PathBuf},
};

use self::progress::Progress;
use anyhow::{Context, Result, bail, ensure};
use rotund_report::console::say;
use rotund_scene::Scene;

const EXAMPLES: &str = "\
Examples:
  cargo xtask accuracy --out out/accuracy
  cargo xtask accuracy --shape cone --family grazing --method Rotund --no-timing
  cargo xtask accuracy --seed 7 --check
  cargo xtask accuracy --round-trip 10000000
  cargo xtask accuracy --unions 10000000
  cargo xtask accuracy --unions 1000000 neuron.swc";

/// Options of `accuracy`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Measure only shapes with this in their name: sphere, cone, patch; may be repeated.
    #[arg(long, value_name = "NAME")]
    shape: Vec<String>,
    /// Measure only families with this in their name; may be repeated.
    #[arg(long, value_name = "NAME")]
    family: Vec<String>,
    /// Measure only methods with this in their name; may be repeated.
    #[arg(long, value_name = "NAME")]
    method: Vec<String>,
    /// Rays of each family and level; 25 times as many are aimed at each kind of joint between
    /// shapes.
    #[arg(long, default_value_t = 10_000, value_name = "COUNT")]
    rays: u64,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write all measurements to this JSON file.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the report, index.html, to this folder.
    #[arg(long, value_name = "DIR", default_value = "out/accuracy")]
    out: PathBuf,
    /// Fail if one of the library's own methods misses a target, or a hit of an instance its bound,
    /// and list each row that does.
    #[arg(long)]
    check: bool,
    /// Print one case of a report with the answer of every method.
    #[arg(long, value_name = "CASE", exclusive = true)]
    replay: Option<String>,
    /// Only compare so many hits, of all elements in frames of every kind, with the point and the
    /// normal that their parameters evaluate to.
    #[arg(
        long,
        value_name = "COUNT",
        conflicts_with_all = ["shape", "family", "method", "rays", "json", "check", "replay", "no_timing"]
    )]
    round_trip: Option<u64>,
    /// Only compare the boundaries of unions along so many rays, and so many points in them, with
    /// depth counting in 106 bits: of sets of balls and cones, and of the points and lines of the
    /// scenes that are given.
    #[arg(
        long,
        value_name = "COUNT",
        conflicts_with_all = [
            "shape", "family", "method", "rays", "json", "check", "replay", "no_timing", "round_trip"
        ]
    )]
    unions: Option<u64>,
    /// Scenes or lone files for --unions.
    #[arg(value_name = "SCENE", requires = "unions")]
    scenes: Vec<String>,
    /// Do not measure time.
    #[arg(long)]
    no_timing: bool,
}

/// Runs the command. `load` loads the scene of a name or path, and returns its name too.
///
/// # Errors
///
/// If no row has the names given, a file cannot be written, or a target is missed with `--check`.
pub fn run(args: Args, load: &dyn Fn(&str) -> Result<(String, Scene)>) -> Result<()> {
    if let Some(case) = &args.replay {
        return replay::run(case);
    }
    if let Some(count) = args.round_trip {
        return round_trip::run(count, args.seed);
    }
    if let Some(count) = args.unions {
        let scenes = args.scenes.iter().map(|scene| load(scene)).collect::<Result<Vec<_>>>()?;
        return unions::run(count, args.seed, &scenes);
    }
    ensure!(args.rays > 0, "--rays must be at least 1");
    let options = study::Options {
        shapes: args.shape,
        families: args.family,
        methods: args.method,
        rays: args.rays,
        seed: args.seed,
        timing: !args.no_timing,
    };
    let rows = options.row_count();
    ensure!(
        rows > 0,
        "no row has the names given; the rows are\n{}",
        study::Options::all_rows().join("\n")
    );
    let progress = Progress::new(rows);
    let study = study::run(&options, &progress);
    progress.finish();
    ensure!(
        !study.shapes.is_empty(),
        "no method of these shapes has the name given with --method; expected one of {}",
        options.all_methods().join(", ")
    );
    let mut verdicts = targets::verdicts(&study);
    // Hits of instances belong to no family, and to the library's own method.
    if options.families.is_empty() && !verdicts.is_empty() {
        let is_measured = |shape: &str| study.shapes.iter().any(|it| it.shape == shape);
        verdicts.extend(placed::verdicts(options.rays, options.seed, is_measured));
    }
    ensure!(
        !args.check || !verdicts.is_empty(),
        "nothing to check: --method leaves out the library's own methods"
    );
    overview::print(&study, &verdicts)?;
    if let Some(path) = &args.json {
        let all = serde_json::json!({ "study": study, "targets": verdicts });
        write(path, &serde_json::to_string_pretty(&all)?)?;
    }
    let page = args.out.join("index.html");
    write(&page, &report::page(&study, &verdicts, &options)?)?;
    say(format!("\nreport: {}", page.display()))?;
    let missed: Vec<_> = verdicts.iter().filter(|v| !v.met).collect();
    if args.check && !missed.is_empty() {
        for verdict in &missed {
            say(format!("\n{}, {}, limit {}:", verdict.shape, verdict.what, verdict.limit))?;
            for miss in &verdict.misses {
                say(format!("  {miss}"))?;
            }
        }
        bail!("{} of {} targets are missed", missed.len(), verdicts.len());
    }
    Ok(())
}

/// Writes a file atomically, and creates its folder if there is none.
fn write(path: &Path, text: &str) -> Result<()> {
    let folder = path.parent().filter(|d| !d.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(folder)
        .with_context(|| format!("cannot create the folder {}", folder.display()))?;
    rotund_image::write_with(path, |file| file.write_all(text.as_bytes()))?;
    Ok(())
}
