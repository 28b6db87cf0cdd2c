//! Vertices as a ray sees them: a picture in which the ray is the origin.

use glam::Vec3;

use crate::Ray;
use crate::f64x2::{F64x2, Mask};

/// Projects points along a ray onto a plane.
///
/// The plane is the pair of axes that are not the dominant one of the direction, `z`:
/// `x = f_x d_z - f_z d_x`, `y = f_y d_z - f_z d_y`, with `f` the point seen from the origin of the ray.
/// The image of a vertex depends on nothing but the ray and the vertex. Two patches that share a vertex
/// thus see it at the same place, to the last bit, whatever else they are made of: that is what makes
/// shared edges watertight.
///
/// Source: S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013.
/// There is no division here, so the image is scaled by `d_z`.
#[derive(Clone, Copy)]
pub(crate) struct RaySpace {
    axes: [usize; 3],
    // Each twice, in fields of their own: the compiler keeps these in registers, but an array in memory.
    ox: F64x2,
    oy: F64x2,
    oz: F64x2,
    dx: F64x2,
    dy: F64x2,
    dz: F64x2,
}

/// The images of two vertices, and their depths: the distances along the dominant axis.
#[derive(Clone, Copy)]
pub(crate) struct Images {
    pub(crate) x: F64x2,
    pub(crate) y: F64x2,
    pub(crate) depth: F64x2,
}

impl RaySpace {
    #[inline(always)]
    pub(crate) fn new(ray: &Ray) -> Self {
        // Of numbers that are not negative the bits have the same order, and are compared faster. Sums
        // instead of branches: the axis of the next ray cannot be foretold.
        let [x, y, z] = ray.direction.to_array().map(|d| d.to_bits() << 1);
        let z = (usize::from(y >= x) + 2 * usize::from(z >= x.max(y))).min(2);
        // Not by a table: so the compiler sees that they are axes.
        let (x, y) = (if z == 2 { 0 } else { z + 1 }, if z == 0 { 2 } else { z - 1 });
        let (o, d): (&[f32; 3], &[f32; 3]) = (ray.origin.as_ref(), ray.direction.as_ref());
        let (x_of, y_of) = (F64x2::widen(o[x], d[x]), F64x2::widen(o[y], d[y]));
        let z_of = F64x2::widen(o[z], d[z]);
        Self {
            axes: [x, y, z],
            ox: x_of.firsts(x_of),
            oy: y_of.firsts(y_of),
            oz: z_of.firsts(z_of),
            dx: x_of.seconds(x_of),
            dy: y_of.seconds(y_of),
            dz: z_of.seconds(z_of),
        }
    }

    /// The axes that are `x`, `y` and `z` of the image.
    #[inline(always)]
    pub(crate) fn axes(&self) -> [usize; 3] {
        self.axes
    }

    /// The images of two points.
    #[inline(always)]
    pub(crate) fn project(&self, p: &Vec3, q: &Vec3) -> Images {
        let [x, y, z] = self.axes;
        let (p, q): (&[f32; 3], &[f32; 3]) = (p.as_ref(), q.as_ref());
        let Self { ox, oy, oz, dx, dy, dz, .. } = *self;
        let depth = F64x2::widen(p[z], q[z]) - oz;
        Images {
            x: (F64x2::widen(p[x], q[x]) - ox) * dz - depth * dx,
            y: (F64x2::widen(p[y], q[y]) - oy) * dz - depth * dy,
            depth,
        }
    }

    /// The size of the direction along the dominant axis.
    #[inline(always)]
    pub(crate) fn length(&self) -> f64 {
        self.dz.first().abs()
    }

    /// `t` at a depth.
    #[inline(always)]
    pub(crate) fn t(&self, depth: f64) -> f64 {
        depth * self.dz.first().recip()
    }
}

impl Images {
    /// The first vertex of both.
    #[inline(always)]
    pub(crate) fn firsts(&self, other: &Self) -> Self {
        let (x, y) = (self.x.firsts(other.x), self.y.firsts(other.y));
        Self { x, y, depth: self.depth.firsts(other.depth) }
    }

    /// The second vertex of both.
    #[inline(always)]
    pub(crate) fn seconds(&self, other: &Self) -> Self {
        let (x, y) = (self.x.seconds(other.x), self.y.seconds(other.y));
        Self { x, y, depth: self.depth.seconds(other.depth) }
    }

    /// Both vertices in the other order.
    #[inline(always)]
    pub(crate) fn swapped(&self) -> Self {
        Self { x: self.x.swapped(), y: self.y.swapped(), depth: self.depth.swapped() }
    }

    /// Twice the signed areas of the triangles (ray, a vertex, the vertex of `to`): negated, to the last
    /// bit, if the two change places, so that it cannot disagree between two neighbours.
    #[inline(always)]
    pub(crate) fn areas(&self, to: &Self) -> F64x2 {
        self.x * to.y - to.x * self.y
    }

    /// Whether the edges to `to`, with these `areas`, cross the positive x axis of the image.
    ///
    /// The same for both directions of an edge. A closed outline crosses it an odd number of times exactly
    /// if the ray passes through it an odd number of times. (An end on the axis counts as above it.)
    #[inline(always)]
    pub(crate) fn crosses(&self, to: &Self, areas: F64x2) -> Mask {
        let zero = F64x2::splat(0.0);
        let (above, to_above) = (zero.less_or_equal(self.y), zero.less_or_equal(to.y));
        above.differs(to_above).and(zero.less(areas.negated_unless(to_above)))
    }
}
