//! Reader of SWC files: reconstructed neurons and glia, as trees of nodes with radii.
//!
//! A row is `id type x y z radius parent`, with -1 as the parent of a root. The segment from a node
//! to its parent is a line, with the radii of both. Three things of the body of a cell, the soma,
//! differ from its branches:
//!
//! - A soma of one node is a ball. So is one of three nodes, as NeuroMorpho.Org writes it: a center
//!   and two points on opposite sides, at the distance of the radius, describe a cylinder that has
//!   the area of the ball. Any other soma, also an outline, is drawn as its segments.
//! - A segment that joins a soma and a branch has the radius of the branch at both ends. With the
//!   radius of the soma it would be a cone as wide as the cell.
//! - That segment has the type of the branch; any other has the type of the child.
//!
//! Colours change sharply where types do: the vertex is repeated there.
//!
//! Sources: R. C. Cannon, D. A. Turner, G. K. Pyapali and H. V. Wheal, "An on-line archive of
//! reconstructed hippocampal neurons", 1998; the INCF SWC specification; "Soma format
//! representation in NeuroMorpho.Org as of version 5.3".

mod radii;
mod rows;
mod tree;

use super::{error::LoadProblem, mesh::Mesh};
use glam::Vec4;
use rotund_image::linear_from_srgb_table;
use rows::Structure;
use tree::{Node, Tree};

/// Reads all trees of a file as lines, coloured by the types of the nodes.
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, LoadProblem> {
    let (mut tree, repeated) = tree::build(&rows::read(bytes)?)?;
    tree.join_three_point_somas();
    let filled = radii::fill(&mut tree);
    let mut mesh = lines(&tree);
    if repeated > 0 {
        mesh.warnings.push(format!("{repeated} nodes are repeated; each counts once"));
    }
    mesh.warnings.extend(filled);
    Ok(mesh)
}

/// Returns the colour of a type, from the palette of Okabe and Ito, which colour-blind people can
/// tell apart.
fn color(structure: Structure) -> Vec4 {
    let bytes: [u8; 3] = match structure {
        Structure::Soma => [0xf0, 0xe4, 0x42],
        Structure::Axon => [0x00, 0x72, 0xb2],
        Structure::BasalDendrite => [0xd5, 0x5e, 0x00],
        Structure::ApicalDendrite => [0xcc, 0x79, 0xa7],
        Structure::Other => [0xbb, 0xbb, 0xbb],
    };
    let [r, g, b] = bytes.map(|byte| linear_from_srgb_table()[usize::from(byte)]);
    Vec4::new(r, g, b, 1.0)
}

/// Converts a tree to lines, and nodes without any segment of their own to lines of no length,
/// which are balls.
fn lines(tree: &Tree) -> Mesh {
    let mesh = Mesh { offset: tree.offset, ..Mesh::default() };
    let mut output = Output { mesh, vertices: vec![None; tree.nodes.len()] };
    let mut has_child = vec![false; tree.nodes.len()];
    for (i, node) in tree.nodes.iter().enumerate() {
        let Some(p) = node.parent.map(|parent| parent as usize) else { continue };
        has_child[p] = true;
        if node.joined {
            continue;
        }
        let parent = &tree.nodes[p];
        // The node of the branch is drawn as itself, and that of the soma only as the end of it.
        let line = match (parent.structure, node.structure) {
            (a, b) if a == b => [output.vertex(p, parent), output.vertex(i, node)],
            (_, Structure::Soma) => {
                let end = Node { position: node.position, ..*parent };
                [output.vertex(p, parent), output.push(&end)]
            }
            (Structure::Soma, _) => {
                let start = Node { position: parent.position, ..*node };
                [output.push(&start), output.vertex(i, node)]
            }
            _ => {
                let start = Node { structure: node.structure, ..*parent };
                [output.push(&start), output.vertex(i, node)]
            }
        };
        output.mesh.lines.push(line);
    }
    for (i, node) in tree.nodes.iter().enumerate() {
        let alone = node.structure == Structure::Soma || !has_child[i];
        if output.vertices[i].is_none() && alone && !node.joined {
            let vertex = output.vertex(i, node);
            output.mesh.lines.push([vertex, vertex]);
        }
    }
    output.mesh
}

struct Output {
    mesh: Mesh,
    /// The vertex of each node that has one.
    vertices: Vec<Option<u32>>,
}

impl Output {
    /// Returns the vertex of a node, added at its first use.
    fn vertex(&mut self, index: usize, node: &Node) -> u32 {
        if let Some(vertex) = self.vertices[index] {
            return vertex;
        }
        let vertex = self.push(node);
        self.vertices[index] = Some(vertex);
        vertex
    }

    /// Adds a vertex. The number of nodes has been checked, so that twice as many have an index.
    fn push(&mut self, node: &Node) -> u32 {
        let vertex = self.mesh.positions.len() as u32;
        self.mesh.positions.push(node.position);
        self.mesh.radii.push(node.radius);
        self.mesh.colors.push(color(node.structure));
        vertex
    }
}
