//! The camera in the hand, and what is below the pointer.

use super::{after, after_setting, distance, eye, open};
use crate::chromium::Chromium;
use crate::viewer::Viewer;
use anyhow::{Result, ensure};
use std::path::Path;
use std::thread::sleep;
use std::time::Duration;

/// Returns the axis of the view in the address.
const BACK: &str = "JSON.stringify(view().camera.frame.slice(6, 9))";

pub(super) fn mouse(program: &Path, chromium: &Chromium) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let page = open(chromium, &viewer, 1)?;
    let middle = page.middle("#picture")?;
    let (start, back) = (eye(&page)?, page.string(BACK)?);
    let still = page.number("hash()")?;
    let orbited = after(&page, || page.drag(middle, [6.0, 0.0], 20))?;
    let turned = eye(&page)?;
    ensure!(orbited != still, "an orbit shows the same picture");
    ensure!(distance(&start, &turned) > 0.01, "an orbit does not move the camera");
    ensure!((start[1] - turned[1]).abs() < 1e-3, "an orbit to the side changes the height");
    ensure!(page.string(BACK)? != back, "an orbit does not turn the camera");
    let back = page.string(BACK)?;
    after(&page, || {
        page.mouse("mousePressed", middle, "right")?;
        for step in 1..10 {
            page.mouse("mouseMoved", [middle[0] + 5.0 * f64::from(step), middle[1]], "right")?;
            sleep(Duration::from_millis(16));
        }
        page.mouse("mouseReleased", middle, "right")
    })?;
    let panned = eye(&page)?;
    ensure!(distance(&turned, &panned) > 0.001, "a pan does not move the camera");
    ensure!(page.string(BACK)? == back, "a pan turns the camera");
    after(&page, || page.wheel(middle, -500.0))?;
    let zoomed = eye(&page)?;
    ensure!(distance(&panned, &zoomed) > 0.01, "the wheel does not move the camera");
    ensure!(page.string(BACK)? == back, "the wheel turns the camera");
    after(&page, || page.wheel(middle, 500.0))?;
    let again = eye(&page)?;
    let (there, off) = (distance(&panned, &zoomed), distance(&panned, &again));
    ensure!(off < 0.2 * there, "the wheel leads {off} m away from where it came, of {there} m");
    Ok(())
}

pub(super) fn fingers(program: &Path, chromium: &Chromium) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let page = open(chromium, &viewer, 1)?;
    after(&page, || page.resize(390, 844, 2.0))?;
    let [x, y] = page.middle("#picture")?;
    let pause = || sleep(Duration::from_millis(16));
    let (start, back) = (eye(&page)?, page.string(BACK)?);
    after(&page, || {
        page.touch("touchStart", &[[x, y]])?;
        for step in 1..=12 {
            page.touch("touchMove", &[[x + 6.0 * f64::from(step), y]])?;
            pause();
        }
        page.touch("touchEnd", &[])
    })?;
    let turned = eye(&page)?;
    ensure!(distance(&start, &turned) > 0.01, "a finger does not move the camera");
    ensure!(page.string(BACK)? != back, "a finger does not turn the camera");
    let back = page.string(BACK)?;
    after(&page, || {
        page.touch("touchStart", &[[x - 30.0, y], [x + 30.0, y]])?;
        for step in 1..=12 {
            let apart = 30.0 + 5.0 * f64::from(step);
            page.touch("touchMove", &[[x - apart, y], [x + apart, y]])?;
            pause();
        }
        page.touch("touchEnd", &[])
    })?;
    let zoomed = eye(&page)?;
    ensure!(distance(&turned, &zoomed) > 0.01, "a pinch does not move the camera");
    ensure!(page.string(BACK)? == back, "a pinch turns the camera");
    page.wait("no sheet", "getComputedStyle(find('sections')).display === 'none'")?;
    let [x, y] = page.middle("#sheet")?;
    page.touch("touchStart", &[[x, y]])?;
    page.touch("touchEnd", &[])?;
    page.wait("an open sheet", "getComputedStyle(find('sections')).display !== 'none'")
}

pub(super) fn controls(program: &Path, chromium: &Chromium) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let page = open(chromium, &viewer, 1)?;
    let [x, y] = page.middle("#picture")?;
    let (start, back) = (eye(&page)?, page.string(BACK)?);
    after(&page, || {
        page.click([x - 90.0, y + 60.0])?;
        page.click([x - 90.0, y + 60.0])
    })?;
    ensure!(distance(&start, &eye(&page)?) < 1e-6, "a double click moves the eye");
    ensure!(page.string(BACK)? != back, "a double click does not turn the camera");
    after_setting(&page, "set('field', 20)")?;
    let field = "2 * Math.atan(view().camera.film / view().camera.lens / 2) * 180 / Math.PI";
    eye(&page)?;
    let degrees = page.number(field)?;
    ensure!((degrees - 20.0).abs() < 1e-3, "a field of view of 20 degrees became {degrees}");
    after_setting(&page, "set('aperture', 12.5)")?;
    after_setting(&page, "set('focus', 1.5)")?;
    eye(&page)?;
    let aperture = page.number("view().camera.aperture")?;
    ensure!((aperture - 0.0125).abs() < 1e-6, "an aperture of 12.5 mm became {aperture} m");
    ensure!(page.number("view().camera.focus")? == 1.5, "the focus is not 1.5 m");
    after(&page, || page.click(page.middle("#frame-all")?))?;
    after_setting(&page, "set('cameras', 0)")?;
    ensure!(distance(&start, &eye(&page)?) < 1e-6, "the camera of the scene is another");
    Ok(())
}

pub(super) fn inspector(program: &Path, chromium: &Chromium) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let page = open(chromium, &viewer, 1)?;
    let [x, y] = page.middle("#picture")?;
    let shown = "!find('inspector').hidden";
    page.mouse("mouseMoved", [x, y], "none")?;
    page.wait("the inspector", shown)?;
    for row in ["value", "instance", "shape", "material", "element", "position", "error", "uv"] {
        let has = format!("find('inspector-rows').textContent.includes('{row}')");
        page.wait(&format!("a row {row}"), &has)?;
    }
    let title = page.string("find('inspector-title').textContent")?;
    page.mouse("mouseMoved", [x + 40.0, y], "none")?;
    let title = serde_json::json!(title);
    page.wait("another pixel", &format!("find('inspector-title').textContent !== {title}"))?;
    page.click([x, y])?;
    page.wait("a pin", "find('inspector-mark').textContent === 'pinned'")?;
    page.mouse("mouseMoved", [x + 80.0, y], "none")?;
    sleep(Duration::from_millis(300));
    let pinned = page.string("find('inspector-title').textContent")?;
    ensure!(serde_json::json!(pinned) == title, "the pin is at {pinned}, not at {title}");
    // The method is that of the check boxes.
    let row = "[...find('inspector-rows').rows].find((row) => \
        row.cells[0].textContent === 'element').textContent";
    let before = page.string(row)?;
    ensure!(before.contains("enhanced") || before.contains("triangles"), "the row is {before:?}");
    page.evaluate("find('picture').focus()")?;
    page.press("Escape", "Escape")?;
    page.wait("no pin", "find('pin').hidden")
}
