//! `render <scene> --out FILE`: one picture of a scene.

use crate::background::{self, Background};
use crate::cancel::Cancel;
use crate::checkpoint::{Checkpoint, CheckpointArgs};
use crate::choice;
use crate::denoised::Denoised;
use crate::exit::{Cancelled, NoCheckpoint};
use crate::kinds::enhance;
use crate::memory;
use crate::message::{one_line, warn};
use crate::origin::origin;
use crate::output::{check_distinct, check_file, check_image_file};
use crate::progress::rays_per_second;
use crate::scene_source::is_lone;
use crate::shot::{PictureArgs, odd_samples, take_on};
use anyhow::{Error, Result, bail};
use rotund_geometry::Method;
use rotund_image::{Format, Image};
use rotund_report::console::say;
use rotund_scene::Overlap;
use rotund_trace::{Film, Options, View, World, output};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  rotund render shapes4 --out shapes4.png
  rotund render cloud.ply --radius 0.01 --out cloud.png
  rotund render neuron.swc --background white --out neuron.png
  rotund render scan.ply --up y --transparent --out scan.png
  rotund render shapes4 --mode vanilla --out vanilla.exr --samples 256
  rotund render scene.json --kinds lines --camera front --out lines.hdr
  rotund render shapes4 --checkpoint a.film --resume --out shapes4.exr
  rotund render shapes4 --checkpoint {shard}.film --resume --shard 2/8
  rotund render shapes4 --view shading-normal --samples 4 --out normals.png
  rotund render shapes4 --layers --out shapes4.exr
  rotund render shapes4 --samples 16 --denoise --out shapes4.png";

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

/// What overlapping elements are, on the command line.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum OverlapKind {
    Union,
    Separate,
}

/// Options of `render`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The name of a built-in scene, or the path of a JSON, PLY, OBJ, SWC, TCK, TRK, XYZ,
    /// TXT, CSV, PTS or ASC file.
    scene: OsString,
    /// The image to write: png or jpg (sRGB), exr or hdr (linear).
    #[arg(long, value_name = "FILE.{png,jpg,exr,hdr}", required_unless_present = "checkpoint")]
    out: Option<PathBuf>,
    /// The quantity that the picture shows.
    #[arg(long, value_parser = choice::parser::<View>(views()), default_value = "path")]
    view: View,
    /// Make the background transparent: the environment lights the scene but is hidden from the
    /// camera. The file of a shape by itself gets no floor, unless --floor is given.
    #[arg(long)]
    transparent: bool,
    /// Show this colour (sRGB) instead of the environment, which still lights the scene: white,
    /// black, grey, #rgb or #rrggbb. The file of a shape by itself gets no floor, unless --floor is
    /// given.
    #[arg(long, value_name = "COLOUR", value_parser = background::parse)]
    #[arg(conflicts_with = "transparent")]
    background: Option<Background>,
    /// Keep the floor of the file of a shape by itself, in spite of --transparent or --background.
    #[arg(long)]
    floor: bool,
    /// Add albedo, normal, depth, position and ids to the image as layers; only an exr holds them.
    #[arg(long, requires = "out")]
    layers: bool,
    /// Write a denoised picture beside the plain one: `a.denoised.png` beside `a.png`. It takes
    /// Intel Open Image Denoise 2, which is looked for at run time; the variable ROTUND_OIDN names
    /// its library.
    #[arg(long, requires = "out")]
    denoise: bool,
    /// The method that points, lines and quads are traced by.
    #[arg(long, value_parser = choice::parser::<Method>(methods()), default_value = "enhanced")]
    mode: Method,
    /// Make the points or lines of a shape that overlap one body, or give each its own whole
    /// surface. Default: as the scene says.
    #[arg(long, value_enum)]
    overlap: Option<OverlapKind>,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    checkpoint: CheckpointArgs,
}

