//! The surface area heuristic, binned.
//!
//! The cost of a subtree is the chance that a ray which meets the parent's box meets the child's
//! (the ratio of their surface areas) times what is inside. Candidates are the borders between
//! bins of equal width along each axis.
//!
//! Sources: J. Goldsmith, J. Salmon, "Automatic creation of object hierarchies for ray tracing",
//! IEEE CG&A 1987; I. Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007.

use glam::Vec4;
use rotund_geometry::Aabb;

/// A box and the id of what it bounds. The fourth lane of `lower` carries the id's bits, so that a
/// record is two SIMD registers; no arithmetic looks at it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Record {
    lower: Vec4,
    upper: Vec4,
}

impl Record {
    /// Returns `None` for a box that is empty or has a NaN.
    ///
    /// An infinite side is drawn in to the largest number: no hit lies beyond it, and sums and
    /// differences of halves stay finite.
    pub(crate) fn new(id: u32, bounds: Aabb) -> Option<Self> {
        if bounds.is_empty() {
            return None;
        }
        let (lower, upper) = (bounds.min.max(glam::Vec3::MIN), bounds.max.min(glam::Vec3::MAX));
        (lower.cmple(upper).all())
            .then(|| Self { lower: lower.extend(f32::from_bits(id)), upper: upper.extend(0.0) })
    }

    #[inline]
    pub(crate) fn id(&self) -> u32 {
        self.lower.w.to_bits()
    }

    /// Twice the distance of the middle from `zero`, halved: the middle without overflow.
    #[inline(always)]
    fn middle(&self) -> Vec4 {
        0.5 * self.lower + 0.5 * self.upper
    }
}

/// A box being grown. The fourth lane is of no meaning.
#[derive(Clone, Copy, Debug)]
struct Growing {
    lower: Vec4,
    upper: Vec4,
}

impl Growing {
    const EMPTY: Self =
        Self { lower: Vec4::splat(f32::INFINITY), upper: Vec4::splat(f32::NEG_INFINITY) };

    #[inline(always)]
    fn union(self, other: Self) -> Self {
        Self { lower: self.lower.min(other.lower), upper: self.upper.max(other.upper) }
    }

    #[inline(always)]
    fn half_area(self, scale: f32) -> f32 {
        // Halves first: the whole width of a huge box would overflow. The scale brings the widest
        // side of the node to one, so that products neither overflow nor vanish.
        let size = ((0.5 * self.upper - 0.5 * self.lower) * scale).max(Vec4::ZERO);
        size.x * size.y + size.y * size.z + size.z * size.x
    }
}

/// The boxes of a range of records: of the boxes themselves, and of their middles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    boxes: Growing,
    middles: Growing,
}

impl Extent {
    pub(crate) const EMPTY: Self = Self { boxes: Growing::EMPTY, middles: Growing::EMPTY };

    pub(crate) fn of(records: &[Record]) -> Self {
        records.iter().fold(Self::EMPTY, Self::with)
    }

    /// The same, in parallel if they are many.
    pub(crate) fn of_many(records: &[Record]) -> Self {
        if records.len() <= PIECE {
            return Self::of(records);
        }
        let (low, high) = records.split_at(records.len() / 2);
        let (low, high) = rayon::join(|| Self::of_many(low), || Self::of_many(high));
        low.union(high)
    }

    #[inline(always)]
    fn with(self, record: &Record) -> Self {
        let (boxed, middle) =
            (Growing { lower: record.lower, upper: record.upper }, record.middle());
        Self {
            boxes: self.boxes.union(boxed),
            middles: self.middles.union(Growing { lower: middle, upper: middle }),
        }
    }

    pub(crate) fn union(self, other: Self) -> Self {
        Self { boxes: self.boxes.union(other.boxes), middles: self.middles.union(other.middles) }
    }

    pub(crate) fn bounds(&self) -> Aabb {
        Aabb { min: self.boxes.lower.truncate(), max: self.boxes.upper.truncate() }
    }

