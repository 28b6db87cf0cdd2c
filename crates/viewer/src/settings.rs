//! What a client sets: methods, the quantity that is shown, samples, and how light becomes colours.

use crate::side::Side;
use rotund_scene::{ElementKind, Method};
use rotund_trace::{Options, RenderError, Sequence, UnknownView, View};
use serde::{Deserialize, Serialize};

/// Longest side of a picture in pixels; larger ones are reduced to it.
pub const LONGEST_SIDE: u32 = 3840;

/// Whether overlapping points and lines are one body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OverlapChoice {
    /// As the scene says.
    #[default]
    Scene,
    /// One body.
    Union,
    /// Every element has its own whole surface.
    Separate,
}

/// Everything that a client sets beside the camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Trace points exactly, as spheres.
    pub points: bool,
    /// Trace lines exactly, as rounded cones.
    pub lines: bool,
    /// Trace quads exactly, as bilinear patches.
    pub quads: bool,
    /// What overlapping points and lines are.
    pub overlap: OverlapChoice,
    /// Render a second picture with all kinds vanilla, [`crate::Side::Vanilla`].
    pub wipe: bool,
    /// Name of a [`View`].
    pub view: String,
    /// Samples of each pixel.
    pub samples: u32,
    /// Segments of the longest path.
    pub bounces: u32,
    /// Radiance to which brighter samples are scaled down.
    pub clamp: Option<f32>,
    /// Independent random numbers instead of Sobol points.
    pub independent: bool,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Show the environment to the camera; otherwise the background is transparent.
    pub background: bool,
    /// Exposure in stops: a step of 1 doubles the brightness.
    pub exposure: f32,
    /// Compress highlights by a curve like that of film.
    pub filmic: bool,
    /// Show pictures at rest without their noise, if the viewer has a [`crate::Denoise`].
    pub denoise: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            points: true,
            lines: true,
            quads: true,
            overlap: OverlapChoice::Scene,
            wipe: false,
            view: View::default().name().to_owned(),
            samples: 256,
            bounces: 8,
            clamp: None,
            independent: false,
            seed: 0,
            background: true,
            exposure: 0.0,
            filmic: false,
            denoise: false,
        }
    }
}

/// A reason why settings or a camera are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages describe variants and fields")]
#[non_exhaustive]
pub enum SettingsError {
    #[error(transparent)]
    View(#[from] UnknownView),
    #[error(transparent)]
    Options(#[from] RenderError),
    #[error("the exposure is {exposure} stops; it must be from -32 to 32")]
    Exposure { exposure: f32 },
    #[error("samples are {samples}; at most 2^24 are taken")]
    Samples { samples: u32 },
}

impl Settings {
    /// Checks that all settings have a meaning.
    ///
    /// # Errors
    ///
    /// If there is no such view, samples or bounces are zero, clamp is not positive, or exposure is
    /// beyond 32 stops.
    pub fn validate(&self) -> Result<(), SettingsError> {
        self.options(1, 1)?.validate()?;
        if self.samples > 1 << 24 {
            return Err(SettingsError::Samples { samples: self.samples });
        }
        if !(-32.0..=32.0).contains(&self.exposure) {
            return Err(SettingsError::Exposure { exposure: self.exposure });
        }
        Ok(())
    }

    /// Returns the options of a render of this size.
    pub(crate) fn options(&self, width: u32, height: u32) -> Result<Options, UnknownView> {
        Ok(Options {
            width,
            height,
            samples: self.samples,
            bounces: self.bounces,
            seed: self.seed,
            sequence: if self.independent { Sequence::Independent } else { Sequence::Sobol },
            view: self.view.parse::<View>()?,
            clamp: self.clamp,
            transparent: !self.background,
            ..Options::default()
        })
    }

    /// Returns the method of each kind of element for one side of the comparison.
    pub(crate) fn methods(&self, side: Side) -> [(ElementKind, Method); 4] {
        let method = |exact| match side {
            Side::Chosen if exact => Method::Enhanced,
            _ => Method::Vanilla,
        };
        // Triangles look the same by both, as in films of `rotund render`.
        [
            (ElementKind::Points, method(self.points)),
            (ElementKind::Lines, method(self.lines)),
            (ElementKind::Quads, method(self.quads)),
            (ElementKind::Triangles, Method::Vanilla),
        ]
    }

    /// Returns true if other settings have the same films, so that only what is made of them
    /// changes.
    pub(crate) fn same_light(&self, other: &Self) -> bool {
        let light = |it: &Self| Self { exposure: 0.0, filmic: false, denoise: false, ..it.clone() };
        light(self) == light(other)
    }
}
