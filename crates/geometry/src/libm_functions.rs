//! Roots and angles from `libm`, for builds without `std`, since `core` does not have them.
//!
//! The trait has the names of the methods of `f64` in `std`, so that the same calls compile with
//! both.

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
