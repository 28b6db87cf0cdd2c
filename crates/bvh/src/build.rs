//! Top-down construction of a wide tree.
//!
//! At the top, where ranges are large, a node starts as one range of primitive references; the
//! range with the largest surface area is split in two until there are [`WIDTH`] of them. Ranges of
//! at most [`SEQUENTIAL_LIMIT`] references become subtrees, built in parallel: each is a binary
//! tree that is collapsed into wide nodes (`fold.rs`) in its own vectors. The vectors are then
//! concatenated in order. A subtree depends only on its references and on the surface area of the
//! whole tree, so the tree is the same for any number of threads.

use crate::build_range::{BuildRange, BuildSettings, Subtree};
use crate::fold;
use crate::huge_pages;
use crate::isa::Isa;
use crate::node::{Child, Node, Tree, WIDTH, range_of};
use crate::prim_ref::{PrimRef, RangeBounds};
use rayon::prelude::*;
use rotund_geometry::Aabb;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Ranges up to this length are built by one thread. A whole tree of at most this length is built
/// by the calling thread, which neither starts nor wakes a thread pool.
pub(crate) const SEQUENTIAL_LIMIT: usize = 1 << 14;

/// The largest number of primitives in a tree: 2^31 - 2, since one bit of a 32-bit index tells
/// leaves from nodes. A larger scene can be divided among several trees, under a [`crate::Bvh`]
/// over their bounds.
pub const MAX_PRIMITIVES: usize = Child::MAX_INDEX as usize;

/// [`BuildSettings::large_area`] relative to the surface area of the tree: one in 32 of the rays
/// that meet the tree meets such a box. With a 256th, trees over up to 30,000 small spheres would
/// have smaller leaves and take more memory.
const LARGE: f32 = 1.0 / 32.0;

/// A tree and the leaves that it refers to.
pub(crate) struct Built {
    pub(crate) tree: Tree,
    /// Ids of all boxes that are not empty, in the order of the leaves.
    pub(crate) ids: Vec<u32>,
    /// Range in `ids` of each leaf: `leaves[i]` for `Child::leaf(i)`.
    pub(crate) leaves: Vec<Range<u32>>,
}

/// Builds a tree over `count` boxes. Empty boxes and boxes with a NaN are left out.
///
/// # Panics
///
/// If there are more than [`MAX_PRIMITIVES`] boxes.
pub(crate) fn build(count: usize, bounds: impl Fn(u32) -> Aabb + Sync, leaf_size: u32) -> Built {
    assert!(
        count <= MAX_PRIMITIVES,
        "a tree holds at most {MAX_PRIMITIVES} boxes, not {count}: divide them among several trees"
    );
    let mut prims = prim_refs(count, bounds);
    if prims.is_empty() {
        let tree = Tree {
            nodes: Vec::new(),
            root: Child::NONE,
            bounds: Aabb::EMPTY,
            range: range_of(Aabb::EMPTY),
            source_count: count,
            kept_count: 0,
        };
        return Built { tree, ids: Vec::new(), leaves: Vec::new() };
    }

    let isa = Isa::default_set();
    let bounds = RangeBounds::of(&prims, isa);
    let large_area = LARGE * bounds.half_area();
    let settings = BuildSettings { leaf_size: leaf_size as usize, large_area, isa };
    let whole = BuildRange { prims: &mut prims, start: 0, bounds, depth: 0 };
    let mut ranges = Vec::new();
    let top = top_tree(whole, &settings).take_ranges(&mut ranges);
    let run = |range: BuildRange<'_>| fold::build_subtree(range, &settings);
    let subtrees: Vec<Subtree> = if ranges.len() == 1 {
        ranges.into_iter().map(run).collect()
    } else {
        ranges.into_par_iter().map(run).collect()
    };

    let mut joined = Joined { nodes: Vec::new(), leaves: Vec::new(), roots: Vec::new() };
    let top_count = top.node_count();
    let node_count = top_count + subtrees.iter().map(|s| s.nodes.len()).sum::<usize>();
    joined.nodes = huge_pages::vec_with_capacity(node_count);
    joined.leaves.reserve_exact(subtrees.iter().map(|s| s.leaves.len()).sum());
    joined.nodes.resize(top_count, Node::EMPTY);
    for subtree in subtrees {
        joined.append(subtree);
    }
    let mut root = top.place(&mut joined, &mut 0);
    if root.is_leaf() {
        // The root is a node, so that the box of a single leaf is tested too.
        let mut node = Node::EMPTY;
        node.set(0, bounds.to_aabb(), root);
        joined.nodes.push(node);
        root = Child::node(0);
    }
    let tree = Tree {
        nodes: joined.nodes,
        root,
        bounds: bounds.to_aabb(),
        range: range_of(bounds.to_aabb()),
        source_count: count,
        kept_count: prims.len(),
    };
    // Only the ids are returned, so that the caller's leaves can reuse the memory of the primitive
    // references.
    let ids = if count <= SEQUENTIAL_LIMIT {
        prims.iter().map(PrimRef::id).collect()
    } else {
        prims.par_iter().map(PrimRef::id).collect()
    };
    Built { tree, ids, leaves: joined.leaves }
}

