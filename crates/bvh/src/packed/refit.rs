//! Refitting packed trees: leaves take over the primitives that moved, and boxes follow them.

use super::Packed;
use super::kernel::{HasIds, Kernel, NO_ID};
use crate::prim_ref::finite_part;
use crate::refit::RefitError;
use rayon::prelude::*;
use rotund_geometry::Aabb;

impl<P: Kernel> Packed<P> {
    /// Moves the primitives: `primitives[i]` replaces primitive `i`. The bounds of all nodes are
    /// recomputed bottom-up; the topology of the tree stays.
    ///
    /// Queries return the same results as a rebuilt tree, but may be slower: where neighbors in the
    /// tree move apart, nodes grow and overlap, and rays visit more of them. Refit while primitives
    /// move together, or by a few of their sizes; build a new tree when queries have slowed down by
    /// more than a build costs. The expected cost of a ray is
    /// [`Statistics::sah`](crate::Statistics::sah): `examples/capsules.rs` builds a new tree when
    /// it has grown by half.
    ///
    /// # Errors
    ///
    /// If the number of primitives is not that of the build, or if a primitive that no ray could
    /// hit at the build (one with a number that is not finite, or a sphere without radius) can be
    /// hit now or the reverse. The tree is then as it was before the call.
    pub fn refit(&mut self, primitives: &[P]) -> Result<(), RefitError> {
        let ids = self.blocks.iter().flat_map(|block| *block.ids()).filter(|&id| id != NO_ID);
        let bounds = |id: u32| finite_part(primitives[id as usize].tree_bounds());
        let any_empty = || {
            self.blocks
                .par_iter()
                .any(|block| block.ids().iter().any(|&id| id != NO_ID && bounds(id).is_none()))
        };
        self.tree.check_refit(primitives.len(), any_empty, ids, |id| bounds(id).is_none())?;
        let boxes: Vec<Aabb> = self
            .blocks
            .par_iter_mut()
            .map(|block| {
                let ids = *block.ids();
                let lane = |id: u32| primitives[if id == NO_ID { ids[0] } else { id } as usize];
                *block = P::pack(&ids.map(lane), ids);
                let used = ids.iter().filter(|&&id| id != NO_ID);
                used.filter_map(|&id| bounds(id)).fold(Aabb::EMPTY, Aabb::union)
            })
            .collect();
        self.tree.refit(|leaf| boxes[leaf]);
        Ok(())
    }
}
