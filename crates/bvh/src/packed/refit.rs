//! Following primitives that move, without a new tree.

use super::Packed;
use super::kernel::{HasIds, Kernel, NO_ID};
use crate::node::{Child, WIDTH};
use rayon::prelude::*;
use rotund_geometry::Aabb;

impl<P: Kernel> Packed<P> {
    /// Takes over the new places of the primitives the tree was built from, and fits its boxes to them.
    ///
    /// The tree keeps its shape: answers stay exact, but rays grow slower as neighbours move apart, and
    /// then a new tree pays. A primitive that was left out when the tree was built stays out.
    ///
    /// # Panics
    ///
    /// If a primitive in the tree is not in the slice any more, or cannot be hit by any ray now (a
    /// number that is not finite, a sphere without radius): such a change asks for a new tree.
    pub fn refit(&mut self, primitives: &[P]) {
        let boxes: Vec<Aabb> = self
            .blocks
            .par_iter_mut()
            .map(|block| {
                let ids = *block.ids();
                let lanes: [P; WIDTH] = ids.map(|id| {
                    let id = if id == NO_ID { ids[0] } else { id } as usize;
                    assert!(
                        id < primitives.len(),
                        "the tree holds primitive {id}, and there are {} now",
                        primitives.len()
                    );
                    primitives[id]
                });
                *block = P::pack(&lanes, ids);
                lanes.iter().zip(ids).fold(Aabb::EMPTY, |sum, (primitive, id)| {
                    let bounds = primitive.bounds();
                    assert!(!bounds.is_empty(), "no ray can hit primitive {id} any more");
                    sum.union(bounds)
                })
            })
            .collect();
        // A child is made after its parent, but the top of the tree is joined to subtrees that stand
        // behind it: either way the index of a child is the larger one.
        let mut whole = vec![Aabb::EMPTY; self.tree.nodes.len()];
        for index in (0..self.tree.nodes.len()).rev() {
            let node = &mut self.tree.nodes[index];
            for slot in 0..WIDTH {
                let child = node.children[slot];
                if child == Child::NONE {
                    continue;
                }
                let bounds =
                    if child.is_leaf() { boxes[child.index()] } else { whole[child.index()] };
                debug_assert!(child.is_leaf() || child.index() > index, "children come later");
                node.set(slot, bounds, child);
                whole[index] = whole[index].union(bounds);
            }
        }
        if self.tree.root != Child::NONE {
            self.tree.bounds = whole[self.tree.root.index()];
        }
    }
}
