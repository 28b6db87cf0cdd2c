//! A set of pictures with their references.

use crate::bless::{Blessed, bless};
use crate::case::{Case, Source, files, has_extension, of_folder, stem};
use crate::error::{Failed, GoldenError, Refused};
use crate::moments::Moments;
use crate::page::{Failure, failure_page};
use crate::reference::Reference;
use crate::subject::{Plan, Subject};
use crate::surface::Surface;
use crate::verdict::{Verdict, judge};
use crate::{BLESS_VARIABLE, REPLICAS};
use rotund_bvh::Isa;
use rotund_image::write_with;
use rotund_scene::Scene;
use rotund_trace::Sequence;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// A set of pictures and the folder of their references. The false-alarm rate is that of the whole
/// set, so a program should have one suite, in a folder of its own.
#[derive(Clone, Debug)]
pub struct Suite {
    folder: PathBuf,
    /// Names are unique.
    cases: Vec<Case>,
    /// Pixels along the longer side of a picture that is accepted for the first time, or anew: 96
    /// by default, and at least 1. Without noise in the way, more pixels find smaller faults and
    /// take more time.
    pub resolution: u32,
    /// The page that a failed check writes: `failures.html` in the folder by default.
    pub page: PathBuf,
    /// How a check renders.
    pub settings: Settings,
}

/// How a check renders. A correct renderer passes with any settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Instructions to traverse trees with.
    pub isa: Isa,
    /// Generator of the random numbers.
    pub sequence: Sequence,
    /// Seed of the random numbers, 1 by default. References are made with seed 0: a check with that
    /// seed would depend on its reference.
    pub seed: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self { isa: Isa::default_set(), sequence: Sequence::Sobol, seed: 1 }
    }
}

/// Result of rendering one picture of a suite.
#[derive(Debug)]
pub enum Outcome {
    /// The picture was compared with its reference.
    Judged(Box<Judged>),
    /// The picture has no reference, or one of another shape; the text says which.
    Failed(String),
}

/// A picture beside its reference.
#[derive(Debug)]
pub struct Judged {
    /// The reference.
    pub reference: Reference,
    /// Mean and variance of the picture.
    pub actual: Moments,
    /// Surfaces of the picture.
    pub surface: Surface,
    /// Results of all checks.
    pub verdict: Verdict,
}

impl Judged {
    /// Returns what a page shows of a picture that differs, or `None` if it agrees with its
    /// reference.
    #[must_use]
    pub fn into_failure(self, name: impl Into<String>) -> Option<Failure> {
        let Self { reference, actual, surface, verdict } = self;
        if verdict.findings.is_empty() {
            return None;
        }
        let differs = !surface.compare(&reference.surface).is_empty();
        Some(Failure {
            name: name.into(),
            expected: reference.moments.picture(),
            actual: actual.picture(),
            surfaces: differs.then_some([reference.surface, surface]),
            verdict,
        })
    }
}

