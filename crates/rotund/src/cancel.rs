//! Ctrl-C, SIGTERM and SIGHUP: the first ends a render early, and its samples are written; the
//! second ends the program at once. SIGXFSZ, of a file that is as large as `ulimit -f` allows, ends
//! nothing: the write fails.

use crate::exit;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

static REQUESTED: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Proof that the signals are handled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cancel(&'static AtomicBool);

impl Cancel {
    /// Installs the handlers: from now on the first signal is a request.
    pub(crate) fn listen() -> Self {
        let requested = REQUESTED.get_or_init(|| {
            let requested = Arc::new(AtomicBool::new(false));
            for signal in signals() {
                // In this order, the second signal finds the request of the first. If no handler
                // can be installed, the signal ends the program as it does by default.
                let code = i32::from(exit::INTERRUPTED);
                let exits =
                    flag::register_conditional_shutdown(signal, code, Arc::clone(&requested));
                if exits.is_ok() {
                    let _ = flag::register(signal, Arc::clone(&requested));
                }
            }
            requested
        });
        Self(requested)
    }

    /// Returns true if a signal has come.
    pub(crate) fn requested(self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Makes a file that grows beyond the limit of the process (`ulimit -f`) an error of the write, not
/// the end of the program.
pub(crate) fn survive_large_files() {
    #[cfg(unix)]
    {
        static SURVIVES: OnceLock<()> = OnceLock::new();
        SURVIVES.get_or_init(|| {
            // Nobody reads the flag: any handler will do. Without one the signal still ends the
            // program.
            let _ = flag::register(signal_hook::consts::signal::SIGXFSZ, Arc::default());
        });
    }
}

/// Returns the signals that ask for an end.
fn signals() -> Vec<i32> {
    let mut signals = vec![SIGINT, SIGTERM];
    #[cfg(unix)]
    if !is_ignored(signal_hook::consts::SIGHUP) {
        signals.push(signal_hook::consts::SIGHUP);
    }
    signals
}

/// Returns true if this process was started with the signal ignored, as `nohup` does with SIGHUP.
/// Only Linux tells.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}
