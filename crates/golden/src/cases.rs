//! Which pictures there are, and where their references lie.

use anyhow::{Context, Result, bail};
use rotund_scene::{ElementKind, LoadOptions, Method, Scene};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// One picture.
#[derive(Clone, Debug)]
pub struct Case {
    /// The name of the scene, and of the method if it is rendered with both.
    pub name: String,
    /// The scene file.
    pub scene: PathBuf,
    /// Overrides what the file says.
    pub method: Option<Method>,
    /// The stored picture, which need not exist yet.
    pub reference: PathBuf,
}

impl Case {
    /// Reads the scene.
    pub fn load(&self) -> Result<Scene> {
        let mut scene = load(&self.scene)?;
        if let Some(method) = self.method {
            for kind in [ElementKind::Points, ElementKind::Lines, ElementKind::Quads] {
                scene.set_method(kind, method);
            }
        }
        Ok(scene)
    }
}

/// The pictures of the workspace: every scene in `folder` with both methods, or once if it has
/// nothing but triangles, on which the methods agree.
pub fn of_workspace(folder: &Path) -> Result<Vec<Case>> {
    let mut scenes: Vec<PathBuf> =
        files(folder)?.into_iter().filter(|path| has_extension(path, "json")).collect();
    scenes.sort();
    let mut cases = Vec::new();
    for scene in scenes {
        let stem = stem(&scene);
        let case = |suffix: &str, method| {
            let name = format!("{stem}{suffix}");
            let reference = folder.join(format!("{name}.exr"));
            Case { name, scene: scene.clone(), method, reference }
        };
        let triangles =
            |shape: &rotund_scene::Shape| shape.elements.kind() == ElementKind::Triangles;
        if load(&scene)?.shapes.iter().all(triangles) {
            cases.push(case("", None));
        } else {
            cases.push(case("-vanilla", Some(Method::Vanilla)));
            cases.push(case("-enhanced", Some(Method::Enhanced)));
        }
    }
    if cases.is_empty() {
        bail!("{} has no scene files", folder.display());
    }
    Ok(cases)
}

/// The pictures of somebody's own scenes, each as its file says, with references in `folder`.
pub fn of_user(folder: &Path, scenes: &[PathBuf]) -> Result<Vec<Case>> {
    let mut by_name: BTreeMap<String, Case> = BTreeMap::new();
    for scene in scenes {
        let name = stem(scene);
        let reference = folder.join(format!("{name}.exr"));
        let case = Case { name: name.clone(), scene: scene.clone(), method: None, reference };
        if let Some(other) = by_name.insert(name, case) {
            let (a, b) = (other.scene.display(), scene.display());
            bail!("{a} and {b} would share a reference: give one another name, or two folders");
        }
    }
    Ok(by_name.into_values().collect())
}

/// Stored pictures that belong to no case.
pub fn dead_references(folder: &Path, cases: &[Case]) -> Result<Vec<PathBuf>> {
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let dead = |path: &PathBuf| {
        has_extension(path, "exr") && cases.iter().all(|case| case.reference != *path)
    };
    let mut dead: Vec<PathBuf> = files(folder)?.into_iter().filter(dead).collect();
    dead.sort();
    Ok(dead)
}

fn load(path: &Path) -> Result<Scene> {
    // The text of a load error already tells its cause.
    let loaded = rotund_scene::load(path, &LoadOptions::default());
    Ok(loaded.map_err(|error| anyhow::anyhow!("{error}"))?.scene)
}

fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let listing = || -> std::io::Result<Vec<PathBuf>> {
        std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect()
    };
    listing().with_context(|| format!("cannot list {}", folder.display()))
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found == extension)
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
