//! `--crossings`: what it costs to find where rays enter and leave the union of solids, against
//! closest hits of the same rays, and pictures of tubes as published.

use super::measure::Subject;
use super::progress::Progress;
use super::recipe::{self, Target};
use super::shoot::{Primitive, Traced};
use super::{Args, memory};
use crate::random::Random;
use anyhow::Result;
use cpu_time::ThreadTime;
use glam::Vec3;
use rotund_bvh::{ConeTree, Crossing, Isa, Method, SphereTree, Start};
use rotund_geometry::Ray;
use rotund_report::console::{Table, say};
use std::hint::black_box;
use std::ops::ControlFlow;

/// A tree of solids.
pub(super) trait Body: Traced {
    fn boundary(&self, ray: &Ray, start: Start) -> Option<Crossing>;
    fn boundaries(&self, ray: &Ray, visit: &mut dyn FnMut(&Crossing) -> ControlFlow<()>);
    fn count_crossings(&self, ray: &Ray) -> usize;
}

macro_rules! body {
    ($($tree:ty)*) => {$(
        impl Body for $tree {
            #[inline]
            fn boundary(&self, ray: &Ray, start: Start) -> Option<Crossing> {
                self.boundary(ray, start)
            }

            #[inline]
            fn boundaries(&self, ray: &Ray, visit: &mut dyn FnMut(&Crossing) -> ControlFlow<()>) {
                _ = self.boundaries(ray, visit);
            }

            fn count_crossings(&self, ray: &Ray) -> usize {
                let mut count = 0;
                _ = self.crossings(ray, Method::Enhanced, |_| {
                    count += 1;
                    ControlFlow::Continue(())
                });
                count
            }
        }
    )*};
}

body! { SphereTree ConeTree }

/// A query as a path makes it: a ray, and what is known about its start.
struct Query {
    ray: Ray,
    start: Start,
}

/// The most crossings that are followed along one ray.
const LONGEST: usize = 1000;

/// The most queries of a kind that are timed.
const QUERIES: usize = 1 << 20;

/// Measures the crossings of one tree, and the picture.
pub(super) fn measure<P: Primitive<Tree: Body>>(
    subject: &Subject<'_>,
    solids: &[P],
    target: &Target,
    args: &Args,
) -> Result<()> {
    let progress = Progress::new(subject.name, solids.len());
    progress.stage("building the tree");
    let isa = args.isa.unwrap_or_else(Isa::default_set);
    let tree = P::build(solids, isa);
    let statistics = tree.statistics();
    progress.stage("following rays");
    let primary = recipe::primary(target);
    let [entries, exits] = follow(&tree, &primary);
    let all = || entries.iter().chain(&exits);
    let mut rows = Vec::new();
    let mut whole = Vec::new();
    for round in 0..args.repeat {
        progress.stage(&format!("pass {} of {}", round + 1, args.repeat));
        let time = |queries: &mut dyn Iterator<Item = &Query>| Times::of(&tree, queries);
        rows.push([time(&mut entries.iter()), time(&mut exits.iter()), time(&mut all())]);
        whole.push(all_at_once(&tree, &primary));
    }
    drop(progress);
    say(format!(
        "{}, {}: {} solids, {:.1} bytes each",
        subject.name,
        isa.name(),
        statistics.primitives,
        statistics.bytes as f64 / statistics.primitives.max(1) as f64
    ))?;
    let mut table = Table::new(&["crossings", "queries", "ns each", "closest hit, ns", "ratio"]);
    for (index, name, count) in [
        (0, "entries, next ray", entries.len()),
        (1, "exits, next ray", exits.len()),
        (2, "both", entries.len() + exits.len()),
    ] {
        let of = |f: fn(&Times) -> f64| {
            super::measure::median(rows.iter().map(|row| f(&row[index])).collect())
        };
        table.row([
            name.to_owned(),
            count.to_string(),
            nanoseconds(of(|times| times.boundary)),
            nanoseconds(of(|times| times.closest)),
            ratio(of(|times| times.boundary / times.closest)),
        ]);
    }
    let counted = whole.first().map_or(0, |&(count, _)| count);
    let each = super::measure::median(whole.iter().map(|&(count, ns)| ns / count as f64).collect());
    table.row([
        "all of a ray at once".into(),
        counted.to_string(),
        nanoseconds(each),
        "-".into(),
        "-".into(),
    ]);
    say(table.to_string())?;
    say(growth(&tree, &exits).to_string())?;
    say(picture(&tree, target)?)?;
    if let Some(gib) = memory::peak_gib() {
        say(format!("{gib:.2} GiB of the process\n"))?;
    }
    Ok(())
}

fn nanoseconds(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map_or_else(|| "-".to_owned(), |value| format!("{value:.0}"))
}

fn ratio(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map_or_else(|| "-".to_owned(), |value| format!("{value:.2}"))
}

/// Follows rays through the union, and returns the queries from outside and those from inside.
fn follow<T: Body>(tree: &T, primary: &[Ray]) -> [Vec<Query>; 2] {
    let mut found = [const { Vec::new() }; 2];
    for primary in primary {
        let mut query = Query { ray: *primary, start: Start::ByPosition };
        let mut inside = 0;
        for _ in 0..LONGEST {
            let crossing = tree.boundary(&query.ray, query.start);
            if found[inside].len() < QUERIES {
                found[inside].push(Query { ..query });
            }
            let Some(crossing) = crossing else { break };
            query.ray = crossing.hit.spawn(primary.direction);
            query.start = if crossing.enters { Start::ByPosition } else { Start::Outside };
            inside = usize::from(crossing.enters);
        }
        if found.iter().all(|queries| queries.len() == QUERIES) {
            break;
        }
    }
    found
}

