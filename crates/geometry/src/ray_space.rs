//! Vertices as a ray sees them: a picture in which the ray is the origin.

use glam::Vec3;

use crate::{Ray, widen};

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
    origin: [f64; 3],
    direction: [f64; 3],
    over_dz: f64,
}

/// The two axes that follow each axis.
const ACROSS: [[usize; 2]; 4] = [[1, 2], [2, 0], [0, 1], [0, 1]];

/// The image of a vertex, and its depth: the distance along the dominant axis.
#[derive(Clone, Copy)]
pub(crate) struct Image {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) depth: f64,
}

impl RaySpace {
    #[inline(always)]
    pub(crate) fn new(ray: &Ray) -> Self {
        let size = ray.direction.abs();
        let z = if size.x > size.y {
            if size.x > size.z { 0 } else { 2 }
        } else if size.y > size.z {
            1
        } else {
            2
        };
        let [x, y] = ACROSS[z & 3];
        let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
        let ([ox, oy], [dx, dy], [oz, dz]) =
            (widen::pair(o[x], o[y]), widen::pair(d[x], d[y]), widen::pair(o[z], d[z]));
        Self { axes: [x, y, z], origin: [ox, oy, oz], direction: [dx, dy, dz], over_dz: dz.recip() }
    }

    /// The axes that are `x`, `y` and `z` of the image.
    #[inline(always)]
    pub(crate) fn axes(&self) -> [usize; 3] {
        self.axes
    }

    /// The images of two points.
    #[inline(always)]
    pub(crate) fn project(&self, p: Vec3, q: Vec3) -> (Image, Image) {
        let [x, y, z] = self.axes;
        let (p, q) = (p.to_array(), q.to_array());
        let (p_xy, q_xy) = (widen::pair(p[x], p[y]), widen::pair(q[x], q[y]));
        let [pz, qz] = widen::pair(p[z], q[z]);
        (self.image(p_xy, pz), self.image(q_xy, qz))
    }

    #[inline(always)]
    fn image(&self, [x, y]: [f64; 2], z: f64) -> Image {
        let [dx, dy, dz] = self.direction;
        let [ox, oy, oz] = self.origin;
        let (x, y, z) = (x - ox, y - oy, z - oz);
        Image { x: x * dz - z * dx, y: y * dz - z * dy, depth: z }
    }

    /// `t` at a depth.
    #[inline(always)]
    pub(crate) fn t(&self, depth: f64) -> f64 {
        depth * self.over_dz
    }
}

/// Twice the signed area of the triangle (ray, a, b): negated, to the last bit, if `a` and `b` change
/// places, so that it cannot disagree between two neighbours.
#[inline]
pub(crate) fn edge(a: Image, b: Image) -> f64 {
    a.x * b.y - b.x * a.y
}

/// True if the edge from `a` to `b` with the area `area` crosses the positive x axis of the image.
///
/// The same for both directions of an edge. A closed outline crosses it an odd number of times exactly
/// if the ray passes through it an odd number of times. (An end on the axis counts as above it.)
#[inline]
pub(crate) fn crosses(a: Image, b: Image, area: f64) -> bool {
    let (a_above, b_above) = (a.y >= 0.0, b.y >= 0.0);
    (a_above != b_above) & if b_above { area > 0.0 } else { area < 0.0 }
}
