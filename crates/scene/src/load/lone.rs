//! Default scenes for the file of a shape that is loaded by itself, and default cameras.

use super::{
    assets,
    context::Context,
    error::LoadError,
    file::NamedFile,
    materials,
    mesh::{self, MeshMaterial, Part},
};
use crate::{
    Camera, Elements, Environment, Instance, Material, MaterialKind, Scene, Shape, generate,
};
use glam::{Affine3A, DVec3, Mat3A, Vec3};
use rayon::prelude::*;
use rotund_geometry::Aabb;
use std::{collections::HashMap, path::PathBuf};

/// Loads the shapes in a file, with a camera, a floor and a sky; returns the scene with the other
/// files that were read.
pub(super) fn load(context: &mut Context<'_>) -> Result<(Scene, Vec<PathBuf>), LoadError> {
    let file = NamedFile::given(&context.scene);
    let mut mesh = assets::read_mesh(context, &file)?;
    materials::warn_of_undefined(&mut mesh);
    let radius = match context.options.radius {
        Some(radius) if radius.is_finite() && radius > 0.0 => radius,
        Some(radius) => return Err(context.unexpected("radius", radius, "a positive number")),
        None if mesh.radii.is_empty() => default_radius(&mesh.positions),
        None => mesh::DEFAULT_RADIUS,
    };
    if mesh.offset != DVec3::ZERO {
        let [x, y, z] = mesh.offset.to_array();
        mesh.warnings.push(format!(
            "coordinates are far from the origin; {x} {y} {z} is subtracted from all"
        ));
    }
    let of_materials = std::mem::take(&mut mesh.materials);
    let mut files = std::mem::take(&mut mesh.files);
    let warnings = std::mem::take(&mut mesh.warnings);
    warnings.iter().for_each(|warning| context.warn(warning));
    let mut parts = mesh.into_parts(radius);
    for part in &mut parts {
        part.shape.name =
            context.scene.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if context.options.radius.is_some() {
            part.shape.radii.fill(radius);
        }
    }
    let bounds = parts.iter().map(|part| bounds_of(&part.shape)).fold(Aabb::EMPTY, Aabb::union);
    let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
    if largest > LARGEST {
        let expected = "at most 1e15, to be framed by a camera";
        return Err(context.unexpected("the largest coordinate", largest, expected));
    }
    let mut scene = around(&parts);
    place(context, &file, &mut scene, parts, of_materials, &mut files);
    Ok((scene, files))
}

/// Adds the parts of a file with their materials to the scene around them.
fn place(
    context: &mut Context<'_>,
    file: &NamedFile,
    scene: &mut Scene,
    parts: Vec<Part>,
    materials: Vec<MeshMaterial>,
    files: &mut Vec<PathBuf>,
) {
    let mut texture_of = HashMap::new();
    for Part { shape, material } in parts {
        let own = material.map(|index| materials[index as usize].clone()).unwrap_or_default();
        let texture = own.texture.and_then(|name| {
            *texture_of.entry(name).or_insert_with_key(|name| {
                if shape.texcoords.is_empty() {
                    let why = "faces have no texture coordinates";
                    context.warn(format_args!("the image {name:?} is not used: {why}"));
                    return None;
                }
                match materials::texture(context, file, name) {
                    Ok((texture, read)) => {
                        files.push(read.path);
                        scene.textures.push(texture);
                        Some(scene.textures.len() as u32 - 1)
                    }
                    Err(warning) => {
                        context.warn(warning);
                        None
                    }
                }
            })
        });
        let has_faces = matches!(shape.elements, Elements::Triangles(_) | Elements::Quads(_));
        let grey = if texture.is_some() { Vec3::ONE } else { Vec3::splat(0.7) };
        // Some programs write black beside an image.
        let color = own.color.filter(|color| texture.is_none() || *color != Vec3::ZERO);
        let material = Material {
            name: if own.name.is_empty() { shape.name.clone() } else { own.name },
            kind: if has_faces { MaterialKind::Matte } else { MaterialKind::Glossy },
            color: color.unwrap_or(grey),
            color_tex: texture,
            roughness: 0.3,
            ..Material::default()
        };
        let name = shape.name.clone();
        let instance = scene.add(shape, material);
        scene.instances[instance as usize].name = name;
    }
}

