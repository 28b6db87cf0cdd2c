//! `golden`: small pictures checked against stored references.
//!
//! Renders small pictures, compares each with its reference and fails with a page that shows what
//! differs. Pictures are those of the scene files that are named, each by the methods that it asks
//! for; or those of all scene files in the folder of the references, each by both methods.
//!
//! Light is compared by a statistical test, so the check accepts another processor, sampler or
//! order of sums and still sees a change by one percent: see [`rotund_golden::verdict`]. The check
//! renders with other random numbers than the reference, which the test requires. What each camera
//! ray hits has no noise, and one ray that goes wrong is found: see [`rotund_golden::surface`].
//! `--isa all` repeats the check with every instruction set that the trees have code for.
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
use rotund_golden::bless::{Blessed, bless};
use rotund_golden::cases::{self, Case};
use rotund_golden::moments::Moments;
use rotund_golden::page::{self, Failure};
use rotund_golden::reference::Reference;
use rotund_golden::significance::FALSE_ALARMS;
use rotund_golden::verdict::Verdict;
use rotund_golden::{Judged, Outcome, REPLICAS, examine};
use rotund_report::console::{Table, say};
use rotund_trace::{Sequence, output};
use serde_json::json;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
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
    fn sequence(&self) -> Sequence {
        if self.independent { Sequence::Independent } else { Sequence::Sobol }
    }
}

pub(crate) fn run(args: Args) -> Result<()> {
    let folder = args.dir.clone().context("golden needs --dir, the folder of the references")?;
    let all = if args.scenes.is_empty() {
        cases::of_workspace(&folder)?
    } else {
        cases::of_user(&folder, &args.scenes)?
    };
    let dead = cases::dead_references(&folder, &all)?;
    let pictures = all.len();
    let wanted = |case: &Case| args.only.as_ref().is_none_or(|text| case.name.contains(text));
    let cases: Vec<Case> = all.into_iter().filter(wanted).collect();
    if cases.is_empty() {
        bail!("no picture has {:?} in its name", args.only.unwrap_or_default());
    }
    if args.bless {
        let dead = if args.only.is_some() { Vec::new() } else { dead };
        return accept(&cases, &dead, &folder, args.resolution, pictures);
    }
    let isas = instruction_sets(&args.isa)?;
    if let Some(seeds) = args.seeds {
        return count_failures(&cases, &args, isas[0], seeds, pictures);
    }
    check(&cases, &isas, &dead, &args, pictures)
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

fn check(
    cases: &[Case],
    isas: &[Isa],
    dead: &[PathBuf],
    args: &Args,
    pictures: usize,
) -> Result<()> {
    let mut table = Table::new(&HEADINGS);
    let bar = ProgressBar::new((isas.len() * cases.len()) as u64);
    let (mut failures, mut complaints, mut failed) = (Vec::new(), Vec::new(), 0);
    let mut objects = Vec::new();
    let start = Instant::now();
    for (case, &isa) in cases.iter().flat_map(|case| isas.iter().map(move |isa| (case, isa))) {
        let case_start = Instant::now();
        let name = if isas.len() > 1 {
            format!("{} ({})", case.name, isa.name())
        } else {
            case.name.clone()
        };
        match examine(case, args.sequence(), isa, args.seed, pictures)? {
            Outcome::Failed(complaint) => {
                table.row([&case.name, isa.name(), "", "", "", "", "", "FAILED"]);
                objects.push(json!({
                    "picture": case.name, "isa": isa.name(), "passed": false, "complaint": complaint,
                }));
                complaints.push(format!("{name}: {complaint}"));
                failed += 1;
            }
            Outcome::Judged(judged) => {
                let Judged { reference, actual, surface, verdict } = *judged;
                let seconds = case_start.elapsed().as_secs_f64();
                table.row(row(&case.name, isa.name(), seconds, &verdict));
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
                        complaints.push(format!("{name}: {}: {}", finding.check, finding.text));
                    }
                    failures.push(Failure {
                        name,
                        expected: reference.moments.picture(),
                        actual: actual.picture(),
                        surfaces: (!surface.compare(&reference.surface).is_empty())
                            .then_some([reference.surface, surface]),
                        verdict,
                    });
                }
            }
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    for path in dead {
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
        write_page(&args.report, &failures)?;
        hint = format!("; see {}", args.report.display());
    }
    bail!(
        "{failed} of {} pictures failed, {} references are dead{hint}; if the change is meant, add \
         --bless",
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
fn count_failures(
    cases: &[Case],
    args: &Args,
    isa: Isa,
    seeds: u32,
    pictures: usize,
) -> Result<()> {
    let mut table = Table::new(&["picture", "runs", "failed", "light, sigma", "smallest chance"]);
    let bar = ProgressBar::new(cases.len() as u64 * u64::from(seeds));
    let mut failed_runs = vec![false; seeds as usize];
    let mut texts = Vec::new();
    for case in cases {
        let (mut failed, mut squares, mut smallest) = (0, 0.0, f64::INFINITY);
        for run in 0..seeds {
            let seed = args.seed.saturating_add(run);
            match examine(case, args.sequence(), isa, seed, pictures)? {
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
                        let (check, text) = (finding.check, finding.text);
                        texts.push(format!("seed {seed}: {}: {check}: {text}", case.name));
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

/// Renders the references anew, prints what changed and removes dead ones.
fn accept(
    cases: &[Case],
    dead: &[PathBuf],
    folder: &Path,
    resolution: u32,
    pictures: usize,
) -> Result<()> {
    fs::create_dir_all(folder)
        .with_context(|| format!("cannot create the folder {}", folder.display()))?;
    let mut refused = 0;
    for case in cases {
        let name = &case.name;
        // A reference that cannot be read is replaced as if there were none.
        let old = Reference::read(&case.reference).ok();
        match bless(case, old.as_ref(), resolution, pictures) {
            Ok(Blessed::Unchanged) => say(format!("{name}: unchanged"))?,
            Ok(Blessed::New(reference)) => {
                reference.write(&case.reference)?;
                say(format!("{name}: new, {}", summary(&reference)))?;
            }
            Ok(Blessed::Changed(reference, findings)) => {
                reference.write(&case.reference)?;
                say(format!("{name}: changed, {}", summary(&reference)))?;
                for finding in findings {
                    say(format!("  {}: {}", finding.check, finding.text))?;
                }
            }
            Err(error) => {
                refused += 1;
                say(format!("{name}: refused: {error:#}"))?;
            }
        }
    }
    for path in dead {
        fs::remove_file(path).with_context(|| format!("cannot remove {}", path.display()))?;
        say(format!("{}: removed, for it belongs to no scene", path.display()))?;
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

fn write_page(path: &Path, failures: &[Failure]) -> Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)
            .with_context(|| format!("cannot create the folder {}", folder.display()))?;
    }
    let html = page::page(failures)?;
    output::write_with(path, |file| file.write_all(html.as_bytes()))?;
    Ok(())
}
