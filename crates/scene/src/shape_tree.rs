//! The tree over the elements of one shape.

use crate::{Elements, Method, Shape};
use rotund_bvh::{
    ConeTree, Isa, Packed, PatchTree, PrimitiveHit, SphereTree, Start, Statistics, TriangleTree,
};
use rotund_geometry::glam::Vec3;
use rotund_geometry::{Aabb, BilinearPatch, Ray, RoundedCone, Sphere, Triangle};

/// The tree over the elements of a shape, in object space.
#[derive(Clone, Debug)]
pub(crate) enum ShapeTree {
    Points(SphereTree),
    Lines(ConeTree),
    Triangles(TriangleTree),
    Quads(PatchTree),
}

impl ShapeTree {
    pub(crate) fn build(shape: &Shape) -> Self {
        match &shape.elements {
            Elements::Points(count) => Self::Points(Packed::build(&spheres(shape, *count))),
            Elements::Lines(lines) => Self::Lines(Packed::build(&cones(shape, lines))),
            Elements::Triangles(triangles) => {
                Self::Triangles(Packed::build(&self::triangles(shape, triangles)))
            }
            Elements::Quads(quads) => Self::Quads(Packed::build(&patches(shape, quads))),
        }
    }

    /// Refits the tree to a shape with as many elements as the one it was built from.
    pub(crate) fn refit(&mut self, shape: &Shape) {
        let refitted = match (&mut *self, &shape.elements) {
            (Self::Points(tree), Elements::Points(count)) => tree.refit(&spheres(shape, *count)),
            (Self::Lines(tree), Elements::Lines(lines)) => tree.refit(&cones(shape, lines)),
            (Self::Triangles(tree), Elements::Triangles(triangles)) => {
                tree.refit(&self::triangles(shape, triangles))
            }
            (Self::Quads(tree), Elements::Quads(quads)) => tree.refit(&patches(shape, quads)),
            // Elements of another kind need a new tree.
            _ => return *self = Self::build(shape).with_isa(self.isa()),
        };
        // An element whose bounds overflow `f32` is not in the tree. If it came or went, build a
        // new tree, since that is rare.
        if refitted.is_err() {
            *self = Self::build(shape).with_isa(self.isa());
        }
    }

    pub(crate) fn with_isa(self, isa: Isa) -> Self {
        match self {
            Self::Points(tree) => Self::Points(tree.with_isa(isa)),
            Self::Lines(tree) => Self::Lines(tree.with_isa(isa)),
            Self::Triangles(tree) => Self::Triangles(tree.with_isa(isa)),
            Self::Quads(tree) => Self::Quads(tree.with_isa(isa)),
        }
    }

    fn isa(&self) -> Isa {
        match self {
            Self::Points(tree) => tree.isa(),
            Self::Lines(tree) => tree.isa(),
            Self::Triangles(tree) => tree.isa(),
            Self::Quads(tree) => tree.isa(),
        }
    }

    pub(crate) fn bounds(&self) -> Aabb {
        match self {
            Self::Points(tree) => tree.bounds(),
            Self::Lines(tree) => tree.bounds(),
            Self::Triangles(tree) => tree.bounds(),
            Self::Quads(tree) => tree.bounds(),
        }
    }

    pub(crate) fn statistics(&self) -> Statistics {
        match self {
            Self::Points(tree) => tree.statistics(),
            Self::Lines(tree) => tree.statistics(),
            Self::Triangles(tree) => tree.statistics(),
            Self::Quads(tree) => tree.statistics(),
        }
    }

    /// Writes the first hit of a ray, or `None`, to a place.
    #[inline]
    pub(crate) fn closest(&self, ray: &Ray, method: Method, place: &mut Option<PrimitiveHit>) {
        match self {
            Self::Points(tree) => tree.closest_to(ray, method, place),
            Self::Lines(tree) => tree.closest_to(ray, method, place),
            Self::Triangles(tree) => tree.closest_to(ray, method, place),
            Self::Quads(tree) => tree.closest_to(ray, method, place),
        }
    }

    /// Returns the next boundary of the union of points or lines. Other elements have none.
    #[inline(never)]
    pub(crate) fn boundary(&self, ray: &Ray, start: Start) -> Option<PrimitiveHit> {
        let crossing = match self {
            Self::Points(tree) => tree.boundary(ray, start)?,
            Self::Lines(tree) => tree.boundary(ray, start)?,
            Self::Triangles(_) | Self::Quads(_) => return None,
        };
        Some(PrimitiveHit { id: crossing.id, hit: crossing.hit })
    }

    /// Returns whether other points or lines cover a point of the surface of `element`, given on
    /// either side of it.
    pub(crate) fn covers(&self, element: u32, below: Vec3, above: Vec3) -> bool {
        match self {
            Self::Points(tree) => tree.covers(element, below, above),
            Self::Lines(tree) => tree.covers(element, below, above),
            Self::Triangles(_) | Self::Quads(_) => false,
        }
    }

    #[inline]
    pub(crate) fn any(&self, ray: &Ray, method: Method) -> bool {
        match self {
            Self::Points(tree) => tree.any(ray, method),
            Self::Lines(tree) => tree.any(ray, method),
            Self::Triangles(tree) => tree.any(ray, method),
            Self::Quads(tree) => tree.any(ray, method),
        }
    }
}

fn spheres(shape: &Shape, count: u32) -> Vec<Sphere> {
    (0..count).map(|point| shape.sphere(point)).collect()
}

fn cones(shape: &Shape, lines: &[[u32; 2]]) -> Vec<RoundedCone> {
    lines.iter().map(|&line| shape.cone(line)).collect()
}

fn triangles(shape: &Shape, triangles: &[[u32; 3]]) -> Vec<Triangle> {
    triangles.iter().map(|&vertices| shape.triangle(vertices)).collect()
}

fn patches(shape: &Shape, quads: &[[u32; 4]]) -> Vec<BilinearPatch> {
    quads.iter().map(|&quad| shape.patch(quad)).collect()
}
