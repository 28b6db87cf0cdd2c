//! The intervals of one ray inside the solids of a tree, in exact order.

use super::Packed;
use super::kernel::{HasIds, Kernel};
use crate::found::Crossing;
use crate::simd::{Simd, WithSimd};
use rotund_geometry::{End, Interval, Ray, Solid};
use std::cmp::Ordering;

/// The interval of a ray inside one solid of a tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) interval: Interval,
    pub(super) id: u32,
    pub(super) block: u32,
    pub(super) lane: u32,
}

/// The solids of a tree along one ray, in exact order.
#[derive(Debug)]
pub(super) struct Pieces<'a, P: Kernel> {
    pub(super) packed: &'a Packed<P>,
    pub(super) ray: &'a Ray,
}

impl<P: Kernel> Clone for Pieces<'_, P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<P: Kernel> Copy for Pieces<'_, P> {}

impl<P: Kernel + Solid + PartialEq> Pieces<'_, P> {
    fn solid(&self, piece: &Piece) -> P {
        P::unpack(&self.packed.blocks[piece.block as usize], piece.lane as usize)
    }

    /// Compares the ends of two intervals.
    #[inline(always)]
    pub(super) fn compare(&self, (a, a_end): (&Piece, End), (b, b_end): (&Piece, End)) -> Ordering {
        let (x, y) = (a.interval.end(a_end), b.interval.end(b_end));
        // False for a NaN.
        if (x - y).abs() > a.interval.error + b.interval.error {
            return if x < y { Ordering::Less } else { Ordering::Greater };
        }
        self.compare_exactly((a, a_end), (b, b_end))
    }

    #[cold]
    #[inline(never)]
    fn compare_exactly(&self, (a, a_end): (&Piece, End), (b, b_end): (&Piece, End)) -> Ordering {
        let (first, second) = (self.solid(a), self.solid(b));
        if a_end == b_end && first == second {
            return Ordering::Equal;
        }
        let exact = (first.interval_exactly(self.ray), second.interval_exactly(self.ray));
        let (Some(x), Some(y)) = exact else { return Ordering::Equal };
        x.compare(a_end, &y, b_end)
    }

    /// Compares an end of an interval with the start of the ray.
    #[inline(always)]
    pub(super) fn compare_with_start(&self, piece: &Piece, end: End) -> Ordering {
        let (x, t) = (piece.interval.end(end), f64::from(self.ray.t_min));
        if (x - t).abs() > piece.interval.error {
            return if x < t { Ordering::Less } else { Ordering::Greater };
        }
        let exact = self.solid(piece).interval_exactly(self.ray);
        exact.map_or(Ordering::Less, |exact| exact.compare_with(end, self.ray.t_min))
    }

    /// Returns whether the ray starts inside the solid.
    #[inline(always)]
    pub(super) fn contains_start(&self, piece: &Piece) -> bool {
        self.compare_with_start(piece, End::Entry) == Ordering::Less
            && self.compare_with_start(piece, End::Exit) != Ordering::Less
    }

    /// Returns whether `piece` ends after `last`, or with it and has a lower id.
    #[inline(always)]
    pub(super) fn ends_later(&self, piece: &Piece, last: &Piece) -> bool {
        match self.compare((piece, End::Exit), (last, End::Exit)) {
            Ordering::Less => false,
            Ordering::Equal => piece.id < last.id,
            Ordering::Greater => true,
        }
    }

    /// Returns whether `piece` begins before `first`, or with it and has a lower id.
    #[inline(always)]
    pub(super) fn begins_earlier(&self, piece: &Piece, first: &Piece) -> bool {
        match self.compare((piece, End::Entry), (first, End::Entry)) {
            Ordering::Less => true,
            Ordering::Equal => piece.id < first.id,
            Ordering::Greater => false,
        }
    }

    /// Returns the crossing at an end of an interval, at any `t`.
    pub(super) fn crossing(&self, piece: &Piece, end: End) -> Option<Crossing> {
        let hit = self.solid(piece).crossing(self.ray, end)?;
        Some(Crossing { id: piece.id, hit, enters: end == End::Entry })
    }
}

/// Returns the interval of the ray inside the solid of a lane.
#[inline(always)]
pub(super) fn piece<S: Simd, P: Kernel + Solid>(
    simd: S,
    pieces: &Pieces<'_, P>,
    index: usize,
    lane: usize,
) -> Option<Piece> {
    let block = &pieces.packed.blocks[index];
    let interval = simd.run_outlined(FindInterval::<P> { block, lane, ray: pieces.ray })?;
    Some(Piece { interval, id: block.ids()[lane], block: index as u32, lane: lane as u32 })
}

struct FindInterval<'a, P: Kernel> {
    block: &'a P::Block,
    lane: usize,
    ray: &'a Ray,
}

impl<P: Kernel + Solid> WithSimd for FindInterval<'_, P> {
    type Output = Option<Interval>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Option<Interval> {
        P::unpack(self.block, self.lane).interval(self.ray)
    }
}
