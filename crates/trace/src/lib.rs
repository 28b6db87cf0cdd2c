//! A path tracer for scenes of spheres, rounded cones and bilinear patches.

pub mod bsdf;
mod distribution;
mod film;
mod light;
mod medium;
mod mis;
pub mod output;
mod path;
pub mod phase;
mod render;
mod sampler;
mod shadow;
pub mod warp;

pub use bsdf::{Bsdf, BsdfSample, BsdfValue};
pub use film::{Film, Image};
pub use light::Lights;
pub use mis::power_heuristic;
pub use render::{Options, Progress, render, resume};
pub use sampler::{Sampler, Sequence};
