//! `--replay`: prints one case with the truth and the answer of every method.

use super::{case::Case, methods::Measured, tally::Collector};
use crate::truth::Truth;
use anyhow::Result;
use rotund_geometry::{BilinearPatch, RoundedCone, Sphere};
use rotund_report::console::{Table, say};

/// Prints the case in decimals, the true crossings and the answer of every method.
pub(crate) fn run(case: &str) -> Result<()> {
    let case: Case = case.parse()?;
    show::<Sphere>(&case)?;
    show::<RoundedCone>(&case)?;
    show::<BilinearPatch>(&case)
}

fn show<S: Measured>(case: &Case) -> Result<()> {
    let Some((shape, ray)) = case.as_shape::<S>() else { return Ok(()) };
    say(format!("{} {:?}\n{ray:?}\n", S::NAME, shape.numbers()))?;
    let truth = Truth::of(&shape, &ray);
    let mut table = Table::new(&["truth", "t", "x", "y", "z", "normal", "uv"]);
    for (i, crossing) in truth.crossings.iter().enumerate() {
        let point = crossing.point.to_f64();
        table.row([
            if truth.hit == Some(i) { "the hit" } else { "crossing" }.to_owned(),
            format!("{:.17e}", crossing.t.to_f64()),
            format!("{:.17e}", point.x),
            format!("{:.17e}", point.y),
            format!("{:.17e}", point.z),
            format!("{:.9}", crossing.normal),
            crossing.uv.map_or(String::new(), |uv| format!("{uv:.9}")),
        ]);
    }
    say(format!("{table}\n"))?;
    if truth.hit.is_none() {
        say("truth: a miss\n")?;
    }
    if truth.either {
        say(
            "A crossing lies at an end of the interval, or the ray is tangent: both answers are correct.\n",
        )?;
    }
    let mut table =
        Table::new(&["method", "verdict", "t", "t error", "position error", "normal error, deg"]);
    for method in S::METHODS {
        let mut collector = Collector::default();
        let right = collector.add(method, &shape, &ray, &truth);
        let tally = collector.finish();
        let answer = (method.closest)(&shape, &ray);
        let verdict = match (tally.worst.first().map(|w| w.what), answer, right) {
            (_, _, Some(_)) => "hit",
            (None, None, _) => "miss",
            (Some(what), _, _) => what,
            (None, Some(_), None) => "hit beside a tie",
        };
        let number = |value: f64| right.map_or(String::new(), |_| format!("{value:.3e}"));
        table.row([
            method.name.to_owned(),
            verdict.to_owned(),
            answer.map_or("-".to_owned(), |hit| format!("{:e}", hit.t)),
            number(tally.t.max),
            number(tally.position.max),
            number(tally.normal.max),
        ]);
    }
    say(format!("{table}\n\nt error in units of 2^-24 t, position error of 2^-24 max(|p|, size)"))
}
