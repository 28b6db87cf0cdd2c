//! Subdivision surfaces.
//!
//! Source: E. Catmull, J. Clark, "Recursively generated B-spline surfaces on arbitrary topological
//! meshes", Computer-Aided Design 10(6), 1978; borders are B-spline curves.

use crate::{Elements, Pixels, Shape, Texture};
use glam::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Parameters of a subdivision.
#[derive(Clone, Copy, Debug)]
pub(super) struct Subdivision<'a> {
    pub levels: u32,
    /// Smooth the surface by the rule of Catmull and Clark; otherwise only split faces.
    pub catmull_clark: bool,
    /// Compute vertex normals.
    pub smooth: bool,
    /// Displacement in meters along the normal for a value of 1, and its texture. The value is the
    /// mean of the four channels, minus 1/2 for bytes. As in yocto-gl the mean includes alpha, so
    /// grey from 0 to 1 displaces by -1/4 to 1/2.
    pub displacement: Option<(f32, &'a Texture)>,
}

/// The most quads of a subdivided shape.
pub(super) const MOST_QUADS: u64 = 1 << 23;

/// Returns the number of quads after subdivision; `None` if the shape has no faces.
pub(super) fn quads_after(shape: &Shape, levels: u32) -> Option<u64> {
    let corners = match &shape.elements {
        Elements::Triangles(triangles) => 3 * triangles.len() as u64,
        Elements::Quads(quads) => 4 * quads.len() as u64,
        Elements::Points(_) | Elements::Lines(_) => return None,
    };
    let more = 4_u64.checked_pow(levels.saturating_sub(1)).unwrap_or(u64::MAX);
    Some(if levels == 0 { corners / 4 } else { corners.saturating_mul(more) })
}

/// Points and polygons over them: the positions of a mesh or its texture coordinates. Both have the
/// same polygons, but those of texture coordinates are disconnected at seams.
struct Net {
    points: Vec<Vec3>,
    faces: Vec<Face>,
}

/// A polygon of three or four corners.
#[derive(Clone, Copy)]
struct Face {
    corners: u32,
    points: [u32; 4],
}

impl Face {
    fn corners(&self) -> &[u32] {
        &self.points[..self.corners as usize]
    }
}

/// How the points of a net move when its faces are split.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Rule {
    /// Points stay.
    Split,
    /// The rule of Catmull and Clark; borders become B-spline curves.
    Smooth,
    /// The same in the interior; borders stay, so that islands of a texture keep their outlines.
    SmoothInside,
}

struct Surface {
    positions: Net,
    /// Texture coordinates of the same faces; empty if there are none.
    texcoords: Net,
}

/// Subdivides a shape into quads. Vertices at the same position are merged, so that seams of
/// texture coordinates stay closed. Vertex colours are dropped, as in yocto-gl.
///
/// Without levels and displacement the mesh keeps its vertices and normals.
pub(super) fn subdivide(shape: &Shape, subdivision: &Subdivision<'_>) -> Shape {
    if subdivision.levels == 0 && subdivision.displacement.is_none() {
        let elements = match &shape.elements {
            Elements::Triangles(triangles) => {
                Elements::Quads(triangles.iter().map(|&[a, b, c]| [a, b, c, c]).collect())
            }
            elements => elements.clone(),
        };
        return Shape { elements, colors: Vec::new(), ..shape.clone() };
    }
    let mut surface = weld(shape);
    let (positions, texcoords) = if subdivision.catmull_clark {
        (Rule::Smooth, Rule::SmoothInside)
    } else {
        (Rule::Split, Rule::Split)
    };
    for _ in 0..subdivision.levels {
        surface.positions = surface.positions.split(positions);
        surface.texcoords = surface.texcoords.split(texcoords);
    }
    if let Some((height, texture)) = subdivision.displacement {
        surface.displace(height, texture);
    }
    let kept = subdivision.levels == 0 && !shape.normals.is_empty();
    surface.into_shape(shape, subdivision.smooth || kept)
}

