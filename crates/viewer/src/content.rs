//! A scene as a loader hands it over.

use rotund_scene::Scene;
use std::path::PathBuf;

/// A loaded scene.
#[derive(Debug)]
pub struct Content {
    /// Name of the scene.
    pub name: String,
    /// The scene, which has at least one camera.
    pub scene: Scene,
    /// Warnings of the loader.
    pub warnings: Vec<String>,
    /// Files that the scene was read from, which are watched for changes.
    pub files: Vec<PathBuf>,
}
