//! What the page must do, each as a function that drives it.

use crate::chromium::Chromium;
use crate::page::Page;
use crate::viewer::Viewer;
use anyhow::{Result, ensure};
use std::path::Path;

mod camera;
mod connection;
mod files;
mod picture;
mod reach;

/// A check of the program at a path.
pub(crate) type Check = fn(&Path, &Chromium) -> Result<()>;

/// All checks with their names.
pub(crate) const ALL: [(&str, Check); 20] = [
    ("a picture comes and is finished", picture::comes),
    ("each check box changes the picture, and back", picture::boxes),
    ("the wipe shows vanilla left and enhanced right", picture::wipe),
    ("views, exposure and background change the picture", picture::views),
    ("the saved PNG has the pixels that are shown", picture::save),
    ("the command of a long render makes the same picture", picture::command),
    ("noise is removed beside the plain picture, or the page says why not", picture::denoise),
    ("a drag orbits, a right drag pans, the wheel zooms", camera::mouse),
    ("fingers orbit, pan and zoom", camera::fingers),
    ("a double click focuses; lens, cameras and frame all", camera::controls),
    ("the inspector follows the pointer and is pinned", camera::inspector),
    ("a reload and a link show the same view", connection::reload),
    ("two pages have their own cameras", connection::two),
    ("a socket cut in mid-drag opens again with the same view", connection::cut),
    ("the end of the viewer is said", connection::end),
    ("a broken edit of the scene is said, and mended", files::edit),
    ("a deleted scene is said, and a new one shown", files::delete),
    ("a picture of 20,000 pixels is reduced", files::huge),
    ("everything is reached by keyboard", reach::keyboard),
    ("every control has a name, and nothing is loaded from elsewhere", reach::names),
];

/// Opens a page with few samples, and waits until they are there.
fn open(chromium: &Chromium, viewer: &Viewer, samples: u32) -> Result<Page> {
    let page = chromium.open(&viewer.url)?;
    page.wait("a state", "epoch() > 0")?;
    page.evaluate(&format!("set('samples', {samples})"))?;
    page.wait("the samples", &format!("rotundStatistics.state.settings.samples === {samples}"))?;
    page.wait_done()?;
    Ok(page)
}

/// Does something that changes the picture, and waits until the new one is there; returns its
/// hash.
fn after(page: &Page, action: impl FnOnce() -> Result<()>) -> Result<f64> {
    let before = page.string("mark()")?;
    action()?;
    page.wait("another picture", &format!("mark() !== '{before}'"))?;
    page.wait_done()?;
    page.number("hash()")
}

fn after_setting(page: &Page, setting: &str) -> Result<f64> {
    after(page, || page.evaluate(setting).map(drop))
}

/// Returns the position of the camera in the address.
fn eye(page: &Page) -> Result<Vec<f64>> {
    // The address follows within its pause.
    let same = "JSON.stringify(view().camera) === JSON.stringify(rotundStatistics.state.camera)";
    page.wait("the camera in the address", same)?;
    let eye = page.evaluate("eye()")?;
    let eye: Vec<f64> = eye.as_array().into_iter().flatten().filter_map(|x| x.as_f64()).collect();
    ensure!(eye.len() == 3, "the address has no camera");
    Ok(eye)
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}
