//! Conversion of a scene file to the arrays of a scene: references, frames, kinds of materials.

use super::{
    collection::{Collection, Reference},
    context::Context,
    error::{LoadError, LoadProblem},
    format::{MaterialFile, MaterialType, SceneFile, SubdivFile},
};
use crate::{Camera, Environment, Instance, Material, MaterialKind, Scene};
use std::collections::HashMap;

/// Converts everything but textures and shapes.
pub(super) fn resolve(context: &mut Context<'_>, file: &SceneFile) -> Result<Scene, LoadError> {
    for (i, (_, material)) in file.materials.items.iter().enumerate() {
        if material.kind == Some(MaterialType::GltfPbr) {
            let name = if material.metallic < 0.5 { "glossy" } else { "reflective" };
            context.warn(format_args!(
                "materials[{i}].type is gltfpbr, which is not supported: taken as {name}"
            ));
        }
    }
    references(file).map_err(|problem| context.fail(problem))
}

fn references(file: &SceneFile) -> Result<Scene, LoadProblem> {
    let textures = Names::new("textures", &file.textures, |texture| &texture.name);
    let materials = Names::new("materials", &file.materials, |material| &material.name);
    let shapes = Names::new("shapes", &file.shapes, |shape| &shape.name);
    let mut scene = Scene::default();
    for (key, camera) in &file.cameras.items {
        let default = Camera::default();
        scene.cameras.push(Camera {
            name: key.clone().unwrap_or_else(|| camera.name.clone()),
            world_from_camera: camera.lookat.map_or(camera.frame.single(), |l| l.frame()),
            orthographic: camera.orthographic,
            lens: camera.lens,
            film: camera.film,
            aspect: camera.aspect,
            // The target of `lookat` is in focus, even if `focus` is given.
            focus: camera
                .lookat
                .map(|lookat| lookat.distance())
                .or(camera.focus)
                .unwrap_or(default.focus),
            aperture: camera.aperture,
        });
    }
    for (i, (key, environment)) in file.environments.items.iter().enumerate() {
        scene.environments.push(Environment {
            name: key.clone().unwrap_or_else(|| environment.name.clone()),
            world_from_environment: environment
                .lookat
                .map_or(environment.frame.single(), |lookat| lookat.frame()),
            emission: environment.emission.into(),
            emission_tex: textures.optional(
                &|| format!("environments[{i}].emission_tex"),
                environment.emission_tex.as_ref(),
            )?,
        });
    }
    for (i, (key, material)) in file.materials.items.iter().enumerate() {
        let texture = |name: &str, reference: &Option<Reference>| {
            textures.optional(&|| format!("materials[{i}].{name}"), reference.as_ref())
        };
        scene.materials.push(Material {
            name: key.clone().unwrap_or_else(|| material.name.clone()),
            kind: kind(material),
            emission: material.emission.into(),
            color: material.color.into(),
            roughness: material.roughness,
            ior: material.ior,
            trdepth: material.trdepth,
            albedo: material.scattering.into(),
            anisotropy: material.scanisotropy,
            opacity: material.opacity,
            emission_tex: texture("emission_tex", &material.emission_tex)?,
            color_tex: texture("color_tex", &material.color_tex)?,
            roughness_tex: texture("roughness_tex", &material.roughness_tex)?,
            scattering_tex: texture("scattering_tex", &material.scattering_tex)?,
            normal_tex: texture("normal_tex", &material.normal_tex)?,
        });
    }
    for (i, (key, instance)) in file.instances.items.iter().enumerate() {
        scene.instances.push(Instance {
            name: key.clone().unwrap_or_else(|| instance.name.clone()),
            world_from_object: instance.lookat.map_or(instance.frame.single(), |l| l.frame()),
            shape: shapes.required(&|| format!("instances[{i}].shape"), instance.shape.as_ref())?,
            material: materials
                .required(&|| format!("instances[{i}].material"), instance.material.as_ref())?,
        });
    }
    Ok(scene)
}

