//! Joining the shards of a picture.

use super::{Film, FilmHeader};
use std::collections::HashMap;

/// A reason why films do not join to one picture. Films are numbered from 1 in the order of the
/// call, shards by their index, from 0; messages count both from 1.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages describe variants and fields")]
#[non_exhaustive]
pub enum MergeError {
    #[error("there is no film to merge")]
    Nothing,
    /// `usual` is a film of the picture that most of the films are of.
    #[error("film {number} is of another picture than film {usual}")]
    Different { number: usize, usual: usize },
    #[error("shard {}/{count} is there {times} times, not once", u64::from(*index) + 1)]
    Twice { index: u32, count: u32, times: usize },
    #[error("{missing} of {count} shards are missing, the first is {}/{count}",
        u64::from(*index) + 1)]
    Missing { index: u32, count: u32, missing: usize },
    #[error("{} of the films are not finished, the first is number {}", numbers.len(),
        numbers.first().unwrap_or(&0))]
    Unfinished { numbers: Vec<usize> },
}

impl FilmHeader {
    /// Checks that films with these headers can be merged. `partial` allows for missing and
    /// unfinished shards.
    ///
    /// # Errors
    ///
    /// If there are none, they are not of one picture, or a shard is there twice; unless `partial`,
    /// also if a shard is missing or not finished.
    pub fn check_merge(headers: &[Self], partial: bool) -> Result<(), MergeError> {
        let mut films_of = HashMap::new();
        for header in headers {
            *films_of.entry(header.picture()).or_insert(0_usize) += 1;
        }
        // The picture that most films are of; of equally many, the first.
        let films = |header: &&Self| films_of[&header.picture()];
        let usual = headers.iter().rev().max_by_key(films).ok_or(MergeError::Nothing)?;
        let position = |same: bool| headers.iter().position(|h| h.same_picture(usual) == same);
        if let Some((odd, usual)) = position(false).zip(position(true)) {
            return Err(MergeError::Different { number: odd + 1, usual: usual + 1 });
        }
        let count = usual.shards.count();
        let mut held: Vec<u32> =
            headers.iter().flat_map(|header| header.shards.indices()).copied().collect();
        held.sort_unstable();
        if let Some(twice) = held.chunk_by(|a, b| a == b).find(|same| same.len() > 1) {
            return Err(MergeError::Twice { index: twice[0], count, times: twice.len() });
        }
        if partial {
            return Ok(());
        }
        let unfinished = headers.iter().zip(1..).filter(|(header, _)| !header.is_finished());
        let numbers: Vec<usize> = unfinished.map(|(_, number)| number).collect();
        if !numbers.is_empty() {
            return Err(MergeError::Unfinished { numbers });
        }
        let missing = count as usize - held.len();
        if missing > 0 {
            let gap = (0..).zip(&held).find(|(index, held)| index != *held);
            let index = gap.map_or(held.len() as u32, |(index, _)| index);
            return Err(MergeError::Missing { index, count, missing });
        }
        Ok(())
    }
}

impl Film {
    /// Joins all shards of a picture, in any order, to the film of an undivided render, bit for
    /// bit. [`FilmHeader::check_merge`] and [`Self::absorb`] do the same with two films in memory
    /// at a time.
    ///
    /// # Errors
    ///
    /// If the films are not all shards of one picture, each once and with all of its samples.
    pub fn merge(films: &[Self]) -> Result<Self, MergeError> {
        let headers: Vec<FilmHeader> = films.iter().map(|film| film.header.clone()).collect();
        FilmHeader::check_merge(&headers, false)?;
        let (first, others) = films.split_first().ok_or(MergeError::Nothing)?;
        let mut sum = first.clone();
        for film in others {
            sum.absorb(film)?;
        }
        Ok(sum)
    }

    /// Adds the samples of other shards of the picture, finished or not.
    ///
    /// # Errors
    ///
    /// If the other film is of another picture, or a shard is in both. The film is unchanged then.
    pub fn absorb(&mut self, other: &Self) -> Result<(), MergeError> {
        if !self.header.same_picture(&other.header) {
            return Err(MergeError::Different { number: 2, usual: 1 });
        }
        if let Some(index) = self.header.shards.first_common(&other.header.shards) {
            let count = self.header.shards.count();
            return Err(MergeError::Twice { index, count, times: 2 });
        }
        self.header.shards = self.header.shards.union(&other.header.shards);
        self.rejected = self.rejected.saturating_add(other.rejected);
        self.fireflies = self.fireflies.saturating_add(other.fireflies);
        self.clamped = self.clamped.saturating_add(other.clamped);
        for (pixel, part) in self.pixels.iter_mut().zip(&other.pixels) {
            pixel.merge(part);
        }
        self.count_samples();
        Ok(())
    }
}
