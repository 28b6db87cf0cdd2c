//! Measurements behind the claims of the workspace: speed against error of every intersector
//! ([`accuracy`]), and how fast trees are built and traversed ([`rays`]).
//!
//! The truth is computed in 106 bits by formulas that share nothing with the code under test, for
//! families of rays that are hard for a known reason; the published methods stand beside our own.

mod baselines;
mod families;
mod random;
mod truth;
// The tests of geometry, which may not depend on this crate, share the numbers of the truth.
#[path = "../../geometry/tests/support/wide.rs"]
mod wide;

pub mod accuracy;
pub mod placement;
pub mod rays;
