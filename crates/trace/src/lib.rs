//! A path tracer.
