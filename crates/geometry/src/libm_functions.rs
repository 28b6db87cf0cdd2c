//! The functions that `core` does not have, for builds without `std`: there they come from `libm`.
//!
//! With `std` the methods of `f64` itself are meant, which have the same names.

pub(crate) trait Functions {
    fn sqrt(self) -> Self;
    fn hypot(self, other: Self) -> Self;
    fn atan2(self, other: Self) -> Self;
    fn sin_cos(self) -> (Self, Self)
    where
        Self: Sized;
}

impl Functions for f64 {
    #[inline]
    fn sqrt(self) -> Self {
        libm::sqrt(self)
    }

    fn hypot(self, other: Self) -> Self {
        libm::hypot(self, other)
    }

    fn atan2(self, other: Self) -> Self {
        libm::atan2(self, other)
    }

    fn sin_cos(self) -> (Self, Self) {
        libm::sincos(self)
    }
}
