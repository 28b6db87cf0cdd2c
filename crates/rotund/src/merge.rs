//! `merge CHECKPOINT... --out FILE`: one picture of the shards of a render.

use crate::checkpoint::describe;
use crate::output::check_image_file;
use crate::shot::odd_samples;
use anyhow::{Result, anyhow};
use rotund_report::console::say;
use rotund_trace::{Film, MergeError, output};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  for i in 1 2 3 4; do
    rotund render shapes4 --shard $i/4 --checkpoint $i.film --resume
  done
  rotund merge 1.film 2.film 3.film 4.film --out shapes4.exr";

/// Options of `merge`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The finished checkpoints of all shards, in any order.
    #[arg(required = true, value_name = "CHECKPOINT")]
    films: Vec<PathBuf>,
    /// The image to write: png or jpg (sRGB), exr or hdr (linear).
    #[arg(long, value_name = "FILE.{png,jpg,exr,hdr}")]
    out: PathBuf,
}

pub(crate) fn run(args: Args) -> Result<()> {
    check_image_file(&args.out)?;
    let films: Vec<Film> = args.films.iter().map(output::load_film).collect::<Result<_, _>>()?;
    let film = Film::merge(&films).map_err(|error| match error {
        // The user knows a shard by its file, not by its number.
        MergeError::Different { number } => anyhow!(
            "{} belongs to another picture than {}: to {}, not to {}",
            args.films[number - 1].display(),
            args.films[0].display(),
            describe(&films[number - 1]),
            describe(&films[0])
        ),
        error => error.into(),
    })?;
    output::write(&args.out, &film)?;
    say(format!(
        "{}: {} x {}, {} samples of {} shards{}",
        args.out.display(),
        film.width(),
        film.height(),
        film.samples(),
        films.len(),
        odd_samples(&film)
    ))
}
