//! The part of the report about one shape.

use std::fmt::Write as _;

use anyhow::Result;

use super::heat::{self, Shown};
use crate::accuracy::{
    overview::{counts, offset},
    study::{MethodResult, Options, ShapeResult, Study, Summary},
    tally::Spread,
    targets::short,
    timing::LOOP,
};
use rotund_report::chart::{self, Labels, Series};
use rotund_report::html::escape;

/// A quantity of the curves: title, axis, the value at which zero is drawn, and how to read it.
struct Quantity {
    title: &'static str,
    axis: &'static str,
    floor: f64,
    /// Returns `None` if there is no correct hit.
    of: fn(&MethodResult) -> Option<f64>,
}

const QUANTITIES: [Quantity; 4] = [
    Quantity {
        title: "False misses, false hits, wrong roots",
        axis: "% of all rays",
        floor: 1e-3,
        of: |m| {
            let rays = m.tally.true_hits + m.tally.true_misses;
            Some(100.0 * m.tally.false_results() as f64 / rays.max(1) as f64)
        },
    },
    Quantity { title: "Error of t, p99", axis: "2⁻²⁴ t", floor: 0.1, of: |m| p99(m.tally.t) },
    Quantity {
        title: "Position from the surface, p99",
        axis: "2⁻²⁴ max(|p|, size)",
        floor: 0.1,
        of: |m| p99(m.tally.position),
    },
    Quantity {
        title: "Error of the normal, p99",
        axis: "degrees",
        floor: 1e-7,
        of: |m| p99(m.tally.normal),
    },
];

fn p99(spread: Spread) -> Option<f64> {
    (spread.count > 0).then_some(spread.p99)
}

/// Writes the table, the scatter plots and the curves.
pub(super) fn section(body: &mut String, shape: &ShapeResult) {
    let summaries = shape.summaries();
    table(body, shape, &summaries);
    scatters(body, shape, &summaries);
    for (curve, axis, title) in [
        ("distance", "distance of the origin in sizes of the shape", "Error against distance"),
        ("grazing", "how far the ray passes the surface by, in sizes", "Error against grazing"),
    ] {
        curves(body, shape, &summaries, curve, axis, title);
    }
    joints(body, shape, &summaries);
}

