//! Subdivision surfaces.
//!
//! Source: E. Catmull, J. Clark, "Recursively generated B-spline surfaces on arbitrary topological
//! meshes", Computer-Aided Design 10(6), 1978; borders are B-spline curves.

use crate::{Elements, Shape, Texture};
use glam::{Vec2, Vec3};
use std::collections::HashMap;

/// What to do with a control mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Subdivision<'a> {
    pub levels: u32,
    /// Smooth the surface rather than only split it.
    pub catmull_clark: bool,
    /// Normals at vertices, rather than none.
    pub smooth: bool,
    /// In meters along the normal, times the mean of the colour of the texture; bytes count from -1/2.
    pub displacement: Option<(f32, &'a Texture)>,
}

/// The most quads that a subdivision may have.
pub(super) const MOST_QUADS: u64 = 1 << 25;

/// How many quads there will be; `None` if the shape has no faces.
pub(super) fn quads_after(shape: &Shape, levels: u32) -> Option<u64> {
    let corners = match &shape.elements {
        Elements::Triangles(triangles) => 3 * triangles.len() as u64,
        Elements::Quads(quads) => 4 * quads.len() as u64,
        Elements::Points(_) | Elements::Lines(_) => return None,
    };
    let more = 4_u64.checked_pow(levels.saturating_sub(1)).unwrap_or(u64::MAX);
    Some(if levels == 0 { corners / 4 } else { corners.saturating_mul(more) })
}

/// A polygon: three or four corners, each a welded position and a texture coordinate of its own.
#[derive(Clone, Copy)]
struct Face {
    corners: usize,
    positions: [u32; 4],
    texcoords: [Vec2; 4],
}

struct Surface {
    positions: Vec<Vec3>,
    faces: Vec<Face>,
}

/// The subdivided shape. Vertices in the same place are one, so seams of texture coordinates stay
/// closed; texture coordinates are interpolated in each face.
pub(super) fn subdivide(shape: &Shape, subdivision: &Subdivision<'_>) -> Shape {
    let mut surface = weld(shape);
    for _ in 0..subdivision.levels {
        surface = surface.split(subdivision.catmull_clark);
    }
    if let Some((height, texture)) = subdivision.displacement {
        surface.displace(height, texture);
    }
    surface.into_shape(shape, subdivision.smooth)
}

