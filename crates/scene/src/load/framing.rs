//! The part of space that a default camera frames: where the drawn vertices are, without outliers.

use super::{
    mesh::{FaceElements, Mesh},
    options::Up,
};
use crate::{Elements, Shape};
use glam::Vec3;
use rayon::prelude::*;
use rotund_geometry::Aabb;

/// The largest coordinate of a shape whose camera is finite: squares of larger distances overflow.
pub(super) const LARGEST: f32 = 1e15;

/// The vertices of a shape that its elements name, as balls.
pub(super) struct Drawn<'a> {
    positions: &'a [Vec3],
    /// Empty if the shape has none.
    radii: &'a [f32],
    /// Indices of the vertices; `None` for all.
    vertices: Option<Vec<u32>>,
    /// True if elements join vertices, as lines and faces do.
    pub joined: bool,
    up: Up,
}

impl<'a> Drawn<'a> {
    pub(super) fn of_shape(shape: &'a Shape, up: Up) -> Self {
        let count = shape.positions.len();
        let (vertices, joined) = match &shape.elements {
            Elements::Points(_) => (None, false),
            Elements::Lines(lines) => (named(count, lines.as_flattened()), true),
            Elements::Triangles(triangles) => (named(count, triangles.as_flattened()), true),
            Elements::Quads(quads) => (named(count, quads.as_flattened()), true),
        };
        Self { positions: &shape.positions, radii: &shape.radii, vertices, joined, up }
    }

    /// Returns the vertices of a mesh without their radii; its indices may be out of range.
    pub(super) fn of_mesh(mesh: &'a Mesh) -> Self {
        let count = mesh.positions.len();
        let faces = match &mesh.faces.elements {
            FaceElements::Triangles(triangles) => triangles.as_flattened(),
            FaceElements::Quads(quads) => quads.as_flattened(),
        };
        let lines = mesh.lines.as_flattened();
        let joined = !(lines.is_empty() && faces.is_empty());
        let elements = [lines, faces, &mesh.points].concat();
        let vertices = if elements.is_empty() { None } else { named(count, &elements) };
        Self { positions: &mesh.positions, radii: &[], vertices, joined, up: Up::Y }
    }

    /// Returns the vertices of lines.
    pub(super) fn of_lines(positions: &'a [Vec3]) -> Self {
        Self { positions, radii: &[], vertices: None, joined: true, up: Up::Y }
    }

    /// Returns at most about `most` of these vertices, evenly spread over the file.
    pub(super) fn thinned(&self, most: usize) -> Self {
        let step = self.count().div_ceil(most).max(1);
        let vertices = (0..self.count()).step_by(step).map(|index| self.vertex(index) as u32);
        Self { vertices: Some(vertices.collect()), ..*self }
    }

    pub(super) fn count(&self) -> usize {
        self.vertices.as_ref().map_or(self.positions.len(), Vec::len)
    }

    fn vertex(&self, index: usize) -> usize {
        self.vertices.as_ref().map_or(index, |vertices| vertices[index] as usize)
    }

    /// Returns the position, with y up, and the radius of a drawn vertex, 0 if the shape has none.
    pub(super) fn ball(&self, index: usize) -> (Vec3, f32) {
        let vertex = self.vertex(index);
        let radius = self.radii.get(vertex).map_or(0.0, |radius| radius.min(LARGEST));
        let Vec3 { x, y, z } = self.positions[vertex];
        match self.up {
            Up::Y => (Vec3::new(x, y, z), radius),
            Up::Z => (Vec3::new(x, z, -y), radius),
        }
    }

    pub(super) fn balls(&self) -> impl ParallelIterator<Item = (Vec3, f32)> {
        (0..self.count()).into_par_iter().map(|index| self.ball(index))
    }

    /// Returns at most about `most` vertices, evenly spread over the file.
    pub(super) fn sample(&self, most: usize) -> impl Iterator<Item = (Vec3, f32)> {
        (0..self.count()).step_by((self.count() / most).max(1)).map(|index| self.ball(index))
    }
}

/// Returns the vertices that elements name, in order; `None` if those are all.
fn named(count: usize, elements: &[u32]) -> Option<Vec<u32>> {
    let mut is_named = vec![false; count];
    for &vertex in elements {
        if let Some(is_named) = is_named.get_mut(vertex as usize) {
            *is_named = true;
        }
    }
    if is_named.iter().all(|&named| named) {
        return None;
    }
    Some((0..).zip(is_named).filter(|&(_, named)| named).map(|(vertex, _)| vertex).collect())
}

/// What a camera frames.
pub(super) struct Frame {
    /// Bounds of the balls inside.
    pub bounds: Aabb,
    /// Radius of a ball about the center of the bounds that holds them.
    pub reach: f32,
    /// The number of vertices far outside.
    pub outside: u64,
    /// The number of all drawn vertices.
    pub count: u64,
    /// The largest distance of a vertex outside from the center.
    pub farthest: f32,
}

