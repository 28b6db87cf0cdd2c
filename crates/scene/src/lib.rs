//! Scenes of points, lines, triangles and quads: plain arrays, ray queries, and evaluation of
//! surface points.
//!
//! A [`Scene`] is made in code, by [`Shape::points`], [`Scene::add`] and the like, or loaded by
//! [`load`] from files of yocto-gl. [`Trees::build`] validates it and builds the acceleration
//! structure; [`Trees::closest`] finds the first [`SceneHit`] of a ray. The `eval_` functions of
//! [`Scene`] compute position, normals, tangents, texture coordinates, colour and material of a
//! surface point from instance, element and `uv` alone.
//!
//! # Parameters
//!
//! `uv` are the parameters of a primitive, both in `0.0..=1.0`. They are continuous except where a
//! surface closes:
//!
//! ```text
//!  sphere, a globe       rounded cone, a striped tube      patch           triangle  two triangles
//!
//!     v = 0 (+y)            v: around the axis, 2 pi v     p01 ------ p11    p2        p3 ---- p2
//!      .------.              .---------___                  |  ^     /       | \        | \  2  |
//!    .'        '.          .'   :         ---.              | v|    /      ^ |  \     ^ |   \   |
//!   |  u: 2 pi u |   u = 0 (    :   u -->   : ) u = 1       |  +-->/       v |   \    v | 1   \ |
//!    '. x to z .'          '.   :      ___---'              |   u /          p0 - p1    p0 ---- p1
//!      '------'              '---------                    p00 - p10         u -->      u -->
//!     v = 1 (-y)           cap p0   body   cap p1
//! ```
//!
//! - A sphere has longitude `2 pi u` from x towards z and polar angle `pi v` from +y, the layout of
//!   environments. A vanilla point has no parameters: its `uv` is zero.
//! - On a rounded cone, `u` is the arc length along the profile, from the pole of the cap about the
//!   first vertex over the body to the other pole, as a fraction of the whole, so that caps and
//!   body join without a jump; `v` is the angle around the axis. On a vanilla line, `u` is the
//!   fraction of the way along the axis, and `v` the distance at which the ray passes the axis, in
//!   radii; its position is on the axis.
//! - A patch is bilinear: `u` runs from `p00` to `p10`, `v` from `p00` to `p01`. The two triangles
//!   of a vanilla quad share that square: the first covers `u + v <= 1`.
//! - On a triangle, `u` and `v` are the barycentric weights of the second and third vertex.
//!
//! A shape without texture coordinates uses these parameters as texture coordinates. With texture
//! coordinates, patches interpolate them bilinearly, triangles linearly, rounded cones along the
//! axis, and each point has its own.
//!
//! # Carried and rebuilt points
//!
//! Position and normal of a hit are available by two routes: carried with the [`SceneHit`], or
//! rebuilt from `uv` by [`Scene::eval_position`] and [`Scene::eval_normal`]; [`Trees::with_route`]
//! selects one. The two positions are within `error + 2^-22 (size + distance)` of each other, where
//! `error` is that of the hit, `size` the extent of the element in the world, and `distance` that
//! from the origin. The two normals are within 1e-6 radians of each other, times the flattening of
//! the frame, plus the angle by which the normal turns while `uv` changes by 2^-22, which is large
//! at a fold of a patch and on the cap of a needle. `tests/frames.rs` holds this over more than a
//! million hits of all primitives in mirrored, scaled, sheared and far frames; `cargo xtask
//! accuracy --round-trip 50000000` measures it for as many hits as you like: the worst positions
//! are apart by half of the bound, the worst normals by a fifth.
//!
//! # Methods
//!
//! The [`Method`] of each shape says whether its points, lines and quads are the exact shapes or
//! the usual approximations. It can be changed at any time.
//!
//! ```
//! use rotund_geometry::{Ray, glam::Vec3};
//! use rotund_scene::{ElementKind, Material, Method, Scene, SceneError, Shape, Trees};
//!
//! let mut scene = Scene::default();
//! scene.add(Shape::points([Vec3::ZERO], 1.0), Material::default());
//! let trees = Trees::build(&scene)?;
//! let ray = Ray::new(Vec3::new(0.6, 0.0, 5.0), Vec3::NEG_Z);
//! // A vanilla point is a disk that faces the ray, an enhanced one a sphere.
//! for (method, t) in [(Method::Vanilla, 5.0), (Method::Enhanced, 4.2)] {
//!     scene.set_method(ElementKind::Points, method);
//!     let hit = trees.closest(&scene, &ray).expect("both are met");
//!     assert!((hit.t - t).abs() < 1e-6, "{method}: {}", hit.t);
//! }
//! # Ok::<(), SceneError>(())
//! ```
//!
//! # Features
//!
//! `load`, on by default, adds the functions `load` and `load_bytes` with their readers of JSON,
//! PLY, OBJ, SWC, TCK, TRK, points as text and images. Without it the crate depends on Rotund's
//! geometry, trees and colour conversions, `glam` and `rayon` alone.

mod camera;
mod closed;
#[cfg(feature = "load")]
mod direction_color;
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
mod overlap;
mod placement;
mod plate;
mod primitive;
mod scene;
mod shape;
mod shape_tree;
mod texture;
mod tiles;
mod unions;
mod validate;

pub use camera::Camera;
pub use environment::Environment;
pub use error::{SceneError, SceneItem};
pub use hit::SceneHit;
pub use intersect::{Route, Trees};
#[cfg(feature = "load")]
pub use load::{LoadError, LoadOptions, LoadProblem, Loaded, NamedBy, Up, load, load_bytes};
pub use material::{Material, MaterialKind, MaterialPoint};
pub use overlap::Overlap;
pub use rotund_geometry as geometry;
pub use rotund_geometry::Method;
pub use scene::{Instance, Scene};
pub use shape::{ElementKind, Elements, Radii, Shape};
pub use texture::{Pixels, Texture};
pub use tiles::Tiles;