/// References to all boxes that are not empty.
fn prim_refs(count: usize, bounds: impl Fn(u32) -> Aabb + Sync) -> Vec<PrimRef> {
    let any_empty = AtomicBool::new(false);
    let mut prims: Vec<PrimRef> = huge_pages::vec_with_capacity(count);
    let prim = |id: u32| {
        let prim = PrimRef::new(id, bounds(id));
        if prim.is_empty() {
            any_empty.store(true, Ordering::Relaxed);
        }
        prim
    };
    if count <= SEQUENTIAL_LIMIT {
        prims.extend((0..count as u32).map(prim));
    } else {
        (0..count as u32).into_par_iter().map(prim).collect_into_vec(&mut prims);
    }
    if any_empty.into_inner() {
        prims.retain(|prim| !prim.is_empty());
    }
    prims
}

/// The top of the tree: nodes over the ranges of subtrees, or over indices of these.
enum TopTree<T> {
    Node(Vec<(Aabb, TopTree<T>)>),
    Subtree(T),
}

fn top_tree<'a>(whole: BuildRange<'a>, settings: &BuildSettings) -> TopTree<BuildRange<'a>> {
    if whole.prims.len() <= SEQUENTIAL_LIMIT {
        return TopTree::Subtree(whole);
    }
    let mut ranges = vec![whole];
    while ranges.len() < WIDTH {
        let area = |i: usize| ranges[i].bounds.half_area();
        let Some(largest) = (0..ranges.len())
            .filter(|&i| ranges[i].prims.len() > settings.leaf_size)
            .max_by(|&a, &b| area(a).total_cmp(&area(b)))
        else {
            break;
        };
        let halves = ranges.swap_remove(largest).split(settings);
        ranges.extend(halves);
    }
    // Back to the order of their references, so that a depth-first traversal reads memory forwards.
    ranges.sort_by_key(|range| range.start);
    let child = |range: BuildRange<'a>| (range.bounds.to_aabb(), top_tree(range, settings));
    TopTree::Node(ranges.into_par_iter().map(child).collect())
}

impl<'a> TopTree<BuildRange<'a>> {
    /// Moves the ranges out, in order, and leaves their indices.
    fn take_ranges(self, ranges: &mut Vec<BuildRange<'a>>) -> TopTree<usize> {
        match self {
            TopTree::Subtree(range) => {
                ranges.push(range);
                TopTree::Subtree(ranges.len() - 1)
            }
            TopTree::Node(children) => TopTree::Node(
                children
                    .into_iter()
                    .map(|(bounds, child)| (bounds, child.take_ranges(ranges)))
                    .collect(),
            ),
        }
    }
}

impl TopTree<usize> {
    fn node_count(&self) -> usize {
        match self {
            TopTree::Subtree(_) => 0,
            TopTree::Node(children) => {
                1 + children.iter().map(|(_, child)| child.node_count()).sum::<usize>()
            }
        }
    }

    /// Writes the nodes of the top to the front of `joined`, from index `next` on.
    fn place(&self, joined: &mut Joined, next: &mut usize) -> Child {
        match self {
            TopTree::Subtree(index) => joined.roots[*index],
            TopTree::Node(children) => {
                let index = *next;
                *next += 1;
                for (slot, (bounds, child)) in children.iter().enumerate() {
                    let child = child.place(joined, next);
                    joined.nodes[index].set(slot, *bounds, child);
                }
                Child::node(index as u32)
            }
        }
    }
}

/// All subtrees, one after the other.
struct Joined {
    nodes: Vec<Node>,
    leaves: Vec<Range<u32>>,
    roots: Vec<Child>,
}

impl Joined {
    fn append(&mut self, subtree: Subtree) {
        let (nodes, leaves) = (self.nodes.len() as u32, self.leaves.len() as u32);
        let shifted = |child: Child| match child {
            Child::NONE => child,
            leaf if leaf.is_leaf() => Child::leaf(leaf.index() as u32 + leaves),
            node => Child::node(node.index() as u32 + nodes),
        };
        self.nodes.extend(subtree.nodes.into_iter().map(|mut node| {
            node.children = node.children.map(shifted);
            node
        }));
        self.leaves.extend(subtree.leaves);
        self.roots.push(shifted(subtree.root));
    }
}
