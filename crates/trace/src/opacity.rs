//! Surfaces of partial opacity: the first surface of a ray that is present by chance.

use crate::{Sampler, context::Context};
use rotund_geometry::Ray;
use rotund_scene::{MaterialPoint, SceneHit};

/// Largest number of surfaces of partial opacity on one path. It ends paths that would otherwise
/// not.
pub(crate) const SHEETS: u32 = 1024;
/// First dimension set of the decisions at surfaces of partial opacity, of which there are any
/// number.
pub(crate) const SHEET_SETS: u32 = 1 << 16;

impl Context<'_> {
    /// Returns the first surface of a ray that is present by its opacity, and the number of rays
    /// traced.
    pub(crate) fn first_surface(
        &self,
        mut ray: Ray,
        sampler: &Sampler,
    ) -> (Option<(SceneHit, MaterialPoint)>, u64) {
        let mut left = None;
        for sheet in 0..SHEETS {
            let rays = u64::from(sheet) + 1;
            let found = self.trees.closest_after(self.scene, &ray, left);
            let Some(hit) = found else { return (None, rays) };
            let material = self.scene.eval_material(hit.instance, hit.element, hit.uv);
            if material.opacity >= 1.0 || sampler.set(SHEET_SETS + sheet)[0] < material.opacity {
                return (Some((hit, material)), rays);
            }
            ray.origin = hit.spawn(ray.direction).origin;
            left = hit.left_by(ray.direction);
        }
        (None, u64::from(SHEETS))
    }
}
