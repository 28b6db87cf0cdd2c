//! The three queries of every shape, as a floating-point filter followed by exact evaluation.
//!
//! A filter computes in `f64` and either knows the answer for certain or reports that it cannot
//! decide. It is inlined at the call. The exact evaluation, in more digits, decides the rays that
//! are left; it is an outlined call. It starts again from the shape and the ray and computes the
//! final answer: if it took intermediate values of the filter, the filter would have to spill them
//! to the stack. As it is, a filter pays one comparison and one branch for the call.
//!
//! Source for the term: J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast
//! Robust Geometric Predicates", Discrete & Computational Geometry 18, 1997.

use crate::{Hit, Ray};

/// The result of a filter.
pub(crate) enum Filtered<R> {
    /// The ray has no crossing in its interval.
    Miss,
    /// This is the first crossing in the interval of the ray.
    Hit(R),
    /// The `f64` filter cannot decide; evaluate exactly.
    Uncertain,
}

impl<R> From<Option<R>> for Filtered<R> {
    #[inline(always)]
    fn from(root: Option<R>) -> Self {
        root.map_or(Self::Miss, Self::Hit)
    }
}

/// The parts of an intersection that differ between the shapes.
pub(crate) trait Solve {
    /// A crossing in the interval of the ray, before it becomes a hit.
    type Root;

    /// Returns the first crossing in the interval of the ray if `f64` suffices to find it.
    fn filter(&self, ray: &Ray) -> Filtered<Self::Root>;

    /// Returns the first crossing in the interval of any ray. Shapes whose filter is never
    /// uncertain keep the default, which is not called.
    fn solve_exactly(&self, _: &Ray) -> Option<Self::Root> {
        None
    }

    fn t(root: &Self::Root) -> f32;

    fn hit(&self, ray: &Ray, root: Self::Root) -> Hit;
}

/// A difference that keeps less than this share of its terms is uncertain.
///
/// It has lost 16 of the 53 bits of an `f64`. With the remaining 37 it rounds to the same `f32` as
/// the exact value, except for one case in 2¹², in which it rounds to the neighbor, half a unit
/// away.
pub(crate) const CANCELLATION: f64 = 1.0 / 65_536.0;

/// The square of `2²⁵`: the distance in radii of a sphere or cone from which its filter is
/// uncertain. Where the ray grazes, that distance is shorter by the factor `h`, the root of the
/// share of the discriminant that is left.
///
/// At a distance of `D` radii the moment of a ray is known to `2⁻⁵³ D` radii, and the discriminant,
/// as a share of its terms, to twice that; half the chord, which is `h` radii, to `2⁻⁵³ D / h`. So
/// the normal is known to `2⁻²⁸`.
pub(crate) const FAR: f64 = (1_u64 << 50) as f64;

#[inline(always)]
pub(crate) fn closest<S: Solve>(shape: &S, ray: &Ray) -> Option<Hit> {
    match shape.filter(ray) {
        Filtered::Miss => None,
        Filtered::Hit(root) => Some(shape.hit(ray, root)),
        Filtered::Uncertain => closest_exactly(shape, ray),
    }
}

#[inline(always)]
pub(crate) fn closest_t<S: Solve>(shape: &S, ray: &Ray) -> Option<f32> {
    match shape.filter(ray) {
        Filtered::Miss => None,
        Filtered::Hit(root) => Some(S::t(&root)),
        Filtered::Uncertain => closest_t_exactly(shape, ray),
    }
}

#[inline(always)]
pub(crate) fn any<S: Solve>(shape: &S, ray: &Ray) -> bool {
    match shape.filter(ray) {
        Filtered::Miss => false,
        Filtered::Hit(_) => true,
        Filtered::Uncertain => closest_t_exactly(shape, ray).is_some(),
    }
}

#[cold]
#[inline(never)]
fn closest_exactly<S: Solve>(shape: &S, ray: &Ray) -> Option<Hit> {
    let root = shape.solve_exactly(ray)?;
    Some(shape.hit(ray, root))
}

#[cold]
#[inline(never)]
fn closest_t_exactly<S: Solve>(shape: &S, ray: &Ray) -> Option<f32> {
    shape.solve_exactly(ray).map(|root| S::t(&root))
}

/// Defines the three queries as methods of a shape, with the documentation of `closest`.
macro_rules! queries {
    ($shape:ty, $(#[$doc:meta])+) => {
        impl $shape {
            $(#[$doc])+
            #[must_use]
            #[inline]
            pub fn closest(&self, ray: &$crate::Ray) -> Option<$crate::Hit> {
                $crate::filter::closest(self, ray)
            }

            /// Returns the `t` of [`Self::closest`], the same bits, at less cost.
            #[must_use]
            #[inline]
            pub fn closest_t(&self, ray: &$crate::Ray) -> Option<f32> {
                $crate::filter::closest_t(self, ray)
            }

            /// Returns whether [`Self::closest`] finds a hit, at less cost.
            #[must_use]
            #[inline]
            pub fn any(&self, ray: &$crate::Ray) -> bool {
                $crate::filter::any(self, ray)
            }
        }
    };
}

pub(crate) use queries;
