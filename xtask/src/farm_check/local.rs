//! Renders on this machine that are killed and interrupted.

use super::{Farm, page};
use anyhow::{Context as _, Result, bail, ensure};
use rotund_report::console::say;
use rotund_trace::output::load_film;
use std::fs;
use std::hash::{BuildHasher as _, RandomState};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Longest time that something may take that takes milliseconds.
const PATIENCE: Duration = Duration::from_secs(120);
/// Shards of the picture.
const SHARDS: u32 = 3;

/// Kills a render so often, each time at a random moment of the time that an undisturbed one takes,
/// and lets the last one finish.
pub(super) fn kill(farm: &Farm, kills: u32, undisturbed: Duration) -> Result<()> {
    let mut render = farm.render();
    render.args(["--checkpoint", "killed.film", "--checkpoint-every", "0", "--resume"]);
    render.args(["--out", "killed.exr"]).stdout(Stdio::null()).stderr(Stdio::null());
    let film = farm.path("killed.film");
    let random = RandomState::new();
    let longest = undisturbed.as_millis().max(1) as u64;
    let (mut killed, mut finished, mut grown, mut last) = (0, 0, 0, 0);
    while killed < kills {
        let mut child = render.spawn()?;
        sleep(Duration::from_millis(random.hash_one((killed, finished)) % longest));
        child.kill()?;
        if child.wait()?.success() {
            // Too late: it starts from nothing.
            finished += 1;
            fs::remove_file(&film)?;
            last = 0;
            continue;
        }
        killed += 1;
        if film.exists() {
            // No kill leaves a film that cannot be read, or that has lost samples.
            let samples = load_film(&film)?.most_samples();
            ensure!(samples >= last, "{samples} samples after {last}");
            grown += u32::from(samples > last);
            last = samples;
        }
    }
    farm.succeed(&mut render)?;
    say(format!(
        "killed {killed} times, {grown} times with new samples; {finished} came too late"
    ))?;
    farm.compare("killed.exr", "killed at random moments and resumed")
}

/// Renders all shards at once, interrupts one by SIGTERM, and merges before and after it goes on.
pub(super) fn shards(farm: &Farm) -> Result<()> {
    let shard = |index: u32| {
        let mut render = farm.render();
        render.args([
            "--shard",
            &format!("{index}/{SHARDS}"),
            "--checkpoint",
            "local-{shard}.film",
        ]);
        render.args(["--checkpoint-every", "0", "--resume"]).stdout(Stdio::null());
        render
    };
    let merge = || {
        let mut merge = farm.command("rotund");
        merge.arg("merge").args((1..=SHARDS).map(|index| format!("local-{index}.film")));
        merge
    };
    let spawn = |index| shard(index).stderr(Stdio::null()).spawn();
    let mut children = (1..=SHARDS).map(spawn).collect::<Result<Vec<Child>, _>>()?;
    let start = Instant::now();
    while !farm.path("local-2.film").exists() {
        ensure!(start.elapsed() < PATIENCE, "the second shard writes no checkpoint");
        sleep(Duration::from_millis(1));
    }
    interrupt(&mut children[1])?;
    let codes: Vec<_> = children.iter_mut().map(|c| Ok(c.wait()?.code())).collect::<Result<_>>()?;
    ensure!(codes == [Some(0), Some(130), Some(0)], "the shards exit with {codes:?}");
    let early = merge().args(["--out", "early.exr"]).output()?;
    let message = String::from_utf8_lossy(&early.stderr).trim().to_owned();
    ensure!(early.status.code() == Some(4), "merge of an unfinished shard: {message}");
    say(format!("merge before it is finished: {message}"))?;
    farm.succeed(merge().args(["--partial", "--out", "preview.png"]))?;
    farm.succeed(&mut shard(2))?;
    farm.succeed(merge().args(["--out", "local.exr"]))?;
    farm.compare("local.exr", "shards of which one was interrupted by SIGTERM")
}

/// Sends SIGTERM.
fn interrupt(child: &mut Child) -> Result<()> {
    let kill = Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
    ensure!(kill.context("cannot start `kill`")?.success(), "the shard has finished already");
    Ok(())
}

/// Runs the line of the page for GNU parallel, if it is there.
pub(super) fn parallel(farm: &Farm) -> Result<()> {
    if !farm.has("parallel") {
        return say("GNU parallel is not installed: left out");
    }
    let block = page::example("parallel ")?;
    let mut lines = block.lines().filter(|line| line.starts_with("parallel "));
    let Some(line) = lines.next() else { bail!("the page has no line of GNU parallel") };
    let line = line.replace("shapes4 --samples 4096", &farm.picture.join(" "));
    farm.succeed(farm.command("sh").args(["-c", &line]))?;
    farm.succeed(farm.command("sh").args(["-c", "rotund merge shard-*.film --out parallel.exr"]))?;
    for entry in fs::read_dir(&farm.folder)? {
        let path = entry?.path();
        if path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("shard-")) {
            fs::remove_file(path)?;
        }
    }
    farm.compare("parallel.exr", "GNU parallel")
}
