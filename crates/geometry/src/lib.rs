//! Exact ray intersection of round primitives, beside their usual approximations.

mod aabb;
mod float;
mod ray;

pub use aabb::Aabb;
pub use float::{UNIT_ROUNDOFF, leave_surface};
pub use glam;
pub use ray::{Hit, Ray};
