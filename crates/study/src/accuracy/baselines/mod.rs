//! Published intersectors, written anew from their descriptions in the precision they were published
//! in. They exist to be compared with, are not part of the library, and keep their known weaknesses.

pub(super) mod interval;
pub(super) mod patch;
pub(super) mod rounded_cone;
pub(super) mod sphere;

use glam::{Vec2, Vec3};
use rotund_geometry::{Hit, Ray};

/// An answer without error bound and parameters.
fn hit(t: f32, position: Vec3, normal: Vec3) -> Hit {
    Hit { t, position, error: 0.0, normal, parameters: Vec2::ZERO }
}

/// Whether the interval of the ray has `t`.
fn inside(ray: &Ray, t: f32) -> bool {
    ray.t_min <= t && t <= ray.t_max
}

/// The first of two roots, in either order, that the interval has.
fn first(ray: &Ray, a: f32, b: f32) -> Option<f32> {
    let (near, far) = if a <= b { (a, b) } else { (b, a) };
    [near, far].into_iter().find(|&t| inside(ray, t))
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};
    use rotund_geometry::{BilinearPatch, Hit, Ray, RoundedCone, Sphere};

    use crate::accuracy::methods::{Measured, Method};

    /// Well-conditioned rays, on which every published form is right.
    fn agree<S: Measured>(shape: S, rays: &[(Ray, Option<f32>)], skip: &[&str]) {
        for method in S::METHODS.iter().filter(|m| !m.approximate && !skip.contains(&m.name)) {
            let Method { name, closest, .. } = method;
            for (ray, expected) in rays {
                let found: Option<Hit> = closest(&shape, ray);
                match (found, expected) {
                    (None, None) => {}
                    (Some(hit), Some(t)) => {
                        assert!((hit.t - t).abs() < 2e-5, "{name}: {} for {t}", hit.t);
                        assert!((hit.position - ray.at(*t)).length() < 3e-5, "{name}: {hit:?}");
                        assert!((hit.normal.length() - 1.0).abs() < 1e-5, "{name}: {hit:?}");
                    }
                    _ => panic!("{name}: {found:?} for {expected:?} of {ray:?}"),
                }
            }
        }
    }

    fn ray(origin: [f32; 3], direction: [f32; 3]) -> Ray {
        Ray::new(origin.into(), direction.into())
    }

    #[test]
    fn every_form_of_the_sphere_is_right_on_easy_rays() {
        let unit = Sphere { center: Vec3::ZERO, radius: 1.0 };
        let rays = [
            (ray([0.0, 0.0, -3.0], [0.0, 0.0, 1.0]), Some(2.0)),
            (ray([0.6, 0.0, -3.0], [0.0, 0.0, 1.0]), Some(2.2)),
            (ray([1.1, 0.0, -3.0], [0.0, 0.0, 1.0]), None),
            (ray([0.0, 0.0, 3.0], [0.0, 0.0, 1.0]), None),
        ];
        agree(unit, &rays, &[]);
    }

    #[test]
    fn every_form_of_the_cone_is_right_on_easy_rays() {
        let cone = RoundedCone { p0: Vec3::ZERO, r0: 1.0, p1: Vec3::new(0.0, 0.0, 3.0), r1: 1.0 };
        let rays = [
            (ray([0.0, -5.0, 1.5], [0.0, 1.0, 0.0]), Some(4.0)),
            (ray([0.6, -5.0, 1.5], [0.0, 1.0, 0.0]), Some(4.2)),
            (ray([0.0, -5.0, -0.6], [0.0, 1.0, 0.0]), Some(4.2)),
            (ray([0.0, -5.0, 3.6], [0.0, 1.0, 0.0]), Some(4.2)),
            (ray([0.0, -5.0, 4.1], [0.0, 1.0, 0.0]), None),
            (ray([1.1, -5.0, 1.5], [0.0, 1.0, 0.0]), None),
        ];
        agree(cone, &rays, &[]);
    }

    #[test]
    fn every_form_of_the_patch_is_right_on_easy_rays() {
        let saddle = BilinearPatch {
            p00: Vec3::new(-1.0, -1.0, -0.5),
            p10: Vec3::new(1.0, -1.0, 0.5),
            p01: Vec3::new(-1.0, 1.0, 0.5),
            p11: Vec3::new(1.0, 1.0, -0.5),
        };
        let down = |x, y| ray([x, y, 3.0], [0.0, 0.0, -1.0]);
        let rays = [
            (down(0.5, 0.5), Some(3.125)),
            (down(0.25, -0.5), Some(2.9375)),
            (down(1.5, 0.5), None),
            (down(0.5, -1.01), None),
        ];
        agree(saddle, &rays, &[]);
        for method in BilinearPatch::METHODS.iter().filter(|m| !m.approximate) {
            let hit = (method.closest)(&saddle, &rays[0].0).expect(method.name);
            let expected = DVec3::new(0.25, 0.25, 1.0).normalize();
            let cosine = hit.normal.as_dvec3().dot(expected).abs();
            assert!(cosine > 1.0 - 1e-6, "{}: {hit:?}", method.name);
        }
    }
}
