//! How fast the page answers, by its own clock, and what the viewer takes.

use crate::chromium::Chromium;
use crate::page::Page;
use crate::spheres;
use crate::viewer::Viewer;
use anyhow::{Context as _, Result, bail};
use rotund_report::console::{Table, say};
use std::ffi::OsStr;
use std::path::Path;
use std::process::Command;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Spheres of the largest scene.
const SPHERES: u32 = 1_000_000;
/// How long a drag takes that is measured.
const DRAG: Duration = Duration::from_secs(4);
/// Samples of the picture by which refinement is compared with a render.
const REFINED: u32 = 24;
/// Refinements in turn with renders.
const PAIRS: u64 = 5;
/// How long the viewer is watched when it has nothing to do.
const REST: Duration = Duration::from_secs(5);
/// How long the hand moves between two rests, and how long it rests, while memory is watched.
const STRETCH: Duration = Duration::from_millis(1200);
const PAUSE: Duration = Duration::from_millis(300);
/// How long the drag takes whose memory is measured with all else.
const SHORT_DRAG: Duration = Duration::from_secs(15);
/// Parts of a drag after which memory is measured.
const PARTS: u32 = 10;
/// Factor of the memory from the first part of a drag to its end beyond which something piles up:
/// room for buffers whose size depends on what the camera sees.
const MOST_GROWTH: f64 = 1.1;

/// Measures three scenes and prints a table, and then the memory of a drag.
pub(crate) fn run(program: &Path, chromium: &Chromium) -> Result<()> {
    let folder = tempfile::tempdir()?;
    let spheres = spheres::write(folder.path(), SPHERES)?;
    let mut table = Table::new(&[
        "milliseconds",
        "page",
        "first",
        "previews/s",
        "input",
        "95 %",
        "box",
        "idle %",
        "refining",
    ]);
    for scene in [OsStr::new("shapes4"), OsStr::new("shapes3"), spheres.as_os_str()] {
        table.row(measure(program, chromium, scene, folder.path())?);
    }
    say(format!("\n{table}"))?;
    memory(program, chromium, SHORT_DRAG)
}

fn measure(
    program: &Path,
    chromium: &Chromium,
    scene: &OsStr,
    folder: &Path,
) -> Result<Vec<String>> {
    let viewer = Viewer::start(program, scene)?;
    {
        // The first page waits for the scene to be loaded; the second is measured.
        let page = chromium.open(&viewer.url)?;
        page.wait_for("a picture", "rotundStatistics.frames > 0", Duration::from_secs(60))?;
    }
    sleep(Duration::from_millis(500));
    let page = chromium.open(&viewer.url)?;
    page.resize(1366, 768, 1.0)?;
    page.wait("a picture", "rotundStatistics.firstPicture !== null")?;
    let asked = page.number("rotundStatistics.asked")?;
    let first = page.number("rotundStatistics.firstPicture")? - asked;
    sleep(Duration::from_secs(1));
    drag(&page, DRAG)?;
    sleep(Duration::from_millis(500));
    let mut inputs = numbers(&page, "Object.values(rotundStatistics.inputs)")?;
    let previews = numbers(&page, "rotundStatistics.previews")?;
    // Previews that follow each other, without the pause before the drag.
    let gaps: Vec<f64> = previews.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let moving: Vec<f64> = gaps.into_iter().filter(|gap| *gap < 400.0).collect();
    let rate = 1000.0 * moving.len() as f64 / moving.iter().sum::<f64>().max(1.0);
    for _ in 0..5 {
        for name in ["points", "lines", "quads"] {
            page.evaluate(&format!("find('settings').elements.{name}.click()"))?;
            sleep(Duration::from_millis(400));
        }
    }
    let mut boxes = numbers(&page, "rotundStatistics.settings")?;
    page.evaluate("set('samples', 2)")?;
    page.wait_done()?;
    sleep(Duration::from_millis(500));
    let before = viewer.processor_seconds()?;
    sleep(REST);
    let idle = (viewer.processor_seconds()? - before) / REST.as_secs_f64();
    let name = Path::new(scene).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = if name == "spheres" { format!("{SPHERES} spheres") } else { name };
    Ok(vec![
        name,
        format!("{asked:.0}"),
        format!("{first:.0}"),
        format!("{rate:.1}"),
        format!("{:.0}", quantile(&mut inputs, 0.5)),
        format!("{:.0}", quantile(&mut inputs, 0.95)),
        format!("{:.0}", quantile(&mut boxes, 0.5)),
        format!("{:.2}", 100.0 * idle),
        format!("{:.2}", refinement(program, &page, folder)?),
    ])
}

