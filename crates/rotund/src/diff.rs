//! `diff A B`: the difference of two images, in numbers and maps.
//!
//! Reads EXR, HDR, PNG and JPEG. `B` is the reference of relative errors.

use crate::output::check_distinct;
use anyhow::{Context, Result};
use rotund_image::{Difference, Image, Metrics};
use rotund_report::console::{Table, say};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  rotund diff out/shapes4/enhanced.exr out/shapes4/vanilla.exr
  rotund diff mine.exr reference.exr --json
  rotund diff a.png b.png --signed-map signed.png --flip-map flip.png";

/// Options of `diff`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// An image: exr or hdr (linear), png or jpg (sRGB).
    a: PathBuf,
    /// The reference, of the same size.
    b: PathBuf,
    /// Write where A is brighter (red) and darker (blue) than B, as a PNG with a legend.
    #[arg(long, value_name = "FILE.png")]
    signed_map: Option<PathBuf>,
    /// Write the FLIP error of each pixel, as a PNG with a legend.
    #[arg(long, value_name = "FILE.png")]
    flip_map: Option<PathBuf>,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: Args) -> Result<()> {
    let maps = [("--signed-map", &args.signed_map), ("--flip-map", &args.flip_map)];
    let maps: Vec<_> =
        maps.iter().filter_map(|&(name, path)| Some((name, path.as_deref()?))).collect();
    check_distinct(&maps, &[args.a.clone(), args.b.clone()])?;
    let (a, b) = (Image::read(&args.a)?, Image::read(&args.b)?);
    let difference = Difference::between(&a, &b).with_context(|| {
        format!("cannot compare {} with {}", args.a.display(), args.b.display())
    })?;
    if let Some(path) = &args.signed_map {
        difference.signed_map("luminance of A - B").write(path)?;
    }
    if let Some(path) = &args.flip_map {
        difference.flip_map().write(path)?;
    }
    if args.json {
        return say(serde_json::to_string_pretty(&difference.metrics)?);
    }
    say(table(&difference.metrics).to_string())
}

fn table(m: &Metrics) -> Table {
    let mut table = Table::new(&["metric", "value"]);
    table.row(["mean luminance of A".to_owned(), format!("{:.6}", m.mean_luminance_a)]);
    table.row(["mean luminance of B".to_owned(), format!("{:.6}", m.mean_luminance_b)]);
    table.row(["ratio A / B".to_owned(), format!("{:.5}", m.luminance_ratio)]);
    table.row(["mean_abs".to_owned(), format!("{:.6}", m.mean_abs)]);
    table.row(["rmse".to_owned(), format!("{:.6}", m.rmse)]);
    table.row(["rel_mse".to_owned(), format!("{:.6}", m.rel_mse)]);
    table.row(["rel_mse without the worst 0.1 %".to_owned(), format!("{:.6}", m.rel_mse_trimmed)]);
    table.row(["flip_mean".to_owned(), format!("{:.6}", m.flip_mean)]);
    table.row(["changed_fraction".to_owned(), format!("{:.6}", m.changed_fraction)]);
    if m.invalid_pixels > 0 {
        table.row(["pixels left out, not finite".to_owned(), m.invalid_pixels.to_string()]);
    }
    table
}
