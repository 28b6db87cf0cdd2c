//! Ray space: vertices projected along a ray onto a plane, in which the ray is the origin.

use glam::Vec3;

use crate::Ray;
use crate::f64x2::{F64x2, Mask};

/// The projection of points along a ray onto a plane.
///
/// The plane is spanned by the two axes other than the dominant axis `z` of the direction:
/// `x = f_x d_z - f_z d_x`, `y = f_y d_z - f_z d_y`, with `f` the point minus the origin of the
/// ray. The image of a vertex depends on nothing but the ray and the vertex. Two patches that share
/// a vertex therefore project it to the same bits, whatever their other vertices are: this makes
/// shared edges watertight.
///
/// Source: S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013.
/// Here the division by `d_z` is left out, so the image is scaled by it.
#[derive(Clone, Copy)]
pub(crate) struct RaySpace {
    axes: [usize; 3],
    // Each value is in both lanes. They are separate fields because the compiler keeps those in
    // registers, but an array in memory.
    ox: F64x2,
    oy: F64x2,
    oz: F64x2,
    dx: F64x2,
    dy: F64x2,
    dz: F64x2,
}

/// The images of two vertices, and their depths, the distances along the dominant axis.
#[derive(Clone, Copy)]
pub(crate) struct Images {
    pub(crate) x: F64x2,
    pub(crate) y: F64x2,
    pub(crate) depth: F64x2,
}

impl RaySpace {
    #[inline(always)]
    pub(crate) fn new(ray: &Ray) -> Self {
        // The bits of non-negative numbers have the order of the numbers, and integers are compared
        // faster. The dominant axis is computed branch-free, because it is unpredictable.
        let [x, y, z] = ray.direction.to_array().map(|d| d.to_bits() << 1);
        let z = (usize::from(y >= x) + 2 * usize::from(z >= x.max(y))).min(2);
        // Arithmetic instead of a table, so that the compiler can prove the indices to be below 3.
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

    /// Returns the axes of the world that are `x`, `y` and `z` of the image.
    #[inline(always)]
    pub(crate) fn axes(&self) -> [usize; 3] {
        self.axes
    }

    /// Projects two points.
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

    /// Returns the absolute value of the direction along the dominant axis.
    #[inline(always)]
    pub(crate) fn length(&self) -> f64 {
        self.dz.first().abs()
    }

    /// Returns the `t` of a depth.
    #[inline(always)]
    pub(crate) fn t(&self, depth: f64) -> f64 {
        depth * self.dz.first().recip()
    }
}

impl Images {
    /// Returns the first vertices of both pairs.
    #[inline(always)]
    pub(crate) fn firsts(&self, other: &Self) -> Self {
        let (x, y) = (self.x.firsts(other.x), self.y.firsts(other.y));
        Self { x, y, depth: self.depth.firsts(other.depth) }
    }

    /// Returns the second vertices of both pairs.
    #[inline(always)]
    pub(crate) fn seconds(&self, other: &Self) -> Self {
        let (x, y) = (self.x.seconds(other.x), self.y.seconds(other.y));
        Self { x, y, depth: self.depth.seconds(other.depth) }
    }

    /// Returns both vertices in the other order.
    #[inline(always)]
    pub(crate) fn swapped(&self) -> Self {
        Self { x: self.x.swapped(), y: self.y.swapped(), depth: self.depth.swapped() }
    }

    /// Returns twice the signed areas of the triangles (ray, vertex, vertex of `to`).
    ///
    /// If the two vertices change places, the area is negated to the bit, so that two neighbors
    /// with a common edge agree about its side.
    #[inline(always)]
    pub(crate) fn areas(&self, to: &Self) -> F64x2 {
        self.x * to.y - to.x * self.y
    }

    /// Returns whether the edges to `to`, with these `areas`, cross the positive x axis of the
    /// image.
    ///
    /// The answer is the same for both directions of an edge. The winding number of a closed
    /// outline about the ray is odd exactly if an odd number of its edges cross that axis. A vertex
    /// on the axis counts as above it.
    #[inline(always)]
    pub(crate) fn crosses(&self, to: &Self, areas: F64x2) -> Mask {
        let zero = F64x2::splat(0.0);
        let (above, to_above) = (zero.less_or_equal(self.y), zero.less_or_equal(to.y));
        above.differs(to_above).and(zero.less(areas.negated_unless(to_above)))
    }
}
