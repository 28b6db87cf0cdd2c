//! The page of `rays`: bars of speed, and a picture of what each pixel costs.

use super::recipe::SIDE;
use super::{Row, Sheet};
use anyhow::Result;
use base64::Engine as _;
use image::{ExtendedColorType, ImageEncoder as _, codecs::png::PngEncoder};
use std::fmt::Write as _;

const STYLE: &str = "\
body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#222}
h2{margin-top:3rem}table{border-collapse:collapse;width:100%}td,th{padding:.25rem .5rem;text-align:right}
td:first-child,th:first-child{text-align:left}.bars{width:50%}.bar{height:.7rem;margin:.1rem 0;background:#0072b2}
.peer{background:#8a8f98}img{width:100%;max-width:32rem;image-rendering:pixelated}figure{margin:1rem 0}";

/// One file that opens offline.
pub(super) fn page(sheets: &[Sheet]) -> Result<String> {
    let mut html = format!(
        "<!doctype html><html lang=en><meta charset=utf-8><title>Rays per second</title>\
         <style>{STYLE}</style><h1>Rays per second</h1>\
         <p>Single rays. On one thread, millions per CPU second; on all, per elapsed second. The bar of this \
         library is blue, that of the peer gray.</p>"
    );
    for sheet in sheets {
        section(&mut html, sheet)?;
    }
    html.push_str("</html>\n");
    Ok(html)
}

fn section(html: &mut String, sheet: &Sheet) -> Result<()> {
    let Some(first) = sheet.rows.first() else { return Ok(()) };
    let peer = first.peer_build_seconds.map(|s| format!(", the peer {s:.3} s")).unwrap_or_default();
    write!(
        html,
        "<h2>{}, {}</h2><p>Built in {:.3} CPU seconds{peer}; {:.1} bytes per primitive; SAH {:.1}; {}.</p>\
         <table><tr><th>rays<th>threads<th>Mrays/s<th>ratio<th>hit<th>nodes<th>primitives<th class=bars>",
        escape(&sheet.scene),
        first.form,
        first.build_seconds,
        first.bytes_per_primitive,
        first.sah,
        first.isa,
    )?;
    let most = sheet
        .rows
        .iter()
        .flat_map(|row| [Some(row.mrays_per_second), row.peer_mrays_per_second])
        .flatten()
        .fold(0.0, f64::max);
    for row in &sheet.rows {
        bar(html, row, most)?;
    }
    let picture = base64::engine::general_purpose::STANDARD.encode(cost_picture(&sheet.visits)?);
    let mean =
        sheet.visits.iter().map(|&v| f64::from(v)).sum::<f64>() / sheet.visits.len().max(1) as f64;
    write!(
        html,
        "</table><figure><img alt='cost per pixel' src='data:image/png;base64,{picture}'><figcaption>Nodes and \
         primitives that each pixel looks at: {mean:.0} on average, from black (none) to light yellow \
         ({} or more).</figcaption></figure>",
        brightest(&sheet.visits)
    )?;
    Ok(())
}

fn bar(html: &mut String, row: &Row, most: f64) -> Result<()> {
    let ratio = row.ratio.map_or_else(String::new, |ratio| format!("{ratio:.2}"));
    write!(
        html,
        "<tr><td>{}<td>{}<td>{:.2}<td>{ratio}<td>{:.3}<td>{:.1}<td>{:.1}<td>\
         <div class=bar style='width:{:.1}%'></div>",
        row.rays,
        row.threads,
        row.mrays_per_second,
        row.hit_share,
        row.nodes_per_ray,
        row.primitives_per_ray,
        100.0 * row.mrays_per_second / most,
    )?;
    if let Some(peer) = row.peer_mrays_per_second {
        write!(html, "<div class='bar peer' style='width:{:.1}%'></div>", 100.0 * peer / most)?;
    }
    Ok(())
}

/// The count that is drawn brightest: few pixels have more.
fn brightest(visits: &[u32]) -> u32 {
    let mut sorted = visits.to_vec();
    sorted.sort_unstable();
    sorted.get(sorted.len() * 99 / 100).copied().unwrap_or(1).max(1)
}

fn cost_picture(visits: &[u32]) -> Result<Vec<u8>> {
    let most = f64::from(brightest(visits));
    let pixels: Vec<u8> = visits
        .iter()
        .flat_map(|&count| {
            let color = colorous::INFERNO.eval_continuous((f64::from(count) / most).min(1.0));
            [color.r, color.g, color.b]
        })
        .collect();
    let mut png = Vec::new();
    let (side, color) = (SIDE as u32, ExtendedColorType::Rgb8);
    PngEncoder::new(&mut png).write_image(&pixels, side, side, color)?;
    Ok(png)
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}
