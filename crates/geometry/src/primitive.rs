//! The interface that all shapes share, for callers that are generic over it or bring their own.

use glam::{Vec2, Vec3};

use crate::vanilla::{Line, Point, Quad};
use crate::{Aabb, BilinearPatch, Hit, Ray, RoundedCone, Sphere, Triangle};

/// A shape that a ray can hit: the interface that trees, pickers and integrators use.
///
/// The seven shapes of this crate implement it. Their own methods have the same names, so a program
/// that calls them on a concrete shape need not import the trait. Implement it for your own shape
/// to use that in the same places, for example in the trees of `rotund-bvh`.
///
/// # Implementing it
///
/// Four methods define a shape: [`closest`](Self::closest) and [`bounds`](Self::bounds) for the
/// ray, [`position`](Self::position) and [`normal`](Self::normal) for the surface over its
/// parameters. The others have defaults. A tree and [`Hit::spawn`] rely on the following.
///
/// - **`t`** counts in units of `ray.direction`, whose length is arbitrary: do not normalize it, or
///   divide `t` by its length afterwards. The interval `ray.t_min..=ray.t_max` is closed. A
///   crossing before `t_min` must not hide a later one. [`Ray::accept`] rounds a root and tests the
///   interval.
/// - **NaN**: a NaN or an infinity in the ray or in the shape, and a zero direction, are a miss,
///   `None`. No number of a hit is NaN. Write comparisons so that a NaN fails:
///   `if !(x >= 0.0) { return None; }`.
/// - **`position`** is the point of the surface; **`error`** bounds its distance from the exact
///   surface. If the point is computed in `f64` and rounded once,
///   [`rounding_error`](crate::rounding_error) is the bound. An error that is too small lets a
///   spawned ray hit the surface that it left; one that is too large makes it start too far away.
///   `position` lies within `bounds`.
/// - **`normal`** has unit length and points out of a solid, or to the front of a sheet, whichever
///   side the ray came from. It is not turned towards the ray.
/// - **`parameters`** is for [`uv`](Self::uv) alone: store there what the intersection knows and
///   `uv` needs.
/// - **`uv`** lies in `0.0..=1.0` in both coordinates, and `position(uv(&hit))` is the point of the
///   hit within rounding.
///
/// The same ray must give the same answer each time, and `closest_t` and `any` must agree with
/// `closest`.
///
/// A reference to a primitive, and with the feature `std` a `Box`, is a primitive too. So a list of
/// `&dyn Primitive` or `Box<dyn Primitive>` can hold shapes of different types; a tree that is
/// built on several threads asks for `+ Sync`.
///
/// ```
/// use rotund_geometry::glam::{Vec2, Vec3};
/// use rotund_geometry::{Aabb, Hit, Primitive, Ray, Sphere, rounding_error};
///
/// /// A disc across the z axis, front towards +z.
/// struct Disc {
///     center: Vec3,
///     radius: f32,
/// }
///
/// impl Primitive for Disc {
///     fn bounds(&self) -> Aabb {
///         let extent = Vec3::new(self.radius, self.radius, 0.0);
///         Aabb { min: self.center - extent, max: self.center + extent }
///     }
///
///     fn closest(&self, ray: &Ray) -> Option<Hit> {
///         // In f64, so that each number of the hit is rounded once.
///         let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
///         let c = self.center.as_dvec3();
///         // Infinite or NaN if the ray is parallel to the disc: both fail below.
///         let t = (c.z - o.z) / d.z;
///         let across = (o + t * d - c).truncate();
///         let r = f64::from(self.radius);
///         // Written so that a NaN fails.
///         if !(across.length_squared() <= r * r) {
///             return None;
///         }
///         let t = ray.accept(t)?;
///         let position = (c + across.extend(0.0)).as_vec3();
///         let parameters = (across / (2.0 * r)).as_vec2() + 0.5;
///         Some(Hit { t, position, error: rounding_error(position), normal: Vec3::Z, parameters })
///     }
///
///     fn position(&self, uv: Vec2) -> Vec3 {
///         self.center + (2.0 * self.radius * (uv - 0.5)).extend(0.0)
///     }
///
///     fn normal(&self, _uv: Vec2) -> Vec3 {
///         Vec3::Z
///     }
/// }
///
/// let disc = Disc { center: Vec3::new(0.0, 0.0, 2.0), radius: 1.0 };
/// let ball = Sphere { center: Vec3::ZERO, radius: 1.0 };
/// let scene: [&dyn Primitive; 2] = [&disc, &ball];
///
/// let ray = Ray::new(Vec3::new(0.5, 0.0, 8.0), 2.0 * Vec3::NEG_Z);
/// let hits = scene.map(|shape| shape.closest_t(&ray));
/// assert_eq!(hits[0], Some(3.0));
/// assert!(hits[1] > hits[0]);
/// assert!(!disc.any(&Ray::new(Vec3::ZERO, Vec3::X)), "a parallel ray");
/// assert!(!disc.any(&Ray::new(Vec3::ZERO, Vec3::NAN)));
/// ```
pub trait Primitive {
    /// Returns a box that contains the shape and every position that [`closest`](Self::closest)
    /// reports.
    ///
    /// Trees skip a shape if the ray misses this box. A shape that no ray can hit may return any
    /// box.
    fn bounds(&self) -> Aabb;

