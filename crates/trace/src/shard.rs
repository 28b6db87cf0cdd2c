//! Division of the samples of a picture among several runs.

/// A residue class of the samples of a picture: every `count`-th sample, from sample `index` on.
///
/// The shards of one picture can be rendered on any machine at any time. [`crate::Film::merge`]
/// joins their films to the film of an undivided render, bit for bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Shard {
    /// Number of the shard, less than `count`.
    pub index: u32,
    /// Number of shards of the picture, at least 1.
    pub count: u32,
}

impl Default for Shard {
    /// The only shard of an undivided picture.
    fn default() -> Self {
        Self { index: 0, count: 1 }
    }
}

impl Shard {
    /// Returns how many of the first `samples` samples of a picture belong to this shard.
    #[must_use]
    pub fn share_of(self, samples: u32) -> u32 {
        samples.saturating_sub(self.index).div_ceil(self.count.max(1))
    }

    /// Returns the number in the whole picture of the `sample`-th sample of this shard.
    #[must_use]
    pub fn sample_index(self, sample: u32) -> u32 {
        self.index + sample * self.count
    }
}
