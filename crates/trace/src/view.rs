//! What a picture can show instead of the light.

use crate::Sampler;
use crate::path::{Arrived, SHEET_SETS, SHEETS, World};
use glam::Vec3;
use rotund_geometry::{Aabb, Ray, UNIT_ROUNDOFF, leave_surface};
use rotund_scene::{ElementKind, Instance, MaterialPoint, Method, Scene, SceneHit};

/// What a picture shows. All but the first two show what the camera sees first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// The light, along paths.
    #[default]
    Path,
    /// The light if every direction sends radiance 1 and nothing else shines: what does not lose light is
    /// white, and nothing is brighter than that.
    Furnace,
    /// Colours in the light of a lamp at the eye: a quick look.
    Eyelight,
    /// The position in the bounds of the scene.
    Position,
    /// The geometric normal, `-1.0..=1.0` shown as `0.0..=1.0`, in world space, out of the solid.
    GeometricNormal,
    /// The shading normal, shown as the geometric one.
    ShadingNormal,
    /// The parameters of the element, as red and green.
    Uv,
    /// Texture coordinates, each without its whole part, as red and green.
    Texcoord,
    /// A colour for each element.
    Element,
    /// A colour for each instance.
    Instance,
    /// Blue for enhanced, orange for vanilla, grey for triangles, which have one method.
    Method,
    /// A colour for each material.
    Material,
    /// The bound on the error of the hit, in units of the roundoff of its largest coordinate: blue
    /// for none, green for 31, red for 1023 and more, evenly by the logarithm.
    Error,
}

impl World<'_> {
    /// The first surface of a ray that is there by its opacity, and how many rays it took.
    pub(crate) fn first_surface(
        &self,
        mut ray: Ray,
        sampler: &Sampler,
    ) -> (Option<(SceneHit, MaterialPoint)>, u64) {
        for sheet in 0..SHEETS {
            let rays = u64::from(sheet) + 1;
            let Some(hit) = self.trees.closest(self.scene, &ray) else { return (None, rays) };
            let material = self.scene.eval_material(hit.instance, hit.element, hit.uv);
            if material.opacity >= 1.0 || sampler.set(SHEET_SETS + sheet)[0] < material.opacity {
                return (Some((hit, material)), rays);
            }
            ray.origin = leave_surface(hit.position, hit.error, hit.normal, ray.direction);
        }
        (None, u64::from(SHEETS))
    }

    /// What a view shows along a ray of unit direction.
    pub(crate) fn look(&self, view: View, ray: Ray, sampler: &Sampler) -> Arrived {
        if matches!(view, View::Path | View::Furnace) {
            return self.trace(ray, sampler);
        }
        let (found, rays) = self.first_surface(ray, sampler);
        let radiance = match &found {
            Some((hit, material)) => self.color(view, hit, material, -ray.direction),
            None if view == View::Eyelight => self.scene.eval_environment(ray.direction),
            None => Vec3::ZERO,
        };
        let covered =
            found.is_some() || view == View::Eyelight && !self.scene.environments.is_empty();
        Arrived { radiance, covered, rays }
    }

    fn color(&self, view: View, hit: &SceneHit, material: &MaterialPoint, outgoing: Vec3) -> Vec3 {
        let scene = self.scene;
        let instance = &scene.instances[hit.instance as usize];
        let shape = &scene.shapes[instance.shape as usize];
        let direction = |d: Vec3| 0.5 * d + 0.5;
        match view {
            View::Path | View::Furnace => Vec3::ZERO,
            View::Eyelight => {
                let normal = scene.shading_normal(hit, outgoing);
                material.emission + material.color * normal.dot(outgoing).abs()
            }
            View::Position => {
                let Aabb { min, max } = self.bounds;
                ((hit.position - min) / (max - min).max(Vec3::splat(f32::MIN_POSITIVE)))
                    .clamp(Vec3::ZERO, Vec3::ONE)
            }
            View::GeometricNormal => direction(hit.normal),
            View::ShadingNormal => direction(scene.shading_normal(hit, outgoing)),
            View::Uv => hit.uv.clamp(glam::Vec2::ZERO, glam::Vec2::ONE).extend(0.0),
            View::Texcoord => {
                let place = scene.eval_texcoord(hit.instance, hit.element, hit.uv);
                (place - place.floor()).extend(0.0)
            }
            View::Element => of_index(hit.element),
            View::Instance => of_index(hit.instance),
            View::Material => of_index(instance.material),
            View::Method => match (shape.elements.kind(), shape.method) {
                (ElementKind::Triangles, _) => Vec3::splat(0.5),
                (_, Method::Enhanced) => Vec3::new(0.1, 0.3, 0.9),
                (_, Method::Vanilla) => Vec3::new(0.9, 0.4, 0.1),
            },
            View::Error => {
                let roundings = hit.error / (UNIT_ROUNDOFF * hit.position.abs().max_element());
                // Infinite at the origin, where every error is.
                let share = ((1.0 + roundings).log2() / 10.0).clamp(0.0, 1.0);
                Vec3::new(share, 1.0 - (2.0 * share - 1.0).abs(), 1.0 - share)
            }
        }
    }
}

