//! What a packed tree is made of, and what a ray sees of it.

use super::kernel::{HasIds, Kernel, NO_ID};
use super::{FindClosest, Form, Packed};
use crate::node::{Child, Node, WIDTH};
use crate::simd::Portable;
use crate::slab::SlabRay;
use crate::traverse::{self, Closest, Leaves};
use rotund_geometry::Ray;

/// The size of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Primitives in the tree: without those that were left out.
    pub primitives: usize,
    /// Inner nodes.
    pub nodes: usize,
    /// Children of inner nodes; of eight slots each.
    pub children: usize,
    /// Leaves: blocks of up to eight primitives.
    pub leaves: usize,
    /// Nodes above the deepest leaf.
    pub depth: usize,
    /// Bytes of nodes and leaves.
    pub bytes: usize,
    /// The surface area heuristic: how many nodes and leaves a long random line through the box of the
    /// tree meets, on average.
    pub sah: f64,
}

/// What one ray visits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Visits {
    /// Nodes whose children were tested.
    pub nodes: u32,
    /// Primitives that the wide test looked at.
    pub primitives: u32,
}

impl<P: Kernel> Packed<P> {
    /// Looks through the whole tree and reports its size.
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        let used = |ids: &[u32; WIDTH]| ids.iter().filter(|&&id| id != NO_ID).count();
        let mut statistics = Statistics {
            primitives: self.blocks.iter().map(|block| used(block.ids())).sum(),
            nodes: self.tree.nodes.len(),
            children: 0,
            leaves: self.blocks.len(),
            depth: 0,
            bytes: size_of_val(self.blocks.as_slice()) + size_of_val(self.tree.nodes.as_slice()),
            sah: 0.0,
        };
        let whole = f64::from(self.tree.bounds.half_area());
        if self.tree.root == Child::NONE {
            return statistics;
        }
        statistics.sah = 1.0;
        let mut waiting = vec![(self.tree.root, 1)];
        while let Some((child, depth)) = waiting.pop() {
            let node: &Node = &self.tree.nodes[child.index()];
            statistics.depth = statistics.depth.max(depth);
            for (slot, &child) in node.children.iter().enumerate() {
                if child == Child::NONE {
                    continue;
                }
                statistics.children += 1;
                if whole > 0.0 {
                    statistics.sah += f64::from(node.bounds(slot).half_area()) / whole;
                }
                if !child.is_leaf() {
                    waiting.push((child, depth + 1));
                }
            }
        }
        statistics
    }

    /// What [`Packed::closest`] visits for this ray. (The instruction sets differ in what they look at
    /// by a few in a million; this counts for the portable one.)
    #[must_use]
    pub fn visits(&self, ray: &Ray, form: Form) -> Visits {
        match form {
            Form::Enhanced => self.count::<false>(ray),
            Form::Vanilla => self.count::<true>(ray),
        }
    }

    fn count<const VANILLA: bool>(&self, ray: &Ray) -> Visits {
        let Some(slab_ray) = SlabRay::new(ray) else { return Visits::default() };
        let find = FindClosest::<Portable, P, VANILLA>::new(Portable, self, ray, &slab_ray);
        let mut counting = Counting { find, visits: Visits::default() };
        let limit = slab_ray.limit(ray.t_max);
        traverse::closest(Portable, &self.tree, &slab_ray, limit, &mut counting);
        counting.visits
    }
}

struct Counting<'a, P: Kernel, const VANILLA: bool> {
    find: FindClosest<'a, Portable, P, VANILLA>,
    visits: Visits,
}

impl<P: Kernel, const VANILLA: bool> Leaves<Portable> for Counting<'_, P, VANILLA> {}

impl<P: Kernel, const VANILLA: bool> Closest<Portable> for Counting<'_, P, VANILLA> {
    #[inline(always)]
    fn leaf(&mut self, simd: Portable, index: usize, limit: f32) -> f32 {
        let ids = self.find.packed.blocks[index].ids();
        self.visits.primitives += ids.iter().filter(|&&id| id != NO_ID).count() as u32;
        self.find.leaf(simd, index, limit)
    }

    #[inline(always)]
    fn node(&mut self) {
        self.visits.nodes += 1;
    }
}
