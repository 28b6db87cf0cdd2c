//! `diff A B`: how far two images are apart, in numbers.
//!
//! Reads EXR, HDR, PNG and JPEG; `B` is the reference that relative errors are relative to.

use crate::console::{Table, say};
use crate::difference::metrics::{Metrics, metrics};
use crate::picture::Picture;
use anyhow::{Context, Result};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  cargo xtask diff out/shapes4/enhanced.exr out/shapes4/vanilla.exr
  cargo xtask diff mine.exr reference.exr --json";

/// Options of `diff`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// An image: exr or hdr (linear), png or jpg (sRGB).
    a: PathBuf,
    /// The image it is held against, of the same size.
    b: PathBuf,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: Args) -> Result<()> {
    let (a, b) = (Picture::read(&args.a)?, Picture::read(&args.b)?);
    let metrics = metrics(&a, &b).with_context(|| {
        format!("cannot compare {} with {}", args.a.display(), args.b.display())
    })?;
    if args.json {
        return say(serde_json::to_string_pretty(&metrics)?);
    }
    say(table(&metrics).to_string())
}

fn table(m: &Metrics) -> Table {
    let mut table = Table::new(&["metric", "value"]);
    table.row(["mean luminance of A".to_owned(), format!("{:.6}", m.mean_luminance_a)]);
    table.row(["mean luminance of B".to_owned(), format!("{:.6}", m.mean_luminance_b)]);
    table.row(["ratio A / B".to_owned(), format!("{:.5}", m.luminance_ratio)]);
    table.row(["mean_abs".to_owned(), format!("{:.6}", m.mean_abs)]);
    table.row(["rmse".to_owned(), format!("{:.6}", m.rmse)]);
    table.row(["rel_mse".to_owned(), format!("{:.6}", m.rel_mse)]);
    table.row(["rel_mse, worst 0.1 % left out".to_owned(), format!("{:.6}", m.rel_mse_trimmed)]);
    table.row(["changed_fraction".to_owned(), format!("{:.6}", m.changed_fraction)]);
    if m.invalid_pixels > 0 {
        table.row(["pixels not finite, left out".to_owned(), m.invalid_pixels.to_string()]);
    }
    table
}
