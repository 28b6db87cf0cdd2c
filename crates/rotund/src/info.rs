//! `info <scene>`: the content of a scene and its cost in memory.
//!
//! Loads the scene, reads its files once more for comparison, and builds the trees. The comparison
//! comes second, when the files are in the cache of the system, so that the ratio does not profit
//! from a cold disk.

use crate::memory as room;
use crate::scene_source::{LoadArgs, load_silently};
use anyhow::{Context, Result};
use rotund_geometry::{Aabb, glam::Vec3};
use rotund_report::console::{Table, say};
use rotund_scene::{ElementKind, Loaded, Material, Scene, Shape, Trees};
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::Read as _;
use std::path::PathBuf;
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  rotund info shapes4
  rotund info path/to/scene.json
  rotund info cloud.ply --radius 0.01";

/// Options of `info`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The name of a built-in scene, or the path of a JSON, PLY, OBJ, SWC, TCK, TRK, XYZ,
    /// TXT, CSV, PTS or ASC file.
    scene: OsString,
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
        "{name}: {} cameras, {} environments, {} textures,\n{} materials, {} shapes, {} instances",
        scene.cameras.len(),
        scene.environments.len(),
        scene.textures.len(),
        scene.materials.len(),
        scene.shapes.len(),
        scene.instances.len()
    ))?;
    say(format!("\n{}", costs(&loaded, load_seconds, peak)?))?;
    say(format!("\n{}", cameras(scene)))?;
    say(format!("\n{}", materials(scene)))?;
    if let Some(table) = textures(scene) {
        say(format!("\n{table}"))?;
    }
    room::check_scene(scene)?;
    let start = Instant::now();
    let trees = Trees::build(scene)?;
    let build_seconds = start.elapsed().as_secs_f64();
    say(format!("\n{}", shapes(scene, &trees)))?;
    say(format!("\n{}", bounds(scene)))?;
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

/// Returns time and memory of loading, beside those of reading the files alone.
fn costs(loaded: &Loaded, load_seconds: f64, peak: Option<u64>) -> Result<Table> {
    let shapes: usize = loaded.scene.shapes.iter().map(Shape::bytes).sum();
    let mut costs = Table::new(&["", "seconds", "MB"]);
    let megabytes = |bytes: u64| format!("{:.2}", bytes as f64 / 1e6);
    if !loaded.files.is_empty() {
        let [(piece_seconds, size), (whole_seconds, _)] =
            [read_in_pieces(&loaded.files)?, read_whole(&loaded.files)?];
        let files = match loaded.files.len() {
            1 => "1 file read".to_owned(),
            count => format!("{count} files read"),
        };
        let seconds = |seconds: f64| format!("{seconds:.3}");
        costs.row([format!("{files}, piece by piece"), seconds(piece_seconds), String::new()]);
        costs.row([format!("{files} into memory"), seconds(whole_seconds), megabytes(size)]);
    }
    let peak = peak.map_or("unknown".to_owned(), megabytes);
    let load_seconds = format!("{load_seconds:.3}");
    costs.row(["scene loaded, with peak memory".to_owned(), load_seconds, peak]);
    costs.row(["shapes after loading".to_owned(), String::new(), megabytes(shapes as u64)]);
    Ok(costs)
}

/// Reads files through one small buffer; returns seconds and bytes.
fn read_in_pieces(files: &[PathBuf]) -> Result<(f64, u64)> {
    let start = Instant::now();
    let mut size = 0_u64;
    let mut buffer = vec![0; 1 << 20];
    for path in files {
        let mut file =
            File::open(path).with_context(|| format!("cannot read {}", path.display()))?;
        loop {
            match file.read(&mut buffer)? {
                0 => break,
                count => size += count as u64,
            }
        }
    }
    Ok((start.elapsed().as_secs_f64(), size))
}

/// Reads files each into new memory, which takes longer than the copy: a loader that keeps the data
/// pays for it too. Returns seconds and bytes.
fn read_whole(files: &[PathBuf]) -> Result<(f64, u64)> {
    let start = Instant::now();
    let mut size = 0;
    for path in files {
        let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        size += bytes.len() as u64;
    }
    Ok((start.elapsed().as_secs_f64(), size))
}

/// Returns bytes of memory of this process by a line of `/proc/self/status`; `None` where there is
/// none.
fn memory(line: &str) -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let kilobytes = status.lines().find_map(|text| text.strip_prefix(line))?;
    Some(1024 * kilobytes.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?)
}

fn cameras(scene: &Scene) -> Table {
    let mut table = Table::new(&["camera", "kind", "width / height", "aperture"]);
    for camera in &scene.cameras {
        let kind = if camera.orthographic { "orthographic" } else { "perspective" };
        let [aspect, aperture] = [camera.aspect, camera.aperture].map(|value| number(value, 4));
        table.row([camera.name.clone(), kind.to_owned(), aspect, aperture]);
    }
    table
}

fn materials(scene: &Scene) -> Table {
    let mut table = Table::new(&["material", "kind", "color", "emission", "roughness", "opacity"]);
    for material in &scene.materials {
        table.row([
            material.name.clone(),
            format!("{:?}", material.kind).to_lowercase(),
            numbers(material.color, 3),
            numbers(material.emission, 3),
            number(material.roughness, 3),
            number(material.opacity, 3),
        ]);
    }
    table
}

