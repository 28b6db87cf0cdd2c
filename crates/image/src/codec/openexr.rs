//! OpenEXR files: which channels are the colour, and where the image lies in its display window.

use super::decoded::{Decoded, Samples};
use super::size::check_size;
use exr::prelude::{
    MetaData, ReadChannels as _, ReadLayers as _, ReadSpecificChannel as _, read as read_exr,
};
use std::io::Cursor;

pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, String> {
    // The dimensions first, because the library allocates what a header claims.
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false)
        .map_err(|error| error.to_string())?;
    for header in &meta.headers {
        let bits = 8 * header.channels.bytes_per_pixel as u64;
        check_size(header.layer_size.0 as u64, header.layer_size.1 as u64, bits, bytes)?;
    }
    let names: Vec<Vec<String>> = meta
        .headers
        .iter()
        .map(|header| header.channels.list.iter().map(|c| c.name.to_string()).collect())
        .collect();
    let (part, chosen) = choose(&names)?;
    let header = &meta.headers[part];
    let display = header.shared_attributes.display_window;
    let bits = 8 * header.channels.bytes_per_pixel as u64;
    let [width, height] = [display.size.0, display.size.1];
    check_size(width as u64, height as u64, bits, bytes)
        .map_err(|problem| format!("the display window: {problem}"))?;
    let data = header.own_attributes.layer_position;
    let start = [0, 1].map(|i| {
        let [data, display] = [[data.0, data.1], [display.position.0, display.position.1]];
        i64::from(data[i]) - i64::from(display[i])
    });
    // Outside of its data window, an image is black, and transparent if it has an alpha.
    let has_alpha = names[part].contains(&chosen.alpha);
    let outside = [0.0, 0.0, 0.0, if has_alpha { 0.0 } else { 1.0 }];
    let canvas = || Canvas { size: [width, height], start, pixels: vec![outside; width * height] };

    let levels = read_exr().no_deep_data().largest_resolution_level();
    let pixels = match chosen.colors {
        Colors::Grey(name) => levels
            .specific_channels()
            .required(name.as_str())
            .optional(chosen.alpha.as_str(), 1.0)
            .collect_pixels(
                |_, _| canvas(),
                |canvas: &mut Canvas, at, (y, a): (f32, f32)| canvas.set(at.0, at.1, [y, y, y, a]),
            )
            .first_valid_layer()
            .all_attributes()
            .non_parallel()
            .from_buffered(Cursor::new(bytes))
            .map(|image| image.layer_data.channel_data.pixels),
        Colors::Rgb([r, g, b]) => levels
            .specific_channels()
            .required(r.as_str())
            .required(g.as_str())
            .required(b.as_str())
            .optional(chosen.alpha.as_str(), 1.0)
            .collect_pixels(
                |_, _| canvas(),
                |canvas: &mut Canvas, at, (r, g, b, a): (f32, f32, f32, f32)| {
                    canvas.set(at.0, at.1, [r, g, b, a]);
                },
            )
            .first_valid_layer()
            .all_attributes()
            .non_parallel()
            .from_buffered(Cursor::new(bytes))
            .map(|image| image.layer_data.channel_data.pixels),
    };
    let pixels = pixels.map_err(|error| error.to_string())?.pixels;
    Ok(Decoded {
        width: u32::try_from(width).map_err(|error| error.to_string())?,
        height: u32::try_from(height).map_err(|error| error.to_string())?,
        samples: Samples::Linear(pixels),
    })
}

/// The channels that become the image.
struct Chosen {
    colors: Colors,
    /// The name of the alpha channel, which the file may not have.
    alpha: String,
}

enum Colors {
    Grey(String),
    Rgb([String; 3]),
}

