//! Division of polygons that a fan of triangles or a bilinear patch would draw wrongly: concave
//! ones, also those whose outline runs along a cut of no width to a hole and back.

use super::faces::{FaceElements, Faces};
use earcut::Earcut;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// The most corners of a polygon whose ears are cut. The time may grow with the square of the
/// number, and is some seconds for this many at random places.
pub(super) const MOST_CORNERS: u32 = 1 << 16;

/// Divides concave polygons by cutting ears, and flat concave quads into two triangles. All
/// vertices must exist. Returns how many polygons have too many corners for that.
pub(super) fn divide(faces: &mut Faces, positions: &[Vec3]) -> usize {
    let mut earcut = Earcut::new();
    let mut left = 0;
    for &[first, count] in &faces.polygons {
        let range = first as usize..(first + count) as usize;
        match &mut faces.elements {
            FaceElements::Triangles(triangles) => {
                left += usize::from(!cut_ears(&mut triangles[range], positions, &mut earcut));
            }
            FaceElements::Quads(quads) => {
                let fan = &mut quads[range];
                let mut triangles: Vec<[u32; 3]> =
                    fan.iter().map(|&[a, b, c, _]| [a, b, c]).collect();
                left += usize::from(!cut_ears(&mut triangles, positions, &mut earcut));
                for (quad, [a, b, c]) in fan.iter_mut().zip(triangles) {
                    *quad = [a, b, c, c];
                }
            }
        }
    }
    halve_quads(faces, positions);
    left
}

/// Replaces the triangles around the first corner of a polygon by others if one of them is turned
/// over; returns false if it has too many corners.
fn cut_ears(fan: &mut [[u32; 3]], positions: &[Vec3], earcut: &mut Earcut<f64>) -> bool {
    let Some(&[first, second, _]) = fan.first() else { return true };
    let at = |vertex: u32| positions[vertex as usize].as_dvec3();
    let origin = at(first);
    let area = |[a, b, c]: [u32; 3]| (at(b) - at(a)).cross(at(c) - at(a));
    let normal: DVec3 = fan.iter().map(|triangle| area(*triangle)).sum();
    // A corner on a straight edge is not worth the cut.
    let least = -1e-6 * normal.length_squared();
    if !normal.is_finite() || fan.iter().all(|triangle| area(*triangle).dot(normal) >= least) {
        return true;
    }
    let Some(normal) = normal.try_normalize() else { return true };
    if fan.len() > MOST_CORNERS as usize {
        return false;
    }
    let (x, y) = normal.any_orthonormal_pair();
    let corners: Vec<u32> =
        [first, second].into_iter().chain(fan.iter().map(|triangle| triangle[2])).collect();
    let flat = |vertex: &u32| {
        let p = at(*vertex) - origin;
        [p.dot(x), p.dot(y)]
    };
    let mut ears: Vec<u32> = Vec::new();
    earcut.earcut(corners.iter().map(flat), &[], &mut ears);
    // A polygon of n corners has n - 2 triangles, less those without area, which repeat a corner.
    let (ears, _) = ears.as_chunks::<3>();
    let triangles = ears.iter().map(|ear| {
        let [a, b, c] = ear.map(|corner| corners[corner as usize]);
        if area([a, b, c]).dot(normal) < 0.0 { [a, c, b] } else { [a, b, c] }
    });
    let mut triangles = triangles.chain(std::iter::repeat([first; 3]));
    fan.iter_mut().zip(&mut triangles).for_each(|(to, triangle)| *to = triangle);
    true
}

/// Divides flat quads with a reflex corner at this corner: as a patch, the quad would fold over
/// itself. Those that are not flat are patches as good as any.
fn halve_quads(faces: &mut Faces, positions: &[Vec3]) {
    let reflex = |quad: &[u32; 4]| {
        let corners = || quad.map(|vertex| positions[vertex as usize].as_dvec3());
        (quad[2] != quad[3]).then(|| reflex_corner(corners())).flatten()
    };
    let FaceElements::Quads(quads) = &mut faces.elements else { return };
    if !quads.par_iter().any(|quad| reflex(quad).is_some()) {
        return;
    }
    let mut sources = Vec::new();
    let mut halved = Vec::new();
    for (i, quad) in quads.iter().enumerate() {
        sources.push(i);
        let Some(corner) = reflex(quad) else {
            halved.push(*quad);
            continue;
        };
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| quad[(corner + k) % 4]);
        halved.extend([[a, b, c, c], [a, c, d, d]]);
        sources.push(i);
    }
    *quads = halved;
    if !faces.colors.is_empty() {
        faces.colors = sources.iter().map(|&i| faces.colors[i]).collect();
    }
    if !faces.materials.is_empty() {
        faces.materials = sources.iter().map(|&i| faces.materials[i]).collect();
    }
    // Their triangles have moved, and are final.
    faces.polygons.clear();
}

/// Returns the reflex corner of a flat quad, if it has one.
fn reflex_corner(p: [DVec3; 4]) -> Option<usize> {
    // How far corners of a flat quad may lie apart from its plane, in units of its diagonals: files
    // with few decimals round them.
    const FLAT: f64 = 1e-3;
    let normal = (p[2] - p[0]).cross(p[3] - p[1]);
    let turns = |i: usize| {
        let (before, at, after) = (p[(i + 3) % 4], p[i], p[(i + 1) % 4]);
        (at - before).cross(after - at).dot(normal) < -1e-6 * normal.length_squared()
    };
    let mut reflex = (0..4).filter(|&i| turns(i));
    let corner = reflex.next().filter(|_| reflex.next().is_none())?;
    // Both ends of a diagonal are equally high above the plane of the normal.
    let height = (p[1] - p[0]).dot(normal.normalize()).abs();
    let size = p[2].distance(p[0]).max(p[3].distance(p[1]));
    (height <= FLAT * size).then_some(corner)
}
