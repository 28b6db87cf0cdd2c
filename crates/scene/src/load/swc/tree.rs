//! The nodes of an SWC file with their parents by index, checked for loops.

use super::rows::{Row, Structure};
use crate::load::{error::LoadProblem, far};
use glam::{DVec3, Vec3};
use std::collections::{HashMap, hash_map::Entry};

#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub structure: Structure,
    pub position: Vec3,
    /// Zero if it was not measured.
    pub radius: f32,
    /// `None` for a root.
    pub parent: Option<u32>,
    /// True if the node only describes the ball about its parent.
    pub joined: bool,
}

/// All trees of a file.
#[derive(Debug)]
pub(super) struct Tree {
    pub nodes: Vec<Node>,
    /// What has been subtracted from all positions of the file.
    pub offset: DVec3,
    /// The indices of all nodes, each after that of its parent.
    pub order: Vec<u32>,
}

/// Finds the parents of all rows. Returns the tree and how many rows repeat an earlier one, which
/// are left out.
pub(super) fn build(rows: &[Row]) -> Result<(Tree, usize), LoadProblem> {
    // Each node may have a second vertex, which needs an index too.
    let limit = u64::from(u32::MAX / 2);
    if rows.len() as u64 > limit {
        return Err(LoadProblem::TooMany { what: "nodes", count: rows.len() as u64, limit });
    }
    let mut kept: Vec<&Row> = Vec::with_capacity(rows.len());
    let mut index_of = HashMap::with_capacity(rows.len());
    for row in rows {
        match index_of.entry(row.id) {
            Entry::Vacant(vacant) => {
                vacant.insert(kept.len() as u32);
                kept.push(row);
            }
            Entry::Occupied(earlier) => {
                let first = kept[*earlier.get() as usize];
                if *first != (Row { line: first.line, ..*row }) {
                    let (id, line) = (row.id, first.line);
                    return Err(at(
                        row,
                        format!(
                            "node {id} is not the node {id} of line {line}; give each its own id"
                        ),
                    ));
                }
            }
        }
    }
    let positions: Vec<DVec3> = kept.iter().map(|row| row.position).collect();
    let (positions, offset) = far::to_single(&positions);
    let node = |(row, &position): (&&Row, &Vec3)| {
        let index = |id| {
            index_of.get(&id).copied().ok_or_else(|| {
                at(row, format!(
                    "the parent of node {} is node {id}, which no line describes; add it, or write \
                     -1 for a root",
                    row.id
                ))
            })
        };
        let &Row { structure, radius, .. } = *row;
        let parent = row.parent.map(index).transpose()?;
        Ok(Node { structure, position, radius, parent, joined: false })
    };
    let nodes: Vec<Node> = kept.iter().zip(&positions).map(node).collect::<Result<_, _>>()?;
    let order = parents_first(&nodes).map_err(|index| {
        let row = kept[index as usize];
        at(row, format!(
            "node {} is an ancestor of itself, expected a tree; write -1 as the parent of its root",
            row.id
        ))
    })?;
    Ok((Tree { nodes, offset, order }, rows.len() - kept.len()))
}

fn at(row: &Row, problem: String) -> LoadProblem {
    LoadProblem::SwcLine { line: row.line, problem }
}

/// Returns all indices, parents first, or the index of a node that is an ancestor of itself. Each
/// node is walked over twice, once up to the root and once back.
fn parents_first(nodes: &[Node]) -> Result<Vec<u32>, u32> {
    #[derive(Clone, Copy, PartialEq)]
    enum State {
        New,
        OnPath,
        Done,
    }
    let mut states = vec![State::New; nodes.len()];
    let mut order = Vec::with_capacity(nodes.len());
    let mut path = Vec::new();
    for start in 0..nodes.len() as u32 {
        let mut next = Some(start);
        while let Some(index) = next {
            match states[index as usize] {
                State::New => {}
                State::OnPath => return Err(index),
                State::Done => break,
            }
            states[index as usize] = State::OnPath;
            path.push(index);
            next = nodes[index as usize].parent;
        }
        while let Some(index) = path.pop() {
            states[index as usize] = State::Done;
            order.push(index);
        }
    }
    Ok(order)
}

impl Tree {
    /// Joins somas of three nodes into balls: a root, and two nodes without children on opposite
    /// sides at the distance of its radius. Radii that were not measured are taken from there.
    pub(super) fn join_three_point_somas(&mut self) {
        let mut child_counts = vec![0_u32; self.nodes.len()];
        let mut sides: HashMap<u32, Vec<u32>> = HashMap::new();
        for (node, index) in self.nodes.iter().zip(0..) {
            let Some(parent) = node.parent else { continue };
            child_counts[parent as usize] += 1;
            let root = &self.nodes[parent as usize];
            let is_body = [root, node].iter().all(|node| node.structure == Structure::Soma);
            if is_body && root.parent.is_none() {
                sides.entry(parent).or_default().push(index);
            }
        }
        for (root, sides) in sides {
            let [a, b] = sides[..] else { continue };
            let is_end = |index| child_counts[index as usize] == 0;
            let nodes = [root, a, b].map(|index| self.nodes[index as usize]);
            let Some(radius) = ball(&nodes).filter(|_| is_end(a) && is_end(b)) else { continue };
            self.nodes[root as usize].radius = radius;
            for side in [a, b] {
                self.nodes[side as usize].joined = true;
            }
        }
    }
}

/// Returns the radius of the ball that a root and two more nodes describe.
fn ball(&[root, a, b]: &[Node; 3]) -> Option<f32> {
    // Files round coordinates to hundredths.
    const ROUNDING: f32 = 0.05;
    let (a_side, b_side) = (a.position - root.position, b.position - root.position);
    let distance = 0.5 * (a_side.length() + b_side.length());
    let radius = if root.radius > 0.0 { root.radius } else { distance };
    let near = |x: f32, y: f32| (x - y).abs() <= ROUNDING * radius;
    let is_radius = |node: Node| node.radius == 0.0 || near(node.radius, radius);
    let fits = near(a_side.length(), radius)
        && near(b_side.length(), radius)
        && (a_side + b_side).length() <= ROUNDING * radius
        && is_radius(a)
        && is_radius(b);
    (fits && radius > 0.0).then_some(radius)
}
