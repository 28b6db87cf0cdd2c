//! Queries whose result is written to a place of the caller.
//!
//! A hit that is returned by value is copied on its way up, and a copy right after the store stalls
//! on store-to-load forwarding.

use crate::found::PrimitiveHit;
use crate::simd::{Simd, WithSimd};

/// Runs a query and writes its result to a place.
pub(super) struct WriteTo<'a, T> {
    pub(super) place: &'a mut Option<PrimitiveHit>,
    pub(super) query: T,
}

impl<T: WithSimd<Output = Option<PrimitiveHit>>> WithSimd for WriteTo<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        *self.place = self.query.run(simd);
    }
}
