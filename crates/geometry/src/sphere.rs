//! The sphere.
//!
//! # Derivation
//!
//! With `f = o - c`, the ray `f + t d` crosses `|x| = r` where `a t² + 2 b t + g = 0`, `a = d·d`,
//! `b = f·d`, `g = f·f - r²`. The textbook discriminant `b² - a g` subtracts two numbers of the
//! size `a f·f` to find one of the size `a r²`: at a distance of `1000 r` no digit of an `f32` is
//! left. By Lagrange's identity `(f·f)(d·d) - (f·d)² = |f × d|²` the discriminant is
//! `a r² - |f × d|²`, which compares the radius with the distance of the line from the center.
//! Neither term grows with the distance of the origin along the ray.
//!
//! In `f64` the difference `o - c` of two `f32` is exact unless their exponents are far apart, and
//! so are most of the products. The results are rounded to `f32` once. No square of finite `f32`
//! input, nor a product of two squares, overflows or underflows an `f64`.
//!
//! Sources: E. Haines, J. Günther, T. Akenine-Möller, "Precision Improvements for Ray/Sphere
//! Intersection", Ray Tracing Gems, chapter 7, 2019, for where the textbook loses its digits and
//! for the roots without cancellation, after W. H. Press et al., "Numerical Recipes", section 5.6.

use core::f64::consts::{PI, TAU};

use glam::{DVec3, Vec2, Vec3};

use crate::double_double::{DoubleDouble, Real};
use crate::filter::{CANCELLATION, FAR, Filtered, Solve, queries};
use crate::float::{error, off_sphere, round};
#[cfg(not(feature = "std"))]
use crate::libm_functions::Functions as _;
use crate::origin_side::{self, OriginSide};
use crate::{Aabb, Hit, Ray, widen};

/// The points at distance `radius` from `center`.
///
/// # Accuracy
///
/// `t` is the exact root, rounded. The position is within `1.0 u max(|p|, radius)` of the surface,
/// `u = 2⁻²⁴`, and the normal within `1e-5` degrees. This holds at every distance; beyond 2²⁵ radii
/// it takes more time.
///
/// # Degenerate inputs
///
/// A radius that is zero, negative or NaN misses, and so does a center with a NaN or an infinity. A
/// tangent ray hits once.
///
/// ```
/// use rotund_geometry::glam::{Vec2, Vec3};
/// use rotund_geometry::{Ray, Sphere};
///
/// let ball = Sphere { center: Vec3::ZERO, radius: 1.0 };
/// let hit = ball.closest(&Ray::new(Vec3::new(-5.0, 0.0, 0.0), 2.0 * Vec3::X)).expect("a hit");
/// assert_eq!((hit.t, hit.normal), (2.0, Vec3::NEG_X));
/// assert_eq!(ball.uv(&hit), Vec2::new(0.5, 0.5));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sphere {
    /// The center.
    pub center: Vec3,
    /// The distance of the surface from the center; positive.
    pub radius: f32,
}

/// The unit sphere about the origin.
impl Default for Sphere {
    fn default() -> Self {
        Self { center: Vec3::ZERO, radius: 1.0 }
    }
}

/// A crossing before rounding: the root, and the point relative to the center.
pub(crate) struct Root {
    pub(crate) t: f32,
    pub(crate) from_center: DVec3,
    pub(crate) normal: DVec3,
}

queries!(
    Sphere,
    /// Returns the first crossing of the surface with `t` in `t_min..=t_max`.
    ///
    /// For a ray that starts inside, this is the exit.
);

impl Solve for Sphere {
    type Root = Root;