pub(crate) fn run(mut args: Args) -> Result<()> {
    let out = args.out.as_deref().map(|out| args.checkpoint.with_shard(out)).transpose()?;
    if let Some(out) = &out {
        let format = check_image_file(out)?;
        if args.layers && format != Format::Exr {
            bail!("cannot write layers to {}: only an exr holds them", out.display());
        }
        if args.transparent && !matches!(format, Format::Png | Format::Exr) {
            bail!("cannot write {}: only png and exr hold a transparent background", out.display());
        }
    }
    let transparent = args.transparent || args.background.is_some();
    args.picture.loading.without_floor = transparent && !args.floor;
    // Before the render: a library that is missing is known at once, and not after a night.
    let denoised = out.as_deref().filter(|_| args.denoise).map(Denoised::beside).transpose()?;
    let checkpoint = args.checkpoint.path()?;
    if let Some(checkpoint) = &checkpoint {
        check_file(checkpoint)?;
    }
    let (mut scene, camera, options) = args.picture.load(&args.scene)?;
    if args.floor && !transparent {
        warn("--floor changes nothing without --transparent or --background: no floor is left out");
    } else if args.floor && !is_lone(&args.scene) {
        warn("--floor changes nothing: it is for files of shapes that are loaded by themselves");
    }
    let outputs = [
        ("--out", out.as_deref()),
        ("--denoise", denoised.as_ref().map(Denoised::path)),
        ("--checkpoint", checkpoint.as_deref()),
    ];
    let outputs: Vec<_> = outputs.iter().filter_map(|&(name, path)| Some((name, path?))).collect();
    check_distinct(&outputs, &scene.files)?;
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
    enhance(&mut scene.scene, &args.picture.kinds.kinds_by(args.mode));
    match args.overlap {
        None => {}
        Some(OverlapKind::Union) => scene.scene.set_overlap(Overlap::Union),
        Some(OverlapKind::Separate) => scene.scene.set_overlap(Overlap::Separate),
    }
    let origin = origin(&scene, camera, &options);
    let (film, mut checkpoint) = args.checkpoint.open(&options, origin)?;
    memory::check_scene(&scene.scene)?;
    let wants_layers = args.layers || denoised.is_some();
    let check_picture = || memory::check_picture(options.width, options.height, wants_layers);
    let (shot, layers) = args.picture.shot.with_threads(|| {
        let world = World::new(&scene.scene)?;
        if out.is_some() {
            check_picture()?;
        }
        let mut keep = |film: &Film, cancel: Cancel| {
            if let Some(checkpoint) = &mut checkpoint {
                checkpoint.update(film, cancel);
            }
        };
        let shot = take_on(film, &world, camera, &options, label, &mut keep)?;
        let layers = wants_layers.then(|| world.layers(camera, &options)).transpose();
        Ok((shot, layers))
    })?;
    let film = &shot.film;
    // The picture comes first, and neither failure costs the other file.
    let written = out.as_deref().map(|out| {
        check_picture()?;
        let before = |image: Image| match args.background {
            Some(Background(color)) => image.before(color),
            None => image,
        };
        let layers = layers?;
        match layers.as_ref().filter(|_| args.layers) {
            Some(layers) => output::write_layers(out, &before(film.image()), layers)?,
            None => before(film.image()).write(out)?,
        }
        if let (Some(denoised), Some(layers)) = (&denoised, &layers) {
            denoised.write(&film.image(), layers, before)?;
        }
        Ok(())
    });
    let saved = checkpoint.as_mut().map(|checkpoint| checkpoint.save(film));
    let checkpoint = checkpoint.as_ref().map(Checkpoint::path);
    let lost = judge(written, saved, checkpoint)?;
    let kept = checkpoint.filter(|_| lost.is_none());
    let files = [out.as_deref(), denoised.as_ref().map(Denoised::path), kept];
    let files: Vec<_> = files.iter().flatten().map(|path| path.display().to_string()).collect();
    let files = files.join(" and ");
    if shot.interrupted {
        if let Some(lost) = lost {
            warn(one_line(&lost));
        }
        let wanted = options.shard.share_of(options.samples);
        bail!(Cancelled(format!("{files}: {} of {wanted} samples", film.samples())));
    }
    say(format!(
        "{files}: {} x {}, {} samples in {:.2} s, {}{}",
        options.width,
        options.height,
        film.samples(),
        shot.render_seconds,
        rays_per_second(shot.rays_per_second()),
        odd_samples(film)
    ))?;
    match lost {
        Some(lost) => {
            bail!(NoCheckpoint(format!("{}: the picture cannot be continued", one_line(&lost))))
        }
        None => Ok(()),
    }
}

/// Returns the failure of a checkpoint beside a picture that was written; other failures are those
/// of the command.
fn judge(
    written: Option<Result<()>>,
    saved: Option<Result<()>>,
    checkpoint: Option<&Path>,
) -> Result<Option<Error>> {
    match (written, saved) {
        (Some(Err(error)), saved) => {
            match (saved, checkpoint) {
                (Some(Err(lost)), _) => warn(one_line(&lost)),
                (_, Some(kept)) => {
                    warn(format!("{} has the samples: run again with --resume", kept.display()));
                }
                _ => {}
            }
            Err(error)
        }
        (None, Some(Err(error))) => Err(error),
        (Some(Ok(())), Some(Err(lost))) => Ok(Some(lost)),
        _ => Ok(None),
    }
}
