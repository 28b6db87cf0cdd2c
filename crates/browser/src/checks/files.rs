//! Scenes that change on disk, and sizes that nobody needs.

use super::{distance, eye, open};
use crate::chromium::Chromium;
use crate::viewer::Viewer;
use anyhow::{Result, ensure};
use std::fs;
use std::path::Path;

/// A scene with a ball of a colour.
fn scene(color: &str) -> String {
    format!(
        r#"{{
    "asset": {{ "version": "4.2" }},
    "cameras": [{{ "name": "front", "frame": [1,0,0, 0,1,0, 0,0,1, 0,0,3] }}],
    "environments": [{{ "emission": [1, 1, 1] }}],
    "materials": [{{ "name": "ball", "type": "matte", "color": {color} }}],
    "shapes": [{{ "name": "ball", "uri": "ball.ply" }}],
    "instances": [{{ "name": "ball", "shape": 0, "material": 0 }}]
}}"#
    )
}

const BALL: &str = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
    property float z\nproperty float radius\nend_header\n0 0 0 0.5\n";

pub(super) fn edit(program: &Path, chromium: &Chromium) -> Result<()> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("scene.json");
    fs::write(folder.path().join("ball.ply"), BALL)?;
    fs::write(&path, scene("[0.8, 0.1, 0.1]"))?;
    let viewer = Viewer::start(program, &path)?;
    let page = open(chromium, &viewer, 1)?;
    page.drag(page.middle("#picture")?, [5.0, 1.0], 10)?;
    page.wait_done()?;
    let (red, camera) = (page.number("hash()")?, eye(&page)?);
    fs::write(&path, scene("\"red\""))?;
    page.wait("a message", "notices().includes('materials[0].color')")?;
    ensure!(page.number("hash()")? == red, "the last good picture is gone");
    fs::write(&path, scene("[0.1, 0.1, 0.8]"))?;
    page.wait("no message", "notices() === ''")?;
    page.wait("another picture", &format!("isDone() && hash() !== {red}"))?;
    ensure!(distance(&camera, &eye(&page)?) == 0.0, "the new scene moves the camera");
    fs::write(folder.path().join("ball.ply"), BALL.replace("0.5", "0.3"))?;
    let blue = page.number("hash()")?;
    page.wait("a smaller ball", &format!("isDone() && hash() !== {blue}"))
}

pub(super) fn delete(program: &Path, chromium: &Chromium) -> Result<()> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("ball.ply");
    fs::write(&path, BALL)?;
    let viewer = Viewer::start(program, &path)?;
    let page = open(chromium, &viewer, 1)?;
    let picture = page.number("hash()")?;
    fs::remove_file(&path)?;
    page.wait("a message", "notices().includes('ball.ply')")?;
    ensure!(page.number("hash()")? == picture, "the last good picture is gone");
    fs::write(&path, BALL.replace("0.5", "0.25"))?;
    page.wait("no message", "notices() === ''")?;
    page.wait("another picture", &format!("isDone() && hash() !== {picture}"))
}

pub(super) fn huge(program: &Path, chromium: &Chromium) -> Result<()> {
    let viewer = Viewer::start(program, "shapes4")?;
    let page = open(chromium, &viewer, 1)?;
    page.evaluate("set('pixels', 20000); set('size', 'camera')")?;
    page.wait("a message", "notices().includes('20000')")?;
    page.wait("a reduced picture", "rotundStatistics.state.width < 5000")?;
    page.evaluate("set('pixels', 100)")?;
    let small = "Math.max(find('picture').width, find('picture').height) === 100 && isDone()";
    page.wait("a small picture", small)
}
