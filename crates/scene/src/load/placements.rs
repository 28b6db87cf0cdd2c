//! Instances by the hundred: version 4.0 of the format lets an object name a PLY file of frames.

use super::{
    LoadOptions, check,
    error::NamedBy,
    file,
    format::{Frame, InstanceFile, SceneFile},
    ply,
};
use crate::LoadError;
use std::{io::BufReader, path::Path};

/// Makes of each instance that names a file of frames as many instances as there are frames in it: the
/// frame of the file after its own.
pub(super) fn expand(
    scene: &Path,
    file: &mut SceneFile,
    options: &LoadOptions,
) -> Result<(), LoadError> {
    let mut expanded = Vec::new();
    for (i, (key, instance)) in std::mem::take(&mut file.instances.items).into_iter().enumerate() {
        let Some(name) = instance.instance.as_ref().filter(|name| !name.is_empty()) else {
            expanded.push((key, instance));
            continue;
        };
        let field = format!("instances[{i}].instance");
        let uri = format!("instances/{name}.ply");
        let path = file::resolve(scene, &field, &uri, options.allow_outside_folder)?;
        let (opened, length) = file::open(&path, &NamedBy(Some((scene.to_owned(), field))))?;
        let frames = ply::read_frames(&path, BufReader::new(opened), length)?;
        let own = instance.lookat.map_or(instance.frame.0, |lookat| lookat.frame());
        let base = key.as_ref().unwrap_or(&instance.name);
        for (k, frame) in frames.into_iter().enumerate() {
            let frame = Frame(frame * own);
            check::frame(&path, || format!("instance {k}"), frame)?;
            expanded.push((
                Some(format!("{base}_{k}")),
                InstanceFile {
                    frame,
                    shape: instance.shape.clone(),
                    material: instance.material.clone(),
                    ..InstanceFile::default()
                },
            ));
        }
    }
    file.instances.items = expanded;
    Ok(())
}
