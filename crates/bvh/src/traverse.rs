//! Walks through a tree along a ray.

use crate::build::MAX_DEPTH;
use crate::node::{Child, Tree, WIDTH};
use crate::simd::Simd;
use crate::slab::SlabRay;

/// Nodes that wait, with the parameter at which the ray enters them.
///
/// Each of at most [`MAX_DEPTH`] nodes on the path down leaves at most `WIDTH - 1` siblings.
struct Stack {
    entries: [(f32, Child); MAX_DEPTH * (WIDTH - 1) + 1],
    len: usize,
}

impl Stack {
    fn new() -> Self {
        Self { entries: [(0.0, Child::NONE); MAX_DEPTH * (WIDTH - 1) + 1], len: 0 }
    }

    #[inline(always)]
    fn push(&mut self, entry: (f32, Child)) {
        self.entries[self.len] = entry;
        self.len += 1;
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<(f32, Child)> {
        self.len = self.len.checked_sub(1)?;
        Some(self.entries[self.len])
    }
}

/// Calls `leaf` with the index of each leaf that the ray meets before `limit`, about nearest first.
/// `leaf` returns the new limit.
#[inline(always)]
pub(crate) fn closest<S: Simd>(
    simd: S,
    tree: &Tree,
    ray: &SlabRay,
    mut limit: f32,
    mut leaf: impl FnMut(usize, f32) -> f32,
) {
    if tree.root == Child::NONE {
        return;
    }
    let lanes = ray.lanes(simd);
    let mut stack = Stack::new();
    stack.push((f32::NEG_INFINITY, tree.root));
    while let Some((entry, child)) = stack.pop() {
        if entry > limit {
            continue;
        }
        if child.is_leaf() {
            limit = leaf(child.index(), limit);
            continue;
        }
        let node = &tree.nodes[child.index()];
        let (near, mut mask) = lanes.test(simd, node, simd.splat(limit));
        let near = simd.to_array(near);
        let first = stack.len;
        while mask != 0 {
            let slot = mask.trailing_zeros() as usize & (WIDTH - 1);
            mask &= mask - 1;
            stack.push((near[slot], node.children[slot]));
        }
        // Few hits, nearly always: insertion wins. The nearest ends on top.
        for i in first + 1..stack.len {
            let mut at = i;
            while at > first && stack.entries[at - 1].0 < stack.entries[at].0 {
                stack.entries.swap(at - 1, at);
                at -= 1;
            }
        }
    }
}

/// Calls `leaf` with the leaves that the ray meets before `limit`, in any order, until one returns
/// true; returns whether one did.
#[inline(always)]
pub(crate) fn any<S: Simd>(
    simd: S,
    tree: &Tree,
    ray: &SlabRay,
    limit: f32,
    mut leaf: impl FnMut(usize) -> bool,
) -> bool {
    if tree.root == Child::NONE {
        return false;
    }
    let lanes = ray.lanes(simd);
    let limit = simd.splat(limit);
    let mut stack = Stack::new();
    stack.push((0.0, tree.root));
    while let Some((_, child)) = stack.pop() {
        if child.is_leaf() {
            if leaf(child.index()) {
                return true;
            }
            continue;
        }
        let node = &tree.nodes[child.index()];
        let (_, mut mask) = lanes.test(simd, node, limit);
        while mask != 0 {
            let slot = mask.trailing_zeros() as usize & (WIDTH - 1);
            mask &= mask - 1;
            stack.push((0.0, node.children[slot]));
        }
    }
    false
}
