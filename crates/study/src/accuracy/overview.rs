//! The tables on the terminal, which fit into 80 columns.

use anyhow::Result;

use super::{
    study::{ShapeResult, Study, Summary},
    targets::{Verdict, short},
    timing::{LOOP, unsteady},
};
use rotund_report::console::{Table, say};

/// Prints the tables of each shape, its joints, and the targets.
pub(crate) fn print(study: &Study, verdicts: &[Verdict]) -> Result<()> {
    for shape in &study.shapes {
        let rays: usize = shape.summaries().first().map_or(0, |(_, s)| s.true_hits + s.true_misses);
        say(format!("\n{}: {rays} rays in {} families and levels", shape.shape, shape.rows.len()))?;
        for table in [speed(shape), answers(shape), errors(shape)].into_iter().flatten() {
            say(format!("\n{table}"))?;
        }
        if let Some((rays, joints)) = joints(shape) {
            say(format!("\nLeaks / doubles of {rays} rays at each kind of joint\n{joints}"))?;
        }
    }
    say("\n\
         ns: of a test and the loop around it; fresh: of rays that are not repeated.\n\
         False misses, false hits and wrong roots in %, and the rows that have any.\n\
         Errors: p99 and max of the worst row; t in 2^-24 t, positions in\n\
         2^-24 max(|p|, size), normals in degrees. The position comes with the hit, by\n\
         o + t d, or from uv. Offset: along the normal, in 2^-24 max(|o|, |p|), enough\n\
         for all rays that leave a hit.")?;
    if study.shapes.iter().any(|shape| unsteady(&shape.timings)) {
        say(
            "\nThe times are unsteady (+- is large): other programs were running. Do not\ncompare them.",
        )?;
    }
    say(format!("\n{}", targets(verdicts)))
}

/// Times, if they were measured.
fn speed(shape: &ShapeResult) -> Option<Table> {
    let mut table = Table::new(&["ns", "mixed", "+-", "fresh", "hits", "misses", "rebuild"]);
    let names = shape.summaries().into_iter().map(|(name, _)| name);
    for name in names.chain([LOOP]) {
        table.row([name.to_owned()].into_iter().chain(times(shape, name)));
    }
    (!shape.timings.is_empty()).then_some(table)
}

/// False results, errors of `t`, and safe offsets.
fn answers(shape: &ShapeResult) -> Option<Table> {
    let mut table =
        Table::new(&["answers", "f.miss", "f.hit", "w.root", "rows", "t p99", "t max", "offset"]);
    for (name, sum) in shape.summaries() {
        let mut cells = vec![name.to_owned()];
        cells.extend(counts(&sum));
        cells.extend([short(sum.t.0), short(sum.t.1), offset(sum.approximate, sum.offset_max)]);
        table.row(cells);
    }
    Some(table)
}

/// Errors of positions and normals.
fn errors(shape: &ShapeResult) -> Option<Table> {
    let mut table =
        Table::new(&["errors", "position p99", "max", "o+td max", "uv max", "normal p99", "max"]);
    for (name, sum) in shape.summaries() {
        table.row([
            name.to_owned(),
            short(sum.position.0),
            short(sum.position.1),
            short(sum.on_ray.1),
            if sum.own { short(sum.rebuilt.1) } else { "-".into() },
            short(sum.normal.0),
            short(sum.normal.1),
        ]);
    }
    Some(table)
}

fn times(shape: &ShapeResult, method: &str) -> [String; 6] {
    let Some(timing) = shape.timing(method) else { return [const { String::new() }; 6] };
    [
        format!("{:.1}", timing.mixed.median),
        format!("{:.1}", timing.mixed.spread),
        format!("{:.1}", timing.fresh.median),
        format!("{:.1}", timing.hits.median),
        format!("{:.1}", timing.misses.median),
        timing.rebuild.map_or("-".to_owned(), |ns| format!("{:.1}", ns.median)),
    ]
}

/// Formats the shares of false results, and how many rows have any.
pub(crate) fn counts(sum: &Summary) -> [String; 4] {
    let share = |count: usize, of: usize| {
        if count == 0 { "0".to_owned() } else { short(100.0 * count as f64 / of.max(1) as f64) }
    };
    [
        share(sum.false_misses, sum.true_hits),
        share(sum.false_hits + sum.invalid, sum.true_misses),
        share(sum.wrong_roots, sum.true_hits),
        sum.rows_with_errors.to_string(),
    ]
}

pub(crate) fn offset(approximate: bool, units: u32) -> String {
    match units {
        _ if approximate => "-".to_owned(),
        u32::MAX => "> 2^18".to_owned(),
        units => units.to_string(),
    }
}

/// How many rays were aimed at each kind of joint, and what became of them.
fn joints(shape: &ShapeResult) -> Option<(usize, Table)> {
    let mut places: Vec<&str> = shape.joints.iter().map(|j| j.place).collect();
    places.dedup();
    let rays = shape.joints.first()?.rays;
    let names: Vec<String> =
        places.iter().map(|p| p.replace("shared ", "").replace("distance ", "")).collect();
    let headings: Vec<&str> = ["joint"].into_iter().chain(names.iter().map(|n| &**n)).collect();
    let mut table = Table::new(&headings);
    for (name, _) in shape.summaries() {
        let cells = places.iter().filter_map(|place| {
            let found = shape.joints.iter().find(|j| j.place == *place && j.method == name)?;
            Some(format!("{} / {}", found.leaks, found.doubles))
        });
        table.row([name.to_owned()].into_iter().chain(cells));
    }
    Some((rays, table))
}

fn targets(verdicts: &[Verdict]) -> Table {
    let mut table = Table::new(&["target of our methods", "limit", "worst", "met"]);
    for verdict in verdicts {
        let what = if verdict.limit.ends_with('x') {
            format!("time, {}", verdict.what)
        } else {
            verdict.what.to_owned()
        };
        let met = match verdict.misses.len() {
            0 => "yes".to_owned(),
            1 => "NO, 1 row".to_owned(),
            n => format!("NO, {n} rows"),
        };
        let name = format!("{}: {what}", verdict.shape);
        table.row([name, verdict.limit.clone(), short(verdict.worst), met]);
    }
    table
}