/// Returns the frame of all shapes, without the few vertices that are so far away that the others
/// would be too small to be seen.
pub(super) fn frame(shapes: &[Drawn<'_>]) -> Frame {
    let count: usize = shapes.iter().map(Drawn::count).sum();
    let center = center(shapes);
    let distance = |(p, radius): (Vec3, f32)| p.distance(center) + radius;
    // Boxed: `fold` moves the sum with every ball.
    let zero = || Box::new([0; 256]);
    let add = |mut counts: Box<Octaves>, ball| {
        counts[octave(distance(ball))] += 1;
        counts
    };
    let sum = |mut a: Box<Octaves>, b: Box<Octaves>| {
        a.iter_mut().zip(*b).for_each(|(a, b)| *a += b);
        a
    };
    let balls = || shapes.par_iter().flat_map(Drawn::balls);
    let counts = balls().fold(zero, add).reduce(zero, sum);
    let farthest_octave = farthest_octave(&counts, shapes.iter().any(|shape| shape.joined));
    let inside = || balls().filter(|&ball| octave(distance(ball)) <= farthest_octave);

    let grow = |bounds: Aabb, (p, radius)| bounds.union(Aabb { min: p - radius, max: p + radius });
    let bounds = inside().fold(|| Aabb::EMPTY, grow).reduce(|| Aabb::EMPTY, Aabb::union);
    let middle = bounds.center();
    let reach = |ball: (Vec3, f32)| ball.0.distance(middle) + ball.1;
    let outside = counts[farthest_octave + 1..].iter().sum();
    let farthest = match outside {
        0 => 0.0,
        _ => balls().map(reach).reduce(|| 0.0, f32::max),
    };
    Frame {
        bounds,
        reach: inside().map(reach).reduce(|| 0.0, f32::max),
        outside,
        count: count as u64,
        farthest,
    }
}

/// Returns the median of each coordinate of a sample.
fn center(shapes: &[Drawn<'_>]) -> Vec3 {
    const SAMPLE: usize = 4096;
    let sample: Vec<_> = shapes.iter().flat_map(|shape| shape.sample(SAMPLE)).collect();
    let median = |axis: usize| {
        let mut values: Vec<f32> = sample.iter().map(|(p, _)| p[axis]).collect();
        values.sort_unstable_by(f32::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    Vec3::new(median(0), median(1), median(2))
}

/// Numbers of vertices by the octave of their distance from the center.
type Octaves = [u64; 256];

/// Returns the exponent of a distance, which is not negative.
fn octave(distance: f32) -> usize {
    (distance.to_bits() >> 23) as usize & 0xff
}

/// Returns the octave of the farthest vertex that is no outlier.
///
/// At most a twentieth of the vertices are outliers. Points are if they lie at least eight times as
/// far away as all others, or at most a 200th of them if they lie at least twice as far away, as
/// dust about scans and splats does. The vertices of lines and faces may lie along a long branch or
/// in a large floor, so they are outliers only beyond an empty space that ends 32 times as far away
/// as it starts.
fn farthest_octave(counts: &Octaves, joined: bool) -> usize {
    const EMPTY: usize = 5;
    let total: u64 = counts.iter().sum();
    let allowed = if total < 4 { 0 } else { total.div_ceil(20) };
    let last = counts.iter().rposition(|&count| count > 0).unwrap_or(0);
    // Without any extent, nothing is far away.
    let first = (1..=last).find(|&octave| counts[octave] > 0).unwrap_or(last);
    if !joined {
        // Returns the octave of the farthest vertices that are inside if so many are outside.
        let inside = |allowed: u64| {
            let mut outside = 0;
            let holds = |&octave: &usize| {
                outside += counts[octave];
                outside > allowed
            };
            (first..=last).rev().find(holds).unwrap_or(first)
        };
        return last.min(inside(allowed) + 3).min(inside(total / 200) + 1);
    }
    let mut farthest = last;
    let mut outside = 0;
    for octave in (first..=last).rev() {
        outside += counts[octave];
        if outside > allowed {
            break;
        }
        let below = &counts[octave.saturating_sub(EMPTY)..octave];
        if octave > first && counts[octave] > 0 && below.iter().all(|&count| count == 0) {
            farthest = octave - 1;
        }
    }
    farthest
}

/// Returns the radius of the ball about `center` that a camera frames, for contents within `reach`
/// of it. Lower bounds give a single point an extent, and keep tiny scenes within the precision of
/// `f32`.
pub(super) fn extent(center: Vec3, reach: f32) -> f32 {
    reach.max(center.abs().max_element() * 1e-3).max(1e-6)
}

#[cfg(test)]
mod tests {
    use super::{farthest_octave, octave};

    /// Returns the number of vertices, given by distances and how many there are of each, that are
    /// inside.
    fn inside(distances: &[(f32, u64)], joined: bool) -> u64 {
        let mut counts = [0; 256];
        for &(distance, count) in distances {
            counts[octave(distance)] += count;
        }
        counts[..=farthest_octave(&counts, joined)].iter().sum()
    }

    #[test]
    fn few_vertices_far_from_all_others_are_outliers() {
        type Distances = [(f32, u64)];
        let table: [(&str, &Distances, u64, u64); 12] = [
            ("nothing", &[], 0, 0),
            ("three points, since any could be the one", &[(1.0, 2), (1e4, 1)], 3, 3),
            ("one of many", &[(1.0, 200), (1e4, 1)], 200, 200),
            ("one of four", &[(1.0, 3), (1e4, 1)], 3, 3),
            ("a tenth", &[(1.0, 90), (1e4, 10)], 100, 100),
            ("at several distances", &[(1.0, 99), (100.0, 1), (1e9, 1)], 99, 99),
            ("noise at all distances", &[(1.0, 99), (4.0, 1), (15.0, 1), (60.0, 1)], 101, 102),
            ("16 times as far", &[(1.0, 99), (16.0, 1)], 99, 100),
            ("dust", &[(1.0, 1000), (2.5, 2), (5.0, 3)], 1002, 1005),
            ("more than dust", &[(1.0, 1000), (2.5, 2), (5.0, 9)], 1011, 1011),
            ("all others in one place", &[(0.0, 99), (1.0, 1)], 100, 100),
            ("infinitely far", &[(1.0, 99), (f32::INFINITY, 1)], 99, 99),
        ];
        for (why, distances, points, joined) in table {
            assert_eq!(inside(distances, false), points, "points: {why}");
            assert_eq!(inside(distances, true), joined, "lines: {why}");
        }
    }
}
