//! What removes noise in the viewer: Open Image Denoise, if it is there.

use crate::denoised::denoise;
use rotund_denoise::Denoiser;
use rotund_image::Image;
use rotund_viewer::{Denoise, Guides};
use std::sync::Arc;

/// The loaded library.
#[derive(Debug)]
struct Remover(Denoiser);

impl Denoise for Remover {
    fn denoise(&self, noisy: &Image, guides: &Guides) -> Result<Image, String> {
        let denoised = denoise(&self.0, noisy, &guides.albedo, &guides.normal);
        denoised.map_err(|error| error.to_string())
    }
}

/// Loads the library; the error says why it cannot be used.
pub(super) fn load() -> Result<Arc<dyn Denoise>, String> {
    match Denoiser::load() {
        Ok(denoiser) => Ok(Arc::new(Remover(denoiser))),
        Err(error) => Err(error.to_string()),
    }
}
