//! `render <scene> --out FILE`: one picture of a scene.

use crate::cancel::Cancelled;
use crate::checkpoint::{self, Checkpoint, CheckpointArgs};
use crate::kinds::enhance;
use crate::output::check_image_file;
use crate::progress::rays_per_second;
use crate::shot::{PictureArgs, odd_samples, take_on};
use anyhow::{Result, bail};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use rotund_report::console::say;
use rotund_trace::{Film, Options, View, World, output};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  cargo xtask render shapes4 --out shapes4.png
  cargo xtask render shapes4 --mode vanilla --out vanilla.exr --samples 256
  cargo xtask render path/to/scene.json --kinds points,lines --camera front --out exact.hdr
  cargo xtask render shapes4 --samples 4096 --checkpoint shapes4.film --resume --out shapes4.exr
  cargo xtask render shapes4 --samples 4096 --checkpoint part-2.film --resume --shard 2/8
  cargo xtask render shapes4 --view shading-normal --samples 4 --out normals.png
  cargo xtask render shapes4 --layers --out shapes4.exr";

/// How all shapes of a scene are traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Mode {
    /// The usual approximations.
    Vanilla,
    /// The exact shapes, for the kinds of `--kinds`.
    Enhanced,
}

/// The parser of `--view`, with a line of help for each view.
fn view_parser() -> impl TypedValueParser<Value = View> {
    let value = |view: View| PossibleValue::new(view.name()).help(view.description());
    PossibleValuesParser::new(View::ALL.map(value)).try_map(|name| name.parse::<View>())
}

/// Options of `render`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The name of a scene in `scenes/`, or the path of a JSON, PLY or OBJ file.
    scene: String,
    /// The image to write: png (sRGB), exr or hdr (linear).
    #[arg(long, value_name = "FILE.{png,exr,hdr}", required_unless_present = "checkpoint")]
    out: Option<PathBuf>,
    /// What the picture shows.
    #[arg(long, value_parser = view_parser(), default_value = "path")]
    view: View,
    /// Hide the environment from the camera: the background is transparent. It lights the scene all
    /// the same.
    #[arg(long)]
    transparent: bool,
    /// Add albedo, normal, depth, position and ids to the image as layers; it must be an exr.
    #[arg(long, requires = "out")]
    layers: bool,
    /// How points, lines and quads are traced.
    #[arg(long, value_enum, default_value = "enhanced")]
    mode: Mode,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    checkpoint: CheckpointArgs,
}

pub(crate) fn run(args: Args) -> Result<()> {
    if let Some(out) = &args.out {
        check_image_file(out)?;
        let is_exr = out.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
        if args.layers && !is_exr {
            bail!("cannot write layers to {}: only an exr holds them", out.display());
        }
    }
    let (mut scene, camera, options) = args.picture.load(&args.scene)?;
    let shard = args.checkpoint.shard.unwrap_or_default();
    let options = Options {
        view: args.view,
        transparent: args.transparent,
        shard,
        // Layers show positions where they are, and the picture must be of the same rays.
        recenter: !args.layers,
        ..options
    };
    let (label, kinds) = match args.mode {
        Mode::Vanilla => ("vanilla", Vec::new()),
        Mode::Enhanced => ("enhanced", args.picture.kinds.kinds()),
    };
    enhance(&mut scene.scene, &kinds);
    let label_of_film = checkpoint::label(&scene, camera, &options);
    let (film, mut checkpoint) = args.checkpoint.open(&options, label_of_film)?;
    let (shot, layers) = args.picture.shot.with_threads(|| {
        let world = World::new(&scene.scene)?;
        let mut keep = |film: &Film| {
            if let Some(checkpoint) = &mut checkpoint {
                checkpoint.update(film);
            }
        };
        let shot = take_on(film, &world, camera, &options, label, &mut keep)?;
        let layers = args.layers.then(|| world.layers(camera, &options)).transpose()?;
        Ok((shot, layers))
    })?;
    if let Some(checkpoint) = &checkpoint {
        checkpoint.save(&shot.film)?;
    }
    if let Some(out) = &args.out {
        match &layers {
            Some(layers) => output::write_layers(out, &shot.film.image(), layers)?,
            None => output::write(out, &shot.film)?,
        }
    }
    let files = [args.out.as_deref(), checkpoint.as_ref().map(Checkpoint::path)];
    let files: Vec<_> = files.iter().flatten().map(|path| path.display().to_string()).collect();
    let files = files.join(" and ");
    if shot.interrupted {
        let wanted = options.shard.share_of(options.samples);
        bail!(Cancelled(format!("{files}: {} of {wanted} samples", shot.film.samples())));
    }
    say(format!(
        "{files}: {} x {}, {} samples in {:.2} s, {}{}",
        options.width,
        options.height,
        shot.film.samples(),
        shot.render_seconds,
        rays_per_second(shot.rays_per_second()),
        odd_samples(&shot.film)
    ))
}
