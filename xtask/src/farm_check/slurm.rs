//! An array job of Slurm of which one task is put back into the queue.

use super::{Farm, page};
use anyhow::{Result, bail, ensure};
use rotund_report::console::say;
use rotund_trace::output::load_film_header;
use std::collections::BTreeMap;
use std::fs;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Tasks of the array, each one shard.
const TASKS: u32 = 4;
/// Longest time that the jobs may take.
const PATIENCE: Duration = Duration::from_secs(900);

/// Runs the script of the page as an array job, requeues one task while it renders, merges in a
/// second job that waits for the first, and compares.
pub(super) fn array(farm: &Farm) -> Result<()> {
    if !farm.has("sbatch") {
        return say("Slurm is not installed (no sbatch): its array job is left out");
    }
    fs::write(farm.path("shards.sh"), page::example("#SBATCH --array")?)?;
    let mut submit = farm.command("sbatch");
    let array = format!("--array=1-{TASKS}");
    submit.args(["--parsable", &array, "--cpus-per-task=1", "shards.sh"]).args(&farm.picture);
    let job = farm.succeed(submit.args(["--checkpoint-every", "1"]))?;
    let mut merge = farm.command("sbatch");
    merge.args(["--parsable", &format!("--dependency=afterok:{job}"), "--output=merge.log"]);
    merge.args(["--wrap", "rotund merge shard-*.film --out slurm.exr"]);
    let merge = farm.succeed(&mut merge)?;
    say(format!("Slurm: array job {job} of {TASKS} tasks, merge job {merge}"))?;

    let start = Instant::now();
    let mut seen = BTreeMap::new();
    let mut requeued = None;
    loop {
        let states = states(farm, &[&job, &merge])?;
        for (id, state) in &states {
            if seen.get(id) != Some(state) {
                say(format!("{:4} s  {id} {state}", start.elapsed().as_secs()))?;
            }
        }
        match requeued {
            None => requeued = requeue(farm, &job, &states)?,
            Some(task) => start_now(farm, &format!("{job}_{task}"), &states),
        }
        if states.is_empty() {
            break;
        }
        ensure!(start.elapsed() < PATIENCE, "jobs {job} and {merge} do not end: {states:?}");
        seen = states;
        sleep(Duration::from_millis(200));
    }
    let Some(task) = requeued else { bail!("no task was seen in the middle: take more --samples") };
    let log = fs::read_to_string(farm.path(&format!("shard-{task}.log")))?;
    for line in log.lines() {
        say(format!("  shard-{task}.log: {line}"))?;
    }
    ensure!(log.contains("continues from"), "task {task} did not continue from its checkpoint");
    say(format!("  merge.log: {}", fs::read_to_string(farm.path("merge.log"))?.trim()))?;
    farm.compare("slurm.exr", "Slurm, with one task requeued in the middle")
}

/// Returns the states of all tasks that are in the queue, by their names, such as `7_2`.
fn states(farm: &Farm, jobs: &[&str]) -> Result<BTreeMap<String, String>> {
    let mut squeue = farm.command("squeue");
    squeue.args(["--noheader", "--array", "--format=%i %j %T %r"]);
    let lines = farm.succeed(&mut squeue)?;
    let mut states = BTreeMap::new();
    for line in lines.lines() {
        let mut words = line.split_whitespace();
        let (Some(id), Some(_), Some(state)) = (words.next(), words.next(), words.next()) else {
            bail!("squeue says {line:?}");
        };
        let of_job = jobs.iter().any(|job| id.split('_').next() == Some(*job));
        if of_job && state != "COMPLETING" {
            let why = words.next().filter(|&why| why != "None").unwrap_or_default();
            ensure!(why != "DependencyNeverSatisfied", "a shard of job {} failed", jobs.concat());
            states.insert(id.to_owned(), format!("{state} {why}").trim().to_owned());
        }
    }
    Ok(states)
}

/// Puts a running task that has written a checkpoint, but not all samples, back into the queue;
/// returns its number.
fn requeue(farm: &Farm, job: &str, states: &BTreeMap<String, String>) -> Result<Option<u32>> {
    let running = |task: &u32| states.get(&format!("{job}_{task}")).is_some_and(|s| s == "RUNNING");
    let is_within = |task: &u32| {
        load_film_header(farm.path(&format!("shard-{task}.film")))
            .is_ok_and(|header| !header.is_finished())
    };
    let Some(task) = (1..=TASKS).find(|task| running(task) && is_within(task)) else {
        return Ok(None);
    };
    let id = format!("{job}_{task}");
    farm.succeed(farm.command("scontrol").args(["requeue", &id]))?;
    say(format!("        {id} is requeued"))?;
    Ok(Some(task))
}

/// Starts a requeued task, for which Slurm would wait two minutes.
fn start_now(farm: &Farm, id: &str, states: &BTreeMap<String, String>) {
    if states.get(id).is_some_and(|state| state == "PENDING BeginTime") {
        let mut update = farm.command("scontrol");
        // If it is refused, the task starts later.
        let _ = farm.succeed(update.args(["update", &format!("JobId={id}"), "StartTime=now"]));
    }
}
