//! What is at a point of the picture.

use crate::message::{Inspection, Surface};
use glam::Vec2;
use rotund_geometry::Ray;
use rotund_image::Image;
use rotund_scene::{Camera, ElementKind};
use rotund_trace::World;

/// Returns the ray through a point of the picture and the center of the lens.
pub(crate) fn ray(camera: &Camera, at: [f32; 2]) -> Ray {
    camera.ray(Vec2::from(at), Vec2::ZERO)
}

/// Returns the pixel that a point of a picture of this size is in.
fn pixel_at(at: [f32; 2], width: u32, height: u32) -> [u32; 2] {
    // The casts saturate, so NaN and points outside become pixels at the border.
    let index = |u: f32, count: u32| ((u * count as f32) as u32).min(count.saturating_sub(1));
    [index(at[0], width), index(at[1], height)]
}

/// Describes what the center of a pixel shows. `image` is the full picture, if there is one.
pub(crate) fn inspect(
    world: &World<'_>,
    camera: &Camera,
    (width, height): (u32, u32),
    at: [f32; 2],
    image: Option<&Image>,
) -> Inspection {
    let pixel = pixel_at(at, width, height);
    let center = [(pixel[0] as f32 + 0.5) / width as f32, (pixel[1] as f32 + 0.5) / height as f32];
    let image = image.filter(|image| (image.width, image.height) == (width, height));
    Inspection {
        at,
        pixel,
        value: image.map(|image| image.pixel(pixel[0], pixel[1])),
        hit: surface(world, &ray(camera, center)),
    }
}

fn surface(world: &World<'_>, ray: &Ray) -> Option<Surface> {
    let hit = world.closest(ray)?;
    let scene = world.scene();
    let instance = &scene.instances[hit.instance as usize];
    let shape = &scene.shapes[instance.shape as usize];
    let material = &scene.materials[instance.material as usize];
    let kind = match shape.elements.kind() {
        ElementKind::Points => "points",
        ElementKind::Lines => "lines",
        ElementKind::Triangles => "triangles",
        ElementKind::Quads => "quads",
    };
    Some(Surface {
        instance: (hit.instance, instance.name.clone()),
        shape: (instance.shape, shape.name.clone()),
        material: (instance.material, material.name.clone()),
        material_kind: format!("{:?}", material.kind).to_lowercase(),
        element: hit.element,
        kind,
        method: shape.method.name(),
        t: hit.t,
        position: hit.position.to_array(),
        error: hit.error,
        normal: hit.normal.to_array(),
        shading_normal: scene.shading_normal(&hit, -ray.direction).to_array(),
        uv: hit.uv.to_array(),
        texcoord: scene.eval_texcoord(hit.instance, hit.element, hit.uv).to_array(),
    })
}
