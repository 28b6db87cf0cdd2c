//! The denoised picture beside a plain one.

use anyhow::{Context, Result};
use rotund_denoise::{Denoiser, Guides};
use rotund_image::Image;
use rotund_trace::Layers;
use std::path::{Path, PathBuf};

/// A denoised picture that is to be written.
#[derive(Debug)]
pub(crate) struct Denoised {
    path: PathBuf,
    denoiser: Denoiser,
}

impl Denoised {
    /// Loads the library, for a picture beside `plain`: `a.denoised.png` beside `a.png`.
    pub(crate) fn beside(plain: &Path) -> Result<Self> {
        let mut extension = std::ffi::OsString::from("denoised.");
        extension.push(plain.extension().unwrap_or_default());
        let denoiser = Denoiser::load().context("--denoise")?;
        Ok(Self { path: plain.with_extension(extension), denoiser })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the picture without its noise. `finish` adds what is no light, such as a background.
    pub(crate) fn write(
        &self,
        noisy: &Image,
        layers: &Layers,
        finish: impl Fn(Image) -> Image,
    ) -> Result<()> {
        let arrays = |vectors: &[glam::Vec3]| vectors.iter().map(glam::Vec3::to_array).collect();
        let guides = Guides { albedo: arrays(&layers.albedo), normal: arrays(&layers.normal) };
        finish(self.denoiser.denoise(noisy, &guides)?).write(&self.path)?;
        Ok(())
    }
}
