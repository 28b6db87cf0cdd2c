//! The surface area heuristic, binned.
//!
//! The cost of a child is the probability that a ray that meets the parent's box meets the child's
//! (the ratio of their surface areas) times the number of leaves inside. The candidate planes are
//! the borders between bins of equal width along each axis, into which references are sorted by
//! their centroids.
//!
//! Sources: J. Goldsmith, J. Salmon, "Automatic creation of object hierarchies for ray tracing",
//! IEEE CG&A 1987; I. Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007.

use crate::isa::Isa;
use crate::prim_ref::{CentroidBounds, LaneBounds, PARALLEL_CHUNK, PrimRef, RangeBounds};
use crate::simd::{Simd, WithSimd};
use glam::Vec4;

/// Largest number of bins on an axis.
const MAX_BINS: usize = 32;

/// Largest number of bins for which the smaller bin arrays are used, which are cheaper to clear.
const FEW_BINS: usize = 16;

/// 2^23: the sum of it and a small number has the nearest integer in its low bits.
const ROUND_TO_INTEGER: f32 = 8_388_608.0;

/// Maps the centroid of a reference to its bin on each axis.
#[derive(Clone, Copy)]
struct BinMapping {
    start: Vec4,
    scale: Vec4,
    last: f32,
}

impl BinMapping {
    #[inline(always)]
    fn new(centroids: &CentroidBounds, bins: usize) -> Self {
        let width = 0.5 * centroids.upper - 0.5 * centroids.lower;
        // An axis without extent has one bin, and so has one so short that the scale would
        // overflow.
        let scale = Vec4::splat(0.5 * bins as f32) / width;
        let scale = Vec4::select(scale.cmplt(Vec4::INFINITY), scale, Vec4::ZERO);
        Self { start: centroids.lower, scale: scale.with_w(0.0), last: (bins - 1) as f32 }
    }

    #[inline(always)]
    fn bins(&self, prim: &PrimRef) -> [usize; 3] {
        // Without float-to-integer conversions, all axes at once. The difference is not negative.
        let position = (prim.0.centroid() - self.start) * self.scale - Vec4::splat(0.5);
        let bin =
            position.min(Vec4::splat(self.last)).max(Vec4::ZERO) + Vec4::splat(ROUND_TO_INTEGER);
        let [x, y, z, _] = bin.to_array();
        [x, y, z].map(|bin| bin.to_bits() as usize)
    }
}

/// How a range is split in two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Split {
    Plane(SplitPlane),
    /// Halves of equal count, since all centroids are equal or the tree is deep.
    Halves,
}

/// A border between bins: references in bins below `bin` go left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SplitPlane {
    axis: usize,
    start: f32,
    scale: f32,
    last: f32,
    bin: usize,
}

impl SplitPlane {
    /// Compares the bin of one axis, computed as by [`BinMapping::bins`], with the border.
    #[inline(always)]
    fn is_left(&self, prim: &PrimRef) -> bool {
        let lanes = &prim.0.0;
        let centroid = 0.5 * lanes[self.axis % 3] - 0.5 * lanes[4 + self.axis % 3];
        let position = (centroid - self.start) * self.scale - 0.5;
        let position = if position < self.last { position } else { self.last };
        let position = if position > 0.0 { position } else { 0.0 };
        position + ROUND_TO_INTEGER < ROUND_TO_INTEGER + self.bin as f32
    }
}

/// The boxes and counts of the bins of all axes.
struct Bins<const N: usize> {
    boxes: [[LaneBounds; N]; 3],
    counts: [[u32; N]; 3],
}

impl<const N: usize> Bins<N> {
    #[inline(always)]
    fn fill<S: Simd>(simd: S, prims: &[PrimRef], mapping: &BinMapping) -> Self {
        let mut bins = Self { boxes: [[LaneBounds::EMPTY; N]; 3], counts: [[0; N]; 3] };
        for prim in prims {
            let bounds = simd.load(&prim.0.0);
            for (axis, bin) in mapping.bins(prim).into_iter().enumerate() {
                let bin = bin & (N - 1);
                let grown = &mut bins.boxes[axis][bin].0;
                *grown = simd.to_array(simd.min(simd.load(grown), bounds));
                bins.counts[axis][bin] += 1;
            }
        }
        bins
    }

