//! Hair made in code, and what a hair shader asks of each hit: the tangent along the strand, and
//! how far along the strand the point is.

use rotund_scene::geometry::{
    Ray,
    glam::{Vec2, Vec3},
};
use rotund_scene::{Material, Scene, SceneHit, Shape, Trees};

const STRANDS: u32 = 400;
const SEGMENTS: u32 = 24;

/// Strands that rise from a square in the plane of x and z, and wave in the wind. Vertices carry,
/// as texture coordinates, the fraction of the way from root to tip and the number of the strand.
fn hair() -> Shape {
    let (mut positions, mut radii, mut texcoords) = (Vec::new(), Vec::new(), Vec::new());
    let mut lines = Vec::new();
    for strand in 0..STRANDS {
        let root = Vec3::new((strand % 20) as f32, 0.0, (strand / 20) as f32) * 0.05;
        for step in 0..=SEGMENTS {
            let along = step as f32 / SEGMENTS as f32;
            let phase = 2.0 * along + 0.3 * strand as f32;
            // Neighbours share a vertex, so the strand is closed: caps lie inside its neighbours.
            if step < SEGMENTS {
                let vertex = positions.len() as u32;
                lines.push([vertex, vertex + 1]);
            }
            positions.push(root + Vec3::new(0.2 * along * phase.sin(), along, 0.1 * phase.cos()));
            radii.push(0.004 * (1.0 - 0.8 * along));
            texcoords.push(Vec2::new(along, strand as f32 + 0.5));
        }
    }
    Shape { texcoords, ..Shape::lines(positions, radii, lines) }
}

/// A point of a fibre.
struct Fibre {
    /// Unit tangent from root to tip.
    tangent: Vec3,
    /// Fraction of the way from root to tip.
    along: f32,
    strand: u32,
}

fn fibre(scene: &Scene, hit: &SceneHit) -> Fibre {
    // The derivative by `u`, which runs from the first end of a segment to the second. It lies on
    // the surface, so in a tapered segment it leans towards the axis. That of a vanilla line is
    // zero; there the normal is the tangent.
    let (along_segment, _) = scene.eval_tangents(hit.instance, hit.element, hit.uv);
    let tangent = along_segment
        .try_normalize()
        .unwrap_or_else(|| scene.eval_normal(hit.instance, hit.element, hit.uv));
    let texcoord = scene.eval_texcoord(hit.instance, hit.element, hit.uv);
    Fibre { tangent, along: texcoord.x, strand: texcoord.y as u32 }
}

pub(crate) fn main() {
    let mut scene = Scene::default();
    scene.add(hair(), Material { color: Vec3::new(0.4, 0.25, 0.1), ..Material::default() });
    let trees = Trees::build(&scene).expect("vertices, radii and lines belong together");
    let Shape { positions, .. } = &scene.shapes[0];

    let (mut hits, mut on_caps) = (0, 0);
    for vertex in (0..positions.len()).step_by(7) {
        let target = positions[vertex] + Vec3::new(0.0, 0.01, 0.0);
        let ray = Ray::new(Vec3::new(0.5, 0.6, 5.0), target - Vec3::new(0.5, 0.6, 5.0));
        let Some(hit) = trees.closest(&scene, &ray) else { continue };
        let fibre = fibre(&scene, &hit);
        hits += 1;

        // Each strand has `SEGMENTS` elements, and rises by 1 while `along` does.
        assert_eq!(fibre.strand, hit.element / SEGMENTS);
        assert!((fibre.along - hit.position.y).abs() < 0.004, "{} {hit:?}", fibre.along);
        assert!(fibre.tangent.dot(hit.normal).abs() < 1e-4, "the tangent is on the surface");

        let first = (hit.element / SEGMENTS * (SEGMENTS + 1) + hit.element % SEGMENTS) as usize;
        let axis = (positions[first + 1] - positions[first]).normalize();
        // At bends a sliver of a cap shows, where `u` runs over the cap.
        if fibre.tangent.dot(axis) < 0.99 {
            on_caps += 1;
        }
    }
    assert!(hits > 1000, "{hits} hits");
    assert!(on_caps * 20 < hits, "{on_caps} of {hits} hits are not along the axis");
}
