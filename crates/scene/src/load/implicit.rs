//! Version 4.0 of the format lists no shapes and textures: a name is a file in a folder of its kind.

use super::{
    collection::{Collection, Reference},
    format::{SceneFile, ShapeFile, TextureFile},
};
use std::path::Path;

/// Adds a shape or texture for each name that nothing in the file has, if there is such a file.
pub(super) fn add(path: &Path, file: &mut SceneFile) {
    let folder = path.parent().unwrap_or(Path::new(""));
    let shapes = file.instances.items.iter().filter_map(|(_, instance)| instance.shape.clone());
    for name in missing(shapes.collect(), &file.shapes, |shape| &shape.name) {
        let uri = find(folder, "shapes", &name, &["ply", "obj"]);
        if uri.is_some() {
            let shape = ShapeFile { uri, ..ShapeFile::default() };
            file.shapes.items.push((Some(name), shape));
        }
    }
    let mut textures = Vec::new();
    for (_, environment) in &file.environments.items {
        textures.extend(environment.emission_tex.clone());
    }
    for (_, material) in &file.materials.items {
        textures.extend(material.emission_tex.clone());
        textures.extend(material.color_tex.clone());
        textures.extend(material.roughness_tex.clone());
        textures.extend(material.normal_tex.clone());
    }
    for name in missing(textures, &file.textures, |texture| &texture.name) {
        let uri = find(folder, "textures", &name, &["hdr", "exr", "png", "jpg"]);
        if uri.is_some() {
            let texture = TextureFile { uri, ..TextureFile::default() };
            file.textures.items.push((Some(name), texture));
        }
    }
}

/// The names, each once, that no item has.
fn missing<T>(
    references: Vec<Reference>,
    collection: &Collection<T>,
    name_of: impl Fn(&T) -> &String,
) -> Vec<String> {
    let mut names = Vec::new();
    for reference in references {
        let Reference::Name(name) = reference else { continue };
        let has =
            |(key, item): &(Option<String>, T)| key.as_ref().unwrap_or(name_of(item)) == &name;
        if !names.contains(&name) && !collection.items.iter().any(has) {
            names.push(name);
        }
    }
    names
}

/// Names with a separator in them are no names of files in a folder.
fn find(folder: &Path, kind: &str, name: &str, extensions: &[&str]) -> Option<String> {
    if name.contains(['/', '\\']) {
        return None;
    }
    let candidates = extensions.iter().map(|extension| format!("{kind}/{name}.{extension}"));
    candidates.into_iter().find(|uri| folder.join(uri).is_file())
}
