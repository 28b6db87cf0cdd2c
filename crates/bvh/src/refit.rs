//! Refitting: the boxes of a tree follow primitives that moved, and its topology stays.

use crate::node::{Child, Tree, WIDTH, range_of};
use rotund_geometry::Aabb;
use std::fmt;

/// Why a tree cannot be refitted. The tree is as it was before the call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RefitError {
    /// The slice does not have as many elements as the one that the tree was built from.
    Count {
        /// Elements of the slice that the tree was built from.
        built: usize,
        /// Elements of the slice given to `refit`.
        given: usize,
    },
    /// An element of the tree cannot be hit any more: its box is empty or has a NaN, or the
    /// primitive has a number that is not finite, or no extent. The first such element is named.
    BecameEmpty {
        /// Index of the element.
        index: usize,
    },
    /// An element that was left out of the tree, because it could not be hit when the tree was
    /// built, can be hit now. The first such element is named.
    NoLongerEmpty {
        /// Index of the element.
        index: usize,
    },
}

impl fmt::Display for RefitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { built, given } => {
                write!(
                    f,
                    "the tree was built from {built} elements and cannot be refitted to {given}"
                )
            }
            Self::BecameEmpty { index } => write!(
                f,
                "element {index} is empty or not finite now, and was not when the tree was built: \
                 build a new tree"
            ),
            Self::NoLongerEmpty { index } => write!(
                f,
                "element {index} was empty or not finite when the tree was built, and is not any \
                 more: build a new tree"
            ),
        }
    }
}

impl std::error::Error for RefitError {}

impl Tree {
    /// Compares the elements of a refit with those that the tree was built from: their number, and
    /// which of them are empty. `ids` are those in the tree; `any_empty` tells, perhaps in
    /// parallel, if one of them is empty now.
    pub(crate) fn check_refit(
        &self,
        given: usize,
        any_empty: impl FnOnce() -> bool,
        ids: impl Iterator<Item = u32>,
        is_empty: impl Fn(u32) -> bool,
    ) -> Result<(), RefitError> {
        let built = self.source_count;
        if given != built {
            return Err(RefitError::Count { built, given });
        }
        if self.kept_count == built && !any_empty() {
            return Ok(());
        }
        let mut in_tree = vec![false; built];
        ids.for_each(|id| in_tree[id as usize] = true);
        for (index, in_tree) in in_tree.into_iter().enumerate() {
            match (in_tree, is_empty(index as u32)) {
                (true, true) => return Err(RefitError::BecameEmpty { index }),
                (false, false) => return Err(RefitError::NoLongerEmpty { index }),
                _ => {}
            }
        }
        Ok(())
    }

    /// Recomputes the boxes of all nodes, bottom-up, from those of the leaves.
    pub(crate) fn refit(&mut self, leaf_bounds: impl Fn(usize) -> Aabb) {
        // A child is stored behind its parent, also where the top of the tree is joined to
        // subtrees, so a reverse pass meets children first.
        let mut node_bounds = vec![Aabb::EMPTY; self.nodes.len()];
        for index in (0..self.nodes.len()).rev() {
            let node = &mut self.nodes[index];
            for slot in 0..WIDTH {
                let child = node.children[slot];
                if child == Child::NONE {
                    break;
                }
                let bounds = if child.is_leaf() {
                    leaf_bounds(child.index())
                } else {
                    debug_assert!(child.index() > index, "children come after their parent");
                    node_bounds[child.index()]
                };
                node.set(slot, bounds, child);
                node_bounds[index] = node_bounds[index].union(bounds);
            }
        }
        if self.root != Child::NONE {
            self.bounds = node_bounds[self.root.index()];
            self.range = range_of(self.bounds);
        }
    }
}
