//! Image files: PNG and JPEG for screens, OpenEXR and Radiance HDR for linear light.

mod content;
mod decode;
mod decoded;
mod encode;
mod error;
mod file;
mod format;
mod hdr;
mod openexr;
mod replace;
mod size;

pub use decode::decode;
pub use decoded::{Decoded, Samples};
pub use encode::{EXR_ENCODING, encode};
pub use error::{DecodeError, EncodeError, ReadError, WriteError};
pub use format::Format;
pub use replace::{sweep, write_with};
