//! `rays`: how fast trees are built and walked, on scenes that anyone can rebuild bit for bit.
//!
//! Prints a table, and writes on request JSON rows and a page with bars and a picture of how many nodes
//! and primitives each pixel looks at. With a peer (a program around another ray tracer) both run in
//! turn on the same machine, so that each ratio is paired; medians are shown.

mod page;
mod peer;
mod recipe;
mod shoot;

use crate::console::{Table, say};
use anyhow::{Result, ensure};
use peer::Peer;
use recipe::Target;
use rotund_bvh::{Form, Isa, Statistics};
use rotund_geometry::{BilinearPatch, RoundedCone, Sphere, Triangle};
use rotund_scene::{Elements, LoadOptions, Shape};
use serde::Serialize;
use shoot::{Primitive, Traced, Volley};
use std::path::{Path, PathBuf};
use std::time::Instant;

const EXAMPLES: &str = "\
Scenes: spheres-1M, spheres-10M, cones-1M, patches-1M, spheres-N for N million spheres, or a scene file
in JSON, each shape of which is measured by itself.

Examples:
  cargo xtask rays
  cargo xtask rays spheres-1M cones-1M --isa avx2 --page rays.html
  cargo xtask rays patches-1M --vanilla --peer ./embree_bench --repeat 5 --json rays.json
  cargo xtask rays patches-1M --verify 1000";

/// Options of `rays`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// What to build trees over.
    #[arg(default_values = ["spheres-1M", "cones-1M", "patches-1M"])]
    scenes: Vec<String>,
    /// Passes, of which the median counts, after one that does not.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..))]
    repeat: u16,
    /// Shoot at the vanilla forms: points, lines, two triangles.
    #[arg(long)]
    vanilla: bool,
    /// Instruction set: portable, avx2 or avx512. [default: the fastest]
    #[arg(long)]
    isa: Option<Isa>,
    /// Also shoot on all threads.
    #[arg(long)]
    all_threads: bool,
    /// Compare this many rays of each kind with a loop over all primitives, instead of measuring.
    #[arg(long, value_name = "RAYS")]
    verify: Option<usize>,
    /// A program that measures another ray tracer, run in turn with ours.
    #[arg(long, value_name = "PROGRAM")]
    peer: Option<PathBuf>,
    /// Write the rows as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a page with bars and a picture of the traversal cost.
    #[arg(long, value_name = "FILE.html")]
    page: Option<PathBuf>,
}

/// One figure and what belongs to it.
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
    sah: f64,
}

/// What a scene adds to the page.
struct Sheet {
    scene: String,
    rows: Vec<Row>,
    /// Nodes and primitives that each primary ray visits.
    visits: Vec<u32>,
}

