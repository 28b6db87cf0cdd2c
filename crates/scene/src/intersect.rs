//! Rays through a scene: a tree over instances, and under each a tree over the elements of its shape.

use crate::{
    ElementKind, Elements, Instance, Method, Scene, SceneError, SceneHit, Shape, frame::Frame,
};
use glam::Affine3A;
use rayon::prelude::*;
use rotund_bvh::{
    Bvh, ConeTree, Isa, PatchTree, PrimitiveHit, SphereTree, Statistics, TriangleTree,
};
use rotund_geometry::{Aabb, Hit, Ray};

/// The trees of one scene.
///
/// They hold the geometry of the shapes as it was, and serve either [`Method`]: setting a method needs
/// no new trees. Any other change of shapes or instances does.
#[derive(Clone, Debug)]
pub struct Trees {
    /// Over `placements`.
    upper: Bvh,
    placements: Vec<Placement>,
    /// One for each shape; then those that several instances share.
    trees: Vec<ShapeTree>,
    /// Of each shared tree, how many elements are before those of each instance.
    shared: Vec<Vec<u32>>,
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

/// One instance, prepared for rays; or several that stand where their shapes do, in one tree.
#[derive(Clone, Copy, Debug)]
struct Placement {
    /// The first, and its shape.
    instance: u32,
    shape: u32,
    /// Index into [`Trees::trees`].
    tree: u32,
    frame: Frame,
    /// Vanilla points and lines nearer than this to the start of a ray, in object space, are what it
    /// has just left.
    ribbon_start: f32,
}

/// Instances of more triangles than this have but their own tree: one more beside it would take as much memory
/// again, and save little.
const FEW: usize = 64;

/// The instances, divided into those that share a tree, each part with the number of its first.
///
/// Neighbours do that are but a few triangles each and need no frame, as the walls of a room: most of what a
/// ray costs is then spent once and not in each. Only triangles have one form whatever the method. Neighbours,
/// so that of equal hits the first instance wins by the order of placements and of triangles in them.
fn parts(scene: &Scene) -> Vec<(u32, &[Instance])> {
    let small = |instance: &Instance| {
        let elements = &scene.shapes[instance.shape as usize].elements;
        instance.world_from_object == Affine3A::IDENTITY
            && elements.kind() == ElementKind::Triangles
            && elements.count() <= FEW
    };
    let parts = scene.instances.chunk_by(|a, b| small(a) && small(b));
    parts
        .scan(0, |next, part| {
            let first = *next;
            *next += part.len() as u32;
            Some((first, part))
        })
        .collect()
}

impl Placement {
    fn object_ray(&self, shape: &Shape, ray: &Ray) -> Ray {
        let mut ray = self.frame.object_ray(ray);
        if shape.is_ribbons() {
            ray.t_min = ray.t_min.max(self.ribbon_start / ray.direction.length());
        }
        ray
    }
}

impl Trees {
    /// Builds all trees, on all threads of the current rayon pool; the result does not depend on how
    /// many there are.
    ///
    /// # Errors
    ///
    /// If the scene is not valid: see [`Scene::validate`], which comes first.
    pub fn build(scene: &Scene) -> Result<Self, SceneError> {
        scene.validate()?;
        let mut trees: Vec<_> = scene.shapes.par_iter().map(ShapeTree::build).collect();
        let parts = parts(scene);
        let place = |&(instance, part): &(u32, &[Instance])| {
            let Instance { shape, world_from_object, .. } = part[0];
            let frame = Frame::new(world_from_object);
            let bounds = trees[shape as usize].bounds();
            let ribbon_start = frame.ribbon_start(bounds);
            let placement = Placement { instance, shape, tree: shape, frame, ribbon_start };
            (placement, frame.world_bounds(bounds))
        };
        let (mut placements, mut boxes): (Vec<_>, Vec<_>) = parts.par_iter().map(place).unzip();
        let mut shared = Vec::new();
        for (index, (_, part)) in parts.iter().enumerate().filter(|(_, (_, part))| part.len() > 1) {
            let (tree, starts) = shared_tree(scene, part);
            placements[index].tree = trees.len() as u32;
            boxes[index] = tree.bounds();
            trees.push(ShapeTree::Triangles(tree));
            shared.push(starts);
        }
        let upper = Bvh::build(&boxes);
        Ok(Self { upper, placements, trees, shared, route: Route::default() })
    }

