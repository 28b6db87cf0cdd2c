//! What the picture shows.

use super::{after, after_setting, open};
use crate::chromium::Chromium;
use crate::page::Page;
use crate::viewer::Viewer;
use anyhow::{Context as _, Result, bail, ensure};
use base64::Engine as _;
use std::path::Path;
use std::process::Command;
use std::thread::sleep;
use std::time::Duration;

pub(super) fn comes(program: &Path, chromium: &Chromium) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let page = open(chromium, &viewer, 4)?;
    let colors = "new Set(new Uint32Array(find('picture').getContext('2d')\
        .getImageData(0, 0, find('picture').width, find('picture').height).data.buffer)).size";
    ensure!(page.number(colors)? > 1000.0, "the picture is nearly empty");
    let text = page.string("find('samples').textContent")?;
    ensure!(text == "4 of 4 samples", "the page says {text:?}");
    let title = page.string("document.title")?;
    ensure!(title.starts_with("shapes4"), "the title is {title:?}");
    Ok(())
}

pub(super) fn boxes(program: &Path, chromium: &Chromium) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let page = open(chromium, &viewer, 2)?;
    let exact = page.number("hash()")?;
    for kind in ["points", "lines", "quads"] {
        let click = || page.click(page.middle(&format!("[name={kind}]"))?);
        let vanilla = after(&page, click)?;
        ensure!(vanilla != exact, "vanilla {kind} look the same");
        let again = after(&page, click)?;
        ensure!(again == exact, "{kind} that are exact again look otherwise");
    }
    Ok(())
}

pub(super) fn wipe(program: &Path, chromium: &Chromium) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let page = open(chromium, &viewer, 2)?;
    let exact = page.number("hash()")?;
    for kind in ["points", "lines", "quads"] {
        after_setting(&page, &format!("set('{kind}', false)"))?;
    }
    let vanilla = page.number("hash()")?;
    let halves = [page.number("hash(0, 0.25)")?, page.number("hash(0.75, 1)")?];
    for kind in ["points", "lines", "quads"] {
        after_setting(&page, &format!("set('{kind}', true)"))?;
    }
    let right_half = page.number("hash(0.75, 1)")?;
    ensure!(halves[1] != right_half, "the methods look the same on the right");
    after_setting(&page, "set('wipe', true)")?;
    ensure!(page.number("hash(0, 0.25)")? == halves[0], "the left is not vanilla");
    ensure!(page.number("hash(0.75, 1)")? == right_half, "the right is not enhanced");
    page.evaluate("find('wipe').focus()")?;
    page.press("End", "End")?;
    ensure!(page.number("hash()")? == vanilla, "a line at the right does not show vanilla alone");
    page.press("Home", "Home")?;
    ensure!(page.number("hash()")? == exact, "a line at the left does not show enhanced alone");
    // By hand, from the left edge to the middle.
    let [x, y] = page.middle("#wipe")?;
    page.drag([x, y], [10.0, 0.0], 35)?;
    let line = page.string("find('wipe').getAttribute('aria-valuenow')")?;
    ensure!(line.parse::<f64>()? > 40.0, "the line was dragged to {line} %");
    ensure!(page.number("hash(0, 0.25)")? == halves[0], "the left is not vanilla after a drag");
    Ok(())
}

pub(super) fn views(program: &Path, chromium: &Chromium) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let page = open(chromium, &viewer, 2)?;
    let mut seen = vec![page.number("hash()")?];
    let count = page.number("document.querySelector('[name=view]').options.length")?;
    ensure!(count == 13.0, "there are {count} views");
    for setting in [
        "set('view', 'shading-normal')",
        "set('view', 'method')",
        "set('view', 'error')",
        "set('view', 'path'); set('exposure', 1.5)",
        "set('filmic', 'filmic')",
        "set('exposure', 0); set('filmic', ''); set('background', false)",
        "set('background', true); set('bounces', 2)",
        "set('bounces', 8); set('seed', 7)",
        "set('seed', 0); set('independent', 'independent')",
        "set('independent', ''); set('clamp', 0.5)",
    ] {
        let hash = after_setting(&page, setting)?;
        ensure!(!seen.contains(&hash), "{setting} shows a picture from before");
        seen.push(hash);
    }
    let first = after_setting(&page, "set('clamp', '')")?;
    ensure!(first == seen[0], "the first settings show another picture now");
    Ok(())
}

pub(super) fn save(program: &Path, chromium: &Chromium) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let page = open(chromium, &viewer, 4)?;
    for (name, start) in [
        ("picture.png", &b"\x89PNG"[..]),
        ("picture.exr", b"\x76\x2f\x31\x01"),
        ("report.html", b"<!doctype html>"),
    ] {
        if name == "report.html" {
            after_setting(&page, "set('wipe', true)")?;
        }
        page.evaluate(&format!("document.querySelector('[data-save=\"{name}\"]').click()"))?;
        let extension = name.split('.').next_back().context("an extension")?;
        let path = chromium.downloads.path().join(format!("shapes4.{extension}"));
        let bytes = downloaded(&path).with_context(|| {
            format!("{name}; the page says {:?}", page.string("notices()").unwrap_or_default())
        })?;
        ensure!(bytes.starts_with(start), "{name} is no such file");
        std::fs::remove_file(&path)?;
        if name == "picture.png" {
            let count = differing(&page, &bytes)?;
            ensure!(count == 0.0, "{count} pixels of the PNG differ from those that are shown");
        }
    }
    Ok(())
}