    /// Half of the surface area; infinite for boxes wider than the square root of the largest
    /// number, which is good enough to order siblings.
    pub(crate) fn half_area(&self) -> f32 {
        self.boxes.half_area(1.0)
    }
}

/// The relative costs that the heuristic weighs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Costs {
    /// Testing one block of primitives, in units of stepping through half a node.
    pub(crate) block: f32,
    /// Primitives that are tested at once. The count of a side is rounded up to whole blocks.
    pub(crate) block_size: u32,
    /// A leaf never holds more than this.
    pub(crate) leaf_size: u32,
}

impl Costs {
    #[inline(always)]
    fn of(&self, count: u32) -> f32 {
        self.block * count.div_ceil(self.block_size) as f32
    }
}

const MAX_BINS: usize = 32;

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
    fn new(middles: &Growing, bins: usize) -> Self {
        let width = 0.5 * middles.upper - 0.5 * middles.lower;
        // A flat axis has one bin. So has one so thin that the scale would overflow.
        let scale = width.to_array().map(|width| {
            let scale = 0.5 * bins as f32 / width;
            if scale.is_finite() { scale } else { 0.0 }
        });
        Self { start: middles.lower, scale: scale.into(), last: (bins - 1) as f32 }
    }

    #[inline(always)]
    fn bins(&self, record: &Record) -> [usize; 3] {
        // No conversion, and all axes at once.
        // The difference is not negative, and the clamp drops a NaN that only lane 3 could have.
        let position = (record.middle() - self.start) * self.scale - Vec4::splat(0.5);
        let bin = position.min(Vec4::splat(self.last)).max(Vec4::ZERO) + Vec4::splat(NEAREST);
        let [x, y, z, _] = bin.to_array();
        [x, y, z].map(|bin| (bin.to_bits() as usize) & (MAX_BINS - 1))
    }
}

/// Where a range is cut in two.
#[derive(Clone, Copy)]
pub(crate) enum Split {
    /// Records in bins below `bin` go left.
    Plane { mapping: PlaneMapping, axis: usize, bin: usize },
    /// The records have all the same middle: half of them go left.
    Middle,
}

/// The mapping a plane was found with.
#[derive(Clone, Copy)]
pub(crate) struct PlaneMapping(Mapping);

/// The boxes and counts of the bins of all axes.
struct Bins {
    boxes: [[Growing; MAX_BINS]; 3],
    counts: [[u32; MAX_BINS]; 3],
}

impl Bins {
    fn fill(records: &[Record], mapping: Mapping, used: usize) -> Self {
        let mut bins = Self { boxes: [[Growing::EMPTY; MAX_BINS]; 3], counts: [[0; MAX_BINS]; 3] };
        debug_assert!(used <= MAX_BINS, "{used} bins");
        for record in records {
            let boxed = Growing { lower: record.lower, upper: record.upper };
            let at = mapping.bins(record);
            for (axis, bin) in at.into_iter().enumerate() {
                bins.boxes[axis][bin] = bins.boxes[axis][bin].union(boxed);
                bins.counts[axis][bin] += 1;
            }
        }
        bins
    }

