//! Scenes of points, lines, triangles and quads.

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