pub(super) fn denoise(program: &Path, chromium: &Chromium) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let page = open(chromium, &viewer, 4)?;
    if page.evaluate("find('settings').elements.denoise.disabled")? == true {
        let named = std::env::var_os("ROTUND_OIDN").is_some_and(|name| !name.is_empty());
        let why = page.string("find('denoise-text').textContent")?;
        ensure!(!named, "the library that ROTUND_OIDN names is not used: {why}");
        ensure!(why.contains("Open Image Denoise") && why.ends_with('.'), "the page says {why:?}");
        ensure!(page.evaluate("find('denoise-text').checkVisibility()")? == true, "it is hidden");
        return Ok(());
    }
    let plain = page.number("hash()")?;
    let click = || page.click(page.middle("[name=denoise]")?);
    click()?;
    let is_denoised = "isDone() && rotundStatistics.shown.chosen.denoised";
    // On a busy machine the library takes many seconds.
    let patience = Duration::from_secs(120);
    page.wait_for("a denoised picture", is_denoised, patience)?;
    let denoised = page.number("hash()")?;
    ensure!(denoised != plain, "the denoised picture has its noise");
    ensure!(page.evaluate("find('denoised').checkVisibility()")? == true, "it is not said");
    let mut sizes = Vec::new();
    for (file, name, is_shown) in
        [("denoised.png", "shapes4.denoised.png", true), ("picture.png", "shapes4.png", false)]
    {
        page.evaluate(&format!("document.querySelector('[data-save=\"{file}\"]').click()"))?;
        let path = chromium.downloads.path().join(name);
        let bytes = downloaded(&path)?;
        std::fs::remove_file(&path)?;
        let count = differing(&page, &bytes)?;
        ensure!((count == 0.0) == is_shown, "{name}: {count} pixels differ from those shown");
        sizes.push(bytes.len());
    }
    ensure!(sizes[0] < sizes[1], "the denoised PNG has {} bytes, the plain {}", sizes[0], sizes[1]);
    click()?;
    page.wait("a plain picture", "isDone() && !rotundStatistics.shown.chosen.denoised")?;
    ensure!(page.number("hash()")? == plain, "the plain picture has changed");
    ensure!(page.evaluate("find('denoised').hidden")? == true, "it is said of the plain picture");
    // While moving, pictures are plain, and the denoised one follows.
    click()?;
    page.drag(page.middle("#picture")?, [9.0, 3.0], 12)?;
    page.wait_for("another picture", is_denoised, patience)?;
    let moved = page.number("hash()")?;
    ensure!(moved != plain && moved != denoised, "the picture is that of before");
    Ok(())
}

/// Returns how many of the pixels of a PNG differ from those that are shown.
fn differing(page: &Page, png: &[u8]) -> Result<f64> {
    let text = base64::engine::general_purpose::STANDARD.encode(png);
    page.number(&format!(
        "differing(new Blob([Uint8Array.from(atob('{text}'), (c) => c.charCodeAt(0))], \
         {{ type: 'image/png' }}))"
    ))
}

/// Returns the content of a file once it is whole.
fn downloaded(path: &Path) -> Result<Vec<u8>> {
    for _ in 0..600 {
        if let Ok(bytes) = std::fs::read(path) {
            return Ok(bytes);
        }
        sleep(Duration::from_millis(50));
    }
    bail!("nothing was saved")
}

pub(super) fn command(program: &Path, chromium: &Chromium) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let page = open(chromium, &viewer, 3)?;
    page.drag(page.middle("#picture")?, [9.0, 3.0], 12)?;
    for setting in ["set('lines', false)", "set('bounces', 4)", "set('seed', 5)"] {
        after_setting(&page, setting)?;
    }
    page.click(page.middle("#long-render")?)?;
    page.wait("the command", "find('text-dialog').open && find('text').value !== ''")?;
    let line = page.string("find('text').value")?;
    let rest = line.strip_prefix("rotund render shapes4 ").context("a render of the scene")?;
    let folder = tempfile::tempdir()?;
    // As a person does: the words are for a shell.
    let mut shell = Command::new("sh");
    shell.current_dir(folder.path()).arg("-c");
    let render = shell.arg(format!("'{}' render shapes4 {rest}", program.display())).output()?;
    let message = String::from_utf8_lossy(&render.stderr);
    ensure!(render.status.success(), "{line}: {message}");
    let bytes = std::fs::read(folder.path().join("shapes4.png"))?;
    let count = differing(&page, &bytes)?;
    ensure!(count == 0.0, "{count} pixels of the render differ from those that are shown ({line})");
    Ok(())
}
