//! Runs all methods over the families and the joints, times them, and holds the results.

use std::collections::BTreeMap;

use rayon::prelude::*;
use rotund_geometry::{BilinearPatch, RoundedCone, Sphere};
use serde::Serialize;

use super::{
    leaving::{Leaving, LeavingCollector},
    methods::{Measured, Method},
    progress::Progress,
    sheets::{self, Joints},
    tally::{Collector, Tally},
    timing::{self, Timing},
};
use crate::families::{Curve, Row, rows};
use crate::random::Random;
use crate::truth::Truth;

/// How many hits of a row send out rays.
const LEAVING_HITS: usize = 300;

/// Rays aimed at each kind of joint, as a multiple of the rays of a row.
const JOINT_RAYS: u64 = 25;

/// What is measured.
#[derive(Clone, Debug)]
pub(crate) struct Options {
    /// Parts of the names of shapes; all are measured if it is empty. The next two work alike.
    pub(crate) shapes: Vec<String>,
    pub(crate) families: Vec<String>,
    pub(crate) methods: Vec<String>,
    /// Rays in each row.
    pub(crate) rays: u64,
    pub(crate) seed: u64,
    pub(crate) timing: bool,
}

/// Results of one method on one row.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct MethodResult {
    pub(crate) method: &'static str,
    pub(crate) own: bool,
    pub(crate) approximate: bool,
    pub(crate) tally: Tally,
    pub(crate) leaving: Leaving,
}

/// Results of one row, which is a family at a level.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct RowResult {
    pub(crate) family: &'static str,
    pub(crate) level: f64,
    pub(crate) label: String,
    pub(crate) why: &'static str,
    /// `distance` or `grazing`, if the level is the abscissa of a curve.
    pub(crate) curve: Option<&'static str>,
    pub(crate) methods: Vec<MethodResult>,
}

/// All results of one shape.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ShapeResult {
    pub(crate) shape: &'static str,
    pub(crate) rows: Vec<RowResult>,
    pub(crate) joints: Vec<Joints>,
    pub(crate) timings: Vec<Timing>,
}

/// All results.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Study {
    pub(crate) seed: u64,
    pub(crate) rays: u64,
    pub(crate) shapes: Vec<ShapeResult>,
}

impl Options {
    fn has(filter: &[String], name: &str) -> bool {
        let name = name.to_lowercase();
        filter.is_empty() || filter.iter().any(|part| name.contains(&part.to_lowercase()))
    }

    pub(crate) fn rows<S: Measured>(&self) -> Vec<Row<S>> {
        if !Self::has(&self.shapes, S::NAME) {
            return Vec::new();
        }
        rows::<S>().filter(|row| Self::has(&self.families, &row.label())).collect()
    }

    pub(crate) fn methods<S: Measured>(&self) -> Vec<&'static Method<S>> {
        if !Self::has(&self.shapes, S::NAME) {
            return Vec::new();
        }
        S::METHODS.iter().filter(|method| Self::has(&self.methods, method.name)).collect()
    }

    /// Returns the names of all rows of all shapes.
    pub(crate) fn all_rows() -> Vec<String> {
        fn names<S: Measured>() -> impl Iterator<Item = String> {
            rows::<S>().map(|row| format!("  {}: {}", S::NAME, row.label()))
        }
        names::<Sphere>().chain(names::<RoundedCone>()).chain(names::<BilinearPatch>()).collect()
    }

    /// Returns the names of all methods of the selected shapes.
    pub(crate) fn all_methods(&self) -> Vec<&'static str> {
        fn names<S: Measured>(shapes: &[String]) -> impl Iterator<Item = &'static str> {
            let asked = Options::has(shapes, S::NAME);
            S::METHODS.iter().filter(move |_| asked).map(|method| method.name)
        }
        let mut all: Vec<&str> = names::<Sphere>(&self.shapes)
            .chain(names::<RoundedCone>(&self.shapes))
            .chain(names::<BilinearPatch>(&self.shapes))
            .collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Returns how many rows are selected.
    pub(crate) fn row_count(&self) -> usize {
        self.rows::<Sphere>().len()
            + self.rows::<RoundedCone>().len()
            + self.rows::<BilinearPatch>().len()
    }
}

/// Measures all that is selected; `progress` counts rows.
pub(crate) fn run(options: &Options, progress: &Progress) -> Study {
    let mut shapes = Vec::new();
    shapes.extend(shape::<Sphere>(options, progress, |_| Vec::new()));
    shapes.extend(shape::<RoundedCone>(options, progress, |methods| {
        sheets::chains(methods, options.rays * JOINT_RAYS, options.seed)
    }));
    shapes.extend(shape::<BilinearPatch>(options, progress, |methods| {
        sheets::sheets(methods, options.rays * JOINT_RAYS, options.seed)
    }));
    Study { seed: options.seed, rays: options.rays, shapes }
}