    /// Returns the first crossing of the surface with `t` in `ray.t_min..=ray.t_max`.
    ///
    /// A ray that starts inside a solid reports where it leaves. The documentation of the trait
    /// lists the requirements on a hit.
    fn closest(&self, ray: &Ray) -> Option<Hit>;

    /// Returns the `t` of [`closest`](Self::closest), the same bits. Override it if that is
    /// cheaper.
    #[inline]
    fn closest_t(&self, ray: &Ray) -> Option<f32> {
        self.closest(ray).map(|hit| hit.t)
    }

    /// Returns whether [`closest`](Self::closest) finds a hit. Override it if that is cheaper.
    #[inline]
    fn any(&self, ray: &Ray) -> bool {
        self.closest_t(ray).is_some()
    }

    /// Returns the surface parameters of a hit of this shape; [`Hit::parameters`] unless
    /// overridden.
    #[inline]
    fn uv(&self, hit: &Hit) -> Vec2 {
        hit.parameters
    }

    /// Returns the point of the surface with parameters `uv`, each in `0.0..=1.0`.
    fn position(&self, uv: Vec2) -> Vec3;

    /// Returns the unit normal at [`position`](Self::position), on the same side as that of a hit.
    fn normal(&self, uv: Vec2) -> Vec3;
}

// The forwarders are always inlined, so that callers that are compiled for an instruction set, as
// the trees of `rotund-bvh`, inline the intersection itself and not a call to a copy without that
// set.
macro_rules! forward {
    ($([$($generic:tt)*] $type:ty => $shape:ty,)+) => {
        $(
            impl $($generic)* Primitive for $type {
                #[inline(always)]
                fn bounds(&self) -> Aabb {
                    <$shape>::bounds(self)
                }

                #[inline(always)]
                fn closest(&self, ray: &Ray) -> Option<Hit> {
                    <$shape>::closest(self, ray)
                }

                #[inline(always)]
                fn closest_t(&self, ray: &Ray) -> Option<f32> {
                    <$shape>::closest_t(self, ray)
                }

                #[inline(always)]
                fn any(&self, ray: &Ray) -> bool {
                    <$shape>::any(self, ray)
                }

                #[inline(always)]
                fn uv(&self, hit: &Hit) -> Vec2 {
                    <$shape>::uv(self, hit)
                }

                #[inline(always)]
                fn position(&self, uv: Vec2) -> Vec3 {
                    <$shape>::position(self, uv)
                }

                #[inline(always)]
                fn normal(&self, uv: Vec2) -> Vec3 {
                    <$shape>::normal(self, uv)
                }
            }
        )+
    };
}

// The inherent methods are meant; `<Sphere>::closest` prefers them to those of the trait.
forward!(
    [] Sphere => Sphere,
    [] RoundedCone => RoundedCone,
    [] BilinearPatch => BilinearPatch,
    [] Triangle => Triangle,
    [] Point => Point,
    [] Line => Line,
    [] Quad => Quad,
    [<P: Primitive + ?Sized>] &P => P,
);
// For lists of shapes of different types, such as `Vec<Box<dyn Primitive + Sync>>`.
#[cfg(feature = "std")]
forward!([<P: Primitive + ?Sized>] std::boxed::Box<P> => P,);
