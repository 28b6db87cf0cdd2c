//! The result of a render: exact sums of the samples of each pixel.

mod accumulate;
mod header;
mod merge;
mod pixel;
mod schedule;

#[cfg(test)]
pub(crate) use accumulate::one_by_one;
pub use accumulate::{FilmSample, Progress};
pub(crate) use accumulate::{GROUP, Limits, Place, Splat, Splats};
pub use header::{FilmHeader, Origin};
pub use merge::MergeError;
pub(crate) use pixel::{PixelSum, Sum};

use crate::{FilmError, Options, RenderError, Shard};
use glam::Vec3;
use rayon::prelude::*;
use rotund_image::Image;

/// The sums of the samples of each pixel, and statistics of the samples.
///
/// Sums are exact: radiance is counted in whole steps of 2⁻⁵⁶, so addition is associative. The same
/// samples make the same bits in any order, on any number of threads, in one run or several, on one
/// machine or several. Each pixel knows its number of samples, so [`Self::image`] is right at any
/// moment, also in the middle of a pass over the pixels. Only light that a sample found for another
/// pixel ([`crate::World::render`] traces paths from the lights) is up to one pass ahead there.
///
/// A custom renderer fills a film with [`Self::accumulate`], or sample by sample with
/// [`Self::add`].
///
/// ```
/// use rotund_trace::{Film, FilmSample};
///
/// // A horizontal ramp, sampled by an "integrator" that needs no scene.
/// let mut film = Film::new(64, 4)?;
/// film.accumulate(16, |x, _y, _sample| FilmSample::from(glam::Vec3::splat(x as f32 / 64.0)));
/// assert_eq!(film.samples(), 16);
/// assert_eq!(film.image().pixels[32], [0.5, 0.5, 0.5, 1.0]);
/// # Ok::<(), rotund_trace::FilmError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Film {
    pub(crate) header: FilmHeader,
    pub(crate) rejected: u64,
    pub(crate) fireflies: u64,
    pub(crate) clamped: u64,
    /// Row by row from the top.
    pub(crate) pixels: Vec<PixelSum>,
    /// Number of pixels with exactly `header.samples` samples. When it reaches 0, the minimum has
    /// risen and is computed anew, so reading it costs nothing however large the film is.
    behind: usize,
}

impl Film {
    /// Makes a film without samples, of seed 0, undivided and of no origin.
    ///
    /// # Errors
    ///
    /// If a side is zero, or the pixels do not fit into memory.
    pub fn new(width: u32, height: u32) -> Result<Self, FilmError> {
        Self::empty(FilmHeader {
            width,
            height,
            seed: 0,
            origin: Origin::default(),
            wanted: 0,
            shards: Shard::default().into(),
            samples: 0,
        })
    }

    /// Makes a film without samples, of the size, seed, shard and number of samples of `options`,
    /// for [`crate::World::resume`].
    ///
    /// # Errors
    ///
    /// If [`Options::validate`] refuses the options, or the pixels do not fit into memory.
    pub fn for_options(options: &Options) -> Result<Self, RenderError> {
        options.validate()?;
        Ok(Self::empty(FilmHeader::for_options(options))?)
    }

    /// Makes a film as [`Self::for_options`] does, in the memory of this one where that is enough.
    ///
    /// A program that starts one picture after another asks for no memory then: allocators keep
    /// some of what is given back to them, in other places each time.
    ///
    /// # Errors
    ///
    /// As [`Self::for_options`].
    pub fn restart(self, options: &Options) -> Result<Self, RenderError> {
        options.validate()?;
        Ok(Self::empty_in(self.pixels, FilmHeader::for_options(options))?)
    }

    fn empty(header: FilmHeader) -> Result<Self, FilmError> {
        Self::empty_in(Vec::new(), header)
    }

    fn empty_in(memory: Vec<PixelSum>, header: FilmHeader) -> Result<Self, FilmError> {
        let FilmHeader { width, height, .. } = header;
        let mut pixels = room_in(memory, width, height)?;
        pixels.resize(width as usize * height as usize, PixelSum::default());
        Ok(Self::from_pixels(header, pixels))
    }

    /// Makes a film of `width * height` sums.
    pub(crate) fn from_pixels(header: FilmHeader, pixels: Vec<PixelSum>) -> Self {
        let mut film = Self { header, rejected: 0, fireflies: 0, clamped: 0, pixels, behind: 0 };
        film.count_samples();
        film
    }

    /// Returns size, origin and samples of the film.
    #[must_use]
    pub fn header(&self) -> &FilmHeader {
        &self.header
    }

