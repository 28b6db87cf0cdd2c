//! Conversion of older versions of the format to version 4.2.
//!
//! | version | arrays | shapes, textures, control meshes | references |
//! | --- | --- | --- | --- |
//! | 4.0, no number | objects by name | not listed: a file of that name in a folder of its kind |
//! name |
//! | 4.1 | objects by name | a `datafile` or its name, in a folder of its kind | name |
//! | 4.2, 4.3, 5.0 | arrays | a `uri` from the folder of the scene | index |
//!
//! A file may mix these forms, as real files do. Materials of early version 4.0 have no type: their
//! reflection and transmission determine it. Files of early 2021 name types `plastic`, `metal`,
//! `glass` and `thinglass`, files before version 4.2 `metallic` and `volume`.

use super::{
    collection::{Collection, Reference},
    context::Context,
    error::LoadError,
    format::{MaterialFile, MaterialType, SceneFile, ShapeFile, TextureFile},
};
use std::collections::HashSet;

const SHAPES: &[&str] = &["ply", "obj"];
const TEXTURES: &[&str] = &["hdr", "exr", "png", "jpg"];
const SEPARATORS: [char; 2] = ['/', '\\'];

/// Refuses scenes that are older than version 4.0: by their number, or, since they have none, by
/// the fields of shapes that only they have. `unknown` has the fields that no later version knows.
pub(super) fn refuse_early(
    context: &Context<'_>,
    file: &SceneFile,
    unknown: &[String],
) -> Result<(), LoadError> {
    const EXPECTED: &str =
        "a scene of version 4.0 or later; convert this one with the programs of yocto-gl";
    let version = file.asset.version.to_string();
    let number: Option<f64> = version.trim_matches('"').parse().ok();
    if number.is_some_and(|number| number < 4.0) {
        return Err(context.unexpected("asset.version", version, EXPECTED));
    }
    const EARLY: [&str; 6] = [
        "shapes[].filename",
        "shapes[].path",
        "textures[].filename",
        "textures[].path",
        "materials[].diffuse",
        "materials[].kd",
    ];
    let has_source = |shape: &ShapeFile| {
        shape.uri.is_some() || shape.datafile.is_some() || shape.generator.is_some()
    };
    let sourceless = file.shapes.items.iter().any(|(_, shape)| !has_source(shape));
    let early = EARLY.iter().find(|field| unknown.iter().any(|name| name == *field));
    match early.filter(|_| number.is_none() && sourceless) {
        Some(field) => Err(context.unexpected(*field, "given", EXPECTED)),
        None => Ok(()),
    }
}

/// Converts a file to version 4.2, except for references by name.
pub(super) fn spell_out(context: &Context<'_>, file: &mut SceneFile) {
    file.instances.items.append(&mut file.objects.items);
    for (_, shape) in &mut file.shapes.items {
        in_folder(context, "shapes", shape.datafile.take(), &mut shape.uri);
    }
    for (_, texture) in &mut file.textures.items {
        in_folder(context, "textures", texture.datafile.take(), &mut texture.uri);
    }
    for (key, subdiv) in &mut file.subdivs.items {
        in_folder(context, "subdivs", subdiv.datafile.take(), &mut subdiv.uri);
        if subdiv.uri.is_none() && subdiv.generator.is_none() {
            subdiv.uri = find(context, "subdivs", key.as_ref().unwrap_or(&subdiv.name), SHAPES);
        }
    }
    list_what_is_only_named(context, file);
    if file.asset.version.is_null() {
        for (_, material) in file.materials.items.iter_mut().filter(|(_, m)| m.kind.is_none()) {
            material.kind = Some(kind_without_type(material));
        }
    }
}

