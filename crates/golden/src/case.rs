//! A picture of a suite: its scene, and where its reference lies.

use crate::error::GoldenError;
use rotund_scene::{ElementKind, LoadOptions, Method, Scene, Shape, load};
use std::path::{Path, PathBuf};

/// Origin of a scene.
#[derive(Clone, Debug)]
pub enum Source {
    /// A file that [`rotund_scene::load`] reads, anew for each check.
    File(PathBuf),
    /// A scene made in code.
    Scene(Box<Scene>),
}

/// A picture of a suite.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name of the picture, and of the file of its reference.
    pub name: String,
    /// Origin of the scene.
    pub source: Source,
    /// Method of all shapes; `None` leaves those of the scene.
    pub method: Option<Method>,
    /// File of the reference, which need not exist yet.
    pub reference: PathBuf,
}

impl Case {
    /// Returns the scene, read from its file if it has one.
    ///
    /// # Errors
    ///
    /// If the file cannot be loaded.
    pub fn load(&self) -> Result<Scene, GoldenError> {
        let mut scene = match &self.source {
            Source::File(path) => load_scene(path)?,
            Source::Scene(scene) => scene.as_ref().clone(),
        };
        if let Some(method) = self.method {
            for kind in [ElementKind::Points, ElementKind::Lines, ElementKind::Quads] {
                scene.set_method(kind, method);
            }
        }
        Ok(scene)
    }

    /// Names the origin of the scene, for errors.
    pub(crate) fn origin(&self) -> String {
        match &self.source {
            Source::File(path) => path.display().to_string(),
            Source::Scene(_) => format!("the scene {:?}", self.name),
        }
    }
}

/// Returns the pictures of the scenes in a folder, by both methods; a scene of triangles alone, on
/// which the methods agree, makes one picture.
pub(crate) fn of_folder(folder: &Path) -> Result<Vec<Case>, GoldenError> {
    let mut scenes = files(folder)?;
    scenes.retain(|path| has_extension(path, "json"));
    let mut cases = Vec::new();
    for path in scenes {
        let stem = stem(&path);
        let case = |suffix: &str, method| {
            let name = format!("{stem}{suffix}");
            let reference = folder.join(format!("{name}.exr"));
            Case { name, source: Source::File(path.clone()), method, reference }
        };
        let triangles = |shape: &Shape| shape.elements.kind() == ElementKind::Triangles;
        if load_scene(&path)?.shapes.iter().all(triangles) {
            cases.push(case("", None));
        } else {
            cases.push(case("-vanilla", Some(Method::Vanilla)));
            cases.push(case("-enhanced", Some(Method::Enhanced)));
        }
    }
    if cases.is_empty() {
        return Err(GoldenError::NoScenes { folder: folder.into() });
    }
    Ok(cases)
}

fn load_scene(path: &Path) -> Result<Scene, GoldenError> {
    Ok(load(path, &LoadOptions::default()).map_err(Box::new)?.scene)
}

/// Returns the files of a folder, by name.
pub(crate) fn files(folder: &Path) -> Result<Vec<PathBuf>, GoldenError> {
    let listing = || -> std::io::Result<Vec<PathBuf>> {
        std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect()
    };
    let mut files = listing().map_err(|source| {
        let path = folder.into();
        GoldenError::Folder { action: "list the folder", path, source }
    })?;
    files.sort();
    Ok(files)
}

pub(crate) fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found == extension)
}

pub(crate) fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
