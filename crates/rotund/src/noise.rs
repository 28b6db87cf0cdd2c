//! `noise <scene> --reference FILE`: noise against render time, for both samplers.
//!
//! Noise is `mean((a - b)² / (b² + 0.01))` against the reference, without the worst 0.1 % of the
//! pixels. With plain Monte Carlo it falls as one over the time, so seconds times noise is a figure
//! of merit that does not depend on the number of samples. The measurement includes the noise of
//! the reference, which therefore should have many more samples.

use crate::cancel::Cancel;
use crate::exit::Cancelled;
use crate::kinds::enhance;
use crate::output::{check_distinct, check_file, write_text};
use crate::shot::{PictureArgs, take_on};
use anyhow::{Result, bail};
use rotund_geometry::Method;
use rotund_image::{Image, trimmed_relative_error};
use rotund_report::chart::{self, Labels, Series};
use rotund_report::console::{Table, say};
use rotund_report::html;
use rotund_trace::{Film, Options, Sequence, World};
use std::ffi::OsString;
use std::path::PathBuf;
use std::time::{Duration, Instant};

const EXAMPLES: &str = "\
Examples:
  rotund render shapes4 --samples 4096 --seed 1 --out reference.exr
  rotund noise shapes4 --reference reference.exr --samples 256
  rotund noise path/to/scene.json --reference other.exr --vanilla";

/// Options of `noise`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The name of a built-in scene, or the path of a JSON, PLY, OBJ, SWC, TCK, TRK, XYZ,
    /// TXT, CSV, PTS or ASC file.
    scene: OsString,
    /// The converged picture: exr or hdr, of the size that is rendered.
    #[arg(long, value_name = "FILE.{exr,hdr}")]
    reference: PathBuf,
    /// Trace all shapes by the usual approximations.
    #[arg(long)]
    vanilla: bool,
    /// The page to write, with the plot.
    #[arg(long, value_name = "FILE.html", default_value = "noise.html")]
    out: PathBuf,
    #[command(flatten)]
    picture: PictureArgs,
}

/// Noise after so many samples and seconds.
struct Reading {
    samples: u32,
    seconds: f64,
    noise: f64,
}

pub(crate) fn run(args: Args) -> Result<()> {
    check_file(&args.out)?;
    let reference = Image::read(&args.reference)?;
    let (mut scene, camera, options) = args.picture.load(&args.scene)?;
    check_distinct(&[("--out", &args.out)], &scene.files)?;
    let size = (options.width, options.height);
    if size != (reference.width, reference.height) {
        bail!(
            "{} is {} x {}, the picture {} x {}",
            args.reference.display(),
            reference.width,
            reference.height,
            size.0,
            size.1
        );
    }
    let method = if args.vanilla { Method::Vanilla } else { Method::Enhanced };
    enhance(&mut scene.scene, &args.picture.kinds.kinds_by(method));
    let world = World::new(&scene.scene)?;
    let mut table = Table::new(&["sampler", "samples", "seconds", "noise", "seconds x noise"]);
    let mut curves = Vec::new();
    for (index, (name, sequence)) in
        [("Sobol", Sequence::Sobol), ("independent", Sequence::Independent)].into_iter().enumerate()
    {
        let options = Options { sequence, ..options.clone() };
        let mut readings: Vec<Reading> = Vec::new();
        let (start, mut reading_time) = (Instant::now(), Duration::ZERO);
        // The sizes agree; a film without a finite pixel has no error that could be drawn.
        let noise =
            |film: &Film| trimmed_relative_error(&film.image(), &reference).unwrap_or(f64::NAN);
        let mut read = |film: &Film, _: Cancel| {
            let now = start.elapsed();
            // Readings are spaced evenly on a logarithmic axis as far as passes allow: the number
            // of samples of a film rises at the end of a pass, when all pixels have as many.
            let due = readings.last().map_or(1, |last| 2 * last.samples).min(options.samples);
            if film.samples() >= due {
                readings.push(Reading {
                    samples: film.samples(),
                    seconds: (now - reading_time).as_secs_f64(),
                    noise: noise(film),
                });
            }
            reading_time += start.elapsed() - now;
        };
        let shot = args.picture.shot.with_threads(|| {
            let film = Film::for_options(&options)?;
            take_on(film, &world, camera, &options, name, &mut read)
        })?;
        if shot.interrupted {
            bail!(Cancelled("nothing was written".to_owned()));
        }
        for Reading { samples, seconds, noise } in &readings {
            table.row([
                name.to_owned(),
                samples.to_string(),
                format!("{seconds:.2}"),
                format!("{noise:.6}"),
                format!("{:.5}", seconds * noise),
            ]);
        }
        curves.push(Series {
            name: name.to_owned(),
            color: chart::color(index),
            approximate: false,
            points: readings.iter().map(|reading| (reading.seconds, reading.noise)).collect(),
        });
    }
    let title = format!("{}: noise against time", scene.name);
    let labels = Labels { title: &title, x: "seconds", y: "relative squared error" };
    let body = format!(
        "<h1>{}</h1>\n{}{}<pre>{table}</pre>",
        html::escape(&title),
        chart::legend(&curves),
        chart::curves(&labels, &curves, None),
    );
    let page = html::page(&title, "", &body);
    write_text(&args.out, &page)?;
    say(table.to_string())?;
    say(format!("\nopen {}", args.out.display()))
}
