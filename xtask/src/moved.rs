//! `moved <scene>`: does a picture stay the same where the world is far away, tiny or huge?
//!
//! Renders the enhanced picture of a scene unchanged; then with everything moved away from the
//! origin, and with everything modelled in other units, camera included, so that the pictures
//! should be the same. The differences that remain are rounding: positions in single precision have
//! 24 bits, so at 10 km from the origin they are multiples of a millimeter. To tell rounding from
//! noise, the picture with another seed is compared with the first as well.

use anyhow::{Result, bail};
use rotund::{Cancelled, PictureArgs, enhance, prepare_folder, take, write_text};
use rotund_image::{Difference, Image, Metrics};
use rotund_report::console::{Table, say};
use rotund_scene::Scene;
use rotund_study::placement::placed;
use serde_json::json;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  cargo xtask moved shapes4
  cargo xtask moved shapes4 --camera front --offset 1e4,1e5 --scale 0.001,1000";

/// Options of `moved`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The name of a scene in `scenes/`, or the path of a JSON, PLY, OBJ, SWC, TCK, TRK,
    /// XYZ, TXT, CSV, PTS or ASC file.
    scene: OsString,
    /// How far everything is moved along x, y and z, in meters: cameras and instances.
    #[arg(long, value_name = "METERS", value_delimiter = ',', default_value = "1e4")]
    #[arg(value_parser = offset, allow_negative_numbers = true)]
    offset: Vec<f64>,
    /// How much larger everything is: vertices, radii, frames, cameras and depths inside materials.
    #[arg(long, value_name = "FACTORS", value_delimiter = ',', default_value = "1e-3,1e3")]
    #[arg(value_parser = scale)]
    scale: Vec<f64>,
    /// The folder to write to; `out/`, the name of the scene and `-moved` if not given.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the content of `metrics.json` instead of a table.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    picture: PictureArgs,
}

fn offset(text: &str) -> Result<f64, String> {
    let offset = text.parse::<f64>().ok().filter(|offset| offset.is_finite());
    offset.ok_or_else(|| "an offset is a finite number of meters".to_owned())
}

fn scale(text: &str) -> Result<f64, String> {
    let scale = text.parse::<f64>().ok().filter(|&scale| scale > 0.0 && scale.is_finite());
    scale.ok_or_else(|| "a factor is a finite number above zero".to_owned())
}

/// A picture that should be the same.
struct Variant {
    name: String,
    scene: Scene,
    seed: u64,
}

pub(crate) fn run(args: Args) -> Result<()> {
    let (mut source, camera, options) = args.picture.load(&args.scene)?;
    let folder = args.out.unwrap_or_else(|| Path::new("out").join(source.name.clone() + "-moved"));
    prepare_folder(&folder)?;
    enhance(&mut source.scene, &args.picture.kinds.kinds());
    let scene = source.scene;

    let seed = options.seed;
    let mut variants =
        vec![Variant { name: "another-seed".into(), scene: scene.clone(), seed: seed ^ 1 << 63 }];
    for &offset in &args.offset {
        let scene = placed(&scene, 1.0, offset);
        variants.push(Variant { name: format!("offset-{offset}"), scene, seed });
    }
    for &scale in &args.scale {
        let scene = placed(&scene, scale, 0.0);
        variants.push(Variant { name: format!("scale-{scale}"), scene, seed });
    }

    let picture = |scene: &Scene, seed, label: &str| -> Result<Image> {
        let options = rotund_trace::Options { seed, ..options.clone() };
        let shot = args.picture.shot.with_threads(|| take(scene, camera, &options, label))?;
        if shot.interrupted {
            bail!(Cancelled(format!("{} holds the pictures before {label}", folder.display())));
        }
        rotund_trace::output::write(folder.join(format!("{label}.png")), &shot.film)?;
        Ok(shot.film.image())
    };
    let base = picture(&scene, seed, "as-it-is")?;
    let mut rows: Vec<(String, Metrics)> = Vec::new();
    for Variant { name, scene, seed } in variants {
        let difference = Difference::between(&picture(&scene, seed, &name)?, &base)?;
        difference.flip_map().write(folder.join(format!("{name}-flip.png")))?;
        rows.push((name, difference.metrics));
    }

    let metrics: serde_json::Map<_, _> =
        rows.iter().map(|(name, metrics)| (name.clone(), json!(metrics))).collect();
    let metrics = serde_json::to_string_pretty(&metrics)?;
    write_text(&folder.join("metrics.json"), &(metrics.clone() + "\n"))?;
    if args.json { say(metrics) } else { say(table(&rows).to_string()) }
}

fn table(rows: &[(String, Metrics)]) -> Table {
    let mut table =
        Table::new(&["against as-it-is", "light", "rel_mse", "flip_mean", "changed_fraction"]);
    for (name, m) in rows {
        table.row([
            name.clone(),
            format!("{:.5}", m.luminance_ratio),
            format!("{:.6}", m.rel_mse),
            format!("{:.5}", m.flip_mean),
            format!("{:.4}", m.changed_fraction),
        ]);
    }
    table
}
