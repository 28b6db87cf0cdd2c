//! Loading of scenes from files and from memory.

mod assets;
mod check;
mod collection;
mod colors;
mod context;
mod error;
mod far;
mod file;
mod format;
mod framing;
mod image;
mod lone;
mod materials;
mod mesh;
mod obj;
mod older;
mod options;
mod place;
mod placements;
mod ply;
mod points;
mod radius;
mod resolve;
mod subdivide;
mod swc;
mod tracks;

pub use error::{LoadError, LoadProblem, NamedBy};
pub use options::{LoadOptions, Up};

use crate::Scene;
use context::Context;
use file::{Files, NamedFile};
use format::SceneFile;
use std::{
    borrow::Cow,
    path::{Path, PathBuf},
};

/// A scene, with the names of its files and warnings about their content.
#[derive(Clone, Debug, Default)]
pub struct Loaded {
    /// The scene; [`Scene::validate`] accepts it.
    pub scene: Scene,
    /// Warnings, each with the file and the field.
    pub warnings: Vec<String>,
    /// The files that the scene was read from, each once.
    pub files: Vec<PathBuf>,
}

/// Loads a scene of yocto-gl, version 4.0 to 5.0, with the files that it names: PLY and OBJ for
/// shapes and control meshes, SWC, TCK and TRK for shapes of lines, XYZ, TXT, CSV, PTS and ASC for
/// points; PNG, JPEG, HDR, EXR, BMP and TGA for textures. The file of a shape by itself
/// becomes a scene with a camera, a floor and a sky around it; a scene without a camera gets one.
///
/// Unknown fields become warnings. Memory is bounded by a small multiple of the sizes of the files,
/// independent of the counts in their headers.
///
/// # Errors
///
/// If a file cannot be read or its content is not valid: see [`LoadProblem`].
pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Loaded, LoadError> {
    let path = path.as_ref();
    let context = Context::new(path, options, Files::Disk);
    if assets::is_mesh(&file::extension(path)) {
        return load_lone(context);
    }
    // A folder is reported as such even if its name has an unsupported extension.
    drop(context.files.open(&NamedFile::given(path))?);
    check_extension(&context)?;
    let bytes = context.files.read(&NamedFile::given(path))?;
    load_json(context, &bytes)
}

/// Loads a scene from memory, as [`load`] does from the file `name`.
///
/// `bytes` is the content of that file, and `files` returns the content of each file that it names,
/// also of the materials and images of a lone mesh. It gets the path with `/` as the separator: if
/// `scenes/a.json` names `shapes/b.ply`, the path is `scenes/shapes/b.ply`. The extension of `name`
/// distinguishes scenes in JSON from the files of shapes.
///
/// ```
/// use rotund_scene::{LoadOptions, load_bytes};
/// use std::borrow::Cow;
///
/// let json = br#"{ "shapes": [{ "uri": "ball.ply" }] }"#;
/// let ply = b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
///     property float z\nproperty float radius\nend_header\n0 1 0 0.5\n";
/// let files = |path: &str| (path == "ball.ply").then_some(Cow::Borrowed(&ply[..]));
/// let loaded = load_bytes("scene.json", json, &files, &LoadOptions::default())?;
/// assert_eq!(loaded.scene.shapes[0].radii, [0.5]);
/// # Ok::<(), rotund_scene::LoadError>(())
/// ```
///
/// # Errors
///
/// As for [`load`]. A file for which `files` returns `None` cannot be read.
pub fn load_bytes<'a>(
    name: impl AsRef<Path>,
    bytes: &'a [u8],
    files: &'a (dyn Fn(&str) -> Option<Cow<'a, [u8]>> + Sync),
    options: &LoadOptions,
) -> Result<Loaded, LoadError> {
    let name = name.as_ref();
    if assets::is_mesh(&file::extension(name)) {
        let path = file::slashed(name);
        let own = |asked: &str| {
            if asked == path { Some(Cow::Borrowed(bytes)) } else { files(asked) }
        };
        return load_lone(Context::new(name, options, Files::Memory(&own)));
    }
    let context = Context::new(name, options, Files::Memory(files));
    check_extension(&context)?;
    load_json(context, bytes)
}

