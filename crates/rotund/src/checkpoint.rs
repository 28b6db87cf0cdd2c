//! Films on disk: checkpoints of a render that can be interrupted, and shards of one picture.

use crate::cancel::Cancel;
use crate::message::{note, one_line, warn};
use anyhow::{Context as _, Result, bail};
use rotund_trace::{Film, FilmHeader, Options, Origin, Shard, output};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Options of a render that keeps its film on disk.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct CheckpointArgs {
    /// Save the state of the render in this file, now and then and at the end. {shard} in its name,
    /// and in that of --out, becomes the number of the shard.
    #[arg(long, value_name = "FILE")]
    checkpoint: Option<PathBuf>,
    /// Seconds between checkpoints.
    #[arg(long, value_name = "SECONDS", default_value_t = 60, requires = "checkpoint")]
    checkpoint_every: u64,
    /// Continue from the checkpoint if there is one. The picture equals that of an uninterrupted
    /// render bit for bit.
    #[arg(long, requires = "checkpoint")]
    resume: bool,
    /// Render only shard I of N, counted from 1: every N-th sample. `merge` makes one picture of
    /// the checkpoints of all shards.
    #[arg(long, value_name = "I/N", value_parser = parse_shard, requires = "checkpoint")]
    pub(crate) shard: Option<Shard>,
}

fn parse_shard(text: &str) -> Result<Shard, String> {
    let numbers = text.split_once('/').and_then(|(index, count)| {
        Some((index.trim().parse::<u32>().ok()?, count.trim().parse::<u32>().ok()?))
    });
    match numbers {
        Some((index, count)) if (1..=count).contains(&index) => {
            Ok(Shard { index: index - 1, count })
        }
        Some((_, count)) if count > 0 => {
            Err(format!("shards are counted from 1: 1/{count} to {count}/{count}"))
        }
        _ => Err("a shard is written as 2/8: the second of eight".to_owned()),
    }
}

/// The file that a film is saved in.
#[derive(Debug)]
pub(crate) struct Checkpoint {
    path: PathBuf,
    every: Duration,
    saved: Instant,
    /// True if the file lacks samples of the film.
    is_behind: bool,
    /// True if the last try to write it failed, which is said once.
    has_failed: bool,
}

impl CheckpointArgs {
    /// Returns the file to save the film in, if any.
    pub(crate) fn path(&self) -> Result<Option<PathBuf>> {
        self.checkpoint.as_deref().map(|path| self.with_shard(path)).transpose()
    }

    /// Replaces `{shard}` in a name by the number of the shard, with as many digits as the last
    /// one has, so that names sort by number.
    pub(crate) fn with_shard(&self, path: &Path) -> Result<PathBuf> {
        const PLACE: &str = "{shard}";
        let has_place = path.to_string_lossy().contains(PLACE);
        match (path.to_str(), self.shard) {
            _ if !has_place => Ok(path.into()),
            (Some(text), Some(Shard { index, count })) => {
                let digits = count.to_string().len();
                let number = format!("{:0digits$}", u64::from(index) + 1);
                Ok(text.replace(PLACE, &number).into())
            }
            (_, None) => bail!("{} names a shard, but there is no --shard", path.display()),
            (None, _) => bail!("cannot replace {PLACE} in {}: it is not UTF-8", path.display()),
        }
    }

    /// Returns the film to add samples to, and the file to save it in. `origin` stands for
    /// everything that the samples depend on and that a film has no field for.
    pub(crate) fn open(
        &self,
        options: &Options,
        origin: Origin,
    ) -> Result<(Film, Option<Checkpoint>)> {
        options.validate()?;
        let path = self.path()?;
        let every = Duration::from_secs(self.checkpoint_every);
        let checkpoint = path.as_ref().map(|path| Checkpoint {
            path: path.clone(),
            every,
            saved: Instant::now(),
            is_behind: true,
            has_failed: false,
        });
        let Some(path) = path.filter(|path| path.exists()) else {
            return Ok((Film::for_options(options)?.with_origin(origin), checkpoint));
        };
        if !self.resume {
            bail!("{} exists: add --resume to continue it, or remove it", path.display());
        }
        let found = output::load_film_header(&path)?;
        let wanted = FilmHeader { origin, ..FilmHeader::for_options(options) };
        check_fit(&found, &wanted)
            .with_context(|| format!("{} is the checkpoint of another picture", path.display()))?;
        let film = output::load_film(&path)?;
        let (most, share) = (film.most_samples(), wanted.share());
        if most > share {
            bail!("{} has {most} samples already, more than the {share} asked for", path.display());
        }
        note(format!("{} continues from {} of {share} samples", path.display(), film.samples()));
        Ok((film, checkpoint))
    }
}

/// Checks that a film is of the picture and the shard that are wanted, whatever number of samples.
fn check_fit(found: &FilmHeader, wanted: &FilmHeader) -> Result<()> {
    let mut differences = FilmHeader { wanted: wanted.wanted, ..found.clone() }.differences(wanted);
    if differences.is_empty() && found.shards != wanted.shards {
        differences = format!("{}, not {}", found.shards, wanted.shards);
    }
    if differences.is_empty() { Ok(()) } else { bail!(differences) }
}

impl Checkpoint {
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Saves the film if the last time is long enough ago, unless a signal ends the render: then
    /// the picture goes first. A failure is only a warning: a disk that is full now may
    /// have room at the end.
    pub(crate) fn update(&mut self, film: &Film, cancel: Cancel) {
        self.is_behind = true;
        if self.saved.elapsed() >= self.every {
            match output::save_film_unless(&self.path, film, || cancel.requested()) {
                Ok(saved) => (self.is_behind, self.has_failed) = (!saved, false),
                Err(error) => {
                    if !self.has_failed {
                        warn(format!("{}: it will be tried again", one_line(&error.into())));
                    }
                    self.has_failed = true;
                }
            }
            self.saved = Instant::now();
        }
    }

    /// Saves the film, unless the file has all its samples.
    pub(crate) fn save(&mut self, film: &Film) -> Result<()> {
        if self.is_behind {
            output::save_film(&self.path, film)?;
            self.is_behind = false;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_of_the_shard_fills_its_place_in_a_name() {
        let args = |shard| CheckpointArgs {
            checkpoint: Some("{shard}/a-{shard}.film".into()),
            checkpoint_every: 60,
            resume: false,
            shard,
        };
        let path = args(Some(Shard { index: 6, count: 100 })).path().expect("a name");
        assert_eq!(path.as_deref(), Some(Path::new("007/a-007.film")));
        let error = args(None).path().expect_err("no shard").to_string();
        assert_eq!(error, "{shard}/a-{shard}.film names a shard, but there is no --shard");
        let plain = args(None).with_shard(Path::new("a.exr")).expect("a name");
        assert_eq!(plain, Path::new("a.exr"));
    }

    #[test]
    fn shards_are_counted_from_one() {
        assert_eq!(parse_shard("1/1"), Ok(Shard { index: 0, count: 1 }));
        assert_eq!(parse_shard("3/8"), Ok(Shard { index: 2, count: 8 }));
        for bad in ["0/4", "5/4"] {
            assert_eq!(parse_shard(bad), Err("shards are counted from 1: 1/4 to 4/4".to_owned()));
        }
        for bad in ["", "3", "1/0", "a/b", "-1/4"] {
            assert!(parse_shard(bad).is_err(), "{bad}");
        }
    }
}
