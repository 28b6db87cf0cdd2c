//! The children that wait during a walk.
#![expect(
    unsafe_code,
    reason = "clearing the whole stack for each ray would cost more than its use"
)]

use crate::build::MAX_DEPTH;
use crate::node::WIDTH;
use crate::simd::Entry;
use std::mem::MaybeUninit;

/// Each of at most [`MAX_DEPTH`] nodes on the way down leaves at most `WIDTH - 1` siblings; the last
/// write is a whole window long.
const CAPACITY: usize = (MAX_DEPTH + 2) * WIDTH;

/// Room for the entries of a [`Stack`].
pub(crate) type Room = [MaybeUninit<Entry>; CAPACITY];

/// Room that is not written to.
#[inline(always)]
pub(crate) fn room() -> Room {
    [const { MaybeUninit::uninit() }; CAPACITY]
}

/// Law: the entries below `len` are written, and `len <= CAPACITY`.
///
/// The room is apart, so that the length is kept in a register.
pub(crate) struct Stack<'a> {
    entries: &'a mut Room,
    len: usize,
}

impl<'a> Stack<'a> {
    #[inline(always)]
    pub(crate) fn new(room: &'a mut Room) -> Self {
        Self { entries: room, len: 0 }
    }

    #[inline(always)]
    pub(crate) fn push(&mut self, entry: Entry) {
        self.entries[self.len].write(entry);
        self.len += 1;
    }

    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<Entry> {
        if self.len == 0 {
            return None;
        }
        self.len -= 1;
        // SAFETY: the law says that entries below the old `len` are written and in the array.
        Some(unsafe { self.entries.get_unchecked(self.len).assume_init() })
    }

    /// Pushes the entries that `write` puts in front of the window.
    ///
    /// # Safety
    ///
    /// `write` must fill the first `count` entries.
    #[inline(always)]
    pub(crate) unsafe fn extend(
        &mut self,
        count: usize,
        write: impl FnOnce(&mut [MaybeUninit<Entry>; WIDTH]),
    ) {
        let window = self.entries[self.len..]
            .first_chunk_mut()
            .expect("the depth of a tree is bounded, and so is what waits");
        write(window);
        self.len += count;
    }
}
