//! Pictures with their auxiliary layers in one EXR.

use super::{WriteError, write_with};
use crate::Layers;
use exr::prelude::{
    AnyChannel, AnyChannels, FlatSamples, Image as ExrImage, Layer, LayerAttributes, WritableImage,
};
use glam::Vec3;
use rotund_image::{EXR_ENCODING, Image};
use std::io::Cursor;
use std::path::Path;

/// A reason why layers cannot be encoded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{problem}")]
#[non_exhaustive]
pub struct LayersError {
    /// One sentence.
    pub problem: String,
}

/// Writes a picture and its layers into one EXR; see [`encode_layers`].
///
/// # Errors
///
/// If the layers are not of the size of the picture, picture or layers do not hold `width * height`
/// pixels, or the file cannot be written.
pub fn write_layers(
    path: impl AsRef<Path>,
    image: &Image,
    layers: &Layers,
) -> Result<(), WriteError> {
    let path = path.as_ref();
    if let Some(problem) = misfit(image, layers) {
        return Err(WriteError::Encode { path: path.into(), source: problem.into() });
    }
    write_with(path, |file| exr_image(image, layers).write().to_buffered(file))
}

/// Encodes a picture and its layers as one EXR: `R G B A` are the picture, `albedo.R` to
/// `position.Z` the layers, by the naming that compositors group channels by; `instance.id`,
/// `element.id` and `material.id` are unsigned integers.
///
/// # Errors
///
/// If the layers are not of the size of the picture, or picture or layers do not hold
/// `width * height` pixels.
pub fn encode_layers(image: &Image, layers: &Layers) -> Result<Vec<u8>, LayersError> {
    if let Some(problem) = misfit(image, layers) {
        return Err(LayersError { problem });
    }
    let mut bytes = Cursor::new(Vec::new());
    let written = exr_image(image, layers).write().to_buffered(&mut bytes);
    written.map_err(|error| LayersError { problem: error.to_string() })?;
    Ok(bytes.into_inner())
}

fn exr_image(image: &Image, layers: &Layers) -> ExrImage<Layer<AnyChannels<FlatSamples>>> {
    let size = (image.width as usize, image.height as usize);
    let mut channels = Vec::new();
    let mut add = |name: &str, samples| channels.push(AnyChannel::new(name, samples));
    for (index, name) in ["R", "G", "B", "A"].into_iter().enumerate() {
        add(name, FlatSamples::F32(image.pixels.iter().map(|pixel| pixel[index]).collect()));
    }
    let mut add_vectors = |names: [&str; 3], vectors: &[Vec3]| {
        for (index, name) in names.into_iter().enumerate() {
            add(name, FlatSamples::F32(vectors.iter().map(|vector| vector[index]).collect()));
        }
    };
    add_vectors(["albedo.R", "albedo.G", "albedo.B"], &layers.albedo);
    add_vectors(["normal.X", "normal.Y", "normal.Z"], &layers.normal);
    add_vectors(["position.X", "position.Y", "position.Z"], &layers.position);
    add("depth.Z", FlatSamples::F32(layers.depth.clone()));
    for (name, ids) in ["instance.id", "element.id", "material.id"].into_iter().zip(&layers.ids) {
        add(name, FlatSamples::U32(ids.clone()));
    }
    let channels = AnyChannels::sort(channels.into_iter().collect());
    let layer = Layer::new(size, LayerAttributes::default(), EXR_ENCODING, channels);
    ExrImage::from_layer(layer)
}

/// Returns why picture and layers do not make one file, if so.
fn misfit(image: &Image, layers: &Layers) -> Option<String> {
    let &Layers { width, height, ref albedo, ref normal, ref depth, ref position, ref ids } =
        layers;
    if (width, height) != (image.width, image.height) {
        let (columns, rows) = (image.width, image.height);
        return Some(format!(
            "layers of {width} x {height} do not fit a picture of {columns} x {rows}"
        ));
    }
    let [instances, elements, materials] = ids;
    let counts = [
        ("picture", image.pixels.len()),
        ("layer `albedo`", albedo.len()),
        ("layer `normal`", normal.len()),
        ("layer `depth`", depth.len()),
        ("layer `position`", position.len()),
        ("layer `instance.id`", instances.len()),
        ("layer `element.id`", elements.len()),
        ("layer `material.id`", materials.len()),
    ];
    let area = u64::from(width) * u64::from(height);
    let wrong = counts.into_iter().find(|&(_, count)| count as u64 != area || count == 0);
    wrong.map(|(what, count)| format!("a {what} of {width} x {height} holds {count} pixels"))
}
