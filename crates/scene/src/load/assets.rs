//! Textures and shapes of a scene, from files or generators.

use super::{
    context::Context,
    error::{LoadError, LoadProblem},
    file::{NamedFile, Opened},
    format::{SceneFile, ShapeFile, SubdivFile, TextureFile},
    image, materials,
    mesh::{self, Mesh},
    obj, ply, points,
    radius::default_radius,
    resolve,
    subdivide::{self, Subdivision},
    swc,
    tracks::{tck, trk},
};
use crate::{
    Shape, Texture,
    generate::{Geometry, Unfit},
    validate,
};
use glam::DVec3;
use rayon::prelude::*;
use std::{collections::HashMap, path::PathBuf};

/// The source of a texture or shape: a file by its `uri`, or a generator.
struct Source<'s, 'a, G> {
    context: &'s Context<'a>,
    /// Path of the item in the scene file, as in `textures[2]`.
    field: String,
    uri: Option<&'s String>,
    generator: Option<&'s G>,
}

impl<G> Source<'_, '_, G> {
    /// Reads the file or runs the generator.
    fn get<T>(
        &self,
        read: impl Fn(&NamedFile) -> Result<T, LoadError>,
        build: impl Fn(&G) -> Result<T, Unfit>,
    ) -> Result<T, LoadError> {
        match (self.uri, self.generator) {
            (Some(uri), None) => read(&self.context.locate(format!("{}.uri", self.field), uri)?),
            (None, Some(generator)) => build(generator).map_err(|unfit| {
                let field = format!("{}.generator.{}", self.field, unfit.parameter);
                self.context.unexpected(field, unfit.value, unfit.expected)
            }),
            (uri, _) => {
                let value = if uri.is_some() { "beside a generator" } else { "missing" };
                let expected = "either the name of a file or a generator";
                Err(self.context.unexpected(format!("{}.uri", self.field), value, expected))
            }
        }
    }
}

/// Loads all textures, in order. A file that several of them name is decoded once.
pub(super) fn textures(
    context: &mut Context<'_>,
    file: &SceneFile,
) -> Result<Vec<Texture>, LoadError> {
    let shared = &*context;
    let are_data = resolve::are_data(file);
    let mut first_of = HashMap::new();
    let items = file.textures.items.iter().enumerate();
    let originals: Vec<usize> = items
        .map(|(i, (_, texture))| match &texture.uri {
            Some(uri) if texture.generator.is_none() => {
                *first_of.entry((uri, are_data[i])).or_insert(i)
            }
            _ => i,
        })
        .collect();
    let load = |i: usize| {
        let texture: &TextureFile = &file.textures.items[i].1;
        let source = Source {
            context: shared,
            field: format!("textures[{i}]"),
            uri: texture.uri.as_ref(),
            generator: texture.generator.as_ref(),
        };
        let read = |file: &NamedFile| image::read(shared, file, are_data[i]);
        let mut loaded = source.get(read, |generator| generator.build())?;
        let mended = image::mend(&mut loaded);
        loaded.pixels = loaded.pixels.packed(loaded.width);
        let warning = (mended > 0).then(|| {
            shared.warning(format_args!(
                "textures[{i}] has pixels that are not finite, taken as black: {mended}"
            ))
        });
        Ok((loaded, warning))
    };
    let loaded: Vec<Option<Result<_, LoadError>>> = originals
        .par_iter()
        .enumerate()
        .map(|(i, &original)| (i == original).then(|| load(i)))
        .collect();
    let mut textures: Vec<Texture> = Vec::new();
    for ((result, original), (key, described)) in
        loaded.into_iter().zip(originals).zip(&file.textures.items)
    {
        let texture = match result {
            None => textures[original].clone(),
            Some(Err(error)) if context.options.keep_going => {
                context.warnings.push(format!("texture left out and replaced by white: {error}"));
                Texture::default()
            }
            Some(result) => {
                let (texture, warning) = result?;
                context.warnings.extend(warning);
                texture
            }
        };
        let name = key.clone().unwrap_or_else(|| described.name.clone());
        textures.push(Texture { name, ..texture });
    }
    Ok(textures)
}

