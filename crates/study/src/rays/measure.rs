//! Measures one tree: builds it, traces rays, and prints the results.

use super::peer::{self, Peer};
use super::progress::Progress;
use super::recipe::Target;
use super::shoot::{self, Primitive, Traced, Volley};
use super::{Args, Row, Sheet, memory, reference};
use anyhow::Result;
use cpu_time::ThreadTime;
use rotund_bvh::{Isa, Method, Statistics};
use rotund_report::console::{Table, say};
use std::time::Instant;

/// The scene that is measured.
pub(super) struct Subject<'a> {
    pub(super) name: &'a str,
    /// Whether the peer can generate the same scene.
    pub(super) known_to_peer: bool,
}

/// The cost of building a tree.
#[derive(Clone, Copy)]
struct Building {
    /// CPU time of a build on one thread; with a peer the median over the rounds.
    cpu_seconds: f64,
    /// Elapsed time of a build on all threads.
    seconds: f64,
    /// Peak growth of the process during the build, where the system reports it.
    peak_bytes: Option<f64>,
}

/// Builds a tree, traces rays and prints the table; `None` if there is no primitive.
pub(super) fn measure<P: Primitive>(
    subject: &Subject<'_>,
    primitives: &[P],
    target: &Target,
    args: &Args,
) -> Result<Option<Sheet>> {
    let scene = subject.name;
    if primitives.is_empty() {
        say(format!("{scene}: no primitives"))?;
        return Ok(None);
    }
    let method = if args.vanilla { Method::Vanilla } else { Method::Enhanced };
    let isa = args.isa.unwrap_or_else(Isa::default_set);
    if let Some(count) = args.verify {
        let sets = args.isa.map_or_else(Isa::available, |isa| vec![isa]);
        reference::verify(scene, primitives, target, count as usize, method, &sets)?;
        return Ok(None);
    }
    let progress = Progress::new(scene, primitives.len());
    let (tree, mut building) = build(primitives, isa, &progress)?;
    let statistics = tree.statistics();
    if statistics.primitives == 0 {
        say(format!("{scene}: no primitive that a ray could hit"))?;
        return Ok(None);
    }
    progress.stage("making rays");
    let volleys = shoot::volleys(&tree, target, method);
    let again = || Ok(on_one_thread(primitives, isa)?.1);
    let rounds = rounds(subject, &tree, &volleys, method, args, again, &progress)?;
    progress.stage("tracing on all threads");
    let builds = rounds.iter().filter_map(|round| round.build_seconds);
    building.cpu_seconds =
        median(builds.chain([building.cpu_seconds]).collect()).unwrap_or(f64::NAN);
    let peer_build = rounds.iter().filter_map(|round| round.peer.as_ref()).map(|p| p.build_seconds);
    let peer_build_seconds = median(peer_build.collect());
    let per_primitive = 1.0 / statistics.primitives as f64;
    let mut rows = Vec::new();
    for (index, volley) in volleys.iter().enumerate().filter(|(_, volley)| !volley.rays.is_empty())
    {
        let template = Row {
            scene: scene.to_owned(),
            form: method.name(),
            rays: volley.name,
            threads: 1,
            isa: isa.name(),
            mrays_per_second: f64::NAN,
            peer_mrays_per_second: None,
            ratio: None,
            hit_share: 0.0,
            nodes_per_ray: 0.0,
            primitives_per_ray: 0.0,
            build_seconds: building.cpu_seconds,
            peer_build_seconds,
            bytes_per_primitive: statistics.bytes as f64 * per_primitive,
            peak_bytes_per_primitive: building.peak_bytes.map(|bytes| bytes * per_primitive),
            sah: statistics.sah,
        };
        rows.extend(volley_rows(&tree, volley, index, &rounds, method, template));
    }
    drop(progress);
    print(scene, &rows, &statistics, &building)?;
    let seen = |ray| {
        let visits = tree.visits(ray, method);
        visits.nodes + visits.primitives
    };
    let visits = volleys[0].rays.iter().map(seen).collect();
    Ok(Some(Sheet { scene: scene.to_owned(), rows, visits }))
}

/// Builds the tree twice, with one of them in memory at a time, so that larger scenes fit.
fn build<P: Primitive>(
    primitives: &[P],
    isa: Isa,
    progress: &Progress,
) -> Result<(P::Tree, Building)> {
    progress.stage("building the tree");
    // This build comes before other large allocations, so that the peak is its own.
    let ((bytes, seconds), peak_bytes) = memory::peak_of(|| {
        let start = Instant::now();
        let tree = P::build(primitives, isa);
        let seconds = start.elapsed().as_secs_f64();
        (tree.statistics().bytes, seconds)
    });
    let again = format!("building it again on one thread (on all it took {seconds:.1} s)");
    progress.stage(&again);
    let (tree, cpu_seconds) = on_one_thread(primitives, isa)?;
    // A smaller peak than the tree means that the memory was held by the process already.
    let peak_bytes = peak_bytes.filter(|&peak| peak >= bytes as f64);
    Ok((tree, Building { cpu_seconds, seconds, peak_bytes }))
}