fn table(body: &mut String, shape: &ShapeResult, summaries: &[(&'static str, Summary)]) {
    let rays = summaries.first().map_or(0, |(_, s)| s.true_hits + s.true_misses);
    let _ = write!(
        body,
        "<p>{rays} rays in {} families and levels. p99 and maximum are of the worst row. Errors of t in 2⁻²⁴ t, of \
         positions in 2⁻²⁴ max(|p|, size), of normals in degrees; the offset along the normal in 2⁻²⁴ max(|o|, |p|).</p>\
         <div class=\"scroll\"><table><tr><th>method</th><th>ns</th><th>±</th><th>fresh</th><th>hits</th><th>misses</th>\
         <th>rebuild<br>from uv</th><th>false<br>misses %</th><th>false<br>hits %</th><th>wrong<br>roots %</th><th>rows with<br>errors</th>\
         <th>t p99</th><th>max</th><th>position<br>p99</th><th>max</th><th>o + t d<br>max</th><th>from uv<br>max</th>\
         <th>normal<br>p99</th><th>max</th><th>safe<br>offset</th></tr>",
        shape.rows.len()
    );
    for (name, sum) in summaries {
        let class = if sum.own { " class=\"own\"" } else { "" };
        let mut cells = vec![escape(name)];
        cells.extend(times(shape, name));
        cells.extend(counts(sum));
        cells.extend([sum.t.0, sum.t.1, sum.position.0, sum.position.1, sum.on_ray.1].map(short));
        cells.push(if sum.own { short(sum.rebuilt.1) } else { "-".into() });
        cells.extend([sum.normal.0, sum.normal.1].map(short));
        cells.push(offset(sum.approximate, sum.offset_max));
        let _ = write!(body, "<tr{class}><td>{}</td></tr>", cells.join("</td><td>"));
    }
    if !shape.timings.is_empty() {
        let _ = write!(
            body,
            "<tr class=\"soft\"><td>{LOOP}</td><td>{}</td></tr>",
            times(shape, LOOP).join("</td><td>")
        );
    }
    body.push_str("</table></div>");
}

fn times(shape: &ShapeResult, method: &str) -> [String; 6] {
    let Some(timing) = shape.timing(method) else { return [const { String::new() }; 6] };
    let ns = |value: f64| format!("{value:.1}");
    [
        ns(timing.mixed.median),
        ns(timing.mixed.spread),
        ns(timing.fresh.median),
        ns(timing.hits.median),
        ns(timing.misses.median),
        timing.rebuild.map_or("-".to_owned(), |rebuild| ns(rebuild.median)),
    ]
}

/// Writes plots of time against error: over all rays, and for the median family.
fn scatters(body: &mut String, shape: &ShapeResult, summaries: &[(&'static str, Summary)]) {
    if shape.timings.is_empty() {
        return;
    }
    let dots = |value: &dyn Fn(&str, &Summary) -> f64| -> Vec<Series> {
        let dot = |(i, (name, sum)): (usize, &(&'static str, Summary))| {
            let ns = shape.timing(name)?.mixed.median;
            Some(series(i, name, sum, vec![(ns, value(name, sum))]))
        };
        summaries.iter().enumerate().filter_map(dot).collect()
    };
    let share = |_: &str, sum: &Summary| {
        let wrong = sum.false_misses + sum.false_hits + sum.wrong_roots + sum.invalid;
        100.0 * wrong as f64 / (sum.true_hits + sum.true_misses).max(1) as f64
    };
    let position = |name: &str, _: &Summary| {
        let mut values: Vec<f64> = shape
            .rows
            .iter()
            .flat_map(|row| &row.methods)
            .filter(|m| m.method == name && m.tally.position.count > 0)
            .map(|m| m.tally.position.max)
            .collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    let key = chart::legend(&dots(&share));
    let _ = write!(body, "<h3>Time against error</h3>{key}<div class=\"charts\">");
    let x = "ns per test, hits and misses half and half";
    let labels = Labels { title: "False results of all families", x, y: "% of all rays" };
    body.push_str(&chart::scatter(&labels, &dots(&share), 1e-4));
    let labels = Labels {
        title: "Largest error of the position, median over the families",
        x,
        y: "2⁻²⁴ max(|p|, size)",
    };
    body.push_str(&chart::scatter(&labels, &dots(&position), 0.1));
    body.push_str(
        "</div><p class=\"soft\">Nothing that is measured lies below and left of the dotted front. Hollow: another \
         problem is solved. On the lowest line: none.</p>",
    );
}

fn series(index: usize, name: &str, sum: &Summary, points: Vec<(f64, f64)>) -> Series {
    let (color, approximate) = (chart::color(index), sum.approximate);
    Series { name: name.to_owned(), color, approximate, points }
}

fn curves(
    body: &mut String,
    shape: &ShapeResult,
    summaries: &[(&'static str, Summary)],
    curve: &str,
    axis: &str,
    title: &str,
) {
    let rows: Vec<_> = shape.rows.iter().filter(|row| row.curve == Some(curve)).collect();
    if rows.len() < 2 {
        return;
    }
    let lines = |of: fn(&MethodResult) -> Option<f64>| -> Vec<Series> {
        let line = |(i, (name, sum)): (usize, &(&'static str, Summary))| {
            let points = rows
                .iter()
                .filter_map(|row| {
                    let result = row.methods.iter().find(|m| m.method == *name)?;
                    Some((row.level, of(result)?))
                })
                .collect();
            series(i, name, sum, points)
        };
        summaries.iter().enumerate().map(line).collect()
    };
    let _ =
        write!(body, "<h3>{title}</h3>{}<div class=\"charts\">", chart::legend(&lines(|_| None)));
    for quantity in &QUANTITIES {
        let labels = Labels { title: quantity.title, x: axis, y: quantity.axis };
        body.push_str(&chart::curves(&labels, &lines(quantity.of), Some(quantity.floor)));
    }
    body.push_str("</div>");
}

fn joints(body: &mut String, shape: &ShapeResult, summaries: &[(&'static str, Summary)]) {
    let Some(first) = shape.joints.first() else { return };
    let mut places: Vec<&str> = shape.joints.iter().map(|j| j.place).collect();
    places.dedup();
    let _ = write!(
        body,
        "<h3>Where shapes meet</h3><p>Leaks and doubles of {} rays aimed at each place. A leak met nothing; a double met \
         two patches where it crosses the sheet once, or another surface of two cones than the first.</p>\
         <div class=\"scroll\"><table><tr><th>method</th><th>{}</th></tr>",
        first.rays,
        places.join("</th><th>")
    );
    for (name, sum) in summaries {
        let class = if sum.own { " class=\"own\"" } else { "" };
        let _ = write!(body, "<tr{class}><td>{}</td>", escape(name));
        for place in &places {
            let found = shape.joints.iter().find(|j| j.place == *place && j.method == *name);
            let text = found.map_or(String::new(), |j| format!("{} / {}", j.leaks, j.doubles));
            let _ = write!(body, "<td>{text}</td>");
        }
        body.push_str("</tr>");
    }
    body.push_str("</table></div>");
}

/// Writes the maps of all methods.
pub(super) fn heat_maps<S: Shown>(body: &mut String, options: &Options) -> Result<()> {
    let maps = heat::maps::<S>(&options.methods::<S>())?;
    let _ = write!(
        body,
        "<h3>Where the errors are</h3><p>Seen from {} sizes away by parallel rays of unit direction; lit from the eye. \
         Above the distance of the position from the surface, below the error of the normal.\
         <span class=\"key\"><span class=\"swatch\" style=\"background:#00c8ff\"></span>false miss</span>\
         <span class=\"key\"><span class=\"swatch\" style=\"background:#78ff50\"></span>false hit</span>\
         <span class=\"key\"><span class=\"swatch\" style=\"background:#ff50ff\"></span>wrong root</span></p>",
        S::FROM
    );
    let bar = heat::scale_bar()?;
    for (pick, (low, high), unit) in
        [(0, heat::POSITION_SCALE, "2⁻²⁴ max(|p|, size)"), (1, heat::NORMAL_SCALE, "degrees")]
    {
        body.push_str("<div class=\"maps\">");
        for map in &maps {
            let image = if pick == 0 { &map.position } else { &map.normal };
            let _ = write!(
                body,
                "<figure><img src=\"{image}\" alt=\"error of {0} in color\"><figcaption>{0}</figcaption></figure>",
                escape(map.method)
            );
        }
        let _ = write!(
            body,
            "</div><div class=\"scale\"><span>10<sup>{low}</sup></span><img src=\"{bar}\" alt=\"scale of colors\"><span>10<sup>{high}</sup> {unit}</span></div>"
        );
    }
    Ok(())
}

/// Writes the worst cases, and all rows of our methods.
pub(super) fn details(body: &mut String, shape: &ShapeResult, study: &Study) {
    let _ = write!(
        body,
        "<h3>Worst cases</h3><p>Of each method the worst case of each kind, by row. <code>cargo xtask accuracy --replay \
         CASE</code> shows one with the answers of all methods.</p>"
    );
    for (name, sum) in shape.summaries() {
        let open = if sum.own { " open" } else { "" };
        let _ = write!(
            body,
            "<details{open}><summary>{}</summary><div class=\"scroll\"><table><tr><th>what</th><th>row</th><th>value</th><th class=\"left\">case</th></tr>",
            escape(name)
        );
        for (row, what, value, case) in worst_cases(shape, name) {
            let _ = write!(
                body,
                "<tr><td>{what}</td><td>{}</td><td>{}</td><td class=\"case\"><code>{case}</code></td></tr>",
                escape(row),
                short(value)
            );
        }
        body.push_str("</table></div></details>");
    }
    for name in shape.summaries().iter().filter(|(_, s)| s.own).map(|(name, _)| name) {
        let _ = write!(
            body,
            "<details><summary>All rows of {name}, seed {}</summary><div class=\"scroll\"><table><tr><th>family</th>\
             <th class=\"left\">why it is hard</th><th>hits</th><th>misses</th><th>false</th><th>t p50</th><th>p99</th><th>max</th><th>position p50</th>\
             <th>p99</th><th>max</th><th>o + t d</th><th>from uv</th><th>uv and back</th><th>uv, 2⁻²⁴</th><th>normal</th><th>from uv</th>\
             <th>self-hits %</th><th>offset</th></tr>",
            study.seed
        );
        for row in &shape.rows {
            let Some(m) = row.methods.iter().find(|m| m.method == *name) else { continue };
            let (t, p) = (m.tally.t, m.tally.position);
            let numbers = [
                t.p50,
                t.p99,
                t.max,
                p.p50,
                p.p99,
                p.max,
                m.tally.on_ray.max,
                m.tally.rebuilt.max,
                m.tally.round_trip.max,
                m.tally.uv.max,
                m.tally.normal.max,
                m.tally.rebuilt_normal.max,
                100.0 * m.leaving.share_without_offset,
                m.leaving.offset_max.into(),
            ];
            let _ = write!(
                body,
                "<tr><td>{}</td><td class=\"left\">{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
                escape(&row.label),
                escape(row.why),
                m.tally.true_hits,
                m.tally.true_misses,
                m.tally.false_results(),
                numbers.map(short).join("</td><td>")
            );
        }
        body.push_str("</table></div></details>");
    }
}

/// Returns the worst case of each kind of error, with its row.
fn worst_cases<'a>(shape: &'a ShapeResult, method: &str) -> Vec<(&'a str, &'a str, f64, &'a str)> {
    let mut worst: Vec<(&str, &str, f64, &str)> = Vec::new();
    for row in &shape.rows {
        for result in row.methods.iter().filter(|m| m.method == method) {
            for case in result.tally.worst.iter().chain(&result.leaving.worst) {
                let found = (row.label.as_str(), case.what, case.value, case.case.as_str());
                match worst.iter_mut().find(|w| w.1 == case.what) {
                    Some(known) if known.2 >= case.value => {}
                    Some(known) => *known = found,
                    None => worst.push(found),
                }
            }
        }
    }
    worst
}
