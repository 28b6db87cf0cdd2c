//! A path tracer for scenes of spheres, rounded cones and bilinear patches.

mod film;
pub mod output;
mod render;
mod sampler;

pub use film::{Film, Image};
pub use render::{Options, Progress, picture_size};
pub use sampler::{Sampler, Sequence};