fn kind_without_type(material: &MaterialFile) -> MaterialType {
    let passes = material.transmission > 0.0 || material.translucency > 0.0;
    if passes && material.thin {
        MaterialType::Transparent
    } else if passes {
        MaterialType::Refractive
    } else if material.metallic > 0.0 {
        MaterialType::Reflective
    } else if material.specular > 0.0 || material.coat > 0.0 {
        MaterialType::Glossy
    } else {
        MaterialType::Matte
    }
}

/// Sets `uri` from `datafile`, unless it is set. A name without a folder refers to a file in the
/// folder of its kind if it exists only there, since some converters to version 4.2 omitted the
/// folder.
fn in_folder(
    context: &Context<'_>,
    kind: &str,
    datafile: Option<String>,
    uri: &mut Option<String>,
) {
    let folder = context.folder();
    let inside = |name: &str| format!("{kind}/{name}");
    match (&uri, datafile) {
        (None, Some(name)) => *uri = Some(inside(&name)),
        (Some(name), _)
            if !name.contains(SEPARATORS) && !context.files.exists(&folder.join(name)) =>
        {
            let moved = inside(name);
            if context.files.is_file(&folder.join(&moved)) {
                *uri = Some(moved);
            }
        }
        _ => {}
    }
}

/// Adds a shape or texture for each name that is referred to but not defined.
fn list_what_is_only_named(context: &Context<'_>, file: &mut SceneFile) {
    let mut shapes: Vec<_> =
        file.instances.items.iter().filter_map(|(_, instance)| instance.shape.clone()).collect();
    let of_subdivs: Vec<_> =
        file.subdivs.items.iter().filter_map(|(_, subdiv)| subdiv.shape.clone()).collect();
    shapes.extend(of_subdivs.iter().cloned());
    for name in missing(shapes, &file.shapes, |shape| &shape.name) {
        let uri = find(context, "shapes", &name, SHAPES);
        // The shape that a subdivision replaces needs no file.
        if uri.is_some() || of_subdivs.contains(&Reference::Name(name.clone())) {
            let shape = ShapeFile { uri, ..ShapeFile::default() };
            file.shapes.items.push((Some(name), shape));
        }
    }
    let mut textures = Vec::new();
    for (_, environment) in &file.environments.items {
        textures.extend(environment.emission_tex.clone());
    }
    for (_, subdiv) in &file.subdivs.items {
        textures.extend(subdiv.displacement_tex.clone());
    }
    for (_, material) in &file.materials.items {
        textures.extend(material.emission_tex.clone());
        textures.extend(material.color_tex.clone());
        textures.extend(material.roughness_tex.clone());
        textures.extend(material.scattering_tex.clone());
        textures.extend(material.normal_tex.clone());
    }
    for name in missing(textures, &file.textures, |texture| &texture.name) {
        let uri = find(context, "textures", &name, TEXTURES);
        if uri.is_some() {
            let texture = TextureFile { uri, ..TextureFile::default() };
            file.textures.items.push((Some(name), texture));
        }
    }
}

/// Returns the referenced names, each once, that no item has.
fn missing<T>(
    references: Vec<Reference>,
    collection: &Collection<T>,
    name_of: impl Fn(&T) -> &String,
) -> Vec<String> {
    let named = collection.items.iter().map(|(key, item)| key.as_ref().unwrap_or(name_of(item)));
    let mut known: HashSet<&str> = named.map(String::as_str).collect();
    let mut names = Vec::new();
    for reference in &references {
        if let Reference::Name(name) = reference
            && known.insert(name)
        {
            names.push(name.clone());
        }
    }
    names
}

/// Returns the file of this name in the folder of its kind, if it exists. Names with a separator
/// are refused.
fn find(context: &Context<'_>, kind: &str, name: &str, extensions: &[&str]) -> Option<String> {
    if name.is_empty() || name.contains(SEPARATORS) {
        return None;
    }
    let mut candidates = extensions.iter().map(|extension| format!("{kind}/{name}.{extension}"));
    candidates.find(|uri| context.files.is_file(&context.folder().join(uri)))
}
