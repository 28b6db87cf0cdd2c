//! Linear RGB images: files in and out, and how far two images are apart.

mod codec;
pub mod color;
pub mod convolve;
mod difference;
mod flip;
mod legend;
mod linear_image;
pub mod maps;
pub mod metrics;
mod picture;

pub use codec::{ENCODING, OutputError, srgb_from_linear, write_image, write_with};
pub use difference::Difference;
pub use linear_image::Image;
pub use picture::{Picture, write_png};