fn weld(shape: &Shape) -> Surface {
    let mut places = HashMap::new();
    let mut positions = Net { points: Vec::new(), faces: Vec::new() };
    let welded: Vec<u32> = shape
        .positions
        .iter()
        .map(|&p| {
            // Adding zero turns -0 into +0.
            *places.entry((p + 0.0).to_array().map(f32::to_bits)).or_insert_with(|| {
                positions.points.push(p);
                positions.points.len() as u32 - 1
            })
        })
        .collect();
    let mut places = HashMap::new();
    let mut texcoords = Net { points: Vec::new(), faces: Vec::new() };
    let of_texture: Vec<u32> = welded
        .iter()
        .zip(&shape.texcoords)
        .map(|(&place, &uv)| {
            *places.entry((place, (uv + 0.0).to_array().map(f32::to_bits))).or_insert_with(|| {
                texcoords.points.push(uv.extend(0.0));
                texcoords.points.len() as u32 - 1
            })
        })
        .collect();
    let mut add = |vertices: [u32; 4]| {
        let corners = if vertices[2] == vertices[3] { 3 } else { 4 };
        let face = |of: &[u32]| Face { corners, points: vertices.map(|v| of[v as usize]) };
        positions.faces.push(face(&welded));
        if !of_texture.is_empty() {
            texcoords.faces.push(face(&of_texture));
        }
    };
    match &shape.elements {
        Elements::Triangles(triangles) => triangles.iter().for_each(|&[a, b, c]| add([a, b, c, c])),
        Elements::Quads(quads) => quads.iter().copied().for_each(add),
        Elements::Points(_) | Elements::Lines(_) => {}
    }
    Surface { positions, texcoords }
}

#[derive(Clone, Copy, Default)]
struct Mean {
    sum: Vec3,
    count: u32,
}

impl Mean {
    fn add(&mut self, point: Vec3) {
        self.sum += point;
        self.count += 1;
    }

    fn get(&self) -> Vec3 {
        self.sum / self.count.max(1) as f32
    }
}

/// An edge and its adjacent faces.
struct Edge {
    ends: [u32; 2],
    faces: Mean,
}

impl Net {
    /// Splits each quad into four quads, each triangle into three.
    fn split(&self, rule: Rule) -> Self {
        // The edge from each corner of each face to the next. The fourth edge of a triangle is not
        // used.
        let sides = self.faces.iter().flat_map(|face| {
            let corners = face.corners();
            (0..4).map(|i| {
                let (a, b) = (corners[i % corners.len()], corners[(i + 1) % corners.len()]);
                u64::from(a.min(b)) << 32 | u64::from(a.max(b))
            })
        });
        let (edge_of, edges) = number(sides.collect());
        let mut edges: Vec<Edge> = edges
            .iter()
            .map(|&key| Edge { ends: [(key >> 32) as u32, key as u32], faces: Mean::default() })
            .collect();
        let mut centers = Vec::with_capacity(self.faces.len());
        for (face, sides) in self.faces.iter().zip(edge_of.as_chunks::<4>().0) {
            let mut center = Mean::default();
            face.corners().iter().for_each(|&v| center.add(self.points[v as usize]));
            centers.push(center.get());
            for &side in &sides[..face.corners().len()] {
                edges[side as usize].faces.add(center.get());
            }
        }
        let middle = |edge: &Edge| {
            0.5 * (self.points[edge.ends[0] as usize] + self.points[edge.ends[1] as usize])
        };
        let mut points = match rule {
            Rule::Split => self.points.clone(),
            _ => self.smoothed(&edges, &centers, middle, rule),
        };
        let first_middle = points.len() as u32;
        points.extend(edges.iter().map(|edge| {
            // An edge with a single face is a border.
            if rule != Rule::Split && edge.faces.count > 1 {
                0.5 * (middle(edge) + edge.faces.get())
            } else {
                middle(edge)
            }
        }));
        let first_center = points.len() as u32;
        points.extend(centers);
        let mut faces = Vec::with_capacity(4 * self.faces.len());
        for ((face, sides), center) in
            self.faces.iter().zip(edge_of.as_chunks::<4>().0).zip(first_center..)
        {
            let n = face.corners().len();
            let middle_of = |i: usize| first_middle + sides[i % n];
            faces.extend((0..n).map(|i| Face {
                corners: 4,
                points: [face.points[i], middle_of(i), center, middle_of(i + n - 1)],
            }));
        }
        Self { points, faces }
    }

