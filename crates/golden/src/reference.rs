//! A reference picture as a file: an EXR that any viewer shows.
//!
//! Channels `R`, `G`, `B` hold the mean, and `deviation.R`, `.G`, `.B` the standard deviation of
//! one replica. Digits below the noise are not stored, so that a reference takes a third of the
//! space: the mean is rounded to a quarter of its own standard error or finer, and the deviation up
//! to five bits. Channels `surface.*` hold the surfaces, which have no noise: see
//! [`crate::surface`].

use crate::error::GoldenError;
use crate::moments::Moments;
use crate::surface::{CHANNELS as SURFACE_CHANNELS, Surface};
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Blocks, Compression, Encoding, FlatSamples, Image,
    Layer, LayerAttributes, LineOrder, ReadChannels as _, ReadLayers as _, Text,
    WritableImage as _,
};
use glam::DVec3;
use rotund_image::write_with;
use std::path::Path;

/// A stored picture, and how it was made.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Mean and variance, rounded as in the file.
    pub moments: Moments,
    /// Geometry and surface buffers (AOVs), which need no light transport.
    pub surface: Surface,
    /// Samples per pixel of one replica.
    pub samples: u32,
    /// Largest number of segments of a path.
    pub bounces: u32,
}

const CHANNELS: [&str; 3] = ["R", "G", "B"];
const REPLICAS: &str = "rotundReplicas";
const SAMPLES: &str = "rotundSamplesPerReplica";
const BOUNCES: &str = "rotundBounces";

impl Reference {
    /// Reads a file that [`Self::write`] made.
    ///
    /// # Errors
    ///
    /// If the file cannot be read or is not a reference.
    pub fn read(path: &Path) -> Result<Self, GoldenError> {
        Self::parse(path).map_err(|problem| GoldenError::Reference { path: path.into(), problem })
    }

    fn parse(path: &Path) -> Result<Self, String> {
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_file(path)
            .map_err(|error| error.to_string())?;
        let layer = &image.layer_data;
        let (width, height) = (layer.size.width(), layer.size.height());
        let number = |name: &str| match layer.attributes.other.get(&Text::from(name)) {
            Some(&AttributeValue::I32(number)) if number > 0 => Ok(number as u32),
            _ => Err(format!("it lacks a positive number {name}")),
        };
        let plane = |name: &str| -> Result<Vec<f32>, String> {
            let named = |channel: &&AnyChannel<FlatSamples>| channel.name.eq(name);
            let channel = layer.channel_data.list.iter().find(named);
            let channel = channel.ok_or_else(|| format!("it lacks the channel {name}"))?;
            let values: Vec<f32> = channel.sample_data.values_as_f32().collect();
            if values.len() != width * height {
                return Err(format!("channel {name} has another size"));
            }
            if !values.iter().all(|x| x.is_finite()) {
                return Err(format!("channel {name} is not finite"));
            }
            Ok(values)
        };
        let planes = |prefix: &str| -> Result<Vec<DVec3>, String> {
            let [r, g, b] = CHANNELS.map(|channel| plane(&format!("{prefix}{channel}")));
            let (r, g, b) = (r?, g?, b?);
            let pixel = |i: usize| DVec3::new(r[i].into(), g[i].into(), b[i].into());
            Ok((0..r.len()).map(pixel).collect())
        };
        let (mean, deviation) = (planes("")?, planes("deviation.")?);
        let variance = deviation.into_iter().map(|d| d * d).collect();
        let replicas = number(REPLICAS)?;
        let moments = Moments { width, height, replicas, mean, variance, rejected: 0 };
        let planes: Result<Vec<_>, String> =
            SURFACE_CHANNELS.iter().map(|channel| plane(channel.name)).collect();
        let surface = Surface { width, height, planes: planes? };
        Ok(Self { moments, surface, samples: number(SAMPLES)?, bounces: number(BOUNCES)? })
    }