    #[inline(always)]
    fn filter(&self, ray: &Ray) -> Filtered<Root> {
        let (c, r) = widen::ball(self.center, self.radius);
        let (o, d) = widen::ray(ray);
        let f = o - c;
        let w = f.cross(d);
        let a = d.dot(d);
        // Negative if the radius is; then the ray misses.
        let square = a * (r * r.abs());
        let discriminant = square - w.dot(w);
        let grazing = CANCELLATION * square;
        // A NaN is not certain and does not graze. With a radius of zero, a ray grazes.
        let certain = discriminant > grazing;
        if !certain {
            let grazes = discriminant >= -grazing;
            return if grazes { Filtered::Uncertain } else { Filtered::Miss };
        }
        // One division gives both reciprocals, and overlaps with the square root.
        let inverse = (a * r).recip();
        let (over_a, over_r) = (inverse * r, inverse * a);
        let b = f.dot(d);
        let root = discriminant.sqrt();
        // The ends of the chord, the part of the line inside the ball.
        let (near, far) = (-b - root, root - b);
        let product = (near * far).abs();
        if (product <= grazing) | (product > FAR * discriminant) {
            return Filtered::Uncertain;
        }
        let (near, far) = (near * over_a, far * over_a);
        let Some((t, t64)) =
            ray.accept(near).map(|t| (t, near)).or_else(|| ray.accept(far).map(|t| (t, far)))
        else {
            return Filtered::Miss;
        };
        let from_center = f + t64 * d;
        Filtered::Hit(Root { t, from_center, normal: from_center * over_r })
    }

    /// Decides rays that graze, that start next to the surface, or that come from far away.
    #[cold]
    #[inline(never)]
    fn solve_exactly(&self, ray: &Ray) -> Option<Root> {
        match origin_side::of_sphere(self.center, self.radius, ray) {
            OriginSide::Leaving => return None,
            OriginSide::Inside => {
                if let Some(exit) = self.solve_exit(ray) {
                    return exit;
                }
            }
            OriginSide::Uncertain => {}
        }
        self.solve_in_double_double(ray)
    }

    #[inline(always)]
    fn t(root: &Root) -> f32 {
        root.t
    }

    #[inline(always)]
    fn hit(&self, _: &Ray, Root { t, from_center, normal }: Root) -> Hit {
        let (center, radius) = widen::ball(self.center, self.radius);
        let position = round(center + from_center);
        Hit {
            t,
            position,
            error: error(position, off_sphere(radius, normal)),
            normal: round(normal),
            parameters: Vec2::ZERO,
        }
    }
}

impl Sphere {
    /// Returns the exit of a ray that starts inside, whose nearer root cannot count; `None` if an
    /// `f64` has too few digits for it.
    fn solve_exit(&self, ray: &Ray) -> Option<Option<Root>> {
        let (c, r) = widen::ball(self.center, self.radius);
        let (o, d) = widen::ray(ray);
        let f = o - c;
        let w = f.cross(d);
        let a = d.dot(d);
        let b = f.dot(d);
        let square = a * (r * r);
        let discriminant = square - w.dot(w);
        // If b is positive, the far root is a difference that may cancel.
        if !(b <= 0.0 && discriminant > CANCELLATION * square) {
            return None;
        }
        let t64 = (discriminant.sqrt() - b) / a;
        let Some(t) = ray.accept(t64) else { return Some(None) };
        let from_center = f + t64 * d;
        Some(Some(Root { t, from_center, normal: from_center / r }))
    }

    /// Returns both roots with 106 bits, or `None` if the line misses.
    pub(crate) fn roots_in_double_double(&self, ray: &Ray) -> Option<[DoubleDouble; 2]> {
        let [f, d] = self.relative_in_double_double(ray);
        let r = DoubleDouble::exact(self.radius);
        let (a, b, g) = (dot(d, d), dot(f, d), dot(f, f) - r * r);
        let w = [f[1] * d[2] - f[2] * d[1], f[2] * d[0] - f[0] * d[2], f[0] * d[1] - f[1] * d[0]];
        let discriminant = a * r * r - dot(w, w);
        if discriminant < DoubleDouble::ZERO || self.radius.is_nan() || self.radius <= 0.0 {
            return None;
        }
        // Both terms of q have the sign of -b, so their sum does not cancel. The other root comes
        // from the product of the roots, g / a.
        let root = discriminant.square_root();
        let roots = if b >= DoubleDouble::ZERO {
            let q = -b - root;
            [q / a, g / q]
        } else {
            let q = root - b;
            [g / q, q / a]
        };
        // If the radius is below the resolution of 106 bits at this distance, the roots may come
        // out in either order.
        let [near, far] = roots;
        Some(if far < near { [near, near] } else { roots })
    }

