//! The intersectors under test: the library's own, its vanilla approximations and the published ones.

use glam::Vec3;
use rotund_geometry::{BilinearPatch, Hit, Ray, RoundedCone, Sphere, vanilla};

use super::{baselines, families::Families};

/// What a renderer that keeps only the parameters of a hit makes of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rebuilt {
    pub(crate) position: Vec3,
    pub(crate) normal: Vec3,
}

/// What the library answers besides the closest hit: whether there is one, and its `t`.
pub(crate) struct Others<S: 'static> {
    pub(crate) any: fn(&S, &Ray) -> bool,
    pub(crate) closest_t: fn(&S, &Ray) -> Option<f32>,
}

/// One intersector of a shape.
pub(crate) struct Method<S: 'static> {
    pub(crate) name: &'static str,
    /// Held to the targets.
    pub(crate) own: bool,
    /// Solves another problem, so that its errors are not of arithmetic.
    pub(crate) approximate: bool,
    /// A function pointer is a call that cannot be inlined: what the clock times.
    pub(crate) closest: fn(&S, &Ray) -> Option<Hit>,
    /// The other two queries, which have to agree with it.
    pub(crate) others: Option<Others<S>>,
    pub(crate) rebuild: Option<fn(&S, &Hit) -> Rebuilt>,
}

/// A shape with intersectors.
pub(crate) trait Measured: Families {
    /// The first is the library's own.
    const METHODS: &'static [Method<Self>];
    /// Family and level of the rays that are timed: well-conditioned ones.
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
