//! Bounding volume hierarchies for rays.
//!
//! [`Bvh`] is the tree over plain boxes: bring any primitive, and a closure that tests it.
//!
//! A tree answers two questions about a ray. *Closest*: which primitive does it meet first? A tie
//! in `t` goes to the lower id, so the answer is that of a loop over all primitives, to the bit.
//! *Any*: does it meet one at all? The test of a box is conservative: rounding never loses a ray,
//! not even one along an edge or in the plane of a flat box.
//!
//! Trees are built with the surface area heuristic, on all threads of the current rayon pool; the
//! same input gives the same tree for any number of threads.

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
mod traverse;

pub use build::MAX_PRIMITIVES;
pub use bvh::Bvh;
pub use found::{Found, PrimitiveHit};
pub use isa::{Isa, UnknownIsa};
pub use packed::{ConeTree, Packed, PatchTree, SphereTree, Statistics, TriangleTree, Visits};
pub use refit::RefitError;
pub use rotund_geometry::{self as geometry, Method};
