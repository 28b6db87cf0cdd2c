//! Exact ray intersection of round primitives, beside their usual approximations.
//!
//! | shape | is | parameters `uv` |
//! | --- | --- | --- |
//! | [`Sphere`] | the points at a distance from a centre | longitude from x towards z, polar angle from y |
//! | [`RoundedCone`] | the convex hull of two balls | along the profile, around the axis |
//! | [`BilinearPatch`] | the surface between four corners | the two weights |
//! | [`Triangle`] | the flat surface between three | the weights of the second and the third |
//! | [`vanilla`] | discs, ribbons and pairs of triangles in their place | as in yocto-gl |
//!
//! ```text
//!  RoundedCone              u = 0: pole of the cap about p0          u = 1: pole of the cap about p1
//!                                     .--"""--..____
//!    u grows along the profile,     /       |       """--._
//!    at constant speed             u=0  p0  +---- axis ---+ p1  u=1      v turns about the axis
//!                                   \       |   ____...--'
//!                                     `--...--""
//! ```
//!
//! # Conventions
//!
//! - A direction has any length; `t` counts in it. The interval `t_min..=t_max` is closed, and the rounded
//!   `t`, the one that is reported, decides whether it holds a crossing. A hit at an end of it counts.
//! - A query finds the first crossing in the interval. One before `t_min` never hides a later one, and a
//!   ray that starts inside a solid finds where it leaves. It enters (or comes from the front) if
//!   `normal.dot(direction)` is negative, and leaves otherwise; the next crossing is found from `t_min`
//!   just after this one.
//! - A NaN or an infinity in a ray or a shape, a zero direction, a radius that is negative, and a shape
//!   without extent miss. Nothing panics. A crossing whose `t` is no finite `f32` does not count.
//! - A patch, a triangle and a quad have the normal about which their parameters turn counter-clockwise.
//!
//! # Accuracy
//!
//! Input is taken as exact. The solvers work in `f64`, in forms whose terms do not grow with the distance
//! of the ray. Those of the three round shapes start again with 106 bits where an `f64` leaves too few: at
//! grazing incidence, and for rays that start on the surface unless it is certain which way they go. Each number
//! of a [`Hit`] is rounded once.
//! With `u = 2⁻²⁴`:
//!
//! | | measured bound |
//! | --- | --- |
//! | `t` | `1.0 u t`, the rounded true root; a patch that a ray grazes to `1e-9` or starts on, up to `1e3 u t` |
//! | `position` | `1.0 u max(abs(p), size)` from the surface, and within [`Hit::error`] |
//! | `normal` | `1e-5` degrees; a patch `2e-5`, more where a ray grazes to `1e-9` (`5e-4`) or next to a collapsed edge |
//! | `position(uv(hit))` | `1.0 u` from the surface; up to `8 u` along it, for `uv` are `f32` |
//! | a ray from [`Hit::spawn`] | never meets a sphere or a cone again from outside |
//! | a ray at a shared edge or corner of patches | one hit, whatever the order of their corners |
//!
//! `tests/` holds all of this against 106-bit arithmetic; `cargo xtask accuracy` prints it beside the
//! published methods. An origin may be 2²⁶ sizes away, and a cone 10⁶ radii long, before these bounds grow.
//!
//! # Without the standard library
//!
//! The crate needs neither `std` nor an allocator: switch the default feature `std` off, and what `core` has not
//! (roots, angles) comes from `libm`. `glam`, whose vectors are part of the interface, is exported here.
//!
//! # Example
//!
//! ```
//! use rotund_geometry::glam::Vec3;
//! use rotund_geometry::{Ray, RoundedCone};
//!
//! let cone = RoundedCone { p0: Vec3::ZERO, r0: 1.0, p1: Vec3::new(0.0, 0.0, 3.0), r1: 0.5 };
//! let ray = Ray::new(Vec3::new(0.0, 0.0, -5.0), Vec3::Z);
//! let hit = cone.closest(&ray).expect("the ray runs along the axis");
//! assert_eq!(hit.t, 4.0);
//! assert_eq!(hit.position, Vec3::new(0.0, 0.0, -1.0));
//!
//! // On through the solid, to the other pole.
//! let inside = hit.spawn(ray.direction);
//! assert_eq!(cone.closest(&inside).map(|exit| exit.position.z), Some(3.5));
//!
//! // Reflected, it never meets the cone again.
//! assert!(!cone.any(&hit.spawn(-ray.direction)));
//! ```

#![no_std]

#[cfg(any(feature = "std", test))]
extern crate std;

mod aabb;
mod basis;
mod bilinear_patch;
mod double_double;
mod f64x2;
mod filter;
mod float;
#[cfg(not(feature = "std"))]
mod libm_functions;
mod method;
mod origin_side;
mod primitive;
mod ray;
mod ray_space;
mod rounded_cone;
mod sphere;
#[cfg(test)]
mod test_random;
#[cfg(test)]
mod test_rays;
mod triangle;
pub mod vanilla;
mod widen;

pub use aabb::Aabb;
pub use bilinear_patch::BilinearPatch;
pub use float::{UNIT_ROUNDOFF, leave_surface, rounding_error};
pub use glam;
pub use method::{Method, UnknownMethod};
pub use primitive::Primitive;
pub use ray::{Hit, Ray};
pub use rounded_cone::RoundedCone;
pub use sphere::Sphere;
pub use triangle::Triangle;

/// All public types can be shared between threads.
const _: () = {
    const fn is_send_and_sync<T: Send + Sync>() {}
    is_send_and_sync::<(Aabb, Hit, Ray, Method, UnknownMethod)>();
    is_send_and_sync::<(Sphere, RoundedCone, BilinearPatch, Triangle)>();
    is_send_and_sync::<(vanilla::Point, vanilla::Line, vanilla::Quad)>();
};
