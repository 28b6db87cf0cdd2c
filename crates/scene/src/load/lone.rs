//! Default scenes for the file of a shape that is loaded by itself, and default cameras.

use super::{
    assets,
    context::Context,
    error::LoadError,
    file::NamedFile,
    framing::{Drawn, Frame, LARGEST, extent, frame},
    materials,
    mesh::{DEFAULT_RADIUS, Mesh, MeshMaterial, Part},
    options::Up,
    points,
    radius::default_radius,
};
use crate::{Camera, Elements, Environment, Material, MaterialKind, Scene, generate};
use glam::{Affine3A, DVec3, Mat3A, Vec3, Vec3A};
use rayon::prelude::*;
use rotund_geometry::Aabb;
use std::{collections::HashMap, path::PathBuf};

/// Loads the shapes in a file, with a camera, a floor and a sky; returns the scene with the other
/// files that were read.
pub(super) fn load(context: &mut Context<'_>) -> Result<(Scene, Vec<PathBuf>), LoadError> {
    let file = NamedFile::given(&context.scene);
    let mut mesh = assets::read_mesh(context, &file)?;
    materials::warn_of_undefined(&mut mesh);
    let up = context.options.up.unwrap_or_else(|| up_of(&file.extension(), &mesh));
    if !mesh.radii.is_empty() && mesh.radii.iter().all(|&radius| radius == 0.0) {
        mesh.warnings.push("all radii are 0; taken as if there were none".to_owned());
        mesh.radii.clear();
    }
    let given = !mesh.radii.is_empty();
    let only_faces = !mesh.faces.is_empty() && mesh.lines.is_empty() && mesh.points.is_empty();
    let radius = match context.options.radius {
        Some(radius) if radius.is_finite() && radius > 0.0 => radius,
        Some(radius) => return Err(context.unexpected("radius", radius, "a positive number")),
        // To find one takes a moment, and faces have none.
        None if given || only_faces => DEFAULT_RADIUS,
        None => default_radius(&mesh),
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
    let name = context.scene.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    for part in &mut parts {
        part.shape.name.clone_from(&name);
        if context.options.radius.is_some() {
            part.shape.radii.fill(radius);
        }
    }
    let drawn: Vec<Drawn<'_>> = parts.iter().map(|part| Drawn::of_shape(&part.shape, up)).collect();
    let framed = frame(&drawn);
    let largest = framed.bounds.min.abs().max(framed.bounds.max.abs()).max_element();
    if largest > LARGEST {
        let expected = "at most 1e15, to be framed by a camera";
        return Err(context.unexpected("the largest coordinate", largest, expected));
    }
    if framed.outside > 0 {
        let Frame { outside, count, farthest, reach, .. } = framed;
        context.warn(format_args!(
            "{outside} of {count} vertices lie far outside of the picture, up to {farthest} from \
             its center; the others lie within {reach}"
        ));
    }
    if given && context.options.radius.is_none() {
        warn_of_thin(context, &parts, framed.reach);
    }
    let mut scene = around(&framed, !context.options.without_floor);
    let first = scene.instances.len();
    place(context, &file, &mut scene, parts, of_materials, &mut files);
    if up == Up::Z {
        let upright = Mat3A::from_cols(Vec3A::X, Vec3A::NEG_Z, Vec3A::Y);
        for instance in &mut scene.instances[first..] {
            instance.world_from_object.matrix3 = upright;
        }
    }
    Ok((scene, files))
}

/// Returns the axis that points up in most files of this format.
///
/// Points come from scanners, maps and molecular or physical simulations, and streamlines from
/// medical images, all with z up. Meshes come from modellers, which write y up to OBJ and PLY, and
/// neurons are traced in the plane x y of a microscope, with the surface of the brain above.
fn up_of(extension: &str, mesh: &Mesh) -> Up {
    match extension {
        "tck" | "trk" => Up::Z,
        text if points::EXTENSIONS.contains(&text) => Up::Z,
        "ply" if mesh.lines.is_empty() && mesh.faces.is_empty() => Up::Z,
        _ => Up::Y,
    }
}

/// Warns if most radii in the file are so small that a picture does not show them.
fn warn_of_thin(context: &mut Context<'_>, parts: &[Part], reach: f32) {
    // A 10th of a pixel of a picture of 720 x 480 pixels.
    let least = reach / 4000.0;
    let count: usize = parts.iter().map(|part| part.shape.radii.len()).sum();
    let radii = parts.iter().flat_map(|part| &part.shape.radii);
    let mut sample: Vec<f32> = radii.step_by((count / 4096).max(1)).copied().collect();
    sample.sort_unstable_by(f32::total_cmp);
    if let Some(&usual) = sample.get(sample.len() / 2).filter(|&&usual| usual < least) {
        context.warn(format_args!(
            "the usual radius is {usual}, too small to be seen among vertices up to {reach} from \
             their center; a radius of {} would be seen",
            reach / 400.0
        ));
    }
}

/// Returns a camera that sees all instances; `None` if there are none, or if they are beyond
/// [`LARGEST`].
pub(super) fn camera_for(scene: &Scene) -> Option<Camera> {
    let mut bounds = Aabb::EMPTY;
    let mut thickest = 0.0_f32;
    for instance in &scene.instances {
        let shape = &scene.shapes[instance.shape as usize];
        let frame = instance.world_from_object;
        let drawn = Drawn::of_shape(shape, Up::Y);
        let grow = |(around, most): (Aabb, f32), (p, radius): (Vec3, f32)| {
            (around.union(Aabb::from_points([p])), most.max(radius))
        };
        let both = |a: (Aabb, f32), b: (Aabb, f32)| (a.0.union(b.0), a.1.max(b.1));
        let nothing = || (Aabb::EMPTY, 0.0);
        let (around, most) = drawn.balls().fold(nothing, grow).reduce(nothing, both);
        for corner in 0..8_u32 {
            let pick = |axis: u32| if corner >> axis & 1 == 0 { around.min } else { around.max };
            let corner = Vec3::new(pick(0).x, pick(1).y, pick(2).z);
            bounds = bounds.union(Aabb::from_points([frame.transform_point3(corner)]));
        }
        let axes = frame.matrix3;
        let stretch = axes.x_axis.length() + axes.y_axis.length() + axes.z_axis.length();
        thickest = thickest.max(stretch * most);
    }
    let fits = bounds.min.abs().max(bounds.max.abs()).max_element() <= LARGEST;
    let diagonal = (bounds.max - bounds.min).length();
    let reach = 0.5 * diagonal + thickest.min(LARGEST);
    fits.then(|| camera_around(bounds, extent(bounds.center(), reach)))
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

/// Returns a scene with a camera, a sky and, if asked for, a floor.
fn around(framed: &Frame, with_floor: bool) -> Scene {
    let bounds = framed.bounds;
    let extent = extent(bounds.center(), framed.reach);
    let built = "constant parameters that fit";
    let mut scene = Scene {
        cameras: vec![camera_around(bounds, extent)],
        environments: vec![Environment {
            name: "sky".to_owned(),
            world_from_environment: Affine3A::IDENTITY,
            emission: Vec3::ONE,
            emission_tex: Some(0),
        }],
        textures: vec![generate::Image::clear_sky().build().expect(built)],
        ..Scene::default()
    };
    if with_floor {
        // Half a pixel of a picture of 720 x 480 pixels lower: flat shapes would lie in the floor.
        let height = bounds.min.y - extent / 400.0;
        let center = Vec3::new(bounds.center().x, height, bounds.center().z);
        let ground = Material {
            name: "floor".to_owned(),
            color: Vec3::splat(0.7),
            color_tex: Some(1),
            ..Material::default()
        };
        scene.textures.push(generate::Image::floor_grid().build().expect(built));
        let floor = generate::Geometry::floor(40.0 * extent, 80.0).build().expect(built);
        let index = scene.add(floor, ground) as usize;
        scene.instances[index].name = "floor".to_owned();
        scene.instances[index].world_from_object = Affine3A::from_translation(center);
    }
    scene
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