    fn union(mut self, other: &Self) -> Self {
        for axis in 0..3 {
            for bin in 0..N {
                let grown = &mut self.boxes[axis][bin];
                *grown = grown.union(other.boxes[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
        self
    }

    /// The border of least cost between the first `used` bins, or halves if there is none.
    #[inline(always)]
    fn best<S: Simd>(
        &self,
        simd: S,
        mapping: &BinMapping,
        used: usize,
        scale: f32,
        leaf_size: u32,
    ) -> Split {
        let empty = simd.splat(f32::INFINITY);
        let mut best = (f32::INFINITY, 0, 0);
        for axis in 0..3 {
            if mapping.scale[axis] == 0.0 {
                continue;
            }
            let (boxes, counts) = (&self.boxes[axis], &self.counts[axis]);
            let mut right_costs = [0.0; N];
            let (mut grown, mut count) = (empty, 0);
            for bin in (1..used).rev() {
                grown = simd.min(simd.load(&boxes[bin % N].0), grown);
                count += counts[bin % N];
                // A plane with an empty side does not split.
                let area = LaneBounds(simd.to_array(grown)).half_area(scale);
                right_costs[bin % N] =
                    if count == 0 { f32::INFINITY } else { area * leaf_count(count, leaf_size) };
            }
            let (mut grown, mut count) = (empty, 0);
            for bin in 1..used {
                grown = simd.min(simd.load(&boxes[(bin - 1) % N].0), grown);
                count += counts[(bin - 1) % N];
                let area = LaneBounds(simd.to_array(grown)).half_area(scale);
                let cost = area * leaf_count(count, leaf_size) + right_costs[bin % N];
                if count > 0 && cost < best.0 {
                    best = (cost, axis, bin);
                }
            }
        }
        let (cost, axis, bin) = best;
        if cost == f32::INFINITY {
            return Split::Halves;
        }
        let (start, scale) = (mapping.start[axis], mapping.scale[axis]);
        Split::Plane(SplitPlane { axis, start, scale, last: mapping.last, bin })
    }
}

/// The least number of leaves for `count` references. A leaf is tested as a whole, however few it
/// holds.
#[inline(always)]
fn leaf_count(count: u32, leaf_size: u32) -> f32 {
    count.div_ceil(leaf_size) as f32
}

/// The split of least cost of `prims`, which are at least two.
pub(crate) fn find_split(
    prims: &[PrimRef],
    bounds: &RangeBounds,
    leaf_size: u32,
    isa: Isa,
) -> Split {
    // Many bins even for short ranges, so that a plane can leave full leaves on both sides.
    let used = (8 + prims.len() / 16).min(MAX_BINS);
    let mapping = &BinMapping::new(&bounds.centroids, used);
    let scale = area_scale(bounds);
    if prims.len() > PARALLEL_CHUNK {
        use rayon::prelude::*;
        // Unions and sums do not depend on their order, so neither does the tree.
        let bins = prims
            .par_chunks(PARALLEL_CHUNK)
            .map(|prims| isa.run(FillBins { prims, mapping }))
            .reduce_with(|a, b| a.union(&b))
            .expect("the range is not empty");
        return isa.run(BestSplit { bins: &bins, mapping, used, scale, leaf_size });
    }
    if used <= FEW_BINS {
        isa.run(FindSplit::<FEW_BINS> { prims, mapping, used, scale, leaf_size })
    } else {
        isa.run(FindSplit::<MAX_BINS> { prims, mapping, used, scale, leaf_size })
    }
}

struct FillBins<'a> {
    prims: &'a [PrimRef],
    mapping: &'a BinMapping,
}

impl WithSimd for FillBins<'_> {
    type Output = Bins<MAX_BINS>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Bins<MAX_BINS> {
        Bins::fill(simd, self.prims, self.mapping)
    }
}

struct BestSplit<'a> {
    bins: &'a Bins<MAX_BINS>,
    mapping: &'a BinMapping,
    used: usize,
    scale: f32,
    leaf_size: u32,
}

impl WithSimd for BestSplit<'_> {
    type Output = Split;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Split {
        self.bins.best(simd, self.mapping, self.used, self.scale, self.leaf_size)
    }
}

