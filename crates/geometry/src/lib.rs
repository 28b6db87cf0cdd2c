//! Exact ray intersection of spheres, rounded cones, bilinear patches and triangles, and of the
//! usual approximations of points, lines and quads.
//!
//! | shape | definition | parameters `uv` |
//! | --- | --- | --- |
//! | [`Sphere`] | the points at a distance from a center | longitude, polar angle |
//! | [`RoundedCone`] | the convex hull of two balls | along the profile, around the axis |
//! | [`BilinearPatch`] | the bilinear surface of four corners | the two weights |
//! | [`Triangle`] | the flat surface of three corners | the weights of `p1` and `p2` |
//! | [`vanilla`] | discs, ribbons and pairs of triangles | as in yocto-gl |
//!
//! ```text
//!  RoundedCone           u = 0: pole of the cap about p0         u = 1: pole of the cap about p1
//!                                   .--"""--..____
//!    u is the arc length         /       |       """--._
//!    along the profile          u=0  p0  +---- axis ---+ p1  u=1     v is the angle about the axis
//!                                \       |   ____...--'
//!                                  `--...--""
//! ```
//!
//! All shapes implement the trait [`Primitive`], as your own shapes can: its page says how. Every
//! query is also a method of the shape itself, so the trait need not be imported.
//!
//! # Conventions
//!
//! - The direction of a ray has any length, and `t` counts in units of it. The interval
//!   `t_min..=t_max` is closed: a hit at one of its ends counts. The `t` that is rounded to `f32`
//!   and reported decides whether a crossing is in the interval.
//! - A query finds the first crossing in the interval. A crossing before `t_min` never hides a
//!   later one, and a ray that starts inside a solid finds where it leaves. The ray enters the
//!   solid, or comes from the front of a surface, if `normal.dot(direction)` is negative, and
//!   leaves otherwise. To find the next crossing of the same shape, set `t_min` to `t.next_up()`.
//! - A ray that starts exactly on a sphere, a rounded cone or a patch, to 2⁻⁹⁰ of the size, crosses
//!   it at `t = 0`, whichever way it goes. On triangles and quads rounding decides.
//! - The normal of a patch, a triangle or a quad points to the side from which its parameters turn
//!   counter-clockwise.
//! - Lengths have any unit. Angles are in radians.
//!
//! # Invalid input
//!
//! Nothing panics, and no result is NaN: `closest` returns `None` and `any` false, if
//!
//! - the ray has a NaN in any field, an infinity in its origin or direction, or a zero direction;
//! - its interval is empty (`t_min > t_max`);
//! - the shape has a NaN or an infinity, a negative radius, or no extent (a sphere of radius zero,
//!   a triangle without area);
//! - the `t` of the crossing is no finite `f32`.
//!
//! The vanilla shapes differ in two cases. The radius of a point or a line may be infinite, and
//! then every ray in front of it hits. A line misses where its radius, interpolated at the closest
//! approach, is not positive: if one of its radii is negative, the part with a positive radius can
//! be hit.
//!
//! ```
//! use rotund_geometry::glam::Vec3;
//! use rotund_geometry::{Ray, Sphere};
//!
//! let ray = Ray::new(Vec3::new(0.0, 0.0, 5.0), Vec3::NEG_Z);
//! let ball = Sphere { center: Vec3::ZERO, radius: 1.0 };
//! assert_eq!(ball.closest_t(&ray), Some(4.0));
//!
//! for radius in [0.0, -1.0, f32::NAN, f32::INFINITY] {
//!     assert_eq!(Sphere { radius, ..ball }.closest(&ray), None);
//! }
//! for direction in [Vec3::ZERO, Vec3::NAN, Vec3::NEG_INFINITY] {
//!     assert_eq!(ball.closest(&Ray { direction, ..ray }), None);
//! }
//! assert!(!ball.any(&Ray { t_min: 5.0, t_max: 3.0, ..ray }));
//! assert!(!ball.any(&Ray { t_max: f32::NAN, ..ray }));
//! ```
//!
//! The bounds of an invalid shape are unspecified: they may be empty, infinite or NaN. The trees of
//! `rotund-bvh` accept them.
//!
//! # Accuracy
//!
//! The input is taken as exact. A floating-point filter in `f64`, in forms whose terms do not grow
//! with the distance of the ray, decides most rays. Where an `f64` has too few digits, at grazing
//! incidence and for rays that start on the surface, the three round shapes evaluate in
//! double-double, with 106 bits. Each number of a [`Hit`] is rounded once. With `u = 2⁻²⁴`:
//!
//! | number | measured bound |
//! | --- | --- |
//! | `t` | `1.0 u t`: the exact root, rounded |
//! | `t` of a patch, grazing to `1e-9` or from its surface | `1e3 u t` |
//! | `position` | `1.0 u max(abs(p), size)` from the surface, and within [`Hit::error`] |
//! | `normal` | `1e-5` degrees |
//! | `normal` of a patch | `2e-5` degrees; `5e-4` if grazing to `1e-9`; more at a collapsed edge |
//! | `position(uv(hit))` | `1.0 u` from the surface, up to `8 u` along it, since `uv` are `f32` |
//! | a ray from [`Hit::spawn`] | never hits a sphere or a cone again from outside |
//! | a ray at a shared edge or corner of patches | one hit, whatever the order of the corners |
//!
//! `tests/` checks all of this against arithmetic of 106 bits; `cargo xtask accuracy` compares it
//! with the published methods. The bounds hold for an origin up to 2²⁶ sizes away, and for a cone
//! up to 10⁶ radii long. From farther away, the position on a round shape may lie outside of its
//! box, by rounding. They do not hold near `f32::MAX`: a coordinate beyond it is infinite.
//!
//! A ray from [`Hit::spawn`] into a sphere or a cone starts inside, if its radii are at least 16
//! times the [`rounding_error`] of the place.
//!
//! [`Hit::error`] bounds the rounding to `f32`, and what the `f64` solution has lost: next to the
//! origin of coordinates, where `f32` resolves much more than the shape needs, that is all.
//!
//! # Features
//!
//! - `std` (default) takes roots and angles from the standard library. Without it the crate is
//!   `no_std`, takes them from `libm`, and needs no allocator.
//! - `serde` implements `Serialize` and `Deserialize` for rays, hits, boxes, methods and shapes. A
//!   [`Ray`] may be written without `t_min` and `t_max`, which are then 0 and infinity. A `t_max`
//!   of infinity is written as none, which JSON calls `null`. Other infinities, as in
//!   [`Aabb::EMPTY`], need a format that has them, which JSON is not.
//!
//! `glam`, whose vectors are part of the interface, is exported as [`rotund_geometry::glam`](glam).
//!
//! # Example
//!
//! Picking: the nearest of several shapes, then a reflected ray and a refracted one.
//!
//! ```
//! use rotund_geometry::glam::Vec3;
//! use rotund_geometry::{Primitive, Ray, RoundedCone, Sphere};
//!
//! let cone = RoundedCone { p0: Vec3::ZERO, r0: 1.0, p1: Vec3::new(0.0, 0.0, 3.0), r1: 0.5 };
//! let ball = Sphere { center: Vec3::new(0.0, 0.0, 9.0), radius: 1.0 };
//! let scene: [&dyn Primitive; 2] = [&ball, &cone];
//!
//! let ray = Ray::new(Vec3::new(0.0, 0.0, -5.0), Vec3::Z);
//! let (id, hit) = scene
//!     .iter()
//!     .enumerate()
//!     .filter_map(|(id, shape)| Some((id, shape.closest(&ray)?)))
//!     .min_by(|(_, a), (_, b)| a.t.partial_cmp(&b.t).expect("no t is NaN"))
//!     .expect("the ray runs along the axis of both");
//! assert_eq!((id, hit.t, hit.position), (1, 4.0, Vec3::new(0.0, 0.0, -1.0)));
//!
//! // A reflected ray starts outside and never hits the cone again.
//! let reflected = hit.spawn(ray.direction.reflect(hit.normal));
//! assert!(!cone.any(&reflected));
//!
//! // A ray that goes on starts inside and hits the other pole.
//! let exit = cone.closest(&hit.spawn(ray.direction)).expect("an exit");
//! assert_eq!(exit.position.z, 3.5);
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
mod next_float;
mod origin_side;
mod primitive;
mod ray;
mod ray_space;
mod rounded_cone;
mod solid;
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
pub use solid::{End, ExactInterval, Interval, Solid};
pub use sphere::Sphere;
pub use triangle::Triangle;

/// Checks at compile time that all public types can be sent to and shared between threads.
const _: () = {
    const fn is_send_and_sync<T: Send + Sync>() {}
    is_send_and_sync::<(Aabb, Hit, Ray, Method, UnknownMethod)>();
    is_send_and_sync::<(Sphere, RoundedCone, BilinearPatch, Triangle)>();
    is_send_and_sync::<(vanilla::Point, vanilla::Line, vanilla::Quad)>();
};
