//! Linear RGB images: files in and out, and how far two images are apart.
//!
//! - [`Image`] is linear RGB and alpha in `f32`. [`srgb_from_linear`] and [`linear_from_srgb`] are
//!   the transfer function between it and 8-bit files.
//! - With the feature `codecs`, [`Image::read`] and [`Image::write`] handle PNG, JPEG, Radiance HDR
//!   and OpenEXR, and read BMP and TGA. [`decode`] does the same for bytes in memory and keeps the
//!   precision of the file; it refuses sizes that the file cannot hold before it allocates, so
//!   untrusted files are safe.
//! - With the feature `compare`, [`Difference::between`] gives [`Metrics`], the FLIP error of each
//!   pixel, and maps that show where two images differ.
//! - With the feature `serde`, `Metrics` can be serialized.
//!
//! `codecs` and `compare` are default features. Without them the crate has no dependency.
//!
//! # Example
//!
//! ```
//! # #[cfg(all(feature = "codecs", feature = "compare"))]
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use rotund_image::{Difference, Image};
//!
//! # let folder = tempfile::tempdir()?;
//! # let path = |name: &str| folder.path().join(name);
//! # Image::from_fn(64, 48, |x, _| [x as f32 / 64.0, 0.5, 0.5, 1.0]).write(path("reference.exr"))?;
//! # Image::from_fn(64, 48, |x, _| [x as f32 / 60.0, 0.5, 0.5, 1.0]).write(path("render.png"))?;
//! // An EXR file is linear; a PNG file is decoded from sRGB.
//! let reference = Image::read(path("reference.exr"))?;
//! let render = Image::read(path("render.png"))?;
//!
//! let difference = Difference::between(&render, &reference)?;
//! assert!(difference.metrics.luminance_ratio > 1.01);
//! difference.signed_map("render - reference").write(path("difference.png"))?;
//! difference.flip_map().write(path("flip.png"))?;
//! # assert!(path("flip.png").is_file());
//! # Ok(())
//! # }
//! # #[cfg(not(all(feature = "codecs", feature = "compare")))]
//! # fn main() {}
//! ```

#[cfg(feature = "codecs")]
mod codec;
mod color;
#[cfg(feature = "compare")]
mod difference;
#[cfg(feature = "compare")]
mod error;
#[cfg(feature = "compare")]
mod flip;
mod image;
#[cfg(feature = "compare")]
mod legend;
#[cfg(feature = "compare")]
pub mod maps;
#[cfg(feature = "compare")]
mod metrics;
#[cfg(feature = "compare")]
mod opponent;
#[cfg(feature = "compare")]
mod plane;

#[cfg(feature = "codecs")]
pub use codec::{
    DecodeError, Decoded, EXR_ENCODING, EncodeError, Format, ReadError, Samples, WriteError,
    decode, encode, sweep, write_with,
};
pub use color::{linear_from_srgb, linear_from_srgb_table, luminance, srgb_from_linear};
#[cfg(feature = "compare")]
pub use difference::Difference;
#[cfg(feature = "compare")]
pub use error::CompareError;
#[cfg(feature = "compare")]
pub use flip::flip;
pub use image::Image;
#[cfg(feature = "compare")]
pub use metrics::{Metrics, trimmed_relative_error};
#[cfg(feature = "compare")]
pub use plane::Plane;