/// The largest coordinate of a shape whose camera is finite: squares of larger distances overflow.
const LARGEST: f32 = 1e15;

/// Returns half the typical distance to the nearest neighbour, so that spheres just touch: half the
/// median over a sample, or 0.001 m if there are no neighbours.
fn default_radius(positions: &[Vec3]) -> f32 {
    const SAMPLE: usize = 33;
    // A block stays in the cache while it is compared with the whole sample.
    const BLOCK: usize = 1 << 10;
    let sample: Vec<Vec3> =
        positions.iter().step_by((positions.len() / SAMPLE).max(1)).copied().collect();
    let nearest = |block: &[Vec3]| {
        let columns = [0, 1, 2].map(|axis| block.iter().map(|p| p[axis]).collect::<Vec<f32>>());
        sample.iter().map(|p| nearest_square(*p, &columns)).collect::<Vec<_>>()
    };
    let less = |a: Vec<f32>, b: Vec<f32>| a.iter().zip(b).map(|(a, b)| a.min(b)).collect();
    let mut nearest =
        positions.par_chunks(BLOCK).map(nearest).reduce_with(less).unwrap_or_default();
    nearest.retain(|square| square.is_finite());
    nearest.sort_unstable_by(f32::total_cmp);
    nearest.get(nearest.len() / 2).map_or(mesh::DEFAULT_RADIUS, |square| 0.5 * square.sqrt())
}

/// Returns the squared distance from `p` to the nearest of the points, given by their coordinates,
/// that does not coincide with `p`; infinite if there is none.
fn nearest_square(p: Vec3, [x, y, z]: &[Vec<f32>; 3]) -> f32 {
    // One minimum for each lane of a register, so that the loop vectorizes.
    const LANES: usize = 8;
    let mut nearest = [f32::INFINITY; LANES];
    let (x, y, z) = (x.chunks(LANES), y.chunks(LANES), z.chunks(LANES));
    for ((x, y), z) in x.zip(y).zip(z) {
        for (((nearest, x), y), z) in nearest.iter_mut().zip(x).zip(y).zip(z) {
            let (x, y, z) = (x - p.x, y - p.y, z - p.z);
            let square = x * x + y * y + z * z;
            let square = if square > 0.0 { square } else { f32::INFINITY };
            *nearest = if square < *nearest { square } else { *nearest };
        }
    }
    nearest.into_iter().fold(f32::INFINITY, f32::min)
}

/// Returns a camera that sees all instances; `None` if there are none, or if they are beyond
/// [`LARGEST`].
pub(super) fn camera_for(scene: &Scene) -> Option<Camera> {
    let mut bounds = Aabb::EMPTY;
    let mut thickest = 0.0_f32;
    for instance in &scene.instances {
        let shape = &scene.shapes[instance.shape as usize];
        let frame = instance.world_from_object;
        let around = bounds_of(shape);
        for corner in 0..8_u32 {
            let pick = |axis: u32| if corner >> axis & 1 == 0 { around.min } else { around.max };
            let corner = Vec3::new(pick(0).x, pick(1).y, pick(2).z);
            bounds = bounds.union(Aabb::from_points([frame.transform_point3(corner)]));
        }
        let axes = frame.matrix3;
        let stretch = axes.x_axis.length() + axes.y_axis.length() + axes.z_axis.length();
        thickest = thickest.max(stretch * thickest_of(shape));
    }
    let fits = bounds.min.abs().max(bounds.max.abs()).max_element() <= LARGEST;
    let diagonal = (bounds.max - bounds.min).length();
    let reach = 0.5 * diagonal + thickest.min(LARGEST);
    fits.then(|| camera_around(bounds, extent(bounds.center(), reach)))
}

