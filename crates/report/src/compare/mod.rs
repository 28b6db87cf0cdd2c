//! The page about two renders of a scene: a slider over both pictures, their difference, and
//! numbers.

use crate::embed;
use crate::html::escape;
use crops::Crop;
use rotund_image::{Difference, EncodeError, Image, Metrics, maps};

mod crops;
mod histogram;
pub mod index;

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");

/// Size of a crop in pixels; it is shown four times as large.
const CROP: (usize, usize) = (44, 33);
const CROP_COUNT: usize = 6;

/// The content of a page.
#[derive(Debug)]
pub struct Report<'a> {
    /// Heading of the page.
    pub scene: &'a str,
    /// Camera, size, samples and so on, in words.
    pub settings: &'a str,
    /// The names of both renders.
    pub pair: &'a Pair,
    /// Pictures on the left and on the right of the slider.
    pub pictures: [&'a Image; 2],
    /// Difference of the second picture from the first.
    pub difference: &'a Difference,
    /// Rows of numbers about the two renders.
    pub timings: &'a [Timing],
    /// Comparison at equal time instead of equal samples, if there is one.
    pub equal_time: Option<EqualTime<'a>>,
}

/// The names of the two renders that are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair {
    /// Names of the first and of the second.
    pub names: [&'static str; 2],
    /// What each is, in words.
    pub meanings: [&'static str; 2],
}

impl Pair {
    /// The vanilla method and the enhanced one.
    pub const METHODS: Self = Self {
        names: ["vanilla", "enhanced"],
        meanings: [
            "points as discs, lines by distance, quads as two triangles",
            "points as spheres, lines as rounded cones, quads as bilinear patches",
        ],
    };

    /// Overlapping elements with surfaces of their own, and as one body.
    pub const OVERLAPS: Self = Self {
        names: ["separate", "union"],
        meanings: [
            "each point and line has its own whole surface",
            "the points or lines of a shape are one body",
        ],
    };
}

/// A picture of the faster render that took as long as the other one.
#[derive(Clone, Copy, Debug)]
pub struct EqualTime<'a> {
    /// Name of the faster render.
    pub faster: &'static str,
    /// Picture of the faster render, with more samples.
    pub picture: &'a Image,
    /// Samples of the slower render and of the faster one.
    pub samples: [u32; 2],
    /// Seconds of the slower render and of the faster one.
    pub seconds: [f64; 2],
    /// Difference of the second picture from the first at equal time.
    pub metrics: Metrics,
}

/// One number about each of the two renders.
#[derive(Clone, Debug)]
pub struct Timing {
    /// Name of the number, with its unit.
    pub label: &'static str,
    /// Values of the first and of the second render.
    pub values: [f64; 2],
    /// Number of digits after the decimal point.
    pub digits: usize,
}

/// Returns the page.
///
/// # Errors
///
/// If a picture has no pixels.
pub fn page(report: &Report<'_>) -> Result<String, EncodeError> {
    let Report { pair, pictures: both, difference, .. } = report;
    let [first, second] = pair.names;
    let worst = crops::worst(&difference.flip, CROP.0, CROP.1, CROP_COUNT);
    let range = maps::signed_range(&difference.signed);
    let signed = maps::signed(&difference.signed, range);
    let flip = maps::flip(&difference.flip);

    let crops = if worst.is_empty() {
        "<p>Nowhere: the pictures look the same.</p>".to_owned()
    } else {
        let mut html = String::from("<div class=\"crops\">\n");
        for (index, crop) in worst.iter().enumerate() {
            let images = [(first, both[0]), (second, both[1]), ("FLIP", &flip)];
            html += &crop_figure(index + 1, crop, images)?;
        }
        html + "</div>"
    };
    let signed_title = format!(
        "Luminance of {second} minus {first}: red where {second} is lighter, blue where darker."
    );
    let flip_title = "FLIP: how visible the difference is to someone who flips between the two.";
    let ticks = [format!("\u{2212}{range}"), "0".to_owned(), format!("+{range}")];
    let maps = map_figure(&signed_title, &embed::photo(&signed)?, &ticks, maps::diverging, "")
        + &map_figure(
            flip_title,
            &embed::photo(&flip)?,
            &["0", "0.5", "1"].map(str::to_owned),
            maps::sequential,
            &marks(&worst, flip.width, flip.height),
        );
    Ok(fill(
        PAGE,
        &[
            ("scene", &escape(report.scene)),
            ("settings", &escape(report.settings)),
            ("first", first),
            ("second", second),
            ("heading", &heading(pair)),
            ("style", STYLE.trim_end()),
            ("script", SCRIPT.trim_end()),
            ("width", &both[0].width.to_string()),
            ("height", &both[0].height.to_string()),
            ("pictures", &pictures(pair, *both, report.equal_time.as_ref())?),
            (
                "choice",
                &report.equal_time.as_ref().map(|longer| choice(pair, longer)).unwrap_or_default(),
            ),
            ("lightness", &histogram::of_lightness(*both)),
            ("visibility", &histogram::of_flip(&difference.flip)),
            ("crops", &crops),
            ("metrics", &metrics_table(pair, difference, report.equal_time.as_ref())),
            ("timings", &timings_table(pair, report.timings)),
            ("maps", &maps),
        ],
    ))
}

