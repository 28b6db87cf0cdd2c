//! Maps of the error over a lit shape: one ray for each pixel, all parallel, from far away.

use anyhow::Result;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use rotund_geometry::{BilinearPatch, Ray, RoundedCone, Sphere};
use rotund_image::Image;
use rotund_report::embed::exact;

use crate::accuracy::{
    methods::{Measured, Method},
    tally::Collector,
};
use crate::truth::Truth;

/// Pixels along a side.
const SIDE: u32 = 128;

/// Colors of false answers, and of rays that correctly miss.
const FALSE_MISS: [u8; 3] = [0, 200, 255];
const FALSE_HIT: [u8; 3] = [120, 255, 80];
const WRONG_ROOT: [u8; 3] = [255, 80, 255];
const MISS: [u8; 3] = [250, 250, 250];

/// The maps of one method.
pub(super) struct Maps {
    pub(super) method: &'static str,
    /// Data URIs of PNG images.
    pub(super) position: String,
    pub(super) normal: String,
}

/// Ends of the two color scales as powers of ten: units of 2⁻²⁴ max(|p|, size), and degrees.
pub(super) const POSITION_SCALE: (f64, f64) = (-1.0, 5.0);
pub(super) const NORMAL_SCALE: (f64, f64) = (-7.0, 1.0);

/// A shape with an example for the maps, seen from `FROM` of its sizes away.
pub(super) trait Shown: Measured {
    const FROM: f64;
    fn shown() -> Self;
}

impl Shown for Sphere {
    const FROM: f64 = 1000.0;
    fn shown() -> Self {
        Self { center: Vec3::new(0.3, -0.2, 0.4), radius: 1.0 }
    }
}

impl Shown for RoundedCone {
    const FROM: f64 = 200.0;
    fn shown() -> Self {
        let (p0, p1) = (Vec3::new(-0.9, -0.6, 0.4), Vec3::new(1.1, 0.8, -0.3));
        Self { p0, r0: 0.8, p1, r1: 0.35 }
    }
}

impl Shown for BilinearPatch {
    const FROM: f64 = 200.0;
    fn shown() -> Self {
        Self {
            p00: Vec3::new(-1.1, -0.9, 0.9),
            p10: Vec3::new(1.0, -1.0, -0.8),
            p01: Vec3::new(-0.9, 1.1, -0.9),
            p11: Vec3::new(1.2, 0.8, 1.0),
        }
    }
}

/// Draws the maps of all methods of a shape.
pub(super) fn maps<S: Shown>(methods: &[&Method<S>]) -> Result<Vec<Maps>> {
    methods
        .par_iter()
        .map(|method| {
            let pixels = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| look(method, x, y)));
            let pixels: Vec<[[u8; 3]; 2]> = pixels.collect();
            let map = |index: usize| {
                exact(&Image::from_srgb_fn(SIDE, SIDE, |x, y| {
                    pixels[(y * SIDE + x) as usize][index]
                }))
            };
            let (position, normal) = (map(0)?, map(1)?);
            Ok(Maps { method: method.name, position, normal })
        })
        .collect()
}

/// Returns the colors of one pixel in both maps.
fn look<S: Shown>(method: &Method<S>, x: u32, y: u32) -> [[u8; 3]; 2] {
    let shape = S::shown();
    let forward = DVec3::new(0.31, 0.42, -0.85).normalize();
    let right = forward.any_orthonormal_vector();
    let up = right.cross(forward);
    let on_screen = |pixel: u32| 2.0 * (f64::from(pixel) + 0.5) / f64::from(SIDE) - 1.0;
    let aside = (right * on_screen(x) - up * on_screen(y)) * 1.1 * shape.size();
    let target = shape.center().as_dvec3() + aside;
    let origin = target - forward * (S::FROM * shape.size());
    let ray = Ray::new(origin.as_vec3(), forward.as_vec3());

    let truth = Truth::of(&shape, &ray);
    let mut collector = Collector::default();
    let right_hit = collector.add(method, &shape, &ray, &truth);
    let tally = collector.finish();
    if right_hit.is_none() {
        let color = if tally.false_misses > 0 {
            FALSE_MISS
        } else if tally.false_hits + tally.invalid > 0 {
            FALSE_HIT
        } else if tally.wrong_roots > 0 {
            WRONG_ROOT
        } else {
            MISS
        };
        return [color; 2];
    }
    let facing = truth.first().map_or(1.0, |c| c.normal.dot(-forward).abs());
    let light = 0.55 + 0.45 * facing;
    [(tally.position.max, POSITION_SCALE), (tally.normal.max, NORMAL_SCALE)].map(
        |(error, (low, high))| {
            let share = ((error.max(1e-30).log10() - low) / (high - low)).clamp(0.0, 1.0);
            scale(share).map(|channel| (f64::from(channel) * light) as u8)
        },
    )
}

/// Returns the color at a share of the scale.
fn scale(share: f64) -> [u8; 3] {
    colorous::VIRIDIS.eval_continuous(share).as_array()
}

/// Draws the color scale.
pub(super) fn scale_bar() -> Result<String> {
    Ok(exact(&Image::from_srgb_fn(256, 12, |x, _| scale(f64::from(x) / 255.0)))?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the share of the shape's pixels that have a color of false answers.
    fn false_share<S: Shown>(method: &Method<S>) -> f64 {
        let pixels = (0..SIDE).step_by(4).flat_map(|y| (0..SIDE).step_by(4).map(move |x| (x, y)));
        let colors: Vec<[u8; 3]> = pixels.map(|(x, y)| look(method, x, y)[0]).collect();
        let hit = colors.iter().filter(|c| **c != MISS).count();
        assert!(hit > colors.len() / 8, "the shape is in the picture");
        let wrong = |c: &&[u8; 3]| [FALSE_MISS, FALSE_HIT, WRONG_ROOT].contains(c);
        colors.iter().filter(wrong).count() as f64 / colors.len() as f64
    }

    #[test]
    fn own_maps_show_no_false_answer_and_a_blind_method_shows_nothing_else() {
        assert_eq!(false_share(&Sphere::METHODS[0]), 0.0);
        assert_eq!(false_share(&RoundedCone::METHODS[0]), 0.0);
        assert_eq!(false_share(&BilinearPatch::METHODS[0]), 0.0);
        let blind = Method::published("blind", |_: &Sphere, _| None);
        assert!(false_share(&blind) > 0.125);
    }
}
