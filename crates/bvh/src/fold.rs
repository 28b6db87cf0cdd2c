//! A binary tree, and how it is folded into wide nodes.
//!
//! A wide node takes up to [`WIDTH`] subtrees out of a binary one. Whatever is chosen, the leaves are the same, so
//! what counts is how often rays visit the nodes above them: the sum of their surface areas. It is made least by
//! dynamic programming. Let `forest(n, k)` be the least sum if subtree `n` becomes at most `k` children of the node
//! above it. For `k = 1` that is the area of `n`, if it is no leaf, and the least
//! `forest(left, i) + forest(right, WIDTH - i)`; for more, the less of `forest(n, k - 1)` and the least
//! `forest(left, i) + forest(right, k - i)`.
//!
//! Source: H. Ylitie, T. Karras, S. Laine, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs",
//! HPG 2017.

use crate::build::{Method, Output, Part};
use crate::node::{Child, Node, WIDTH};
use crate::sah::unit_scale;
use rotund_geometry::Aabb;
use std::ops::Range;

/// Builds the tree over a part.
pub(crate) fn subtree(part: Part<'_>, method: &Method) -> Output {
    let mut fold = Fold { branches: Vec::new(), scale: unit_scale(&part.extent), method };
    // About four branches for the contents of three leaves.
    fold.branches.reserve(part.records.len() * 3 / (2 * method.leaf_size));
    fold.grow(part);
    let mut output = Output { nodes: Vec::new(), leaves: Vec::new(), root: Child::NONE };
    output.root = fold.emit(0, &mut output);
    output
}

/// A node of the binary tree.
struct Branch {
    bounds: Aabb,
    records: Range<u32>,
    /// The right child; the left one is the next branch. Zero for a leaf.
    right: u32,
    /// `forest[k - 1]` is the least cost as at most `k` children.
    forest: [f32; WIDTH - 1],
    /// Of `k` children, `left[k - 1]` are for the left child, or zero if `k - 1` are as good.
    /// All [`WIDTH`] are those of the branch as a node of its own.
    left: [u8; WIDTH],
}

struct Fold<'a> {
    /// In depth-first order.
    branches: Vec<Branch>,
    /// What brings areas near one.
    scale: f32,
    method: &'a Method,
}

impl Fold<'_> {
    /// Appends the binary tree over a part, with its costs, and returns its index.
    fn grow(&mut self, part: Part<'_>) -> u32 {
        let index = self.branches.len();
        let range = part.start as u32..(part.start + part.records.len()) as u32;
        self.branches.push(Branch {
            bounds: part.extent.bounds(),
            records: range,
            right: 0,
            forest: [0.0; WIDTH - 1],
            left: [0; WIDTH],
        });
        if part.records.len() > self.method.leaf_size {
            // Where there are no areas, the fewest nodes are best.
            let area = part.extent.boxes.half_area(self.scale) + f32::EPSILON;
            let [low, high] = part.cut(self.method);
            self.grow(low);
            let right = self.grow(high);
            self.weigh(index, right, area);
        }
        index as u32
    }

    /// Fills in what becomes of a branch with two children.
    fn weigh(&mut self, index: usize, right: u32, area: f32) {
        let (low, high) = (self.branches[index + 1].forest, self.branches[right as usize].forest);
        let branch = &mut self.branches[index];
        branch.right = right;
        let mut spread = [f32::INFINITY; WIDTH];
        for count in 2..=WIDTH {
            for of_left in 1..count {
                let cost = low[of_left - 1] + high[count - of_left - 1];
                if cost < spread[count - 1] {
                    spread[count - 1] = cost;
                    branch.left[count - 1] = of_left as u8;
                }
            }
        }
        branch.forest[0] = area + spread[WIDTH - 1];
        for count in 2..WIDTH {
            let fewer = branch.forest[count - 2];
            if spread[count - 1] < fewer {
                branch.forest[count - 1] = spread[count - 1];
            } else {
                branch.forest[count - 1] = fewer;
                branch.left[count - 1] = 0;
            }
        }
    }

    /// Appends the wide nodes and leaves of a branch.
    fn emit(&self, index: usize, output: &mut Output) -> Child {
        let branch = &self.branches[index];
        if branch.right == 0 {
            output.leaves.push(branch.records.clone());
            return Child::leaf(output.leaves.len() as u32 - 1);
        }
        let node = output.nodes.len();
        output.nodes.push(Node::EMPTY);
        let mut children = Children { indices: [0; WIDTH], count: 0 };
        self.choose_below(index, WIDTH, &mut children);
        for slot in 0..children.count {
            let index = children.indices[slot];
            let child = self.emit(index, output);
            output.nodes[node].set(slot, self.branches[index].bounds, child);
        }
        Child::node(node as u32)
    }

    /// The branches that become at most `count` children in place of one.
    fn choose(&self, index: usize, mut count: usize, children: &mut Children) {
        let left = &self.branches[index].left;
        while count > 1 && left[count - 1] == 0 {
            count -= 1;
        }
        if count > 1 {
            self.choose_below(index, count, children);
        } else {
            children.indices[children.count] = index;
            children.count += 1;
        }
    }

    fn choose_below(&self, index: usize, count: usize, children: &mut Children) {
        let branch = &self.branches[index];
        let of_left = usize::from(branch.left[count - 1]);
        self.choose(index + 1, of_left, children);
        self.choose(branch.right as usize, count - of_left, children);
    }
}

/// Branches that become children of one node, in the order of their records.
struct Children {
    indices: [usize; WIDTH],
    count: usize,
}
