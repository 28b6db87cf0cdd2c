//! Subtrees: a binary tree, collapsed into wide nodes at the least cost.
//!
//! A wide node takes up to [`WIDTH`] subtrees out of a binary one. The cost to minimize is that of
//! the nodes and leaves that rays visit: the sum of their surface areas, times [`LEAF_COST`] for
//! leaves. Dynamic programming finds the minimum. Let `forest(n, k)` be the least cost if subtree
//! `n` becomes at most `k` children of the node above it. `forest(n, 1)` is the smaller of the cost
//! as a leaf, infinite if the primitives do not fit into one, and the area of `n` plus the least
//! `forest(left, i) + forest(right, WIDTH - i)`; for `k > 1`, `forest(n, k)` is the smaller of
//! `forest(n, k - 1)` and the least `forest(left, i) + forest(right, k - i)`.
//!
//! Primitives that fit into a leaf become one leaf, unless their box is large beside that of the
//! tree ([`BuildSettings::large_area`]) and larger than both its halves together: then they may
//! become several. So a leaf does not join what lies far apart, such as the sides of a box and the
//! wall behind it. Few boxes are so large, and therefore a tree over many small primitives takes no
//! more memory.
//!
//! Source: H. Ylitie, T. Karras, S. Laine, "Efficient incoherent ray traversal on GPUs through
//! compressed wide BVHs", HPG 2017.

use crate::build_range::{BuildRange, BuildSettings, Subtree};
use crate::node::{Child, Node, WIDTH};
use crate::sah::area_scale;
use rotund_geometry::Aabb;
use std::ops::Range;

/// Builds the subtree over a range.
pub(crate) fn build_subtree(range: BuildRange<'_>, settings: &BuildSettings) -> Subtree {
    let mut binary =
        BinaryTree { nodes: Vec::new(), area_scale: area_scale(&range.bounds), settings };
    // A low estimate of the number of binary nodes; the vector grows if there are more.
    binary.nodes.reserve(range.prims.len() * 3 / (2 * settings.leaf_size));
    binary.grow(range);
    let mut subtree = Subtree { nodes: Vec::new(), leaves: Vec::new(), root: Child::NONE };
    subtree.root = binary.collapse(0, &mut subtree);
    subtree
}

/// The time of a visit to a leaf, relative to that to a node. Values from 4 to 6 render a room of
/// triangles in the same time, 3 takes 1 % more.
const LEAF_COST: f32 = 4.0;

struct BinaryNode {
    bounds: Aabb,
    /// The range of its references.
    prims: Range<u32>,
    /// Index of the right child; the left child is the next node. Zero without children.
    right: u32,
    /// Whether it is a leaf if it becomes one child.
    is_leaf: bool,
    /// `forest[k - 1]` is the least cost as at most `k` children.
    forest: [f32; WIDTH - 1],
    /// Of `k` children, `left[k - 1]` come from the left child; zero if `k - 1` children cost no
    /// more. The entry for [`WIDTH`] children is that of this node as a wide node.
    left: [u8; WIDTH],
}

struct BinaryTree<'a> {
    /// In depth-first order.
    nodes: Vec<BinaryNode>,
    /// Factor that brings the areas near one.
    area_scale: f32,
    settings: &'a BuildSettings,
}

impl BinaryTree<'_> {
    /// Appends the binary tree over a range, with its costs, and returns the index of its root.
    fn grow(&mut self, range: BuildRange<'_>) -> u32 {
        // The constant prefers fewer nodes where all areas are zero.
        let scale = self.area_scale;
        let area_of = |range: &BuildRange<'_>| range.bounds.boxes.half_area(scale) + f32::EPSILON;
        let (index, count, area) = (self.nodes.len(), range.prims.len(), area_of(&range));
        let fits = count <= self.settings.leaf_size;
        let leaf_cost = if fits { LEAF_COST * area } else { f32::INFINITY };
        self.nodes.push(BinaryNode {
            bounds: range.bounds.to_aabb(),
            prims: range.start as u32..(range.start + count) as u32,
            right: 0,
            is_leaf: true,
            forest: [leaf_cost; WIDTH - 1],
            left: [0; WIDTH],
        });
        let is_large = range.bounds.half_area() > self.settings.large_area;
        if !fits || (count > 1 && is_large) {
            let [low, high] = range.split(self.settings);
            if !fits || area_of(&low) + area_of(&high) < area {
                self.grow(low);
                let right = self.grow(high);
                self.compute_costs(index, right, area);
            }
        }
        index as u32
    }

    /// Fills in the costs of a node with two children. Its `forest` holds the cost as a leaf.
    fn compute_costs(&mut self, index: usize, right: u32, area: f32) {
        let (low, high) = (self.nodes[index + 1].forest, self.nodes[right as usize].forest);
        let node = &mut self.nodes[index];
        node.right = right;
        let mut distributed = [f32::INFINITY; WIDTH];
        for count in 2..=WIDTH {
            for left_count in 1..count {
                let cost = low[left_count - 1] + high[count - left_count - 1];
                if cost < distributed[count - 1] {
                    distributed[count - 1] = cost;
                    node.left[count - 1] = left_count as u8;
                }
            }
        }
        let as_node = area + distributed[WIDTH - 1];
        node.is_leaf = node.forest[0] < as_node;
        node.forest[0] = node.forest[0].min(as_node);
        for count in 2..WIDTH {
            let fewer = node.forest[count - 2];
            if distributed[count - 1] < fewer {
                node.forest[count - 1] = distributed[count - 1];
            } else {
                node.forest[count - 1] = fewer;
                node.left[count - 1] = 0;
            }
        }
    }

    /// Appends the wide nodes and the leaves under a binary node.
    fn collapse(&self, index: usize, subtree: &mut Subtree) -> Child {
        let binary = &self.nodes[index];
        if binary.is_leaf {
            subtree.leaves.push(binary.prims.clone());
            return Child::leaf(subtree.leaves.len() as u32 - 1);
        }
        let node = subtree.nodes.len();
        subtree.nodes.push(Node::EMPTY);
        let mut children = WideChildren { indices: [0; WIDTH], count: 0 };
        self.distribute(index, WIDTH, &mut children);
        for slot in 0..children.count {
            let index = children.indices[slot];
            let child = self.collapse(index, subtree);
            subtree.nodes[node].set(slot, self.nodes[index].bounds, child);
        }
        Child::node(node as u32)
    }

    /// Appends the at most `count` wide children that a binary node becomes.
    fn choose(&self, index: usize, mut count: usize, children: &mut WideChildren) {
        let left = &self.nodes[index].left;
        while count > 1 && left[count - 1] == 0 {
            count -= 1;
        }
        if count > 1 {
            self.distribute(index, count, children);
        } else {
            children.indices[children.count] = index;
            children.count += 1;
        }
    }

    /// Distributes `count` wide children among the two children of a binary node.
    fn distribute(&self, index: usize, count: usize, children: &mut WideChildren) {
        let node = &self.nodes[index];
        let left_count = usize::from(node.left[count - 1]);
        self.choose(index + 1, left_count, children);
        self.choose(node.right as usize, count - left_count, children);
    }
}

/// Binary nodes that become the children of one wide node, in the order of their references.
struct WideChildren {
    indices: [usize; WIDTH],
    count: usize,
}