    /// Returns the number of pixels in a row.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.header.width
    }

    /// Returns the number of rows.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.header.height
    }

    /// Returns the number of samples that every pixel has: the minimum over all pixels.
    #[must_use]
    pub fn samples(&self) -> u32 {
        self.header.samples
    }

    /// Returns the largest number of samples of a pixel, which after an interruption may be more
    /// than [`Self::samples`].
    #[must_use]
    pub fn most_samples(&self) -> u32 {
        self.pixels.iter().map(|pixel| pixel.samples).max().unwrap_or(0)
    }

    /// Returns the number of samples of one pixel, or `None` outside of the film.
    #[must_use]
    pub fn samples_at(&self, x: u32, y: u32) -> Option<u32> {
        self.index(x, y).ok().map(|index| self.pixels[index].samples)
    }

    /// Returns how many samples were rejected, and counted as black, because their radiance was
    /// NaN, negative, or 2³⁹ or more. What a path from a light adds to a pixel counts as a sample
    /// here, and in [`Self::fireflies`] and [`Self::clamped`]. There is one such path for eight
    /// samples, so its radiance is that of eight samples, and it counts as one of them.
    #[must_use]
    pub fn rejected(&self) -> u64 {
        self.rejected
    }

    /// Returns how many samples were brighter than every light source of the scene, as no pixel can
    /// be. They are noise of paths with too low a sampling density; they count in full.
    #[must_use]
    pub fn fireflies(&self) -> u64 {
        self.fireflies
    }

    /// Returns how many samples [`Options::clamp`] scaled down.
    #[must_use]
    pub fn clamped(&self) -> u64 {
        self.clamped
    }

    /// Returns the seed of the samples, which an integrator passes to [`crate::Sampler::new`].
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.header.seed
    }

    /// Returns the same film with another seed.
    #[must_use]
    pub fn with_seed(self, seed: u64) -> Self {
        Self { header: FilmHeader { seed, ..self.header }, ..self }
    }

    /// Returns the same film with the source of its samples; films of different origins do not
    /// merge.
    #[must_use]
    pub fn with_origin(self, origin: Origin) -> Self {
        Self { header: FilmHeader { origin, ..self.header }, ..self }
    }

    /// Adds one sample to a pixel. An invalid radiance counts as black and in [`Self::rejected`].
    ///
    /// # Errors
    ///
    /// If the pixel is outside of the film, or the film is a merge of some of the shards of a
    /// picture, whose next sample is undefined.
    pub fn add(&mut self, x: u32, y: u32, radiance: Vec3, covered: bool) -> Result<(), FilmError> {
        let index = self.index(x, y)?;
        let shard = self.header.shards.only().ok_or(FilmError::Merged)?;
        let pixel = &mut self.pixels[index];
        let was_behind = pixel.samples == self.header.samples;
        let wanted = shard.sample_index(pixel.samples).saturating_add(1);
        self.header.wanted = self.header.wanted.max(wanted);
        let valid = pixel.add(radiance.to_array(), covered);
        self.rejected += u64::from(!valid);
        self.advance(usize::from(was_behind));
        Ok(())
    }

    /// Returns the mean of the samples of each pixel, rounded once; black and transparent where
    /// there are none.
    #[must_use]
    pub fn image(&self) -> Image {
        let mut image = Image { width: 0, height: 0, pixels: Vec::new() };
        self.develop(&mut image);
        image
    }

    /// Makes `image` equal to [`Self::image`] in the memory that it has, if that is enough.
    pub fn develop(&self, image: &mut Image) {
        image.width = self.header.width;
        image.height = self.header.height;
        self.pixels.par_iter().map(PixelSum::mean).collect_into_vec(&mut image.pixels);
    }

    fn index(&self, x: u32, y: u32) -> Result<usize, FilmError> {
        let FilmHeader { width, height, .. } = self.header;
        if x < width && y < height {
            Ok(y as usize * width as usize + x as usize)
        } else {
            Err(FilmError::OutOfRange { x, y, width, height })
        }
    }

    /// Takes note that `count` pixels now have more samples than the minimum.
    fn advance(&mut self, count: usize) {
        self.behind -= count;
        if self.behind == 0 {
            self.count_samples();
        }
    }

    /// Computes the minimum number of samples, and how many pixels have it.
    fn count_samples(&mut self) {
        let least = |a: (u32, usize), b: (u32, usize)| match a.0.cmp(&b.0) {
            std::cmp::Ordering::Less => a,
            std::cmp::Ordering::Equal => (a.0, a.1 + b.1),
            std::cmp::Ordering::Greater => b,
        };
        let pixels = self.pixels.par_iter().with_min_len(1 << 14);
        let (samples, behind) =
            pixels.map(|pixel| (pixel.samples, 1)).reduce(|| (u32::MAX, 0), least);
        (self.header.samples, self.behind) = (samples, behind);
    }
}

