//! Denoised pictures: beside a plain one, and in the viewer.

use anyhow::{Context, Result};
use glam::Vec3;
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
        let denoised = self.denoiser.denoise(noisy, &guides(&layers.albedo, &layers.normal))?;
        finish(denoised).write(&self.path)?;
        Ok(())
    }
}

/// Returns the guides that these colours and normals are.
pub(crate) fn guides(albedo: &[Vec3], normal: &[Vec3]) -> Guides {
    let arrays = |vectors: &[Vec3]| vectors.iter().map(Vec3::to_array).collect();
    Guides { albedo: arrays(albedo), normal: arrays(normal) }
}
