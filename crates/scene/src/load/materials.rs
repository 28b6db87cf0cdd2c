//! Materials of the files of meshes: the MTL files that they name, and images.

use super::{
    context::Context,
    error::LoadError,
    file::NamedFile,
    image,
    mesh::{Mesh, listed},
    obj::mtl,
};
use crate::Texture;
use std::{collections::HashMap, path::Path};

/// Completes the materials of a mesh by the files that define them, with a warning for each that
/// is missing.
pub(super) fn define(context: &Context<'_>, file: &NamedFile, mesh: &mut Mesh) {
    let mut defined = HashMap::new();
    for library in std::mem::take(&mut mesh.libraries) {
        // A statement names one file with blanks in its name, or several.
        let whole = beside(context, file, &library);
        let found: Vec<_> = match whole {
            Some(found) => vec![(library, Some(found))],
            None => {
                let names = library.split_ascii_whitespace();
                names.map(|name| (name.to_owned(), beside(context, file, name))).collect()
            }
        };
        for (name, found) in found {
            let Some(found) = found else {
                mesh.warnings.push(format!("the file {name:?} of materials is not beside it"));
                continue;
            };
            let read = context.files.read(&found);
            match read.and_then(|bytes| mtl::read(&bytes).map_err(|p| found.fail(p))) {
                Ok((materials, warnings)) => {
                    mesh.warnings.extend(warnings.iter().map(|text| format!("{name}: {text}")));
                    mesh.files.push(found.path);
                    for material in materials {
                        defined.entry(material.name.clone()).or_insert(material);
                    }
                }
                Err(error) => mesh.warnings.push(format!("materials left out: {error}")),
            }
        }
    }
    for material in &mut mesh.materials {
        if let Some(defined) = defined.remove(&material.name) {
            *material = defined;
        }
    }
}

/// Adds a warning about materials that are in use but nowhere defined.
pub(super) fn warn_of_undefined(mesh: &mut Mesh) {
    let mut used = mesh.faces.materials.clone();
    used.sort_unstable();
    used.dedup();
    let materials = used.iter().filter_map(|&index| mesh.materials.get(index as usize));
    let undefined =
        materials.filter(|material| material.color.is_none() && material.texture.is_none());
    let names: Vec<&str> = undefined.map(|material| material.name.as_str()).collect();
    if !names.is_empty() {
        let warning = format!("no colour is defined for the materials: {}", listed(&names));
        mesh.warnings.push(warning);
    }
}

/// Reads the image of a material; returns it with the file.
pub(super) fn texture(
    context: &Context<'_>,
    file: &NamedFile,
    name: &str,
) -> Result<(Texture, NamedFile), String> {
    let found = beside(context, file, name).ok_or_else(|| {
        format!("the image {name:?} of a material is not beside the file; left out")
    })?;
    let loaded = image::read(context, &found, false);
    let mut texture = loaded.map_err(|error: LoadError| format!("image left out: {error}"))?;
    image::mend(&mut texture);
    texture.pixels = texture.pixels.packed(texture.width);
    texture.name = name.to_owned();
    Ok((texture, found))
}

/// Returns the file of this name in the folder of `file`, below it or, if the name has a path of
/// another machine, in the folder itself; `None` if there is none.
fn beside(context: &Context<'_>, file: &NamedFile, name: &str) -> Option<NamedFile> {
    let folder = file.path.parent().unwrap_or(Path::new(""));
    let name = name.replace('\\', "/");
    let last = name.rsplit('/').next().unwrap_or_default();
    let allowed = |uri: &&str| {
        context.options.allow_outside_folder || !context.files.leads_outside(folder, uri)
    };
    let candidates = [name.as_str(), last].into_iter().filter(allowed);
    let mut paths = candidates.map(|uri| folder.join(uri));
    paths.find(|path| context.files.is_file(path)).map(|path| NamedFile::given(&path))
}
