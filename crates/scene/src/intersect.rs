//! Rays through a scene: a tree over instances, and under each a tree over the elements of its shape.

use crate::{ElementKind, Elements, Instance, Method, Scene, Shape, frame::Frame};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use rotund_bvh::{Bvh, ConeTree, Form, Isa, PatchTree, SphereTree, Statistics, TriangleTree};
use rotund_geometry::{Aabb, Hit, Ray};

/// The trees of one scene.
///
/// They hold the geometry of the shapes as it was, and serve either [`Method`]: setting a method needs
/// no new trees. Any other change of shapes or instances does.
#[derive(Clone, Debug)]
pub struct Trees {
    instances: Bvh,
    placements: Vec<Placement>,
    /// One for each shape.
    shapes: Vec<ShapeTree>,
    route: Route,
}

/// By which route position and normal of a [`SceneHit`] come.
///
/// Vanilla points and lines are where the ray meets them, which parameters do not tell: with either route
/// theirs are carried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Route {
    /// With the hit: what the intersection found on the way.
    #[default]
    Carried,
    /// From the element and `uv`, by [`Scene::eval_position`] and [`Scene::eval_normal`]: as a renderer
    /// does that stores nothing else. `error` covers what that adds.
    Rebuilt,
}

/// How far a rebuilt point may be from the carried one beyond the error of the hit, per unit of the size of
/// the element in the world and of its distance from the origin. `tests/frames.rs` holds it.
const ROUND_TRIP: f32 = 8.0 * f32::EPSILON;

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
        let shapes: Vec<_> = scene.shapes.par_iter().map(ShapeTree::build).collect();
        let place = |instance: &Instance| {
            let frame = Frame::new(instance.world_from_object);
            let bounds = shapes[instance.shape as usize].bounds();
            let ribbon_start = frame.ribbon_start(bounds);
            (Placement { shape: instance.shape, frame, ribbon_start }, frame.world_bounds(bounds))
        };
        let (placements, boxes): (Vec<_>, Vec<_>) = scene.instances.par_iter().map(place).unzip();
        let route = Route::default();
        Self { instances: Bvh::build(&boxes), placements, shapes, route }
    }

    /// The same trees, walked with these instructions: the answers are the same, to the bit.
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        let shapes = self.shapes.into_iter().map(|shape| shape.with_isa(isa)).collect();
        Self { instances: self.instances.with_isa(isa), shapes, ..self }
    }

    /// The same trees, whose hits come by this route.
    #[must_use]
    pub fn with_route(self, route: Route) -> Self {
        Self { route, ..self }
    }

    /// The first surface that the ray meets with `t` in `t_min..=t_max`. Ties go to the instance, and
    /// in it to the element, that comes first.
    ///
    /// `scene` is the one the trees were built of.
    #[must_use]
    pub fn closest(&self, scene: &Scene, ray: &Ray) -> Option<SceneHit> {
        let (instance, t, (element, hit)) = self.instances.closest(ray, |id, ray| {
            let placement = &self.placements[id as usize];
            let shape = &scene.shapes[placement.shape as usize];
            let ray = placement.object_ray(shape, ray);
            let tree = &self.shapes[placement.shape as usize];
            let (element, hit) = tree.closest(&ray, form(shape.method))?;
            Some((hit.t, (element, hit)))
        })?;
        let placement = &self.placements[instance as usize];
        let shape = &scene.shapes[placement.shape as usize];
        let world = placement.frame.world_hit(&hit);
        let primitive = shape.primitive(element);
        let hit = SceneHit {
            instance,
            element,
            uv: primitive.uv(&hit),
            t,
            position: world.position,
            normal: world.normal,
            error: world.error,
        };
        if self.route == Route::Carried || primitive.is_ribbon() {
            return Some(hit);
        }
        let bounds = placement.frame.world_bounds(primitive.bounds());
        let scale = (bounds.max - bounds.min).length() + hit.position.length();
        Some(SceneHit {
            position: scene.eval_position(instance, element, hit.uv),
            normal: scene.eval_normal(instance, element, hit.uv),
            // Of the hit from the surface, and of the rebuilt point from the hit.
            error: 2.0 * hit.error + ROUND_TRIP * scale,
            ..hit
        })
    }

    /// The size of the tree under each shape, in order.
    #[must_use]
    pub fn statistics(&self) -> Vec<Statistics> {
        self.shapes.iter().map(ShapeTree::statistics).collect()
    }

    /// True if the ray meets anything with `t` in `t_min..=t_max`.
    #[must_use]
    pub fn any(&self, scene: &Scene, ray: &Ray) -> bool {
        self.instances.any(ray, |id, ray| {
            let placement = &self.placements[id as usize];
            let shape = &scene.shapes[placement.shape as usize];
            let ray = placement.object_ray(shape, ray);
            self.shapes[placement.shape as usize].any(&ray, form(shape.method))
        })
    }
}

