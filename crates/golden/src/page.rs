//! The page about pictures that differ: expected, actual and difference, in one file.

use crate::surface::Surface;
use crate::verdict::Verdict;
use rotund_image::{EncodeError, Image, maps};
use rotund_report::embed::exact;
use rotund_report::html::{escape, page};

/// A picture that differs from its reference.
#[derive(Debug)]
pub struct Failure {
    /// Name of the picture.
    pub name: String,
    /// Mean picture of the reference.
    pub expected: Image,
    /// Mean picture of the check.
    pub actual: Image,
    /// Surfaces of the reference and of the check, if they differ.
    pub surfaces: Option<[Surface; 2]>,
    /// The checks that failed.
    pub verdict: Verdict,
}

const TITLE: &str = "Golden pictures that differ";

const STYLE: &str = "\
section { margin: 2.5rem 0; }
li { overflow-wrap: anywhere; }
.pictures { display: grid; gap: 1rem;
  grid-template-columns: repeat(auto-fit, minmax(min(24rem, 100%), 1fr)); }
.pictures img { display: block; width: 100%; height: auto; image-rendering: pixelated; }
@media print { section { break-inside: avoid; } }
";

/// Returns a page about pictures that differ. `accept` is the command that accepts the change.
///
/// # Errors
///
/// If a picture has no pixels.
pub fn failure_page(failures: &[Failure], accept: &str) -> Result<String, EncodeError> {
    let mut html = format!(
        "<h1>{TITLE}</h1>\n<p>If the change is intended, <code>{}</code> accepts it.</p>\n",
        escape(accept)
    );
    for failure in failures {
        let name = escape(&failure.name);
        html += &format!("<section id=\"{name}\">\n<h2>{name}</h2>\n<ul>\n");
        for finding in &failure.verdict.findings {
            let text = escape(&finding.text);
            html += &format!("<li><strong>{}</strong>: {text}</li>\n", finding.check);
        }
        html.push_str("</ul>\n<div class=\"pictures\">\n");
        let difference = &failure.verdict.difference;
        let range = maps::signed_range(&difference.signed);
        let mut figures = vec![
            ("Expected".to_owned(), failure.expected.clone()),
            ("Actual".to_owned(), failure.actual.clone()),
            (
                format!("Lighter (red) and darker (blue) than expected, up to {range}"),
                maps::signed(&difference.signed, range),
            ),
            (
                format!(
                    "FLIP error from black, 0, to pale yellow, 1; {:.4} in the mean",
                    difference.metrics.flip_mean
                ),
                maps::flip(&difference.flip),
            ),
        ];
        if let Some([expected, actual]) = &failure.surfaces {
            figures.push(("Expected normals".to_owned(), normals(expected)));
            figures.push(("Actual normals".to_owned(), normals(actual)));
            let caption = "Pixels in which a check of the surface fails";
            figures.push((caption.to_owned(), differing(expected, actual)));
        }
        for (caption, image) in figures {
            let (width, height, source) = (image.width, image.height, exact(&image)?);
            html += &format!(
                "<figure><img width=\"{width}\" height=\"{height}\" alt=\"{caption}\" \
                 src=\"{source}\"><figcaption>{caption}</figcaption></figure>\n"
            );
        }
        html.push_str("</div>\n</section>\n");
    }
    Ok(page(TITLE, STYLE, &html))
}

/// Draws normals: x is red, y green, z blue, and zero a middle grey.
fn normals(surface: &Surface) -> Image {
    Image::from_srgb_fn(surface.width as u32, surface.height as u32, |x, y| {
        let normal = surface.normal(y as usize * surface.width + x as usize);
        (127.5 * (normal + 1.0)).to_array().map(|channel| channel as u8)
    })
}

/// Draws pixels that differ in white on black.
fn differing(expected: &Surface, actual: &Surface) -> Image {
    Image::from_srgb_fn(actual.width as u32, actual.height as u32, |x, y| {
        let differs = actual.differs_at(expected, y as usize * actual.width + x as usize);
        [if differs { 255 } else { 0 }; 3]
    })
}
