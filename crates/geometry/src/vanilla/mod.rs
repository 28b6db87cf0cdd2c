//! The usual approximations of points, lines and quads, as yocto-gl and many others draw them.
//!
//! | shape | is | in place of | what it costs |
//! | --- | --- | --- | --- |
//! | [`Point`] | a disc that faces every ray | [`Sphere`](crate::Sphere) | `t` is off by up to the radius, no normal, nothing to refract |
//! | [`Line`] | a ribbon that faces every ray | [`RoundedCone`](crate::RoundedCone) | the same, and no caps: rays along the axis pass |
//! | [`Quad`] | two triangles | [`BilinearPatch`](crate::BilinearPatch) | another surface wherever the quad is not flat |
//!
//! They are approximations of the round shapes, not of themselves: the definitions on their pages are
//! evaluated in `f64` too, so that a comparison with the round shapes shows the shapes and not the rounding,
//! and the triangles of a quad are as watertight as patches. Beside the plain `f32` forms, a point costs the same, a
//! quad 0.7 times Möller and Trumbore's triangles on rays that the processor has not seen before (1.3 times
//! on rays that come again and again), and a line up to 1.5 times: its cross products, which do not cancel where the
//! ray is far away, take twice the multiplications of the plain form's dot products.
//!
//! Source: F. Pellacini, G. Nazzaro, E. Carra, "Yocto/GL", 2019.

mod line;
mod point;
mod quad;

pub use line::Line;
pub use point::Point;
pub use quad::Quad;
