//! Axis-aligned boxes.

use glam::Vec3;

/// An axis-aligned box: the points with coordinates in `min..=max`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Aabb {
    /// The corner with the smallest coordinates.
    pub min: Vec3,
    /// The corner with the largest coordinates.
    pub max: Vec3,
}

/// The empty box, [`Aabb::EMPTY`].
impl Default for Aabb {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Aabb {
    /// The box without points, the identity of [`Aabb::union`]: `min` is infinity, `max` is minus
    /// infinity.
    pub const EMPTY: Self =
        Self { min: Vec3::splat(f32::INFINITY), max: Vec3::splat(f32::NEG_INFINITY) };

    /// Returns the smallest box that contains `points`; [`Aabb::EMPTY`] if there are none.
    ///
    /// If a coordinate is NaN, the result is unspecified.
    #[must_use]
    pub fn from_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |sum, p| sum.union(Self { min: p, max: p }))
    }

    /// Returns the smallest box that contains both boxes.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Returns whether the box contains no point. A box with a NaN counts as empty.
    #[must_use]
    pub fn is_empty(self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Returns the center, without overflow of the sum of two large coordinates.
    #[must_use]
    pub fn center(self) -> Vec3 {
        0.5 * self.min + 0.5 * self.max
    }

    /// Returns half of the surface area, the measure of the surface area heuristic; zero for an
    /// empty box.
    #[must_use]
    pub fn half_area(self) -> f32 {
        let size = (self.max - self.min).max(Vec3::ZERO);
        size.x * size.y + size.y * size.z + size.z * size.x
    }

    /// Returns the box with each side moved outwards by 2⁻²⁶ of the longest side, and then to the
    /// next `f32`.
    ///
    /// The first step covers the rounding of the `f64` arithmetic for rays that start up to 2²⁶
    /// sizes away, which matters where a side lies near a coordinate of zero. The second step
    /// covers the rounding to `f32` of a surface point or of a side of the box.
    pub(crate) fn grown_by_rounding(self) -> Self {
        // The halves are subtracted, so that the largest numbers do not overflow.
        let half = (0.5 * self.max - 0.5 * self.min).max_element();
        let margin = Vec3::splat(half * (0.5 * f32::EPSILON * 0.5));
        Self {
            min: (self.min - margin).map(f32::next_down),
            max: (self.max + margin).map(f32::next_up),
        }
    }
}
