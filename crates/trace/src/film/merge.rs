//! Joining the shards of a picture.

use super::Film;
use crate::Shard;

/// A reason why films do not join to one picture. Films are numbered from 1 in the order of the
/// call, shards by their index, from 0; messages count both from 1.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages describe variants and fields")]
#[non_exhaustive]
pub enum MergeError {
    #[error("there is no film to merge")]
    Nothing,
    #[error("film {number} differs from film 1 in size, seed, label or shard count")]
    Different { number: usize },
    #[error("shard {}/{count} is there {times} times, not once", index + 1)]
    Shards { index: u32, count: u32, times: usize },
    #[error("shard {} has {samples} samples, not {expected}: it is not finished", index + 1)]
    Unfinished { index: u32, samples: u32, expected: u32 },
}

impl Film {
    /// Joins all shards of a picture, in any order, to the film of an undivided render, bit for
    /// bit.
    ///
    /// # Errors
    ///
    /// If the films are not all shards of one picture, each once and with all of its samples.
    pub fn merge(films: &[Self]) -> Result<Self, MergeError> {
        let first = films.first().ok_or(MergeError::Nothing)?;
        let picture = |film: &Self| {
            (film.width, film.height, film.seed, film.shard.count, film.label.clone())
        };
        if let Some(other) = films.iter().position(|film| picture(film) != picture(first)) {
            return Err(MergeError::Different { number: other + 1 });
        }
        let count = first.shard.count;
        for index in 0..count {
            let times = films.iter().filter(|film| film.shard.index == index).count();
            if times != 1 {
                return Err(MergeError::Shards { index, count, times });
            }
        }
        let samples = films.iter().fold(0_u32, |sum, film| sum.saturating_add(film.samples));
        for film in films {
            let (index, expected) = (film.shard.index, film.shard.share_of(samples));
            if film.samples != expected || !film.is_even() {
                return Err(MergeError::Unfinished { index, samples: film.samples, expected });
            }
        }
        let mut sum = Self { shard: Shard::default(), ..first.clone() };
        for film in &films[1..] {
            sum.rejected += film.rejected;
            sum.fireflies += film.fireflies;
            sum.clamped += film.clamped;
            for (pixel, part) in sum.pixels.iter_mut().zip(&film.pixels) {
                pixel.merge(part);
            }
        }
        sum.count_samples();
        Ok(sum)
    }
}