    fn union(mut self, other: &Self, used: usize) -> Self {
        for axis in 0..3 {
            for bin in 0..used {
                self.boxes[axis][bin] = self.boxes[axis][bin].union(other.boxes[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
        self
    }
}

/// Ranges longer than this are binned in parallel, in pieces of this length.
const PIECE: usize = 1 << 16;

/// The best place to cut `records`, which are at least two, and the cost of both sides together,
/// relative to the half area `scale`d as by [`unit_scale`].
pub(crate) fn find_split(records: &[Record], extent: &Extent, costs: &Costs) -> Split {
    let used = (4 + records.len() / 20).min(MAX_BINS);
    let mapping = Mapping::new(&extent.middles, used);
    let bins = if records.len() <= PIECE {
        Bins::fill(records, mapping, used)
    } else {
        use rayon::prelude::*;
        // Unions and sums do not depend on their order, so neither does the tree.
        records
            .par_chunks(PIECE)
            .map(|piece| Bins::fill(piece, mapping, used))
            .reduce_with(|a, b| a.union(&b, used))
            .expect("there are records")
    };

    let scale = unit_scale(extent);
    let mut best = (f32::INFINITY, Split::Middle);
    for axis in 0..3 {
        if mapping.scale[axis] == 0.0 {
            continue;
        }
        let (boxes, counts) = (&bins.boxes[axis], &bins.counts[axis]);
        let mut right_costs = [0.0; MAX_BINS];
        let (mut grown, mut count) = (Growing::EMPTY, 0);
        for bin in (1..used).rev() {
            grown = grown.union(boxes[bin]);
            count += counts[bin];
            // An empty side is no cut.
            right_costs[bin] =
                if count == 0 { f32::INFINITY } else { grown.half_area(scale) * costs.of(count) };
        }
        let (mut grown, mut count) = (Growing::EMPTY, 0);
        for bin in 1..used {
            grown = grown.union(boxes[bin - 1]);
            count += counts[bin - 1];
            let cost = grown.half_area(scale) * costs.of(count) + right_costs[bin];
            if count > 0 && cost < best.0 {
                best = (cost, Split::Plane { mapping: PlaneMapping(mapping), axis, bin });
            }
        }
    }
    best.1
}

/// Brings the widest half side of the extent to one.
fn unit_scale(extent: &Extent) -> f32 {
    let half = (0.5 * extent.boxes.upper - 0.5 * extent.boxes.lower).truncate();
    let scale = half.max_element().recip();
    if scale.is_finite() { scale } else { 1.0 }
}

/// Cuts `records` in two, in place, and returns how many went left and the extents of both sides.
pub(crate) fn partition(records: &mut [Record], split: Split) -> (usize, Extent, Extent) {
    let count = match split {
        Split::Plane { mapping: PlaneMapping(mapping), axis, bin } => {
            move_left(records, &Side::new(&mapping, axis, bin))
        }
        Split::Middle => records.len() / 2,
    };
    let (left, right) = records.split_at(count);
    (count, Extent::of_many(left), Extent::of_many(right))
}

/// Which records are left of a plane: [`Mapping::bins`] of one axis.
struct Side {
    axis: usize,
    start: f32,
    scale: f32,
    last: f32,
    bin: f32,
}

impl Side {
    fn new(mapping: &Mapping, axis: usize, bin: usize) -> Self {
        let (start, scale) = (mapping.start[axis], mapping.scale[axis]);
        Self { axis, start, scale, last: mapping.last, bin: NEAREST + bin as f32 }
    }

    #[inline(always)]
    fn is_left(&self, record: &Record) -> bool {
        let middle = 0.5 * record.lower[self.axis] + 0.5 * record.upper[self.axis];
        let position = (middle - self.start) * self.scale - 0.5;
        let position = if position < self.last { position } else { self.last };
        let position = if position > 0.0 { position } else { 0.0 };
        position + NEAREST < self.bin
    }
}

/// Moves the records on the left to the front, and returns how many they are.
fn move_left(records: &mut [Record], side: &Side) -> usize {
    if records.len() <= PIECE {
        // No branch depends on the side, which could be predicted only half of the time.
        let mut count = 0;
        for index in 0..records.len() {
            let left = side.is_left(&records[index]);
            records.swap(index, count);
            count += usize::from(left);
        }
        return count;
    }
    // Halves are moved in parallel; then what is right in the first changes places with as much of what is
    // left in the second.
    let middle = records.len() / 2;
    let (low, high) = records.split_at_mut(middle);
    let (first, second) = rayon::join(|| move_left(low, side), || move_left(high, side));
    let swapped = (middle - first).min(second);
    low[first..first + swapped].swap_with_slice(&mut high[second - swapped..second]);
    first + second
}
