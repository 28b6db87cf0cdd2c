//! `rays`: how fast trees are built and traversed, on scenes that other programs can generate bit
//! for bit.
//!
//! The command prints a table and writes, on request, rows of JSON and a page with bars and a
//! picture of how many nodes and primitives each pixel visits. With a peer (a program around
//! another ray tracer) both run in turn on the same machine, so that each ratio is paired; medians
//! are shown.

mod bodies;
mod measure;
mod memory;
mod page;
mod peer;
mod progress;
mod recipe;
mod reference;
mod shoot;
mod subject;

use anyhow::Result;
use rotund_bvh::Isa;
use rotund_scene::Scene;
use serde::Serialize;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Scenes: spheres-1M, cones-1M, patches-1M, triangles-1M, spheres-10M or another
number of millions; tracts-218K and vessels-4K, tubes of published sizes; or the
name of a scene that is built in, or the path of a JSON, PLY, OBJ, SWC, TCK,
TRK, XYZ, TXT, CSV, PTS or ASC file, each shape of which is measured by itself.

Examples:
  cargo xtask rays
  cargo xtask rays spheres-1M cones-1M --isa avx2 --page rays.html
  cargo xtask rays patches-1M --vanilla --peer ./embree_bench --json rays.json
  cargo xtask rays shapes4 scan.ply
  cargo xtask rays patches-1M --verify 10000000
  cargo xtask rays cones-1M tracts-218K vessels-4K cell.swc --crossings";

/// Options of `rays`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The scenes to build trees over.
    #[arg(default_values = ["spheres-1M", "cones-1M", "patches-1M"])]
    scenes: Vec<String>,
    /// How many passes are timed, after one that warms up; the median is shown.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..))]
    repeat: u16,
    /// Intersect the vanilla shapes: points, lines, two triangles.
    #[arg(long)]
    vanilla: bool,
    /// Instruction set: portable (or sse2, its name on x86-64), avx2 or avx512. [default: the
    /// fastest]
    #[arg(long)]
    isa: Option<Isa>,
    /// Instead of measuring, compare the answers for this many rays, to the bit, with those of a
    /// simple tree that calls the exact test of each primitive, and some with a loop over all
    /// primitives. Without --isa, on all instruction sets.
    #[arg(long, value_name = "RAYS", value_parser = clap::value_parser!(u32).range(1..))]
    verify: Option<u32>,
    /// Instead, measure what it costs to find where rays enter and leave the union of points or
    /// lines, against closest hits of the same rays, and a picture of the union: transparent, with
    /// shadows and ambient occlusion.
    #[arg(long, conflicts_with_all = ["vanilla", "verify", "peer", "json", "page"])]
    crossings: bool,
    /// A program that measures another ray tracer, run in turn with ours on the generated scenes up
    /// to spheres-10M.
    #[arg(long, value_name = "PROGRAM")]
    peer: Option<PathBuf>,
    /// Write the rows to this JSON file.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a page with bars and a picture of the traversal cost.
    #[arg(long, value_name = "FILE.html")]
    page: Option<PathBuf>,
}

/// One measured speed, with the properties of its tree and rays.
#[derive(Clone, Debug, Serialize)]
struct Row {
    scene: String,
    form: &'static str,
    rays: &'static str,
    threads: usize,
    isa: &'static str,
    mrays_per_second: f64,
    peer_mrays_per_second: Option<f64>,
    ratio: Option<f64>,
    hit_share: f64,
    nodes_per_ray: f64,
    primitives_per_ray: f64,
    build_seconds: f64,
    peer_build_seconds: Option<f64>,
    bytes_per_primitive: f64,
    /// Peak growth of the process during the build.
    peak_bytes_per_primitive: Option<f64>,
    sah: f64,
}

/// The results of a scene, for the page.
struct Sheet {
    scene: String,
    rows: Vec<Row>,
    /// How many nodes and primitives each primary ray visits.
    visits: Vec<u32>,
}

/// A function that loads the scene of a name or a path, and returns its name too.
pub type Load<'a> = &'a dyn Fn(&str) -> Result<(String, Scene)>;

/// Runs the command.
///
/// # Errors
///
/// If a scene is unknown or cannot be loaded, or a file cannot be written.
pub fn run(args: Args, load: Load<'_>) -> Result<()> {
    let mut sheets = Vec::new();
    for scene in &args.scenes {
        subject::measure_all(scene, &args, load, &mut sheets)?;
    }
    if let Some(path) = &args.json {
        let rows: Vec<&Row> = sheets.iter().flat_map(|sheet| &sheet.rows).collect();
        write(path, serde_json::to_string_pretty(&rows)?.as_bytes())?;
    }
    if let Some(path) = &args.page {
        write(path, page::page(&sheets)?.as_bytes())?;
    }
    Ok(())
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    rotund_image::write_with(path, |file| std::io::Write::write_all(file, bytes))?;
    Ok(())
}
