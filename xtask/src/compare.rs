//! `compare <scene>`: the same picture by both methods, and what changed.
//!
//! Renders the scene vanilla and enhanced with equal seeds. Writes into one folder: `vanilla` and
//! `enhanced` (PNG and EXR), `difference.png`, `flip.png`, `metrics.json` and `report.html`.

use crate::cancel::Cancelled;
use crate::console::{Table, say};
use crate::difference::Difference;
use crate::kinds::{Kind, KindArgs, enhance};
use crate::output::{prepare_folder, write_text};
use crate::picture::{Picture, write_png};
use crate::report::{self, Report, Timing};
use crate::scene_source::{LoadArgs, NamedScene, load};
use crate::shot::{Shot, ShotArgs, take};
use anyhow::{Result, bail};
use rotund_trace::Options;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  cargo xtask compare shapes4
  cargo xtask compare shapes4 --camera front --samples 256 --resolution 2160 --bounces 8
  cargo xtask compare path/to/scene.json --kinds lines --out out/only-lines";

/// Options of `compare`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The name of a scene in `scenes/`, or the path of a JSON, PLY or OBJ file.
    scene: String,
    /// The folder to write to; `out/` and the name of the scene if not given.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the content of `metrics.json` instead of a table.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    kinds: KindArgs,
    #[command(flatten)]
    shot: ShotArgs,
    #[command(flatten)]
    loading: LoadArgs,
}

pub(crate) fn run(args: Args) -> Result<()> {
    let mut scene = load(&args.scene, &args.loading)?;
    let (camera, options) = args.shot.resolve(&scene)?;
    let folder = args.out.unwrap_or_else(|| Path::new("out").join(&scene.name));
    prepare_folder(&folder)?;

    let kinds = args.kinds.kinds();
    let shots = args.shot.with_threads(|| {
        enhance(&mut scene.scene, &[]);
        let vanilla = take(&scene.scene, camera, &options, NAMES[0]);
        if vanilla.interrupted {
            return [Some(vanilla), None];
        }
        enhance(&mut scene.scene, &kinds);
        let enhanced = take(&scene.scene, camera, &options, NAMES[1]);
        [Some(vanilla), Some(enhanced)]
    })?;
    let [Some(vanilla), Some(enhanced)] = shots else {
        for shot in shots.iter().flatten() {
            write_picture(&folder, NAMES[0], shot)?;
        }
        let done = shots.iter().flatten().map(|shot| shot.film.samples).sum::<u32>();
        bail!(Cancelled(format!(
            "{} holds vanilla with {done} of {} samples",
            folder.display(),
            options.samples
        )));
    };
    let done = enhanced.film.samples;
    let comparison = Comparison::new(&scene, camera, &options, &kinds, vanilla, enhanced)?;
    comparison.write(&folder)?;
    if done < options.samples {
        bail!(Cancelled(format!(
            "{} holds vanilla with all and enhanced with {done} of {} samples",
            folder.display(),
            options.samples
        )));
    }
    if args.json {
        say(serde_json::to_string_pretty(&comparison.metrics())?)
    } else {
        say(comparison.table().to_string())?;
        say(format!("\nopen {}", folder.join("report.html").display()))
    }
}

/// Both renders and their difference.
struct Comparison<'a> {
    scene: &'a str,
    camera: &'a str,
    options: &'a Options,
    kinds: Vec<&'static str>,
    shots: [Shot; 2],
    pictures: [Picture; 2],
    difference: Difference,
}

const NAMES: [&str; 2] = ["vanilla", "enhanced"];

fn write_picture(folder: &Path, name: &str, shot: &Shot) -> Result<()> {
    for extension in ["png", "exr"] {
        rotund_trace::output::write(folder.join(format!("{name}.{extension}")), &shot.film)?;
    }
    Ok(())
}

impl<'a> Comparison<'a> {
    fn new(
        scene: &'a NamedScene,
        camera: usize,
        options: &'a Options,
        kinds: &[Kind],
        vanilla: Shot,
        enhanced: Shot,
    ) -> Result<Self> {
        let pictures = [&vanilla, &enhanced].map(|shot| Picture::from(&shot.film.image()));
        let difference = Difference::between(&pictures[1], &pictures[0])?;
        Ok(Self {
            scene: &scene.name,
            camera: &scene.scene.cameras[camera].name,
            options,
            kinds: kinds.iter().map(|kind| kind.name()).collect(),
            shots: [vanilla, enhanced],
            pictures,
            difference,
        })
    }

