//! Top-down construction of a wide tree.
//!
//! At the top, where ranges are large, a node starts as one range of records; the range with the largest
//! surface is cut in two until there are [`WIDTH`] of them. What is left are tasks that run in parallel, each
//! a binary tree that is folded into wide nodes (`fold.rs`), each into its own vectors, which are joined in order. What a task does depends on its records alone, so the tree
//! is the same for any number of threads.

use crate::fold;
use crate::huge;
use crate::isa::Isa;
use crate::node::{Child, Node, Tree, WIDTH};
use crate::record::{Extent, Record};
use crate::sah::{Split, find_split, partition};
use rayon::prelude::*;
use rotund_geometry::Aabb;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Ranges cut out of the whole by as many cuts as this follow the heuristic. Below, ranges are cut in halves, so that
/// a tree over adversarial boxes stays flat enough for [`MAX_DEPTH`].
pub(crate) const SAH_DEPTH: usize = 64;

/// The deepest leaf has at most this many nodes above it: 2^31 records are halved less than 32 times.
pub(crate) const MAX_DEPTH: usize = SAH_DEPTH + 32;

/// Ranges up to this length are built by one thread: a whole tree of no more than this by the caller's, without
/// waking, or starting, a pool of others.
pub(crate) const TASK: usize = 1 << 14;

/// The most primitives that a tree holds: 2^31 - 2, since one bit of 32 tells leaves from nodes. Larger scenes
/// are split in several trees, under a [`crate::Bvh`] over their bounds.
pub const MAX_PRIMITIVES: usize = Child::MAX_INDEX as usize;

/// A tree, and the leaves it refers to.
pub(crate) struct Built {
    pub(crate) tree: Tree,
    /// In the order of the tree, ids of all boxes that are not empty.
    pub(crate) ids: Vec<u32>,
    /// Where the ids of leaf `i` are, for `Child::leaf(i)`.
    pub(crate) leaves: Vec<Range<u32>>,
}

/// Builds a tree over `count` boxes, of which the empty ones and those with a NaN are left out.
///
/// # Panics
///
/// If there are more than [`MAX_PRIMITIVES`].
pub(crate) fn build(count: usize, bounds: impl Fn(u32) -> Aabb + Sync, leaf_size: u32) -> Built {
    assert!(
        count <= MAX_PRIMITIVES,
        "a tree holds at most {MAX_PRIMITIVES} boxes, not {count}: split the scene in several trees"
    );
    let any_empty = AtomicBool::new(false);
    let mut records: Vec<Record> = huge::vec_with_capacity(count);
    let record = |id: u32| {
        let record = Record::new(id, bounds(id));
        if record.is_empty() {
            any_empty.store(true, Ordering::Relaxed);
        }
        record
    };
    if count <= TASK {
        records.extend((0..count as u32).map(record));
    } else {
        (0..count as u32).into_par_iter().map(record).collect_into_vec(&mut records);
    }
    if any_empty.into_inner() {
        records.retain(|record| !record.is_empty());
    }
    if records.is_empty() {
        let tree = Tree {
            nodes: Vec::new(),
            root: Child::NONE,
            bounds: Aabb::EMPTY,
            source_count: count,
            kept_count: 0,
        };
        return Built { tree, ids: Vec::new(), leaves: Vec::new() };
    }

    let method = Method { leaf_size: leaf_size as usize, isa: Isa::default_set() };
    let extent = Extent::of(&records, method.isa);
    let whole = Part { records: &mut records, start: 0, extent, depth: 0 };
    let mut tasks = Vec::new();
    let plan = plan(whole, &method).collect(&mut tasks);
    let run = |task: Part| fold::subtree(task, &method);
    let outputs: Vec<Output> = if tasks.len() == 1 {
        tasks.into_iter().map(run).collect()
    } else {
        tasks.into_par_iter().map(run).collect()
    };

    let mut joined = Joined { nodes: Vec::new(), leaves: Vec::new(), roots: Vec::new() };
    let top = plan.node_count();
    let node_count = top + outputs.iter().map(|output| output.nodes.len()).sum::<usize>();
    joined.nodes = huge::vec_with_capacity(node_count);
    joined.leaves.reserve_exact(outputs.iter().map(|o| o.leaves.len()).sum());
    joined.nodes.resize(top, Node::EMPTY);
    for output in outputs {
        joined.append(output);
    }
    let mut root = plan.place(&mut joined, &mut 0);
    if root.is_leaf() {
        // So that the box of a single leaf is looked at too.
        let mut node = Node::EMPTY;
        node.set(0, extent.bounds(), root);
        joined.nodes.push(node);
        root = Child::node(0);
    }
    let tree = Tree {
        nodes: joined.nodes,
        root,
        bounds: extent.bounds(),
        source_count: count,
        kept_count: records.len(),
    };
    // The boxes go, so that what comes next takes their memory and asks the system for less.
    let ids = if count <= TASK {
        records.iter().map(Record::id).collect()
    } else {
        records.par_iter().map(Record::id).collect()
    };
    Built { tree, ids, leaves: joined.leaves }
}

