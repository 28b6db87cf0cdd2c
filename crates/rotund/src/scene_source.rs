//! Which scene a command is about, and what can be picked in it.

use crate::workspace;
use anyhow::{Context, Result, anyhow, bail};
use rotund_scene::{LoadOptions, LoadProblem, Loaded, Scene};
use std::path::{Path, PathBuf};

/// A scene and what to call it.
#[derive(Debug)]
pub struct NamedScene {
    /// The name of the file without its extension.
    pub name: String,
    pub scene: Scene,
}

/// What to allow and what to bear with while loading.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct LoadArgs {
    /// Radius in meters of the points and lines of a lone PLY or OBJ file, instead of its own radii or half
    /// the usual distance between neighbours.
    #[arg(long, value_name = "METERS", value_parser = radius)]
    radius: Option<f32>,
    /// Take what cannot be read of textures as white, and say so, instead of giving up.
    #[arg(long)]
    keep_going: bool,
    /// Let the scene name files outside its own folder: only for scenes that you trust.
    #[arg(long)]
    allow_outside: bool,
}

fn radius(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(radius) if radius > 0.0 && f32::is_finite(radius) => Ok(radius),
        _ => Err("a radius is a positive number of meters".to_owned()),
    }
}

impl LoadArgs {
    /// As the library takes them.
    pub fn options(&self) -> LoadOptions {
        LoadOptions {
            allow_outside_folder: self.allow_outside,
            keep_going: self.keep_going,
            radius: self.radius,
        }
    }
}

/// Loads a scene: the name of one that comes with the workspace, or the path of a JSON, PLY or OBJ file. What is
/// odd about it but no error goes to standard error.
#[expect(clippy::print_stderr, reason = "warnings are for the person, not for a pipe")]
pub fn load(name_or_path: &str, args: &LoadArgs) -> Result<NamedScene> {
    let (name, loaded) = load_silently(name_or_path, args)?;
    for warning in &loaded.warnings {
        eprintln!("warning: {warning}");
    }
    if loaded.scene.cameras.is_empty() {
        bail!("{name}: the scene has neither a camera nor anything to see");
    }
    Ok(NamedScene { name, scene: loaded.scene })
}

/// Loads a scene and its name, and leaves warnings to the caller.
pub fn load_silently(name_or_path: &str, args: &LoadArgs) -> Result<(String, Loaded)> {
    let path = locate(name_or_path)?;
    // The text of a load error already tells its cause, so the chain would say it twice.
    let loaded = rotund_scene::load(&path, &args.options()).map_err(|error| match error {
        error if matches!(*error.problem, LoadProblem::OutsideFolder { .. }) => {
            anyhow!("{error}: --allow-outside")
        }
        error => anyhow!("{error}"),
    })?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok((name, loaded))
}

/// The index of the camera of that name; of the first without one.
pub fn find_camera(scene: &NamedScene, name: Option<&str>) -> Result<usize> {
    let Some(name) = name else { return Ok(0) };
    let cameras = &scene.scene.cameras;
    cameras.iter().position(|camera| camera.name == name).with_context(|| {
        let names: Vec<&str> = cameras.iter().map(|camera| camera.name.as_str()).collect();
        format!("{} has no camera {name:?}, only: {}", scene.name, names.join(", "))
    })
}

/// The names of the scenes that come with the workspace, in order.
pub fn bundled() -> Result<Vec<String>> {
    let folder = workspace::root().join("scenes");
    let entries = std::fs::read_dir(&folder)
        .with_context(|| format!("cannot list the scenes in {}", folder.display()))?;
    let mut names = Vec::new();
    for entry in entries {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "json") {
            names.extend(path.file_stem().map(|stem| stem.to_string_lossy().into_owned()));
        }
    }
    names.sort();
    Ok(names)
}

fn locate(name_or_path: &str) -> Result<PathBuf> {
    let path = Path::new(name_or_path);
    if name_or_path.contains(std::path::is_separator) || path.extension().is_some() {
        return Ok(path.to_owned());
    }
    let names = bundled()?;
    if !names.iter().any(|name| name == name_or_path) {
        bail!(
            "there is no scene {name_or_path:?}; there are {}, or give the path of a JSON, PLY or OBJ file",
            names.join(", ")
        );
    }
    Ok(workspace::root().join("scenes").join(format!("{name_or_path}.json")))
}
