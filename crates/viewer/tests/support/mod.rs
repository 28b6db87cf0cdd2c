//! What the tests of viewers share.

use rotund_viewer::{Output, Request, Session};
use std::time::{Duration, Instant};

/// Longer than any answer takes, on a busy machine too.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);

/// Returns the first output that `wanted` accepts, and shows all frames before it.
pub(crate) fn wait_for<T>(
    session: &Session,
    what: &str,
    mut wanted: impl FnMut(&Output) -> Option<T>,
) -> T {
    let end = Instant::now() + PATIENCE;
    while Instant::now() < end {
        let Some(output) = session.next(Duration::from_millis(200)) else { continue };
        if let Output::Frame(frame) = &output {
            session.request(Request::Shown { frame: frame.header.id });
        }
        if let Some(found) = wanted(&output) {
            return found;
        }
    }
    panic!("no {what} after {PATIENCE:?}");
}
