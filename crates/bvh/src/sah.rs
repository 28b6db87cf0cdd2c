//! The surface area heuristic, binned.
//!
//! The cost of a subtree is the chance that a ray which meets the parent's box meets the child's
//! (the ratio of their surface areas) times the leaves inside. Candidates are the borders between
//! bins of equal width along each axis.
//!
//! Sources: J. Goldsmith, J. Salmon, "Automatic creation of object hierarchies for ray tracing",
//! IEEE CG&A 1987; I. Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007.

use crate::isa::Isa;
use crate::record::{Corners, Extent, Middles, PIECE, Record};
use crate::simd::{Simd, Task};
use glam::Vec4;

const MAX_BINS: usize = 32;

/// Short ranges have at most this many, and pay for no more.
const FEW_BINS: usize = 16;

/// 2^23: adding it to a small number leaves the nearest integer in the low bits.
const NEAREST: f32 = 8_388_608.0;

/// Maps the middle of a record to its bin on each axis.
#[derive(Clone, Copy)]
struct Mapping {
    start: Vec4,
    scale: Vec4,
    last: f32,
}

impl Mapping {
    #[inline(always)]
    fn new(middles: &Middles, bins: usize) -> Self {
        let width = 0.5 * middles.upper - 0.5 * middles.lower;
        // A flat axis has one bin. So has one so thin that the scale would overflow.
        let scale = Vec4::splat(0.5 * bins as f32) / width;
        let scale = Vec4::select(scale.cmplt(Vec4::INFINITY), scale, Vec4::ZERO);
        Self { start: middles.lower, scale: scale.with_w(0.0), last: (bins - 1) as f32 }
    }

    #[inline(always)]
    fn bins(&self, record: &Record) -> [usize; 3] {
        // No conversion, and all axes at once. The difference is not negative.
        let position = (record.0.middle() - self.start) * self.scale - Vec4::splat(0.5);
        let bin = position.min(Vec4::splat(self.last)).max(Vec4::ZERO) + Vec4::splat(NEAREST);
        let [x, y, z, _] = bin.to_array();
        [x, y, z].map(|bin| bin.to_bits() as usize)
    }
}

/// Where a range is cut in two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Split {
    Plane(Plane),
    /// The records have all the same middle: half of them go left.
    Middle,
}

/// Records in bins below `bin` go left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plane {
    axis: usize,
    start: f32,
    scale: f32,
    last: f32,
    bin: usize,
}

impl Plane {
    /// [`Mapping::bins`] of one axis.
    #[inline(always)]
    fn is_left(&self, record: &Record) -> bool {
        let corners = &record.0.0;
        let middle = 0.5 * corners[self.axis % 3] - 0.5 * corners[4 + self.axis % 3];
        let position = (middle - self.start) * self.scale - 0.5;
        let position = if position < self.last { position } else { self.last };
        let position = if position > 0.0 { position } else { 0.0 };
        position + NEAREST < NEAREST + self.bin as f32
    }
}

/// The boxes and counts of the bins of all axes.
struct Bins<const N: usize> {
    boxes: [[Corners; N]; 3],
    counts: [[u32; N]; 3],
}

impl<const N: usize> Bins<N> {
    #[inline(always)]
    fn fill<S: Simd>(simd: S, records: &[Record], mapping: &Mapping) -> Self {
        let mut bins = Self { boxes: [[Corners::EMPTY; N]; 3], counts: [[0; N]; 3] };
        for record in records {
            let boxed = simd.load(&record.0.0);
            for (axis, bin) in mapping.bins(record).into_iter().enumerate() {
                let bin = bin & (N - 1);
                let grown = &mut bins.boxes[axis][bin].0;
                *grown = simd.to_array(simd.min(simd.load(grown), boxed));
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

    /// The best border between the first `used` bins.
    #[inline(always)]
    fn best<S: Simd>(
        &self,
        simd: S,
        mapping: &Mapping,
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
                // An empty side is no cut.
                let area = Corners(simd.to_array(grown)).half_area(scale);
                right_costs[bin % N] =
                    if count == 0 { f32::INFINITY } else { area * leaves(count, leaf_size) };
            }
            let (mut grown, mut count) = (empty, 0);
            for bin in 1..used {
                grown = simd.min(simd.load(&boxes[(bin - 1) % N].0), grown);
                count += counts[(bin - 1) % N];
                let area = Corners(simd.to_array(grown)).half_area(scale);
                let cost = area * leaves(count, leaf_size) + right_costs[bin % N];
                if count > 0 && cost < best.0 {
                    best = (cost, axis, bin);
                }
            }
        }
        let (cost, axis, bin) = best;
        if cost == f32::INFINITY {
            return Split::Middle;
        }
        let (start, scale) = (mapping.start[axis], mapping.scale[axis]);
        Split::Plane(Plane { axis, start, scale, last: mapping.last, bin })
    }
}

/// What is tested where a side of a cut is met: whole leaves, however few there are in one.
#[inline(always)]
fn leaves(count: u32, leaf_size: u32) -> f32 {
    count.div_ceil(leaf_size) as f32
}

/// The best place to cut `records`, which are at least two.
pub(crate) fn find_split(records: &[Record], extent: &Extent, leaf_size: u32, isa: Isa) -> Split {
    // Many, also for short ranges: there they let a cut leave full leaves on both sides.
    let used = (8 + records.len() / 16).min(MAX_BINS);
    let mapping = &Mapping::new(&extent.middles, used);
    let scale = unit_scale(extent);
    if records.len() > PIECE {
        use rayon::prelude::*;
        // Unions and sums do not depend on their order, so neither does the tree.
        let bins = records
            .par_chunks(PIECE)
            .map(|records| isa.run(Fill { records, mapping }))
            .reduce_with(|a, b| a.union(&b))
            .expect("there are records");
        return isa.run(Best { bins: &bins, mapping, used, scale, leaf_size });
    }
    if used <= FEW_BINS {
        isa.run(FindSplit::<FEW_BINS> { records, mapping, used, scale, leaf_size })
    } else {
        isa.run(FindSplit::<MAX_BINS> { records, mapping, used, scale, leaf_size })
    }
}

struct Fill<'a> {
    records: &'a [Record],
    mapping: &'a Mapping,
}

