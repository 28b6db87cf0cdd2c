//! The checks by name, and what a failed one reports.

use std::fmt;

/// A check of a picture. [`Self::name`] is what reports call it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Check {
    /// No sample of the picture is negative, infinite or NaN.
    Rejected,
    /// Student's t for each pixel and channel.
    Pixel,
    /// Student's t for the mean of each block of 8 x 8 pixels.
    Block,
    /// Student's t for the mean of the picture.
    Energy,
    /// The mean FLIP error is within that of the noise.
    Flip,
    /// Share of the rays of each pixel that meet a surface.
    Coverage,
    /// Number of surfaces along the rays of each pixel.
    Crossings,
    /// Share of the rays from the surface, in fixed directions, that meet nothing.
    Shadow,
    /// Distance of the first surface.
    Depth,
    /// Shading normal of the first surface.
    Normal,
    /// Texture coordinates of the first surface.
    Texcoord,
    /// Material colour of the first surface.
    Color,
}

impl Check {
    /// Returns the name of the check in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Rejected => "rejected",
            Self::Pixel => "pixel",
            Self::Block => "block",
            Self::Energy => "energy",
            Self::Flip => "flip",
            Self::Coverage => "coverage",
            Self::Crossings => "crossings",
            Self::Shadow => "shadow",
            Self::Depth => "depth",
            Self::Normal => "normal",
            Self::Texcoord => "texcoord",
            Self::Color => "colour",
        }
    }
}

impl fmt::Display for Check {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A check that failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// The check.
    pub check: Check,
    /// The place and the values, in words.
    pub text: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.check, self.text)
    }
}