pub(crate) fn run(args: Args) -> Result<()> {
    let mut sheets = Vec::new();
    for scene in &args.scenes {
        each_kind(scene, &args, &mut sheets)?;
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
    rotund_trace::output::write_with(path, |file| std::io::Write::write_all(file, bytes))?;
    Ok(())
}

/// Makes the scene and measures it, whatever it consists of.
fn each_kind(scene: &str, args: &Args, sheets: &mut Vec<Sheet>) -> Result<()> {
    let million = 1_000_000;
    let check = |hash: u64, expected: u64| {
        let ok = hash == expected;
        ensure!(ok, "{scene} has the hash {hash:016x} and not {expected:016x}");
        Ok(())
    };
    match scene {
        "spheres-1M" => {
            let (spheres, hash) = recipe::spheres(million, 1, 0.002);
            check(hash, 0x0915_ef57_9e5f_da21)?;
            sheets.extend(measure(scene, &spheres, &Target::UNIT, args)?);
        }
        "spheres-10M" => {
            let (spheres, hash) = recipe::spheres(10 * million, 11, 0.000_928_317_8);
            check(hash, 0x7d1d_4cee_a667_c619)?;
            sheets.extend(measure(scene, &spheres, &Target::UNIT, args)?);
        }
        "cones-1M" => {
            let (cones, hash) = recipe::cones(50_000);
            check(hash, 0x8990_b660_83f1_cf0c)?;
            sheets.extend(measure(scene, &cones, &Target::UNIT, args)?);
        }
        "patches-1M" => {
            let (patches, hash) = recipe::patches(1000);
            check(hash, 0x1613_fb93_455e_a7e8)?;
            let corners = patches.iter().flat_map(|p| [p.p00, p.p10, p.p11, p.p01]);
            sheets.extend(measure(scene, &patches, &Target::around(corners), args)?);
        }
        _ => {
            if let Some(millions) = scene.strip_prefix("spheres-").and_then(|n| n.parse().ok()) {
                let millions: u16 = millions;
                ensure!(millions > 0, "spheres-{millions} is empty");
                let count = usize::from(millions) * million;
                let base = 0.002 / f32::from(millions).cbrt();
                let (spheres, _) = recipe::spheres(count, 1, base);
                sheets.extend(measure(scene, &spheres, &Target::UNIT, args)?);
                return Ok(());
            }
            ensure!(
                Path::new(scene).extension().is_some_and(|extension| extension == "json"),
                "no scene {scene:?}: there are spheres-1M, spheres-10M, cones-1M, patches-1M, \
                 spheres-N for N million, and scene files in JSON"
            );
            let loaded = rotund_scene::load(scene, &LoadOptions::default())?;
            for shape in &loaded.scene.shapes {
                sheets.extend(shape_sheet(shape, args)?);
            }
        }
    }
    Ok(())
}

/// Measures a shape of a scene file, in its own space.
fn shape_sheet(shape: &Shape, args: &Args) -> Result<Option<Sheet>> {
    let at = |vertex: u32| shape.positions[vertex as usize];
    let radius = |vertex: u32| shape.radii.get(vertex as usize).copied().unwrap_or(0.001);
    let target = Target::around(shape.positions.iter().copied());
    let name = &shape.name;
    match &shape.elements {
        Elements::Points(count) => {
            let sphere = |v| Sphere { center: at(v), radius: radius(v) };
            let spheres: Vec<Sphere> = (0..*count).map(sphere).collect();
            measure(name, &spheres, &target, args)
        }
        Elements::Lines(lines) => {
            let cone = |&[a, b]: &[u32; 2]| RoundedCone {
                p0: at(a),
                r0: radius(a),
                p1: at(b),
                r1: radius(b),
            };
            let cones: Vec<RoundedCone> = lines.iter().map(cone).collect();
            measure(name, &cones, &target, args)
        }
        Elements::Triangles(triangles) => {
            let triangle = |t: &[u32; 3]| Triangle { p0: at(t[0]), p1: at(t[1]), p2: at(t[2]) };
            let triangles: Vec<Triangle> = triangles.iter().map(triangle).collect();
            measure(name, &triangles, &target, args)
        }
        Elements::Quads(quads) => {
            let patch = |q: &[u32; 4]| {
                let [p00, p10, p11, p01] = q.map(at);
                BilinearPatch { p00, p10, p01, p11 }
            };
            let patches: Vec<BilinearPatch> = quads.iter().map(patch).collect();
            measure(name, &patches, &target, args)
        }
    }
}

/// Builds a tree, shoots at it, and prints the table. Nothing to show if there is no primitive.
fn measure<P: Primitive>(
    scene: &str,
    primitives: &[P],
    target: &Target,
    args: &Args,
) -> Result<Option<Sheet>> {
    if primitives.is_empty() {
        say(format!("{scene}: empty"))?;
        return Ok(None);
    }
    let form = if args.vanilla { Form::Vanilla } else { Form::Enhanced };
    let isa = args.isa.unwrap_or_else(Isa::default_set);
    let build = || -> Result<_> {
        // In a thread of its own: CPU seconds are then what a build costs, not what it took.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        Ok(pool.install(|| {
            let (start, before) = (Instant::now(), shoot::cpu_seconds());
            let tree = P::build(primitives, isa);
            let cpu = shoot::cpu_seconds().zip(before).map(|(after, before)| after - before);
            (tree, cpu.unwrap_or_else(|| start.elapsed().as_secs_f64()))
        }))
    };
    let (tree, build_seconds) = build()?;
    let start = Instant::now();
    drop(P::build(primitives, isa));
    let parallel_build = start.elapsed().as_secs_f64();
    let volleys = shoot::volleys(&tree, target, form);
    if let Some(count) = args.verify {
        verify(scene, &tree, primitives, &volleys, count, form)?;
        return Ok(None);
    }
    let statistics = tree.statistics();
    let rounds = rounds(scene, &tree, &volleys, form, args)?;
    let mut rows = Vec::new();
    for (index, volley) in volleys.iter().enumerate() {
        rows.extend(volley_rows(&tree, volley, index, &rounds, form, isa, args));
    }
    let peer_build = rounds.iter().filter_map(|round| round.peer.as_ref()).map(|p| p.build_seconds);
    let peer_build_seconds = median(peer_build.collect());
    for row in &mut rows {
        scene.clone_into(&mut row.scene);
        row.build_seconds = build_seconds;
        row.peer_build_seconds = peer_build_seconds;
        row.bytes_per_primitive = statistics.bytes as f64 / statistics.primitives.max(1) as f64;
        row.sah = statistics.sah;
    }
    print(scene, &rows, &statistics, parallel_build)?;
    let seen = |ray| {
        let visits = tree.visits(ray, form);
        visits.nodes + visits.primitives
    };
    let visits = volleys[0].rays.iter().map(seen).collect();
    Ok(Some(Sheet { scene: scene.to_owned(), rows, visits }))
}

fn verify<P: Primitive>(
    scene: &str,
    tree: &P::Tree,
    primitives: &[P],
    volleys: &[Volley],
    count: usize,
    form: Form,
) -> Result<()> {
    for Volley { name, rays, .. } in volleys {
        // Spread over all of them.
        let step = (rays.len() / count.max(1)).max(1);
        let rays: Vec<_> = rays.iter().step_by(step).take(count).copied().collect();
        if let Some(difference) = shoot::first_difference(tree, primitives, &rays, form) {
            anyhow::bail!("{scene}, {name}: {difference}");
        }
        say(format!("{scene}, {name}: {} rays, all bits as in a loop", rays.len()))?;
    }
    Ok(())
}

