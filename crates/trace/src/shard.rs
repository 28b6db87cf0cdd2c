//! Division of the samples of a picture among several runs.

use std::fmt;

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

/// Some of the shards of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShardSet {
    count: u32,
    /// In increasing order, each less than `count`; at least one.
    indices: Vec<u32>,
}

impl From<Shard> for ShardSet {
    fn from(shard: Shard) -> Self {
        Self { count: shard.count, indices: vec![shard.index] }
    }
}

impl ShardSet {
    /// Returns the set of these shards of `count`, or `None` if they are not in increasing order,
    /// out of range, or none.
    pub(crate) fn new(count: u32, indices: Vec<u32>) -> Option<Self> {
        let increases = indices.windows(2).all(|pair| pair[0] < pair[1]);
        let fits = indices.last().is_some_and(|&last| last < count);
        (increases && fits).then_some(Self { count, indices })
    }

    /// Returns the number of shards of the picture.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Returns the numbers of the shards of the set, from 0, in increasing order.
    #[must_use]
    pub fn indices(&self) -> &[u32] {
        &self.indices
    }

    /// Returns the shard of a set of one.
    #[must_use]
    pub fn only(&self) -> Option<Shard> {
        match self.indices[..] {
            [index] => Some(Shard { index, count: self.count }),
            _ => None,
        }
    }

    /// Returns how many of the first `samples` samples of a picture belong to these shards.
    #[must_use]
    pub fn share_of(&self, samples: u32) -> u32 {
        let share = |&index: &u32| Shard { index, count: self.count }.share_of(samples);
        // The shares of different shards are disjoint, so the sum is at most `samples`.
        self.indices.iter().map(share).sum()
    }

    /// Returns the first shard that both sets hold.
    pub(crate) fn first_common(&self, other: &Self) -> Option<u32> {
        self.indices.iter().copied().find(|index| other.indices.binary_search(index).is_ok())
    }

    /// Returns the set of the shards of both; all shards of a picture are its only one.
    pub(crate) fn union(&self, other: &Self) -> Self {
        let mut indices = [&self.indices[..], &other.indices].concat();
        indices.sort_unstable();
        indices.dedup();
        if indices.len() == self.count as usize {
            return Shard::default().into();
        }
        Self { count: self.count, indices }
    }
}

impl fmt::Display for ShardSet {
    /// Counts shards from 1 and joins neighbours: `shard 2/8`, `shards 1-3 and 7 of 8`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.only() {
            Some(Shard { index, count }) => write!(f, "shard {}/{count}", u64::from(index) + 1),
            None => write!(f, "shards {} of {}", ranges(&self.indices), self.count),
        }
    }
}

/// Writes increasing numbers, counted from 1 instead of 0, as ranges.
fn ranges(indices: &[u32]) -> String {
    let runs = indices.chunk_by(|a, b| a + 1 == *b).map(|run| {
        let [first, last] = [run[0], run[run.len() - 1]].map(|index| u64::from(index) + 1);
        if first == last { first.to_string() } else { format!("{first}-{last}") }
    });
    let mut runs: Vec<String> = runs.collect();
    match runs.pop() {
        Some(last) if !runs.is_empty() => format!("{} and {last}", runs.join(", ")),
        last => last.unwrap_or_default(),
    }
}

#[cfg(test)]
mod tests {
    use super::{Shard, ShardSet};

    #[test]
    fn an_index_beyond_all_pictures_is_the_largest() {
        let shard = Shard { index: 1, count: u32::MAX };
        assert_eq!([0, 1, 5].map(|sample| shard.sample_index(sample)), [1, u32::MAX, u32::MAX]);
        assert_eq!(Shard { index: 2, count: 3 }.sample_index(4), 14);
    }

    #[test]
    fn a_set_is_written_in_ranges_counted_from_one() {
        let table: [(&[u32], &str); 4] = [
            (&[1], "shard 2/8"),
            (&[0, 1, 2], "shards 1-3 of 8"),
            (&[0, 2], "shards 1 and 3 of 8"),
            (&[0, 1, 4, 6, 7], "shards 1-2, 5 and 7-8 of 8"),
        ];
        for (indices, text) in table {
            let set = ShardSet::new(8, indices.to_vec()).expect("shards of 8");
            assert_eq!(set.to_string(), text);
        }
    }

    #[test]
    fn what_is_no_set_of_shards_is_refused() {
        for (count, indices) in
            [(0, vec![]), (0, vec![0]), (3, vec![]), (3, vec![3]), (3, vec![1, 1]), (3, vec![2, 1])]
        {
            assert_eq!(ShardSet::new(count, indices.clone()), None, "{indices:?} of {count}");
        }
    }

    #[test]
    fn all_shards_together_are_the_undivided_picture() {
        let set = |indices: &[u32]| ShardSet::new(4, indices.to_vec()).expect("shards of 4");
        let half = set(&[0, 3]).union(&set(&[1]));
        assert_eq!((half.indices(), half.share_of(10)), (&[0, 1, 3][..], 3 + 3 + 2));
        assert_eq!(half.union(&set(&[2])), Shard::default().into());
        assert_eq!(half.first_common(&set(&[2, 3])), Some(3));
        assert_eq!(half.first_common(&set(&[2])), None);
    }
}
