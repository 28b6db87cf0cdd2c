//! The core of an interactive viewer of rotund scenes: it knows neither a browser nor a window.
//!
//! A [`Viewer`] loads a scene and renders it. Each client has a [`Session`]: it passes [`Request`]s
//! on, and gets [`Event`]s and encoded pictures back. All of them are plain data with a JSON form,
//! so that a client may be a page in a browser, a window, or a test.
//!
//! While the camera moves, pictures are previews, whose size follows the speed that the last ones
//! were rendered at. Once it rests, they grow to full size and then gain sample after sample, until
//! the wanted number is there; then nothing is done any more. A picture at rest is the one that
//! [`rotund_trace::World::render`] makes with the same camera and options, bit for bit.

mod bell;
mod board;
mod buffers;
mod content;
mod denoise;
mod develop;
mod engine;
mod inspect;
mod message;
mod outbox;
mod place;
mod publisher;
mod queue;
mod rig;
mod seat;
mod session;
mod settings;
mod shared;
mod side;
mod viewer;
mod watch;

pub use content::Content;
pub use denoise::{Denoise, Guides};
pub use message::{
    Activity, CameraText, Event, Frame, FrameHeader, Inspection, Motion, Output, Request, State,
    Status, Surface,
};
pub use session::Session;
pub use settings::{LONGEST_SIDE, OverlapChoice, Settings, SettingsError};
pub use shared::{SaveError, Snapshot};
pub use side::Side;
pub use viewer::Viewer;
