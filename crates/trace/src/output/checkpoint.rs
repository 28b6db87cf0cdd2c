//! Films on disk, to be resumed later or merged with others.
//!
//! All numbers are little-endian: 16 bytes of magic with the version of the format; width, height,
//! shard index and shard count as `u32`; rejected, fireflies, clamped and seed as `u64`; the length
//! of the label as `u32`, and its UTF-8; for each pixel three sums as `u128`, the covered samples
//! and all samples as `u32`; and a hash of all before it, so that a truncated or altered file is
//! refused.

use super::{WriteError, write_with};
use crate::Shard;
use crate::film::{Film, PixelSum};
use std::{
    fs, io,
    io::Write,
    path::{Path, PathBuf},
};

const MAGIC: &[u8; 16] = b"rotund film 003\n";
/// The part of the magic that all versions share.
const MAGIC_START: &[u8] = b"rotund film ";
const PIXEL_BYTES: usize = 3 * 16 + 2 * 4;

/// A reason why a checkpoint is refused.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages describe variants and fields")]
pub enum CheckpointError {
    #[error("cannot read {}", path.display())]
    Read { path: PathBuf, source: io::Error },
    #[error("{} is not a checkpoint", path.display())]
    NotACheckpoint { path: PathBuf },
    #[error("{} is a checkpoint of another version of the format: render it again", path.display())]
    OtherVersion { path: PathBuf },
    #[error("{} is damaged: render it again", path.display())]
    Damaged { path: PathBuf },
}

/// Writes a film to a file, from which [`load_film`] restores it bit for bit. The file is complete
/// or not written at all.
///
/// # Errors
///
/// If the file cannot be written.
pub fn save_film(path: impl AsRef<Path>, film: &Film) -> Result<(), WriteError> {
    let mut bytes = Vec::with_capacity(128 + film.label.len() + film.pixels.len() * PIXEL_BYTES);
    bytes.extend(MAGIC);
    for number in [film.width, film.height, film.shard.index, film.shard.count] {
        bytes.extend(number.to_le_bytes());
    }
    for number in [film.rejected, film.fireflies, film.clamped, film.seed] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend((film.label.len() as u32).to_le_bytes());
    bytes.extend(film.label.as_bytes());
    for pixel in &film.pixels {
        for sum in pixel.radiance {
            bytes.extend(sum.to_le_bytes());
        }
        bytes.extend(pixel.covered.to_le_bytes());
        bytes.extend(pixel.samples.to_le_bytes());
    }
    let hash = hash(&bytes);
    bytes.extend(hash.to_le_bytes());
    write_with(path, |file| file.write_all(&bytes))
}

/// Reads a film that [`save_film`] wrote.
///
/// # Errors
///
/// If the file cannot be read, is not a checkpoint or one of another version, or is damaged.
pub fn load_film(path: impl AsRef<Path>) -> Result<Film, CheckpointError> {
    let path = path.as_ref();
    let bytes =
        fs::read(path).map_err(|source| CheckpointError::Read { path: path.into(), source })?;
    if bytes.starts_with(MAGIC_START) && !bytes.starts_with(MAGIC) {
        return Err(CheckpointError::OtherVersion { path: path.into() });
    }
    if !bytes.starts_with(MAGIC) {
        return Err(CheckpointError::NotACheckpoint { path: path.into() });
    }
    parse(&bytes).ok_or_else(|| CheckpointError::Damaged { path: path.into() })
}

/// Returns the film of a file, or `None` if the bytes are not as they were written.
fn parse(bytes: &[u8]) -> Option<Film> {
    let (content, expected) = bytes.split_last_chunk::<8>()?;
    if hash(content) != u64::from_le_bytes(*expected) {
        return None;
    }
    let mut rest = content.get(MAGIC.len()..)?;
    let mut take = |count: usize| {
        let (taken, left) = rest.split_at_checked(count)?;
        rest = left;
        Some(taken)
    };
    let mut small = || Some(u32::from_le_bytes(take(4)?.try_into().ok()?));
    let [width, height, index, count] = [small()?, small()?, small()?, small()?];
    let mut large = || Some(u64::from_le_bytes(take(8)?.try_into().ok()?));
    let [rejected, fireflies, clamped, seed] = [large()?, large()?, large()?, large()?];
    let length = u32::from_le_bytes(take(4)?.try_into().ok()?);
    let label = String::from_utf8(take(length as usize)?.to_vec()).ok()?;
    let pixels: Vec<PixelSum> = rest.chunks_exact(PIXEL_BYTES).map(pixel).collect::<Option<_>>()?;
    let whole = pixels.len() == width as usize * height as usize
        && !pixels.is_empty()
        && rest.len() == pixels.len() * PIXEL_BYTES
        && index < count;
    let shard = Shard { index, count };
    let mut film = whole.then(|| Film::from_pixels(width, height, pixels))?;
    (film.rejected, film.fireflies, film.clamped) = (rejected, fireflies, clamped);
    (film.seed, film.shard, film.label) = (seed, shard, label);
    Some(film)
}

fn pixel(bytes: &[u8]) -> Option<PixelSum> {
    let (sums, counts) = bytes.split_at_checked(48)?;
    let mut radiance = [0; 3];
    for (sum, bytes) in radiance.iter_mut().zip(sums.chunks_exact(16)) {
        *sum = u128::from_le_bytes(bytes.try_into().ok()?);
    }
    let (covered, samples) = counts.split_first_chunk::<4>()?;
    Some(PixelSum {
        radiance,
        covered: u32::from_le_bytes(*covered),
        samples: u32::from_le_bytes(samples.try_into().ok()?),
    })
}

/// Returns the FNV-1a hash over words of eight bytes. It detects accidents, not malice.
fn hash(bytes: &[u8]) -> u64 {
    bytes.chunks(8).fold(0xcbf2_9ce4_8422_2325, |hash, chunk| {
        let mut word = [0; 8];
        word[..chunk.len()].copy_from_slice(chunk);
        (hash ^ u64::from_le_bytes(word)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}
