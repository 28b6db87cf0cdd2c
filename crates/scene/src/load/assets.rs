//! Textures and shapes of a scene: from their files, or from generators.

use super::{
    LoadOptions,
    error::NamedBy,
    file,
    format::{SceneFile, ShapeFile, SubdivFile, TextureFile},
    image,
    mesh::{self, Mesh},
    obj, ply, resolve,
    subdivide::{self, Subdivision},
};
use crate::{
    LoadError, Shape, Texture,
    generate::{Geometry, Unfit},
};
use rayon::prelude::*;
use std::{
    io::BufReader,
    path::{Path, PathBuf},
};

/// Where something comes from, by `uri` or `generator`.
struct Source<'a, G> {
    scene: &'a Path,
    /// As in `textures[2]`.
    field: String,
    uri: Option<&'a String>,
    generator: Option<&'a G>,
    allow_outside: bool,
}

impl<G> Source<'_, G> {
    /// Reads or builds it, whichever the scene says.
    fn get<T>(
        &self,
        read: impl Fn(&Path, &NamedBy) -> Result<T, LoadError>,
        build: impl Fn(&G) -> Result<T, Unfit>,
    ) -> Result<T, LoadError> {
        match (self.uri, self.generator) {
            (Some(uri), None) => {
                let field = format!("{}.uri", self.field);
                let path = file::resolve(self.scene, &field, uri, self.allow_outside)?;
                read(&path, &NamedBy(Some((self.scene.to_owned(), field))))
            }
            (None, Some(generator)) => build(generator).map_err(|unfit| LoadError::Value {
                path: self.scene.to_owned(),
                field: format!("{}.generator.{}", self.field, unfit.parameter),
                value: unfit.value,
                expected: unfit.expected,
            }),
            (uri, _) => Err(LoadError::Value {
                path: self.scene.to_owned(),
                field: format!("{}.uri", self.field),
                value: if uri.is_some() { "beside a generator" } else { "missing" }.to_owned(),
                expected: "either the name of a file or a generator",
            }),
        }
    }
}

/// All textures, in order.
pub(super) fn textures(
    scene: &Path,
    file: &SceneFile,
    options: &LoadOptions,
    warnings: &mut Vec<String>,
) -> Result<Vec<Texture>, LoadError> {
    let load = |(i, (key, texture)): (usize, &(Option<String>, TextureFile))| {
        let source = Source {
            scene,
            field: format!("textures[{i}]"),
            uri: texture.uri.as_ref(),
            generator: texture.generator.as_ref(),
            allow_outside: options.allow_outside_folder,
        };
        let mut loaded = source.get(image::load, |generator| generator.build())?;
        loaded.name = key.clone().unwrap_or_else(|| texture.name.clone());
        let mended = image::mend(&mut loaded);
        loaded.pixels = loaded.pixels.packed(loaded.width);
        let warning = (mended > 0).then(|| {
            let scene = scene.display();
            format!(
                "{scene}: textures[{i}] has {mended} pixels that are not finite; taken as black"
            )
        });
        Ok((loaded, warning))
    };
    let loaded: Vec<_> = file.textures.items.par_iter().enumerate().map(load).collect();
    let mut textures = Vec::new();
    for result in loaded {
        match result {
            Err(error) if options.keep_going => {
                warnings.push(format!("left out, white instead: {error}"));
                textures.push(Texture::default());
            }
            result => {
                let (texture, warning) = result?;
                textures.push(texture);
                warnings.extend(warning);
            }
        }
    }
    Ok(textures)
}

