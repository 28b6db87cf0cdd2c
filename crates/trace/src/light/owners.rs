//! Emitters with a part of their surface in common.
//!
//! Consecutive lines share the ball at their joint, and a scene may have an element twice, such as
//! both sides of a face. A ray that meets such a surface hits the first element that has it, in the
//! order of instances and elements. So only that element may be sampled there: the light would
//! count twice otherwise.

use super::round::Ball;
use glam::{Vec3, Vec4};
use std::collections::HashSet;
use std::hash::{DefaultHasher, Hash, Hasher};

/// The surfaces that have an emitter, as hashes of 64 bits. Two of ten million surfaces have the
/// same hash by chance once in 300,000 scenes; the second is then found by BSDF samples alone.
#[derive(Default)]
pub(super) struct Owners(HashSet<u64>);

impl Owners {
    /// Records a ball; returns false if it has an emitter already.
    pub(super) fn take_ball(&mut self, ball: &Ball) -> bool {
        self.take([of_ball(ball)])
    }

    /// Records a line between two balls; returns false if it has an emitter already, in either
    /// direction.
    pub(super) fn take_line(&mut self, balls: &[Ball; 2]) -> bool {
        self.take(balls.each_ref().map(of_ball))
    }

    /// Records a face; returns false if it has an emitter already, from either side.
    pub(super) fn take_face<const N: usize>(&mut self, corners: [Vec3; N]) -> bool {
        self.take(corners.map(|corner| corner.extend(0.0)))
    }

    fn take<const N: usize>(&mut self, points: [Vec4; N]) -> bool {
        // The sum makes positive zeros of negative ones.
        let mut bits = points.map(|point| (point + 0.0).to_array().map(f32::to_bits));
        bits.sort_unstable();
        let mut hasher = DefaultHasher::new();
        bits.hash(&mut hasher);
        self.0.insert(hasher.finish())
    }
}

fn of_ball(ball: &Ball) -> Vec4 {
    ball.center.extend(ball.radius)
}
