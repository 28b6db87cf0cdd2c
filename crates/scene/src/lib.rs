//! Scenes of points, lines, triangles and quads: plain arrays, rays through them, and what is where
//! a ray meets them.
//!
//! [`load`] reads the scenes of yocto-gl. [`Trees`] finds the first [`SceneHit`] of a ray. The `eval_`
//! functions of [`Scene`] tell position, normals, tangents, texture coordinates, colour and material of a
//! point that is named by instance, element and `uv`, and by nothing else.
//!
//! # Parameters
//!
//! `uv` are the parameters of the primitive, both in `0.0..=1.0`, without a jump but where something closes:
//!
//! ```text
//!  sphere, a globe        rounded cone, a striped tube         patch             triangle   two triangles
//!
//!     v = 0 (+y)             v: around the axis, 2 pi v        p01 ------ p11      p2         p3 ---- p2
//!      .------.               .---------___                     |  ^     /         | \         | \  2  |
//!    .'        '.           .'   :         ---.                 | v|    /        ^ |  \      ^ |   \   |
//!   |  u: 2 pi u |    u = 0 (    :   u -->   : ) u = 1          |  +-->/         v |   \     v | 1   \ |
//!    '. x to z .'           '.   :      ___---'                 |   u /            p0 - p1     p0 ---- p1
//!      '------'               '---------                       p00 - p10           u -->       u -->
//!     v = 1 (-y)            cap p0   body   cap p1
//! ```
//!
//! - A sphere has longitude `2 pi u` from x towards z, and polar angle `pi v` from +y: as an environment is
//!   laid out. A vanilla point has no parameters, `uv = 0`.
//! - A rounded cone has, in `u`, the length along its profile from the pole of the cap about the first vertex
//!   over the body to the other pole, as a fraction, so caps and body join without a jump; and in `v` the
//!   angle around the axis. A vanilla line has in `u` the fraction of the way along its axis, and in `v` how
//!   far beside it the ray passes, in radii; its position is on the axis.
//! - A patch is bilinear: `u` from `p00` to `p10`, `v` from `p00` to `p01`. Two triangles share the square: the
//!   first where `u + v <= 1`.
//! - A triangle has the weights of its second and third vertex.
//!
//! Without texture coordinates at the vertices these parameters are the texture coordinates. With them,
//! patches interpolate bilinearly, triangles linearly, tubes along the axis, and a point has its own.
//!
//! The point and the normal of a hit come by two routes: carried with the [`SceneHit`], or rebuilt from
//! `uv` by [`Scene::eval_position`] and [`Scene::eval_normal`]; [`Trees::with_route`] chooses. Both name the same point: they are within
//! `error + 2^-22 (size + distance)` of each other, with the error of the hit, the size of the element in the
//! world and its distance from the origin; the normals within 1e-6 radians, times what the frame flattens, and
//! what the normal turns while `uv` change by 2^-22, which is much about a fold of a patch or on the cap of a
//! needle. `tests/frames.rs` holds this over more than a million hits of all forms in mirrored, scaled, sheared
//! and far frames; `cargo xtask accuracy --round-trip 50000000` prints it for as many as you like: the
//! worst points are apart by half of what is allowed, the worst normals by a fifth.
//!
//! Whether points, lines and quads are exact shapes or the usual approximations is data: the [`Method`] of
//! each shape, which may be changed at any time.
//!
//! ```
//! use rotund_geometry::glam::{Vec2, vec2};
//! use rotund_scene::{ElementKind, LoadOptions, Method, Trees, load};
//!
//! let mut scene = load("../../scenes/shapes4.json", &LoadOptions::default())?.scene;
//! let trees = Trees::build(&scene)?;
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
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod camera;
mod environment;
mod error;
mod eval;
mod frame;
#[cfg(feature = "load")]
mod generate;
mod hit;
mod intersect;
#[cfg(feature = "load")]
mod load;
mod material;
mod placement;
mod primitive;
mod scene;
mod shape;
mod shape_tree;
mod texture;
mod tiles;
mod validate;

pub use camera::Camera;
pub use environment::Environment;
pub use error::{SceneError, SceneItem};
pub use hit::SceneHit;
pub use intersect::{Route, Trees};
#[cfg(feature = "load")]
pub use load::{LoadError, LoadOptions, LoadProblem, Loaded, NamedBy, load, load_bytes};
pub use material::{Material, MaterialKind, MaterialPoint};
pub use rotund_geometry as geometry;
pub use rotund_geometry::Method;
pub use scene::{Instance, Scene};
pub use shape::{ElementKind, Elements, Radii, Shape};
pub use texture::{Pixels, Texture};
pub use tiles::Tiles;
