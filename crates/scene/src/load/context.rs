//! What all steps of loading share: the scene file, the options, the source of files, and the warnings.

use super::{
    error::{LoadError, LoadProblem, NamedBy},
    file::{Files, NamedFile},
    options::LoadOptions,
};
use std::{
    fmt::Display,
    path::{Path, PathBuf},
};

/// The scene that is being loaded.
pub(super) struct Context<'a> {
    /// The scene file.
    pub scene: PathBuf,
    pub options: LoadOptions,
    pub files: Files<'a>,
    /// Complete sentences, each with its file.
    pub warnings: Vec<String>,
}

impl<'a> Context<'a> {
    pub(super) fn new(scene: &Path, options: &LoadOptions, files: Files<'a>) -> Self {
        Self { scene: scene.to_owned(), options: *options, files, warnings: Vec::new() }
    }

    /// The folder that paths in the scene file are relative to.
    pub(super) fn folder(&self) -> &Path {
        self.scene.parent().unwrap_or(Path::new(""))
    }

    /// Adds a warning about the scene file.
    pub(super) fn warn(&mut self, warning: impl Display) {
        self.warnings.push(self.warning(warning));
    }

    /// The text of a warning about the scene file.
    pub(super) fn warning(&self, warning: impl Display) -> String {
        format!("{}: {warning}", self.scene.display())
    }

    /// The error that the scene file has this problem.
    pub(super) fn fail(&self, problem: LoadProblem) -> LoadError {
        problem.at(&self.scene)
    }

    /// The error that a field of the scene file has a value that is not expected.
    pub(super) fn unexpected(
        &self,
        field: impl Into<String>,
        value: impl ToString,
        expected: &'static str,
    ) -> LoadError {
        self.fail(LoadProblem::Value { field: field.into(), value: value.to_string(), expected })
    }

    /// The file that `uri`, in `field` of the scene file, names: relative to the folder of the scene, and
    /// not outside of it unless the options allow that.
    pub(super) fn locate(&self, field: String, uri: &str) -> Result<NamedFile, LoadError> {
        let outside = self.files.leads_outside(self.folder(), uri);
        if outside && !self.options.allow_outside_folder {
            return Err(self.fail(LoadProblem::OutsideFolder { field, uri: uri.to_owned() }));
        }
        let named_by = Some(NamedBy { scene: self.scene.clone(), field });
        Ok(NamedFile { path: self.folder().join(uri), named_by })
    }
}
