//! Golden pictures: small stored renders that a test compares with.
//!
//! A [`Suite`] is a set of scenes, made in code or read from files, and a folder of references.
//! [`Suite::check`] renders each scene and fails if a picture differs from its reference; the error
//! lists what differs, and a page shows it. With `ROTUND_BLESS=1` in the environment, or by
//! [`Suite::bless`], pictures are accepted as they are. The README has an example of a test.
//!
//! # How a picture is compared
//!
//! A picture of a path tracer is random. To demand equal pixels would fail for another processor,
//! thread count or sampler; to allow a fixed tolerance would hide faults that are smaller. So a
//! check renders with *other* random numbers than the reference, and asks how probable the
//! difference is.
//!
//! - **Light**. A check renders [`REPLICAS`] small pictures that differ in their seed, a reference
//!   [`REFERENCE_REPLICAS`]. Their spread gives the standard error of each pixel, and Student's
//!   t-test the probability that noise alone makes a difference as large. Pixels, blocks of 8 x 8
//!   pixels, and the whole picture are tested: small faults show in pixels, faint ones in means.
//!   The mean FLIP error must not exceed that of the noise, which finds visible changes of another
//!   shape.
//! - **Surfaces**. Sixteen fixed rays per pixel find coverage, number of surfaces, shadows, depth,
//!   normals, texture coordinates and colours. These have no noise, so a single wrong ray fails.
//!
//! **False alarms**: the t-tests of a run over a whole suite in which nothing changed fail with a
//! probability of at most [`FALSE_ALARMS`], 1 in 1000, by Bonferroni's inequality over all tests of
//! all pictures. FLIP has a margin instead of a probability: its limit lies half above the measured
//! noise. The random numbers of a check are fixed, so a check that passes keeps passing until
//! something changes.
//!
//! **Smallest loss found**: a picture that lost [`SMALLEST_LOSS`], 1 %, of its light fails with a
//! probability of at least 99 %. A picture that is too noisy for that is refused when it is
//! accepted, and samples are doubled before, so the check of every picture is that sharp.
//!
//! # Cost
//!
//! A picture of 96 x 54 pixels takes some tenths of a second to check and eight times as long to
//! accept.

mod bless;
mod case;
mod check;
mod error;
mod moments;
mod page;
mod probe;
mod reference;
mod significance;
mod subject;
mod suite;
mod surface;
#[cfg(test)]
mod tests;
mod verdict;

pub use bless::{Blessed, MISSED_LOSSES, SMALLEST_LOSS};
pub use case::{Case, Source};
pub use check::{Check, Finding};
pub use error::{Failed, GoldenError, Refused};
pub use moments::Moments;
pub use page::{Failure, failure_page};
pub use reference::Reference;
pub use rotund_scene as scene;
pub use significance::FALSE_ALARMS;
pub use suite::{Judged, Outcome, Settings, Suite, write_page};
pub use surface::Surface;
pub use verdict::Verdict;

/// Number of replicas of a check. Fewer would give Student's t heavy tails. More would leave fewer
/// samples to each, and the samples of one render are better stratified than those of two.
pub const REPLICAS: u32 = 32;
/// Number of replicas of a reference. Its noise adds an eighth to the variance of a check.
pub const REFERENCE_REPLICAS: u32 = 256;
/// Seed of references. A check may use any other.
pub const REFERENCE_SEED: u32 = 0;
/// Environment variable that makes [`Suite::check`] accept the pictures as they are.
pub const BLESS_VARIABLE: &str = "ROTUND_BLESS";
