//! Refitting packed trees: leaves take over the primitives that moved, and boxes follow them.

use super::Packed;
use super::kernel::{HasIds, Kernel, NO_ID};
use crate::prim_ref::finite_part;
use crate::refit::RefitError;
use rayon::prelude::*;
use rotund_geometry::Aabb;

impl<P: Kernel> Packed<P> {
    /// Moves the primitives of the tree to new places: `primitives[i]` takes the place of the
    /// `i`-th primitive that the tree was built from. The bounds of all nodes are recomputed
    /// bottom-up; the topology stays.
    ///
    /// Answers are those of a tree built anew. Their cost is not: neighbours in the tree that move
    /// apart make its nodes overlap, and rays visit more of them. Refit while primitives move
    /// together or by less than the size of a leaf; build a new tree once queries have become
    /// slower than a build is worth. [`Statistics::sah`](crate::Statistics::sah) tells the expected
    /// cost of a ray.
    ///
    /// # Errors
    ///
    /// If there are more or fewer primitives than the tree was built from, or if one that no ray
    /// could hit (a number that is not finite, a sphere without radius) can be hit now or the
    /// reverse. The tree is then as it was.
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
