//! What removes noise in the viewer: Open Image Denoise, if it is there.

use crate::denoised::guides;
use rotund_denoise::{CleanGuides, DenoiseError, Denoiser};
use rotund_image::Image;
use rotund_viewer::{Denoise, Guides};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// Guides that are kept: of both sides of two clients.
const MOST_GUIDES: usize = 4;

/// The loaded library, with the last guides, which cost as much as a picture each.
#[derive(Debug)]
struct Remover {
    denoiser: Denoiser,
    clean: Mutex<VecDeque<(Weak<Guides>, Arc<CleanGuides>)>>,
}

impl Remover {
    fn clean(&self, image: &Image, of: &Arc<Guides>) -> Result<Arc<CleanGuides>, DenoiseError> {
        let mut kept = self.clean.lock().unwrap_or_else(PoisonError::into_inner);
        kept.retain(|(guides, _)| guides.strong_count() > 0);
        if let Some((_, clean)) = kept.iter().find(|(own, _)| own.as_ptr() == Arc::as_ptr(of)) {
            return Ok(Arc::clone(clean));
        }
        let noisy = guides(&of.albedo, &of.normal);
        let clean = Arc::new(self.denoiser.clean(image.width, image.height, &noisy)?);
        kept.truncate(MOST_GUIDES - 1);
        kept.push_front((Arc::downgrade(of), Arc::clone(&clean)));
        Ok(clean)
    }
}

impl Denoise for Remover {
    fn denoise(&self, noisy: &Image, guides: &Arc<Guides>) -> Result<Image, String> {
        let clean = self.clean(noisy, guides);
        let denoised = clean.and_then(|clean| self.denoiser.denoise_by(noisy, &clean));
        denoised.map_err(|error| error.to_string())
    }
}

/// Loads the library; the error says why it cannot be used.
pub(super) fn load() -> Result<Arc<dyn Denoise>, String> {
    match Denoiser::load() {
        Ok(denoiser) => Ok(Arc::new(Remover { denoiser, clean: Mutex::default() })),
        Err(error) => Err(error.to_string()),
    }
}