/// A colour that is far from that of the neighbouring indices, not dark.
fn of_index(index: u32) -> Vec3 {
    let hash = (index.wrapping_add(1)).wrapping_mul(0x9e37_79b9);
    let hash = (hash ^ hash >> 15).wrapping_mul(0x85eb_ca6b);
    let hash = hash ^ hash >> 13;
    let channel = |shift: u32| 0.15 + 0.85 * (hash >> shift & 255) as f32 / 255.0;
    Vec3::new(channel(0), channel(8), channel(16))
}

/// A box around all instances.
pub(crate) fn bounds(scene: &Scene) -> Aabb {
    let of_instance = |instance| instance_bounds(scene, instance);
    scene.instances.iter().map(of_instance).fold(Aabb::EMPTY, Aabb::union)
}

/// A box around an instance.
pub(crate) fn instance_bounds(scene: &Scene, instance: &Instance) -> Aabb {
    let shape = &scene.shapes[instance.shape as usize];
    let frame = &instance.world_from_object;
    let stretch = frame.matrix3.x_axis.length().max(frame.matrix3.y_axis.length());
    let stretch = stretch.max(frame.matrix3.z_axis.length());
    let radius = stretch * shape.radii.iter().copied().fold(0.0, f32::max);
    let points = shape.positions.iter().map(|&p| frame.transform_point3(p));
    let Aabb { min, max } = Aabb::from_points(points);
    Aabb { min: min - radius, max: max + radius }
}

/// What the camera sees first, for compositing and denoising; row by row from the top.
#[derive(Clone, Debug)]
pub struct Layers {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Mean over the pixel of the colour of the surface; black where there is none.
    pub albedo: Vec<Vec3>,
    /// Mean over the pixel of the shading normal, in world space.
    pub normal: Vec<Vec3>,
    /// In the middle of the pixel: meters from where the ray starts, infinite without a surface.
    pub depth: Vec<f32>,
    /// In the middle of the pixel, in world space; zeros without a surface.
    pub position: Vec<Vec3>,
    /// Indices of instance, element and material in the middle of the pixel; [`u32::MAX`] without a surface.
    pub ids: [Vec<u32>; 3],
}

/// Samples of each pixel for the means of [`layers`].
const LAYER_SAMPLES: u32 = 16;

/// Looks at what the camera sees first: the size, seed and sequence of the options count.
///
/// # Panics
///
/// If the scene has no camera of that index.
#[must_use]
pub fn layers(
    scene: &Scene,
    trees: &rotund_scene::Trees,
    camera: usize,
    options: &crate::Options,
) -> Layers {
    use rayon::prelude::*;
    let lights = crate::Lights::default();
    let world = World::new(scene, trees, &lights, options);
    let camera = &scene.cameras[camera];
    let (width, height) = (options.width, options.height);
    let count = LAYER_SAMPLES.min(options.samples.max(1));
    let size = glam::Vec2::new(width as f32, height as f32);
    let pixel = |index: usize| {
        let (x, y) = (index as u32 % width, index as u32 / width);
        let corner = glam::Vec2::new(x as f32, y as f32);
        let (mut albedo, mut normal) = (Vec3::ZERO, Vec3::ZERO);
        for sample in 0..count {
            let sampler = Sampler::new(options.sequence, options.seed, x, y, sample);
            let [u, v, lens_u, lens_v] = sampler.set(0);
            let lens = crate::warp::disk(glam::Vec2::new(lens_u, lens_v));
            let ray = camera.ray((corner + glam::Vec2::new(u, v)) / size, lens);
            if let (Some((hit, material)), _) = world.first_surface(ray, &sampler) {
                albedo += material.color;
                normal += scene.shading_normal(&hit, -ray.direction);
            }
        }
        let middle = camera.ray((corner + 0.5) / size, glam::Vec2::ZERO);
        let hit = trees.closest(scene, &middle);
        let material = |hit: SceneHit| scene.instances[hit.instance as usize].material;
        let ids = hit.map_or([u32::MAX; 3], |hit| [hit.instance, hit.element, material(hit)]);
        (
            albedo / count as f32,
            normal / count as f32,
            hit.map_or(f32::INFINITY, |hit| hit.t),
            hit.map_or(Vec3::ZERO, |hit| hit.position),
            ids,
        )
    };
    let pixels: Vec<_> = (0..width as usize * height as usize).into_par_iter().map(pixel).collect();
    Layers {
        width,
        height,
        albedo: pixels.iter().map(|pixel| pixel.0).collect(),
        normal: pixels.iter().map(|pixel| pixel.1).collect(),
        depth: pixels.iter().map(|pixel| pixel.2).collect(),
        position: pixels.iter().map(|pixel| pixel.3).collect(),
        ids: [0, 1, 2].map(|id| pixels.iter().map(|pixel| pixel.4[id]).collect()),
    }
}
