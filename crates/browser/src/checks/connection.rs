//! Pages that come back, several of them, and a connection that is cut.

use super::{after, after_setting, distance, eye, open};
use crate::chromium::Chromium;
use crate::proxy::Proxy;
use crate::viewer::Viewer;
use anyhow::{Result, ensure};
use std::path::Path;
use std::thread::sleep;
use std::time::Duration;

pub(super) fn reload(program: &Path, chromium: &Chromium) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let page = open(chromium, &viewer, 2)?;
    page.drag(page.middle("#picture")?, [7.0, 2.0], 15)?;
    let picture = after_setting(&page, "set('lines', false)")?;
    let camera = eye(&page)?;
    page.reload()?;
    page.wait_done()?;
    ensure!(distance(&camera, &eye(&page)?) == 0.0, "a reload moves the camera");
    ensure!(page.number("hash()")? == picture, "a reload shows another picture");
    let link = page.string("location.href")?;
    let other = chromium.open(&link)?;
    other.wait_done()?;
    ensure!(other.number("hash()")? == picture, "a link shows another picture");
    Ok(())
}

pub(super) fn two(program: &Path, chromium: &Chromium) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let first = open(chromium, &viewer, 1)?;
    let (camera, picture) = (eye(&first)?, first.number("hash()")?);
    let second = open(chromium, &viewer, 1)?;
    let moved = after(&second, || second.drag(second.middle("#picture")?, [8.0, 0.0], 15))?;
    ensure!(moved != picture, "the second page does not move");
    ensure!(distance(&camera, &eye(&second)?) > 0.01, "the camera of the second page rests");
    after_setting(&second, "set('points', false)")?;
    sleep(Duration::from_millis(300));
    ensure!(distance(&camera, &eye(&first)?) == 0.0, "the camera of the first page has moved");
    ensure!(first.number("hash()")? == picture, "the picture of the first page has changed");
    Ok(())
}

pub(super) fn cut(program: &Path, chromium: &Chromium) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let tunnel = Proxy::start(viewer.port()?)?;
    let page = chromium.open(&viewer.url_at(tunnel.port)?)?;
    page.wait("a state", "epoch() > 0")?;
    page.evaluate("set('samples', 1)")?;
    page.wait("a sample", "rotundStatistics.state.settings.samples === 1")?;
    let [x, y] = page.middle("#picture")?;
    page.mouse("mousePressed", [x, y], "left")?;
    for step in 1..20 {
        page.mouse("mouseMoved", [x + 5.0 * f64::from(step), y], "left")?;
        sleep(Duration::from_millis(16));
    }
    page.wait("movement", "rotundStatistics.previews.length > 2")?;
    let camera = page.string("JSON.stringify(rotundStatistics.state.camera.frame)")?;
    tunnel.cut();
    page.wait("a message", "notices().includes('connection is lost')")?;
    let lost = page.string("JSON.stringify(rotundStatistics.state.camera.frame)")?;
    ensure!(lost == camera || !lost.is_empty(), "the state is lost");
    page.wait("no message", "notices() === ''")?;
    page.mouse("mouseReleased", [x, y], "left")?;
    page.wait_done()?;
    let after = page.string("JSON.stringify(rotundStatistics.state.camera.frame)")?;
    ensure!(after == lost, "the camera is {after} after the cut, not {lost}");
    // It goes on.
    page.drag([x, y], [5.0, 0.0], 10)?;
    let moved = format!("JSON.stringify(rotundStatistics.state.camera.frame) !== '{after}'");
    page.wait("movement", &moved)
}

pub(super) fn end(program: &Path, chromium: &Chromium) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let page = open(chromium, &viewer, 1)?;
    let picture = page.number("hash()")?;
    drop(viewer);
    page.wait("a message", "notices().includes('connection is lost')")?;
    page.wait("another message", "notices().includes('start it again')")?;
    ensure!(page.number("hash()")? == picture, "the last picture is gone");
    Ok(())
}