fn weld(shape: &Shape) -> Surface {
    let mut places = HashMap::new();
    let mut positions = Vec::new();
    let welded: Vec<u32> = shape
        .positions
        .iter()
        .map(|&p| {
            // Adding zero makes one of the two zeros.
            *places.entry((p + 0.0).to_array().map(f32::to_bits)).or_insert_with(|| {
                positions.push(p);
                positions.len() as u32 - 1
            })
        })
        .collect();
    let texcoord = |v: u32| shape.texcoords.get(v as usize).copied().unwrap_or_default();
    let face = |vertices: [u32; 4]| Face {
        corners: if vertices[2] == vertices[3] { 3 } else { 4 },
        positions: vertices.map(|v| welded[v as usize]),
        texcoords: vertices.map(texcoord),
    };
    let faces = match &shape.elements {
        Elements::Triangles(triangles) => {
            triangles.iter().map(|&[a, b, c]| face([a, b, c, c])).collect()
        }
        Elements::Quads(quads) => quads.iter().map(|&quad| face(quad)).collect(),
        Elements::Points(_) | Elements::Lines(_) => Vec::new(),
    };
    Surface { positions, faces }
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

/// An edge, and the faces beside it.
struct Edge {
    ends: [u32; 2],
    faces: Mean,
}

impl Surface {
    fn split(&self, smooth: bool) -> Self {
        let vertices = self.positions.len() as u32;
        let mut edges: Vec<Edge> = Vec::new();
        let mut edge_of = HashMap::new();
        let mut centers = Vec::new();
        for face in &self.faces {
            let corners = &face.positions[..face.corners];
            let mut center = Mean::default();
            corners.iter().for_each(|&v| center.add(self.positions[v as usize]));
            centers.push(center.get());
            for (i, &a) in corners.iter().enumerate() {
                let b = corners[(i + 1) % corners.len()];
                let edge = *edge_of.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    edges.push(Edge { ends: [a, b], faces: Mean::default() });
                    edges.len() as u32 - 1
                });
                edges[edge as usize].faces.add(center.get());
            }
        }
        let middle = |edge: &Edge| {
            0.5 * (self.positions[edge.ends[0] as usize] + self.positions[edge.ends[1] as usize])
        };
        let mut positions =
            if smooth { self.smoothed(&edges, &centers, middle) } else { self.positions.clone() };
        positions.extend(edges.iter().map(|edge| {
            // An edge of one face is a border.
            if smooth && edge.faces.count > 1 {
                0.5 * (middle(edge) + edge.faces.get())
            } else {
                middle(edge)
            }
        }));
        let first_center = positions.len() as u32;
        positions.extend(centers);
        let mut faces = Vec::new();
        for (index, face) in self.faces.iter().enumerate() {
            let n = face.corners;
            let middle_of = |i: usize| {
                let (a, b) = (face.positions[i % n], face.positions[(i + 1) % n]);
                let texcoord = 0.5 * (face.texcoords[i % n] + face.texcoords[(i + 1) % n]);
                (vertices + edge_of[&(a.min(b), a.max(b))], texcoord)
            };
            let sum: Vec2 = face.texcoords[..n].iter().sum();
            let center = (first_center + index as u32, sum / n as f32);
            for i in 0..n {
                let corner = (face.positions[i], face.texcoords[i]);
                let around = [corner, middle_of(i), center, middle_of(i + n - 1)];
                faces.push(Face {
                    corners: 4,
                    positions: around.map(|c| c.0),
                    texcoords: around.map(|c| c.1),
                });
            }
        }
        Self { positions, faces }
    }

    /// Where the old vertices go: `(F + 2 R + (n - 3) P) / n` inside, a cubic B-spline on borders.
    fn smoothed(
        &self,
        edges: &[Edge],
        centers: &[Vec3],
        middle: impl Fn(&Edge) -> Vec3,
    ) -> Vec<Vec3> {
        let none = vec![Mean::default(); self.positions.len()];
        let (mut faces, mut middles, mut borders) = (none.clone(), none.clone(), none);
        for (face, &center) in self.faces.iter().zip(centers) {
            face.positions[..face.corners].iter().for_each(|&v| faces[v as usize].add(center));
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
                2 => 0.5 * (p + borders[v].get()),
                // Loose, or where borders cross: it stays.
                _ => p,
            }
        };
        self.positions.iter().enumerate().map(place).collect()
    }

    /// Sums of the normals of the faces around each vertex, by area.
    fn normals(&self) -> Vec<Vec3> {
        let mut normals = vec![Vec3::ZERO; self.positions.len()];
        for face in &self.faces {
            let [a, b, c, d] = face.positions.map(|v| self.positions[v as usize]);
            let normal = (c - a).cross(d - b);
            face.positions[..face.corners].iter().for_each(|&v| normals[v as usize] += normal);
        }
        normals.iter().map(|normal| normal.normalize_or_zero()).collect()
    }

    fn displace(&mut self, height: f32, texture: &Texture) {
        let zero = if matches!(texture.pixels, crate::Pixels::Bytes(_)) { 0.5 } else { 0.0 };
        let mut heights = vec![Mean::default(); self.positions.len()];
        for face in &self.faces {
            for (&vertex, &texcoord) in face.positions.iter().zip(&face.texcoords) {
                // The mean where a seam of the texture meets: the surface stays closed.
                heights[vertex as usize].add(texture.data(texcoord).truncate());
            }
        }
        let normals = self.normals();
        for (v, position) in self.positions.iter_mut().enumerate() {
            *position += normals[v] * (height * (heights[v].get().element_sum() / 3.0 - zero));
        }
    }

    fn into_shape(self, control: &Shape, smooth: bool) -> Shape {
        let normals = if smooth { self.normals() } else { Vec::new() };
        let textured = !control.texcoords.is_empty();
        let mut shape = Shape {
            name: control.name.clone(),
            method: control.method,
            elements: Elements::Quads(Vec::new()),
            positions: Vec::new(),
            normals: Vec::new(),
            texcoords: Vec::new(),
            colors: Vec::new(),
            radii: Vec::new(),
        };
        let mut vertices = HashMap::new();
        let quads = self.faces.iter().map(|face| {
            std::array::from_fn(|i| {
                let (v, uv) = (face.positions[i] as usize, face.texcoords[i]);
                *vertices.entry((v, uv.to_array().map(f32::to_bits))).or_insert_with(|| {
                    shape.positions.push(self.positions[v]);
                    if smooth {
                        shape.normals.push(normals[v]);
                    }
                    if textured {
                        shape.texcoords.push(uv);
                    }
                    shape.positions.len() as u32 - 1
                })
            })
        });
        shape.elements = Elements::Quads(quads.collect());
        shape
    }
}
