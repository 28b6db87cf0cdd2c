//! The targets of the library's own intersectors, and whether they are met.

use serde::Serialize;

use super::study::{MethodResult, RowResult, ShapeResult, Study};

/// The result of one target on one shape: the worst value over all rows, and the rows that miss it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Verdict {
    pub(crate) shape: &'static str,
    pub(crate) what: &'static str,
    /// The limit of most rows; few have another.
    pub(crate) limit: String,
    pub(crate) worst: f64,
    pub(crate) met: bool,
    /// Row, value and limit of each miss, as text.
    pub(crate) misses: Vec<String>,
}

/// A quantity of a row, and its limit on that row.
struct Target {
    what: &'static str,
    limit: fn(&str, &RowResult) -> f64,
    value: fn(&MethodResult) -> f64,
}

/// A correctly rounded `t` has an error of at most one unit. The rest allows for the error of the
/// `f64` solution before rounding.
const T_LIMIT: f64 = 1.001;

const TARGETS: &[Target] = &[
    Target {
        what: "false misses, false hits, wrong roots",
        limit: |_, row| match (row.family, row.level) {
            // Such a ray lies in the surface, so its hit is not defined; 1 % of the rays may
            // differ.
            ("parallel to a ruling", 0.0) => {
                0.01 * row.methods.first().map_or(0, |m| m.tally.true_hits + m.tally.true_misses)
                    as f64
            }
            _ => 0.0,
        },
        value: |m| m.tally.false_results() as f64,
    },
    Target {
        what: "t error, max, 2⁻²⁴ t",
        limit: |_, row| match (row.family, row.level) {
            ("parallel to a ruling", 0.0) => f64::INFINITY,
            _ => T_LIMIT,
        },
        value: |m| m.tally.t.max,
    },
    Target {
        what: "position error, max, 2⁻²⁴ max(|p|, size)",
        limit: |_, _| 1.5,
        value: |m| m.tally.position.max,
    },
    Target {
        what: "position rebuilt from uv, max, same unit",
        limit: |shape, _| if shape == "patch" { 1.5 } else { 4.0 },
        value: |m| m.tally.rebuilt.max,
    },
    Target {
        what: "normal error, max, degrees",
        limit: normal_limit,
        value: |m| m.tally.normal.max,
    },
    Target {
        what: "hits outside of their error bound",
        limit: |_, _| 0.0,
        value: |m| m.tally.bounds_broken as f64,
    },
    Target {
        what: "rays on which the three queries differ",
        limit: |_, _| 0.0,
        value: |m| m.tally.queries_differ as f64,
    },
    Target {
        what: "safe offset, max, 2⁻²⁴ max(|o|, |p|)",
        limit: |shape, _| if shape == "patch" { 16.0 } else { 2.0 },
        value: |m| m.leaving.offset_max.into(),
    },
    Target {
        what: "safe offset, p99, same unit",
        limit: |shape, _| if shape == "patch" { 4.0 } else { 2.0 },
        value: |m| m.leaving.offset_p99.into(),
    },
    Target {
        what: "self-hits after leave_surface",
        limit: |_, _| 0.0,
        value: |m| m.leaving.left_badly as f64,
    },
];

fn normal_limit(shape: &str, row: &RowResult) -> f64 {
    match (shape, row.family, row.level) {
        ("cone", "long and thin", level) if level >= 1e5 => 1e-2,
        // Interpolates the limits of 1e3 and 1e5 on a logarithmic scale.
        ("cone", "long and thin", level) if level > 1e3 => 3e-4,
        ("patch", "sliver", _) => 1e-2,
        ("patch", "bow tie", _) => 0.05,
        // On a ray along a ruling the point of the hit is not defined.
        ("patch", "parallel to a ruling", 0.0) => f64::INFINITY,
        ("patch", ..) => 2e-5,
        _ => 1e-5,
    }
}

/// Shape, published method, and the largest allowed ratio of our time to that of the method.
const TIMES: &[(&str, &str, f64)] = &[
    ("sphere", "textbook", 1.5),
    ("sphere", "Haines et al.", 1.1),
    ("cone", "round line (Embree)", 1.2),
    ("cone", "Quilez with uv", 0.8),
    ("patch", "Cool Patches", 1.3),
    ("patch", "two triangles", 1.5),
];

/// Evaluates all targets of all shapes in the study.
pub(crate) fn verdicts(study: &Study) -> Vec<Verdict> {
    study
        .shapes
        .iter()
        .flat_map(|shape| {
            let of_rows = TARGETS.iter().filter_map(|target| of_rows(shape, target));
            of_rows.chain(of_joints(shape)).chain(of_times(shape)).collect::<Vec<_>>()
        })
        .collect()
}

