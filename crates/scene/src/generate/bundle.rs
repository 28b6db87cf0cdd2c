//! Bundles of fibres along a curve, as streamlines of nerve fibres form them.

use super::{STEPS, STRANDS, Unfit, count, noise::vector_noise, positive};
use crate::{Elements, Shape, direction_color};
use glam::{Quat, Vec2, Vec3};
use serde::Deserialize;
use std::f32::consts::PI;

/// Fibres that follow a cubic Bezier curve, coloured by their direction.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Bundle {
    fibres: u32,
    /// Segments of each fibre.
    steps: u32,
    /// Control points of the curve in meters.
    path: [[f32; 3]; 4],
    /// Radii of the bundle at its start, middle and end in meters.
    width: [f32; 3],
    /// Radius of each fibre in meters.
    radius: f32,
    /// Amplitude of the displacement of vertices in meters, and frequency of the noise per meter.
    #[serde(default)]
    noise: [f32; 2],
}

impl Bundle {
    pub(super) fn build(&self) -> Result<Shape, Unfit> {
        let steps = count("steps", self.steps, STEPS)?;
        let fibres = count("fibres", self.fibres, STRANDS / steps)?;
        let radius = positive("radius", self.radius)?;
        let [start, middle, end] = self.width;
        positive("width", start.min(middle).min(end))?;
        let axis = self.axis(steps);
        let mut shape = Shape::default();
        let mut segments = Vec::with_capacity(fibres as usize * steps as usize);
        for fibre in 0..fibres {
            let first = shape.positions.len();
            let place = sunflower(fibre, fibres);
            for (step, (center, frame)) in axis.iter().enumerate() {
                // The parabola through the three radii.
                let t = step as f32 / steps as f32;
                let s = 1.0 - t;
                let width = s * (s - t) * start + 4.0 * s * t * middle + t * (t - s) * end;
                let position = *center + width * (*frame * place.extend(0.0));
                let place = self.noise[1] * position;
                shape.positions.push(position + self.noise[0] * vector_noise(place));
                shape.radii.push(radius);
            }
            let last = shape.positions.len() as u32 - 1;
            segments.extend((first as u32..last).map(|vertex| [vertex, vertex + 1]));
            direction_color::append(&shape.positions[first..], &mut shape.colors);
        }
        shape.elements = Elements::Lines(segments);
        Ok(shape)
    }

    /// Returns points of the curve, each with the rotation of z to its tangent that turns least
    /// from that of the point before.
    fn axis(&self, steps: u32) -> Vec<(Vec3, Quat)> {
        let [a, b, c, d] = self.path.map(Vec3::from);
        let mut frame = Quat::IDENTITY;
        (0..=steps)
            .map(|step| {
                let t = step as f32 / steps as f32;
                let s = 1.0 - t;
                let point = s * s * s * a + 3.0 * s * t * (s * b + t * c) + t * t * t * d;
                let tangent = s * s * (b - a) + 2.0 * s * t * (c - b) + t * t * (d - c);
                if let Some(tangent) = tangent.try_normalize() {
                    frame = Quat::from_rotation_arc(frame * Vec3::Z, tangent) * frame;
                }
                (point, frame)
            })
            .collect()
    }
}

/// Returns one of `count` points that fill the unit disk evenly.
///
/// Source: H. Vogel, "A better way to construct the sunflower head", Math. Biosci. 44, 1979.
fn sunflower(index: u32, count: u32) -> Vec2 {
    let radius = ((index as f32 + 0.5) / count as f32).sqrt();
    radius * Vec2::from_angle(PI * (3.0 - 5f32.sqrt()) * index as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3Swizzles;

    const STRAIGHT: Bundle = Bundle {
        fibres: 100,
        steps: 8,
        path: [[0.0; 3], [0.0, 1.0, 0.0], [0.0, 2.0, 0.0], [0.0, 3.0, 0.0]],
        width: [0.4, 0.1, 0.2],
        radius: 0.01,
        noise: [0.0; 2],
    };

    #[test]
    fn fibres_fill_the_width_of_the_bundle() {
        let bundle = STRAIGHT.build().expect("a bundle");
        assert_eq!(bundle.elements, Elements::Lines(bundle_segments(100, 8)));
        for (step, width) in [(0, 0.4), (4, 0.1), (8, 0.2)] {
            let distances = bundle.positions.iter().skip(step).step_by(9).map(|p| p.xz().length());
            let most = distances.fold(0.0, f32::max);
            assert!((0.95 * width..=1.0001 * width).contains(&most), "{step}: {most}");
        }
        assert!(bundle.positions.iter().all(|p| (0.0..=3.0).contains(&p.y)));
        // Along y all fibres are mostly green.
        assert!(bundle.colors.iter().all(|c| c.y > c.x && c.y > c.z));
    }

    fn bundle_segments(fibres: u32, steps: u32) -> Vec<[u32; 2]> {
        let fibre = |i| (0..steps).map(move |k| [i * (steps + 1) + k, i * (steps + 1) + k + 1]);
        (0..fibres).flat_map(fibre).collect()
    }

    #[test]
    fn a_path_of_coinciding_points_has_no_nan() {
        let bundle = Bundle { path: [[1.0; 3]; 4], ..STRAIGHT }.build().expect("a bundle");
        assert!(bundle.positions.iter().all(|p| p.is_finite()));
        let back = [[0.0; 3], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]];
        let bundle = Bundle { path: back, ..STRAIGHT }.build().expect("a bundle");
        assert!(bundle.positions.iter().all(|p| p.is_finite()));
    }
}
