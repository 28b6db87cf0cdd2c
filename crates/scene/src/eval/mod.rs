//! Evaluation of surface points, each given by instance, element and `uv`.

mod environment;
mod material;
mod normal;
mod position;
mod texcoord;
mod weights;
