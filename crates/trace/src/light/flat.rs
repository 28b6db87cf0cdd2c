//! Areas of flat emitters, and sampling of bilinear patches.

use glam::{Vec2, Vec3};

/// A point on an emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SurfacePoint {
    pub(super) position: Vec3,
    /// Normal of unit length, to either side.
    pub(super) normal: Vec3,
    /// Parameters of the point on the element.
    pub(super) uv: Vec2,
    /// Density per area.
    pub(super) pdf_area: f32,
}

pub(super) fn triangle_area([p0, p1, p2]: [Vec3; 3]) -> f32 {
    0.5 * (p1 - p0).cross(p2 - p0).length()
}

/// Returns the two triangles that approximate a quad. Each begins at the corner that the other
/// lacks.
pub(super) fn halves([p0, p1, p2, p3]: [Vec3; 4]) -> [[Vec3; 3]; 2] {
    [[p0, p1, p3], [p2, p3, p1]]
}

/// Returns the corners, in order, of the quad that two triangles with one common side make.
pub(super) fn around(a: [Vec3; 3], b: [Vec3; 3]) -> Option<[Vec3; 4]> {
    let alone = a.iter().position(|corner| !b.contains(corner))?;
    let opposite = b.into_iter().find(|corner| !a.contains(corner))?;
    let side = [a[(alone + 1) % 3], a[(alone + 2) % 3]];
    side.iter().all(|end| b.contains(end)).then_some([a[alone], side[0], opposite, side[1]])
}

/// Returns the areas of the two triangles of a quad.
pub(super) fn triangle_areas(corners: [Vec3; 4]) -> [f32; 2] {
    halves(corners).map(triangle_area)
}

/// Returns the tangents of a bilinear patch `p00 p10 p01 p11` along u and v.
fn tangents([p00, p10, p01, p11]: [Vec3; 4], uv: Vec2) -> [Vec3; 2] {
    [(p10 - p00).lerp(p11 - p01, uv.y), (p01 - p00).lerp(p11 - p10, uv.x)]
}

/// Returns the area of a patch per area of its parameters at `p00 p10 p01 p11`.
fn corner_stretch(corners: [Vec3; 4]) -> [f32; 4] {
    [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE].map(|uv| {
        let [du, dv] = tangents(corners, uv);
        du.cross(dv).length()
    })
}

/// Returns the density of [`patch`] per area at `uv`.
///
/// Parameters are sampled in proportion to the bilinear interpolation of the area per area of
/// parameters at the corners. That is uniform by area for a parallelogram, and nearly so for a
/// patch of little curvature.
pub(super) fn patch_pdf(corners: [Vec3; 4], uv: Vec2) -> f32 {
    let [w00, w10, w01, w11] = corner_stretch(corners);
    let [du, dv] = tangents(corners, uv);
    let lower = w00 + uv.x * (w10 - w00);
    let upper = w01 + uv.x * (w11 - w01);
    let weight = lower + uv.y * (upper - lower);
    4.0 * weight / ((w00 + w10 + w01 + w11) * du.cross(dv).length())
}

/// Samples a point of a patch `p00 p10 p01 p11`.
pub(super) fn patch(corners: [Vec3; 4], u: Vec2) -> Option<SurfacePoint> {
    let [p00, p10, p01, p11] = corners;
    let [w00, w10, w01, w11] = corner_stretch(corners);
    let y = linear(w00 + w10, w01 + w11, u.y);
    let x = linear(w00 + y * (w01 - w00), w10 + y * (w11 - w10), u.x);
    let uv = Vec2::new(x, y);
    let [du, dv] = tangents(corners, uv);
    Some(SurfacePoint {
        position: p00.lerp(p10, x).lerp(p01.lerp(p11, x), y),
        normal: du.cross(dv).try_normalize()?,
        uv,
        pdf_area: patch_pdf(corners, uv),
    })
}

/// Samples a number in `0.0..=1.0` with a density that changes linearly from `a` to `b`, up to a
/// factor.
pub(super) fn linear(a: f32, b: f32, u: f32) -> f32 {
    if a + b <= 0.0 {
        return u;
    }
    // The root of (b - a) x² / 2 + a x = u (a + b) / 2, in a form that cannot cancel.
    (u * (a + b) / (a + (a * a + u * (b * b - a * a)).max(0.0).sqrt())).min(1.0)
}
