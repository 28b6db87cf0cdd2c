//! The three queries of every shape: the first hit, its `t`, and whether there is one.
//!
//! A shape brings a common path, which is inlined where it is called, and a careful one, which is not. The
//! careful path does everything anew from the shape and the ray, and up to the answer: nothing that the
//! common path has computed must be in memory for its sake, so that it costs a compare and a branch.

use crate::{Hit, Ray};

/// What the common path says.
pub(crate) enum Common<R> {
    Miss,
    Root(R),
    /// Only the careful path can tell.
    Unsure,
}

/// What a shape brings.
pub(crate) trait Solve {
    /// A crossing in the interval of the ray, before it becomes a hit.
    type Root;

    fn solve(&self, ray: &Ray) -> Common<Self::Root>;

    /// Decides every ray. A shape that is never unsure needs none.
    fn solve_carefully(&self, _: &Ray) -> Option<Self::Root> {
        None
    }

    fn t(root: &Self::Root) -> f32;

    fn hit(&self, ray: &Ray, root: Self::Root) -> Hit;
}

#[inline(always)]
pub(crate) fn closest<S: Solve>(shape: &S, ray: &Ray) -> Option<Hit> {
    match shape.solve(ray) {
        Common::Miss => None,
        Common::Root(root) => Some(shape.hit(ray, root)),
        Common::Unsure => closest_carefully(shape, ray),
    }
}

#[inline(always)]
pub(crate) fn closest_t<S: Solve>(shape: &S, ray: &Ray) -> Option<f32> {
    match shape.solve(ray) {
        Common::Miss => None,
        Common::Root(root) => Some(S::t(&root)),
        Common::Unsure => closest_t_carefully(shape, ray),
    }
}

#[inline(always)]
pub(crate) fn any<S: Solve>(shape: &S, ray: &Ray) -> bool {
    match shape.solve(ray) {
        Common::Miss => false,
        Common::Root(_) => true,
        Common::Unsure => closest_t_carefully(shape, ray).is_some(),
    }
}

#[cold]
#[inline(never)]
fn closest_carefully<S: Solve>(shape: &S, ray: &Ray) -> Option<Hit> {
    let root = shape.solve_carefully(ray)?;
    Some(shape.hit(ray, root))
}

#[cold]
#[inline(never)]
fn closest_t_carefully<S: Solve>(shape: &S, ray: &Ray) -> Option<f32> {
    shape.solve_carefully(ray).map(|root| S::t(&root))
}

/// The queries as methods of a shape; the first line of documentation is of `closest`.
macro_rules! queries {
    ($shape:ty, $(#[$doc:meta])+) => {
        impl $shape {
            $(#[$doc])+
            #[must_use]
            #[inline]
            pub fn closest(&self, ray: &$crate::Ray) -> Option<$crate::Hit> {
                $crate::queries::closest(self, ray)
            }

            /// The `t` of [`Self::closest`], the same bits, at less cost.
            #[must_use]
            #[inline]
            pub fn closest_t(&self, ray: &$crate::Ray) -> Option<f32> {
                $crate::queries::closest_t(self, ray)
            }

            /// True if [`Self::closest`] finds a hit.
            #[must_use]
            #[inline]
            pub fn any(&self, ray: &$crate::Ray) -> bool {
                $crate::queries::any(self, ray)
            }
        }
    };
}

pub(crate) use queries;

impl<R> From<Option<R>> for Common<R> {
    #[inline(always)]
    fn from(root: Option<R>) -> Self {
        root.map_or(Self::Miss, Self::Root)
    }
}
