//! The intersectors under test: the library's own, its vanilla approximations, published ones.

use glam::Vec3;
use rotund_geometry::{BilinearPatch, Hit, Ray, RoundedCone, Sphere, vanilla};

use crate::baselines;
use crate::families::Families;

/// Position and normal that a renderer evaluates if it keeps only the parameters of a hit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rebuilt {
    pub(crate) position: Vec3,
    pub(crate) normal: Vec3,
}

/// The library's other queries: whether there is a hit, and the `t` of the closest one.
pub(crate) struct Others<S: 'static> {
    pub(crate) any: fn(&S, &Ray) -> bool,
    pub(crate) closest_t: fn(&S, &Ray) -> Option<f32>,
}

/// One intersector of a shape.
pub(crate) struct Method<S: 'static> {
    pub(crate) name: &'static str,
    /// True for the library's own method, to which the targets apply.
    pub(crate) own: bool,
    /// True if the method solves another problem, so that its errors are not those of arithmetic.
    pub(crate) approximate: bool,
    /// The query that is timed; a call through a function pointer cannot be inlined.
    pub(crate) closest: fn(&S, &Ray) -> Option<Hit>,
    /// The other two queries, which must agree with `closest`.
    pub(crate) others: Option<Others<S>>,
    pub(crate) rebuild: Option<fn(&S, &Hit) -> Rebuilt>,
}

/// A shape with intersectors.
pub(crate) trait Measured: Families {
    /// All intersectors; the first is the library's own.
    const METHODS: &'static [Method<Self>];
    /// Family and level of the rays that are timed; they are well-conditioned.
    const TIMED: (&'static str, f64);
}

impl<S> Method<S> {
    const fn own(
        closest: fn(&S, &Ray) -> Option<Hit>,
        others: Others<S>,
        rebuild: fn(&S, &Hit) -> Rebuilt,
    ) -> Self {
        let (others, rebuild) = (Some(others), Some(rebuild));
        Self { name: "Rotund", own: true, approximate: false, closest, others, rebuild }
    }

    pub(crate) const fn published(
        name: &'static str,
        closest: fn(&S, &Ray) -> Option<Hit>,
    ) -> Self {
        Self { name, own: false, approximate: false, closest, others: None, rebuild: None }
    }

    const fn approximate(name: &'static str, closest: fn(&S, &Ray) -> Option<Hit>) -> Self {
        Self { approximate: true, ..Self::published(name, closest) }
    }
}

impl Measured for Sphere {
    const METHODS: &'static [Method<Self>] = &[
        Method::own(
            Self::closest,
            Others { any: Self::any, closest_t: Self::closest_t },
            |sphere, hit| {
                let uv = sphere.uv(hit);
                Rebuilt { position: sphere.position(uv), normal: sphere.normal(uv) }
            },
        ),
        Method::approximate("vanilla point", |sphere, ray| {
            vanilla::Point { center: sphere.center, radius: sphere.radius }.closest(ray)
        }),
        Method::published("textbook", baselines::sphere::textbook),
        Method::published("Quilez", baselines::sphere::quilez),
        Method::published("Haines et al.", baselines::sphere::haines),
        Method::published("projected (Embree)", baselines::sphere::projected),
        Method::published("interval (pbrt)", baselines::sphere::interval),
    ];
    const TIMED: (&'static str, f64) = ("distance", 1.5e1);
}

impl Measured for RoundedCone {
    const METHODS: &'static [Method<Self>] = &[
        Method::own(
            Self::closest,
            Others { any: Self::any, closest_t: Self::closest_t },
            |cone, hit| {
                let uv = cone.uv(hit);
                Rebuilt { position: cone.position(uv), normal: cone.normal(uv) }
            },
        ),
        Method::approximate("vanilla line", |cone, ray| {
            let Self { p0, r0, p1, r1 } = *cone;
            vanilla::Line { p0, r0, p1, r1 }.closest(ray)
        }),
        Method::published("Quilez", baselines::rounded_cone::quilez),
        Method::published("Quilez with uv", baselines::rounded_cone::quilez_with_uv),
        Method::published("round line (Embree)", baselines::rounded_cone::embree),
    ];
    const TIMED: (&'static str, f64) = ("distance", 4.0);
}

impl Measured for BilinearPatch {
    const METHODS: &'static [Method<Self>] = &[
        Method::own(
            Self::closest,
            Others { any: Self::any, closest_t: Self::closest_t },
            |patch, hit| {
                let uv = patch.uv(hit);
                Rebuilt { position: patch.position(uv), normal: patch.normal(uv) }
            },
        ),
        Method::approximate("vanilla quad", |patch, ray| {
            let Self { p00, p10, p01, p11 } = *patch;
            vanilla::Quad { p0: p00, p1: p10, p2: p11, p3: p01 }.closest(ray)
        }),
        Method::approximate("two triangles", baselines::patch::two_triangles),
        Method::published("Cool Patches", baselines::patch::cool),
        Method::published("pbrt", baselines::patch::pbrt),
        Method::published("Ramsey f32", baselines::patch::ramsey_f32),
        Method::published("Ramsey f64", baselines::patch::ramsey_f64),
    ];
    const TIMED: (&'static str, f64) = ("distance", 1.5);
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Checks well-conditioned rays, on which every published form is right.
    fn agree<S: Measured>(shape: S, rays: &[(Ray, Option<f32>)]) {
        for method in S::METHODS.iter().filter(|m| !m.approximate) {
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
        agree(unit, &rays);
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
        agree(cone, &rays);
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
        agree(saddle, &rays);
        for method in BilinearPatch::METHODS.iter().filter(|m| !m.approximate) {
            let hit = (method.closest)(&saddle, &rays[0].0).expect(method.name);
            let expected = DVec3::new(0.25, 0.25, 1.0).normalize();
            let cosine = hit.normal.as_dvec3().dot(expected).abs();
            assert!(cosine > 1.0 - 1e-6, "{}: {hit:?}", method.name);
        }
    }
}
