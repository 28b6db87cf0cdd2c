//! Image files: PNG and JPEG for screens, OpenEXR and Radiance HDR for linear light.

mod decode;
mod encode;
mod error;
mod file;
mod format;
mod hdr;
mod openexr;

pub use decode::{Decoded, Samples, decode};
pub use encode::{EXR_ENCODING, encode};
pub use error::{DecodeError, EncodeError, ReadError, WriteError};
pub use file::write_with;
pub use format::Format;
