//! A ray, and where it meets a primitive.

use glam::{Vec2, Vec3};

/// The points `origin + t * direction` with `t` in `t_min..=t_max`.
///
/// The direction may have any length but zero; `t` counts in units of it. An interval that is empty
/// or has a NaN end meets nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where `t` is zero.
    pub origin: Vec3,
    /// The step of `t = 1`; not necessarily of unit length.
    pub direction: Vec3,
    /// The nearest `t` that counts as a hit.
    pub t_min: f32,
    /// The farthest `t` that counts as a hit.
    pub t_max: f32,
}

impl Ray {
    /// A ray from `origin` on to infinity, `t` in `0.0..=f32::INFINITY`.
    #[must_use]
    pub const fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// The point at `t`, rounded at each step; a [`Hit`] carries a better one.
    #[must_use]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + t * self.direction
    }
}

/// Where a ray meets a primitive.
///
/// The ray enters a solid, or comes from the front of a surface, if `normal.dot(ray.direction)` is
/// negative, and leaves it otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Position along the ray, in units of `Ray::direction`, which need not have unit length.
    pub t: f32,
    /// The point itself, more accurate than `ray.at(t)`.
    pub position: Vec3,
    /// Bound on the distance from `position` to the exact surface. See [`crate::leave_surface`].
    pub error: f32,
    /// Geometric normal: unit length, out of the solid, whichever side the ray came from. A patch,
    /// a triangle or a quad points where its parameters turn counter-clockwise.
    pub normal: Vec3,
    /// What the primitive needs to name the point, at no cost to the intersection: ask its `uv`.
    pub parameters: Vec2,
}
