//! The tables on the terminal.

use anyhow::Result;

use super::{
    study::{ShapeResult, Study, Summary},
    targets::{Verdict, short},
    timing::{LOOP, unsteady},
};
use rotund_report::console::{Table, say};

/// Prints one table for each shape, its joints, and the targets.
pub(crate) fn print(study: &Study, verdicts: &[Verdict]) -> Result<()> {
    for shape in &study.shapes {
        let rays: usize = shape.summaries().first().map_or(0, |(_, s)| s.true_hits + s.true_misses);
        say(format!("\n{}: {rays} rays in {} families and levels", shape.shape, shape.rows.len()))?;
        say(methods(shape).to_string())?;
        if let Some(joints) = joints(shape) {
            say(format!("\n{joints}"))?;
        }
    }
    say(
        "\nUnits: t in 2^-24 t; positions in 2^-24 max(|p|, size); normals in degrees; the offset along \
         the normal that\nno ray needs to exceed in 2^-24 max(|o|, |p|). p99 and max are of the worst row. \
         ns include the loop \
         around the test;\nfresh: rays the processor has not seen before, the others come again and again.",
    )?;
    if study.shapes.iter().any(|shape| unsteady(&shape.timings)) {
        say(
            "\nThe times are unsteady (+- is large): something else was running. Do not compare them.",
        )?;
    }
    say(format!("\n{}", targets(verdicts)))
}

fn methods(shape: &ShapeResult) -> Table {
    let mut table = Table::new(&[
        "method",
        "ns",
        "+-",
        "fresh",
        "hits",
        "misses",
        "rebuild",
        "f.miss %",
        "f.hit %",
        "w.root %",
        "rows",
        "t p99",
        "max",
        "position p99",
        "max",
        "o+td max",
        "uv max",
        "normal p99",
        "max",
        "offset",
    ]);
    for (name, sum) in shape.summaries() {
        let mut cells = vec![name.to_owned()];
        cells.extend(times(shape, name));
        cells.extend(counts(&sum));
        cells.extend([
            short(sum.t.0),
            short(sum.t.1),
            short(sum.position.0),
            short(sum.position.1),
            short(sum.on_ray.1),
            if sum.own { short(sum.rebuilt.1) } else { "-".into() },
            short(sum.normal.0),
            short(sum.normal.1),
            offset(sum.approximate, sum.offset_max),
        ]);
        table.row(cells);
    }
    if !shape.timings.is_empty() {
        table.row([LOOP.to_owned()].into_iter().chain(times(shape, LOOP)));
    }
    table
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

/// Shares of false results, and in how many rows there are any.
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

fn joints(shape: &ShapeResult) -> Option<Table> {
    let mut places: Vec<&str> = shape.joints.iter().map(|j| j.place).collect();
    places.dedup();
    let rays = shape.joints.first()?.rays;
    let heading = format!("leaks / doubles of {rays} rays at a shared");
    let mut table = Table::new(&[&[heading.as_str()], places.as_slice()].concat());
    for (name, _) in shape.summaries() {
        let cells = places.iter().filter_map(|place| {
            let found = shape.joints.iter().find(|j| j.place == *place && j.method == name)?;
            Some(format!("{} / {}", found.leaks, found.doubles))
        });
        table.row([name.to_owned()].into_iter().chain(cells));
    }
    Some(table)
}

fn targets(verdicts: &[Verdict]) -> Table {
    let mut table = Table::new(&["target of the own methods", "limit", "worst", "met"]);
    for verdict in verdicts {
        let what = if verdict.limit.ends_with('x') {
            format!("time against {}", verdict.what)
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
