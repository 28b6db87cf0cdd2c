//! Boxes with sides parallel to the axes.

use glam::Vec3;

/// A closed box, `min..=max` in each coordinate.
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
    /// The box of nothing: the identity of [`Aabb::union`].
    pub const EMPTY: Self =
        Self { min: Vec3::splat(f32::INFINITY), max: Vec3::splat(f32::NEG_INFINITY) };

    /// The smallest box around `points`.
    #[must_use]
    pub fn from_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |sum, p| sum.union(Self { min: p, max: p }))
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// True if no point is inside; also if a coordinate is NaN.
    #[must_use]
    pub fn is_empty(self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// The middle, without overflow.
    #[must_use]
    pub fn center(self) -> Vec3 {
        0.5 * self.min + 0.5 * self.max
    }

    /// Half of the surface area, zero for an empty box: what the surface area heuristic compares.
    #[must_use]
    pub fn half_area(self) -> f32 {
        let size = (self.max - self.min).max(Vec3::ZERO);
        size.x * size.y + size.y * size.z + size.z * size.x
    }

    /// The box with each side moved out by 2⁻²⁶ of the longest, and then to the next `f32`.
    ///
    /// The first step is for what an `f64` loses on the way from a ray that starts up to 2²⁶ sizes away,
    /// where a side happens to lie near a coordinate of zero; the second for rounding a point of the
    /// surface, or a side of the box, to nearest.
    pub(crate) fn grown_by_rounding(self) -> Self {
        // Halves, so that the largest numbers do not overflow.
        let half = (0.5 * self.max - 0.5 * self.min).max_element();
        let margin = Vec3::splat(half * (0.5 * f32::EPSILON * 0.5));
        Self {
            min: (self.min - margin).map(f32::next_down),
            max: (self.max + margin).map(f32::next_up),
        }
    }
}
