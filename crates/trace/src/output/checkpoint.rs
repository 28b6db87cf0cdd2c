//! Films on disk, to be resumed later or merged with others.
//!
//! All numbers are little-endian:
//!
//! | bytes | content |
//! | --- | --- |
//! | 16 | magic with the version of the format |
//! | 4 | length of the header as `u32`, such that the header ends at a multiple of eight bytes |
//! | | the header |
//! | 8 | hash of all before it |
//! | 56 for each pixel | three sums as `u128`, light paths included; the covered samples and all samples as `u32` |
//! | 8 | hash of all before it, so that a truncated or altered file is refused |
//!
//! The header is width, height, shard count, number of shards held, and the index of each as `u32`;
//! samples wanted, and samples that every pixel has, as `u32`; rejected, fireflies, clamped, seed
//! and hash of the origin as `u64`; program and label, each as its length as `u32` and its UTF-8;
//! and zeros up to its length.
//!
//! Films are written and read through a small buffer, so that a checkpoint takes no memory beside
//! that of the film.

use super::{WriteError, write_with};
use crate::film::{Film, FilmHeader, Origin, PixelSum, Sum, room};
use crate::{FilmError, ShardSet};
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

const MAGIC: &[u8; 16] = b"rotund film 005\n";
/// The part of the magic that all versions share.
const MAGIC_START: &[u8] = b"rotund film ";
/// Bytes before the header.
const START: usize = MAGIC.len() + 4;
const PIXEL_BYTES: usize = 3 * 16 + 2 * 4;
/// Pixels that pass through the buffer at once.
const BUFFERED: usize = 1 << 12;
/// Parts of so many pixels that go to the disk together, 28 MiB.
const SYNCED: usize = 1 << 7;

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
    #[error("cannot read {}", path.display())]
    Memory { path: PathBuf, source: FilmError },
}

/// Writes a film to a file, from which [`load_film`] restores it bit for bit. The file is complete
/// or not written at all.
///
/// # Errors
///
/// If the file cannot be written.
pub fn save_film(path: impl AsRef<Path>, film: &Film) -> Result<(), WriteError> {
    write_with(path, |file| write(file, film, &mut |_| Ok(())))
}

/// Writes a film as [`save_film`] does, unless `stop` returns true before it is written; returns
/// whether the file was written. `stop` is called several times a second, unless the disk is slow.
///
/// # Errors
///
/// If the file cannot be written.
pub fn save_film_unless(
    path: impl AsRef<Path>,
    film: &Film,
    mut stop: impl FnMut() -> bool,
) -> Result<bool, WriteError> {
    let (mut stopped, mut parts) = (false, 0);
    let saved = write_with(path, |file| {
        write(file, film, &mut |file| {
            stopped = stop();
            if stopped {
                return Err(io::Error::from(io::ErrorKind::Interrupted));
            }
            parts += 1;
            if parts % SYNCED == 0 {
                // Otherwise all parts would go to the disk at the end, when none can be stopped.
                file.flush()?;
                file.get_ref().sync_data()?;
            }
            Ok(())
        })
    });
    if stopped { Ok(false) } else { saved.map(|()| true) }
}

/// Reads a film that [`save_film`] wrote.
///
/// # Errors
///
/// If the file cannot be read, is not a checkpoint or one of another version, is damaged, or does
/// not fit into memory.
pub fn load_film(path: impl AsRef<Path>) -> Result<Film, CheckpointError> {
    open(path.as_ref(), |reader| reader.film())
}

/// Reads the header of a film that [`save_film`] wrote. The pixels are not checked.
///
/// # Errors
///
/// As [`load_film`].
pub fn load_film_header(path: impl AsRef<Path>) -> Result<FilmHeader, CheckpointError> {
    open(path.as_ref(), |reader| Ok(reader.header()?.header))
}

/// Why a file is no film.
enum Problem {
    Io(io::Error),
    NotACheckpoint,
    OtherVersion,
    Damaged,
    Memory(FilmError),
}

impl From<io::Error> for Problem {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::UnexpectedEof => Self::Damaged,
            _ => Self::Io(error),
        }
    }
}

