//! The page without a mouse, without eyes, and without the rest of the network.

use super::{after, distance, eye, open};
use crate::chromium::Chromium;
use crate::viewer::Viewer;
use anyhow::{Result, ensure};
use std::path::Path;
use std::time::Duration;

pub(super) fn keyboard(program: &Path, chromium: &Chromium) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let page = open(chromium, &viewer, 1)?;
    let mut seen = vec![page.number("hash()")?];
    let held = Duration::from_millis(150);
    for (key, code) in [
        ("ArrowRight", "ArrowRight"),
        ("ArrowUp", "ArrowUp"),
        ("w", "KeyW"),
        ("d", "KeyD"),
        ("e", "KeyE"),
        ("-", "Minus"),
        ("1", "Digit1"),
        ("2", "Digit2"),
        ("3", "Digit3"),
    ] {
        let hash = after(&page, || page.key(key, code, held))?;
        ensure!(!seen.contains(&hash), "the key {key} shows a picture from before");
        seen.push(hash);
    }
    let before = eye(&page)?;
    after(&page, || page.press("f", "KeyF"))?;
    ensure!(distance(&before, &eye(&page)?) > 0.01, "F does not move the camera");
    page.press("?", "Slash")?;
    page.wait("help", "find('help-dialog').open")?;
    page.press("Escape", "Escape")?;
    page.wait("no help", "!find('help-dialog').open")?;
    page.press("i", "KeyI")?;
    page.wait("a pin", "document.activeElement === find('pin')")?;
    page.wait("the inspector", "!find('inspector').hidden")?;
    let title = page.string("find('inspector-title').textContent")?;
    page.press("ArrowRight", "ArrowRight")?;
    page.wait("the next pixel", &format!("find('inspector-title').textContent !== '{title}'"))?;
    page.press("Escape", "Escape")?;
    page.wait("no pin", "find('pin').hidden")?;
    // Tab reaches every control that is shown, and what has the focus is seen to have it.
    page.evaluate("document.activeElement.blur(); window.reached = new Set()")?;
    for _ in 0..60 {
        page.press("Tab", "Tab")?;
        page.evaluate("reached.add(document.activeElement)")?;
    }
    let missed = page.string(
        "[...document.querySelectorAll('button, input, select, summary, [tabindex]')]\
         .filter((it) => it.checkVisibility() && !it.disabled && !reached.has(it))\
         .map((it) => it.id || it.name || it.textContent).join()",
    )?;
    ensure!(missed.is_empty(), "Tab does not reach {missed}");
    Ok(())
}

pub(super) fn names(program: &Path, chromium: &Chromium) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let page = open(chromium, &viewer, 1)?;
    let nameless = page.string(
        "[...document.querySelectorAll('button, input, select, canvas, progress, [role]')]\
         .filter((it) => !it.getAttribute('aria-label') && !it.labels?.length \
             && !it.textContent.trim() && !['alert'].includes(it.getAttribute('role')))\
         .map((it) => it.outerHTML.slice(0, 60)).join()",
    )?;
    ensure!(nameless.is_empty(), "no name: {nameless}");
    let foreign = page.string(
        "performance.getEntriesByType('resource').map((it) => it.name)\
         .filter((name) => !name.startsWith(location.href.split('#')[0]) \
             && !name.startsWith('data:')).join()",
    )?;
    ensure!(foreign.is_empty(), "loaded from elsewhere: {foreign}");
    let asked = page.evaluate("fetch('https://example.org/').then(() => true, () => false)")?;
    ensure!(asked == false, "the page may talk to other sites");
    Ok(())
}
