//! Two pictures of one scene that differ in one thing.

use super::subject::Subject;
use crate::exit::Cancelled;
use crate::output::write_text;
use crate::scene_source::NamedScene;
use crate::shot::{Shot, take, take_more};
use anyhow::Result;
use rotund_image::{Difference, Image};
use rotund_report::compare::index::Entry;
use rotund_report::compare::{EqualTime, Pair, Report, Timing};
use rotund_report::console::Table;
use rotund_scene::Scene;
use rotund_trace::Options;
use serde_json::{Value, json};
use std::path::Path;

/// Both renders and their difference.
#[derive(Debug)]
pub(super) struct Comparison {
    scene: String,
    camera: String,
    options: Options,
    subject: Subject,
    shots: [Shot; 2],
    pictures: [Image; 2],
    difference: Difference,
    longer: Option<Longer>,
}

/// The picture of the faster render after the time that the slower one takes.
#[derive(Debug)]
struct Longer {
    /// Index into the names of the pair.
    faster: usize,
    shot: Shot,
    picture: Image,
    difference: Difference,
}

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
    /// Compares two renders that are there.
    ///
    /// # Errors
    ///
    /// If they are not of one size.
    pub(super) fn new(
        scene: &str,
        camera: &str,
        options: &Options,
        subject: Subject,
        shots: [Shot; 2],
    ) -> Result<Self> {
        let pictures = shots.each_ref().map(|shot| shot.film.image());
        let difference = Difference::between(&pictures[1], &pictures[0])?;
        Ok(Self {
            scene: scene.to_owned(),
            camera: camera.to_owned(),
            options: options.clone(),
            subject,
            shots,
            pictures,
            difference,
            longer: None,
        })
    }

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
        subject: Subject,
        equal_time: bool,
        folder: &Path,
    ) -> Result<Self> {
        let scene = &mut source.scene;
        let names = subject.pair().names;
        subject.prepare(scene, 0);
        let first = take(scene, camera, options, names[0])?;
        if first.interrupted {
            write_picture(folder, names[0], &first)?;
            let what = format!("{} with {}", names[0], first.film.samples());
            return Err(interrupted(folder, &what, options));
        }
        subject.prepare(scene, 1);
        let second = take(scene, camera, options, names[1])?;
        let was_interrupted = second.interrupted;
        let done = second.film.samples();
        let camera_name = &source.scene.cameras[camera].name;
        let mut comparison =
            Self::new(&source.name, camera_name, options, subject, [first, second])?;
        if was_interrupted {
            comparison.write(folder)?;
            let what = format!("{} with all and {} with {done}", names[0], names[1]);
            return Err(interrupted(folder, &what, options));
        }
        if equal_time {
            comparison.longer = comparison.render_longer(&mut source.scene, camera)?;
        }
        Ok(comparison)
    }

    /// Returns `None` if both take about as long, or if Ctrl-C is pressed: both pictures
    /// are complete by then.
    fn render_longer(&self, scene: &mut Scene, camera: usize) -> Result<Option<Longer>> {
        let [v, e] = self.shots.each_ref().map(|shot| shot.render_seconds);
        let faster = usize::from(e < v);
        let samples = (f64::from(self.options.samples) * v.max(e) / v.min(e).max(1e-9)) as u32;
        if samples <= self.options.samples {
            return Ok(None);
        }
        self.subject.prepare(scene, faster);
        let begun = &self.shots[faster];
        let shot = take_more(scene, camera, &self.options, begun, samples, self.names()[faster])?;
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

    fn pair(&self) -> &'static Pair {
        self.subject.pair()
    }

    fn names(&self) -> [&'static str; 2] {
        self.pair().names
    }

    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        for (name, shot) in self.names().iter().zip(&self.shots) {
            write_picture(folder, name, shot)?;
        }
        let [first, second] = self.names();
        let title = format!("luminance of {second} - {first}");
        self.difference.signed_map(&title).write(folder.join("difference.png"))?;
        self.difference.flip_map().write(folder.join("flip.png"))?;
        let metrics = serde_json::to_string_pretty(&self.metrics())? + "\n";
        write_text(&folder.join("metrics.json"), &metrics)?;
        write_text(&folder.join("report.html"), &self.report()?)
    }

    /// Returns the content of `metrics.json`. In `difference`, `a` is the second picture and `b` is
    /// the first.
    pub(super) fn metrics(&self) -> Value {
        let names = self.names();
        let shots = self.shots.each_ref().map(|shot| {
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
            "kinds": self.subject.kind_names(),
            (names[0]): shots[0],
            (names[1]): shots[1],
            "difference": self.difference.metrics,
        });
        if let Some(longer) = &self.longer {
            let side = |index: usize| {
                let shot = if index == longer.faster { &longer.shot } else { &self.shots[index] };
                json!({ "samples": shot.film.samples(), "render_seconds": shot.render_seconds })
            };
            metrics["equal_time"] = json!({
                (names[0]): side(0),
                (names[1]): side(1),
                "difference": longer.difference.metrics,
            });
        }
        metrics
    }

    fn timings(&self) -> Vec<Timing> {
        let row = |label, digits, value: fn(&Shot) -> f64| Timing {
            label,
            values: self.shots.each_ref().map(value),
            digits,
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
        let [first, second] = self.names();
        let mut table = Table::new(&[self.scene.as_str(), first, second, "ratio"]);
        for Timing { label, values: [first, second], digits } in self.timings() {
            let ratio = if first > 0.0 { format!("{:.2}", second / first) } else { "-".into() };
            let [first, second] = [first, second].map(|value| format!("{value:.digits$}"));
            table.row([label.to_owned(), first, second, ratio]);
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
        Ok(Entry::new(
            &self.scene,
            &self.settings(),
            self.pair(),
            pictures,
            &self.difference,
            &timings,
        )?)
    }

    fn settings(&self) -> String {
        let Options { width, height, samples, bounces, seed, .. } = self.options;
        format!(
            "camera {}, {width} \u{d7} {height} pixels, {samples} samples, {bounces} bounces, \
             seed {seed}; {}",
            self.camera,
            self.subject.settings()
        )
    }

    /// Returns the page about both pictures.
    pub(super) fn report(&self) -> Result<String> {
        let page = rotund_report::compare::page(&Report {
            scene: &self.scene,
            settings: &self.settings(),
            pair: self.pair(),
            pictures: self.pictures.each_ref(),
            difference: &self.difference,
            timings: &self.timings(),
            equal_time: self.longer.as_ref().map(|longer| EqualTime {
                faster: self.names()[longer.faster],
                picture: &longer.picture,
                samples: [self.options.samples, longer.shot.film.samples()],
                seconds: [self.shots[1 - longer.faster].render_seconds, longer.shot.render_seconds],
                metrics: longer.difference.metrics,
            }),
        })?;
        Ok(page)
    }
}
