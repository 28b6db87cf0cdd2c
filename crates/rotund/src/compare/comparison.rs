//! One scene by both methods.

use crate::exit::Cancelled;
use crate::kinds::{Kind, enhance};
use crate::output::write_text;
use crate::scene_source::NamedScene;
use crate::shot::{Shot, take, take_more};
use anyhow::Result;
use rotund_image::{Difference, Image};
use rotund_report::compare::index::Entry;
use rotund_report::compare::{EqualTime, Report, Timing};
use rotund_report::console::Table;
use rotund_scene::Scene;
use rotund_trace::Options;
use serde_json::{Value, json};
use std::path::Path;

/// Both renders and their difference. In each pair vanilla is first.
#[derive(Debug)]
pub(super) struct Comparison {
    scene: String,
    camera: String,
    options: Options,
    kinds: Vec<&'static str>,
    shots: [Shot; 2],
    pictures: [Image; 2],
    difference: Difference,
    longer: Option<Longer>,
}

/// The picture of the faster method after the time that the slower one takes.
#[derive(Debug)]
struct Longer {
    /// Index into [`NAMES`].
    faster: usize,
    shot: Shot,
    picture: Image,
    difference: Difference,
}

const NAMES: [&str; 2] = ["vanilla", "enhanced"];

fn write_picture(folder: &Path, name: &str, shot: &Shot) -> Result<()> {
    for extension in ["png", "exr"] {
        rotund_trace::output::write(folder.join(format!("{name}.{extension}")), &shot.film)?;
    }
    Ok(())
}

fn interrupted(folder: &Path, what: &str, options: &Options) -> anyhow::Error {
    let text = format!("{} holds {what} of {} samples", folder.display(), options.samples);
    Cancelled(text).into()
}

impl Comparison {
    /// Renders both pictures, and continues the faster one if `equal_time`.
    ///
    /// # Errors
    ///
    /// If the scene cannot be rendered, or Ctrl-C is pressed; then the pictures so far are written
    /// into `folder`.
    pub(super) fn render(
        source: &mut NamedScene,
        camera: usize,
        options: &Options,
        kinds: &[Kind],
        equal_time: bool,
        folder: &Path,
    ) -> Result<Self> {
        let scene = &mut source.scene;
        enhance(scene, &[]);
        let vanilla = take(scene, camera, options, NAMES[0])?;
        if vanilla.interrupted {
            write_picture(folder, NAMES[0], &vanilla)?;
            let what = format!("vanilla with {}", vanilla.film.samples());
            return Err(interrupted(folder, &what, options));
        }
        enhance(scene, kinds);
        let enhanced = take(scene, camera, options, NAMES[1])?;
        let was_interrupted = enhanced.interrupted;
        let done = enhanced.film.samples();
        let shots = [vanilla, enhanced];
        let pictures = shots.each_ref().map(|shot| shot.film.image());
        let difference = Difference::between(&pictures[1], &pictures[0])?;
        let mut comparison = Self {
            scene: source.name.clone(),
            camera: source.scene.cameras[camera].name.clone(),
            options: options.clone(),
            kinds: kinds.iter().map(|kind| kind.name()).collect(),
            shots,
            pictures,
            difference,
            longer: None,
        };
        if was_interrupted {
            comparison.write(folder)?;
            let what = format!("vanilla with all and enhanced with {done}");
            return Err(interrupted(folder, &what, options));
        }
        if equal_time {
            comparison.longer = comparison.render_longer(&mut source.scene, camera, kinds)?;
        }
        Ok(comparison)
    }

