//! How two pictures differ: numbers, and maps that show where.

pub(crate) mod metrics;