/// Returns the materials that have textures, or `None` if there are none.
fn textures(scene: &Scene) -> Option<Table> {
    let mut table = Table::new(&["material", "textures"]);
    let mut any = false;
    for material in &scene.materials {
        let names = textures_of(material);
        if !names.is_empty() {
            table.row([material.name.clone(), names]);
            any = true;
        }
    }
    any.then_some(table)
}

fn textures_of(material: &Material) -> String {
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
        "shape", "kind", "method", "elements", "vertices", "placed", "B each", "of tree",
    ]);
    let mut placed = vec![0_usize; scene.shapes.len()];
    scene.instances.iter().for_each(|instance| placed[instance.shape as usize] += 1);
    for ((shape, tree), placed) in scene.shapes.iter().zip(trees.statistics()).zip(placed) {
        let each =
            |bytes: usize| format!("{:.1}", bytes as f64 / shape.elements.count().max(1) as f64);
        table.row([
            shape.name.clone(),
            kind(shape).to_owned(),
            method(shape).to_owned(),
            shape.elements.count().to_string(),
            shape.positions.len().to_string(),
            placed.to_string(),
            each(shape.bytes()),
            each(tree.bytes),
        ]);
    }
    table
}

/// Returns the bounds of the vertices of each shape, before it is placed.
fn bounds(scene: &Scene) -> Table {
    let mut table = Table::new(&["shape", "from x y z", "to x y z"]);
    for shape in &scene.shapes {
        let bounds = Aabb::from_points(shape.positions.iter().copied());
        table.row([shape.name.clone(), numbers(bounds.min, 4), numbers(bounds.max, 4)]);
    }
    table
}

/// Writes a number with so many significant digits, 3 or 4. It takes at most `digits + 3`
/// characters, and one more for a minus.
fn number(value: f32, digits: i32) -> String {
    let size = value.abs();
    if size == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    if !(1e-2..1e5).contains(&size) {
        let decimals = (digits - 3).max(0) as usize;
        return format!("{value:.decimals$e}");
    }
    let decimals = (digits - 1 - size.log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

fn numbers(vector: Vec3, digits: i32) -> String {
    vector.to_array().map(|value| number(value, digits)).join(" ")
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
    match shape.elements.kind() {
        ElementKind::Triangles => "",
        _ => shape.method.name(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rotund_scene::{Camera, Elements, Instance, MaterialKind};

    #[test]
    fn numbers_are_short_and_have_their_digits() {
        let table = [
            (0.0, "0", "0"),
            (1.0, "1", "1"),
            (-0.25, "-0.25", "-0.25"),
            (0.123_456, "0.123", "0.1235"),
            (0.012_341, "0.0123", "0.01234"),
            (0.001_234, "1e-3", "1.2e-3"),
            (-99_999.4, "-99999", "-99999"),
            (1234.56, "1235", "1235"),
            (100.0, "100", "100"),
            (2e6, "2e6", "2.0e6"),
            (-1.6e-19, "-2e-19", "-1.6e-19"),
            (f32::NAN, "NaN", "NaN"),
            (f32::NEG_INFINITY, "-inf", "-inf"),
        ];
        for (value, three, four) in table {
            assert_eq!(number(value, 3), three);
            assert_eq!(number(value, 4), four);
            assert!(three.len() <= 7 && four.len() <= 8, "{three} {four}");
        }
    }

    #[test]
    fn every_table_fits_in_80_columns() {
        let long = "a-very-long-name-of-something-in-a-scene-".repeat(3);
        let wide = Vec3::splat(-0.012_341);
        let camera = Camera { name: long.clone(), ..Camera::default() };
        let material = Material {
            name: long.clone(),
            kind: MaterialKind::Transparent,
            color: -wide,
            emission: -wide,
            color_tex: Some(0),
            emission_tex: Some(0),
            roughness_tex: Some(0),
            scattering_tex: Some(0),
            normal_tex: Some(0),
            ..Material::default()
        };
        let shape = Shape {
            name: long,
            elements: Elements::Points(100_000),
            positions: vec![wide; 100_000],
            radii: vec![1.0; 100_000],
            ..Shape::default()
        };
        let instance = Instance::default();
        let scene = Scene {
            cameras: vec![camera],
            materials: vec![material],
            shapes: vec![shape],
            instances: vec![instance; 1000],
            ..Scene::default()
        };
        let loaded = Loaded { scene, ..Loaded::default() };
        let scene = &loaded.scene;
        // Trees are built of valid scenes only, and the textures of this material do not exist.
        let valid = Scene { materials: vec![Material::default()], ..scene.clone() };
        let trees = Trees::build(&valid).expect("a valid scene");
        let tables = [
            costs(&loaded, 12_345.678, Some(123_456_789_012)).expect("no file to read"),
            cameras(scene),
            materials(scene),
            textures(scene).expect("there are textures"),
            shapes(scene, &trees),
            bounds(scene),
        ];
        for table in tables {
            for line in table.to_string().lines() {
                assert!(line.chars().count() <= 80, "{line}");
            }
        }
    }
}