/// Largest number of pixels of a film: 1 TiB of sums.
const MOST_PIXELS: usize = 1 << 34;

/// Returns an empty vector with room for something of each pixel, or an error if a side is zero or
/// there is not enough memory.
pub(crate) fn room<T>(width: u32, height: u32) -> Result<Vec<T>, FilmError> {
    room_in(Vec::new(), width, height)
}

/// Does the same in the memory of another vector, which is freed first if it is too small.
fn room_in<T>(mut memory: Vec<T>, width: u32, height: u32) -> Result<Vec<T>, FilmError> {
    if width == 0 || height == 0 {
        return Err(FilmError::Empty { width, height });
    }
    memory.clear();
    let count = (width as usize).checked_mul(height as usize);
    match count.filter(|&count| count <= MOST_PIXELS) {
        Some(count) if count <= memory.capacity() => Ok(memory),
        Some(count) => {
            drop(memory);
            let mut room = Vec::new();
            let reserved = room.try_reserve_exact(count);
            reserved.map(|()| room).map_err(|_| FilmError::TooLarge { width, height })
        }
        None => Err(FilmError::TooLarge { width, height }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, vec2};
    use std::ops::ControlFlow;

    #[test]
    fn samples_are_those_that_every_pixel_has() {
        let mut film = Film::new(2, 1).expect("a film");
        let add = |film: &mut Film, x| film.add(x, 0, Vec3::ONE, true).expect("a pixel");
        add(&mut film, 0);
        add(&mut film, 0);
        assert_eq!((film.samples(), film.header().wanted), (0, 2));
        add(&mut film, 1);
        assert_eq!((film.samples(), film.header().is_finished()), (1, false));
        add(&mut film, 1);
        assert_eq!((film.samples(), film.header().is_finished()), (2, true));
        assert_eq!([0, 1, 2].map(|x| film.samples_at(x, 0)), [Some(2), Some(2), None]);
    }

    #[test]
    fn a_film_that_starts_again_is_a_new_one_in_the_same_memory() {
        let options = |width, height, seed| Options { width, height, seed, ..Options::default() };
        let mut film = Film::for_options(&options(30, 20, 1)).expect("a film");
        let memory = film.pixels.as_ptr();
        for next in [options(30, 20, 2), options(7, 5, 3), options(20, 30, 4)] {
            film.accumulate(2, |x, _, _| Vec3::splat(1e20 * x as f32).into());
            assert!(film.rejected() > 0);
            film = film.restart(&next).expect("a film");
            assert_eq!(film, Film::for_options(&next).expect("a film"));
            assert_eq!(film.pixels.as_ptr(), memory);
        }
        let larger = options(31, 20, 1);
        let film = film.restart(&larger).expect("a film");
        assert_eq!(film, Film::for_options(&larger).expect("a film"));
    }

    #[test]
    fn light_for_other_pixels_is_added_limited_and_counted() {
        let mut film = Film::new(4, 2).expect("a film");
        let limits = Limits { clamp: 4.0, brightest: 2.0 };
        let sample = one_by_one(|[x, y, _], splats| {
            // From each pixel to the next one, from the last of a row to the first.
            let image_uv = Vec2::new(((x + 1) % 4) as f32 + 0.5, y as f32 + 0.5) / vec2(4.0, 2.0);
            let radiance = Vec3::splat([1.0, 3.0, 8.0, f32::NAN][x as usize]);
            splats.push(Splat { image_uv, radiance, samples: 2.0 });
            FilmSample::from(Vec3::ONE)
        });
        film.take_samples(2, limits, &sample, &mut |_| ControlFlow::Continue(()));
        let row: Vec<f32> = film.image().pixels[4..].iter().map(|pixel| pixel[0]).collect();
        assert_eq!(row, [1.0, 3.0, 7.0, 9.0]);
        assert_eq!((film.rejected(), film.fireflies(), film.clamped()), (4, 8, 4));
        assert_eq!(film.samples(), 2);
    }

    #[test]
    fn a_film_that_cannot_be_is_refused() {
        for (width, height, message) in [
            (0, 5, "a film of 0 x 5 has no pixels"),
            (5, 0, "a film of 5 x 0 has no pixels"),
            (u32::MAX, u32::MAX, "a film of 4294967295 x 4294967295 does not fit into memory"),
        ] {
            let error = Film::new(width, height).expect_err("no film").to_string();
            assert!(error.starts_with(message), "{error}");
        }
        let mut film = Film::new(3, 2).expect("a film");
        let error = film.add(1, 2, Vec3::ONE, true).expect_err("no such pixel").to_string();
        assert_eq!(error, "pixel (1, 2) is outside of a film of 3 x 2");
    }
}