/// What an item of the shapes of a scene describes.
pub(super) struct LoadedShape {
    /// One shape, and more if the file has elements of several kinds.
    pub shapes: Vec<Shape>,
    /// What has been subtracted from all positions.
    pub offset: DVec3,
    warnings: Vec<String>,
    /// Files beside the one that the scene names.
    files: Vec<PathBuf>,
}

/// Loads all shapes, in order; `textures` serve as displacement maps. Returns them with the files
/// that were read beside those that the scene names.
pub(super) fn shapes(
    context: &mut Context<'_>,
    file: &SceneFile,
    textures: &[Texture],
) -> Result<(Vec<LoadedShape>, Vec<PathBuf>), LoadError> {
    let subdivs = resolve::subdivs(file).map_err(|problem| context.fail(problem))?;
    let shared = &*context;
    let load = |(i, (key, shape)): (usize, &(Option<String>, ShapeFile))| {
        // A subdivision replaces its shape, whose own file is not read.
        let mut numbered = subdivs.iter().enumerate();
        let subdiv = numbered.rfind(|(_, subdiv)| subdiv.shape as usize == i);
        let mut loaded = match subdiv {
            Some((k, references)) => {
                let described: &SubdivFile = &file.subdivs.items[k].1;
                let source = Source {
                    context: shared,
                    field: format!("subdivs[{k}]"),
                    uri: described.uri.as_ref(),
                    generator: described.generator.as_ref(),
                };
                let mut control = read_shape(&source)?;
                let texture = references.displacement_tex.map(|index| &textures[index as usize]);
                control.shapes[0] = subdivided(&source, &control.shapes[0], described, texture)?;
                control
            }
            None => read_shape(&Source {
                context: shared,
                field: format!("shapes[{i}]"),
                uri: shape.uri.as_ref(),
                generator: shape.generator.as_ref(),
            })?,
        };
        for loaded in &mut loaded.shapes {
            loaded.name = key.clone().unwrap_or_else(|| shape.name.clone());
            if let Some(method) = shape.method.or(file.method) {
                loaded.method = method;
            }
            if let Some(overlap) = shape.overlap {
                loaded.overlap = overlap;
            }
        }
        // Values from files are checked already; generators and subdivisions may overflow.
        if shape.generator.is_some() || subdiv.is_some() {
            validate::shape(i, &loaded.shapes[0])
                .map_err(|error| shared.fail(LoadProblem::Scene { error }))?;
        }
        Ok(loaded)
    };
    let loaded: Vec<_> = file.shapes.items.par_iter().enumerate().map(load).collect();
    let mut loaded = loaded.into_iter().collect::<Result<Vec<LoadedShape>, LoadError>>()?;
    let mut files = Vec::new();
    for shape in &mut loaded {
        context.warnings.append(&mut shape.warnings);
        files.append(&mut shape.files);
    }
    Ok((loaded, files))
}

/// Lists the scene file, the files that it names, without those that do not exist because a
/// subdivision replaces their shape, and `more`.
pub(super) fn files(context: &Context<'_>, file: &SceneFile, more: Vec<PathBuf>) -> Vec<PathBuf> {
    let textures = file.textures.items.iter().filter_map(|(_, texture)| texture.uri.as_ref());
    let shapes = file.shapes.items.iter().filter_map(|(_, shape)| shape.uri.as_ref());
    let subdivs = file.subdivs.items.iter().filter_map(|(_, subdiv)| subdiv.uri.as_ref());
    let named = textures.chain(shapes).chain(subdivs).map(|uri| context.folder().join(uri));
    let mut files: Vec<_> = named.filter(|path| context.files.is_file(path)).collect();
    files.push(context.scene.clone());
    files.extend(more);
    files.sort();
    files.dedup();
    files
}

