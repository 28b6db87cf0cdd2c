//! Ctrl-C: the first ends a render early, and its samples are written; the second ends the program
//! at once.

use std::fmt;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);
static LISTENING: OnceLock<()> = OnceLock::new();

/// Exit code of a program that was interrupted: 128 plus the number of the signal.
pub(crate) const EXIT_CODE: u8 = 130;

/// Proof that the handler of Ctrl-C is installed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cancel(());

impl Cancel {
    /// Installs the handler: from now on the first Ctrl-C is a request.
    pub(crate) fn listen() -> Self {
        LISTENING.get_or_init(|| {
            let handler = || {
                if REQUESTED.swap(true, Ordering::Relaxed) {
                    std::process::exit(i32::from(EXIT_CODE));
                }
            };
            // If no handler can be installed, Ctrl-C ends the program as it does by default.
            let _ = ctrlc::set_handler(handler);
        });
        Self(())
    }

    /// Returns true if Ctrl-C was pressed.
    pub(crate) fn requested(self) -> bool {
        REQUESTED.load(Ordering::Relaxed)
    }
}

/// The error of a command that Ctrl-C interrupted. Its text says what was written.
#[derive(Clone, Debug)]
pub struct Cancelled(pub String);

impl fmt::Display for Cancelled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "interrupted; {}", self.0)
    }
}

impl std::error::Error for Cancelled {}
