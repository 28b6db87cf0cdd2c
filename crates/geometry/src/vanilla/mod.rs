//! The usual approximations of points, lines and quads, as yocto-gl and many others draw them.
//!
//! | shape | is | in place of | what it costs |
//! | --- | --- | --- | --- |
//! | [`Point`] | a disc that faces every ray | [`Sphere`](crate::Sphere) | `t` is off by up to the radius, no normal, nothing to refract |
//! | [`Line`] | a ribbon that faces every ray | [`RoundedCone`](crate::RoundedCone) | the same, and no caps: rays along the axis pass |
//! | [`Quad`] | two triangles | [`BilinearPatch`](crate::BilinearPatch) | another surface wherever the quad is not flat |
//!
//! They are approximations of the round shapes, not of themselves: the definitions on their pages are
//! evaluated in `f64` too.
//!
//! Source: F. Pellacini, G. Nazzaro, E. Carra, "Yocto/GL", 2019.

mod line;
mod point;
mod quad;

pub use line::Line;
pub use point::Point;
pub use quad::Quad;