/// Returns the bounds of the vertices.
fn bounds_of(shape: &Shape) -> Aabb {
    let blocks = shape.positions.par_chunks(1 << 14);
    let bounds = blocks.map(|block| Aabb::from_points(block.iter().copied()));
    bounds.reduce(|| Aabb::EMPTY, Aabb::union)
}

fn thickest_of(shape: &Shape) -> f32 {
    shape.radii.par_iter().copied().reduce(|| 0.0, f32::max).min(LARGEST)
}

/// Returns the radius of the ball about `center` that a camera frames, for contents within `reach`
/// of it. Lower bounds give a single point an extent, and keep tiny scenes within the precision of
/// `f32`.
fn extent(center: Vec3, reach: f32) -> f32 {
    reach.max(center.abs().max_element() * 1e-3).max(1e-6)
}

fn camera_around(bounds: Aabb, extent: f32) -> Camera {
    let camera = Camera { name: "default".to_owned(), ..Camera::default() };
    // Half the shorter side of the film over the lens is the tangent of half the field of view. At
    // this distance the ball around the shape fills most of it.
    let tangent = 0.5 * camera.film / camera.aspect / camera.lens;
    let distance = 1.1 * extent * (1.0 + tangent * tangent).sqrt() / tangent;
    let z = Vec3::new(0.4, 0.45, 1.0).normalize();
    let x = Vec3::Y.cross(z).normalize();
    Camera {
        world_from_camera: Affine3A {
            matrix3: Mat3A::from_cols(x.into(), z.cross(x).into(), z.into()),
            translation: (bounds.center() + distance * z).into(),
        },
        focus: distance,
        ..camera
    }
}

/// Returns the position and the radius of each vertex, 0 if the shape has none.
fn balls(shape: &Shape) -> impl ParallelIterator<Item = (Vec3, f32)> {
    let radius = |i| shape.radii.get(i).map_or(0.0, |radius: &f32| radius.min(LARGEST));
    shape.positions.par_iter().enumerate().map(move |(i, position)| (*position, radius(i)))
}

/// Returns the scene without the parts themselves.
fn around(parts: &[Part]) -> Scene {
    let grow = |bounds: Aabb, (p, radius)| bounds.union(Aabb { min: p - radius, max: p + radius });
    let all = || parts.par_iter().flat_map(|part| balls(&part.shape));
    let bounds = all().fold(|| Aabb::EMPTY, grow).reduce(|| Aabb::EMPTY, Aabb::union);
    let center = bounds.center();
    let reach = all().map(|(p, radius)| p.distance(center) + radius);
    let reach = reach.reduce(|| 0.0, f32::max);
    let extent = extent(center, reach);
    let floor_height = bounds.min.y;
    let camera = camera_around(bounds, extent);
    let built = "constant parameters that fit";
    let floor = generate::Geometry::floor(40.0 * extent, 80.0).build().expect(built);
    let ground = Material {
        name: "floor".to_owned(),
        color: Vec3::splat(0.7),
        color_tex: Some(1),
        ..Material::default()
    };
    let under = Affine3A::from_translation(Vec3::new(center.x, floor_height, center.z));
    Scene {
        cameras: vec![camera],
        environments: vec![Environment {
            name: "sky".to_owned(),
            world_from_environment: Affine3A::IDENTITY,
            emission: Vec3::ONE,
            emission_tex: Some(0),
        }],
        textures: vec![
            generate::Image::clear_sky().build().expect(built),
            generate::Image::floor_grid().build().expect(built),
        ],
        instances: vec![Instance {
            name: "floor".to_owned(),
            world_from_object: under,
            ..Instance::new(0, 0)
        }],
        materials: vec![ground],
        shapes: vec![floor],
    }
}
