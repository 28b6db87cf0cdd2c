//! Traversal of a tree along a ray, generic over the visitor of its leaves.
#![expect(unsafe_code, reason = "the stack relies on `Simd::order` to initialize its entries")]

use crate::node::{Child, Node, Tree, WIDTH};
use crate::simd::{Simd, StackEntry};
use crate::slab::SlabRay;
use crate::stack::{self, Stack};
use std::mem::MaybeUninit;

/// A visitor of leaves, whose memory it may prefetch.
pub(crate) trait LeafVisitor<S: Simd> {
    /// Prefetches a leaf that will be tested soon.
    #[inline(always)]
    fn prefetch(&self, simd: S, index: usize) {
        _ = (simd, index);
    }
}

/// A visitor that searches leaves for the closest hit.
pub(crate) trait ClosestVisitor<S: Simd>: LeafVisitor<S> {
    /// Tests the leaf, and returns the new limit. Implementations are `#[inline(always)]`.
    fn leaf(&mut self, simd: S, index: usize, limit: f32) -> f32;

    /// Called for each node whose children are tested.
    #[inline(always)]
    fn node(&mut self) {}
}

/// A visitor that searches leaves for any hit.
pub(crate) trait AnyVisitor<S: Simd>: LeafVisitor<S> {
    /// Returns whether the ray hits anything in the leaf. Implementations are `#[inline(always)]`.
    fn leaf(&mut self, simd: S, index: usize) -> bool;
}

/// Prefetches a node or leaf.
#[inline(always)]
fn prefetch<S: Simd>(simd: S, tree: &Tree, visitor: &impl LeafVisitor<S>, child: Child) {
    if child.is_leaf() {
        visitor.prefetch(simd, child.index());
    } else {
        simd.prefetch(&tree.nodes[child.index()]);
    }
}

/// Returns the children in `mask`, farthest first; the entries after them are unspecified.
#[inline(always)]
pub(crate) fn ordered<S: Simd>(
    simd: S,
    near: S::Lanes,
    mask: u32,
    children: &[Child; WIDTH],
) -> [StackEntry; WIDTH] {
    let mut entries = [MaybeUninit::new(StackEntry::NONE); WIDTH];
    simd.order(near, mask, children, &mut entries);
    // SAFETY: all entries were initialized above, and `order` only overwrites them.
    entries.map(|entry| unsafe { entry.assume_init() })
}

/// Calls `visitor` with each leaf whose box the ray meets before the limit, roughly from near to
/// far.
#[inline(always)]
pub(crate) fn closest<S: Simd>(
    simd: S,
    tree: &Tree,
    ray: &SlabRay,
    mut limit: f32,
    visitor: &mut impl ClosestVisitor<S>,
) {
    if tree.root == Child::NONE {
        return;
    }
    let lanes = ray.lanes(simd);
    let mut limits = simd.splat(limit);
    let mut storage = stack::storage();
    let mut stack = Stack::new(&mut storage);
    let mut current = tree.root;
    loop {
        if current.is_leaf() {
            // Earlier than the loads of the test, whose addresses wait for the set-up of its call.
            visitor.prefetch(simd, current.index());
            let new_limit = visitor.leaf(simd, current.index(), limit);
            if new_limit != limit {
                limit = new_limit;
                limits = simd.splat(limit);
            }
        } else {
            visitor.node();
            let node: &Node = &tree.nodes[current.index()];
            let (near, mask) = lanes.test(simd, node, limits);
            if mask != 0 {
                let first = mask.trailing_zeros() as usize % WIDTH;
                let rest = mask & (mask - 1);
                if rest == 0 {
                    current = node.children[first];
                    continue;
                }
                if rest & (rest - 1) == 0 {
                    let second = rest.trailing_zeros() as usize % WIDTH;
                    let near = simd.to_array(near);
                    let a = StackEntry::new(near[first], node.children[first]);
                    let b = StackEntry::new(near[second], node.children[second]);
                    // Two branches and no selection: where the processor predicts the nearer child,
                    // it loads it before the distances are known.
                    if a < b {
                        stack.push(b);
                        prefetch(simd, tree, visitor, b.child());
                        current = a.child();
                    } else {
                        stack.push(a);
                        prefetch(simd, tree, visitor, a.child());
                        current = b.child();
                    }
                    continue;
                }
                let count = mask.count_ones() as usize;
                // Not in a closure, which might be outlined, without the instruction set.
                simd.order(near, mask, &node.children, stack.next());
                // SAFETY: `order` initializes an entry for each bit of the mask.
                unsafe { stack.grow(count) };
                let mut rest = mask;
                while rest != 0 {
                    let slot = rest.trailing_zeros() as usize % WIDTH;
                    rest &= rest - 1;
                    prefetch(simd, tree, visitor, node.children[slot]);
                }
            }
        }
        current = loop {
            let Some(entry) = stack.pop() else { return };
            // Distances in entries are clamped to zero, and the lane in their low bits increases
            // them a little; so an entry at zero must pass also if the limit is negative (an
            // interval that ends behind the origin).
            if entry.near() <= limit.max(f32::MIN_POSITIVE) {
                break entry.child();
            }
        };
    }
}

