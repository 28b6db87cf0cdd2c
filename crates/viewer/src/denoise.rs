//! The removal of noise from pictures at rest, which a viewer does not know by itself.

use glam::Vec3;
use rotund_image::Image;
use std::fmt::Debug;
use std::sync::Arc;
use std::time::Duration;

/// Something that removes the noise of pictures.
pub trait Denoise: Debug + Send + Sync {
    /// Returns the picture without its noise; the error is one sentence for people. Pictures of
    /// the same surfaces come with the same allocation of guides.
    ///
    /// # Errors
    ///
    /// If it fails, for instance for lack of memory.
    fn denoise(&self, noisy: &Image, guides: &Arc<Guides>) -> Result<Image, String>;
}

/// What is known of each pixel without noise, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Guides {
    /// Colour of the first surface.
    pub albedo: Vec<Vec3>,
    /// Shading normal of the first surface.
    pub normal: Vec<Vec3>,
}

/// A picture without its noise.
#[derive(Clone, Debug)]
pub(crate) struct Denoised {
    pub(crate) image: Arc<Image>,
    /// Number of the change of which the picture is.
    pub(crate) version: u64,
    pub(crate) samples: u32,
    /// How long it took.
    pub(crate) time: Duration,
}
