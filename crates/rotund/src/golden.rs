//! `golden`: small pictures checked against stored references.
//!
//! Renders small pictures, compares each with its reference and fails with a page that shows what
//! differs. Pictures are those of the scene files that are named, each by the methods that it asks
//! for; or those of all scene files in the folder of the references, each by both methods.
//!
//! Light is compared by a statistical test, so the check accepts another processor, sampler or
//! order of sums and still sees a change by one percent: see [`rotund_golden`]. The check renders
//! with other random numbers than the reference, which the test requires. What each camera ray hits
//! has no noise, and one ray that goes wrong is found. `--isa all` repeats the check with every
//! instruction set that the trees have code for.
//!
//! # Golden pictures of your own scenes
//!
//! ```sh
//! rotund golden --dir goldens --bless a.json b.json   # once; commit goldens/
//! rotund golden --dir goldens a.json b.json           # in every build
//! ```

use anyhow::{Context, Result, bail};
use indicatif::ProgressBar;
use rotund_bvh::Isa;
use rotund_golden::{
    Blessed, Case, FALSE_ALARMS, GoldenError, Judged, Moments, Outcome, REPLICAS, Reference,
    Settings, Suite, Verdict, write_page,
};
use rotund_report::console::{Table, say};
use rotund_trace::Sequence;
use serde_json::json;
use std::fs;
use std::path::PathBuf;
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  rotund golden --dir goldens --bless a.json b.json
  rotund golden --dir goldens a.json b.json
  rotund golden --dir folder-of-scenes-and-references --isa all";

/// Options of `golden`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Scene files to check pictures of, each by the methods that it asks for. Without any: all
    /// scene files in the folder of the references, each by both methods.
    #[arg(requires = "dir")]
    scenes: Vec<PathBuf>,
    /// Folder of the references; `--bless` makes it if need be.
    #[arg(long, required = true)]
    dir: Option<PathBuf>,
    /// Accept the pictures as they are now, and print what changed.
    #[arg(long)]
    bless: bool,
    /// Check only pictures whose names contain this.
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Pixels along the longer side of a picture that is accepted.
    #[arg(long, requires = "bless", default_value_t = 96)]
    #[arg(value_parser = clap::value_parser!(u32).range(16..=1024))]
    resolution: u32,
    /// Seed of the random numbers; 0 is that of the references.
    #[arg(long, default_value_t = 1, conflicts_with = "bless")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    seed: u32,
    /// Check with this many seeds, from --seed on, and count how often each picture fails.
    #[arg(long, value_name = "COUNT", conflicts_with = "bless")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1000))]
    seeds: Option<u32>,
    /// Render with independent random numbers instead of Sobol points; the check must accept both.
    #[arg(long, conflicts_with = "bless")]
    independent: bool,
    /// Instruction sets to traverse trees with, or `all` that this processor has. Default: the one
    /// that the environment variable ROTUND_ISA names, else the fastest.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', conflicts_with = "bless")]
    isa: Vec<String>,
    /// Print a JSON list with an object for each picture instead of a table.
    #[arg(long, conflicts_with_all = ["bless", "seeds"])]
    json: bool,
    /// The page to write about pictures that differ.
    #[arg(long, value_name = "FILE.html", default_value = "out/golden/report.html")]
    report: PathBuf,
}

impl Args {
    fn settings(&self, isa: Isa, seed: u32) -> Settings {
        let sequence = if self.independent { Sequence::Independent } else { Sequence::Sobol };
        Settings { isa, sequence, seed }
    }
}

pub(crate) fn run(args: Args) -> Result<()> {
    let folder = args.dir.clone().context("golden needs --dir, the folder of the references")?;
    let mut suite =
        if args.scenes.is_empty() { Suite::of_folder(folder)? } else { Suite::new(folder) };
    for scene in &args.scenes {
        suite.add_file(scene)?;
    }
    suite.resolution = args.resolution;
    let wanted = |case: &&Case| args.only.as_ref().is_none_or(|text| case.name.contains(text));
    let cases: Vec<&Case> = suite.cases().iter().filter(wanted).collect();
    if cases.is_empty() {
        bail!("no picture has {:?} in its name", args.only.unwrap_or_default());
    }
    if args.bless {
        return accept(&suite, &cases, args.only.is_none());
    }
    let isas = instruction_sets(&args.isa)?;
    if let Some(seeds) = args.seeds {
        return count_failures(&suite, &cases, &args, isas[0], seeds);
    }
    check(&suite, &cases, &isas, &args)
}

