//! Scenes of points, lines, triangles and quads.

mod camera;
mod environment;
mod material;
mod scene;
mod shape;
mod texture;

pub use camera::Camera;
pub use environment::Environment;
pub use material::{Material, MaterialKind, MaterialPoint};
pub use scene::{Instance, Scene};
pub use shape::{ElementKind, Elements, Method, Shape};
pub use texture::{Pixels, Texture};
