//! Size and expected cost of a packed tree, and the cost of single rays.

use super::Packed;
use super::closest::ClosestVisitor;
use super::kernel::{HasIds, Kernel, NO_ID};
use super::method_tag::{Enhanced, MethodTag, Vanilla};
use crate::node::{Child, Node, WIDTH};
use crate::simd::Portable;
use crate::slab::SlabRay;
use crate::traverse;
use rotund_geometry::{Aabb, Method, Ray};

/// The size and the expected cost of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Number of primitives, without those that were [left out](Packed::left_out).
    pub primitives: usize,
    /// Number of inner nodes.
    pub nodes: usize,
    /// Number of children of all inner nodes, which have eight slots each.
    pub children: usize,
    /// Number of leaves: blocks of up to eight primitives.
    pub leaves: usize,
    /// Number of nodes above the deepest leaf.
    pub depth: usize,
    /// Size of nodes and leaves in bytes.
    pub bytes: usize,
    /// Cost by the surface area heuristic: the mean number of nodes and leaves that a random line
    /// through the box of the tree visits.
    pub sah: f64,
}

/// The numbers of nodes and primitives that one ray visits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Visits {
    /// Number of nodes whose children were tested.
    pub nodes: u32,
    /// Number of primitives in the leaves that were tested.
    pub primitives: u32,
}

impl<P: Kernel> Packed<P> {
    /// Traverses the whole tree and reports its size and expected cost.
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
        let whole = half_area(self.tree.bounds);
        if self.tree.root == Child::NONE {
            return statistics;
        }
        statistics.sah = 1.0;
        let mut stack = vec![(self.tree.root, 1)];
        while let Some((child, depth)) = stack.pop() {
            let node: &Node = &self.tree.nodes[child.index()];
            statistics.depth = statistics.depth.max(depth);
            for (slot, &child) in node.children.iter().enumerate() {
                if child == Child::NONE {
                    continue;
                }
                statistics.children += 1;
                if whole > 0.0 {
                    statistics.sah += half_area(node.bounds(slot)) / whole;
                }
                if !child.is_leaf() {
                    stack.push((child, depth + 1));
                }
            }
        }
        statistics
    }

    /// Returns what [`Packed::closest`] visits for this ray. This counts for the portable
    /// instruction set; the numbers of other sets differ by a few in a million.
    #[must_use]
    pub fn visits(&self, ray: &Ray, method: Method) -> Visits {
        match method {
            Method::Enhanced => self.count_visits::<Enhanced>(ray),
            Method::Vanilla => self.count_visits::<Vanilla>(ray),
        }
    }

    fn count_visits<M: MethodTag>(&self, ray: &Ray) -> Visits {
        let Some(slab_ray) = SlabRay::new(ray, self.tree.range) else { return Visits::default() };
        let visitor = ClosestVisitor::<P, M>::new(self, ray, &slab_ray);
        let mut counting = CountingVisitor { visitor, visits: Visits::default() };
        let limit = slab_ray.scaling.limit(ray.t_max);
        traverse::closest(Portable, &self.tree, &slab_ray, limit, &mut counting);
        counting.visits
    }
}

/// Half of the surface area of a box that is not empty, in `f64`, where no product of two sides
/// overflows or underflows.
fn half_area(bounds: Aabb) -> f64 {
    let size = bounds.max.as_dvec3() - bounds.min.as_dvec3();
    size.x * size.y + size.y * size.z + size.z * size.x
}

struct CountingVisitor<'a, P: Kernel, M> {
    visitor: ClosestVisitor<'a, P, M>,
    visits: Visits,
}

impl<P: Kernel, M: MethodTag> traverse::LeafVisitor<Portable> for CountingVisitor<'_, P, M> {}

impl<P: Kernel, M: MethodTag> traverse::ClosestVisitor<Portable> for CountingVisitor<'_, P, M> {
    #[inline(always)]
    fn leaf(&mut self, simd: Portable, index: usize, limit: f32) -> f32 {
        let ids = self.visitor.packed.blocks[index].ids();
        self.visits.primitives += ids.iter().filter(|&&id| id != NO_ID).count() as u32;
        self.visitor.leaf(simd, index, limit)
    }

    #[inline(always)]
    fn node(&mut self) {
        self.visits.nodes += 1;
    }
}
