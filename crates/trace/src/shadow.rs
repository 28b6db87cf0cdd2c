//! Transmittance from a light source to a vertex of a path.

use crate::context::Context;
use crate::light::LightSource;
use crate::medium::{Media, Medium};
use crate::opacity::SHEETS;
use glam::Vec3;
use rotund_geometry::Ray;
use rotund_scene::{MaterialKind, SceneHit};
use std::borrow::Cow;

/// The start of a shadow ray.
pub(crate) enum Departure<'a> {
    /// A surface point. `medium` is the medium behind it, if it is the boundary of one.
    Surface { hit: &'a SceneHit, outgoing: Vec3, medium: Option<Medium> },
    /// A point inside of a medium.
    Inside(Vec3),
}

/// The end of a shadow ray.
pub(crate) struct Target<'a> {
    /// Direction to the light, of unit length.
    pub(crate) incoming: Vec3,
    /// Point on the light; `None` for an environment.
    pub(crate) source: Option<&'a LightSource>,
    /// Number of borders of clouds that the ray may pass: each is a segment of the path.
    pub(crate) borders: u32,
}

/// What is between both ends.
pub(crate) struct Visible {
    /// Transmittance.
    pub(crate) share: Vec3,
    /// Number of rays traced.
    pub(crate) rays: u64,
    /// The ray passes borders of clouds.
    pub(crate) clouds: bool,
}

impl Context<'_> {
    /// Returns what is between both ends.
    ///
    /// Surfaces of partial opacity attenuate light, clouds absorb it and scatter it away, and other
    /// surfaces block it.
    pub(crate) fn visibility(
        &self,
        departure: &Departure<'_>,
        target: &Target<'_>,
        media: &Media,
    ) -> Visible {
        let incoming = target.incoming;
        // Copied only where the ray crosses a border.
        let mut media = Cow::Borrowed(media);
        let end = target.source.map(|source| source.end(incoming));
        let segment = |origin: Vec3| match (target.source, end) {
            (Some(source), Some(end)) => source.shadow_ray(end, origin),
            _ => Ray::new(origin, incoming),
        };
        // Transmittance of the last piece of the ray. An infinite piece is not inside of a medium.
        let last_piece = |media: &Media, origin: Vec3| match end {
            None => Vec3::ONE,
            Some(end) => media.transmittance(end.distance(origin)),
        };
        let (origin, mut left) = match departure {
            Departure::Surface { hit, outgoing, medium } => {
                if let Some(medium) = medium
                    && hit.normal.dot(*outgoing) * hit.normal.dot(incoming) < 0.0
                {
                    media.to_mut().cross(hit, incoming, *medium);
                }
                (hit.spawn(incoming).origin, hit.left_by(incoming))
            }
            Departure::Inside(position) => (*position, None),
        };
        let mut ray = segment(origin);
        if self.facts.opaque {
            let blocked = self.trees.any_after(self.scene, &ray, left);
            let share = if blocked { Vec3::ZERO } else { last_piece(&media, origin) };
            return Visible { share, rays: 1, clouds: false };
        }
        let mut share = Vec3::ONE;
        let mut borders = target.borders;
        for rays in 1..=u64::from(SHEETS) {
            let Some(sheet) = self.trees.closest_after(self.scene, &ray, left) else {
                let share = share * last_piece(&media, ray.origin);
                return Visible { share, rays, clouds: borders < target.borders };
            };
            share *= media.transmittance(sheet.position.distance(ray.origin));
            let material = self.scene.eval_material(sheet.instance, sheet.element, sheet.uv);
            let whole = material.opacity >= 1.0;
            if material.kind == MaterialKind::Volumetric && whole && borders > 0 {
                borders -= 1;
                media.to_mut().cross(&sheet, incoming, Medium::new(&material));
            } else if !whole {
                share *= 1.0 - material.opacity;
            } else {
                return Visible { share: Vec3::ZERO, rays, clouds: false };
            }
            ray = segment(sheet.spawn(incoming).origin);
            left = sheet.left_by(incoming);
        }
        Visible { share: Vec3::ZERO, rays: u64::from(SHEETS), clouds: false }
    }
}