    /// The same trees, walked with these instructions: the answers are the same, to the bit.
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        let trees = self.trees.into_iter().map(|tree| tree.with_isa(isa)).collect();
        Self { upper: self.upper.with_isa(isa), trees, ..self }
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
        if let [placement] = self.placements.as_slice() {
            // Not moved out of the option: a copy of what has just been written waits until it has left the processor.
            let found = self.closest_in(scene, placement, ray);
            return found
                .as_ref()
                .map(|found| self.scene_hit(scene, placement, found.id, &found.hit));
        }
        let test = |id: u32, ray: &Ray| {
            let found = self.closest_in(scene, &self.placements[id as usize], ray)?;
            Some((found.hit.t, found))
        };
        let found = self.upper.closest(ray, test)?;
        let (placement, primitive) = (&self.placements[found.id as usize], &found.value);
        Some(self.scene_hit(scene, placement, primitive.id, &primitive.hit))
    }

    /// What a ray meets of a placement.
    #[inline(always)]
    fn closest_in(&self, scene: &Scene, placement: &Placement, ray: &Ray) -> Option<PrimitiveHit> {
        let shape = &scene.shapes[placement.shape as usize];
        let tree = &self.trees[placement.tree as usize];
        tree.closest(&placement.object_ray(shape, ray), shape.method)
    }

    /// The hit of an element of a placement, in world space.
    #[inline(always)]
    fn scene_hit(&self, scene: &Scene, placement: &Placement, element: u32, hit: &Hit) -> SceneHit {
        let (instance, element) = self.locate(placement, element);
        let shape = &scene.shapes[scene.instances[instance as usize].shape as usize];
        let world = placement.frame.world_hit(hit);
        let hit = SceneHit {
            instance,
            element,
            uv: shape.uv(element, hit),
            t: hit.t,
            position: world.position,
            normal: world.normal,
            error: world.error,
        };
        if self.route == Route::Carried || shape.is_ribbons() {
            return hit;
        }
        let bounds = placement.frame.world_bounds(shape.primitive(element).bounds());
        let scale = (bounds.max - bounds.min).length() + hit.position.length();
        SceneHit {
            position: scene.eval_position(instance, element, hit.uv),
            normal: scene.eval_normal(instance, element, hit.uv),
            // Of the hit from the surface, and of the rebuilt point from the hit.
            error: 2.0 * hit.error + ROUND_TRIP * scale,
            ..hit
        }
    }

    /// The size of the tree under each shape, in order.
    #[must_use]
    pub fn statistics(&self) -> Vec<Statistics> {
        self.trees[..self.shape_count()].iter().map(ShapeTree::statistics).collect()
    }

    fn shape_count(&self) -> usize {
        self.trees.len() - self.shared.len()
    }

    /// An instance and an element of its shape, from an element of the tree of a placement.
    fn locate(&self, placement: &Placement, element: u32) -> (u32, u32) {
        let Some(shared) = (placement.tree as usize).checked_sub(self.shape_count()) else {
            return (placement.instance, element);
        };
        let starts = &self.shared[shared];
        let place = starts.partition_point(|&start| start <= element) - 1;
        (placement.instance + place as u32, element - starts[place])
    }

    /// True if the ray meets anything with `t` in `t_min..=t_max`.
    #[must_use]
    pub fn any(&self, scene: &Scene, ray: &Ray) -> bool {
        let test = |id: u32, ray: &Ray| {
            let placement = &self.placements[id as usize];
            let shape = &scene.shapes[placement.shape as usize];
            let ray = placement.object_ray(shape, ray);
            self.trees[placement.tree as usize].any(&ray, shape.method)
        };
        if self.placements.len() == 1 { test(0, ray) } else { self.upper.any(ray, test) }
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

    fn closest(&self, ray: &Ray, method: Method) -> Option<PrimitiveHit> {
        match self {
            Self::Points(tree) => tree.closest(ray, method),
            Self::Lines(tree) => tree.closest(ray, method),
            Self::Triangles(tree) => tree.closest(ray, method),
            Self::Quads(tree) => tree.closest(ray, method),
        }
    }

    fn any(&self, ray: &Ray, method: Method) -> bool {
        match self {
            Self::Points(tree) => tree.any(ray, method),
            Self::Lines(tree) => tree.any(ray, method),
            Self::Triangles(tree) => tree.any(ray, method),
            Self::Quads(tree) => tree.any(ray, method),
        }
    }
}

/// A tree over the triangles of all these instances, and how many are before those of each.
fn shared_tree(scene: &Scene, instances: &[Instance]) -> (TriangleTree, Vec<u32>) {
    let (mut triangles, mut starts) = (Vec::new(), Vec::new());
    for instance in instances {
        let shape = &scene.shapes[instance.shape as usize];
        starts.push(triangles.len() as u32);
        if let Elements::Triangles(elements) = &shape.elements {
            triangles.extend(elements.iter().map(|&vertices| shape.triangle(vertices)));
        }
    }
    (TriangleTree::build(&triangles), starts)
}
