//! Default scenes for the file of a shape that is loaded by itself, and default cameras.

use super::{
    assets,
    context::Context,
    error::LoadError,
    file::NamedFile,
    framing::{Drawn, Frame, LARGEST, extent, frame},
    mesh::Mesh,
    options::Up,
    radius::default_radius,
};
use crate::{
    Camera, Elements, Environment, Instance, Material, MaterialKind, Scene, Shape, generate,
};
use glam::{Affine3A, Mat3A, Vec3, Vec3A};
use rayon::prelude::*;
use rotund_geometry::Aabb;

/// Loads the shape in a file, with a camera, a floor and a sky.
pub(super) fn load(context: &mut Context<'_>) -> Result<Scene, LoadError> {
    let file = NamedFile::given(&context.scene);
    let mut mesh = assets::read_mesh(context, &file)?;
    let up = context.options.up.unwrap_or_else(|| up_of(&file.extension(), &mesh));
    if !mesh.radii.is_empty() && mesh.radii.iter().all(|&radius| radius == 0.0) {
        context.warn("all radii are 0; taken as if there were none");
        mesh.radii.clear();
    }
    let given = !mesh.radii.is_empty();
    let radius = match context.options.radius {
        Some(radius) if radius.is_finite() && radius > 0.0 => radius,
        Some(radius) => return Err(context.unexpected("radius", radius, "a positive number")),
        None => default_radius(&mesh),
    };
    let (mut shape, warnings) = assets::into_shape(mesh, &file, radius)?;
    context.warnings.extend(warnings);
    shape.name = context.scene.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    if context.options.radius.is_some() {
        shape.radii.fill(radius);
    }
    let framed = frame(&[Drawn::of_shape(&shape, up)]);
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
        warn_of_thin(context, &shape, framed.reach);
    }
    Ok(around(shape, &framed, up, !context.options.without_floor))
}

/// Returns the axis that points up in most files of this format.
///
/// Points come from scanners, maps and molecular or physical simulations, and streamlines from
/// medical images, all with z up. Meshes come from modellers, which write y up to OBJ and PLY, and
/// neurons are traced in the plane x y of a microscope, with the surface of the brain above.
fn up_of(extension: &str, mesh: &Mesh) -> Up {
    match extension {
        "tck" | "trk" => Up::Z,
        "ply" if mesh.lines.is_empty() && mesh.faces.is_empty() => Up::Z,
        _ => Up::Y,
    }
}

/// Warns if most radii in the file are so small that a picture does not show them.
fn warn_of_thin(context: &mut Context<'_>, shape: &Shape, reach: f32) {
    // A 10th of a pixel of a picture of 720 x 480 pixels.
    let least = reach / 4000.0;
    let step = (shape.radii.len() / 4096).max(1);
    let mut sample: Vec<f32> = shape.radii.iter().step_by(step).copied().collect();
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

/// Surrounds a shape with a camera, a sky and, if asked for, a floor.
fn around(shape: Shape, framed: &Frame, up: Up, with_floor: bool) -> Scene {
    let bounds = framed.bounds;
    let extent = extent(bounds.center(), framed.reach);
    let built = "constant parameters that fit";
    let upright = match up {
        Up::Y => Mat3A::IDENTITY,
        Up::Z => Mat3A::from_cols(Vec3A::X, Vec3A::NEG_Z, Vec3A::Y),
    };
    let has_faces = matches!(shape.elements, Elements::Triangles(_) | Elements::Quads(_));
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
        let material = Material {
            name: "floor".to_owned(),
            color: Vec3::splat(0.7),
            color_tex: Some(1),
            ..Material::default()
        };
        let floor = generate::Geometry::floor(40.0 * extent, 80.0).build().expect(built);
        let floor = Shape { name: "floor".to_owned(), ..floor };
        scene.textures.push(generate::Image::floor_grid().build().expect(built));
        place(&mut scene, floor, material, Affine3A::from_translation(center));
    }
    let material = Material {
        name: shape.name.clone(),
        kind: if has_faces { MaterialKind::Matte } else { MaterialKind::Glossy },
        color: Vec3::splat(0.7),
        roughness: 0.3,
        ..Material::default()
    };
    place(&mut scene, shape, material, Affine3A::from_mat3(upright.into()));
    scene
}

/// Adds an instance of a shape with a material of its own.
fn place(scene: &mut Scene, shape: Shape, material: Material, frame: Affine3A) {
    let index = scene.shapes.len() as u32;
    scene.instances.push(Instance {
        name: shape.name.clone(),
        world_from_object: frame,
        shape: index,
        material: index,
    });
    scene.shapes.push(shape);
    scene.materials.push(material);
}