/// Returns the samples per second of the viewer over those of a render of the same picture: the
/// median of pairs of runs in turn, so that what else the machine does counts for both.
fn refinement(program: &Path, page: &Page, folder: &Path) -> Result<f64> {
    page.evaluate("set('pixels', 320); set('size', 'camera')")?;
    page.wait("another size", "Math.max(find('picture').width, find('picture').height) === 320")?;
    page.evaluate(&format!("set('samples', {REFINED})"))?;
    let mut ratios = Vec::new();
    for seed in 1..=PAIRS {
        page.evaluate(&format!("set('seed', {seed})"))?;
        page.wait("the seed", &format!("rotundStatistics.state.settings.seed === {seed}"))?;
        let is_done = "rotundStatistics.status.activity === 'done' \
            && rotundStatistics.status.epoch === rotundStatistics.state.epoch";
        // Whoever asks all the time takes time.
        while page.evaluate(is_done)? != true {
            sleep(Duration::from_millis(250));
        }
        let viewer = page.number("rotundStatistics.status.seconds")?;
        ratios.push(render(program, page, folder)? / viewer);
    }
    Ok(quantile(&mut ratios, 0.5))
}

/// Returns the seconds of a render of what the page shows.
fn render(program: &Path, page: &Page, folder: &Path) -> Result<f64> {
    page.evaluate("find('long-render').click()")?;
    page.wait("the command", "find('text-dialog').open && find('text').value !== ''")?;
    let line = page.string("find('text').value")?;
    page.evaluate("find('text-dialog').close(); find('text').value = ''")?;
    let words = line.strip_prefix("rotund").context("a command of the program")?;
    let mut shell = Command::new("sh");
    shell.current_dir(folder).arg("-c").arg(format!("'{}'{words}", program.display()));
    let output = shell.output()?;
    let said = String::from_utf8_lossy(&output.stdout);
    let seconds = said.split(" samples in ").nth(1).and_then(|rest| rest.split(' ').next());
    Ok(seconds.with_context(|| format!("{line} prints {said:?}"))?.parse()?)
}

/// Drags in a circle.
fn drag(page: &Page, time: Duration) -> Result<()> {
    let [x, y] = page.middle("#picture")?;
    page.mouse("mousePressed", [x, y], "left")?;
    let start = Instant::now();
    while start.elapsed() < time {
        let (sine, cosine) = (3.0 * start.elapsed().as_secs_f64()).sin_cos();
        page.mouse("mouseMoved", [x + 120.0 * sine, y + 40.0 * cosine], "left")?;
        sleep(Duration::from_millis(14));
    }
    page.mouse("mouseReleased", [x, y], "left")
}

/// Prints the memory of the viewer during a drag: first without a rest, then with pauses; fails if
/// it grows.
pub(crate) fn memory(program: &Path, chromium: &Chromium, time: Duration) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let page = chromium.open(&viewer.url)?;
    page.wait("a picture", "rotundStatistics.frames > 0")?;
    // Room for a whole picture belongs to the memory of before.
    sleep(Duration::from_secs(2));
    let mut table = Table::new(&["minutes of dragging", "MB"]);
    let mut first = None;
    let mut last = 0.0;
    for part in 1..=PARTS {
        match first {
            None => drag(&page, time / PARTS)?,
            Some(_) => drag_and_rest(&page, time / PARTS)?,
        }
        last = viewer.memory()?;
        first.get_or_insert(last);
        let minutes = time.as_secs_f64() / 60.0 * f64::from(part) / f64::from(PARTS);
        table.row(vec![format!("{minutes:.1}"), format!("{:.1}", last / 1e6)]);
    }
    say(format!("\nmemory of the viewer of shapes4\n{table}"))?;
    if first.is_none_or(|first| last > first * MOST_GROWTH) {
        bail!("the memory of the viewer grows while it is dragged: it must stay the same");
    }
    Ok(())
}

/// Drags in circles with rests in between, so that refinements begin and are interrupted.
fn drag_and_rest(page: &Page, time: Duration) -> Result<()> {
    let start = Instant::now();
    while start.elapsed() < time {
        drag(page, STRETCH)?;
        sleep(PAUSE);
    }
    Ok(())
}

fn numbers(page: &Page, expression: &str) -> Result<Vec<f64>> {
    let values = page.evaluate(expression)?;
    let values = values.as_array().context("a list")?;
    Ok(values.iter().filter_map(|value| value.as_f64()).collect())
}

fn quantile(values: &mut [f64], part: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let index = (part * (values.len() as f64 - 1.0)).round();
    values.get(index.max(0.0) as usize).copied().unwrap_or(f64::NAN)
}