fn open<T>(
    path: &Path,
    read: impl FnOnce(&mut Reader) -> Result<T, Problem>,
) -> Result<T, CheckpointError> {
    let result = Reader::open(path).and_then(|mut reader| read(&mut reader));
    let path = path.to_path_buf();
    result.map_err(|problem| match problem {
        Problem::Io(source) => CheckpointError::Read { path, source },
        Problem::NotACheckpoint => CheckpointError::NotACheckpoint { path },
        Problem::OtherVersion => CheckpointError::OtherVersion { path },
        Problem::Damaged => CheckpointError::Damaged { path },
        Problem::Memory(source) => CheckpointError::Memory { path, source },
    })
}

/// Writes a film; `each` is called after each part of it.
fn write<W: Write>(
    file: &mut W,
    film: &Film,
    each: &mut dyn FnMut(&mut W) -> io::Result<()>,
) -> io::Result<()> {
    let mut hash = Hash::default();
    let start = start(film);
    hash.add(&start);
    file.write_all(&start)?;
    let mut buffer = hash.0.to_le_bytes().to_vec();
    for pixels in film.pixels.chunks(BUFFERED) {
        for PixelSum { radiance, covered, samples } in pixels {
            radiance
                .iter()
                .flat_map(|sum| sum.0)
                .for_each(|half| buffer.extend(half.to_le_bytes()));
            buffer.extend(covered.to_le_bytes());
            buffer.extend(samples.to_le_bytes());
        }
        hash.add(&buffer);
        file.write_all(&buffer)?;
        buffer.clear();
        each(file)?;
    }
    file.write_all(&hash.0.to_le_bytes())
}

/// Returns the bytes up to the end of the header.
fn start(film: &Film) -> Vec<u8> {
    let FilmHeader { width, height, seed, origin, wanted, shards, samples } = &film.header;
    let Origin { program, hash, label } = origin;
    let mut bytes = [&MAGIC[..], &[0; 4]].concat();
    let mut small = vec![*width, *height, shards.count(), shards.indices().len() as u32];
    small.extend(shards.indices());
    small.extend([*wanted, *samples]);
    small.into_iter().for_each(|number| bytes.extend(number.to_le_bytes()));
    for number in [film.rejected, film.fireflies, film.clamped, *seed, *hash] {
        bytes.extend(number.to_le_bytes());
    }
    for text in [program, label] {
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(text.as_bytes());
    }
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    let length = (bytes.len() - START) as u32;
    bytes[MAGIC.len()..START].copy_from_slice(&length.to_le_bytes());
    bytes
}

/// A header with the statistics that are stored in it.
struct Head {
    header: FilmHeader,
    rejected: u64,
    fireflies: u64,
    clamped: u64,
}

/// Reads a file whose bytes need not be trusted: nothing is allocated that is larger than the file.
struct Reader {
    file: File,
    /// Length of the file.
    length: u64,
    /// Hash of the bytes so far.
    hash: Hash,
}

impl Reader {
    fn open(path: &Path) -> Result<Self, Problem> {
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        Ok(Self { file, length, hash: Hash::default() })
    }

    /// Reads and hashes bytes, whose number must be a multiple of eight.
    fn read(&mut self, bytes: &mut [u8]) -> Result<(), Problem> {
        self.file.read_exact(bytes)?;
        self.hash.add(bytes);
        Ok(())
    }

    /// Reads a hash, which must be that of the bytes before it.
    fn check_hash(&mut self) -> Result<(), Problem> {
        let expected = self.hash.0.to_le_bytes();
        let mut hash = [0; 8];
        self.read(&mut hash)?;
        if hash == expected { Ok(()) } else { Err(Problem::Damaged) }
    }

