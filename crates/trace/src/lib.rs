//! A path tracer for scenes of spheres, rounded cones and bilinear patches.
//!
//! [`render`] follows paths from a camera: at each vertex one direction is drawn from the [`Lights`] and
//! one from the [`Bsdf`], joined by multiple importance sampling. What it leaves is a [`Film`], whose sums
//! are exact: any order of samples, any number of threads, any interruption and any division into
//! [`Shard`]s makes the same bits. [`output`] writes pictures and checkpoints.
//!
//! Conventions: directions `incoming` (to the light) and `outgoing` (to the eye) point away from the
//! surface; radiance is linear Rec. 709; a pdf is per solid angle unless its name says `pdf_area`.
//!
//! ```
//! use rotund_scene::{Camera, Environment, Scene, Trees};
//! use rotund_trace::{Lights, Options, render};
//! use std::ops::ControlFlow;
//!
//! let sky = Environment {
//!     name: "sky".into(),
//!     world_from_environment: Default::default(),
//!     emission: [0.2, 0.4, 0.8].into(),
//!     emission_tex: None,
//! };
//! let scene =
//!     Scene { cameras: vec![Camera::default()], environments: vec![sky], ..Scene::default() };
//! let (trees, lights) = (Trees::build(&scene)?, Lights::build(&scene));
//! let options = Options { width: 3, height: 2, samples: 4, ..Options::default() };
//! let film = render(&scene, &trees, &lights, 0, &options, &mut |progress| {
//!     println!("{} samples after {:?}", progress.film.samples, progress.elapsed);
//!     ControlFlow::Continue(())
//! });
//! assert_eq!(film.image().pixels[0], [0.2, 0.4, 0.8, 1.0]);
//! # Ok::<(), rotund_scene::SceneError>(())
//! ```

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
mod view;
pub mod warp;

pub use bsdf::{Bsdf, BsdfSample, BsdfValue};
pub use film::{Film, MergeError, Shard};
pub use light::Lights;
pub use mis::power_heuristic;
pub use render::{Options, Progress, render, resume};
pub use rotund_image::{self as image, Image};
pub use rotund_scene as scene;
pub use sampler::{Sampler, Sequence};
pub use view::{Layers, View, layers};