/// The tree over the elements of a shape, in object space.
#[derive(Clone, Debug)]
enum ShapeTree {
    Points(SphereTree),
    Lines(ConeTree),
    Triangles(TriangleTree),
    Quads(PatchTree),
}

impl ShapeTree {
    fn build(shape: &Shape) -> Self {
        match &shape.elements {
            Elements::Points(count) => {
                let spheres: Vec<_> = (0..*count).map(|point| shape.sphere(point)).collect();
                Self::Points(SphereTree::build(&spheres))
            }
            Elements::Lines(lines) => {
                let cones: Vec<_> = lines.iter().map(|&line| shape.cone(line)).collect();
                Self::Lines(ConeTree::build(&cones))
            }
            Elements::Triangles(triangles) => {
                let triangles: Vec<_> =
                    triangles.iter().map(|&vertices| shape.triangle(vertices)).collect();
                Self::Triangles(TriangleTree::build(&triangles))
            }
            Elements::Quads(quads) => {
                let patches: Vec<_> = quads.iter().map(|&quad| shape.patch(quad)).collect();
                Self::Quads(PatchTree::build(&patches))
            }
        }
    }

    fn with_isa(self, isa: Isa) -> Self {
        match self {
            Self::Points(tree) => Self::Points(tree.with_isa(isa)),
            Self::Lines(tree) => Self::Lines(tree.with_isa(isa)),
            Self::Triangles(tree) => Self::Triangles(tree.with_isa(isa)),
            Self::Quads(tree) => Self::Quads(tree.with_isa(isa)),
        }
    }

    fn bounds(&self) -> Aabb {
        match self {
            Self::Points(tree) => tree.bounds(),
            Self::Lines(tree) => tree.bounds(),
            Self::Triangles(tree) => tree.bounds(),
            Self::Quads(tree) => tree.bounds(),
        }
    }

    fn statistics(&self) -> Statistics {
        match self {
            Self::Points(tree) => tree.statistics(),
            Self::Lines(tree) => tree.statistics(),
            Self::Triangles(tree) => tree.statistics(),
            Self::Quads(tree) => tree.statistics(),
        }
    }

    fn closest(&self, ray: &Ray, form: Form) -> Option<(u32, Hit)> {
        match self {
            Self::Points(tree) => tree.closest(ray, form),
            Self::Lines(tree) => tree.closest(ray, form),
            Self::Triangles(tree) => tree.closest(ray, form),
            Self::Quads(tree) => tree.closest(ray, form),
        }
    }

    fn any(&self, ray: &Ray, form: Form) -> bool {
        match self {
            Self::Points(tree) => tree.any(ray, form),
            Self::Lines(tree) => tree.any(ray, form),
            Self::Triangles(tree) => tree.any(ray, form),
            Self::Quads(tree) => tree.any(ray, form),
        }
    }
}

fn form(method: Method) -> Form {
    match method {
        Method::Vanilla => Form::Vanilla,
        Method::Enhanced => Form::Enhanced,
    }
}
