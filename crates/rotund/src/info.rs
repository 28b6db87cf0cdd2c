//! `info <scene>`: what a scene holds, and what it costs to hold it.
//!
//! Loads the scene, reads its files once more for comparison, and builds the trees. Reading comes second,
//! when the system has the files at hand, so the ratio is not flattered by a cold disk.

use crate::scene_source::{LoadArgs, load_silently};
use anyhow::{Context, Result};
use rotund_geometry::{Aabb, glam::Vec3};
use rotund_report::console::{Table, say};
use rotund_scene::{ElementKind, Loaded, Material, Method, Scene, Shape, Trees};
use std::fs::{self, File};
use std::io::Read as _;
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  cargo xtask info shapes4
  cargo xtask info path/to/scene.json
  cargo xtask info cloud.ply --radius 0.01";

/// Options of `info`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The name of a scene in `scenes/`, or the path of a JSON, PLY or OBJ file.
    scene: String,
    #[command(flatten)]
    loading: LoadArgs,
}

pub(crate) fn run(args: Args) -> Result<()> {
    let before = memory("VmRSS:");
    let start = Instant::now();
    let (name, loaded) = load_silently(&args.scene, &args.loading)?;
    let load_seconds = start.elapsed().as_secs_f64();
    let peak = memory("VmHWM:").zip(before).map(|(peak, before)| peak.saturating_sub(before));
    let scene = &loaded.scene;
    say(format!(
        "{name}: {} cameras, {} environments, {} textures, {} materials, {} shapes, {} instances",
        scene.cameras.len(),
        scene.environments.len(),
        scene.textures.len(),
        scene.materials.len(),
        scene.shapes.len(),
        scene.instances.len()
    ))?;
    say_costs(&loaded, load_seconds, peak)?;
    say(format!("\n{}", cameras(scene)))?;
    say(format!("\n{}", materials(scene)))?;
    let start = Instant::now();
    let trees = Trees::build(scene)?;
    let build_seconds = start.elapsed().as_secs_f64();
    say(format!("\n{}", shapes(scene, &trees)))?;
    say(format!("\ntrees built in {build_seconds:.2} s"))?;
    for warning in &loaded.warnings {
        say(format!("warning: {warning}"))?;
    }
    say(match loaded.warnings.len() {
        0 => "no warnings".to_owned(),
        1 => "1 warning".to_owned(),
        count => format!("{count} warnings"),
    })
}

/// Time and memory of loading, beside the files themselves.
fn say_costs(loaded: &Loaded, load_seconds: f64, peak: Option<u64>) -> Result<()> {
    let start = Instant::now();
    let mut size = 0_u64;
    let mut buffer = vec![0; 1 << 20];
    for path in &loaded.files {
        let mut file =
            File::open(path).with_context(|| format!("cannot read {}", path.display()))?;
        loop {
            match file.read(&mut buffer)? {
                0 => break,
                count => size += count as u64,
            }
        }
    }
    let read_seconds = start.elapsed().as_secs_f64();
    // New memory costs more than the copy; whoever keeps what is in a file pays for it.
    let start = Instant::now();
    for path in &loaded.files {
        fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    }
    let keep_seconds = start.elapsed().as_secs_f64();
    let shapes: usize = loaded.scene.shapes.iter().map(Shape::bytes).sum();
    let mut costs = Table::new(&["", "seconds", "MB"]);
    let megabytes = |bytes: u64| format!("{:.2}", bytes as f64 / 1e6);
    let files = match loaded.files.len() {
        1 => "1 file read".to_owned(),
        count => format!("{count} files read"),
    };
    costs.row([format!("{files}, piece by piece"), format!("{read_seconds:.3}"), String::new()]);
    costs.row([format!("{files} into memory"), format!("{keep_seconds:.3}"), megabytes(size)]);
    let peak = peak.map_or("unknown".to_owned(), megabytes);
    costs.row([
        "scene loaded, with the most memory in use".to_owned(),
        format!("{load_seconds:.3}"),
        peak,
    ]);
    costs.row(["shapes, as they stay".to_owned(), String::new(), megabytes(shapes as u64)]);
    say(format!("\n{costs}"))
}

/// Bytes of memory of this process by a line of Linux's account; `None` elsewhere.
fn memory(line: &str) -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let kilobytes = status.lines().find_map(|text| text.strip_prefix(line))?;
    Some(1024 * kilobytes.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?)
}

fn cameras(scene: &Scene) -> Table {
    let mut table = Table::new(&["camera", "kind", "width / height", "aperture"]);
    for camera in &scene.cameras {
        let kind = if camera.orthographic { "orthographic" } else { "perspective" };
        let [aspect, aperture] =
            [camera.aspect, camera.aperture].map(|value| format!("{value:.3}"));
        table.row([camera.name.clone(), kind.to_owned(), aspect, aperture]);
    }
    table
}

fn materials(scene: &Scene) -> Table {
    let mut table =
        Table::new(&["material", "kind", "color", "emission", "roughness", "opacity", "textures"]);
    for material in &scene.materials {
        table.row([
            material.name.clone(),
            format!("{:?}", material.kind).to_lowercase(),
            numbers(material.color),
            numbers(material.emission),
            material.roughness.to_string(),
            material.opacity.to_string(),
            textures(material),
        ]);
    }
    table
}

fn textures(material: &Material) -> String {
    let all = [
        (material.color_tex, "color"),
        (material.emission_tex, "emission"),
        (material.roughness_tex, "roughness"),
        (material.scattering_tex, "scattering"),
        (material.normal_tex, "normal"),
    ];
    let named: Vec<_> = all.iter().filter(|(index, _)| index.is_some()).map(|(_, n)| *n).collect();
    named.join(" ")
}

fn shapes(scene: &Scene, trees: &Trees) -> Table {
    let mut table = Table::new(&[
        "shape", "kind", "method", "elements", "vertices", "placed", "B each", "of tree", "from",
        "to",
    ]);
    let mut placed = vec![0_usize; scene.shapes.len()];
    scene.instances.iter().for_each(|instance| placed[instance.shape as usize] += 1);
    for ((shape, tree), placed) in scene.shapes.iter().zip(trees.statistics()).zip(placed) {
        let each =
            |bytes: usize| format!("{:.1}", bytes as f64 / shape.elements.count().max(1) as f64);
        let bounds = Aabb::from_points(shape.positions.iter().copied());
        table.row([
            shape.name.clone(),
            kind(shape).to_owned(),
            method(shape).to_owned(),
            shape.elements.count().to_string(),
            shape.positions.len().to_string(),
            placed.to_string(),
            each(shape.bytes()),
            each(tree.bytes),
            numbers(bounds.min),
            numbers(bounds.max),
        ]);
    }
    table
}

fn numbers(vector: Vec3) -> String {
    vector.to_array().map(|number| format!("{}", (number * 1e4).round() / 1e4)).join(" ")
}

fn kind(shape: &Shape) -> &'static str {
    match shape.elements.kind() {
        ElementKind::Points => "points",
        ElementKind::Lines => "lines",
        ElementKind::Triangles => "triangles",
        ElementKind::Quads => "quads",
    }
}

fn method(shape: &Shape) -> &'static str {
    match (shape.elements.kind(), shape.method) {
        (ElementKind::Triangles, _) => "",
        (_, Method::Vanilla) => "vanilla",
        (_, Method::Enhanced) => "enhanced",
    }
}