fn kind(material: &MaterialFile) -> MaterialKind {
    match material.kind.unwrap_or_default() {
        MaterialType::Matte => MaterialKind::Matte,
        MaterialType::Glossy => MaterialKind::Glossy,
        MaterialType::Reflective => MaterialKind::Reflective,
        // yocto-gl renders both alike.
        MaterialType::Refractive | MaterialType::Subsurface => MaterialKind::Refractive,
        MaterialType::Transparent => MaterialKind::Transparent,
        MaterialType::Volumetric => MaterialKind::Volumetric,
        MaterialType::GltfPbr if material.metallic < 0.5 => MaterialKind::Glossy,
        MaterialType::GltfPbr => MaterialKind::Reflective,
    }
}

/// The references of a subdivision.
#[derive(Clone, Copy)]
pub(super) struct SubdivReferences {
    /// The shape that it replaces.
    pub shape: u32,
    pub displacement_tex: Option<u32>,
}

/// Resolves the references of all subdivisions, in order.
pub(super) fn subdivs(file: &SceneFile) -> Result<Vec<SubdivReferences>, LoadProblem> {
    let textures = Names::new("textures", &file.textures, |texture| &texture.name);
    let shapes = Names::new("shapes", &file.shapes, |shape| &shape.name);
    let resolve = |(i, (_, subdiv)): (usize, &(Option<String>, SubdivFile))| {
        Ok(SubdivReferences {
            shape: shapes.required(&|| format!("subdivs[{i}].shape"), subdiv.shape.as_ref())?,
            displacement_tex: textures.optional(
                &|| format!("subdivs[{i}].displacement_tex"),
                subdiv.displacement_tex.as_ref(),
            )?,
        })
    };
    file.subdivs.items.iter().enumerate().map(resolve).collect()
}

/// Returns for each texture whether it is data anywhere, such as a height, and not a colour.
pub(super) fn are_data(file: &SceneFile) -> Vec<bool> {
    let textures = Names::new("textures", &file.textures, |texture| &texture.name);
    let of_materials = file.materials.items.iter();
    let references = of_materials
        .flat_map(|(_, material)| [&material.normal_tex, &material.roughness_tex])
        .chain(file.subdivs.items.iter().map(|(_, subdiv)| &subdiv.displacement_tex));
    let mut are_data = vec![false; file.textures.items.len()];
    for reference in references {
        // Whoever needs the texture reports a reference to nothing.
        if let Ok(Some(index)) = textures.optional(&String::new, reference.as_ref()) {
            are_data[index as usize] = true;
        }
    }
    are_data
}

/// The names of the items of one array, to resolve references.
struct Names<'a> {
    what: &'static str,
    count: usize,
    by_name: HashMap<&'a str, u32>,
}

impl<'a> Names<'a> {
    fn new<T>(
        what: &'static str,
        collection: &'a Collection<T>,
        name: impl Fn(&'a T) -> &'a String,
    ) -> Self {
        let mut by_name = HashMap::new();
        for (i, (key, item)) in (0..).zip(&collection.items) {
            // Of items with the same name, the first counts.
            by_name.entry(key.as_ref().unwrap_or_else(|| name(item)).as_str()).or_insert(i);
        }
        Self { what, count: collection.items.len(), by_name }
    }

    fn required(
        &self,
        field: &dyn Fn() -> String,
        reference: Option<&Reference>,
    ) -> Result<u32, LoadProblem> {
        match reference {
            Some(reference) => self.find(field, reference),
            None => Err(LoadProblem::Value {
                field: field(),
                value: "missing".to_owned(),
                expected: "an index or a name",
            }),
        }
    }

    fn optional(
        &self,
        field: &dyn Fn() -> String,
        reference: Option<&Reference>,
    ) -> Result<Option<u32>, LoadProblem> {
        match reference {
            None => Ok(None),
            Some(Reference::Index(-1)) => Ok(None),
            Some(Reference::Name(name)) if name.is_empty() => Ok(None),
            Some(reference) => self.find(field, reference).map(Some),
        }
    }

    fn find(&self, field: &dyn Fn() -> String, reference: &Reference) -> Result<u32, LoadProblem> {
        match reference {
            Reference::Index(index) => match u32::try_from(*index) {
                Ok(found) if (found as usize) < self.count => Ok(found),
                _ => Err(LoadProblem::IndexOutOfRange {
                    field: field(),
                    value: *index,
                    what: self.what,
                    count: self.count,
                }),
            },
            Reference::Name(name) => self.by_name.get(name.as_str()).copied().ok_or_else(|| {
                LoadProblem::UnknownName { field: field(), name: name.clone(), what: self.what }
            }),
        }
    }
}
