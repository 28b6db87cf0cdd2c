//! Whether the elements of a shape are one body.

/// What the points or lines of a shape are where they overlap, with
/// [`Method::Enhanced`](crate::Method::Enhanced).
///
/// It matters only where the inside of a shape can be seen: with a material that is transparent,
/// refractive, volumetric or of partial opacity. In scene files it is `"union"` or `"separate"`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "load", derive(serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Overlap {
    /// One solid, the union of the balls or cones. Its surface is the boundary of the union; what
    /// lies inside another element is not a surface.
    #[default]
    Union,
    /// Every element has its own whole surface.
    Separate,
}
