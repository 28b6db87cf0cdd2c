//! Scenes of points, lines, triangles and quads: plain arrays, rays through them, and what is where
//! a ray meets them.
//!
//! [`load`] reads the scenes of yocto-gl. [`Trees`] finds the first [`SceneHit`] of a ray. The `eval_`
//! functions of [`Scene`] tell position, normal, texture coordinates and material of a point that is named
//! by instance, element and `uv`; `uv` are the parameters of the primitive, in the units of its own
//! `position`: longitude and polar angle of a sphere, along the profile and around the axis of a rounded
//! cone, the two sides of a patch.
//!
//! Whether points, lines and quads are exact shapes or the usual approximations is data: the [`Method`] of
//! each shape, which may be changed at any time.
//!
//! ```
//! use rotund_geometry::glam::{Vec2, vec2};
//! use rotund_scene::{ElementKind, LoadOptions, Method, Trees, load};
//!
//! let mut scene = load("../../scenes/shapes4.json", &LoadOptions::default())?.scene;
//! let trees = Trees::build(&scene);
//! // Through the middle of the thick points.
//! let ray = scene.cameras[1].ray(vec2(0.5, 0.47), Vec2::ZERO);
//! for method in [Method::Vanilla, Method::Enhanced] {
//!     scene.set_method(ElementKind::Points, method);
//!     if let Some(hit) = trees.closest(&scene, &ray) {
//!         let material = scene.eval_material(hit.instance, hit.element, hit.uv);
//!         let normal = scene.shading_normal(&hit, -ray.direction);
//!         assert!(normal.dot(ray.direction) < 0.0 && material.opacity == 1.0);
//!     }
//! }
//! # Ok::<(), rotund_scene::LoadError>(())
//! ```

mod camera;
mod environment;
mod eval;
mod frame;
mod generate;
mod intersect;
mod load;
mod material;
mod primitive;
mod scene;
mod shape;
mod texture;

pub use camera::Camera;
pub use environment::Environment;
pub use intersect::{SceneHit, Trees};
pub use load::{LoadError, LoadOptions, Loaded, NamedBy, load};
pub use material::{Material, MaterialKind, MaterialPoint};
pub use scene::{Instance, Scene};
pub use shape::{ElementKind, Elements, Method, Shape};
pub use texture::{Pixels, Texture};
