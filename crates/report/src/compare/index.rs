//! The page about several comparisons, with a link to the page of each.

use super::{Pair, STYLE, Timing, fill};
use crate::embed;
use crate::html::escape;
use rotund_image::{Difference, EncodeError, Image};

const PAGE: &str = include_str!("index.html");

/// The part of the page about one scene. The page of its comparison is `SCENE/report.html` beside
/// it.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Name of the scene, and of the folder of its comparison.
    pub scene: String,
    card: String,
    row: String,
}

impl Entry {
    /// Describes the comparison of two pictures, of which `settings` names camera, size and so on.
    ///
    /// # Errors
    ///
    /// If a picture has no pixels.
    pub fn new(
        scene: &str,
        settings: &str,
        pair: &Pair,
        pictures: &[Image; 2],
        difference: &Difference,
        timings: &[Timing],
    ) -> Result<Self, EncodeError> {
        let name = escape(scene);
        let [first, second] = pair.names;
        let link = format!("{}/report.html", percent_encoded(scene));
        let m = &difference.metrics;
        let card = format!(
            "<article><a href=\"{link}\"><div class=\"pair\">\
             <img src=\"{}\" alt=\"{name}, {first}\"><img src=\"{}\" alt=\"{name}, {second}\">\
             </div>\
             <h2>{name}</h2></a>\n<p class=\"settings\">{}</p>\n\
             <p>FLIP {:.4}, {:.1} % of the pixels changed, {:+.2} % light</p></article>\n",
            embed::thumbnail(&pictures[0])?,
            embed::thumbnail(&pictures[1])?,
            escape(settings),
            m.flip_mean,
            100.0 * m.changed_fraction,
            100.0 * (m.luminance_ratio - 1.0)
        );
        let mut row = format!("<tr><th scope=\"row\"><a href=\"{link}\">{name}</a></th>");
        for value in [m.flip_mean, m.mean_abs, m.rel_mse, m.changed_fraction, m.luminance_ratio] {
            row += &format!("<td>{value:.4}</td>");
        }
        for &Timing { values: [first, second], digits, .. } in timings.iter().take(4) {
            row += &format!("<td>{first:.digits$}</td><td>{second:.digits$}</td>");
        }
        Ok(Self { scene: scene.to_owned(), card, row: row + "</tr>\n" })
    }
}

/// Returns the page.
#[must_use]
pub fn page(pair: &Pair, entries: &[Entry]) -> String {
    let join = |part: fn(&Entry) -> &str| entries.iter().map(part).collect::<String>();
    let count = entries.len().to_string();
    fill(
        PAGE,
        &[
            ("style", STYLE.trim_end()),
            ("first", pair.names[0]),
            ("second", pair.names[1]),
            ("count", &count),
            ("cards", &join(|entry| &entry.card)),
            ("rows", &join(|entry| &entry.row)),
        ],
    )
}

/// Returns a name as a part of a URL.
fn percent_encoded(name: &str) -> String {
    let encode = |byte: u8| {
        if byte.is_ascii_alphanumeric() || b"-_.~".contains(&byte) {
            char::from(byte).to_string()
        } else {
            format!("%{byte:02X}")
        }
    };
    name.bytes().map(encode).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_links_to_each_report_and_loads_nothing() {
        let picture = |value: f32| Image::from_fn(8, 4, |_, _| [value; 4]);
        let pictures = [picture(0.2), picture(0.4)];
        let difference = Difference::between(&pictures[1], &pictures[0]).unwrap();
        let timing = Timing { label: "render, s", values: [1.0, 2.0], digits: 2 };
        let entry = |scene: &str| {
            Entry::new(
                scene,
                "64 samples",
                &Pair::METHODS,
                &pictures,
                &difference,
                std::slice::from_ref(&timing),
            )
            .unwrap()
        };
        let html = page(&Pair::METHODS, &[entry("shapes4"), entry("a & b")]);
        assert!(html.contains("href=\"shapes4/report.html\""));
        assert!(html.contains("href=\"a%20%26%20b/report.html\"") && html.contains("a &amp; b"));
        assert_eq!(html.matches("src=\"data:image/").count(), html.matches("<img ").count());
        assert!(!html.contains("http:") && !html.contains("https:") && !html.contains("{{"));
    }
}
