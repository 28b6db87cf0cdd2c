//! A path tracer for scenes of spheres, rounded cones and bilinear patches.
//!
//! A [`World`] holds a scene with its trees and lights. [`World::render`] traces paths from a
//! camera: at each vertex one direction is sampled from the [`Lights`] and one from the [`Bsdf`],
//! combined by multiple importance sampling. Where smooth glass or metal casts light, paths from
//! the lights join them, and lights are sampled through balls of glass. The result is a [`Film`],
//! whose sums are exact: any order of samples, any number of threads, any interruption and any
//! division into [`Shard`]s makes the same bits. [`output`] writes pictures and checkpoints.
//!
//! A custom integrator starts its paths with [`camera_ray`], takes its random numbers from a
//! [`Sampler`], and fills a film by [`Film::accumulate`]; [`Lights`] shows how to combine light and
//! BSDF samples. The examples of this crate have a whole one.
//!
//! Conventions: directions `incoming` (to the light) and `outgoing` (to the eye) point away from
//! the surface and have unit length; radiance is linear Rec. 709; a pdf is per solid angle unless
//! its name says `pdf_area`; random numbers are uniform in `0.0..1.0`.
//!
//! ```
//! use rotund_trace::scene::{Camera, Environment, Scene};
//! use rotund_trace::{Options, World};
//!
//! let sky = Environment {
//!     name: "sky".into(),
//!     world_from_environment: Default::default(),
//!     emission: [0.2, 0.4, 0.8].into(),
//!     emission_tex: None,
//! };
//! let scene =
//!     Scene { cameras: vec![Camera::default()], environments: vec![sky], ..Scene::default() };
//! let options = Options { width: 3, height: 2, samples: 4, ..Options::default() };
//! let film = World::new(&scene)?.render(0, &options)?;
//! assert_eq!(film.image().pixels[0], [0.2, 0.4, 0.8, 1.0]);
//! # Ok::<(), rotund_trace::RenderError>(())
//! ```

pub mod bsdf;
mod camera_ray;
mod context;
mod distribution;
mod error;
mod false_color;
mod film;
mod layers;
mod light;
mod light_path;
mod medium;
mod mis;
mod near;
mod opacity;
mod options;
pub mod output;
mod path;
pub mod phase;
mod render;
#[cfg(test)]
mod same_light;
mod sampler;
mod sensor;
mod shadow;
mod shard;
mod stage;
mod vertex;
mod view;
pub mod warp;
mod world;

pub use bsdf::{Bsdf, BsdfSample, BsdfValue};
pub use camera_ray::camera_ray;
pub use error::{FilmError, RenderError};
pub use film::{Film, FilmHeader, FilmSample, MergeError, Origin, Progress};
pub use layers::Layers;
pub use light::{LightSample, LightSource, Lights, Receiver};
pub use mis::power_heuristic;
pub use options::Options;
pub use rotund_image::{self as image, Image};
pub use rotund_scene as scene;
pub use sampler::{Sampler, Sequence};
pub use shard::{Shard, ShardSet};
pub use stage::Stage;
pub use view::{UnknownView, View};
pub use world::World;
