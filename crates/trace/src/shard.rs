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

    /// Returns the number in the whole picture of the `sample`-th sample of this shard; for samples
    /// from [`Self::share_of`] on, which no picture has, at most [`u32::MAX`].
    #[must_use]
    pub fn sample_index(self, sample: u32) -> u32 {
        self.index.saturating_add(sample.saturating_mul(self.count))
    }
}

#[cfg(test)]
mod tests {
    use super::Shard;

    #[test]
    fn an_index_beyond_all_pictures_is_the_largest() {
        let shard = Shard { index: 1, count: u32::MAX };
        assert_eq!([0, 1, 5].map(|sample| shard.sample_index(sample)), [1, u32::MAX, u32::MAX]);
        assert_eq!(Shard { index: 2, count: 3 }.sample_index(4), 14);
    }
}
