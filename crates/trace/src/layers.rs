//! Auxiliary pictures of the surfaces that a camera sees first.

use crate::context::Context;
use crate::film::room;
use crate::{Options, RenderError, Sampler, World, camera_ray};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use rotund_scene::Camera;

/// Auxiliary pictures (AOVs) of the first surfaces, for compositing and denoising; row by row from
/// the top.
#[derive(Clone, Debug)]
pub struct Layers {
    /// Pixels in a row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// Surface colour, averaged over the pixel; black without a surface.
    pub albedo: Vec<Vec3>,
    /// Shading normal in world space, averaged over the pixel.
    pub normal: Vec<Vec3>,
    /// Distance in meters from the start of the ray through the center of the pixel; infinite
    /// without a surface.
    pub depth: Vec<f32>,
    /// Position in world space at the center of the pixel; zero without a surface.
    pub position: Vec<Vec3>,
    /// Indices of instance, element and material at the center of the pixel; [`u32::MAX`] without a
    /// surface.
    pub ids: [Vec<u32>; 3],
}

/// Largest number of samples of a pixel for the averages of [`Layers`].
const LAYER_SAMPLES: u32 = 16;

/// The layers of one pixel.
struct Pixel {
    albedo: Vec3,
    normal: Vec3,
    depth: f32,
    position: Vec3,
    ids: [u32; 3],
}

impl World<'_> {
    /// Returns the layers of a picture. Uses only these options: `width`, `height`, `seed`,
    /// `sequence`, and `samples` up to 16.
    ///
    /// Positions are those of the scene: [`Options::recenter`] has no effect.
    ///
    /// # Errors
    ///
    /// If the scene has no such camera, [`Options::validate`] refuses the options, or the layers do
    /// not fit into memory.
    pub fn layers(&self, camera: usize, options: &Options) -> Result<Layers, RenderError> {
        let camera = self.camera(camera)?;
        options.validate()?;
        let &Options { width, height, .. } = options;
        let context = self.context(options);
        let pixel = |index: usize| {
            let (x, y) = ((index % width as usize) as u32, (index / width as usize) as u32);
            layers_of_pixel(&context, camera, options, x, y)
        };
        // All memory first: a size that does not fit is refused before the work and not after it.
        let mut pixels: Vec<Pixel> = room(width, height)?;
        let mut layers = Layers {
            width,
            height,
            albedo: room(width, height)?,
            normal: room(width, height)?,
            depth: room(width, height)?,
            position: room(width, height)?,
            ids: [room(width, height)?, room(width, height)?, room(width, height)?],
        };
        let count = width as usize * height as usize;
        (0..count).into_par_iter().map(pixel).collect_into_vec(&mut pixels);
        layers.albedo.extend(pixels.iter().map(|pixel| pixel.albedo));
        layers.normal.extend(pixels.iter().map(|pixel| pixel.normal));
        layers.depth.extend(pixels.iter().map(|pixel| pixel.depth));
        layers.position.extend(pixels.iter().map(|pixel| pixel.position));
        for (id, layer) in layers.ids.iter_mut().enumerate() {
            layer.extend(pixels.iter().map(|pixel| pixel.ids[id]));
        }
        Ok(layers)
    }
}

fn layers_of_pixel(
    context: &Context<'_>,
    camera: &Camera,
    options: &Options,
    x: u32,
    y: u32,
) -> Pixel {
    let scene = context.scene;
    let size = [options.width, options.height];
    let count = LAYER_SAMPLES.min(options.samples);
    let (mut albedo, mut normal) = (Vec3::ZERO, Vec3::ZERO);
    for sample in 0..count {
        let sampler = Sampler::new(options.sequence, options.seed, x, y, sample);
        let ray = camera_ray(camera, size, [x, y], &sampler);
        if let (Some((hit, material)), _) = context.first_surface(ray, &sampler) {
            albedo += material.color;
            normal += scene.shading_normal(&hit, -ray.direction);
        }
    }
    let center = Vec2::new(x as f32, y as f32) + 0.5;
    let size = Vec2::new(options.width as f32, options.height as f32);
    let hit = context.trees.closest(scene, &camera.ray(center / size, Vec2::ZERO));
    let ids = hit.map_or([u32::MAX; 3], |hit| {
        [hit.instance, hit.element, scene.instances[hit.instance as usize].material]
    });
    Pixel {
        albedo: albedo / count as f32,
        normal: normal / count as f32,
        depth: hit.map_or(f32::INFINITY, |hit| hit.t),
        position: hit.map_or(Vec3::ZERO, |hit| hit.position),
        ids,
    }
}