    fn header(&mut self) -> Result<Head, Problem> {
        let mut start = Vec::new();
        let mut first = Read::by_ref(&mut self.file).take(START as u64);
        first.read_to_end(&mut start)?;
        let length = match start.strip_prefix(MAGIC) {
            Some(length) => u32::from_le_bytes(length.try_into().map_err(|_| Problem::Damaged)?),
            None if start.starts_with(MAGIC_START) => return Err(Problem::OtherVersion),
            None => return Err(Problem::NotACheckpoint),
        };
        let end = START as u64 + u64::from(length);
        if end > self.length || !end.is_multiple_of(8) {
            return Err(Problem::Damaged);
        }
        start.resize(end as usize, 0);
        self.file.read_exact(&mut start[START..])?;
        self.hash.add(&start);
        self.check_hash()?;
        let head = parse(&start[START..]).ok_or(Problem::Damaged)?;
        let pixels = u64::from(head.header.width) * u64::from(head.header.height);
        let expected = u128::from(pixels) * PIXEL_BYTES as u128 + u128::from(end) + 16;
        if u128::from(self.length) == expected { Ok(head) } else { Err(Problem::Damaged) }
    }

    fn film(&mut self) -> Result<Film, Problem> {
        let Head { header, rejected, fireflies, clamped } = self.header()?;
        let (count, most) = (header.width as usize * header.height as usize, header.share());
        let mut pixels: Vec<PixelSum> =
            room(header.width, header.height).map_err(Problem::Memory)?;
        let mut buffer = vec![0; BUFFERED * PIXEL_BYTES];
        while pixels.len() < count {
            let bytes = &mut buffer[..BUFFERED.min(count - pixels.len()) * PIXEL_BYTES];
            self.read(bytes)?;
            for bytes in bytes.chunks_exact(PIXEL_BYTES) {
                let sum = pixel(bytes).filter(|sum| sum.is_possible(most));
                pixels.push(sum.ok_or(Problem::Damaged)?);
            }
        }
        self.check_hash()?;
        let samples = header.samples;
        let mut film = Film::from_pixels(header, pixels);
        (film.rejected, film.fireflies, film.clamped) = (rejected, fireflies, clamped);
        if film.header.samples == samples { Ok(film) } else { Err(Problem::Damaged) }
    }
}

/// Returns the content of a header, or `None` if it is none that [`start`] writes.
fn parse(mut rest: &[u8]) -> Option<Head> {
    let mut take = |count: usize| {
        let (taken, left) = rest.split_at_checked(count)?;
        rest = left;
        Some(taken)
    };
    let mut small = || Some(u32::from_le_bytes(take(4)?.try_into().ok()?));
    let [width, height, count, held] = [small()?, small()?, small()?, small()?];
    // The iterator ends where the header does, whatever number of shards it claims.
    let indices: Vec<u32> = (0..held).map(|_| small()).collect::<Option<_>>()?;
    let shards = ShardSet::new(count, indices)?;
    let [wanted, samples] = [small()?, small()?];
    let mut large = || Some(u64::from_le_bytes(take(8)?.try_into().ok()?));
    let [rejected, fireflies, clamped, seed, hash] =
        [large()?, large()?, large()?, large()?, large()?];
    let mut text = || {
        let length = u32::from_le_bytes(take(4)?.try_into().ok()?);
        String::from_utf8(take(length as usize)?.to_vec()).ok()
    };
    let origin = Origin { program: text()?, hash, label: text()? };
    let header = FilmHeader { width, height, seed, origin, wanted, shards, samples };
    let has_pixels = width > 0 && height > 0;
    let is_padded = rest.len() < 8 && rest.iter().all(|&byte| byte == 0);
    (has_pixels && is_padded).then_some(Head { header, rejected, fireflies, clamped })
}

fn pixel(bytes: &[u8]) -> Option<PixelSum> {
    let (words, _) = bytes.as_chunks::<8>();
    let [r0, r1, g0, g1, b0, b1, counts] = <[_; 7]>::try_from(words).ok()?.map(u64::from_le_bytes);
    Some(PixelSum {
        radiance: [Sum([r0, r1]), Sum([g0, g1]), Sum([b0, b1])],
        covered: counts as u32,
        samples: (counts >> 32) as u32,
    })
}

/// FNV-1a over words of eight bytes. It detects accidents, not malice.
struct Hash(u64);

