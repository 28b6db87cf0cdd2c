//! Colours of lines by their direction, as is usual for streamlines.

use glam::{DVec3, Vec3, Vec4};
use rotund_image::linear_from_srgb;

/// Adds the colours of a streamline: the absolute values of the tangent as red, green and blue of
/// sRGB. A point without a tangent, since its neighbours coincide, has the colour before it.
pub(crate) fn append(points: &[Vec3], colors: &mut Vec<Vec4>) {
    let last = points.len().saturating_sub(1);
    let mut color = Vec4::ONE;
    let mut waiting = 0;
    for i in 0..points.len() {
        let [before, at, after] =
            [i.saturating_sub(1), i, (i + 1).min(last)].map(|i| points[i].as_dvec3());
        let tangents = [after - before, after - at].map(DVec3::try_normalize);
        let Some(tangent) = tangents.into_iter().flatten().next() else {
            // The first colour is also that of the points before it.
            if waiting == i {
                waiting += 1;
            } else {
                colors.push(color);
            }
            continue;
        };
        let [r, g, b] = tangent.abs().as_vec3().to_array().map(linear_from_srgb);
        color = Vec4::new(r, g, b, 1.0);
        colors.extend(std::iter::repeat_n(color, std::mem::take(&mut waiting)));
        colors.push(color);
    }
    colors.extend(std::iter::repeat_n(color, waiting));
}
