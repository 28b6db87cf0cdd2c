//! Wide nodes, and the laws they keep.

use rotund_geometry::Aabb;

/// Children of a node: one SIMD register of `f32` under AVX, two under SSE2 or NEON.
pub(crate) const WIDTH: usize = 8;

/// What a slot of a node leads to: another node, a leaf, or nothing.
///
/// The top bit tells a leaf from a node; the rest is the index of the node, or what the owner of
/// the tree made of the leaf's number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct Child(pub(crate) u32);

impl Child {
    const LEAF: u32 = 1 << 31;
    /// The largest index of a node or leaf. One below the end, so that no leaf looks like
    /// [`Child::NONE`].
    pub(crate) const MAX_INDEX: u32 = Self::LEAF - 2;
    /// An unused slot. Its box is empty, so no ray gets here.
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

/// A node with up to [`WIDTH`] children, their boxes as six arrays of planes.
///
/// Four cache lines. `planes[axis]` are the lower planes of an axis and the upper ones, so that a ray
/// chooses its near and far planes by an index and not by a comparison.
///
/// Laws: no plane is NaN; used slots come first; an unused slot holds [`Child::NONE`] and an
/// empty box (`+inf..=-inf`); the box of a slot holds all boxes below it.
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

/// The nodes of a tree and where to start.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    pub(crate) nodes: Vec<Node>,
    /// A node, or [`Child::NONE`] if there is nothing in the tree.
    pub(crate) root: Child,
    /// The union of all boxes; [`Aabb::EMPTY`] if there is none.
    pub(crate) bounds: Aabb,
    /// Length of the slice that the tree was built from.
    pub(crate) source_count: usize,
    /// How many of its elements are in the tree; the others are empty.
    pub(crate) kept_count: usize,
}
