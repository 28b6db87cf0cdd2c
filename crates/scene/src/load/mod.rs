//! Scenes from files.

mod check;
mod collection;
mod error;
mod file;
mod format;
mod image;
mod mesh;
mod ply;
mod resolve;

pub use error::{LoadError, NamedBy};

use crate::{Scene, Shape, Texture};
use format::SceneFile;
use rayon::prelude::*;
use std::{
    io::BufReader,
    path::{Path, PathBuf},
};

/// What to allow and what to bear with while loading.
#[derive(Clone, Copy, Debug, Default)]
pub struct LoadOptions {
    /// Let a scene name files outside its own folder. Off by default: then a scene from a stranger
    /// reads nothing but what came with it.
    pub allow_outside_folder: bool,
    /// Load the rest if a texture cannot be read: it becomes white, and a warning says so.
    pub keep_going: bool,
}

/// A scene, and what about its files was odd but not wrong.
#[derive(Clone, Debug, Default)]
pub struct Loaded {
    /// Indices and values are checked.
    pub scene: Scene,
    /// One sentence each, with the file and the field.
    pub warnings: Vec<String>,
}

/// Loads a scene of yocto-gl, version 4, with the files that it names: PLY for shapes; PNG, JPEG, HDR
/// and EXR for textures.
///
/// Unknown fields become warnings. Memory is bounded by a small multiple of the sizes of the files,
/// whatever they claim to hold.
///
/// # Errors
///
/// If a file cannot be read or means nothing: see [`LoadError`].
pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Loaded, LoadError> {
    let path = path.as_ref();
    let bytes = file::read(path, &NamedBy::default())?;
    let mut warnings = Vec::new();
    let file = parse(path, &bytes, &mut warnings)?;
    check::check(path, &file)?;
    let mut scene = resolve::resolve(path, &file, &mut warnings)?;
    let requests = Requests::new(path, &file, options)?;
    scene.textures = requests.textures(options.keep_going, &mut warnings)?;
    scene.shapes = requests.shapes(&file, &mut warnings)?;
    Ok(Loaded { scene, warnings })
}

/// The JSON, with the path of whatever is wrong in it, and a warning for each unknown field.
fn parse(path: &Path, bytes: &[u8], warnings: &mut Vec<String>) -> Result<SceneFile, LoadError> {
    let mut json = serde_json::Deserializer::from_slice(bytes);
    let mut track = serde_path_to_error::Track::new();
    let tracked = serde_path_to_error::Deserializer::new(&mut json, &mut track);
    let mut unknown = Vec::new();
    let result = serde_ignored::deserialize(tracked, |field| {
        // Ten thousand materials with one odd field each are one oddity.
        let field = check::without_indices(&field.to_string());
        if !unknown.contains(&field) {
            unknown.push(field);
        }
    });
    let failed = |field: String, source| LoadError::Json { path: path.to_owned(), field, source };
    let file = result.map_err(|source| failed(track.path().to_string(), source))?;
    json.end().map_err(|source| failed(String::new(), source))?;
    let warning = |field| format!("{}: unknown field {field} is ignored", path.display());
    warnings.extend(unknown.into_iter().map(warning));
    Ok(file)
}

/// The files to read, in the order of the arrays.
struct Requests {
    textures: Vec<(PathBuf, NamedBy)>,
    shapes: Vec<(PathBuf, NamedBy)>,
}

impl Requests {
    fn new(path: &Path, file: &SceneFile, options: &LoadOptions) -> Result<Self, LoadError> {
        let request = |what: &str, i: usize, uri: &Option<String>| {
            let field = format!("{what}[{i}].uri");
            let Some(uri) = uri else {
                return Err(LoadError::Value {
                    path: path.to_owned(),
                    field,
                    value: "missing".to_owned(),
                    expected: "the name of a file",
                });
            };
            let target = file::resolve(path, &field, uri, options.allow_outside_folder)?;
            Ok((target, NamedBy(Some((path.to_owned(), field)))))
        };
        let textures = file.textures.items.iter().enumerate();
        let shapes = file.shapes.items.iter().enumerate();
        Ok(Self {
            textures: textures
                .map(|(i, (_, texture))| request("textures", i, &texture.uri))
                .collect::<Result<_, _>>()?,
            shapes: shapes
                .map(|(i, (_, shape))| request("shapes", i, &shape.uri))
                .collect::<Result<_, _>>()?,
        })
    }

    fn textures(
        &self,
        keep_going: bool,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<Texture>, LoadError> {
        let loaded: Vec<_> =
            self.textures.par_iter().map(|(path, named_by)| image::load(path, named_by)).collect();
        let mut textures = Vec::new();
        for (result, (path, _)) in loaded.into_iter().zip(&self.textures) {
            let mut texture = match result {
                Ok(texture) => texture,
                Err(error) if keep_going => {
                    warnings.push(format!("left out, white instead: {error}"));
                    Texture::white()
                }
                Err(error) => return Err(error),
            };
            texture.name = stem(path);
            textures.push(texture);
        }
        Ok(textures)
    }

    fn shapes(
        &self,
        file: &SceneFile,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<Shape>, LoadError> {
        let loaded: Vec<_> = self
            .shapes
            .par_iter()
            .map(|(path, named_by)| {
                let mut warnings = Vec::new();
                let mesh = read_mesh(path, named_by)?;
                let shape = mesh.into_shape(path, mesh::DEFAULT_RADIUS, &mut warnings)?;
                Ok((shape, warnings))
            })
            .collect();
        let mut shapes = Vec::new();
        for (result, (key, described)) in loaded.into_iter().zip(&file.shapes.items) {
            let (mut shape, its_warnings) = result?;
            warnings.extend(its_warnings);
            shape.name = key.clone().unwrap_or_else(|| described.name.clone());
            if let Some(method) = described.method.or(file.method) {
                shape.method = method.into();
            }
            shapes.push(shape);
        }
        Ok(shapes)
    }
}

fn read_mesh(path: &Path, named_by: &NamedBy) -> Result<mesh::Mesh, LoadError> {
    match file::extension(path).as_str() {
        "ply" => {
            let (file, length) = file::open(path, named_by)?;
            ply::read(path, BufReader::with_capacity(1 << 16, file), length)
        }
        other => Err(LoadError::Unsupported {
            path: path.to_owned(),
            named_by: named_by.clone(),
            extension: other.to_owned(),
            supported: "ply",
        }),
    }
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
