//! Scenes from files.

mod assets;
mod check;
mod collection;
mod error;
mod file;
mod format;
mod image;
mod lone;
mod mesh;
mod obj;
mod older;
mod placements;
mod ply;
mod resolve;
mod subdivide;

pub use error::{LoadError, NamedBy};

use crate::Scene;
use format::SceneFile;
use std::path::{Path, PathBuf};

/// What to allow and what to bear with while loading.
#[derive(Clone, Copy, Debug, Default)]
pub struct LoadOptions {
    /// Let a scene name files outside its own folder. Off by default: then a scene from a stranger
    /// reads nothing but what came with it.
    pub allow_outside_folder: bool,
    /// Load the rest if a texture cannot be read: it becomes white, and a warning says so.
    pub keep_going: bool,
    /// Of points and lines if what is loaded is a lone shape: in the place of radii in the file, or of
    /// one found from how far the points are apart.
    pub radius: Option<f32>,
}

/// A scene, and what about its files was odd but not wrong.
#[derive(Clone, Debug, Default)]
pub struct Loaded {
    /// Indices and values are checked.
    pub scene: Scene,
    /// One sentence each, with the file and the field.
    pub warnings: Vec<String>,
    /// What was read, each once.
    pub files: Vec<PathBuf>,
}

/// Loads a scene of yocto-gl, version 4.0 to 5.0, with the files that it names: PLY and OBJ for shapes
/// and control meshes; PNG, JPEG, HDR and EXR for textures. A shape by itself becomes a scene with a
/// camera, a floor and a sky around it; a scene without a camera gets one.
///
/// Unknown fields become warnings. Memory is bounded by a small multiple of the sizes of the files,
/// whatever they claim to hold.
///
/// # Errors
///
/// If a file cannot be read or means nothing: see [`LoadError`].
pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Loaded, LoadError> {
    let path = path.as_ref();
    if matches!(file::extension(path).as_str(), "ply" | "obj") {
        return lone::load(path, options);
    }
    let nobody = NamedBy::default();
    // A folder is told as such, whatever its name ends in.
    drop(file::open(path, &nobody)?);
    let extension = file::extension(path);
    let unsupported = |extension| {
        let (path, named_by) = (path.to_owned(), NamedBy::default());
        LoadError::Unsupported { path, named_by, extension, supported: "json, ply and obj" }
    };
    if !matches!(extension.as_str(), "json" | "") {
        return Err(unsupported(extension));
    }
    let bytes = file::read(path, &nobody)?;
    // A pipe has no extension. A mesh without one is no JSON with a mistake in its first line.
    if bytes.starts_with(b"ply") {
        return Err(unsupported(extension));
    }
    let mut warnings = Vec::new();
    if options.radius.is_some() {
        let path = path.display();
        warnings
            .push(format!("{path}: a radius is for lone PLY and OBJ files, and changes nothing"));
    }
    let mut file = parse(path, &bytes, &mut warnings)?;
    older::spell_out(path, &mut file);
    check::check(path, &file, &mut warnings)?;
    placements::expand(path, &mut file, options)?;
    let mut scene = resolve::resolve(path, &file, &mut warnings)?;
    scene.textures = assets::textures(path, &file, options, &mut warnings)?;
    scene.shapes = assets::shapes(path, &file, options, &scene.textures, &mut warnings)?;
    if scene.cameras.is_empty() {
        scene.cameras.extend(lone::camera_for(&scene));
    }
    let files = assets::files(path, &file);
    Ok(Loaded { scene, warnings, files })
}

/// The JSON, with the path of whatever is wrong in it, and a warning for each unknown field.
fn parse(path: &Path, bytes: &[u8], warnings: &mut Vec<String>) -> Result<SceneFile, LoadError> {
    let mut json = serde_json::Deserializer::from_slice(file::text(path, bytes)?);
    let mut track = serde_path_to_error::Track::new();
    let tracked = serde_path_to_error::Deserializer::new(&mut json, &mut track);
    let mut unknown = Vec::new();
    let result: Result<format::Whole, _> = serde_ignored::deserialize(tracked, |field| {
        let field = without_items(&field);
        if !unknown.contains(&field) {
            unknown.push(field);
        }
    });
    let failed = |field: String, source| LoadError::Json { path: path.to_owned(), field, source };
    let format::Whole(file) = result.map_err(|source| failed(track.path().to_string(), source))?;
    json.end().map_err(|source| failed(String::new(), source))?;
    let warning = |field| format!("{}: unknown field {field} is ignored", path.display());
    warnings.extend(unknown.into_iter().map(warning));
    Ok(file)
}

/// `materials[].shine` of any material, by index or by name: ten thousand with one odd field each are one
/// oddity.
fn without_items(path: &serde_ignored::Path<'_>) -> String {
    use serde_ignored::Path;
    let inside = |parent: &Path<'_>, key: &str| match without_items(parent) {
        parent if parent.is_empty() => key.to_owned(),
        // The names of a collection's items are keys of the second level.
        parent if COLLECTIONS.contains(&parent.as_str()) => format!("{parent}[]"),
        parent => format!("{parent}.{key}"),
    };
    match path {
        Path::Root => String::new(),
        Path::Seq { parent, .. } => format!("{}[]", without_items(parent)),
        Path::Map { parent, key } => inside(parent, key),
        Path::Some { parent }
        | Path::NewtypeStruct { parent }
        | Path::NewtypeVariant { parent } => without_items(parent),
    }
}

/// What may be an object of items by name.
const COLLECTIONS: [&str; 8] = [
    "cameras",
    "environments",
    "textures",
    "materials",
    "shapes",
    "subdivs",
    "instances",
    "objects",
];