impl Suite {
    /// Returns a suite without pictures, whose references lie in `folder`. The folder need not
    /// exist before a picture is accepted.
    #[must_use]
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        let folder = folder.into();
        let page = folder.join("failures.html");
        let settings = Settings::default();
        Self { folder, cases: Vec::new(), resolution: 96, page, settings }
    }

    /// Returns a suite of all scene files (`*.json`) in a folder, with their references beside
    /// them: each scene by both methods, or once if it has nothing but triangles.
    ///
    /// # Errors
    ///
    /// If the folder has no scenes, or one cannot be loaded.
    pub fn of_folder(folder: impl Into<PathBuf>) -> Result<Self, GoldenError> {
        let mut suite = Self::new(folder);
        for case in of_folder(&suite.folder)? {
            suite.push(case)?;
        }
        Ok(suite)
    }

    /// Adds a picture of a scene made in code, through its first camera.
    ///
    /// # Errors
    ///
    /// If the suite has a picture of this name, or the name cannot be that of a file in the folder.
    pub fn add(&mut self, name: &str, scene: Scene) -> Result<&mut Self, GoldenError> {
        self.push(self.case(name.to_owned(), Source::Scene(Box::new(scene))))
    }

    /// Adds a picture of a scene file that [`rotund_scene::load`] reads, named for the file. It is
    /// read when the picture is checked.
    ///
    /// # Errors
    ///
    /// If the suite has a picture of this name.
    pub fn add_file(&mut self, path: impl Into<PathBuf>) -> Result<&mut Self, GoldenError> {
        let path = path.into();
        self.push(self.case(stem(&path), Source::File(path)))
    }

    fn case(&self, name: String, source: Source) -> Case {
        let reference = self.folder.join(format!("{name}.exr"));
        Case { name, source, method: None, reference }
    }

    fn push(&mut self, case: Case) -> Result<&mut Self, GoldenError> {
        let plain = !case.name.is_empty() && !case.name.contains(['/', '\\', ':', '\0']);
        if !plain {
            return Err(GoldenError::Name { name: case.name });
        }
        if let Some(other) = self.cases.iter().find(|other| other.name == case.name) {
            let (first, second) = (other.origin(), case.origin());
            return Err(GoldenError::NameTaken { name: case.name, first, second });
        }
        self.cases.push(case);
        Ok(self)
    }

    /// Returns the pictures.
    #[must_use]
    pub fn cases(&self) -> &[Case] {
        &self.cases
    }

    /// Renders all pictures and compares each with its reference. If the environment variable
    /// `ROTUND_BLESS` is set, and neither empty nor `0`, it accepts them instead, as
    /// [`Self::bless`].
    ///
    /// # Errors
    ///
    /// [`GoldenError::Failed`] if a picture differs or has no reference, or a reference in the
    /// folder belongs to no picture; its message lists all of them, and the page [`Self::page`]
    /// shows them. Other errors if the suite has no picture or no resolution, a scene cannot be
    /// loaded or rendered, or a file cannot be read or written.
    pub fn check(&self) -> Result<(), GoldenError> {
        if self.cases.is_empty() {
            return Err(GoldenError::NoPictures { folder: self.folder.clone() });
        }
        if self.resolution == 0 {
            return Err(GoldenError::Resolution);
        }
        let bless = std::env::var_os(BLESS_VARIABLE);
        if bless.is_some_and(|value| !value.is_empty() && value != "0") {
            return self.bless().map(drop);
        }
        let (mut failures, mut complaints) = (Vec::new(), Vec::new());
        for case in &self.cases {
            match self.examine(case, &self.settings)? {
                Outcome::Judged(judged) => failures.extend(judged.into_failure(&case.name)),
                Outcome::Failed(complaint) => {
                    complaints.push(format!("{}: {complaint}", case.name));
                }
            }
        }
        for path in self.dead_references()? {
            complaints.push(format!("{} is the reference of no picture", path.display()));
        }
        if failures.is_empty() && complaints.is_empty() {
            return Ok(());
        }
        let page = (!failures.is_empty()).then(|| self.page.clone());
        if let Some(page) = &page {
            write_page(page, &failures, &format!("{BLESS_VARIABLE}=1 cargo test"))?;
        }
        let pictures = failures.into_iter().map(|f| (f.name, f.verdict.findings)).collect();
        let count = self.cases.len();
        Err(GoldenError::Failed(Failed { pictures, complaints, count, page }))
    }

    /// Renders a picture and compares it with its reference.
    ///
    /// # Errors
    ///
    /// If the scene cannot be loaded or rendered, or the reference cannot be read.
    pub fn examine(&self, case: &Case, settings: &Settings) -> Result<Outcome, GoldenError> {
        // A scene that cannot be rendered is worse news than that it has no reference yet.
        let subject = Subject::new(&case.name, case.load()?, settings.isa)?;
        if !case.reference.is_file() {
            let text = format!("there is no reference {} yet", case.reference.display());
            return Ok(Outcome::Failed(text));
        }
        let reference = Reference::read(&case.reference)?;
        let Moments { width, height, .. } = reference.moments;
        let (width, height) = (width as u32, height as u32);
        let size = subject.resolution(width.max(height));
        if size != (width, height) {
            let text = format!("{} x {} pixels instead of {width} x {height}", size.0, size.1);
            return Ok(Outcome::Failed(text));
        }
        let &Settings { sequence, seed, .. } = settings;
        let (samples, bounces) = (reference.samples, reference.bounces);
        let plan = Plan { width, height, bounces, samples, sequence };
        let surface = subject.surface(width, height);
        let actual = subject.measure(&plan, REPLICAS, seed)?;
        let mut verdict = judge(&actual, &reference.moments, self.cases.len())
            .map_err(|source| GoldenError::Compare { name: case.name.clone(), source })?;
        verdict.findings.splice(0..0, surface.compare(&reference.surface));
        Ok(Outcome::Judged(Box::new(Judged { reference, actual, surface, verdict })))
    }

    /// Accepts all pictures as they are: writes new references, leaves those that agree as they are
    /// to the bit, and removes references of the folder that belong to no picture. Returns the name
    /// of each picture and what became of it.
    ///
    /// # Errors
    ///
    /// [`GoldenError::Refused`] if pictures cannot be references, see [`Self::accept`]; the others
    /// are accepted. Other errors if a scene cannot be loaded or rendered, or a file cannot be
    /// written.
    pub fn bless(&self) -> Result<Vec<(String, Blessed)>, GoldenError> {
        let (mut accepted, mut refused) = (Vec::new(), Vec::new());
        for case in &self.cases {
            match self.accept(case) {
                Ok(blessed) => accepted.push((case.name.clone(), blessed)),
                Err(GoldenError::Refused(one)) => refused.extend(one.pictures),
                Err(error) => return Err(error),
            }
        }
        for path in self.dead_references()? {
            fs::remove_file(&path).map_err(|source| GoldenError::Folder {
                action: "remove",
                path,
                source,
            })?;
        }
        if refused.is_empty() {
            return Ok(accepted);
        }
        Err(GoldenError::Refused(Refused { pictures: refused }))
    }

    /// Accepts one picture as it is, and writes its reference unless it agrees with the old one.
    ///
    /// # Errors
    ///
    /// [`GoldenError::Refused`] if the check would be weaker than that of the other pictures: the
    /// picture is black, has invalid samples, is smaller than its reference was, or is so noisy
    /// that [`SMALLEST_LOSS`](crate::SMALLEST_LOSS) of the light could be lost unnoticed. Other
    /// errors if [`Self::resolution`] is 0, the scene cannot be loaded or rendered, or the file
    /// cannot be written.
    pub fn accept(&self, case: &Case) -> Result<Blessed, GoldenError> {
        if self.resolution == 0 {
            return Err(GoldenError::Resolution);
        }
        // A file that cannot be read is replaced like one that is missing.
        let old = Reference::read(&case.reference).ok();
        let blessed = bless(case, old.as_ref(), self.resolution, self.cases.len())?;
        if let Blessed::New(reference) | Blessed::Changed(reference, _) = &blessed {
            create_folder(&self.folder)?;
            reference.write(&case.reference)?;
        }
        Ok(blessed)
    }

    /// Returns the references in the folder that belong to no picture. Other EXR files are left
    /// alone.
    ///
    /// # Errors
    ///
    /// If the folder exists but cannot be listed.
    pub fn dead_references(&self) -> Result<Vec<PathBuf>, GoldenError> {
        if !self.folder.is_dir() {
            return Ok(Vec::new());
        }
        let mut dead = files(&self.folder)?;
        dead.retain(|path| {
            has_extension(path, "exr")
                && self.cases.iter().all(|case| case.reference != *path)
                && Reference::read(path).is_ok()
        });
        Ok(dead)
    }
}

/// Writes the page about pictures that differ, and the folder it lies in. `accept` is the command
/// that accepts the change.
///
/// # Errors
///
/// If the file cannot be written.
pub fn write_page(path: &Path, failures: &[Failure], accept: &str) -> Result<(), GoldenError> {
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        create_folder(folder)?;
    }
    let html = failure_page(failures, accept)
        .map_err(|source| GoldenError::Page { path: path.into(), source })?;
    Ok(write_with(path, |file| file.write_all(html.as_bytes()))?)
}

fn create_folder(folder: &Path) -> Result<(), GoldenError> {
    fs::create_dir_all(folder).map_err(|source| {
        let path = folder.into();
        GoldenError::Folder { action: "create the folder", path, source }
    })
}
