//! Image files: PNG and JPEG for screens, OpenEXR and Radiance HDR for linear light.

mod decode;
mod encode;
mod error;
mod file;
mod format;
mod replace;

pub use decode::{Decoded, Samples, decode};
pub use encode::{EXR_ENCODING, encode};
pub use error::{DecodeError, EncodeError, ReadError, WriteError};
pub use format::Format;
pub use replace::{sweep, write_with};
