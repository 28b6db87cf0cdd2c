//! The state that all steps of loading share: scene file, options, source of files, and warnings.

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
    /// Warnings, each with the path of its file.
    pub warnings: Vec<String>,
}

impl<'a> Context<'a> {
    pub(super) fn new(scene: &Path, options: &LoadOptions, files: Files<'a>) -> Self {
        Self { scene: scene.to_owned(), options: *options, files, warnings: Vec::new() }
    }

    /// Returns the folder that paths in the scene file are relative to.
    pub(super) fn folder(&self) -> &Path {
        self.scene.parent().unwrap_or(Path::new(""))
    }

    /// Adds a warning about the scene file.
    pub(super) fn warn(&mut self, warning: impl Display) {
        self.warnings.push(self.warning(warning));
    }

    /// Returns the text of a warning about the scene file.
    pub(super) fn warning(&self, warning: impl Display) -> String {
        format!("{}: {warning}", self.scene.display())
    }

    /// Returns the error for a problem of the scene file.
    pub(super) fn fail(&self, problem: LoadProblem) -> LoadError {
        problem.at(&self.scene)
    }

    /// Returns the error for an unexpected value of a field of the scene file.
    pub(super) fn unexpected(
        &self,
        field: impl Into<String>,
        value: impl ToString,
        expected: &'static str,
    ) -> LoadError {
        self.fail(LoadProblem::Value { field: field.into(), value: value.to_string(), expected })
    }

    /// Resolves the `uri` in `field` of the scene file, relative to the folder of the scene;
    /// refuses a file outside of that folder unless the options allow it.
    pub(super) fn locate(&self, field: String, uri: &str) -> Result<NamedFile, LoadError> {
        let outside = self.files.leads_outside(self.folder(), uri);
        if outside && !self.options.allow_outside_folder {
            return Err(self.fail(LoadProblem::OutsideFolder { field, uri: uri.to_owned() }));
        }
        let named_by = Some(NamedBy { scene: self.scene.clone(), field });
        Ok(NamedFile { path: self.folder().join(uri), named_by })
    }
}