/// Nanoseconds of one query.
struct Times {
    boundary: f64,
    closest: f64,
}

impl Times {
    fn of(tree: &impl Body, queries: &mut dyn Iterator<Item = &Query>) -> Self {
        let queries: Vec<&Query> = queries.collect();
        let boundary = |query: &&Query| {
            black_box(tree.boundary(&query.ray, query.start));
        };
        let closest = |query: &&Query| {
            black_box(tree.closest(&query.ray, Method::Enhanced));
        };
        // The first pass over each warms up.
        queries.iter().take(QUERIES / 16).for_each(closest);
        let closest = time(queries.len(), || queries.iter().for_each(closest));
        queries.iter().take(QUERIES / 16).for_each(boundary);
        let boundary = time(queries.len(), || queries.iter().for_each(boundary));
        Self { boundary, closest }
    }
}

/// Returns the nanoseconds of this thread for each of `count` things.
fn time(count: usize, work: impl FnOnce()) -> f64 {
    let start = ThreadTime::now();
    work();
    1e9 * start.elapsed().as_secs_f64() / count as f64
}

/// Returns the number of boundaries along all rays, and the nanoseconds to visit them.
fn all_at_once(tree: &impl Body, primary: &[Ray]) -> (usize, f64) {
    let mut count = 0;
    let start = ThreadTime::now();
    for ray in primary {
        tree.boundaries(ray, &mut |_| {
            count += 1;
            ControlFlow::Continue(())
        });
    }
    (count, 1e9 * start.elapsed().as_secs_f64())
}

/// Returns how the cost of an exit grows with the number of solids on the way to it.
fn growth(tree: &impl Body, exits: &[Query]) -> Table {
    let mut bins: Vec<Vec<&Query>> = Vec::new();
    let step = (exits.len() / 200_000).max(1);
    for query in exits.iter().step_by(step) {
        let Some(crossing) = tree.boundary(&query.ray, query.start) else { continue };
        let inside = Ray { t_max: crossing.hit.t, ..query.ray };
        let solids = tree.count_crossings(&inside).max(1);
        let bin = solids.next_power_of_two().ilog2() as usize;
        bins.resize_with(bins.len().max(bin + 1), Vec::new);
        bins[bin].push(query);
    }
    let mut table = Table::new(&["crossings inside", "exits", "ns each", "to the first"]);
    let mut first = None;
    for (bin, queries) in bins.iter().enumerate().filter(|(_, queries)| queries.len() >= 100) {
        let exit = |query: &&Query| {
            black_box(tree.boundary(&query.ray, query.start));
        };
        queries.iter().for_each(exit);
        let each = time(queries.len(), || queries.iter().for_each(exit));
        let low = (1 << bin) / 2 + 1;
        let range =
            if low >= 1 << bin { low.to_string() } else { format!("{low} to {}", 1 << bin) };
        let first = *first.get_or_insert(each);
        table.row([
            range,
            queries.len().to_string(),
            nanoseconds(Some(each)),
            ratio(Some(each / first)),
        ]);
    }
    table
}

/// Pixels along a side of the published pictures.
const SIDE: usize = 2048;

/// Opacity of a surface in the picture, and the transmittance at which a ray ends.
const OPACITY: f32 = 0.5;
const DARK: f32 = 0.01;

/// Renders a picture on one thread as in published measurements of tubes: transparent surfaces
/// without those inside, composited from front to back, each with a ray to a light and one of
/// ambient occlusion.
///
/// Source of the setting: M. Han et al., "Ray Tracing Generalized Tube Primitives", Computer
/// Graphics Forum 38, 2019.
fn picture(tree: &impl Body, target: &Target) -> Result<String> {
    let rays = recipe::pinhole(target, SIDE);
    let light = Vec3::new(0.3, 0.4, 0.87).normalize();
    let (mut surfaces, mut covered, mut sum) = (0u64, 0u64, 0.0f64);
    let start = ThreadTime::now();
    for (pixel, ray) in rays.iter().enumerate() {
        let mut transmittance = 1.0;
        let mut brightness = 0.0;
        let mut random = Random::from_state(pixel as u64);
        tree.boundaries(ray, &mut |crossing| {
            surfaces += 1;
            let hit = &crossing.hit;
            let normal = if crossing.enters { hit.normal } else { -hit.normal };
            let around = (normal.as_dvec3() + random.direction()).as_vec3();
            let lit = normal.dot(light) > 0.0 && !tree.any(&hit.spawn(light), Method::Enhanced);
            let open = !tree.any(&hit.spawn(around), Method::Enhanced);
            let share = f32::from(u8::from(lit)) * normal.dot(light) + f32::from(u8::from(open));
            brightness += transmittance * OPACITY * share;
            transmittance *= 1.0 - OPACITY;
            if transmittance < DARK { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        covered += u64::from(transmittance < 1.0);
        sum += f64::from(brightness);
    }
    black_box(sum);
    let seconds = start.elapsed().as_secs_f64();
    let pixels = rays.len() as f64;
    Ok(format!(
        "picture of {SIDE} x {SIDE} pixels, {:.0} % of them covered, by {:.1} surfaces each, \
         a shadow and an occlusion ray for each:\n  {seconds:.2} s of one core, {:.0} thousand \
         pixels per second and core",
        100.0 * covered as f64 / pixels,
        surfaces as f64 / covered.max(1) as f64,
        1e-3 * pixels / seconds
    ))
}