impl Default for Hash {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Hash {
    /// Adds bytes, whose number must be a multiple of eight.
    fn add(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks::<8>();
        debug_assert!(rest.is_empty(), "whole words");
        for &word in words {
            self.0 = (self.0 ^ u64::from_le_bytes(word)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FilmSample, Options, Shard};

    /// A film of four pixels, and its bytes.
    fn film() -> (Film, Vec<u8>) {
        let shard = Shard { index: 1, count: 3 };
        let options = Options { width: 2, height: 2, samples: 9, shard, ..Options::default() };
        let origin = Origin { program: "rotund 0".into(), hash: 7, label: "a picture".into() };
        let mut film = Film::for_options(&options).expect("a film").with_origin(origin);
        film.accumulate(9, |x, y, _| FilmSample::from(glam::Vec3::splat((x + y) as f32)));
        let mut bytes = Vec::new();
        write(&mut bytes, &film, &mut |_| Ok(())).expect("memory takes all");
        (film, bytes)
    }

    /// Loads bytes from a file; returns the error in words.
    fn load(bytes: &[u8]) -> Result<Film, String> {
        let file = tempfile::NamedTempFile::new().expect("a file");
        std::fs::write(file.path(), bytes).expect("it is written");
        load_film(file.path()).map_err(|error| error.to_string())
    }

    /// Makes both hashes right again, as a forger would.
    fn forged(mut bytes: Vec<u8>) -> Vec<u8> {
        let header = u32::from_le_bytes(bytes[16..20].try_into().expect("four bytes")) as usize;
        for end in [START + header, bytes.len() - 8] {
            if end + 8 <= bytes.len() && end.is_multiple_of(8) {
                let mut hash = Hash::default();
                hash.add(&bytes[..end]);
                bytes[end..end + 8].copy_from_slice(&hash.0.to_le_bytes());
            }
        }
        bytes
    }

    #[test]
    fn a_film_comes_back_and_so_does_its_header_alone() {
        let (film, bytes) = film();
        assert_eq!(load(&bytes), Ok(film.clone()));
        let file = tempfile::NamedTempFile::new().expect("a file");
        save_film(file.path(), &film).expect("it is saved");
        assert_eq!(load_film_header(file.path()).expect("a header"), film.header);
    }

    #[test]
    fn a_film_that_is_stopped_leaves_the_file_as_it_was() {
        let (film, _) = film();
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.film");
        std::fs::write(&path, "old").expect("a file");
        assert!(!save_film_unless(&path, &film, || true).expect("no failure"));
        assert_eq!(std::fs::read(&path).expect("a file"), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1);
        assert!(save_film_unless(&path, &film, || false).expect("it is saved"));
        assert_eq!(load_film(&path).expect("a film"), film);
    }

    #[test]
    fn every_cut_and_every_changed_byte_is_found() {
        let (_, bytes) = film();
        for length in 0..bytes.len() {
            assert!(load(&bytes[..length]).is_err(), "the first {length} bytes");
        }
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 0x10;
            assert!(load(&changed).is_err(), "byte {at}");
        }
        assert!(load(&[&bytes[..], &[0; 8]].concat()).is_err(), "longer");
    }

    #[test]
    fn a_forged_film_is_refused_or_can_be_used() {
        let (good, bytes) = film();
        let mut loaded = 0;
        for at in MAGIC.len()..bytes.len() - 8 {
            for byte in [0, 1, 0x7f, 0xff] {
                let mut changed = bytes.clone();
                changed[at] = byte;
                let Ok(mut film) = load(&forged(changed)) else { continue };
                loaded += 1;
                let mut sum = good.clone();
                let _ = sum.absorb(&film);
                let _ = film.absorb(&good);
                let _ = film.image();
                if film.header.shards.only().is_some() && film.header.wanted < 100 {
                    film.accumulate(film.header.wanted, |_, _, _| glam::Vec3::ONE.into());
                    assert!(film.header.is_finished(), "byte {at} is {byte}");
                }
            }
        }
        assert!(loaded > 100, "the hashes are right in {loaded} films");
    }
}