/// Loads the shapes of one item.
fn read_shape(source: &Source<'_, '_, Geometry>) -> Result<LoadedShape, LoadError> {
    source.get(
        |file| {
            let mut mesh = read_mesh(source.context, file)?;
            mesh.materials_to_colors();
            // PLY and OBJ are the formats of yocto-gl, which has this default. The others may be in
            // millimeters or angstroms.
            let usual = matches!(file.extension().as_str(), "ply" | "obj");
            let radius = if usual || !mesh.radii.is_empty() {
                mesh::DEFAULT_RADIUS
            } else {
                default_radius(&mesh)
            };
            let of_file = |warning| format!("{}: {warning}", file.path.display());
            Ok(LoadedShape {
                offset: mesh.offset,
                warnings: mesh.warnings.drain(..).map(of_file).collect(),
                files: std::mem::take(&mut mesh.files),
                shapes: mesh.into_parts(radius).into_iter().map(|part| part.shape).collect(),
            })
        },
        |generator| {
            Ok(LoadedShape {
                shapes: vec![generator.build()?],
                offset: DVec3::ZERO,
                warnings: Vec::new(),
                files: Vec::new(),
            })
        },
    )
}

fn subdivided(
    source: &Source<'_, '_, Geometry>,
    control: &Shape,
    described: &SubdivFile,
    displacement_tex: Option<&Texture>,
) -> Result<Shape, LoadError> {
    let unfit = |field: &str, value: String, expected| {
        source.context.unexpected(format!("{}.{field}", source.field), value, expected)
    };
    match subdivide::quads_after(control, described.subdivisions) {
        None => return Err(unfit("uri", "without faces".to_owned(), "a mesh")),
        Some(quads) if quads > subdivide::MOST_QUADS => {
            let value = described.subdivisions.to_string();
            return Err(unfit("subdivisions", value, "few enough for 8388608 quads in the end"));
        }
        Some(_) => {}
    }
    let displacement = described.displacement;
    if !displacement.is_finite() {
        return Err(unfit("displacement", displacement.to_string(), "a finite number"));
    }
    let displacement_tex = displacement_tex.filter(|_| displacement != 0.0);
    if displacement_tex.is_some() && control.texcoords.is_empty() {
        let expected = "none, since the mesh has no texture coordinates";
        return Err(unfit("displacement_tex", "given".to_owned(), expected));
    }
    Ok(subdivide::subdivide(
        control,
        &Subdivision {
            levels: described.subdivisions,
            catmull_clark: described.catmullclark,
            smooth: described.smooth,
            displacement: displacement_tex.map(|texture| (displacement, texture)),
        },
    ))
}

/// The extensions of files that [`read_mesh`] reads, for messages.
const SUPPORTED: &str = "ply, obj, swc, tck, trk, xyz, txt, csv, pts and asc";

/// Returns true for the extensions of files that [`read_mesh`] reads.
pub(super) fn is_mesh(extension: &str) -> bool {
    matches!(extension, "ply" | "obj" | "swc" | "tck" | "trk")
        || points::EXTENSIONS.contains(&extension)
}

/// Reads a file of points, lines or faces, by its extension, and the materials that it names. The
/// mesh is valid.
pub(super) fn read_mesh(context: &Context<'_>, file: &NamedFile) -> Result<Mesh, LoadError> {
    let mesh = match file.extension().as_str() {
        "ply" => match context.files.open(file)? {
            Opened::Disk(reader, length) => ply::read(reader, length),
            Opened::Memory(bytes) => ply::read(&*bytes, bytes.len() as u64),
        },
        "obj" => obj::read(&context.files.read(file)?),
        "swc" => swc::read(&context.files.read(file)?),
        "tck" => tck::read(&context.files.read(file)?),
        "trk" => trk::read(&context.files.read(file)?),
        text if points::EXTENSIONS.contains(&text) => {
            points::read(&context.files.read(file)?, text)
        }
        other => {
            let extension = other.to_owned();
            Err(LoadProblem::Unsupported { extension, supported: SUPPORTED })
        }
    };
    let mut mesh = mesh.map_err(|problem| file.fail(problem))?;
    materials::define(context, file, &mut mesh);
    mesh.color_lines_by_materials();
    mesh.settle().map_err(|problem| file.fail(problem))?;
    if !mesh.colors.is_empty() && mesh.colors.iter().all(|color| color.w == 0.0) {
        mesh.colors.par_iter_mut().for_each(|color| color.w = 1.0);
        mesh.warnings.push("alpha is 0 at every vertex; taken as opaque".to_owned());
    }
    Ok(mesh)
}
