//! `render <scene> --out FILE`: one picture of a scene.

use crate::console::say;
use crate::kinds::{KindArgs, enhance};
use crate::output::check_image_file;
use crate::progress::rays_per_second;
use crate::scene_source::{LoadArgs, load};
use crate::shot::{ShotArgs, take};
use anyhow::Result;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  cargo xtask render shapes4 --out shapes4.png
  cargo xtask render shapes4 --mode vanilla --out vanilla.exr --samples 256
  cargo xtask render path/to/scene.json --kinds points,lines --camera front --out exact.hdr";

/// How all shapes of a scene are traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Mode {
    /// The usual approximations.
    Vanilla,
    /// The exact shapes, for the kinds of `--kinds`.
    Enhanced,
}

/// Options of `render`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The name of a scene in `scenes/`, or the path of a JSON, PLY or OBJ file.
    scene: String,
    /// The image to write: png (sRGB), exr or hdr (linear).
    #[arg(long, value_name = "FILE.{png,exr,hdr}")]
    out: PathBuf,
    /// How points, lines and quads are traced.
    #[arg(long, value_enum, default_value = "enhanced")]
    mode: Mode,
    #[command(flatten)]
    kinds: KindArgs,
    #[command(flatten)]
    shot: ShotArgs,
    #[command(flatten)]
    loading: LoadArgs,
}

pub(crate) fn run(args: Args) -> Result<()> {
    check_image_file(&args.out)?;
    let mut scene = load(&args.scene, &args.loading)?;
    let (camera, options) = args.shot.resolve(&scene)?;
    let (label, kinds) = match args.mode {
        Mode::Vanilla => ("vanilla", Vec::new()),
        Mode::Enhanced => ("enhanced", args.kinds.kinds()),
    };
    enhance(&mut scene.scene, &kinds);
    let shot = args.shot.with_threads(|| take(&scene.scene, camera, &options, label))??;
    rotund_trace::output::write(&args.out, &shot.film)?;
    say(format!(
        "{}: {} x {}, {} samples in {:.2} s, {}",
        args.out.display(),
        options.width,
        options.height,
        options.samples,
        shot.render_seconds,
        rays_per_second(shot.rays_per_second())
    ))
}
