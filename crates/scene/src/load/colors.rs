//! Colours in floating point, which some programs write from 0 to 255, and greys.

use glam::{Vec3, Vec4};
use rayon::prelude::*;
use rotund_image::linear_from_srgb;

/// What the colours of a file tell about their scale.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    brightest: f32,
    /// The number of colours, and of those with a channel beyond 1.
    count: usize,
    bright_count: usize,
    has_fractions: bool,
}

impl Scale {
    /// The scale of no colours.
    pub(super) const NOTHING: Self =
        Self { brightest: 0.0, count: 0, bright_count: 0, has_fractions: false };

    /// Returns the scale of colours by their channels.
    pub(super) fn of_channels(red: &[f32], green: &[f32], blue: &[f32]) -> Self {
        let channels = red.iter().zip(green).zip(blue);
        Self::of(channels.map(|((&red, &green), &blue)| [red, green, blue]))
    }

    pub(super) fn of(colors: impl Iterator<Item = [f32; 3]>) -> Self {
        let mut scale = Self::NOTHING;
        for [red, green, blue] in colors {
            let brightest = red.max(green).max(blue);
            scale.count += 1;
            scale.brightest = scale.brightest.max(brightest);
            scale.bright_count += usize::from(brightest > 1.0);
            scale.has_fractions |= [red, green, blue].map(f32::fract) != [0.0; 3];
        }
        scale
    }

    /// Returns the scale of two sets of colours together.
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            brightest: self.brightest.max(other.brightest),
            count: self.count + other.count,
            bright_count: self.bright_count + other.bright_count,
            has_fractions: self.has_fractions || other.has_fractions,
        }
    }

    /// Returns true if 255 is white: nothing is beyond, and either all numbers are integers or most
    /// colours are beyond 1.
    pub(super) fn is_of_bytes(self) -> bool {
        // Few lights are this bright, and few images of bytes this dark.
        const BRIGHT: f32 = 16.0;
        let most = 2 * self.bright_count > self.count && self.brightest > BRIGHT;
        self.brightest > 1.0 && self.brightest <= 255.5 && (!self.has_fractions || most)
    }

    /// Converts colours from 0 to 255 to linear ones; returns a warning about colours beyond 1.
    pub(super) fn settle(self, colors: &mut [Vec4]) -> Option<String> {
        let brightest = self.brightest;
        if self.is_of_bytes() {
            let opaque = colors.par_iter().map(|color| color.w).reduce(|| 0.0, f32::max);
            let one = if opaque > 1.0 { 255.0 } else { 1.0 };
            colors.par_iter_mut().for_each(|color| {
                let [r, g, b] = [color.x, color.y, color.z].map(|c| linear_from_srgb(c / 255.0));
                *color = Vec4::new(r, g, b, color.w / one);
            });
            return Some(format!(
                "colours are floating-point numbers up to {brightest}; taken as 0 to 255"
            ));
        }
        (brightest > 1.0).then(|| {
            format!(
                "colours are floating-point numbers up to {brightest}; taken as light beyond white"
            )
        })
    }
}

/// Returns greys from black at the 1st to white at the 99th percentile of the intensities, none if
/// these are equal.
pub(super) fn greys(intensities: &[f32]) -> Vec<Vec4> {
    const SAMPLE: usize = 1 << 16;
    let step = (intensities.len() / SAMPLE).max(1);
    let mut sample: Vec<f32> =
        intensities.iter().step_by(step).copied().filter(|x| x.is_finite()).collect();
    sample.sort_unstable_by(f32::total_cmp);
    let last = sample.len().saturating_sub(1);
    let ends = (sample.get(last / 100), sample.get((99 * last).div_ceil(100)));
    let (Some(&low), Some(&high)) = ends else { return Vec::new() };
    if low >= high {
        return Vec::new();
    }
    let grey = |x: &f32| {
        let share = (x - low) / (high - low);
        let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
        Vec3::splat(linear_from_srgb(share)).extend(1.0)
    };
    intensities.iter().map(grey).collect()
}