/// Calls `visitor` with each leaf whose box the ray meets before a limit that the visitor may move
/// away, at most to `reach`, roughly from near to far. Returns the nearest distance of a box that
/// was skipped, which the limit may have passed since.
#[inline(always)]
pub(crate) fn growing<S: Simd>(
    simd: S,
    tree: &Tree,
    ray: &SlabRay,
    reach: f32,
    mut limit: f32,
    visitor: &mut impl ClosestVisitor<S>,
) -> f32 {
    let mut skipped = f32::INFINITY;
    if tree.root == Child::NONE {
        return skipped;
    }
    let lanes = ray.lanes(simd);
    let ends = simd.splat(reach);
    let mut storage = stack::storage();
    let mut stack = Stack::new(&mut storage);
    let mut current = tree.root;
    loop {
        if current.is_leaf() {
            limit = visitor.leaf(simd, current.index(), limit);
        } else {
            let node: &Node = &tree.nodes[current.index()];
            // What begins behind the limit waits on the stack, since the limit may move.
            let (near, mask) = lanes.test(simd, node, ends);
            if mask & mask.wrapping_sub(1) != 0 {
                let count = mask.count_ones() as usize;
                simd.order(near, mask, &node.children, stack.next());
                // SAFETY: `order` initializes an entry for each bit of the mask.
                unsafe { stack.grow(count) };
            } else if mask != 0 {
                let only = mask.trailing_zeros() as usize % WIDTH;
                stack.push(StackEntry::new(simd.to_array(near)[only], node.children[only]));
            }
        }
        current = loop {
            let Some(entry) = stack.pop() else { return skipped };
            // As in `closest`.
            if entry.near() <= limit.max(f32::MIN_POSITIVE) {
                break entry.child();
            }
            skipped = skipped.min(entry.near());
        };
    }
}

/// Calls `visitor` with leaves whose boxes the ray meets before the limit, in no particular order,
/// until it reports a hit; returns whether it did.
#[inline(always)]
pub(crate) fn any<S: Simd>(
    simd: S,
    tree: &Tree,
    ray: &SlabRay,
    limit: f32,
    visitor: &mut impl AnyVisitor<S>,
) -> bool {
    if tree.root == Child::NONE {
        return false;
    }
    let lanes = ray.lanes(simd);
    let limits = simd.splat(limit);
    let mut storage = stack::storage();
    let mut stack = Stack::new(&mut storage);
    let mut current = tree.root;
    loop {
        if current.is_leaf() {
            // As in `closest`.
            visitor.prefetch(simd, current.index());
            if visitor.leaf(simd, current.index()) {
                return true;
            }
        } else {
            let node = &tree.nodes[current.index()];
            let (_, mut mask) = lanes.test(simd, node, limits);
            if mask != 0 {
                current = node.children[mask.trailing_zeros() as usize % WIDTH];
                mask &= mask - 1;
                while mask != 0 {
                    let slot = mask.trailing_zeros() as usize % WIDTH;
                    mask &= mask - 1;
                    stack.push(StackEntry::new(0.0, node.children[slot]));
                    prefetch(simd, tree, visitor, node.children[slot]);
                }
                continue;
            }
        }
        let Some(entry) = stack.pop() else { return false };
        current = entry.child();
    }
}
