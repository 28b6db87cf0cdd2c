//! The page about pictures that failed: expected, actual and difference, in one file.

use crate::surface::Surface;
use crate::verdict::Verdict;
use anyhow::Result;
use rotund_image::{Image, maps};
use rotund_report::embed::exact;
use std::fmt::Write as _;

/// A picture that differs from its reference.
#[derive(Debug)]
pub struct Failure {
    pub name: String,
    pub expected: Image,
    pub actual: Image,
    /// What is seen without light, expected and actual, if that differs.
    pub surfaces: Option<[Surface; 2]>,
    pub verdict: Verdict,
}

const HEAD: &str = r#"<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Golden pictures that differ</title>
<style>
:root { color-scheme: light dark; font: 16px/1.5 system-ui, sans-serif; }
body { margin: 1.5rem auto; max-width: 72rem; padding: 0 1rem; }
section { margin: 2.5rem 0; }
h2 { margin-bottom: .25rem; }
li { overflow-wrap: anywhere; }
.pictures { display: grid; gap: 1rem; grid-template-columns: repeat(auto-fit, minmax(min(24rem, 100%), 1fr)); }
figure { margin: 0; }
img { display: block; width: 100%; height: auto; image-rendering: pixelated; }
figcaption { font-size: .9rem; }
@media print { section { break-inside: avoid; } }
</style>
</head>
<body>
<h1>Golden pictures that differ</h1>
"#;

/// The text of the page.
///
/// # Errors
///
/// Only if an image cannot be encoded.
pub fn page(failures: &[Failure]) -> Result<String> {
    let mut html = HEAD.to_owned();
    html.push_str(
        "<p>If the change is meant, <code>cargo xtask golden --bless</code> accepts it.</p>\n",
    );
    for failure in failures {
        let name = escape(&failure.name);
        writeln!(html, "<section id=\"{name}\">\n<h2>{name}</h2>\n<ul>")?;
        for finding in &failure.verdict.findings {
            let text = escape(&finding.text);
            writeln!(html, "<li><strong>{}</strong>: {text}</li>", finding.check)?;
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
            let caption =
                "Where coverage, crossings, shadow, depth, normal, texcoord or colour differ";
            figures.push((caption.to_owned(), differing(expected, actual)));
        }
        for (caption, image) in figures {
            let (width, height, source) = (image.width, image.height, exact(&image)?);
            writeln!(
                html,
                "<figure><img width=\"{width}\" height=\"{height}\" alt=\"{caption}\" \
                 src=\"{source}\"><figcaption>{caption}</figcaption></figure>"
            )?;
        }
        html.push_str("</div>\n</section>\n");
    }
    html.push_str("</body>\n</html>\n");
    Ok(html)
}

/// Normals as colours: x is red, y green, z blue, and zero a middle grey.
fn normals(surface: &Surface) -> Image {
    Image::from_srgb_fn(surface.width as u32, surface.height as u32, |x, y| {
        let normal = surface.normal(y as usize * surface.width + x as usize);
        (127.5 * (normal + 1.0)).to_array().map(|channel| channel as u8)
    })
}

/// Pixels that differ in white on black.
fn differing(expected: &Surface, actual: &Surface) -> Image {
    Image::from_srgb_fn(actual.width as u32, actual.height as u32, |x, y| {
        let differs = actual.differs_at(expected, y as usize * actual.width + x as usize);
        [if differs { 255 } else { 0 }; 3]
    })
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
