//! The usual approximations of points, lines and quads, as yocto-gl and many other renderers define
//! them.
//!
//! | shape | definition | approximates |
//! | --- | --- | --- |
//! | [`Point`] | a disc that faces every ray | [`Sphere`](crate::Sphere) |
//! | [`Line`] | a ribbon that faces every ray | [`RoundedCone`](crate::RoundedCone) |
//! | [`Quad`] | two triangles | [`BilinearPatch`](crate::BilinearPatch) |
//!
//! The `t` of a point or a line differs from that of the round shape by up to the radius, and
//! neither has normals of a solid or an inside that could refract light. A line has no caps: rays
//! along its axis miss. A quad is another surface than the patch wherever its corners are not in a
//! plane.
//!
//! These shapes, too, are computed in `f64`, so that a comparison with the round shapes shows the
//! difference between the shapes and not that between roundings, and the triangles of a quad are as
//! watertight as patches. Relative to the plain `f32` forms, a point costs the same. A quad costs
//! 0.7 times as much as Möller and Trumbore's triangles with a cold branch predictor, for rays that
//! are traced once, and 1.3 times with a warm one, for rays that repeat. A line costs up to 1.5
//! times as much: its cross products, which do not cancel for distant rays, take twice the
//! multiplications of the dot products of the plain form.
//!
//! Source: F. Pellacini, G. Nazzaro, E. Carra, "Yocto/GL", 2019.

mod line;
mod point;
mod quad;

pub use line::Line;
pub use point::Point;
pub use quad::Quad;
