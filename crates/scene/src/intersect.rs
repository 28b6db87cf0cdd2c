//! Rays through a scene: a tree over instances, and under each a tree over the elements of its shape.

use crate::{ElementKind, Elements, Instance, Method, Scene, Shape, frame::Frame};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use rotund_bvh::Bvh;
use rotund_geometry::Ray;

/// The trees of one scene.
///
/// They hold boxes, not geometry, and the boxes hold the elements under either [`Method`]: setting a
/// method needs no new trees. Any other change of shapes or instances does.
#[derive(Clone, Debug)]
pub struct Trees {
    instances: Bvh,
    placements: Vec<Placement>,
    /// One for each shape.
    shapes: Vec<Bvh>,
}

/// An instance, prepared for rays.
#[derive(Clone, Copy, Debug)]
struct Placement {
    shape: u32,
    frame: Frame,
    /// Vanilla points and lines nearer than this to the start of a ray, in object space, are what it
    /// has just left.
    ribbon_start: f32,
}

impl Placement {
    fn object_ray(&self, shape: &Shape, ray: &Ray) -> Ray {
        let mut ray = self.frame.object_ray(ray);
        let round = matches!(shape.elements.kind(), ElementKind::Points | ElementKind::Lines);
        if round && shape.method == Method::Vanilla {
            ray.t_min = ray.t_min.max(self.ribbon_start / ray.direction.length());
        }
        ray
    }
}

/// Where a ray meets a scene, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneHit {
    /// Index into [`Scene::instances`].
    pub instance: u32,
    /// Index into the elements of the instance's shape.
    pub element: u32,
    /// Parameters of the element, which with it name the point: `scene.eval_position` gives back
    /// `position`, except under vanilla methods whose place depends on the ray (points, and lines
    /// across).
    pub uv: Vec2,
    /// Position along the ray, in units of its direction.
    pub t: f32,
    /// The point, within `error` of the surface.
    pub position: Vec3,
    /// Geometric normal: unit length, out of the solid whichever side the ray came from.
    pub normal: Vec3,
    /// How far along `normal` a ray has to start from `position` in order not to meet the surface
    /// again: what [`rotund_geometry::leave_surface`] asks for. It covers the rounding of the way to
    /// object space and back.
    pub error: f32,
}

impl Trees {
    /// Builds all trees, on all threads of the current rayon pool; the result does not depend on how
    /// many there are.
    ///
    /// # Panics
    ///
    /// If an index in the scene is out of range.
    #[must_use]
    pub fn build(scene: &Scene) -> Self {
        let shapes: Vec<Bvh> =
            scene.shapes.par_iter().map(|shape| Bvh::build(&shape.element_bounds())).collect();
        let place = |instance: &Instance| {
            let frame = Frame::new(instance.world_from_object);
            let bounds = shapes[instance.shape as usize].bounds();
            let ribbon_start = frame.ribbon_start(bounds);
            (Placement { shape: instance.shape, frame, ribbon_start }, frame.world_bounds(bounds))
        };
        let (placements, boxes): (Vec<_>, Vec<_>) = scene.instances.par_iter().map(place).unzip();
        Self { instances: Bvh::build(&boxes), placements, shapes }
    }

    /// The first surface that the ray meets with `t` in `t_min..=t_max`. Ties go to the instance, and
    /// in it to the element, that comes first.
    ///
    /// `scene` is the one the trees were built of.
    #[must_use]
    pub fn closest(&self, scene: &Scene, ray: &Ray) -> Option<SceneHit> {
        let (instance, t, element) = self.instances.closest(ray, |id, ray| {
            let placement = &self.placements[id as usize];
            let shape = &scene.shapes[placement.shape as usize];
            let ray = placement.object_ray(shape, ray);
            let (element, t) =
                closest_element(shape, &self.shapes[placement.shape as usize], &ray)?;
            Some((t, element))
        })?;
        // The traversal asked for `t` alone; the rest is worth its price once.
        let placement = &self.placements[instance as usize];
        let shape = &scene.shapes[placement.shape as usize];
        let primitive = shape.primitive(element);
        let hit = primitive.closest(&placement.object_ray(shape, ray))?;
        let world = placement.frame.world_hit(&hit);
        Some(SceneHit {
            instance,
            element,
            uv: primitive.uv(&hit),
            t,
            position: world.position,
            normal: world.normal,
            error: world.error,
        })
    }

    /// True if the ray meets anything with `t` in `t_min..=t_max`.
    #[must_use]
    pub fn any(&self, scene: &Scene, ray: &Ray) -> bool {
        self.instances.any(ray, |id, ray| {
            let placement = &self.placements[id as usize];
            let shape = &scene.shapes[placement.shape as usize];
            let ray = placement.object_ray(shape, ray);
            any_element(shape, &self.shapes[placement.shape as usize], &ray)
        })
    }
}

/// Matches once outside the traversal, so that inside it the kind is known.
macro_rules! traverse {
    ($shape:expr, $primitive:ident, $element:ident => $traversal:expr) => {{
        let vanilla = $shape.method == Method::Vanilla;
        match &$shape.elements {
            Elements::Points(_) if vanilla => {
                let $primitive = |$element: u32| $shape.point($element);
                $traversal
            }
            Elements::Points(_) => {
                let $primitive = |$element: u32| $shape.sphere($element);
                $traversal
            }
            Elements::Lines(lines) if vanilla => {
                let $primitive = |$element: u32| $shape.line(lines[$element as usize]);
                $traversal
            }
            Elements::Lines(lines) => {
                let $primitive = |$element: u32| $shape.cone(lines[$element as usize]);
                $traversal
            }
            Elements::Triangles(triangles) => {
                let $primitive = |$element: u32| $shape.triangle(triangles[$element as usize]);
                $traversal
            }
            Elements::Quads(quads) if vanilla => {
                let $primitive = |$element: u32| $shape.quad(quads[$element as usize]);
                $traversal
            }
            Elements::Quads(quads) => {
                let $primitive = |$element: u32| $shape.patch(quads[$element as usize]);
                $traversal
            }
        }
    }};
}

fn closest_element(shape: &Shape, tree: &Bvh, ray: &Ray) -> Option<(u32, f32)> {
    let (element, t, ()) = traverse!(shape, primitive, element => {
        tree.closest(ray, |id, ray| primitive(id).closest_t(ray).map(|t| (t, ())))
    })?;
    Some((element, t))
}

fn any_element(shape: &Shape, tree: &Bvh, ray: &Ray) -> bool {
    traverse!(shape, primitive, element => tree.any(ray, |id, ray| primitive(id).any(ray)))
}
