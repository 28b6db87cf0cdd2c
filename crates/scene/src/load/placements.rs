//! Repeated instances: in version 4.0 of the format an object may name a PLY file of frames.

use super::{
    check,
    context::Context,
    error::LoadError,
    file::Opened,
    format::{Frame, InstanceFile, SceneFile},
    ply,
};

/// Replaces each instance that names a file of frames by one instance for each frame in it: the
/// frame of the file after its own.
pub(super) fn expand(context: &Context<'_>, file: &mut SceneFile) -> Result<(), LoadError> {
    let mut expanded = Vec::new();
    for (i, (key, instance)) in std::mem::take(&mut file.instances.items).into_iter().enumerate() {
        let Some(name) = instance.instance.as_ref().filter(|name| !name.is_empty()) else {
            expanded.push((key, instance));
            continue;
        };
        let field = format!("instances[{i}].instance");
        let of_frames = context.locate(field, &format!("instances/{name}.ply"))?;
        let frames = match context.files.open(&of_frames)? {
            Opened::Disk(reader, length) => ply::read_frames(reader, length),
            Opened::Memory(bytes) => ply::read_frames(&*bytes, bytes.len() as u64),
        };
        let frames = frames.map_err(|problem| of_frames.fail(problem))?;
        let own = instance.lookat.map_or(instance.frame.0, |lookat| lookat.frame().as_daffine3());
        let base = key.as_ref().unwrap_or(&instance.name);
        for (k, frame) in frames.into_iter().enumerate() {
            let frame = Frame(frame * own);
            check::frame(format!("instance {k}"), frame)
                .map_err(|problem| of_frames.fail(problem))?;
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