/// [`FillBins`] and [`BestSplit`] in one, for a range of one chunk.
struct FindSplit<'a, const N: usize> {
    prims: &'a [PrimRef],
    mapping: &'a BinMapping,
    used: usize,
    scale: f32,
    leaf_size: u32,
}

impl<const N: usize> WithSimd for FindSplit<'_, N> {
    type Output = Split;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Split {
        let bins = Bins::<N>::fill(simd, self.prims, self.mapping);
        bins.best(simd, self.mapping, self.used, self.scale, self.leaf_size)
    }
}

/// The scale that brings the longest half side of the bounds to one.
pub(crate) fn area_scale(bounds: &RangeBounds) -> f32 {
    let scale = bounds.boxes.half_size().truncate().max_element().recip();
    if scale.is_finite() { scale } else { 1.0 }
}

/// Splits `prims` in place, and returns the number of references on the left and the bounds of both
/// sides.
pub(crate) fn partition(
    prims: &mut [PrimRef],
    split: Split,
    isa: Isa,
) -> (usize, RangeBounds, RangeBounds) {
    let count = match split {
        Split::Plane(plane) => partition_by_plane(prims, &plane),
        Split::Halves => prims.len() / 2,
    };
    let (left, right) = prims.split_at(count);
    (count, RangeBounds::of(left, isa), RangeBounds::of(right, isa))
}

/// Moves the references on the left of the plane to the front, and returns their number.
fn partition_by_plane(prims: &mut [PrimRef], plane: &SplitPlane) -> usize {
    if prims.len() <= PARALLEL_CHUNK {
        // Branch-free: the side is unpredictable.
        let mut count = 0;
        for index in 0..prims.len() {
            let left = plane.is_left(&prims[index]);
            prims.swap(index, count);
            count += usize::from(left);
        }
        return count;
    }
    // Partition the halves in parallel, then swap the right part of the first half with as many
    // references of the left part of the second.
    let middle = prims.len() / 2;
    let (low, high) = prims.split_at_mut(middle);
    let (first, second) =
        rayon::join(|| partition_by_plane(low, plane), || partition_by_plane(high, plane));
    let swapped = (middle - first).min(second);
    low[first..first + swapped].swap_with_slice(&mut high[second - swapped..second]);
    first + second
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_random::Random;
    use glam::Vec3;
    use rotund_geometry::Aabb;

    #[test]
    fn every_instruction_set_splits_at_the_same_place() {
        let mut random = Random(1);
        let mut number = || random.unit();
        for count in [2, 9, 50, 99, 100, 1000, PARALLEL_CHUNK + 1000] {
            let prims: Vec<PrimRef> = (0..count as u32)
                .map(|id| {
                    let min = Vec3::new(number(), 3.0 * number(), number() * number());
                    PrimRef::new(id, Aabb { min, max: min + 0.1 * Vec3::splat(number()) })
                })
                .collect();
            let split_by = |isa: Isa| {
                let mut prims = prims.clone();
                let bounds = RangeBounds::of(&prims, isa);
                let split = find_split(&prims, &bounds, 8, isa);
                let (count, left, right) = partition(&mut prims, split, isa);
                let ids: Vec<u32> = prims.iter().map(PrimRef::id).collect();
                let centroids = [left, right].map(|side| side.centroids.lower.truncate());
                (split, count, left.to_aabb(), right.to_aabb(), centroids, ids)
            };
            let expected = split_by(Isa::PORTABLE);
            assert!(matches!(expected.0, Split::Plane(_)), "{count}: {:?}", expected.0);
            for isa in Isa::available() {
                assert_eq!(split_by(isa), expected, "{count} by {isa:?}");
            }
        }
    }
}
