//! What a tree is built from: boxes that know their ids, and unions of them.

use crate::isa::Isa;
use crate::simd::{Simd, Task};
use glam::{Vec3, Vec4};
use rotund_geometry::Aabb;

/// Eight lanes: the lower corner of a box, and the upper one negated, so that a union is a minimum of all lanes.
/// The lanes 3 and 7 are of no meaning.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Corners(pub(crate) [f32; 8]);

impl Corners {
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

    /// The middle without overflow.
    #[inline(always)]
    pub(crate) fn middle(&self) -> Vec4 {
        0.5 * self.lower() - 0.5 * self.negated_upper()
    }

    /// Half of the size, without overflow.
    #[inline(always)]
    pub(crate) fn half_size(&self) -> Vec4 {
        -0.5 * self.negated_upper() - 0.5 * self.lower()
    }

    /// Half of the surface area of the box times `scale`, which is to bring the widest side of the node to one,
    /// so that products neither overflow nor vanish.
    #[inline(always)]
    pub(crate) fn half_area(&self, scale: f32) -> f32 {
        let size = (self.half_size() * scale).max(Vec4::ZERO);
        size.x * size.y + size.y * size.z + size.z * size.x
    }

    fn bounds(&self) -> Aabb {
        Aabb { min: self.lower().truncate(), max: -self.negated_upper().truncate() }
    }
}

/// A box and the id of what it bounds, in one register.
///
/// The lanes 3 and 7 carry the id: 23 bits and the rest as fractions of numbers from 1 to 2, since arithmetic
/// goes over them too, and is many times slower for a subnormal number, as a small id by itself is.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub(crate) struct Record(pub(crate) Corners);

impl Record {
    const FRACTION: u32 = f32::MANTISSA_DIGITS - 1;
    const ONE: u32 = 1.0_f32.to_bits();

    /// The record of a box that is empty or has a NaN is [`Self::is_empty`].
    ///
    pub(crate) fn new(id: u32, bounds: Aabb) -> Self {
        let Some(Aabb { min: lower, max }) = finite_part(bounds) else {
            return Self(Corners::EMPTY);
        };
        let upper = -max;
        let low = f32::from_bits(Self::ONE | (id & ((1 << Self::FRACTION) - 1)));
        let high = f32::from_bits(Self::ONE | (id >> Self::FRACTION));
        Self(Corners([lower.x, lower.y, lower.z, low, upper.x, upper.y, upper.z, high]))
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

/// The box that a tree keeps in place of `bounds`, or `None` if it is empty or has a NaN.
///
/// An infinite side is clamped to the largest number: no hit lies beyond it, and sums and differences of
/// halves stay finite.
pub(crate) fn finite_part(bounds: Aabb) -> Option<Aabb> {
    let (min, max) = (bounds.min.max(Vec3::MIN), bounds.max.min(Vec3::MAX));
    (!bounds.is_empty() && min.cmple(max).all()).then_some(Aabb { min, max })
}

/// The boxes of a range of records: of the boxes themselves, and of their middles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    pub(crate) boxes: Corners,
    pub(crate) middles: Middles,
}

/// The box of middles. The fourth lane is of no meaning.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Middles {
    pub(crate) lower: Vec4,
    pub(crate) upper: Vec4,
}

/// Ranges longer than this are worked on in parallel, in pieces of this length.
pub(crate) const PIECE: usize = 1 << 16;

impl Extent {
    /// In parallel if they are many.
    pub(crate) fn of(records: &[Record], isa: Isa) -> Self {
        if records.len() <= PIECE {
            return isa.run(ExtentOf(records));
        }
        let (low, high) = records.split_at(records.len() / 2);
        let (low, high) = rayon::join(|| Self::of(low, isa), || Self::of(high, isa));
        Self {
            boxes: low.boxes.union(high.boxes),
            middles: Middles {
                lower: low.middles.lower.min(high.middles.lower),
                upper: low.middles.upper.max(high.middles.upper),
            },
        }
    }

    pub(crate) fn bounds(&self) -> Aabb {
        self.boxes.bounds()
    }

    /// Half of the surface area; infinite for boxes wider than the square root of the largest
    /// number, which is good enough to order siblings.
    pub(crate) fn half_area(&self) -> f32 {
        self.boxes.half_area(1.0)
    }
}

/// The extent of records, as a task.
struct ExtentOf<'a>(&'a [Record]);

impl Task for ExtentOf<'_> {
    type Output = Extent;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Extent {
        let mut boxes = simd.splat(f32::INFINITY);
        let (mut lower, mut upper) = (Vec4::INFINITY, Vec4::NEG_INFINITY);
        for record in self.0 {
            boxes = simd.min(boxes, simd.load(&record.0.0));
            let middle = record.0.middle();
            (lower, upper) = (lower.min(middle), upper.max(middle));
        }
        Extent { boxes: Corners(simd.to_array(boxes)), middles: Middles { lower, upper } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_keeps_its_id_beside_numbers_that_are_normal() {
        let bounds = Aabb { min: Vec3::splat(-1.0), max: Vec3::new(2.0, 3.0, f32::INFINITY) };
        for id in [0, 1, 255, (1 << 23) - 1, 1 << 23, 123_456_789, crate::MAX_PRIMITIVES as u32] {
            let record = Record::new(id, bounds);
            assert_eq!(record.id(), id);
            assert!(record.0.0.iter().all(|lane| lane.is_normal()), "{record:?}");
            assert_eq!(record.0.bounds(), Aabb { max: bounds.max.min(Vec3::MAX), ..bounds });
        }
    }

    #[test]
    fn a_box_without_inside_has_an_empty_record() {
        let nan = Aabb { min: Vec3::new(f32::NAN, 0.0, 0.0), max: Vec3::ONE };
        for bounds in [Aabb::EMPTY, nan, Aabb { min: Vec3::ZERO, max: Vec3::splat(f32::NAN) }] {
            assert!(Record::new(7, bounds).is_empty(), "{bounds:?}");
        }
    }
}
