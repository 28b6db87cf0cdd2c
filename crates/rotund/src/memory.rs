//! Refusal, in one line and before it begins, of work that there is too little memory for.
//!
//! Arrays whose sizes the input decides are allocated deep inside of loaders and trees, where a
//! failure ends the process. So as much memory as they take at the peak is reserved beforehand, and
//! given back at once. Where the address space is limited (`ulimit -v`, as batch systems do) or
//! memory is not overcommitted, that reservation fails in their place.

use crate::exit::NoMemory;
use anyhow::{Result, bail};
use rotund_scene::{ElementKind, Scene};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Bytes that a loader takes for each byte of a file: three coordinates of 4 bytes become 16 bytes
/// with a radius, and the array grows by copying.
const LOADED: u64 = 2;
/// Bytes that an emitting element takes in the tables of lights.
const LIGHT: u64 = 370;
/// Bytes of an instance in tree and tables.
const INSTANCE: u64 = 300;
/// Bytes of a pixel for an image and its encoder, by measurement: the image has 16.
const PICTURE: u64 = 32;
/// Bytes of a pixel for layers, and for their copies as the channels of a file.
const LAYERS: u64 = 144;
/// Bytes for stacks of threads and their parts of the heap.
const MARGIN: u64 = 128 << 20;

/// Makes sure that a scene with the shapes that it names can be loaded.
pub(crate) fn check_file(path: &Path) -> Result<()> {
    // What cannot be read is the loader's to report.
    let length = |path: &Path| fs::metadata(path).map_or(0, |file| file.len());
    let mut bytes = length(path);
    let is_json = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    let text = if is_json { fs::read(path).unwrap_or_default() } else { Vec::new() };
    if let (Ok(json), Some(folder)) = (serde_json::from_slice::<Value>(&text), path.parent()) {
        let mut names = Vec::new();
        shapes_named(&json, &mut names);
        names.sort_unstable();
        names.dedup();
        bytes += names.iter().map(|name| length(&folder.join(name))).sum::<u64>();
    }
    reserve(bytes.saturating_mul(LOADED), || format!("load {}", path.display()))
}

/// Makes sure that the trees and lights of a scene fit into memory.
pub(crate) fn check_scene(scene: &Scene) -> Result<()> {
    let mut bytes = scene.instances.len() as u64 * INSTANCE;
    for shape in &scene.shapes {
        bytes += shape.elements.count() as u64 * tree_bytes(shape.elements.kind());
    }
    for instance in &scene.instances {
        let material = &scene.materials[instance.material as usize];
        if material.emission.max_element() > 0.0 {
            bytes += scene.shapes[instance.shape as usize].elements.count() as u64 * LIGHT;
        }
    }
    reserve(bytes, || "build the trees of the scene".to_owned())
}

/// Makes sure that a picture, with layers or without, can be made of a film that is in memory, and
/// written.
pub(crate) fn check_picture(width: u32, height: u32, layers: bool) -> Result<()> {
    let pixels = u64::from(width) * u64::from(height);
    let bytes = PICTURE + if layers { LAYERS } else { 0 };
    reserve(pixels * bytes, || format!("write a picture of {width} x {height}"))
}

/// Returns the bytes that an element takes while its tree is built, by measurement.
fn tree_bytes(kind: ElementKind) -> u64 {
    match kind {
        ElementKind::Points => 70,
        ElementKind::Lines => 110,
        ElementKind::Triangles => 110,
        ElementKind::Quads => 140,
    }
}

/// Collects all texts that are names of files of shapes.
fn shapes_named<'a>(json: &'a Value, names: &mut Vec<&'a str>) {
    match json {
        Value::String(text) => {
            let extension = text.rsplit_once('.').map(|(_, extension)| extension);
            if extension.is_some_and(|e| ["ply", "obj", "swc", "tck", "trk"].contains(&e)) {
                names.push(text);
            }
        }
        Value::Array(values) => values.iter().for_each(|value| shapes_named(value, names)),
        Value::Object(fields) => fields.values().for_each(|value| shapes_named(value, names)),
        _ => {}
    }
}

/// Makes sure that so many bytes can be allocated.
fn reserve(bytes: u64, what: impl FnOnce() -> String) -> Result<()> {
    let wanted = usize::try_from(bytes.saturating_add(MARGIN)).unwrap_or(usize::MAX);
    if Vec::<u8>::new().try_reserve_exact(wanted).is_err() {
        let megabytes = bytes.div_ceil(1 << 20);
        bail!(NoMemory(format!("not enough memory to {}: it takes {megabytes} MiB", what())));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{reserve, shapes_named};

    #[test]
    fn more_than_the_address_space_is_refused_in_a_sentence() {
        let error = reserve(1 << 60, || "load a.ply".to_owned()).expect_err("too much").to_string();
        assert_eq!(error, "not enough memory to load a.ply: it takes 1099511627776 MiB");
        assert!(reserve(1 << 20, String::new).is_ok());
    }

    #[test]
    fn files_of_shapes_are_found_in_any_version_of_a_scene() {
        let json = r#"{"shapes": [{"uri": "a.ply"}], "subdivs": {"x": {"datafile": "b.obj"}},
            "textures": ["c.png"]}"#;
        let json = serde_json::from_str(json).expect("JSON");
        let mut names = Vec::new();
        shapes_named(&json, &mut names);
        assert_eq!(names, ["a.ply", "b.obj"]);
    }
}
