//! Results of closest-hit queries.

use rotund_geometry::Hit;

/// The closest hit that [`Bvh::closest`](crate::Bvh::closest) found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found<T> {
    /// Index of the primitive in the slice that the tree was built from.
    pub id: u32,
    /// Position along the ray, in units of its direction.
    pub t: f32,
    /// The value that the callback returned together with `t`.
    pub value: T,
}

/// The closest primitive that a ray hits, and the hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrimitiveHit {
    /// Index of the primitive in the slice that the tree was built from.
    pub id: u32,
    /// Where the ray meets the primitive.
    pub hit: Hit,
}

/// Where a ray enters or leaves a primitive, or a union of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Index of the primitive in the slice that the tree was built from.
    pub id: u32,
    /// Where the ray meets the primitive.
    pub hit: Hit,
    /// Whether the ray enters the solid, or comes from the front of the surface.
    pub enters: bool,
}
