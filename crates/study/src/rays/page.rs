//! The page of `rays`: bars of speed, and a picture of the traversal cost of each pixel.

use super::recipe::SIDE;
use super::{Row, Sheet};
use anyhow::Result;
use rotund_image::Image;
use rotund_report::embed::exact;
use rotund_report::html::{self, escape};
use std::fmt::Write as _;

const STYLE: &str = "\
body { max-width: 60rem; }
table { width: 100%; }
th.bars { width: 50%; }
.bar { height: .7rem; margin: .1rem 0; background: #0072b2; }
.peer { background: #8a8f98; }
figure { margin: 1rem 0; }
figure img { width: 100%; max-width: 32rem; image-rendering: pixelated; }
";

/// Returns one file that opens offline.
pub(super) fn page(sheets: &[Sheet]) -> Result<String> {
    let title = "Rays per second";
    let mut body = format!(
        "<h1>{title}</h1><p>Single rays. On one thread, millions per CPU second; on all, per elapsed second. \
         The bar of this library is blue, that of the peer gray.</p>"
    );
    for sheet in sheets {
        section(&mut body, sheet)?;
    }
    Ok(html::page(title, STYLE, &body))
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
    let picture = exact(&cost_picture(&sheet.visits))?;
    let mean =
        sheet.visits.iter().map(|&v| f64::from(v)).sum::<f64>() / sheet.visits.len().max(1) as f64;
    write!(
        html,
        "</table><figure><img alt='cost per pixel' src='{picture}'><figcaption>Nodes and \
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

/// Returns the count that is drawn brightest: the 99th percentile.
fn brightest(visits: &[u32]) -> u32 {
    let mut sorted = visits.to_vec();
    sorted.sort_unstable();
    sorted.get(sorted.len() * 99 / 100).copied().unwrap_or(1).max(1)
}

fn cost_picture(visits: &[u32]) -> Image {
    let most = f64::from(brightest(visits));
    let side = SIDE as u32;
    Image::from_srgb_fn(side, side, |x, y| {
        let count = visits[y as usize * SIDE + x as usize];
        colorous::INFERNO.eval_continuous((f64::from(count) / most).min(1.0)).as_array()
    })
}