fn shape<S: Measured>(
    options: &Options,
    progress: &Progress,
    joints: impl FnOnce(&[&Method<S>]) -> Vec<Joints>,
) -> Option<ShapeResult> {
    let (rows, methods) = (options.rows::<S>(), options.methods::<S>());
    if rows.is_empty() || methods.is_empty() {
        return None;
    }
    let results = rows
        .par_iter()
        .map(|row| {
            let result = measure(row, &methods, options);
            progress.row();
            result
        })
        .collect();
    // Joints belong to no family, so a selection of families leaves them out.
    let joints = if options.families.is_empty() { joints(&methods) } else { Vec::new() };
    let timings = if options.timing { timing::time(&methods, options.seed) } else { Vec::new() };
    progress.shape(S::NAME, rows.len());
    Some(ShapeResult { shape: S::NAME, rows: results, joints, timings })
}

fn measure<S: Measured>(row: &Row<S>, methods: &[&Method<S>], options: &Options) -> RowResult {
    let name = row.name();
    let mut collectors: Vec<(Collector, LeavingCollector)> =
        methods.iter().map(|_| Default::default()).collect();
    for index in 0..options.rays {
        let random = &mut Random::of(options.seed, &name, index);
        let (shape, ray) = row.generate(random);
        let truth = Truth::of(&shape, &ray);
        for (method, (tally, leaving)) in methods.iter().zip(&mut collectors) {
            let right = tally.add(method, &shape, &ray, &truth);
            if let Some(hit) = right
                && !method.approximate
                && leaving.len() < LEAVING_HITS
            {
                leaving.add(method, &shape, &ray, &hit, &truth, &mut random.clone());
            }
        }
    }
    let methods = methods
        .iter()
        .zip(collectors)
        .map(|(method, (tally, leaving))| MethodResult {
            method: method.name,
            own: method.own,
            approximate: method.approximate,
            tally: tally.finish(),
            leaving: leaving.finish(),
        })
        .collect();
    RowResult {
        family: row.family.name,
        level: row.level,
        label: row.label(),
        why: row.family.why,
        curve: row.family.curve.map(|curve| match curve {
            Curve::Distance => "distance",
            Curve::Grazing => "grazing",
        }),
        methods,
    }
}

/// Sums and extremes of one method over all rows of its shape.
#[derive(Clone, Debug, Default)]
pub(crate) struct Summary {
    pub(crate) own: bool,
    pub(crate) approximate: bool,
    pub(crate) true_hits: usize,
    pub(crate) true_misses: usize,
    pub(crate) false_misses: usize,
    pub(crate) false_hits: usize,
    pub(crate) wrong_roots: usize,
    pub(crate) rows_with_errors: usize,
    pub(crate) invalid: usize,
    /// 99th percentile and maximum, each of the worst row.
    pub(crate) t: (f64, f64),
    pub(crate) position: (f64, f64),
    pub(crate) on_ray: (f64, f64),
    pub(crate) rebuilt: (f64, f64),
    pub(crate) normal: (f64, f64),
    pub(crate) offset_max: u32,
}

impl ShapeResult {
    /// Returns the methods in the order of the table, each with its summary.
    pub(crate) fn summaries(&self) -> Vec<(&'static str, Summary)> {
        let mut order = Vec::new();
        let mut sums: BTreeMap<&str, Summary> = BTreeMap::new();
        for result in self.rows.iter().flat_map(|row| &row.methods) {
            if !order.contains(&result.method) {
                order.push(result.method);
            }
            let sum = sums.entry(result.method).or_default();
            let tally = &result.tally;
            (sum.own, sum.approximate) = (result.own, result.approximate);
            sum.true_hits += tally.true_hits;
            sum.true_misses += tally.true_misses;
            sum.false_misses += tally.false_misses;
            sum.false_hits += tally.false_hits;
            sum.wrong_roots += tally.wrong_roots;
            sum.invalid += tally.invalid;
            sum.rows_with_errors += usize::from(tally.false_results() > 0);
            for (sum, spread) in [
                (&mut sum.t, tally.t),
                (&mut sum.position, tally.position),
                (&mut sum.on_ray, tally.on_ray),
                (&mut sum.rebuilt, tally.rebuilt),
                (&mut sum.normal, tally.normal),
            ] {
                *sum = (sum.0.max(spread.p99), sum.1.max(spread.max));
            }
            sum.offset_max = sum.offset_max.max(result.leaving.offset_max);
        }
        order.into_iter().filter_map(|name| Some((name, sums.remove(name)?))).collect()
    }

    /// Returns the times of a method.
    pub(crate) fn timing(&self, method: &str) -> Option<&Timing> {
        self.timings.iter().find(|timing| timing.method == method)
    }
}