    /// Returns `None` if both methods take about as long, or if Ctrl-C is pressed: both pictures
    /// are complete by then.
    fn render_longer(
        &self,
        scene: &mut Scene,
        camera: usize,
        kinds: &[Kind],
    ) -> Result<Option<Longer>> {
        let [v, e] = self.shots.each_ref().map(|shot| shot.render_seconds);
        let faster = usize::from(e < v);
        let samples = (f64::from(self.options.samples) * v.max(e) / v.min(e).max(1e-9)) as u32;
        if samples <= self.options.samples {
            return Ok(None);
        }
        enhance(scene, [&[], kinds][faster]);
        let begun = &self.shots[faster];
        let shot = take_more(scene, camera, &self.options, begun, samples, NAMES[faster])?;
        if shot.interrupted {
            return Ok(None);
        }
        let picture = shot.film.image();
        let other = &self.pictures[1 - faster];
        let difference = match faster {
            0 => Difference::between(other, &picture)?,
            _ => Difference::between(&picture, other)?,
        };
        Ok(Some(Longer { faster, shot, picture, difference }))
    }

    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        for (name, shot) in NAMES.iter().zip(&self.shots) {
            write_picture(folder, name, shot)?;
        }
        let title = "luminance of enhanced - vanilla";
        self.difference.signed_map(title).write(folder.join("difference.png"))?;
        self.difference.flip_map().write(folder.join("flip.png"))?;
        let metrics = serde_json::to_string_pretty(&self.metrics())? + "\n";
        write_text(&folder.join("metrics.json"), &metrics)?;
        write_text(&folder.join("report.html"), &self.report()?)
    }

    /// Returns the content of `metrics.json`. In `difference`, `a` is enhanced and `b` is vanilla.
    pub(super) fn metrics(&self) -> Value {
        let [vanilla, enhanced] = self.shots.each_ref().map(|shot| {
            json!({
                "build_seconds": shot.build_seconds,
                "render_seconds": shot.render_seconds,
                "rays": shot.rays,
                "rays_per_second": shot.rays_per_second(),
                "samples": shot.film.samples(),
                "samples_per_second": shot.samples_per_second(),
                "rejected_samples": shot.film.rejected(),
                "fireflies": shot.film.fireflies(),
                "clamped_samples": shot.film.clamped(),
            })
        });
        let mut metrics = json!({
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
        });
        if let Some(longer) = &self.longer {
            let side = |index: usize| {
                let shot = if index == longer.faster { &longer.shot } else { &self.shots[index] };
                json!({ "samples": shot.film.samples(), "render_seconds": shot.render_seconds })
            };
            metrics["equal_time"] = json!({
                "vanilla": side(0),
                "enhanced": side(1),
                "difference": longer.difference.metrics,
            });
        }
        metrics
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
            row("rejected samples", 0, |shot| shot.film.rejected() as f64),
            row("fireflies", 0, |shot| shot.film.fireflies() as f64),
        ]
    }

    pub(super) fn table(&self) -> Table {
        let mut table = Table::new(&[self.scene.as_str(), "vanilla", "enhanced", "ratio"]);
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

    /// Returns the card of the scene on the page about several scenes.
    pub(super) fn entry(&self) -> Result<Entry> {
        let (pictures, timings) = (&self.pictures, self.timings());
        Ok(Entry::new(&self.scene, &self.settings(), pictures, &self.difference, &timings)?)
    }

    fn settings(&self) -> String {
        let Options { width, height, samples, bounces, seed, .. } = self.options;
        let kinds = if self.kinds.is_empty() { "nothing".into() } else { self.kinds.join(", ") };
        format!(
            "camera {}, {width} \u{d7} {height} pixels, {samples} samples, {bounces} bounces, \
             seed {seed}; enhanced: {kinds}",
            self.camera
        )
    }

    fn report(&self) -> Result<String> {
        let page = rotund_report::compare::page(&Report {
            scene: &self.scene,
            settings: &self.settings(),
            vanilla: &self.pictures[0],
            enhanced: &self.pictures[1],
            difference: &self.difference,
            timings: &self.timings(),
            equal_time: self.longer.as_ref().map(|longer| EqualTime {
                faster: NAMES[longer.faster],
                picture: &longer.picture,
                samples: [self.options.samples, longer.shot.film.samples()],
                seconds: [self.shots[1 - longer.faster].render_seconds, longer.shot.render_seconds],
                metrics: longer.difference.metrics,
            }),
        })?;
        Ok(page)
    }
}
