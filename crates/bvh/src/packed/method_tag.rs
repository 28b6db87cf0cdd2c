//! Methods as types.

use rotund_geometry::Method;

/// A [`Method`] as a type, so that traversal is compiled separately for each method. The trait
/// cannot be named outside this crate.
pub trait MethodTag {
    /// The method.
    const METHOD: Method;
}

/// The tag of [`Method::Enhanced`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Enhanced;

impl MethodTag for Enhanced {
    const METHOD: Method = Method::Enhanced;
}

/// The tag of [`Method::Vanilla`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vanilla;

impl MethodTag for Vanilla {
    const METHOD: Method = Method::Vanilla;
}