impl Task for Fill<'_> {
    type Output = Bins<MAX_BINS>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Bins<MAX_BINS> {
        Bins::fill(simd, self.records, self.mapping)
    }
}

struct Best<'a> {
    bins: &'a Bins<MAX_BINS>,
    mapping: &'a Mapping,
    used: usize,
    scale: f32,
    leaf_size: u32,
}

impl Task for Best<'_> {
    type Output = Split;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Split {
        self.bins.best(simd, self.mapping, self.used, self.scale, self.leaf_size)
    }
}

/// Both for a range of one piece.
struct FindSplit<'a, const N: usize> {
    records: &'a [Record],
    mapping: &'a Mapping,
    used: usize,
    scale: f32,
    leaf_size: u32,
}

impl<const N: usize> Task for FindSplit<'_, N> {
    type Output = Split;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Split {
        let bins = Bins::<N>::fill(simd, self.records, self.mapping);
        bins.best(simd, self.mapping, self.used, self.scale, self.leaf_size)
    }
}

/// Brings the widest half side of the extent to one.
pub(crate) fn unit_scale(extent: &Extent) -> f32 {
    let scale = extent.boxes.half_size().truncate().max_element().recip();
    if scale.is_finite() { scale } else { 1.0 }
}

/// Cuts `records` in two, in place, and returns how many went left and the extents of both sides.
pub(crate) fn partition(records: &mut [Record], split: Split, isa: Isa) -> (usize, Extent, Extent) {
    let count = match split {
        Split::Plane(plane) => move_left(records, &plane),
        Split::Middle => records.len() / 2,
    };
    let (left, right) = records.split_at(count);
    (count, Extent::of(left, isa), Extent::of(right, isa))
}

/// Moves the records on the left to the front, and returns how many they are.
fn move_left(records: &mut [Record], plane: &Plane) -> usize {
    if records.len() <= PIECE {
        // No branch depends on the side, which could be predicted only half of the time.
        let mut count = 0;
        for index in 0..records.len() {
            let left = plane.is_left(&records[index]);
            records.swap(index, count);
            count += usize::from(left);
        }
        return count;
    }
    // Halves are moved in parallel; then what is right in the first changes places with as much of what is
    // left in the second.
    let middle = records.len() / 2;
    let (low, high) = records.split_at_mut(middle);
    let (first, second) = rayon::join(|| move_left(low, plane), || move_left(high, plane));
    let swapped = (middle - first).min(second);
    low[first..first + swapped].swap_with_slice(&mut high[second - swapped..second]);
    first + second
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use rotund_geometry::Aabb;

    #[test]
    fn every_instruction_set_cuts_at_the_same_place() {
        let mut state = 1_u32;
        let mut number = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 * 2f32.powi(-24)
        };
        for count in [2, 9, 50, 99, 100, 1000, PIECE + 1000] {
            let records: Vec<Record> = (0..count as u32)
                .map(|id| {
                    let min = Vec3::new(number(), 3.0 * number(), number() * number());
                    Record::new(id, Aabb { min, max: min + 0.1 * Vec3::splat(number()) })
                })
                .collect();
            let cut = |isa: Isa| {
                let mut records = records.clone();
                let extent = Extent::of(&records, isa);
                let split = find_split(&records, &extent, 8, isa);
                let (count, left, right) = partition(&mut records, split, isa);
                let ids: Vec<u32> = records.iter().map(Record::id).collect();
                let middles = [left, right].map(|part| part.middles.lower.truncate());
                (split, count, left.bounds(), right.bounds(), middles, ids)
            };
            let expected = cut(Isa::PORTABLE);
            assert!(matches!(expected.0, Split::Plane(_)), "{count}: {:?}", expected.0);
            for isa in Isa::available() {
                assert_eq!(cut(isa), expected, "{count} by {isa:?}");
            }
        }
    }
}