fn instruction_sets(names: &[String]) -> Result<Vec<Isa>> {
    if names.is_empty() {
        return Ok(vec![Isa::default_set()]);
    }
    if names.iter().any(|name| name == "all") {
        return Ok(Isa::available());
    }
    names.iter().map(|name| Ok(name.parse()?)).collect()
}

fn check(suite: &Suite, cases: &[&Case], isas: &[Isa], args: &Args) -> Result<()> {
    let dead = suite.dead_references()?;
    let mut table = Table::new(&HEADINGS);
    let bar = ProgressBar::new((isas.len() * cases.len()) as u64);
    let (mut failures, mut complaints, mut failed) = (Vec::new(), Vec::new(), 0);
    let mut objects = Vec::new();
    let start = Instant::now();
    for (&case, &isa) in cases.iter().flat_map(|case| isas.iter().map(move |isa| (case, isa))) {
        let case_start = Instant::now();
        let name = if isas.len() > 1 {
            format!("{} ({})", case.name, isa.name())
        } else {
            case.name.clone()
        };
        match suite.examine(case, &args.settings(isa, args.seed))? {
            Outcome::Failed(complaint) => {
                table.row([&case.name, isa.name(), "", "", "", "", "", "FAILED"]);
                objects.push(json!({
                    "picture": case.name,
                    "isa": isa.name(),
                    "passed": false,
                    "complaint": complaint,
                }));
                complaints.push(format!("{name}: {complaint}"));
                failed += 1;
            }
            Outcome::Judged(judged) => {
                let Judged { reference, verdict, .. } = judged.as_ref();
                let seconds = case_start.elapsed().as_secs_f64();
                table.row(row(&case.name, isa.name(), seconds, verdict));
                let findings = verdict.findings.iter();
                let findings: Vec<_> = findings
                    .map(|found| json!({ "check": found.check.to_string(), "text": found.text }))
                    .collect();
                objects.push(json!({
                    "picture": case.name,
                    "isa": isa.name(),
                    "passed": findings.is_empty(),
                    "samples": REPLICAS * reference.samples,
                    "seconds": seconds,
                    "energy": verdict.energy,
                    "flip": verdict.flip,
                    "flip_limit": verdict.flip_limit,
                    "smallest_p": verdict.smallest_p,
                    "findings": findings,
                }));
                if !verdict.findings.is_empty() {
                    failed += 1;
                    for finding in &verdict.findings {
                        complaints.push(format!("{name}: {finding}"));
                    }
                    failures.extend(judged.into_failure(name));
                }
            }
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    for path in &dead {
        complaints.push(format!("{} is the reference of no scene", path.display()));
    }
    if args.json {
        say(serde_json::to_string_pretty(&objects)?)?;
    } else {
        say(table.to_string())?;
    }
    if complaints.is_empty() {
        if args.json {
            return Ok(());
        }
        let sets: Vec<&str> = isas.iter().map(|isa| isa.name()).collect();
        let seconds = start.elapsed().as_secs_f64();
        return say(format!("{} pictures in {seconds:.1} s by {}", cases.len(), sets.join(", ")));
    }
    for complaint in complaints.iter().filter(|_| !args.json) {
        say(complaint)?;
    }
    let mut hint = String::new();
    if !failures.is_empty() {
        write_page(&args.report, &failures, "golden --bless")?;
        hint = format!("; see {}", args.report.display());
    }
    bail!(
        "{failed} of {} pictures failed, {} references belong to no scene{hint}; if the change is \
         intended, add --bless",
        isas.len() * cases.len(),
        dead.len()
    )
}

const HEADINGS: [&str; 8] = ["picture", "isa", "s", "light", "FLIP", "limit", "chance", ""];

fn row(name: &str, isa: &str, seconds: f64, verdict: &Verdict) -> [String; 8] {
    [
        name.to_owned(),
        isa.to_owned(),
        format!("{seconds:.1}"),
        format!("{:+.2} %", 100.0 * verdict.energy),
        format!("{:.4}", verdict.flip),
        format!("{:.4}", verdict.flip_limit),
        chance(verdict.smallest_p),
        if verdict.findings.is_empty() { "ok" } else { "FAILED" }.to_owned(),
    ]
}

/// Writes the smallest p-value of all tests of one kind. A check fails if it is below a third of
/// [`FALSE_ALARMS`].
fn chance(verdict_p: f64) -> String {
    if verdict_p >= 0.1 { format!("{verdict_p:.1}") } else { format!("{verdict_p:.0e}") }
}

/// Checks every picture with many seeds and counts the false alarms.
fn count_failures(suite: &Suite, cases: &[&Case], args: &Args, isa: Isa, seeds: u32) -> Result<()> {
    let mut table = Table::new(&["picture", "runs", "failed", "light, sigma", "smallest chance"]);
    let bar = ProgressBar::new(cases.len() as u64 * u64::from(seeds));
    let mut failed_runs = vec![false; seeds as usize];
    let mut texts = Vec::new();
    for &case in cases {
        let (mut failed, mut squares, mut smallest) = (0, 0.0, f64::INFINITY);
        for run in 0..seeds {
            let seed = args.seed.saturating_add(run);
            match suite.examine(case, &args.settings(isa, seed))? {
                Outcome::Failed(complaint) => bail!("{}: {complaint}", case.name),
                Outcome::Judged(judged) => {
                    let verdict = judged.verdict;
                    squares += verdict.energy_t * verdict.energy_t;
                    smallest = smallest.min(verdict.smallest_p);
                    if !verdict.findings.is_empty() {
                        failed += 1;
                        failed_runs[run as usize] = true;
                    }
                    for finding in verdict.findings {
                        texts.push(format!("seed {seed}: {}: {finding}", case.name));
                    }
                }
            }
            bar.inc(1);
        }
        let sigma = format!("{:.2}", (squares / f64::from(seeds)).sqrt());
        table.row([
            case.name.clone(),
            seeds.to_string(),
            failed.to_string(),
            sigma,
            chance(smallest),
        ]);
    }
    bar.finish_and_clear();
    say(table.to_string())?;
    for text in &texts {
        say(text)?;
    }
    let failed = failed_runs.iter().filter(|&&failed| failed).count();
    say(format!(
        "{failed} of {seeds} runs failed; by chance at most {FALSE_ALARMS} of all runs should"
    ))
}

/// Renders the references anew and prints what changed. Removes those of no scene if asked to.
fn accept(suite: &Suite, cases: &[&Case], remove_dead: bool) -> Result<()> {
    let mut refused = 0;
    for &case in cases {
        let name = &case.name;
        match suite.accept(case) {
            Ok(Blessed::Unchanged) => say(format!("{name}: unchanged"))?,
            Ok(Blessed::New(reference)) => say(format!("{name}: new, {}", summary(&reference)))?,
            Ok(Blessed::Changed(reference, findings)) => {
                say(format!("{name}: changed, {}", summary(&reference)))?;
                for finding in findings {
                    say(format!("  {finding}"))?;
                }
            }
            Err(GoldenError::Refused(refusal)) => {
                refused += 1;
                for (name, reason) in refusal.pictures {
                    say(format!("{name}: refused: {reason}"))?;
                }
            }
            Err(error) => {
                refused += 1;
                say(format!("{name}: refused: {:#}", anyhow::Error::new(error)))?;
            }
        }
    }
    let dead = if remove_dead { suite.dead_references()? } else { Vec::new() };
    for path in dead {
        fs::remove_file(&path).with_context(|| format!("cannot remove {}", path.display()))?;
        say(format!("{}: removed, because it belongs to no scene", path.display()))?;
    }
    if refused > 0 {
        bail!("{refused} of {} pictures were refused; their references are as before", cases.len());
    }
    Ok(())
}

fn summary(reference: &Reference) -> String {
    let Moments { width, height, replicas, .. } = reference.moments;
    format!("{width} x {height} pixels, {} samples", replicas * reference.samples)
}
