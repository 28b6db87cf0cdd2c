//! Measures speed against error of every intersector, and how fast trees are built and walked.

pub mod accuracy;
pub mod placement;
pub mod rays;
