//! Exit codes, by which a script decides whether to run a command again.

use rotund_image::WriteError;
use rotund_trace::{FilmError, RenderError, output::CheckpointError};
use std::fmt;

/// The command failed, and will again.
pub(crate) const FAILED: u8 = 1;
/// The picture was written, the checkpoint was not.
pub(crate) const NO_CHECKPOINT: u8 = 3;
/// Shards are missing or not finished.
pub(crate) const NOT_FINISHED: u8 = 4;
/// Memory or disk did not suffice.
pub(crate) const NO_ROOM: u8 = 5;
/// A signal interrupted the command: 128 plus the number of SIGINT, for all signals.
pub(crate) const INTERRUPTED: u8 = 130;

/// The exit codes, for the help of a program that reports by [`crate::report`].
pub const EXIT_CODES: &str = "\
Exit codes:
  0    the command succeeded
  1    the command failed, and will again; standard error says why in one line
  2    the command line was not understood
  3    the picture was written, its checkpoint was not; standard error warns
  4    shards are missing or not finished: render them, then merge again
  5    a file could not be written or memory ran out: make room, run it again
  130  Ctrl-C, SIGTERM or SIGHUP interrupted the command; standard error says
       what was written, and --resume continues it

Colours and progress bars are for terminals only; NO_COLOR turns colours off.";

/// The error of a command that a signal interrupted. Its text says what was written.
#[derive(Clone, Debug)]
pub struct Cancelled(pub String);

impl fmt::Display for Cancelled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "interrupted; {}", self.0)
    }
}

impl std::error::Error for Cancelled {}

/// The warning that ends a render whose picture was written, but not its checkpoint.
#[derive(Clone, Debug)]
pub(crate) struct NoCheckpoint(pub(crate) String);

/// The error of a merge of which shards are missing or not finished.
#[derive(Clone, Debug)]
pub(crate) struct NotFinished(pub(crate) String);

/// The error of a command for which there is not enough memory.
#[derive(Clone, Debug)]
pub(crate) struct NoMemory(pub(crate) String);

macro_rules! message {
    ($($error:ty),*) => {$(
        impl fmt::Display for $error {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(&self.0)
            }
        }
        impl std::error::Error for $error {}
    )*};
}
message!(NoCheckpoint, NotFinished, NoMemory);

/// Returns the exit code of a command that failed with this error.
pub(crate) fn code(error: &anyhow::Error) -> u8 {
    let any = |found: fn(&(dyn std::error::Error + 'static)) -> bool| error.chain().any(found);
    if any(|cause| cause.is::<Cancelled>()) {
        INTERRUPTED
    } else if any(|cause| cause.is::<NoCheckpoint>()) {
        NO_CHECKPOINT
    } else if any(|cause| cause.is::<NotFinished>()) {
        NOT_FINISHED
    } else if any(lacks_room) {
        NO_ROOM
    } else {
        FAILED
    }
}

fn lacks_room(cause: &(dyn std::error::Error + 'static)) -> bool {
    let too_large = |error: &FilmError| matches!(error, FilmError::TooLarge { .. });
    let render = cause.downcast_ref::<RenderError>();
    let written = cause.downcast_ref::<WriteError>();
    let loaded = cause.downcast_ref::<CheckpointError>();
    render.is_some_and(|error| matches!(error, RenderError::Film(film) if too_large(film)))
        || written.is_some_and(|error| !matches!(error, WriteError::UnknownFormat { .. }))
        || loaded.is_some_and(|error| matches!(error, CheckpointError::Memory { .. }))
        || cause.downcast_ref().is_some_and(too_large)
        || cause.is::<NoMemory>()
}