/// Replaces each `{{name}}` of `template` once, from left to right, so that text that is filled in
/// is never interpreted as a template.
///
/// # Panics
///
/// If the template names a value that is missing: the templates are part of this program.
fn fill(template: &str, values: &[(&str, &str)]) -> String {
    let mut parts = template.split("{{");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (name, rest) = part.split_once("}}").expect("each {{ has its }}");
        let value = values.iter().find(|(key, _)| *key == name);
        text += value.unwrap_or_else(|| panic!("no value for {{{{{name}}}}}")).1;
        text += rest;
    }
    text
}

/// Returns the names of both, with a capital letter.
fn heading(pair: &Pair) -> String {
    let [first, second] = pair.names;
    let (initial, rest) = first.split_at(1);
    format!("{}{rest} and {second}", initial.to_uppercase())
}

/// Returns the pictures that the slider shows over each other.
fn pictures(
    pair: &Pair,
    pictures: [&Image; 2],
    equal_time: Option<&EqualTime<'_>>,
) -> Result<String, EncodeError> {
    let mut html = String::new();
    for (index, class) in ["first", "second"].into_iter().enumerate() {
        let (name, meaning, image) = (pair.names[index], pair.meanings[index], pictures[index]);
        let uri = embed::photo(image)?;
        html += &format!(
            "<img class=\"{class}\" src=\"{uri}\" alt=\"The {name} picture: {meaning}\">\n"
        );
        if let Some(longer) = equal_time.filter(|longer| longer.faster == name) {
            let uri = embed::photo(longer.picture)?;
            let samples = longer.samples[1];
            html += &format!(
                "<img class=\"{class} longer\" src=\"{uri}\" \
                 alt=\"The {name} picture with {samples} samples\">\n"
            );
        }
    }
    Ok(html)
}

/// Returns the buttons that switch between equal samples and equal time.
fn choice(pair: &Pair, equal_time: &EqualTime<'_>) -> String {
    let EqualTime { faster, samples: [fewer, more], seconds: [slow, fast], .. } = equal_time;
    let slower = pair.names[usize::from(*faster == pair.names[0])];
    format!(
        "<fieldset class=\"choice\"><legend>The two pictures have</legend>\n\
         <label><input type=\"radio\" name=\"equal\" checked> equal samples: {fewer}</label>\n\
         <label><input type=\"radio\" name=\"equal\" id=\"equal-time\"> equal time: {slower} \
         {fewer} samples in {slow:.1} s, {faster} {more} in {fast:.1} s</label>\n</fieldset>"
    )
}

fn crop_figure(
    number: usize,
    crop: &Crop,
    images: [(&str, &Image); 3],
) -> Result<String, EncodeError> {
    let (x, y) = (crop.x, crop.y);
    let mut html = format!(
        "<div><h3>{number}. at x = {x}, y = {y}; mean FLIP {:.3}</h3>\n\
         <div class=\"row\">\n",
        crop.error
    );
    let (width, height) = (4 * crop.width, 4 * crop.height);
    for (name, image) in images {
        let part = [crop.x, crop.y, crop.width, crop.height].map(|side| side as u32);
        let uri = embed::exact(&image.crop(part[0], part[1], part[2], part[3]))?;
        let alt = format!("{name}, {} by {} pixels at {x}, {y}", crop.width, crop.height);
        html += &format!(
            "<figure><img src=\"{uri}\" alt=\"{alt}\" width=\"{width}\" height=\"{height}\">\
             <figcaption>{name}</figcaption></figure>\n"
        );
    }
    Ok(html + "</div></div>\n")
}