/// Returns the index of a part of the file and the channels in it: R, G and B without a layer, then
/// Y or a lone channel, then a layer that is the final image by its name, then the only layer with
/// colours.
fn choose(parts: &[Vec<String>]) -> Result<(usize, Chosen), String> {
    let colors = |names: &[String], layer: &str| {
        let find = |letter: &str| {
            let wanted = format!("{layer}{letter}");
            let same = |name: &&String| {
                let (head, tail) = name.split_at_checked(layer.len()).unwrap_or_default();
                head == layer && tail.eq_ignore_ascii_case(letter)
            };
            // Of two spellings, the usual one.
            names.iter().find(|name| **name == wanted).or_else(|| names.iter().find(same)).cloned()
        };
        let alpha = find("A").unwrap_or_else(|| format!("{layer}A"));
        Some(Chosen { colors: Colors::Rgb([find("R")?, find("G")?, find("B")?]), alpha })
    };
    let grey = |names: &[String]| {
        let has = |wanted: &str| names.iter().any(|name| name == wanted);
        let name = match names {
            [name] if name != "A" => name,
            // With R it is incomplete, and with X and Z it is no luminance.
            _ if has("Y") && !has("R") && !(has("X") && has("Z")) => "Y",
            _ => return None,
        };
        Some(Chosen { colors: Colors::Grey(name.to_owned()), alpha: "A".to_owned() })
    };
    let numbered = || parts.iter().enumerate();
    if let Some(found) = numbered().find_map(|(i, names)| Some((i, colors(names, "")?))) {
        return Ok(found);
    }
    if let [names] = parts
        && let Some(chosen) = grey(names)
    {
        return Ok((0, chosen));
    }
    let mut layers: Vec<(usize, &str)> = Vec::new();
    for (part, names) in numbered() {
        for name in names {
            let layer = &name[..name.rfind('.').map_or(0, |dot| dot + 1)];
            if !layer.is_empty() && !layers.contains(&(part, layer)) {
                layers.push((part, layer));
            }
        }
    }
    layers.retain(|(part, layer)| colors(&parts[*part], layer).is_some());
    let last_word = |layer: &str| {
        let path = layer.trim_end_matches('.');
        path[path.rfind('.').map_or(0, |dot| dot + 1)..].to_ascii_lowercase()
    };
    // Blender, then Arnold and others.
    let final_names = ["combined", "beauty", "rgba", "rgb", "image", "color"];
    let by_name =
        || final_names.iter().find_map(|name| layers.iter().find(|(_, l)| last_word(l) == *name));
    let only = if let [only] = &layers[..] { Some(only) } else { by_name() };
    if let Some((part, layer)) = only
        && let Some(chosen) = colors(&parts[*part], layer)
    {
        return Ok((*part, chosen));
    }
    if let Some(found) = numbered().find_map(|(i, names)| Some((i, grey(names)?))) {
        return Ok(found);
    }
    Err(refusal(parts, &layers))
}

/// Returns the message for a file whose colours are not known.
fn refusal(parts: &[Vec<String>], layers: &[(usize, &str)]) -> String {
    const MOST: usize = 12;
    let listed = |names: Vec<&str>| {
        let more = names.len().saturating_sub(MOST);
        let text = names[..names.len() - more].join(", ");
        if more > 0 { format!("{text} and {more} more") } else { text }
    };
    if layers.is_empty() {
        let names = parts.iter().flatten().map(String::as_str).collect();
        return format!(
            "has the channels {}, expected R, G and B, or Y, or a single one",
            listed(names)
        );
    }
    let names = layers.iter().map(|(_, layer)| layer.trim_end_matches('.')).collect();
    format!(
        "has colours in the layers {}, and which is the image is not known: expected one of them, \
         or one named Combined, beauty, rgba, image or color",
        listed(names)
    )
}

/// The pixels of the display window while the library delivers those of the data window.
struct Canvas {
    size: [usize; 2],
    /// Where the data window starts.
    start: [i64; 2],
    pixels: Vec<[f32; 4]>,
}

impl Canvas {
    fn set(&mut self, x: usize, y: usize, pixel: [f32; 4]) {
        let [x, y] = [self.start[0] + x as i64, self.start[1] + y as i64];
        if let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y))
            && x < self.size[0]
            && y < self.size[1]
        {
            self.pixels[y * self.size[0] + x] = pixel;
        }
    }
}
