//! Exact ray intersection of round primitives, beside their usual approximations.

mod aabb;
mod basis;
mod bilinear_patch;
mod careful_cone;
mod double_double;
mod float;
mod profile;
mod ray;
mod ray_space;
mod rounded_cone;
mod sphere;
mod triangle;
pub mod vanilla;
mod widen;

pub use aabb::Aabb;
pub use bilinear_patch::BilinearPatch;
pub use float::{UNIT_ROUNDOFF, leave_surface};
pub use glam;
pub use ray::{Hit, Ray};
pub use rounded_cone::RoundedCone;
pub use sphere::Sphere;
pub use triangle::Triangle;
