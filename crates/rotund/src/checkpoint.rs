//! Films on disk: checkpoints of a render that can be interrupted, and shards of one picture.

use crate::message::one_line;
use crate::scene_source::NamedScene;
use anyhow::{Result, bail};
use rotund_scene::{Elements, Scene};
use rotund_trace::{Film, Options, Shard, output};
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Options of a render that keeps its film on disk.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct CheckpointArgs {
    /// Save the state of the render in this file, now and then and at the end.
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
}

impl CheckpointArgs {
    /// Returns the film to add samples to, and the file to save it in. `label` names everything
    /// that the samples depend on and that a film has no field for.
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
            bail!("{} exists: add --resume to continue it, or remove it", path.display());
        }
        let film = output::load_film(path)?;
        let of = |film: &Film| (film.width(), film.height(), film.seed(), film.shard());
        if of(&film) != of(&empty) || film.label() != empty.label() {
            bail!(
                "{} is the checkpoint of another picture: {}, not {}",
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

    /// Saves the film if the last time is long enough ago. A failure is only a warning: a disk that
    /// is full now may have room at the end.
    #[expect(clippy::print_stderr, reason = "warnings are for the person, not for a pipe")]
    pub(crate) fn update(&mut self, film: &Film) {
        if self.saved.elapsed() >= self.every {
            if let Err(error) = self.save(film) {
                eprintln!("warning: {}", one_line(&error));
            }
            self.saved = Instant::now();
        }
    }

    /// Saves the film.
    pub(crate) fn save(&self, film: &Film) -> Result<()> {
        Ok(output::save_film(&self.path, film)?)
    }
}

/// Describes a film so that a person can tell it from another.
pub(crate) fn describe(film: &Film) -> String {
    let Shard { index, count } = film.shard();
    let shard = if count > 1 { format!(", shard {}/{count}", index + 1) } else { String::new() };
    let (label, width, height, seed) = (film.label(), film.width(), film.height(), film.seed());
    format!("{label}, {width} x {height}, seed {seed}{shard}")
}

/// Returns the label of a film: scene, camera and options in words, with a hash of the whole scene.
pub(crate) fn label(scene: &NamedScene, camera: usize, options: &Options) -> String {
    let mut hash = Hash(0xcbf2_9ce4_8422_2325);
    hash.scene(&scene.scene);
    let mut label = format!(
        "{} ({:016x}), camera {}, {} bounces",
        scene.name, hash.0, scene.scene.cameras[camera].name, options.bounces
    );
    // Options are named only if they differ from the default.
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

/// FNV-1a over 32-bit words. It detects mistakes; it is no protection against forgery.
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

    /// Hashes the debug text of a small value.
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
