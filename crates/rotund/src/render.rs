//! `render <scene> --out FILE`: one picture of a scene.

use crate::background::{self, Background};
use crate::cancel::Cancelled;
use crate::checkpoint::{self, Checkpoint, CheckpointArgs};
use crate::choice;
use crate::kinds::enhance;
use crate::output::check_image_file;
use crate::progress::rays_per_second;
use crate::shot::{PictureArgs, odd_samples, take_on};
use anyhow::{Result, bail};
use rotund_geometry::Method;
use rotund_image::Format;
use rotund_report::console::say;
use rotund_trace::{Film, Options, View, World, output};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  rotund render shapes4 --out shapes4.png
  rotund render cloud.ply --radius 0.01 --out cloud.png
  rotund render neuron.swc --background white --out neuron.png
  rotund render scan.ply --up y --transparent --out scan.png
  rotund render shapes4 --mode vanilla --out vanilla.exr --samples 256
  rotund render scene.json --kinds lines --camera front --out lines.hdr
  rotund render shapes4 --checkpoint a.film --resume --out shapes4.exr
  rotund render shapes4 --checkpoint 2.film --resume --shard 2/8
  rotund render shapes4 --view shading-normal --samples 4 --out normals.png
  rotund render shapes4 --layers --out shapes4.exr";

/// The names of the methods, each with a line of help.
fn methods() -> [(&'static str, &'static str); 2] {
    Method::ALL.map(|method| {
        let help = match method {
            Method::Vanilla => "The usual approximations",
            Method::Enhanced => "The exact shapes, for the kinds of --kinds",
        };
        (method.name(), help)
    })
}

/// The names of the views, each with a line of help.
fn views() -> impl Iterator<Item = (&'static str, &'static str)> {
    View::ALL.into_iter().map(|view| (view.name(), view.description()))
}

/// Options of `render`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The name of a built-in scene, or the path of a JSON, PLY, OBJ, SWC, TCK, TRK, XYZ,
    /// TXT, CSV, PTS or ASC file.
    scene: String,
    /// The image to write: png or jpg (sRGB), exr or hdr (linear).
    #[arg(long, value_name = "FILE.{png,jpg,exr,hdr}", required_unless_present = "checkpoint")]
    out: Option<PathBuf>,
    /// The quantity that the picture shows.
    #[arg(long, value_parser = choice::parser::<View>(views()), default_value = "path")]
    view: View,
    /// Make the background transparent: the environment lights the scene but is hidden from the
    /// camera. The file of a shape by itself gets no floor.
    #[arg(long)]
    transparent: bool,
    /// Show this colour (sRGB) instead of the environment, which still lights the scene: white,
    /// black, grey, #rgb or #rrggbb. The file of a shape by itself gets no floor.
    #[arg(long, value_name = "COLOUR", value_parser = background::parse)]
    #[arg(conflicts_with = "transparent")]
    background: Option<Background>,
    /// Add albedo, normal, depth, position and ids to the image as layers; only an exr holds them.
    #[arg(long, requires = "out")]
    layers: bool,
    /// The method that points, lines and quads are traced by.
    #[arg(long, value_parser = choice::parser::<Method>(methods()), default_value = "enhanced")]
    mode: Method,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    checkpoint: CheckpointArgs,
}

pub(crate) fn run(mut args: Args) -> Result<()> {
    if let Some(out) = &args.out {
        let format = check_image_file(out)?;
        if args.layers && format != Format::Exr {
            bail!("cannot write layers to {}: only an exr holds them", out.display());
        }
        if args.transparent && !matches!(format, Format::Png | Format::Exr) {
            bail!("cannot write {}: only png and exr hold a transparent background", out.display());
        }
    }
    let transparent = args.transparent || args.background.is_some();
    args.picture.loading.without_floor = transparent;
    let (mut scene, camera, options) = args.picture.load(&args.scene)?;
    let shard = args.checkpoint.shard.unwrap_or_default();
    let options = Options {
        view: args.view,
        transparent,
        shard,
        // Layers hold positions in the world, and the picture must show the same rays.
        recenter: !args.layers,
        ..options
    };
    let label = args.mode.name();
    let kinds = match args.mode {
        Method::Vanilla => Vec::new(),
        Method::Enhanced => args.picture.kinds.kinds(),
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
        let image = match args.background {
            Some(Background(color)) => shot.film.image().before(color),
            None => shot.film.image(),
        };
        match &layers {
            Some(layers) => output::write_layers(out, &image, layers)?,
            None => image.write(out)?,
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
