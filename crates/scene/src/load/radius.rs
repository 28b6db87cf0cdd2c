//! The radius of points and lines whose file has none.

use super::{
    framing::{self, Drawn, extent, frame},
    mesh::{DEFAULT_RADIUS, Mesh},
};
use glam::Vec3;
use rayon::prelude::*;

/// Returns half the typical distance between neighbours, so that spheres just touch, within bounds
/// that keep lines apart and both visible; see [`bounded`].
pub(super) fn default_radius(mesh: &Mesh) -> f32 {
    bounded(&Drawn::of_mesh(mesh))
}

/// Returns the default radius of lines between these positions.
pub(super) fn default_radius_of_lines(positions: &[Vec3]) -> f32 {
    bounded(&Drawn::of_lines(positions))
}

/// Returns the default radius of these points or, if `joined`, lines.
///
/// A picture of 720 x 480 pixels shows about 400 of them along the diameter of what it frames. A
/// point is at least a pixel wide and at most an eighth of that diameter, a line at least 1.3
/// pixels and at most a 50th: the edges of a wire cube do not fill it.
fn bounded(drawn: &Drawn<'_>) -> f32 {
    let framed = frame(&[drawn.thinned(1 << 16)]);
    let center = framed.bounds.center();
    if framed.count == 0 || framed.reach.is_nan() || framed.reach <= 0.0 {
        return extent(center, DEFAULT_RADIUS).min(framing::LARGEST);
    }
    let whole = extent(center, framed.reach).min(framing::LARGEST);
    let (least, most) = if drawn.joined { (300.0, 50.0) } else { (400.0, 8.0) };
    let spacing = half_spacing(drawn).unwrap_or(DEFAULT_RADIUS);
    spacing.clamp(whole / least, whole / most)
}

/// Returns half the median distance to the nearest neighbour over a sample.
fn half_spacing(drawn: &Drawn<'_>) -> Option<f32> {
    const SAMPLE: usize = 33;
    // A block stays in the cache while it is compared with the whole sample.
    const BLOCK: usize = 1 << 10;
    let sample: Vec<Vec3> = drawn.sample(SAMPLE).map(|(p, _)| p).collect();
    let count = drawn.count();
    let nearest = |block: usize| {
        let range = block * BLOCK..((block + 1) * BLOCK).min(count);
        let columns = [0, 1, 2]
            .map(|axis| range.clone().map(|index| drawn.ball(index).0[axis]).collect::<Vec<f32>>());
        sample.iter().map(|p| nearest_square(*p, &columns)).collect::<Vec<_>>()
    };
    let less = |a: Vec<f32>, b: Vec<f32>| a.iter().zip(b).map(|(a, b)| a.min(b)).collect();
    let blocks = (0..count.div_ceil(BLOCK)).into_par_iter();
    let mut nearest = blocks.map(nearest).reduce_with(less)?;
    nearest.retain(|square| square.is_finite());
    nearest.sort_unstable_by(f32::total_cmp);
    nearest.get(nearest.len() / 2).map(|square| 0.5 * square.sqrt())
}

/// Returns the squared distance from `p` to the nearest of the points, given by their coordinates,
/// that does not coincide with `p`; infinite if there is none.
fn nearest_square(p: Vec3, [x, y, z]: &[Vec<f32>; 3]) -> f32 {
    // One minimum for each lane of a register, so that the loop vectorizes.
    const LANES: usize = 8;
    let mut nearest = [f32::INFINITY; LANES];
    let (x, y, z) = (x.chunks(LANES), y.chunks(LANES), z.chunks(LANES));
    for ((x, y), z) in x.zip(y).zip(z) {
        for (((nearest, x), y), z) in nearest.iter_mut().zip(x).zip(y).zip(z) {
            let (x, y, z) = (x - p.x, y - p.y, z - p.z);
            let square = x * x + y * y + z * z;
            let square = if square > 0.0 { square } else { f32::INFINITY };
            *nearest = if square < *nearest { square } else { *nearest };
        }
    }
    nearest.into_iter().fold(f32::INFINITY, f32::min)
}
