//! Radii that an SWC file does not give.

use super::{
    rows::Structure,
    tree::{Node, Tree},
};
use crate::load::radius::default_radius_of_lines;
use glam::Vec3;

/// Replaces radii of zero. A node takes the radius of its parent if both have the same type, and
/// else the typical one. Returns the text of a warning if there were any.
pub(super) fn fill(tree: &mut Tree) -> Option<String> {
    let is_missing = |node: &Node| node.radius == 0.0 && !node.joined;
    let missing = tree.nodes.iter().filter(|node| is_missing(node)).count();
    if missing == 0 {
        return None;
    }
    let typical = typical(&tree.nodes);
    for &index in &tree.order {
        let node = tree.nodes[index as usize];
        if !is_missing(&node) {
            continue;
        }
        let parent = node.parent.map(|parent| tree.nodes[parent as usize]);
        let alike = parent.filter(|parent| parent.structure == node.structure);
        tree.nodes[index as usize].radius = alike.map_or(typical, |parent| parent.radius);
    }
    Some(format!(
        "{missing} nodes have no radius; they take that of their parent of the same type, or else \
         {typical}"
    ))
}

/// Returns the median radius of branches that were measured, and the default radius of lines
/// without any.
fn typical(nodes: &[Node]) -> f32 {
    let branches = nodes.iter().filter(|node| node.structure != Structure::Soma);
    median(branches.map(|node| node.radius).filter(|&radius| radius > 0.0).collect())
        .unwrap_or_else(|| {
            let positions: Vec<Vec3> = nodes.iter().map(|node| node.position).collect();
            default_radius_of_lines(&positions)
        })
}

fn median(mut values: Vec<f32>) -> Option<f32> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    Some(*values.select_nth_unstable_by(middle, f32::total_cmp).1)
}
