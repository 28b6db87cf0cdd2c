//! Walks through a tree along a ray.
#![expect(unsafe_code, reason = "the stack takes what `Simd::order` writes on trust")]

use crate::node::{Child, Node, Tree, WIDTH};
use crate::simd::{Entry, Simd};
use crate::slab::SlabRay;
use crate::stack::{self, Stack};

/// Knows where leaves are.
pub(crate) trait Leaves<S: Simd> {
    /// Asks for the memory of a leaf that will be tested soon.
    #[inline(always)]
    fn prefetch(&self, simd: S, index: usize) {
        _ = (simd, index);
    }
}

/// Looks into leaves for the closest hit.
pub(crate) trait Closest<S: Simd>: Leaves<S> {
    /// Tests the leaf, and returns the limit from now on. Implementations are `#[inline(always)]`.
    fn leaf(&mut self, simd: S, index: usize, limit: f32) -> f32;

    /// Notes that the walk tests the children of a node.
    #[inline(always)]
    fn node(&mut self) {}
}

/// Looks into leaves for any hit.
pub(crate) trait Any<S: Simd>: Leaves<S> {
    /// Tests the leaf. Implementations are `#[inline(always)]`.
    fn leaf(&mut self, simd: S, index: usize) -> bool;
}

/// Asks for the memory of a child.
#[inline(always)]
fn prefetch<S: Simd>(simd: S, tree: &Tree, visitor: &impl Leaves<S>, child: Child) {
    if child.is_leaf() {
        visitor.prefetch(simd, child.index());
    } else {
        simd.prefetch(&tree.nodes[child.index()]);
    }
}

/// Shows `visitor` each leaf that the ray meets before the limit, about nearest first.
#[inline(always)]
pub(crate) fn closest<S: Simd>(
    simd: S,
    tree: &Tree,
    ray: &SlabRay,
    mut limit: f32,
    visitor: &mut impl Closest<S>,
) {
    if tree.root == Child::NONE {
        return;
    }
    let lanes = ray.lanes(simd);
    let mut limits = simd.splat(limit);
    let mut room = stack::room();
    let mut stack = Stack::new(&mut room);
    let mut current = tree.root;
    loop {
        if current.is_leaf() {
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
                    let a = Entry::new(near[first], node.children[first]);
                    let b = Entry::new(near[second], node.children[second]);
                    stack.push(a.max(b));
                    prefetch(simd, tree, visitor, a.max(b).child());
                    current = a.min(b).child();
                    continue;
                }
                let count = mask.count_ones() as usize;
                // SAFETY: `order` writes an entry for each bit of the mask.
                unsafe {
                    stack.extend(count, |window| simd.order(near, mask, &node.children, window));
                }
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
            // A limit below zero (an interval that ends behind the origin) is no reason to skip:
            // entries count from zero, and the lane in their low bits makes them a little more.
            if entry.near() <= limit.max(f32::MIN_POSITIVE) {
                break entry.child();
            }
        };
    }
}

/// Shows `visitor` the leaves that the ray meets before the limit, in any order, until one is hit;
/// returns whether one was.
#[inline(always)]
pub(crate) fn any<S: Simd>(
    simd: S,
    tree: &Tree,
    ray: &SlabRay,
    limit: f32,
    visitor: &mut impl Any<S>,
) -> bool {
    if tree.root == Child::NONE {
        return false;
    }
    let lanes = ray.lanes(simd);
    let limits = simd.splat(limit);
    let mut room = stack::room();
    let mut stack = Stack::new(&mut room);
    let mut current = tree.root;
    loop {
        if current.is_leaf() {
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
                    stack.push(Entry::new(0.0, node.children[slot]));
                    prefetch(simd, tree, visitor, node.children[slot]);
                }
                continue;
            }
        }
        let Some(entry) = stack.pop() else { return false };
        current = entry.child();
    }
}
