//! Which scene a command is about: one that is built in, or a file.

use crate::message::warn;
use crate::{built_in, memory};
use anyhow::{Context, Error, Result, bail};
use rotund_scene::{Camera, LoadOptions, LoadProblem, Loaded, Scene, Up, load_bytes};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// A scene and what to call it.
#[derive(Debug)]
pub struct NamedScene {
    /// The name of a built-in scene, or of a file without its extension.
    pub name: String,
    /// The scene, which has a camera.
    pub scene: Scene,
    /// The files that the scene was read from; none for a built-in one.
    pub files: Vec<PathBuf>,
}

/// Security, error recovery and defaults for loading a scene.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct LoadArgs {
    /// Radius in meters of the points and lines of the file of a shape that is loaded by itself. It
    /// replaces the radii in the file, and the default of half the usual distance between
    /// neighbours.
    #[arg(long, value_name = "METERS", value_parser = radius)]
    radius: Option<f32>,
    /// Axis that points up in the file of a shape that is loaded by itself. Default: z for TCK,
    /// TRK, points as text and PLY without lines or faces, y for all others.
    #[arg(long, value_enum)]
    up: Option<UpAxis>,
    /// Leave out the floor of the file of a shape that is loaded by itself.
    #[arg(skip)]
    pub(crate) without_floor: bool,
    /// Replace textures that cannot be read by white, with a warning, instead of failing.
    #[arg(long)]
    keep_going: bool,
    /// Allow the scene to name files outside its own folder: only for scenes that you trust.
    #[arg(long)]
    allow_outside: bool,
}

/// The names of axes on the command line.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum UpAxis {
    Y,
    Z,
}

fn radius(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(radius) if radius > 0.0 && f32::is_finite(radius) => Ok(radius),
        _ => Err("a radius is a positive number of meters".to_owned()),
    }
}

impl LoadArgs {
    /// Returns the arguments as words of a command line.
    #[cfg(feature = "view")]
    pub(crate) fn words(&self) -> Vec<String> {
        let Self { radius, up, without_floor: _, keep_going, allow_outside } = *self;
        let mut words = Vec::new();
        words.extend(radius.map(|radius| format!("--radius={radius}")));
        words.extend(up.map(|axis| match axis {
            UpAxis::Y => "--up=y".to_owned(),
            UpAxis::Z => "--up=z".to_owned(),
        }));
        words.extend(keep_going.then(|| "--keep-going".to_owned()));
        words.extend(allow_outside.then(|| "--allow-outside".to_owned()));
        words
    }

    fn options(&self) -> LoadOptions {
        LoadOptions {
            allow_outside_folder: self.allow_outside,
            keep_going: self.keep_going,
            radius: self.radius,
            up: self.up.map(|axis| match axis {
                UpAxis::Y => Up::Y,
                UpAxis::Z => Up::Z,
            }),
            without_floor: self.without_floor,
        }
    }
}

/// Whether there is a scene of this name, or a file.
#[cfg(feature = "view")]
pub(crate) fn exists(name_or_path: &OsStr) -> bool {
    let is_built_in = |name| built_in::names().any(|built_in| built_in == name);
    name_or_path.to_str().is_some_and(is_built_in) || Path::new(name_or_path).is_file()
}

/// Whether a scene is the file of a shape that is loaded by itself.
pub(crate) fn is_lone(name_or_path: &OsStr) -> bool {
    // Built-in scenes have no extension.
    let extension = Path::new(name_or_path).extension();
    extension.is_some_and(|it| !it.eq_ignore_ascii_case("json"))
}

/// Loads a scene by the name of a built-in one or by the path of a file, of a scene or of a shape,
/// and prints the loader's warnings on standard error.
///
/// # Errors
///
/// If there is no such scene, the loader refuses it, or it has neither a camera nor any surface to
/// aim one at.
pub fn load(name_or_path: &OsStr, args: &LoadArgs) -> Result<NamedScene> {
    let (name, loaded) = load_silently(name_or_path, args)?;
    for warning in &loaded.warnings {
        warn(warning);
    }
    if loaded.scene.cameras.is_empty() {
        bail!("{name}: the scene has neither a camera nor anything to see");
    }
    Ok(NamedScene { name, scene: loaded.scene, files: loaded.files })
}

