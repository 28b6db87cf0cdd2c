//! Primitive references, which a tree is built from, and the bounds of ranges of them.

use crate::isa::Isa;
use crate::simd::{Simd, WithSimd};
use glam::{Vec3, Vec4};
use rotund_geometry::Aabb;

/// A box as eight lanes: the lower corner, and the upper corner negated, so that a union is a
/// minimum of all lanes. Lanes 3 and 7 are ignored.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct LaneBounds(pub(crate) [f32; 8]);

impl LaneBounds {
    pub(crate) const EMPTY: Self = Self([f32::INFINITY; 8]);

    pub(crate) fn union(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self(std::array::from_fn(|i| if a[i] < b[i] { a[i] } else { b[i] }))
    }

    #[inline(always)]
    fn lower(&self) -> Vec4 {
        let [x, y, z, w, ..] = self.0;
        Vec4::new(x, y, z, w)
    }

    #[inline(always)]
    fn negated_upper(&self) -> Vec4 {
        let [.., x, y, z, w] = self.0;
        Vec4::new(x, y, z, w)
    }

    /// The centroid, computed without overflow.
    #[inline(always)]
    pub(crate) fn centroid(&self) -> Vec4 {
        0.5 * self.lower() - 0.5 * self.negated_upper()
    }

    /// Half of the size, computed without overflow.
    #[inline(always)]
    pub(crate) fn half_size(&self) -> Vec4 {
        -0.5 * self.negated_upper() - 0.5 * self.lower()
    }

    /// Half of the surface area of the box, its sides scaled by `scale`. A scale that brings the
    /// longest side near one prevents overflow and underflow of the products.
    #[inline(always)]
    pub(crate) fn half_area(&self, scale: f32) -> f32 {
        let size = (self.half_size() * scale).max(Vec4::ZERO);
        size.x * size.y + size.y * size.z + size.z * size.x
    }

    fn to_aabb(self) -> Aabb {
        Aabb { min: self.lower().truncate(), max: -self.negated_upper().truncate() }
    }
}

/// A primitive reference: the box of a primitive and its id, in the size of one AVX register.
///
/// Lanes 3 and 7 hold the id: its lower 23 bits and the others, as fractions of numbers from 1 to
/// 2. Arithmetic runs over these lanes too, and a small id stored as it is would be a subnormal
/// number, which is many times slower.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub(crate) struct PrimRef(pub(crate) LaneBounds);

impl PrimRef {
    const FRACTION: u32 = f32::MANTISSA_DIGITS - 1;
    const ONE: u32 = 1.0_f32.to_bits();

    /// A reference to the primitive `id`; [`Self::is_empty`] if the box is empty or has a NaN.
    pub(crate) fn new(id: u32, bounds: Aabb) -> Self {
        let Some(Aabb { min: lower, max }) = finite_part(bounds) else {
            return Self(LaneBounds::EMPTY);
        };
        let upper = -max;
        let low = f32::from_bits(Self::ONE | (id & ((1 << Self::FRACTION) - 1)));
        let high = f32::from_bits(Self::ONE | (id >> Self::FRACTION));
        Self(LaneBounds([lower.x, lower.y, lower.z, low, upper.x, upper.y, upper.z, high]))
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.0[0] == f32::INFINITY
    }

    #[inline]
    pub(crate) fn id(&self) -> u32 {
        let [low, high] = [3, 7].map(|lane: usize| self.0.0[lane].to_bits() & !Self::ONE);
        low | high << Self::FRACTION
    }
}

/// The box that a tree stores for `bounds`, or `None` if it is empty or has a NaN.
///
/// Infinite sides are clamped to the largest finite number: no hit lies beyond it, and sums and
/// differences of halves stay finite.
pub(crate) fn finite_part(bounds: Aabb) -> Option<Aabb> {
    let (min, max) = (bounds.min.max(Vec3::MIN), bounds.max.min(Vec3::MAX));
    (!bounds.is_empty() && min.cmple(max).all()).then_some(Aabb { min, max })
}

/// Bounds of a range of primitive references: of their boxes, and of the centroids of these.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RangeBounds {
    pub(crate) boxes: LaneBounds,
    pub(crate) centroids: CentroidBounds,
}

/// The box of centroids. The fourth lane is ignored.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CentroidBounds {
    pub(crate) lower: Vec4,
    pub(crate) upper: Vec4,
}

/// Longer ranges are processed in parallel, in chunks of this length.
pub(crate) const PARALLEL_CHUNK: usize = 1 << 16;

impl RangeBounds {
    /// The bounds of `prims`, computed in parallel if there are many.
    pub(crate) fn of(prims: &[PrimRef], isa: Isa) -> Self {
        if prims.len() <= PARALLEL_CHUNK {
            return isa.run(ComputeBounds(prims));
        }
        let (low, high) = prims.split_at(prims.len() / 2);
        let (low, high) = rayon::join(|| Self::of(low, isa), || Self::of(high, isa));
        Self {
            boxes: low.boxes.union(high.boxes),
            centroids: CentroidBounds {
                lower: low.centroids.lower.min(high.centroids.lower),
                upper: low.centroids.upper.max(high.centroids.upper),
            },
        }
    }

    pub(crate) fn to_aabb(self) -> Aabb {
        self.boxes.to_aabb()
    }

    /// Half of the surface area; infinite for boxes longer than the square root of the largest
    /// number, which still serves to compare siblings.
    pub(crate) fn half_area(&self) -> f32 {
        self.boxes.half_area(1.0)
    }
}

struct ComputeBounds<'a>(&'a [PrimRef]);

impl WithSimd for ComputeBounds<'_> {
    type Output = RangeBounds;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> RangeBounds {
        let mut boxes = simd.splat(f32::INFINITY);
        let (mut lower, mut upper) = (Vec4::INFINITY, Vec4::NEG_INFINITY);
        for prim in self.0 {
            boxes = simd.min(boxes, simd.load(&prim.0.0));
            let centroid = prim.0.centroid();
            (lower, upper) = (lower.min(centroid), upper.max(centroid));
        }
        let boxes = LaneBounds(simd.to_array(boxes));
        RangeBounds { boxes, centroids: CentroidBounds { lower, upper } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_keeps_its_id_in_normal_numbers() {
        let bounds = Aabb { min: Vec3::splat(-1.0), max: Vec3::new(2.0, 3.0, f32::INFINITY) };
        for id in [0, 1, 255, (1 << 23) - 1, 1 << 23, 123_456_789, crate::MAX_PRIMITIVES as u32] {
            let prim = PrimRef::new(id, bounds);
            assert_eq!(prim.id(), id);
            assert!(prim.0.0.iter().all(|lane| lane.is_normal()), "{prim:?}");
            assert_eq!(prim.0.to_aabb(), Aabb { max: bounds.max.min(Vec3::MAX), ..bounds });
        }
    }

    #[test]
    fn the_reference_of_an_empty_box_is_empty() {
        let nan = Aabb { min: Vec3::new(f32::NAN, 0.0, 0.0), max: Vec3::ONE };
        for bounds in [Aabb::EMPTY, nan, Aabb { min: Vec3::ZERO, max: Vec3::splat(f32::NAN) }] {
            assert!(PrimRef::new(7, bounds).is_empty(), "{bounds:?}");
        }
    }
}