/// Our passes over the kinds of rays, and the peer's turn after them.
struct Round {
    ours: Vec<shoot::Pass>,
    peer: Option<Peer>,
}

fn rounds(
    scene: &str,
    tree: &impl Traced,
    volleys: &[Volley],
    form: Form,
    args: &Args,
) -> Result<Vec<Round>> {
    (0..args.repeat)
        .map(|_| {
            let ours = volleys
                .iter()
                .map(|volley| {
                    // One pass to warm up, as the peer has.
                    shoot::on_one_thread(tree, volley, form);
                    shoot::on_one_thread(tree, volley, form)
                })
                .collect();
            let peer = args.peer.as_deref().map(|program| peer::run(program, scene)).transpose()?;
            Ok(Round { ours, peer })
        })
        .collect()
}

/// The rows of one kind of rays: on one thread, and on all if asked for.
fn volley_rows(
    tree: &impl Traced,
    volley: &Volley,
    index: usize,
    rounds: &[Round],
    form: Form,
    isa: Isa,
    args: &Args,
) -> Vec<Row> {
    let theirs = |round: &Round| Some(*round.peer.as_ref()?.mrays_per_second.get(volley.name)?);
    let step = (volley.rays.len() / 100_000).max(1);
    let sample: Vec<_> =
        volley.rays.iter().step_by(step).map(|ray| tree.visits(ray, form)).collect();
    let mean = |f: fn(&rotund_bvh::Visits) -> u32| {
        sample.iter().map(|v| f64::from(f(v))).sum::<f64>() / sample.len().max(1) as f64
    };
    let one = Row {
        scene: String::new(),
        form: if form == Form::Vanilla { "vanilla" } else { "enhanced" },
        rays: volley.name,
        threads: 1,
        isa: isa.name(),
        mrays_per_second: median(rounds.iter().map(|r| r.ours[index].mrays_per_second).collect())
            .unwrap_or(f64::NAN),
        peer_mrays_per_second: median(rounds.iter().filter_map(theirs).collect()),
        ratio: median(
            rounds
                .iter()
                .filter_map(|round| Some(round.ours[index].mrays_per_second / theirs(round)?))
                .collect(),
        ),
        hit_share: rounds.first().map_or(0.0, |round| round.ours[index].hit_share),
        nodes_per_ray: mean(|v| v.nodes),
        primitives_per_ray: mean(|v| v.primitives),
        build_seconds: 0.0,
        peer_build_seconds: None,
        bytes_per_primitive: 0.0,
        sah: 0.0,
    };
    let mut rows = vec![one.clone()];
    if args.all_threads {
        let passes = (0..args.repeat).map(|_| shoot::on_all_threads(tree, volley, form));
        let mrays = median(passes.map(|pass| pass.mrays_per_second).collect());
        rows.push(Row {
            threads: rayon::current_num_threads(),
            mrays_per_second: mrays.unwrap_or(f64::NAN),
            peer_mrays_per_second: None,
            ratio: None,
            ..one
        });
    }
    rows
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

fn print(scene: &str, rows: &[Row], tree: &Statistics, parallel_build: f64) -> Result<()> {
    let Some(first) = rows.first() else { return Ok(()) };
    let peer = first.peer_build_seconds.map(|s| format!(" (peer {s:.3} s)")).unwrap_or_default();
    say(format!(
        "{scene}, {}, {}: {} primitives, built in {:.3} CPU s{peer}, {parallel_build:.3} s on {} threads, \
         {:.1} bytes each; {} nodes {:.0} % full, {} leaves of {:.1}, depth {}, SAH {:.1}{}",
        first.form,
        first.isa,
        tree.primitives,
        first.build_seconds,
        rayon::current_num_threads(),
        first.bytes_per_primitive,
        tree.nodes,
        100.0 * tree.children as f64 / (8 * tree.nodes.max(1)) as f64,
        tree.leaves,
        tree.primitives as f64 / tree.leaves.max(1) as f64,
        tree.depth,
        tree.sah,
        peak_memory().map(|gib| format!("; the process held {gib:.2} GiB")).unwrap_or_default(),
    ))?;
    let mut table =
        Table::new(&["rays", "threads", "Mrays/s", "peer", "ratio", "hit", "nodes", "primitives"]);
    for row in rows {
        let or_dash = |value: Option<f64>| {
            value.map_or_else(|| "-".to_owned(), |value| format!("{value:.2}"))
        };
        table.row([
            row.rays.to_owned(),
            row.threads.to_string(),
            format!("{:.2}", row.mrays_per_second),
            or_dash(row.peer_mrays_per_second),
            or_dash(row.ratio),
            format!("{:.3}", row.hit_share),
            format!("{:.1}", row.nodes_per_ray),
            format!("{:.1}", row.primitives_per_ray),
        ]);
    }
    say(table.to_string())
}

/// The most memory the process has held so far, in GiB.
fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: f64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(kib / (1024.0 * 1024.0))
}