    /// Returns the origin of the ray relative to the center, and its direction.
    fn relative_in_double_double(&self, ray: &Ray) -> [[DoubleDouble; 3]; 2] {
        let exact = |p: Vec3| p.to_array().map(DoubleDouble::exact);
        let (o, c) = (exact(ray.origin), exact(self.center));
        [[o[0] - c[0], o[1] - c[1], o[2] - c[2]], exact(ray.direction)]
    }

    /// Solves with 106 bits.
    #[inline(never)]
    pub(crate) fn solve_in_double_double(&self, ray: &Ray) -> Option<Root> {
        let roots = self.roots_in_double_double(ray)?;
        roots.into_iter().find_map(|t| self.root_at(ray, t))
    }

    /// Returns the crossing at a root if it is in the interval of the ray.
    fn root_at(&self, ray: &Ray, exact_t: DoubleDouble) -> Option<Root> {
        let t = ray.accept(exact_t.nearest())?;
        let [f, d] = self.relative_in_double_double(ray);
        let x = [0, 1, 2].map(|i| (f[i] + exact_t * d[i]).nearest());
        let from_center = DVec3::from_array(x);
        let radius = f64::from(self.radius);
        let normal = from_center / radius;
        if (normal.dot(normal) - 1.0).abs() < 1e-9 {
            return Some(Root { t, from_center, normal });
        }
        // From distances at which 106 bits are too few, the nearest point of the surface is taken.
        let normal = normal.normalize_or(DVec3::Y);
        Some(Root { t, from_center: radius * normal, normal })
    }

    /// Returns the hit where the line of the ray leaves the sphere, at any `t`.
    #[inline]
    pub(crate) fn exit(&self, ray: &Ray) -> Option<Hit> {
        let ray = &Ray { t_min: f32::NEG_INFINITY, t_max: f32::INFINITY, ..*ray };
        let (c, r) = widen::ball(self.center, self.radius);
        let (o, d) = widen::ray(ray);
        let f = o - c;
        let w = f.cross(d);
        let a = d.dot(d);
        let square = a * (r * r);
        let discriminant = square - w.dot(w);
        let root = discriminant.sqrt();
        let b = f.dot(d);
        let far = root - b;
        let grazing = CANCELLATION * square;
        let product = (far * (far - 2.0 * root)).abs();
        // If b is positive, as for a ray that leaves the sphere from next to its surface, the far
        // root is a difference that may cancel. Written so that a NaN is left to the exact
        // evaluation.
        let certain = discriminant > grazing
            && (b <= 0.0 || product > grazing)
            && product <= FAR * discriminant
            && r > 0.0;
        if !certain {
            return self.exit_exactly(ray);
        }
        let inverse = (a * r).recip();
        let far = far * (inverse * r);
        let from_center = f + far * d;
        let normal = from_center * (inverse * a);
        Some(self.hit(ray, Root { t: ray.accept(far)?, from_center, normal }))
    }

    #[cold]
    #[inline(never)]
    fn exit_exactly(&self, ray: &Ray) -> Option<Hit> {
        let [_, exit] = self.roots_in_double_double(ray)?;
        Some(self.hit(ray, self.root_at(ray, exit)?))
    }

