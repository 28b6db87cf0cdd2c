//! The traversal stack: children that are still to be visited.
#![expect(
    unsafe_code,
    reason = "initializing the whole stack for each ray would cost more than using it"
)]

use crate::build_range::MAX_DEPTH;
use crate::node::WIDTH;
use crate::simd::StackEntry;
use std::mem::MaybeUninit;

/// Each of at most [`MAX_DEPTH`] nodes on the way down leaves at most `WIDTH - 1` siblings, and the
/// last write covers [`WIDTH`] entries.
const CAPACITY: usize = (MAX_DEPTH + 2) * WIDTH;

/// The memory of a [`Stack`].
pub(crate) type Storage = [MaybeUninit<StackEntry>; CAPACITY];

/// Uninitialized memory for a stack.
#[inline(always)]
pub(crate) fn storage() -> Storage {
    [const { MaybeUninit::uninit() }; CAPACITY]
}

/// A stack of children with the distances at which the ray enters them.
///
/// Invariant: the entries below `len` are initialized, and `len <= CAPACITY`.
///
/// The memory is borrowed, so that the compiler keeps the length in a register.
pub(crate) struct Stack<'a> {
    entries: &'a mut Storage,
    len: usize,
}

impl<'a> Stack<'a> {
    #[inline(always)]
    pub(crate) fn new(storage: &'a mut Storage) -> Self {
        Self { entries: storage, len: 0 }
    }

    #[inline(always)]
    pub(crate) fn push(&mut self, entry: StackEntry) {
        self.entries[self.len].write(entry);
        self.len += 1;
    }

    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<StackEntry> {
        if self.len == 0 {
            return None;
        }
        self.len -= 1;
        // SAFETY: by the invariant, entries below the old `len` are initialized and in the array.
        Some(unsafe { self.entries.get_unchecked(self.len).assume_init() })
    }

    /// The places of the next entries, to be written before [`Self::grow`].
    #[inline(always)]
    pub(crate) fn next(&mut self) -> &mut [MaybeUninit<StackEntry>; WIDTH] {
        self.entries[self.len..]
            .first_chunk_mut()
            .expect("the capacity follows from the depth of the tree")
    }

    /// Pushes the first `count` entries that were written to [`Self::next`].
    ///
    /// # Safety
    ///
    /// They must be initialized, and at most [`WIDTH`].
    #[inline(always)]
    pub(crate) unsafe fn grow(&mut self, count: usize) {
        self.len += count;
    }
}
