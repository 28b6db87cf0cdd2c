//! What is at a point of a surface, named by `(instance, element, uv)`.

mod environment;
mod material;
mod normal;
mod position;
mod texcoord;
mod weights;
