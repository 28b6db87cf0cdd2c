//! Ctrl-C: a render stops at the next pass and what there is is written. A second Ctrl-C ends the
//! program at once.

use std::fmt;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);
static LISTENING: OnceLock<()> = OnceLock::new();

/// The exit code of a program that was interrupted: 128 and the number of the signal.
pub const EXIT_CODE: u8 = 130;

/// Proof that Ctrl-C is listened to.
#[derive(Clone, Copy, Debug)]
pub struct Cancel(());

impl Cancel {
    /// From now on Ctrl-C is a request and no longer the end.
    pub fn listen() -> Self {
        LISTENING.get_or_init(|| {
            let handler = || {
                if REQUESTED.swap(true, Ordering::Relaxed) {
                    std::process::exit(i32::from(EXIT_CODE));
                }
            };
            // Without a handler Ctrl-C ends the program, which is also what was asked for.
            let _ = ctrlc::set_handler(handler);
        });
        Self(())
    }

    /// Whether Ctrl-C was pressed.
    pub fn requested(self) -> bool {
        REQUESTED.load(Ordering::Relaxed)
    }
}

/// The error of work that Ctrl-C has ended: it says what was written.
#[derive(Clone, Debug)]
pub struct Cancelled(pub String);

impl fmt::Display for Cancelled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "interrupted; {}", self.0)
    }
}

impl std::error::Error for Cancelled {}
