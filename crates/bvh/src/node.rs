//! Wide nodes and their invariants.

use rotund_geometry::Aabb;

/// Children of a node: one SIMD register of `f32` with AVX, two with SSE2 or NEON.
pub(crate) const WIDTH: usize = 8;

/// The content of a slot of a node: another node, a leaf, or nothing.
///
/// The top bit is set for leaves. The other bits are the index of the node or leaf; in a
/// [`crate::Bvh`] the index of a leaf is the id of its primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct Child(pub(crate) u32);

impl Child {
    const LEAF: u32 = 1 << 31;
    /// The largest index of a node or leaf. The next one is not used, since it would make a leaf
    /// equal to [`Child::NONE`].
    pub(crate) const MAX_INDEX: u32 = Self::LEAF - 2;
    /// An unused slot. Its box is empty, so no ray visits it.
    pub(crate) const NONE: Self = Self(u32::MAX);

    pub(crate) fn node(index: u32) -> Self {
        debug_assert!(index <= Self::MAX_INDEX, "node index {index} has 31 bits");
        Self(index)
    }

    pub(crate) fn leaf(index: u32) -> Self {
        debug_assert!(index <= Self::MAX_INDEX, "leaf index {index} has 31 bits");
        Self(Self::LEAF | index)
    }

    #[inline(always)]
    pub(crate) fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    #[inline(always)]
    pub(crate) fn index(self) -> usize {
        (self.0 & !Self::LEAF) as usize
    }
}

/// A node with up to [`WIDTH`] children. Their boxes are stored as six arrays of planes, in four
/// cache lines.
///
/// `planes[axis]` holds the lower and then the upper planes of an axis, so that a ray selects its
/// near and far planes by an index instead of a comparison.
///
/// Invariants: no plane is NaN; used slots come first; an unused slot holds [`Child::NONE`] and an
/// empty box (`+inf..=-inf`); the box of a slot contains all boxes below it; a child node comes
/// after its parent.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Node {
    pub(crate) planes: [[[f32; WIDTH]; 2]; 3],
    pub(crate) children: [Child; WIDTH],
}

impl Node {
    pub(crate) const EMPTY: Self = Self {
        planes: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3],
        children: [Child::NONE; WIDTH],
    };

    pub(crate) fn set(&mut self, slot: usize, bounds: Aabb, child: Child) {
        for axis in 0..3 {
            self.planes[axis][0][slot] = bounds.min[axis];
            self.planes[axis][1][slot] = bounds.max[axis];
        }
        self.children[slot] = child;
    }

    pub(crate) fn bounds(&self, slot: usize) -> Aabb {
        let corner = |side: usize| self.planes.map(|axis| axis[side][slot]).into();
        Aabb { min: corner(0), max: corner(1) }
    }
}

/// The largest coordinate of boxes and of origins of rays for which no product in `f32` overflows.
///
/// The largest terms are the volumes of triangles in the wide tests of leaves: with coordinates of
/// up to `R`, those relative to the origin are below `2 R`, sheared ones below `4 R`, areas below
/// `32 R²`, and volumes below `384 R³`, or `2^122.6` for this `R`.
pub(crate) const RANGE: f32 = (1_u64 << 38) as f32;

/// Returns the [`Tree::range`] of boxes in these bounds.
pub(crate) fn range_of(bounds: Aabb) -> f32 {
    let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
    if bounds.is_empty() || farthest <= RANGE { RANGE } else { -1.0 }
}

/// The nodes of a tree and its root.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    pub(crate) nodes: Vec<Node>,
    /// A node, or [`Child::NONE`] if the tree is empty.
    pub(crate) root: Child,
    /// The union of all boxes; [`Aabb::EMPTY`] if the tree is empty.
    pub(crate) bounds: Aabb,
    /// The largest coordinate of the origin of a ray for which `f32` suffices: [`RANGE`], or a
    /// negative number if the boxes reach farther.
    pub(crate) range: f32,
    /// Length of the slice that the tree was built from.
    pub(crate) source_count: usize,
    /// How many of its elements are in the tree; the others are empty.
    pub(crate) kept_count: usize,
}

impl Tree {
    pub(crate) fn left_out(&self) -> usize {
        self.source_count - self.kept_count
    }
}