fn map_figure(
    title: &str,
    uri: &str,
    ticks: &[String; 3],
    color: fn(f64) -> [u8; 3],
    marks: &str,
) -> String {
    let stops: Vec<String> = (0..=16)
        .map(|i| {
            let [r, g, b] = color(f64::from(i) / 16.0);
            format!("rgb({r} {g} {b})")
        })
        .collect();
    let [low, middle, high] = ticks;
    format!(
        "<figure><div class=\"map\"><img src=\"{uri}\" alt=\"{title}\">{marks}</div>\n\
         <div class=\"scale\" style=\"background: linear-gradient(to right, {})\"></div>\n\
         <div class=\"ticks\"><span>{low}</span><span>{middle}</span><span>{high}</span></div>\n\
         <figcaption>{title}</figcaption></figure>\n",
        stops.join(", ")
    )
}

/// Returns numbered frames at the places of the crops.
fn marks(crops: &[Crop], width: u32, height: u32) -> String {
    let percent = |part: usize, whole: u32| 100.0 * part as f64 / f64::from(whole);
    let mark = |(index, crop): (usize, &Crop)| {
        format!(
            "<span class=\"mark\" style=\"left: {:.2}%; top: {:.2}%; width: {:.2}%; height: \
             {:.2}%\">{}</span>",
            percent(crop.x, width),
            percent(crop.y, height),
            percent(crop.width, width),
            percent(crop.height, height),
            index + 1
        )
    };
    crops.iter().enumerate().map(mark).collect()
}

fn metrics_table(
    pair: &Pair,
    difference: &Difference,
    equal_time: Option<&EqualTime<'_>>,
) -> String {
    type Row<'a> = (&'a str, &'a str, fn(&Metrics) -> f64);
    let [first, second] = pair.names;
    let means = [second, first].map(|name| format!("mean luminance, {name}"));
    let ratio = format!("{second} over {first}");
    let rows: [Row<'_>; 9] = [
        (&means[0], "", |m| m.mean_luminance_a),
        (&means[1], "", |m| m.mean_luminance_b),
        ("luminance ratio", &ratio, |m| m.luminance_ratio),
        ("mean_abs", "mean of |b \u{2212} a| in linear RGB, a the first picture", |m| m.mean_abs),
        ("rmse", "root of the mean of (b \u{2212} a)\u{b2}", |m| m.rmse),
        ("rel_mse", "mean of (b \u{2212} a)\u{b2} / (a\u{b2} + 0.01)", |m| m.rel_mse),
        ("rel_mse, trimmed", "without the worst 0.1 % of the pixels", |m| m.rel_mse_trimmed),
        ("flip_mean", "0: no visible difference, 1: the largest possible", |m| m.flip_mean),
        ("changed_fraction", "pixels that differ by more than two steps of 8-bit sRGB", |m| {
            m.changed_fraction
        }),
    ];
    let mut html = String::from("<table><caption>Difference</caption>\n");
    if equal_time.is_some() {
        html += "<thead><tr><th></th><th scope=\"col\">equal samples</th>\
                 <th scope=\"col\">equal time</th></tr></thead>";
    }
    html += "<tbody>\n";
    for (name, meaning, value) in rows {
        html += &format!("<tr><th scope=\"row\">{name}<small>{meaning}</small></th>");
        html += &format!("<td>{:.6}</td>", value(&difference.metrics));
        if let Some(longer) = equal_time {
            html += &format!("<td>{:.6}</td>", value(&longer.metrics));
        }
        html += "</tr>\n";
    }
    html + "</tbody></table>"
}

fn timings_table(pair: &Pair, timings: &[Timing]) -> String {
    let [first, second] = pair.names;
    let mut html = format!(
        "<table><caption>Time</caption>\n<thead><tr><th></th><th scope=\"col\">{first}</th>\
         <th scope=\"col\">{second}</th><th scope=\"col\">ratio</th></tr></thead><tbody>\n",
    );
    for Timing { label, values: [first, second], digits } in timings {
        let ratio = if *first > 0.0 { format!("{:.2}", second / first) } else { String::new() };
        html += &format!("<tr><th scope=\"row\">{label}</th><td>{first:.digits$}</td>");
        html += &format!("<td>{second:.digits$}</td><td>{ratio}</td></tr>\n");
    }
    html + "</tbody></table>"
}

#[cfg(test)]
mod tests;