/// Builds a tree on one thread, and returns it with the CPU time in seconds.
fn on_one_thread<P: Primitive>(primitives: &[P], isa: Isa) -> Result<(P::Tree, f64)> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    Ok(pool.install(|| {
        let start = ThreadTime::now();
        let tree = P::build(primitives, isa);
        (tree, start.elapsed().as_secs_f64())
    }))
}

/// One round: our passes over all kinds of rays, then the peer's turn.
struct Round {
    ours: Vec<shoot::Pass>,
    /// Time of another build of ours, since the peer builds its tree in each turn.
    build_seconds: Option<f64>,
    peer: Option<Peer>,
}

fn rounds(
    subject: &Subject<'_>,
    tree: &impl Traced,
    volleys: &[Volley],
    method: Method,
    args: &Args,
    build: impl Fn() -> Result<f64>,
    progress: &Progress,
) -> Result<Vec<Round>> {
    let start = Instant::now();
    (0..args.repeat)
        .map(|round| {
            progress.step("pass", usize::from(round), usize::from(args.repeat), start);
            let ours = volleys
                .iter()
                .map(|volley| {
                    // The first pass warms up, as in the peer.
                    shoot::on_one_thread(tree, volley, method);
                    shoot::on_one_thread(tree, volley, method)
                })
                .collect();
            let program = args.peer.as_deref().filter(|_| subject.known_to_peer);
            let peer = program.map(|program| peer::run(program, subject.name)).transpose()?;
            let build_seconds = peer.as_ref().map(|_| build()).transpose()?;
            Ok(Round { ours, build_seconds, peer })
        })
        .collect()
}

/// Returns the rows of one kind of rays: on one thread, and on all.
fn volley_rows(
    tree: &impl Traced,
    volley: &Volley,
    index: usize,
    rounds: &[Round],
    method: Method,
    template: Row,
) -> [Row; 2] {
    let theirs = |round: &Round| Some(*round.peer.as_ref()?.mrays_per_second.get(volley.name)?);
    let step = (volley.rays.len() / 100_000).max(1);
    let sample: Vec<_> =
        volley.rays.iter().step_by(step).map(|ray| tree.visits(ray, method)).collect();
    let mean = |f: fn(&rotund_bvh::Visits) -> u32| {
        sample.iter().map(|v| f64::from(f(v))).sum::<f64>() / sample.len().max(1) as f64
    };
    let ours = |round: &Round| round.ours[index].mrays_per_second;
    let paired = |round: &Round| Some(ours(round) / theirs(round)?);
    let one = Row {
        mrays_per_second: median(rounds.iter().map(ours).collect()).unwrap_or(f64::NAN),
        peer_mrays_per_second: median(rounds.iter().filter_map(theirs).collect()),
        ratio: median(rounds.iter().filter_map(paired).collect()),
        hit_share: rounds.first().map_or(0.0, |round| round.ours[index].hit_share),
        nodes_per_ray: mean(|v| v.nodes),
        primitives_per_ray: mean(|v| v.primitives),
        ..template
    };
    let passes =
        rounds.iter().map(|_| shoot::on_all_threads(tree, volley, method).mrays_per_second);
    let all = Row {
        threads: rayon::current_num_threads(),
        mrays_per_second: median(passes.collect()).unwrap_or(f64::NAN),
        peer_mrays_per_second: None,
        ratio: None,
        ..one.clone()
    };
    [one, all]
}

pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

fn print(scene: &str, rows: &[Row], tree: &Statistics, building: &Building) -> Result<()> {
    let Some(first) = rows.first() else { return Ok(()) };
    let peer = first.peer_build_seconds.map(|s| format!(" (peer {s:.3})")).unwrap_or_default();
    let peak = first.peak_bytes_per_primitive.map(|peak| format!(", {peak:.1} at the peak"));
    // The peak of the process includes primitives and rays.
    let process = memory::peak_gib().map(|gib| format!(" ({gib:.2} GiB of the process)"));
    say(format!(
        "{scene}, {}, {}: {} primitives\n  \
         build: {:.3} CPU seconds{peer}, {:.3} s on {} threads\n  \
         bytes each: {:.1}{}{}\n  \
         tree: {} nodes {:.0} % full, {} leaves of {:.1}, depth {}, SAH {:.1}",
        first.form,
        first.isa,
        tree.primitives,
        building.cpu_seconds,
        building.seconds,
        rayon::current_num_threads(),
        first.bytes_per_primitive,
        peak.unwrap_or_default(),
        process.unwrap_or_default(),
        tree.nodes,
        100.0 * tree.children as f64 / (8 * tree.nodes.max(1)) as f64,
        tree.leaves,
        tree.primitives as f64 / tree.leaves.max(1) as f64,
        tree.depth,
        tree.sah,
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
