//! `merge FILM... --out FILE`: one picture, or one film, of the shards of a render.
//!
//! Two films are in memory at a time, however many shards there are.

use crate::exit::NotFinished;
use crate::memory;
use crate::output::{check_distinct, check_file, check_image_file};
use crate::shot::odd_samples;
use anyhow::{Result, anyhow, bail};
use rotund_report::console::say;
use rotund_trace::output::{load_film, load_film_header, save_film, write};
use rotund_trace::{Film, FilmHeader, MergeError};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  for i in 1 2 3 4; do
    rotund render shapes4 --shard $i/4 --checkpoint {shard}.film --resume
  done
  rotund merge 1.film 2.film 3.film 4.film --out shapes4.exr
  rotund merge 1.film 3.film --partial --out preview.png
  rotund merge 1.film 2.film --partial --out half.film";

/// Films that a message lists.
const MOST_LISTED: usize = 4;

/// Options of `merge`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The checkpoints of all shards, in any order, or films of merged ones.
    #[arg(required = true, value_name = "FILM")]
    films: Vec<PathBuf>,
    /// The image to write: png or jpg (sRGB), exr or hdr (linear). Or a film, to be merged with
    /// others; one of all shards is the checkpoint of the undivided render, to which `render
    /// --resume` adds samples.
    #[arg(long, value_name = "FILE.{png,jpg,exr,hdr,film}")]
    out: PathBuf,
    /// Accept missing and unfinished shards, for a preview.
    #[arg(long)]
    partial: bool,
}

pub(crate) fn run(args: Args) -> Result<()> {
    let is_film = args.out.extension().is_some_and(|extension| extension == "film");
    if is_film {
        check_file(&args.out)?;
    } else {
        check_image_file(&args.out)?;
    }
    check_distinct(&[("--out", &args.out)], &args.films)?;
    let headers: Vec<_> = args.films.iter().map(load_film_header).collect::<Result<_, _>>()?;
    FilmHeader::check_merge(&headers, args.partial)
        .map_err(|error| explain(error, &args.films, &headers))?;
    let film = join(&args.films, &headers)?;
    if is_film {
        save_film(&args.out, &film)?;
    } else {
        memory::check_picture(film.width(), film.height(), false)?;
        write(&args.out, &film)?;
    }
    say(format!(
        "{}: {} x {}, {} of {} samples of {} films{}{}",
        args.out.display(),
        film.width(),
        film.height(),
        film.samples(),
        film.header().wanted,
        args.films.len(),
        left(film.header()),
        odd_samples(&film)
    ))
}

/// Loads and adds up the films.
fn join(paths: &[PathBuf], headers: &[FilmHeader]) -> Result<Film> {
    let mut sum: Option<Film> = None;
    for (path, header) in paths.iter().zip(headers) {
        let film = load_film(path)?;
        // The rest was checked by the headers.
        if film.header() != header {
            bail!("{} was changed while it was read: merge again", path.display());
        }
        match &mut sum {
            None => sum = Some(film),
            Some(sum) => sum.absorb(&film)?,
        }
    }
    sum.ok_or_else(|| MergeError::Nothing.into())
}

/// Returns what is missing, for the end of a message; an empty text if nothing is.
fn left(header: &FilmHeader) -> String {
    let shards = if header.shards.count() > 1 {
        format!("; {} alone", header.shards)
    } else {
        String::new()
    };
    let state = if header.is_finished() { "" } else { "; not finished" };
    shards + state
}

/// Replaces the numbers of films by their files, which is what the user knows them by.
fn explain(error: MergeError, paths: &[PathBuf], headers: &[FilmHeader]) -> anyhow::Error {
    let path = |number: usize| paths[number - 1].display();
    match error {
        MergeError::Different { number, usual } => anyhow!(
            "{} is of another picture than {}: {}",
            path(number),
            path(usual),
            headers[number - 1].differences(&headers[usual - 1])
        ),
        MergeError::Twice { index, .. } => {
            let holds = |header: &FilmHeader| header.shards.indices().contains(&index);
            let holders = paths.iter().zip(headers).filter(|(_, header)| holds(header));
            let holders: Vec<_> = holders.map(|(path, _)| path.as_path()).collect();
            anyhow!("{error}: in {}", list(&holders, |path| path.display().to_string()))
        }
        MergeError::Unfinished { numbers } => {
            let text = list(&numbers, |&number| {
                let header = &headers[number - 1];
                format!("{} ({} of {} samples)", path(number), header.samples, header.share())
            });
            NotFinished(format!("not finished: {text}")).into()
        }
        MergeError::Missing { .. } => NotFinished(error.to_string()).into(),
        error => error.into(),
    }
}

/// Writes the first of some things, and how many there are beside them.
fn list<T>(things: &[T], text: impl Fn(&T) -> String) -> String {
    let shown: Vec<_> = things.iter().take(MOST_LISTED).map(text).collect();
    let rest = things.len() - shown.len();
    let more = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    shown.join(", ") + &more
}
