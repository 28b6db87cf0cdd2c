//! Bounding volume hierarchies: find the first primitive that a ray hits, or whether it hits any.
//!
//! | type | primitives |
//! | --- | --- |
//! | [`SphereTree`] | spheres; points with the vanilla method |
//! | [`ConeTree`] | rounded cones: hair, bonds, capsules; lines with the vanilla method |
//! | [`PatchTree`] | bilinear patches; pairs of triangles with the vanilla method |
//! | [`TriangleTree`] | triangles |
//! | [`Bvh`] | primitives of your own, or anything in boxes |
//!
//! [`Bvh`] takes a slice of a type that implements [`Primitive`](geometry::Primitive), or boxes and
//! a callback. The four others keep the primitives in their leaves, eight side by side, and test
//! eight at a time. They are built from a slice and queried with a ray:
//!
//! ```
//! use rotund_bvh::geometry::{Ray, RoundedCone, glam::Vec3};
//! use rotund_bvh::{ConeTree, Method};
//!
//! let mut capsules: Vec<RoundedCone> = (0..100)
//!     .map(|i| Vec3::X * i as f32)
//!     .map(|foot| RoundedCone { p0: foot, r0: 0.25, p1: foot + Vec3::Y, r1: 0.125 })
//!     .collect();
//! let mut tree = ConeTree::build(&capsules);
//!
//! let ray = Ray::new(Vec3::new(7.0, 0.0, 5.0), Vec3::NEG_Z);
//! let found = tree.closest(&ray, Method::Enhanced).expect("the ray is aimed at capsule 7");
//! assert_eq!((found.id, found.hit.t, found.hit.normal), (7, 4.75, Vec3::Z));
//!
//! // The capsules move, and the tree follows.
//! for capsule in &mut capsules {
//!     capsule.p0 += Vec3::X;
//!     capsule.p1 += Vec3::X;
//! }
//! tree.refit(&capsules)?;
//! let found = tree.closest(&ray, Method::Enhanced).expect("capsule 6 took its place");
//! assert_eq!(found.id, 6);
//! # Ok::<(), rotund_bvh::RefitError>(())
//! ```
//!
//! # Conventions
//!
//! - The id of a primitive is its index in the slice given to `build`.
//! - `closest` returns the hit with the smallest `t` in the interval of the ray. A tie goes to the
//!   lowest id, so the answer is that of a loop over all primitives, to the bit. `any` returns
//!   whether there is a hit. A `t` of `-0.0` equals one of `0.0`, and ties with it.
//! - Answers are exact in the whole range of `f32`, at less speed for coordinates beyond `2.7e11`:
//!   see [`Packed`].
//! - The test of boxes is conservative: rounding never loses a hit, not even along an edge of a box
//!   or in the plane of a flat one.
//! - Trees are built by the surface area heuristic, on all threads of the current rayon pool. The
//!   same input gives the same tree for any number of threads.
//! - Queries take `&self`; trees are `Send` and `Sync`.

mod build;
mod build_range;
mod bvh;
mod fold;
mod found;
mod huge_pages;
mod isa;
mod node;
mod packed;
mod prim_ref;
mod refit;
mod sah;
mod simd;
mod slab;
mod stack;
#[cfg(test)]
#[path = "../../geometry/src/test_random.rs"]
mod test_random;
mod traverse;

pub use build::MAX_PRIMITIVES;
pub use bvh::Bvh;
pub use found::{Crossing, Found, PrimitiveHit};
pub use isa::{Isa, UnknownIsa, Vectorize};
pub use packed::{
    ConeTree, Packed, PatchTree, SphereTree, Start, Statistics, TriangleTree, Visits,
};
pub use refit::RefitError;
pub use rotund_geometry::{self as geometry, Method};

/// Trees can be shared between threads.
const _: () = {
    const fn is_shared<T: Send + Sync>() {}
    is_shared::<Bvh>();
    is_shared::<SphereTree>();
    is_shared::<ConeTree>();
    is_shared::<PatchTree>();
    is_shared::<TriangleTree>();
};