    /// Returns a box that contains the sphere and every position that [`Self::closest`] reports for
    /// a ray that starts up to 2²⁶ radii away.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        let r = Vec3::splat(self.radius);
        Aabb { min: self.center - r, max: self.center + r }.grown_by_rounding()
    }

    /// Returns the surface parameters of a hit: longitude and polar angle, see [`Self::position`].
    #[must_use]
    pub fn uv(&self, hit: &Hit) -> Vec2 {
        let n = hit.normal.as_dvec3();
        let u = n.z.atan2(n.x) / TAU;
        // A negative angle close to zero would round to a whole turn.
        let u = (if u < 0.0 { u + 1.0 } else { u }) as f32;
        Vec2::new(if u < 1.0 { u } else { 0.0 }, (n.x.hypot(n.z).atan2(n.y) / PI) as f32)
    }

    /// Returns the point with longitude `2 pi u` about the y axis, from x towards z, and polar
    /// angle `pi v` from +y: the layout of an environment map.
    #[must_use]
    pub fn position(&self, uv: Vec2) -> Vec3 {
        round(self.center.as_dvec3() + f64::from(self.radius) * direction(uv))
    }

    /// Returns the outward unit normal at [`Self::position`].
    #[must_use]
    pub fn normal(&self, uv: Vec2) -> Vec3 {
        round(direction(uv))
    }

    /// Returns the derivatives of [`Self::position`] by `u` and by `v`. The first is zero at the
    /// poles.
    #[must_use]
    pub fn tangents(&self, uv: Vec2) -> (Vec3, Vec3) {
        let (sin_u, cos_u) = (TAU * f64::from(uv.x)).sin_cos();
        let (sin_v, cos_v) = (PI * f64::from(uv.y)).sin_cos();
        let r = f64::from(self.radius);
        let du = TAU * r * sin_v * DVec3::new(-sin_u, 0.0, cos_u);
        let dv = PI * r * DVec3::new(cos_v * cos_u, -sin_v, cos_v * sin_u);
        (round(du), round(dv))
    }
}

fn dot(a: [DoubleDouble; 3], b: [DoubleDouble; 3]) -> DoubleDouble {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn direction(uv: Vec2) -> DVec3 {
    let (sin_u, cos_u) = (TAU * f64::from(uv.x)).sin_cos();
    let (sin_v, cos_v) = (PI * f64::from(uv.y)).sin_cos();
    DVec3::new(sin_v * cos_u, cos_v, sin_v * sin_u)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_random::Random;
    use crate::test_rays::{aimed, spawned};

    #[test]
    fn the_side_of_the_origin_of_a_ray_is_that_found_with_106_bits() {
        let mut random = Random(0x9E37_79B9_7F4A_7C15);
        let mut known = [0, 0];
        let mut spawned_count = 0;
        while spawned_count < 200_000 {
            let size = random.power(4.0);
            let center = random.in_cube() * random.power(4.0);
            let sphere = Sphere { center, radius: size };
            let Some(hit) = sphere.closest(&aimed(&mut random, center, size)) else { continue };
            spawned_count += 1;
            let ray = spawned(&mut random, &hit);
            let exact = sphere.solve_in_double_double(&ray).map(|root| root.t);
            match origin_side::of_sphere(center, size, &ray) {
                OriginSide::Leaving => assert_eq!(exact, None, "{sphere:?} {ray:?}"),
                OriginSide::Inside => {
                    let exit = Ray { t_min: ray.t_min.max(f32::MIN_POSITIVE), ..ray };
                    let last = sphere.solve_in_double_double(&exit).map(|root| root.t);
                    assert_eq!(exact, last, "{sphere:?} {ray:?}");
                    let found = sphere.closest_t(&ray);
                    let near = |t: f32| found == Some(t) || found == Some(t.next_up());
                    let agrees = exact.map_or(found.is_none(), |t| near(t) || near(t.next_down()));
                    assert!(agrees, "{sphere:?} {ray:?} {exact:?} {found:?}");
                }
                OriginSide::Uncertain => continue,
            }
            known[usize::from(exact.is_some())] += 1;
        }
        assert!(known[0] > 60_000 && known[1] > 40_000, "{known:?}");
    }
}
