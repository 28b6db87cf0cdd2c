//! Placements: instances prepared for ray queries, where small neighbours share a tree.

use crate::{
    ElementKind, Elements, Instance, Method, Scene, Shape, frame::Frame, plate::Plate,
    shape_tree::ShapeTree, unions::Unions,
};
use glam::Affine3A;
use rayon::prelude::*;
use rotund_bvh::TriangleTree;
use rotund_geometry::{Aabb, Ray};

/// An instance prepared for ray queries, or several small ones with identity frames in one tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    /// The first instance, and its shape.
    pub instance: u32,
    pub shape: u32,
    /// Index into [`Placements::trees`].
    pub tree: u32,
    pub frame: Frame,
    /// Vanilla points and lines nearer than this to the start of a ray, in object space, are taken
    /// for the one that the ray has just left.
    ribbon_start: f32,
    /// The elements are one body into which one can see.
    union: bool,
}

/// The most triangles of an instance that shares a tree. Larger ones only have the tree of their
/// shape, since a copy would double the memory and save little time.
const FEW: usize = 64;

/// Divides the instances into runs that share a tree, each with the index of its first instance.
///
/// A run consists of consecutive instances of few triangles with identity frames, such as the walls
/// of a room, so that a ray pays most of its cost once and not for each. Only triangles are the
/// same primitive under either method. Runs are consecutive so that, of equal `t`, the first
/// instance wins by the order of placements and of triangles in them.
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
    /// Returns a ray in the space of the shape: the ray itself where that is world space, and
    /// otherwise the transformed one, which is written to `place`.
    #[inline(always)]
    pub(crate) fn ray_in_object<'a>(
        &self,
        shape: &Shape,
        ray: &'a Ray,
        place: &'a mut Option<Ray>,
    ) -> &'a Ray {
        if self.frame.is_identity() && !shape.is_ribbons() {
            ray
        } else {
            place.insert(self.object_ray(shape, ray))
        }
    }

    /// Transforms a ray to the space of the shape.
    #[inline]
    fn object_ray(&self, shape: &Shape, ray: &Ray) -> Ray {
        let mut ray = self.frame.object_ray(ray);
        if shape.is_ribbons() {
            ray.t_min = ray.t_min.max(self.ribbon_start / ray.direction.length());
        }
        ray
    }

    /// Returns whether the elements are one body into which one can see.
    pub(crate) fn is_body(&self) -> bool {
        self.union
    }

    /// Returns whether the surface of the shape is the boundary of the union of its elements.
    #[inline]
    pub(crate) fn is_union(&self, shape: &Shape) -> bool {
        self.union && shape.method == Method::Enhanced
    }
}

/// The placements of a scene, their bounds, and the trees that they refer to.
pub(crate) struct Placements {
    pub placements: Vec<Placement>,
    /// The bounds of each placement in world space.
    pub boxes: Vec<Aabb>,
    /// The tree of each shape, followed by those that several instances share.
    pub trees: Vec<ShapeTree>,
    /// Planes around the elements of each tree of a flat shape; shared trees have none.
    pub plates: Vec<Option<Plate>>,
    /// For each shared tree, the number of elements before those of each of its instances.
    pub shared: Vec<Vec<u32>>,
}

impl Placements {
    /// Prepares the instances. `trees` are those of the shapes; shared ones are added.
    pub(crate) fn new(scene: &Scene, mut trees: Vec<ShapeTree>) -> Self {
        let parts = parts(scene);
        let unions = Unions::new(scene);
        let place = |&(instance, part): &(u32, &[Instance])| {
            let Instance { shape, world_from_object, .. } = part[0];
            let frame = Frame::new(world_from_object);
            let bounds = trees[shape as usize].bounds();
            let ribbon_start = frame.ribbon_start(bounds);
            let union = unions.contain(&part[0]);
            let placement = Placement { instance, shape, tree: shape, frame, ribbon_start, union };
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
        let mut plates: Vec<_> = scene.shapes.par_iter().map(Plate::around).collect();
        plates.resize(trees.len(), None);
        Self { placements, boxes, trees, plates, shared }
    }
}

/// Builds a tree over the triangles of all these instances, with the number of triangles before
/// those of each.
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
