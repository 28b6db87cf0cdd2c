//! A range of primitive references during a build, and the subtree that is built from one.

use crate::isa::Isa;
use crate::node::{Child, Node};
use crate::prim_ref::{PrimRef, RangeBounds};
use crate::sah::{Split, find_split, partition};
use std::ops::Range;

/// Ranges that result from up to this many splits are split by the surface area heuristic. Deeper
/// ranges are halved, which bounds the depth of a tree over adversarial boxes by [`MAX_DEPTH`].
const SAH_DEPTH: usize = 64;

/// Upper bound on the nodes above a leaf: 2^31 references are halved less than 32 times.
pub(crate) const MAX_DEPTH: usize = SAH_DEPTH + 32;

/// Parameters of a build.
pub(crate) struct BuildSettings {
    /// Largest number of references in a leaf.
    pub(crate) leaf_size: usize,
    /// Half the surface area above which a range that fits into one leaf may be divided among
    /// several.
    pub(crate) large_area: f32,
    /// Instruction set of the build. The tree does not depend on it, only the time.
    pub(crate) isa: Isa,
}

/// A range of primitive references.
pub(crate) struct BuildRange<'a> {
    pub(crate) prims: &'a mut [PrimRef],
    /// Index of the first reference among all of the build.
    pub(crate) start: usize,
    pub(crate) bounds: RangeBounds,
    /// Number of splits that led to this range.
    pub(crate) depth: usize,
}

impl BuildRange<'_> {
    /// Splits the range in two, reordering its references.
    pub(crate) fn split(self, settings: &BuildSettings) -> [Self; 2] {
        let BuildRange { prims, start, bounds, depth } = self;
        let split = if depth < SAH_DEPTH {
            find_split(prims, &bounds, settings.leaf_size as u32, settings.isa)
        } else {
            Split::Halves
        };
        let (count, left, right) = partition(prims, split, settings.isa);
        let (low, high) = prims.split_at_mut(count);
        let depth = depth + 1;
        [
            BuildRange { prims: low, start, bounds: left, depth },
            BuildRange { prims: high, start: start + count, bounds: right, depth },
        ]
    }
}

/// A finished subtree, whose node and leaf indices start at zero.
pub(crate) struct Subtree {
    pub(crate) nodes: Vec<Node>,
    /// The range of references of each leaf.
    pub(crate) leaves: Vec<Range<u32>>,
    pub(crate) root: Child,
}