    /// Moves the original points: to `(F + 2 R + (n - 3) P) / n` in the interior, by a cubic
    /// B-spline on borders.
    fn smoothed(
        &self,
        edges: &[Edge],
        centers: &[Vec3],
        middle: impl Fn(&Edge) -> Vec3,
        rule: Rule,
    ) -> Vec<Vec3> {
        let none = vec![Mean::default(); self.points.len()];
        let (mut faces, mut middles, mut borders) = (none.clone(), none.clone(), none);
        for (face, &center) in self.faces.iter().zip(centers) {
            face.corners().iter().for_each(|&v| faces[v as usize].add(center));
        }
        for edge in edges {
            for end in edge.ends {
                middles[end as usize].add(middle(edge));
                if edge.faces.count < 2 {
                    borders[end as usize].add(middle(edge));
                }
            }
        }
        let place = |(v, &p): (usize, &Vec3)| {
            let n = faces[v].count as f32;
            match borders[v].count {
                0 if n > 0.0 => (faces[v].get() + 2.0 * middles[v].get() + (n - 3.0) * p) / n,
                2 if rule == Rule::Smooth => 0.5 * (p + borders[v].get()),
                // Unconnected points, fixed borders and crossings of borders stay.
                _ => p,
            }
        };
        self.points.iter().enumerate().map(place).collect()
    }

    /// Computes vertex normals: the normalized sum of the normals of adjacent faces, weighted by
    /// area.
    fn normals(&self) -> Vec<Vec3> {
        let mut normals = vec![Vec3::ZERO; self.points.len()];
        for face in &self.faces {
            let [a, b, c, d] = face.points.map(|v| self.points[v as usize]);
            let normal = (c - a).cross(d - b);
            face.corners().iter().for_each(|&v| normals[v as usize] += normal);
        }
        normals.iter().map(|normal| normal.normalize_or_zero()).collect()
    }
}

impl Surface {
    fn displace(&mut self, height: f32, texture: &Texture) {
        let zero = match texture.pixels {
            Pixels::Bytes(_) | Pixels::Words(_) | Pixels::TiledBytes(_) => 0.5,
            Pixels::Floats(_) | Pixels::SharedExponent(_) => 0.0,
        };
        let mut heights = vec![Mean::default(); self.positions.points.len()];
        for (face, of_texture) in self.positions.faces.iter().zip(&self.texcoords.faces) {
            for (&vertex, &uv) in face.points.iter().zip(&of_texture.points) {
                // Use the mean height at seams of the texture, so that the surface stays closed.
                let uv = self.texcoords.points[uv as usize].truncate();
                let height = texture.data(uv).element_sum() / 4.0;
                heights[vertex as usize].add(Vec3::splat(height));
            }
        }
        let normals = self.positions.normals();
        for ((position, normal), own) in self.positions.points.iter_mut().zip(normals).zip(&heights)
        {
            *position += normal * (height * (own.get().x - zero));
        }
    }

    fn into_shape(self, control: &Shape, smooth: bool) -> Shape {
        let normals = if smooth { self.positions.normals() } else { Vec::new() };
        let mut shape = Shape {
            name: control.name.clone(),
            method: control.method,
            overlap: control.overlap,
            elements: Elements::Quads(Vec::new()),
            positions: Vec::new(),
            normals: Vec::new(),
            texcoords: Vec::new(),
            colors: Vec::new(),
            radii: Vec::new(),
        };
        // One vertex for each pair of a point and a texture coordinate.
        let corners = self.positions.faces.iter().enumerate().flat_map(|(f, face)| {
            let of_texture = self.texcoords.faces.get(f).map_or([0; 4], |face| face.points);
            face.points
                .into_iter()
                .zip(of_texture)
                .map(|(v, uv)| u64::from(v) << 32 | u64::from(uv))
        });
        let (vertices, keys) = number(corners.collect());
        let points = || keys.iter().map(|&key| (key >> 32) as usize);
        shape.positions = points().map(|v| self.positions.points[v]).collect();
        if smooth {
            shape.normals = points().map(|v| normals[v]).collect();
        }
        if !self.texcoords.faces.is_empty() {
            let uv = |&key: &u64| self.texcoords.points[key as u32 as usize].truncate();
            shape.texcoords = keys.iter().map(uv).collect();
        }
        shape.elements = Elements::Quads(vertices.as_chunks().0.to_vec());
        shape
    }
}

/// Numbers the distinct keys from 0; returns the number of each key, and the distinct keys in
/// order.
fn number(keys: Vec<u64>) -> (Vec<u32>, Vec<u64>) {
    let mut sorted: Vec<(u64, u32)> = keys.into_iter().zip(0..).collect();
    sorted.par_sort_unstable();
    let mut numbers = vec![0; sorted.len()];
    let mut distinct = Vec::new();
    for (key, at) in sorted {
        if distinct.last() != Some(&key) {
            distinct.push(key);
        }
        numbers[at as usize] = distinct.len() as u32 - 1;
    }
    (numbers, distinct)
}