    /// Writes the file, which appears under its name when it is complete.
    ///
    /// # Errors
    ///
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), GoldenError> {
        let Moments { width, height, replicas, mean, variance, .. } = &self.moments;
        let mut channels = Vec::new();
        for (index, name) in CHANNELS.into_iter().enumerate() {
            let deviation: Vec<f32> =
                variance.iter().map(|v| round_up_to_five_bits(v[index].sqrt())).collect();
            let error = |i: usize| f64::from(deviation[i]) / f64::from(*replicas).sqrt();
            let mean = mean.iter().enumerate().map(|(i, m)| round_to_noise(m[index], error(i)));
            channels.push(AnyChannel::new(name, FlatSamples::F32(mean.collect())));
            let name = format!("deviation.{name}");
            channels.push(AnyChannel::new(name.as_str(), FlatSamples::F32(deviation)));
        }
        for (channel, plane) in SURFACE_CHANNELS.iter().zip(&self.surface.planes) {
            channels.push(AnyChannel::new(channel.name, FlatSamples::F32(plane.clone())));
        }
        let mut attributes = LayerAttributes::default();
        for (name, number) in
            [(REPLICAS, *replicas), (SAMPLES, self.samples), (BOUNCES, self.bounces)]
        {
            let number = AttributeValue::I32(i32::try_from(number).unwrap_or(i32::MAX));
            attributes.other.insert(Text::from(name), number);
        }
        let encoding = Encoding {
            compression: Compression::ZIP16,
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        };
        let channels = AnyChannels::sort(channels.into_iter().collect());
        let layer = Layer::new((*width, *height), attributes, encoding, channels);
        let image = Image::from_layer(layer);
        write_with(path, |file| image.write().to_buffered(file))?;
        Ok(())
    }
}

/// Rounds to a multiple of a power of two that is at most a quarter of `error`, and to 16 bits.
fn round_to_noise(x: f64, error: f64) -> f32 {
    let step = (0.25 * error).max(x.abs() / 65_536.0);
    if step < f64::MIN_POSITIVE {
        return x as f32;
    }
    let step = step.log2().floor().exp2();
    ((x / step).round() * step) as f32
}

/// Rounds a number that is not negative up, so that no picture seems less noisy than it was.
fn round_up_to_five_bits(x: f64) -> f32 {
    if x < 1e-30 {
        return 0.0;
    }
    let step = x.log2().floor().exp2() / 16.0;
    ((x / step).ceil() * step) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::probe::Probe;
    use glam::Vec2;

    #[test]
    fn a_reference_comes_back_as_it_was_but_for_digits_below_its_noise() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let mean: Vec<DVec3> = (0..15).map(|i| DVec3::new(0.1, 1e3, 0.0) * f64::from(i)).collect();
        let variance = vec![DVec3::new(0.01, 30.0, 0.0); 15];
        let moments = Moments { width: 5, height: 3, replicas: 256, mean, variance, rejected: 0 };
        let probe = |uv: Vec2, _| Probe { depth: 9.0 * uv.x, crossings: 3, ..Probe::default() };
        let surface = Surface::measure(5, 3, probe);
        let reference = Reference { moments, surface, samples: 2, bounces: 8 };
        reference.write(&path).unwrap();
        let back = Reference::read(&path).unwrap();
        assert_eq!((back.samples, back.bounces, back.moments.replicas), (2, 8, 256));
        assert_eq!((back.moments.width, back.moments.height), (5, 3));
        assert_eq!(back.surface, reference.surface);
        for i in 0..15 {
            let noise = (reference.moments.variance[i] / 256.0).map(f64::sqrt);
            let off = (back.moments.mean[i] - reference.moments.mean[i]).abs();
            let allowed = 0.125 * noise * 1.07 + reference.moments.mean[i] / 65_536.0;
            assert!(off.cmple(allowed).all(), "{i}: {off} of {allowed}");
            let ratio = back.moments.variance[i].x / 0.01;
            assert!((1.0..1.14).contains(&ratio), "{ratio}");
            assert_eq!(back.moments.variance[i].z, 0.0);
        }
    }

    #[test]
    fn a_file_that_is_not_a_reference_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.exr");
        let image = rotund_image::Image { width: 1, height: 1, pixels: vec![[0.5; 4]] };
        image.write(&path).unwrap();
        let error = Reference::read(&path).unwrap_err().to_string();
        assert!(error.contains("picture.exr is not a reference"), "{error}");
        std::fs::write(&path, b"no picture at all").unwrap();
        assert!(Reference::read(&path).is_err());
    }
}
