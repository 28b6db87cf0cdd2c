//! Rounding bounds, and how to leave a surface without hitting it again.

use glam::Vec3;

/// Half the distance between 1 and the next larger `f32`: the largest relative error of one
/// rounding.
pub const UNIT_ROUNDOFF: f32 = 0.5 * f32::EPSILON;

/// Where a ray leaves a surface so that it cannot meet the surface again by rounding alone.
///
/// `position` lies within `error` of the surface, whose normal there is `normal` (of unit length);
/// the result lies on the side that `direction` points to. The step is `error` along the normal,
/// rounded outwards in each coordinate, so it is as small as the error allows.
///
/// Source: M. Pharr, W. Jakob, G. Humphreys, "Physically Based Rendering", section 6.8.6 (robust
/// spawned ray origins), 4th edition, 2023.
#[must_use]
pub fn leave_surface(position: Vec3, error: f32, normal: Vec3, direction: Vec3) -> Vec3 {
    let side = if normal.dot(direction) < 0.0 { -normal } else { normal };
    let away = |p: f32, step: f32| {
        let moved = p + step;
        if step > 0.0 {
            moved.next_up()
        } else if step < 0.0 {
            moved.next_down()
        } else {
            moved
        }
    };
    let step = error * side;
    Vec3::new(away(position.x, step.x), away(position.y, step.y), away(position.z, step.z))
}