/// All shapes, in order; `textures` are for displacement.
pub(super) fn shapes(
    scene: &Path,
    file: &SceneFile,
    options: &LoadOptions,
    textures: &[Texture],
    warnings: &mut Vec<String>,
) -> Result<Vec<Shape>, LoadError> {
    let subdivs = resolve::subdivs(scene, file)?;
    let load = |(i, (key, shape)): (usize, &(Option<String>, ShapeFile))| {
        // A subdivision takes the place of its shape, whose own file nobody needs.
        let mut numbered = subdivs.iter().enumerate();
        let subdiv = numbered.rfind(|(_, subdiv)| subdiv.shape as usize == i);
        let (mut loaded, warnings) = match subdiv {
            Some((k, references)) => {
                let described: &SubdivFile = &file.subdivs.items[k].1;
                let source = Source {
                    scene,
                    field: format!("subdivs[{k}]"),
                    uri: described.uri.as_ref(),
                    generator: described.generator.as_ref(),
                    allow_outside: options.allow_outside_folder,
                };
                let (control, warnings) = read_shape(&source)?;
                let texture = references.displacement_tex.map(|index| &textures[index as usize]);
                (subdivided(&source, &control, described, texture)?, warnings)
            }
            None => read_shape(&Source {
                scene,
                field: format!("shapes[{i}]"),
                uri: shape.uri.as_ref(),
                generator: shape.generator.as_ref(),
                allow_outside: options.allow_outside_folder,
            })?,
        };
        loaded.name = key.clone().unwrap_or_else(|| shape.name.clone());
        if let Some(method) = shape.method.or(file.method) {
            loaded.method = method;
        }
        Ok((loaded, warnings))
    };
    let loaded: Vec<_> = file.shapes.items.par_iter().enumerate().map(load).collect();
    let mut shapes = Vec::new();
    for result in loaded {
        let (shape, its_warnings) = result?;
        shapes.push(shape);
        warnings.extend(its_warnings);
    }
    Ok(shapes)
}

/// The scene and the files that it names. Of a shape that a subdivision takes the place of, only if it is there.
pub(super) fn files(scene: &Path, file: &SceneFile) -> Vec<PathBuf> {
    let folder = scene.parent().unwrap_or(Path::new(""));
    let textures = file.textures.items.iter().filter_map(|(_, texture)| texture.uri.as_ref());
    let shapes = file.shapes.items.iter().filter_map(|(_, shape)| shape.uri.as_ref());
    let subdivs = file.subdivs.items.iter().filter_map(|(_, subdiv)| subdiv.uri.as_ref());
    let named = textures.chain(shapes).chain(subdivs).map(|uri| folder.join(uri));
    let mut files: Vec<_> = named.filter(|path| path.is_file()).collect();
    files.push(scene.to_owned());
    files.sort();
    files.dedup();
    files
}

fn read_shape(source: &Source<'_, Geometry>) -> Result<(Shape, Vec<String>), LoadError> {
    source.get(
        |path, named_by| {
            let mut warnings = Vec::new();
            let mesh = read_mesh(path, named_by)?;
            Ok((mesh.into_shape(path, mesh::DEFAULT_RADIUS, &mut warnings)?, warnings))
        },
        |generator| Ok((generator.build()?, Vec::new())),
    )
}

fn subdivided(
    source: &Source<'_, Geometry>,
    control: &Shape,
    described: &SubdivFile,
    displacement_tex: Option<&Texture>,
) -> Result<Shape, LoadError> {
    let unfit = |field: &str, value: String, expected| LoadError::Value {
        path: source.scene.to_owned(),
        field: format!("{}.{field}", source.field),
        value,
        expected,
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
        let expected = "none, for the mesh has no texture coordinates";
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

pub(super) fn read_mesh(path: &Path, named_by: &NamedBy) -> Result<Mesh, LoadError> {
    match file::extension(path).as_str() {
        "ply" => {
            let (file, length) = file::open(path, named_by)?;
            ply::read(path, BufReader::with_capacity(1 << 16, file), length)
        }
        "obj" => obj::load(path, named_by),
        other => Err(LoadError::Unsupported {
            path: path.to_owned(),
            named_by: named_by.clone(),
            extension: other.to_owned(),
            supported: "ply and obj",
        }),
    }
}
