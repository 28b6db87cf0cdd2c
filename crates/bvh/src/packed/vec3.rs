//! Vectors of three coordinates in eight lanes.
//!
//! These are functions and not closures: a closure is compiled as a function of its own, without
//! the instruction set of its caller, and may then be too large to be inlined. The same holds for
//! all code that is compiled once for each instruction set.

use crate::node::WIDTH;
use crate::simd::Simd;
use rotund_geometry::glam::Vec3;

/// `a · b`.
#[inline(always)]
pub(crate) fn dot<S: Simd>(simd: S, a: [S::Lanes; 3], b: [S::Lanes; 3]) -> S::Lanes {
    simd.mul_add(a[0], b[0], simd.mul_add(a[1], b[1], simd.mul(a[2], b[2])))
}

/// `a - b`.
#[inline(always)]
pub(crate) fn sub<S: Simd>(simd: S, a: [S::Lanes; 3], b: [S::Lanes; 3]) -> [S::Lanes; 3] {
    [simd.sub(a[0], b[0]), simd.sub(a[1], b[1]), simd.sub(a[2], b[2])]
}

/// `c - a b`.
#[inline(always)]
pub(crate) fn neg_mul_add<S: Simd>(
    simd: S,
    a: S::Lanes,
    b: [S::Lanes; 3],
    c: [S::Lanes; 3],
) -> [S::Lanes; 3] {
    [
        simd.neg_mul_add(a, b[0], c[0]),
        simd.neg_mul_add(a, b[1], c[1]),
        simd.neg_mul_add(a, b[2], c[2]),
    ]
}

/// One vector in all lanes.
#[inline(always)]
pub(crate) fn splat<S: Simd>(simd: S, v: Vec3) -> [S::Lanes; 3] {
    [simd.splat(v.x), simd.splat(v.y), simd.splat(v.z)]
}

/// The vectors whose coordinates are in three rows of a block.
#[inline(always)]
pub(crate) fn load<S: Simd>(simd: S, rows: [&[f32; WIDTH]; 3]) -> [S::Lanes; 3] {
    [simd.load(rows[0]), simd.load(rows[1]), simd.load(rows[2])]
}