fn of_rows(shape: &ShapeResult, target: &Target) -> Option<Verdict> {
    let mut worst: Option<f64> = None;
    let mut misses = Vec::new();
    let mut limits = Vec::new();
    for row in &shape.rows {
        let limit = (target.limit)(shape.shape, row);
        for result in row.methods.iter().filter(|m| m.own) {
            let value = (target.value)(result);
            limits.push(limit);
            if limit.is_finite() {
                worst = Some(worst.map_or(value, |w| w.max(value)));
            }
            if value.is_nan() || value > limit {
                misses.push(format!(
                    "{}: {} where {} is allowed",
                    row.label,
                    short(value),
                    short(limit)
                ));
            }
        }
    }
    let usual = limits.iter().copied().fold(f64::INFINITY, f64::min);
    let (what, limit, met) = (target.what, short(usual), misses.is_empty());
    Some(Verdict { shape: shape.shape, what, limit, worst: worst?, met, misses })
}

fn of_joints(shape: &ShapeResult) -> Option<Verdict> {
    let own: Vec<_> = shape
        .joints
        .iter()
        .filter(|j| shape.rows[0].methods.iter().any(|m| m.own && m.method == j.method))
        .collect();
    let misses: Vec<String> = own
        .iter()
        .filter(|j| j.leaks + j.doubles > 0)
        .map(|j| {
            format!("{}: {} leaks, {} doubles of {} rays", j.place, j.leaks, j.doubles, j.rays)
        })
        .collect();
    let worst = own.iter().map(|j| j.leaks + j.doubles).sum::<usize>() as f64;
    (!own.is_empty()).then(|| Verdict {
        shape: shape.shape,
        what: "leaks and doubles where shapes meet",
        limit: "0".to_owned(),
        worst,
        met: misses.is_empty(),
        misses,
    })
}

fn of_times(shape: &ShapeResult) -> Vec<Verdict> {
    let own = shape.rows[0].methods.iter().find(|m| m.own).map(|m| m.method);
    let own = own.and_then(|name| shape.timing(name));
    let verdict = |&(_, other, limit): &(&str, &'static str, f64)| {
        let (own, peer) = (own?, shape.timing(other)?);
        let ratio = own.mixed.median / peer.mixed.median;
        let fresh = own.fresh.median / peer.fresh.median;
        let met = ratio <= limit;
        let misses = if met {
            vec![]
        } else {
            vec![format!(
                "{ratio:.2} times {other} where {limit} is allowed ({fresh:.2} times on fresh rays)"
            )]
        };
        Some(Verdict {
            shape: shape.shape,
            what: other,
            limit: format!("{limit} x"),
            worst: ratio,
            met,
            misses,
        })
    };
    TIMES.iter().filter(|(name, ..)| *name == shape.shape).filter_map(verdict).collect()
}

/// Formats a number with about three digits, whatever its magnitude.
pub(crate) fn short(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else if !value.is_finite() {
        format!("{value}")
    } else if value.abs() >= 1e5 || value.abs() < 1e-2 {
        format!("{value:.1e}")
    } else if value.fract() == 0.0 || value.abs() >= 100.0 {
        format!("{value:.0}")
    } else {
        format!("{value:.2}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::{
        progress::Progress,
        study::{self, Options},
    };

    #[test]
    fn a_planted_miss_of_a_target_names_its_row() {
        let options = Options {
            shapes: vec!["sphere".into()],
            families: vec!["grazing".into()],
            methods: vec!["Rotund".into(), "textbook".into()],
            rays: 200,
            seed: 1,
            timing: false,
        };
        let mut study = study::run(&options, &Progress::hidden());
        assert!(verdicts(&study).iter().all(|v| v.met), "{:#?}", verdicts(&study));

        // Plants the results of the textbook's method under our name.
        for row in &mut study.shapes[0].rows {
            let textbook = row.methods.pop().expect("two methods");
            row.methods[0].tally = textbook.tally;
        }
        let missed: Vec<_> = verdicts(&study).into_iter().filter(|v| !v.met).collect();
        let t = missed.iter().find(|v| v.what.starts_with("t error")).expect("t misses");
        assert!(t.misses.iter().any(|miss| miss.starts_with("grazing 1e-5: ")), "{t:?}");
        assert!(missed.iter().any(|v| v.what.starts_with("false misses")), "{missed:?}");
    }

    #[test]
    fn short_numbers_keep_three_digits() {
        for (value, text) in [
            (0.0, "0"),
            (3.0, "3"),
            (0.123_4, "0.12"),
            (123.4, "123"),
            (1.5e7, "1.5e7"),
            (1e-5, "1.0e-5"),
        ] {
            assert_eq!(short(value), text);
        }
    }
}
