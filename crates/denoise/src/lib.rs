//! Denoising of pictures by Intel Open Image Denoise, a library that is loaded at run time.
//!
//! [`Denoiser::load`] finds the library, and [`Denoiser::denoise`] removes the noise of a picture,
//! guided by the colours and normals of its surfaces. The library runs on the processor, so the
//! result does not depend on graphics cards.
//!
//! A denoised picture is a guess of a neural network: it is free of noise, but biased. Errors that
//! were noise become wrong shades and lost detail, which more samples do not average away. Keep the
//! plain picture beside it.

mod library;

use library::Library;
use rotund_image::Image;
use std::ffi::{OsStr, OsString};

/// The variable that names the library.
pub const VARIABLE: &str = "ROTUND_OIDN";

/// The names of the library on this system, the most exact one first.
const NAMES: &[&str] = if cfg!(windows) {
    &["OpenImageDenoise.dll"]
} else if cfg!(target_os = "macos") {
    &["libOpenImageDenoise.2.dylib", "libOpenImageDenoise.dylib"]
} else {
    &["libOpenImageDenoise.so.2", "libOpenImageDenoise.so"]
};

/// A reason why a picture cannot be denoised.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages describe variants and fields")]
#[non_exhaustive]
pub enum DenoiseError {
    #[error(
        "cannot load Open Image Denoise: {problem}; install version 2 of it, or name its library \
         by the variable {VARIABLE}"
    )]
    Missing { problem: String },
    #[error("{name} is not Open Image Denoise 2: {problem}")]
    Unsuitable { name: String, problem: String },
    #[error("Open Image Denoise fails: {problem}")]
    Failed { problem: String },
    #[error("{what} has {count} pixels, the picture {width} x {height}")]
    Size { what: &'static str, count: usize, width: u32, height: u32 },
}

/// Colours and normals of the surfaces that a picture shows, row by row from the top: where they
/// have an edge, the denoised picture keeps one. Both are empty by default, which means unknown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Guides {
    /// Colour of the first surface, averaged over the pixel; black without one.
    pub albedo: Vec<[f32; 3]>,
    /// Shading normal of the first surface, averaged over the pixel; zero without one. Without
    /// [`Self::albedo`] it is not used.
    pub normal: Vec<[f32; 3]>,
}

/// Guides whose noise has been removed.
#[derive(Clone, Debug, PartialEq)]
pub struct CleanGuides(Guides);

/// The loaded library.
#[derive(Debug)]
pub struct Denoiser {
    oidn: Library,
}

impl Denoiser {
    /// Loads the library that the variable `ROTUND_OIDN` names, or else the one of the system.
    ///
    /// # Errors
    ///
    /// If there is none, or it is not Open Image Denoise 2.
    pub fn load() -> Result<Self, DenoiseError> {
        match std::env::var_os(VARIABLE).filter(|name| !name.is_empty()) {
            Some(name) => Self::open(&name),
            None => {
                let mut tries = NAMES.iter().map(|name| Self::open(OsStr::new(name)));
                let first = tries.next().unwrap_or_else(|| Self::open(&OsString::new()));
                first.or_else(|error| tries.find(Result::is_ok).unwrap_or(Err(error)))
            }
        }
    }

    /// Loads a library by its path, or by a name that the system looks for.
    ///
    /// # Errors
    ///
    /// If there is none, or it is not Open Image Denoise 2.
    pub fn open(name: &OsStr) -> Result<Self, DenoiseError> {
        Ok(Self { oidn: Library::open(name)? })
    }

    /// Returns the version of the library, such as `2.5.1`.
    #[must_use]
    pub fn version(&self) -> String {
        let version = self.oidn.version();
        format!("{}.{}.{}", version / 10_000, version / 100 % 100, version % 100)
    }

    /// Returns a picture without its noise. Alpha stays as it is.
    ///
    /// Guides are denoised first, by the same library, since depth of field and motion make them
    /// noisy too.
    ///
    /// # Errors
    ///
    /// If picture or guides do not hold `width * height` pixels, or the library fails, for instance
    /// for lack of memory.
    pub fn denoise(&self, image: &Image, guides: &Guides) -> Result<Image, DenoiseError> {
        self.denoise_by(image, &self.clean(image.width, image.height, guides)?)
    }

    /// Returns guides without their noise, for several pictures of the same surfaces.
    ///
    /// # Errors
    ///
    /// As [`Self::denoise`].
    pub fn clean(
        &self,
        width: u32,
        height: u32,
        guides: &Guides,
    ) -> Result<CleanGuides, DenoiseError> {
        let size = [width as usize, height as usize];
        let clean = |what, name, guide: &[[f32; 3]]| {
            check_size(what, guide.len(), width, height, true)?;
            if guide.is_empty() {
                return Ok(Vec::new());
            }
            self.oidn.run(size, &[(name, guide)], &[])
        };
        let albedo = clean("the albedo", c"albedo", &guides.albedo)?;
        let normal = clean("the normal", c"normal", &guides.normal)?;
        Ok(CleanGuides(Guides { albedo, normal }))
    }

    /// Does what [`Self::denoise`] does, by guides that are free of noise.
    ///
    /// # Errors
    ///
    /// As [`Self::denoise`].
    pub fn denoise_by(&self, image: &Image, guides: &CleanGuides) -> Result<Image, DenoiseError> {
        let &Image { width, height, ref pixels } = image;
        let CleanGuides(Guides { albedo, normal }) = guides;
        check_size("the array", pixels.len(), width, height, false)?;
        check_size("the albedo", albedo.len(), width, height, true)?;
        check_size("the normal", normal.len(), width, height, true)?;
        if pixels.is_empty() {
            return Ok(image.clone());
        }
        let size = [width as usize, height as usize];
        let color: Vec<[f32; 3]> = pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        let mut inputs = vec![(c"color", &color[..])];
        if !albedo.is_empty() {
            inputs.push((c"albedo", albedo));
            if !normal.is_empty() {
                inputs.push((c"normal", normal));
            }
        }
        let has_guides = inputs.len() > 1;
        let flags = [(c"hdr", true), (c"cleanAux", has_guides)];
        let clean = self.oidn.run(size, &inputs, &flags)?;
        let joined = clean.iter().zip(pixels).map(|(&[r, g, b], &[_, _, _, a])| [r, g, b, a]);
        Ok(Image { width, height, pixels: joined.collect() })
    }
}

/// Makes sure that there is one value for each pixel, or none if that `may_be_empty`.
fn check_size(
    what: &'static str,
    count: usize,
    width: u32,
    height: u32,
    may_be_empty: bool,
) -> Result<(), DenoiseError> {
    let fits = count == width as usize * height as usize || (may_be_empty && count == 0);
    if fits { Ok(()) } else { Err(DenoiseError::Size { what, count, width, height }) }
}