/// Loads a scene and its name, and leaves the warnings to the caller.
pub(crate) fn load_silently(name_or_path: &OsStr, args: &LoadArgs) -> Result<(String, Loaded)> {
    let options = args.options();
    let built_in = name_or_path.to_str().and_then(|name| built_in::load(name, &options));
    let name = |path: &OsStr| path.to_string_lossy().into_owned();
    if let Some(loaded) = built_in {
        return Ok((name(name_or_path), loaded?));
    }
    let path = Path::new(name_or_path);
    let is_path =
        name(name_or_path).contains(std::path::is_separator) || path.extension().is_some();
    if !is_path {
        bail!(
            "there is no built-in scene {name_or_path:?}; there are {}, or give the path of a \
             JSON, PLY, OBJ, SWC, TCK, TRK, XYZ, TXT, CSV, PTS or ASC file",
            built_in::names().collect::<Vec<_>>().join(", ")
        );
    }
    memory::check_file(path)?;
    let loaded = rotund_scene::load(path, &options).map_err(|error| match *error.problem {
        LoadProblem::OutsideFolder { .. } => Error::msg(format!("{error}: --allow-outside")),
        _ => error.into(),
    })?;
    Ok((name(path.file_stem().unwrap_or_default()), loaded))
}

/// Returns the index of the camera of that name, or of the first camera if `name` is `None`. A
/// camera as JSON is added to the scene.
pub(crate) fn find_camera(scene: &mut NamedScene, name: Option<&str>) -> Result<usize> {
    let Some(name) = name else { return Ok(0) };
    if name.trim_start().starts_with('{') {
        scene.scene.cameras.push(camera_from_json(name)?);
        return Ok(scene.scene.cameras.len() - 1);
    }
    let cameras = &scene.scene.cameras;
    cameras.iter().position(|camera| camera.name == name).with_context(|| {
        let names: Vec<&str> = cameras.iter().map(|camera| camera.name.as_str()).collect();
        format!("{} has no camera {name:?}, only: {}", scene.name, names.join(", "))
    })
}

/// Reads a camera as the loader reads an entry of `cameras` in a scene file.
fn camera_from_json(text: &str) -> Result<Camera> {
    // As a whole object it cannot end the list that it is put into.
    let whole: serde_json::Result<serde_json::Map<_, _>> = serde_json::from_str(text);
    whole.context("--camera is no JSON object")?;
    let scene = format!("{{\"cameras\": [{text}]}}");
    let options = LoadOptions::default();
    let loaded = load_bytes("--camera", scene.as_bytes(), &|_| None, &options)?;
    if let Some(warning) = loaded.warnings.first() {
        bail!("{warning}");
    }
    loaded.scene.cameras.into_iter().next().context("--camera has no camera")
}

#[cfg(test)]
mod tests {
    use super::camera_from_json;
    use crate::message::one_line;

    #[test]
    fn a_camera_is_an_entry_of_cameras_in_a_scene_file() {
        let text = r#"{"name": "near", "frame": [1,0,0, 0,1,0, 0,0,1, 0,1,3], "lens": 0.035}"#;
        let camera = camera_from_json(text).expect("a camera");
        assert_eq!((camera.name.as_str(), camera.lens, camera.aspect), ("near", 0.035, 1.5));
        assert_eq!(camera.world_from_camera.translation.to_array(), [0.0, 1.0, 3.0]);
        let usual = camera_from_json("{}").expect("a camera");
        assert_eq!(usual, rotund_scene::Camera::default());
    }

    #[test]
    fn a_mistake_in_a_camera_is_said_with_its_field() {
        let table = [
            ("a number that is none", r#"{"lens": NaN}"#, "--camera"),
            ("no lens", r#"{"lens": 0}"#, "lens"),
            ("too large a number", r#"{"focus": 1e99}"#, "focus"),
            ("a text for a number", r#"{"lens": "long"}"#, "lens"),
            ("eleven numbers", r#"{"frame": [1,0,0, 0,1,0, 0,0,1, 0,1]}"#, "frame"),
            ("no inverse", r#"{"frame": [0,0,0, 0,0,0, 0,0,0, 0,0,0]}"#, "frame"),
            ("an unknown field", r#"{"zoom": 2}"#, "zoom"),
            ("half an object", r#"{"lens": 1"#, "--camera"),
            ("more than an object", r#"{}], "shapes": [{}"#, "--camera"),
        ];
        for (why, text, word) in table {
            let error = camera_from_json(text).err().unwrap_or_else(|| panic!("{why}: accepted"));
            let message = one_line(&error);
            assert!(message.contains("--camera") && message.contains(word), "{why}: {message}");
        }
    }
}