/// How the tree is built.
pub(crate) struct Method {
    /// Records in a leaf, at most.
    pub(crate) leaf_size: usize,
    /// What the tree is does not depend on it, only how soon it is there.
    pub(crate) isa: Isa,
}

/// A range of records.
pub(crate) struct Part<'a> {
    pub(crate) records: &'a mut [Record],
    /// Where they are among all.
    pub(crate) start: usize,
    pub(crate) extent: Extent,
    /// Cuts that led here.
    pub(crate) depth: usize,
}

impl<'a> Part<'a> {
    /// Cuts it in two.
    pub(crate) fn cut(self, method: &Method) -> [Self; 2] {
        let Part { records, start, extent, depth } = self;
        let split = if depth < SAH_DEPTH {
            find_split(records, &extent, method.leaf_size as u32, method.isa)
        } else {
            Split::Middle
        };
        let (count, left, right) = partition(records, split, method.isa);
        let (low, high) = records.split_at_mut(count);
        let depth = depth + 1;
        [
            Part { records: low, start, extent: left, depth },
            Part { records: high, start: start + count, extent: right, depth },
        ]
    }
}

/// The top of the tree: nodes over tasks, or over indices of tasks.
enum Plan<T> {
    Node(Vec<(Aabb, Plan<T>)>),
    Task(T),
}

fn plan<'a>(whole: Part<'a>, method: &Method) -> Plan<Part<'a>> {
    if whole.records.len() <= TASK {
        return Plan::Task(whole);
    }
    let mut parts = vec![whole];
    while parts.len() < WIDTH {
        let Some(widest) = (0..parts.len())
            .filter(|&i| parts[i].records.len() > method.leaf_size)
            .max_by(|&a, &b| parts[a].extent.half_area().total_cmp(&parts[b].extent.half_area()))
        else {
            break;
        };
        let halves = parts.swap_remove(widest).cut(method);
        parts.extend(halves);
    }
    // Back in the order of their records, so that a depth-first walk reads memory forwards.
    parts.sort_by_key(|part| part.start);
    let child = |part: Part<'a>| (part.extent.bounds(), plan(part, method));
    Plan::Node(parts.into_par_iter().map(child).collect())
}

impl<'a> Plan<Part<'a>> {
    /// Moves the tasks out, in order, and leaves their indices.
    fn collect(self, tasks: &mut Vec<Part<'a>>) -> Plan<usize> {
        match self {
            Plan::Task(task) => {
                tasks.push(task);
                Plan::Task(tasks.len() - 1)
            }
            Plan::Node(children) => Plan::Node(
                children.into_iter().map(|(bounds, plan)| (bounds, plan.collect(tasks))).collect(),
            ),
        }
    }
}

impl Plan<usize> {
    fn node_count(&self) -> usize {
        match self {
            Plan::Task(_) => 0,
            Plan::Node(children) => {
                1 + children.iter().map(|(_, plan)| plan.node_count()).sum::<usize>()
            }
        }
    }

    /// Writes the nodes of the top into the front of `joined`, from `next` on.
    fn place(&self, joined: &mut Joined, next: &mut usize) -> Child {
        match self {
            Plan::Task(index) => joined.roots[*index],
            Plan::Node(children) => {
                let index = *next;
                *next += 1;
                for (slot, (bounds, plan)) in children.iter().enumerate() {
                    let child = plan.place(joined, next);
                    joined.nodes[index].set(slot, *bounds, child);
                }
                Child::node(index as u32)
            }
        }
    }
}

/// What one task made, with indices that start at zero.
pub(crate) struct Output {
    pub(crate) nodes: Vec<Node>,
    pub(crate) leaves: Vec<Range<u32>>,
    pub(crate) root: Child,
}

/// The outputs of all tasks, one after the other.
struct Joined {
    nodes: Vec<Node>,
    leaves: Vec<Range<u32>>,
    roots: Vec<Child>,
}

impl Joined {
    fn append(&mut self, output: Output) {
        let (nodes, leaves) = (self.nodes.len() as u32, self.leaves.len() as u32);
        let moved = |child: Child| match child {
            Child::NONE => child,
            leaf if leaf.is_leaf() => Child::leaf(leaf.index() as u32 + leaves),
            node => Child::node(node.index() as u32 + nodes),
        };
        self.nodes.extend(output.nodes.into_iter().map(|mut node| {
            node.children = node.children.map(moved);
            node
        }));
        self.leaves.extend(output.leaves);
        self.roots.push(moved(output.root));
    }
}
