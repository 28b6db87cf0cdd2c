//! Films on disk: a render that can be stopped at any time and go on, and shards of one picture.

use crate::scene_source::NamedScene;
use anyhow::{Result, bail};
use rotund_scene::{Elements, Scene};
use rotund_trace::{Film, Options, Shard, output};
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Options of a render that leaves its film on disk.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct CheckpointArgs {
    /// Keep all that is needed to go on in this file: it is replaced now and then, and at the end.
    #[arg(long, value_name = "FILE")]
    checkpoint: Option<PathBuf>,
    /// Seconds between checkpoints.
    #[arg(long, value_name = "SECONDS", default_value_t = 60, requires = "checkpoint")]
    checkpoint_every: u64,
    /// Go on from the checkpoint, if there is one; the picture is that of an uninterrupted render, bit for bit.
    #[arg(long, requires = "checkpoint")]
    resume: bool,
    /// Render every N-th sample only, the I-th and so on, counted from 1; `merge` makes one picture of
    /// the checkpoints of all N shards.
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

/// A file that follows a film.
#[derive(Debug)]
pub(crate) struct Checkpoint {
    path: PathBuf,
    every: Duration,
    saved: Instant,
}

impl CheckpointArgs {
    /// The film to add to, and the file to keep it in. `label` tells all that the samples depend on and
    /// a film does not know.
    pub(crate) fn open(
        &self,
        options: &Options,
        label: String,
    ) -> Result<(Film, Option<Checkpoint>)> {
        let empty = Film::for_options(options)?.with_label(label);
        let Some(path) = &self.checkpoint else { return Ok((empty, None)) };
        let checkpoint = Checkpoint {
            path: path.clone(),
            every: Duration::from_secs(self.checkpoint_every),
            saved: Instant::now(),
        };
        crate::output::check_file(path)?;
        if !path.exists() {
            return Ok((empty, Some(checkpoint)));
        }
        if !self.resume {
            bail!("{} exists: add --resume to go on from it, or remove it", path.display());
        }
        let film = output::load_film(path)?;
        let of = |film: &Film| (film.width(), film.height(), film.seed(), film.shard());
        if of(&film) != of(&empty) || film.label() != empty.label() {
            bail!(
                "{} is the checkpoint of another picture: it is of {}, not of {}",
                path.display(),
                describe(&film),
                describe(&empty)
            );
        }
        let wanted = options.shard.share_of(options.samples);
        if film.samples() > wanted {
            bail!(
                "{} has {} samples already, more than the {wanted} asked for",
                path.display(),
                film.samples()
            );
        }
        Ok((film, Some(checkpoint)))
    }
}

impl Checkpoint {
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Replaces the file if it is old enough. A disk that is full now may not be at the end.
    #[expect(clippy::print_stderr, reason = "warnings are for the person, not for a pipe")]
    pub(crate) fn update(&mut self, film: &Film) {
        if self.saved.elapsed() >= self.every {
            if let Err(error) = self.save(film) {
                eprintln!("warning: {error:#}");
            }
            self.saved = Instant::now();
        }
    }

    /// Replaces the file.
    pub(crate) fn save(&self, film: &Film) -> Result<()> {
        Ok(output::save_film(&self.path, film)?)
    }
}

/// What a film is of, for a person who has to tell it from another.
pub(crate) fn describe(film: &Film) -> String {
    let Shard { index, count } = film.shard();
    let shard = if count > 1 { format!(", shard {}/{count}", index + 1) } else { String::new() };
    let (label, width, height, seed) = (film.label(), film.width(), film.height(), film.seed());
    format!("{label}, {width} x {height}, seed {seed}{shard}")
}

/// What a film is of, in words, with a hash of the whole scene.
pub(crate) fn label(scene: &NamedScene, camera: usize, options: &Options) -> String {
    let mut hash = Hash(0xcbf2_9ce4_8422_2325);
    hash.scene(&scene.scene);
    let mut label = format!(
        "{} ({:016x}), camera {}, {} bounces",
        scene.name, hash.0, scene.scene.cameras[camera].name, options.bounces
    );
    // What is not the default is worth a word.
    let usual = Options::default();
    if options.sequence != usual.sequence {
        label += &format!(", {:?} numbers", options.sequence).to_lowercase();
    }
    if options.view != usual.view {
        label += &format!(", view {}", options.view);
    }
    if options.transparent {
        label += ", transparent";
    }
    if let Some(clamp) = options.clamp {
        label += &format!(", clamped to {clamp}");
    }
    label
}

/// FNV-1a over words: against mistakes, not against malice.
struct Hash(u64);

impl Hash {
    fn word(&mut self, word: u32) {
        self.0 = (self.0 ^ u64::from(word)).wrapping_mul(0x0000_0100_0000_01b3);
    }

    fn floats<const N: usize>(&mut self, vectors: impl Iterator<Item = [f32; N]>) {
        vectors.for_each(|vector| vector.iter().for_each(|x| self.word(x.to_bits())));
    }

    fn words<const N: usize>(&mut self, vectors: &[[u32; N]]) {
        vectors.iter().flatten().for_each(|&word| self.word(word));
    }

    fn scene(&mut self, scene: &Scene) {
        for shape in &scene.shapes {
            self.debug(&(shape.method, shape.elements.kind()));
            match &shape.elements {
                Elements::Points(count) => self.word(*count),
                Elements::Lines(lines) => self.words(lines),
                Elements::Triangles(triangles) => self.words(triangles),
                Elements::Quads(quads) => self.words(quads),
            }
            self.floats(shape.positions.iter().map(|p| p.to_array()));
            self.floats(shape.normals.iter().map(|n| n.to_array()));
            self.floats(shape.texcoords.iter().map(|t| t.to_array()));
            self.floats(shape.colors.iter().map(|c| c.to_array()));
            self.floats(shape.radii.iter().map(|&r| [r]));
        }
        for texture in &scene.textures {
            self.debug(&(texture.width, texture.height));
            let places = (0..texture.height).flat_map(|y| (0..texture.width).map(move |x| (x, y)));
            self.floats(places.map(|(x, y)| texture.color_at(x, y).to_array()));
        }
        self.debug(&(&scene.cameras, &scene.materials, &scene.instances, &scene.environments));
    }

    /// Small things by what they print.
    fn debug(&mut self, value: &impl fmt::Debug) {
        format!("{value:?}").bytes().for_each(|byte| self.word(u32::from(byte)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