    fn write(&self, folder: &Path) -> Result<()> {
        for (name, shot) in NAMES.iter().zip(&self.shots) {
            write_picture(folder, name, shot)?;
        }
        let title = "luminance of enhanced - vanilla";
        write_png(&folder.join("difference.png"), &self.difference.signed_map(title))?;
        write_png(&folder.join("flip.png"), &self.difference.flip_map())?;
        let metrics = serde_json::to_string_pretty(&self.metrics())? + "\n";
        write_text(&folder.join("metrics.json"), &metrics)?;
        write_text(&folder.join("report.html"), &self.report()?)
    }

    /// What `metrics.json` holds. In `difference`, `a` is enhanced and `b` is vanilla.
    fn metrics(&self) -> Value {
        let [vanilla, enhanced] = self.shots.each_ref().map(|shot| {
            json!({
                "build_seconds": shot.build_seconds,
                "render_seconds": shot.render_seconds,
                "rays": shot.rays,
                "rays_per_second": shot.rays_per_second(),
                "samples": shot.film.samples,
                "samples_per_second": shot.samples_per_second(),
                "rejected_samples": shot.film.rejected,
                "fireflies": shot.film.fireflies,
                "clamped_samples": shot.film.clamped,
            })
        });
        json!({
            "scene": self.scene,
            "camera": self.camera,
            "width": self.options.width,
            "height": self.options.height,
            "samples": self.options.samples,
            "bounces": self.options.bounces,
            "seed": self.options.seed,
            "kinds": self.kinds,
            "vanilla": vanilla,
            "enhanced": enhanced,
            "difference": self.difference.metrics,
        })
    }

    fn timings(&self) -> Vec<Timing> {
        let row = |label, digits, value: fn(&Shot) -> f64| {
            let [vanilla, enhanced] = self.shots.each_ref().map(value);
            Timing { label, vanilla, enhanced, digits }
        };
        vec![
            row("build, s", 3, |shot| shot.build_seconds),
            row("render, s", 2, |shot| shot.render_seconds),
            row("rays, millions", 2, |shot| shot.rays as f64 / 1e6),
            row("Mrays/s", 2, |shot| shot.rays_per_second() / 1e6),
            row("Msamples/s", 2, |shot| shot.samples_per_second() / 1e6),
            row("rejected samples", 0, |shot| shot.film.rejected as f64),
            row("fireflies", 0, |shot| shot.film.fireflies as f64),
        ]
    }

    fn table(&self) -> Table {
        let mut table = Table::new(&[self.scene, "vanilla", "enhanced", "ratio"]);
        for Timing { label, vanilla, enhanced, digits } in self.timings() {
            let ratio =
                if vanilla > 0.0 { format!("{:.2}", enhanced / vanilla) } else { "-".into() };
            let [vanilla, enhanced] = [vanilla, enhanced].map(|value| format!("{value:.digits$}"));
            table.row([label.to_owned(), vanilla, enhanced, ratio]);
        }
        let m = &self.difference.metrics;
        table.row([
            "mean luminance".to_owned(),
            format!("{:.5}", m.mean_luminance_b),
            format!("{:.5}", m.mean_luminance_a),
            format!("{:.4}", m.luminance_ratio),
        ]);
        for (name, value) in [
            ("mean_abs", m.mean_abs),
            ("flip_mean", m.flip_mean),
            ("changed_fraction", m.changed_fraction),
        ] {
            table.row([name.to_owned(), String::new(), String::new(), format!("{value:.4}")]);
        }
        table
    }

    fn report(&self) -> Result<String> {
        let Options { width, height, samples, bounces, seed, .. } = self.options;
        let kinds = if self.kinds.is_empty() { "nothing".into() } else { self.kinds.join(", ") };
        report::page(&Report {
            scene: self.scene,
            settings: &format!(
                "camera {}, {width} \u{d7} {height} pixels, {samples} samples, {bounces} bounces, \
                 seed {seed}; enhanced: {kinds}",
                self.camera
            ),
            vanilla: &self.pictures[0],
            enhanced: &self.pictures[1],
            difference: &self.difference,
            timings: &self.timings(),
        })
    }
}