fn load_lone(mut context: Context<'_>) -> Result<Loaded, LoadError> {
    let (scene, mut files) = lone::load(&mut context)?;
    files.insert(0, context.scene.clone());
    Ok(Loaded { scene, warnings: context.warnings, files })
}

/// Refuses extensions other than `json`. Pipes have none, which is accepted.
fn check_extension(context: &Context<'_>) -> Result<(), LoadError> {
    match file::extension(&context.scene).as_str() {
        "json" | "" => Ok(()),
        _ => Err(unsupported(context)),
    }
}

fn unsupported(context: &Context<'_>) -> LoadError {
    let extension = file::extension(&context.scene);
    let supported = "json, ply, obj, swc, tck, trk, xyz, txt, csv, pts and asc";
    context.fail(LoadProblem::Unsupported { extension, supported })
}

fn load_json(mut context: Context<'_>, bytes: &[u8]) -> Result<Loaded, LoadError> {
    // Report a PLY file with another extension as such, and not as a mistake in JSON.
    if bytes.starts_with(b"ply") {
        return Err(unsupported(&context));
    }
    let LoadOptions { radius, up, .. } = context.options;
    for (what, is_given) in [("radius", radius.is_some()), ("up axis", up.is_some())] {
        if is_given {
            context.warn(format_args!(
                "the {what} changes nothing: it is for files of shapes that are loaded by \
                 themselves"
            ));
        }
    }
    let mut file = parse(&mut context, bytes)?;
    older::spell_out(&context, &mut file);
    check::check(&mut context, &file)?;
    placements::expand(&context, &mut file)?;
    let mut scene = resolve::resolve(&mut context, &file)?;
    scene.textures = assets::textures(&mut context, &file)?;
    let (shapes, more) = assets::shapes(&mut context, &file, &scene.textures)?;
    place::shapes(&mut scene, &file, shapes);
    if scene.cameras.is_empty() {
        scene.cameras.extend(lone::camera_for(&scene));
    }
    let files = assets::files(&context, &file, more);
    Ok(Loaded { scene, warnings: context.warnings, files })
}

/// Parses the JSON. Errors name the field, and each unknown field adds a warning.
fn parse(context: &mut Context<'_>, bytes: &[u8]) -> Result<SceneFile, LoadError> {
    let text = file::text(bytes).map_err(|problem| context.fail(problem))?;
    let mut json = serde_json::Deserializer::from_slice(text);
    let mut track = serde_path_to_error::Track::new();
    let tracked = serde_path_to_error::Deserializer::new(&mut json, &mut track);
    let mut unknown = Vec::new();
    let result: Result<format::Whole, _> = serde_ignored::deserialize(tracked, |field| {
        let field = without_items(&field);
        if !unknown.contains(&field) {
            unknown.push(field);
        }
    });
    let failed = |field: String, error| context.fail(LoadProblem::Json { field, error });
    let format::Whole(file) = result.map_err(|error| failed(track.path().to_string(), error))?;
    json.end().map_err(|error| failed(String::new(), error))?;
    older::refuse_early(context, &file, &unknown)?;
    for field in unknown {
        context.warn(format_args!("unknown field {field} is ignored"));
    }
    Ok(file)
}

/// Returns the path of a field without indices and names of items, as in `materials[].shine`, so
/// that an unknown field of ten thousand items is one warning.
fn without_items(path: &serde_ignored::Path<'_>) -> String {
    use serde_ignored::Path;
    let inside = |parent: &Path<'_>, key: &str| match without_items(parent) {
        parent if parent.is_empty() => key.to_owned(),
        // Keys of the second level are names of items.
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

/// The fields that may be objects, with items by name.
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
