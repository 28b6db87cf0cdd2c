//! How much memory the viewer takes for a large scene while all is done with it that a page can do.

use crate::chromium::Chromium;
use crate::page::Page;
use crate::spheres;
use crate::viewer::Viewer;
use anyhow::{Context as _, Result};
use rotund_report::console::say;
use std::fs::File;
use std::path::Path;
use std::time::{Duration, SystemTime};

/// Longer than any picture or reload takes.
const PATIENCE: Duration = Duration::from_secs(900);

/// Views this many spheres by all methods and from all sides, and reads them again.
pub(crate) fn run(program: &Path, chromium: &Chromium, count: u32) -> Result<()> {
    let folder = tempfile::tempdir()?;
    let file = spheres::write(folder.path(), count)?;
    let viewer = Viewer::start(program, &file)?;
    let page = chromium.open(&viewer.url)?;
    page.resize(1366, 768, 1.0)?;
    page.wait_for("a picture", "rotundStatistics.frames > 0", PATIENCE)?;
    tell(&viewer, &format!("{count} spheres loaded"))?;
    page.evaluate("set('samples', 2)")?;
    page.wait("the samples", "rotundStatistics.state.settings.samples === 2")?;
    finished(&page)?;
    page.drag(page.middle("#picture")?, [9.0, 3.0], 60)?;
    finished(&page)?;
    page.mouse("mouseMoved", page.middle("#picture")?, "none")?;
    page.wait_for("the inspector", "!find('inspector').hidden", PATIENCE)?;
    for setting in [
        "set('points', false)",
        "set('points', true)",
        "set('overlap', 'union')",
        "set('overlap', 'separate')",
        "set('view', 'error')",
        "set('view', 'path'); set('wipe', true)",
    ] {
        let before = page.string("mark()")?;
        page.evaluate(setting)?;
        page.wait("another picture", &format!("mark() !== '{before}'"))?;
        finished(&page)?;
    }
    tell(&viewer, "looked at from all sides, by both methods")?;
    let before = page.string("mark()")?;
    File::options().append(true).open(&file)?.set_modified(SystemTime::now())?;
    page.wait_for("the scene again", &format!("mark() !== '{before}'"), PATIENCE)?;
    finished(&page)?;
    tell(&viewer, "read again after a change of the file")
}

fn finished(page: &Page) -> Result<()> {
    page.wait_for("all samples", "isDone()", PATIENCE)
}

fn tell(viewer: &Viewer, what: &str) -> Result<()> {
    let peak = viewer.peak().context("the largest memory")?;
    say(format!("{what}: at most {:.2} GB so far", peak / 1e9))
}
