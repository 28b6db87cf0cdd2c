//! Two published statements, compared with the figures of this run.

use std::fmt::Write as _;

use rotund_geometry::{BilinearPatch, Sphere};

use crate::accuracy::{
    study::{ShapeResult, Study, Summary},
    targets::short,
    timing::Timing,
};
use crate::truth::Exact;
use rotund_report::html::escape;

pub(super) fn section(body: &mut String, study: &Study) {
    let find = |name: &str| study.shapes.iter().find(|s| s.shape == name && !s.timings.is_empty());
    body.push_str("<h2 id=\"answers\">Two published statements</h2>");
    let cool = find(BilinearPatch::NAME).and_then(cool_patches);
    let points = find(Sphere::NAME).and_then(spheres_and_points);
    if cool.is_none() && points.is_none() {
        body.push_str("<p class=\"soft\">This run did not time the methods they are about.</p>");
    }
    body.extend(cool);
    body.extend(points);
}

fn summary(shape: &ShapeResult, method: &str) -> Option<Summary> {
    shape.summaries().into_iter().find(|(name, _)| *name == method).map(|(_, sum)| sum)
}

fn verdict(holds: bool) -> &'static str {
    if holds { "holds here" } else { "does not hold here" }
}

fn cool_patches(shape: &ShapeResult) -> Option<String> {
    let own = shape.summaries().into_iter().find(|(_, s)| s.own)?.0;
    let [own, cool, ramsey, triangles] =
        [own, "Cool Patches", "Ramsey f32", "two triangles"].map(|name| shape.timing(name));
    let (own, cool, ramsey, triangles) = (own?, cool?, ramsey?, triangles?);
    let learned = |a: &Timing, b: &Timing| a.mixed.median / b.mixed.median;
    let fresh = |a: &Timing, b: &Timing| a.fresh.median / b.fresh.median;
    let mut html = format!(
        "<h3>A. Reshetov, Cool Patches, 2019</h3><blockquote>The method is 6.5 times as fast as the single-precision form of \
         Ramsey et al., and faster than two triangles.</blockquote><p>On one core of this processor, compiled from scalar code: \
         Cool Patches takes {:.1} ns, Ramsey's form in f32 {:.1} ns, two triangles {:.1} ns. <b>6.5 times as fast as Ramsey: {}</b>, \
         the ratio is {:.2} ({:.2} on rays that the processor has not seen). <b>Faster than two triangles: {}</b>, the ratio of times \
         is {:.2} ({:.2} on unseen rays).</p>",
        cool.mixed.median,
        ramsey.mixed.median,
        triangles.mixed.median,
        verdict(learned(ramsey, cool) >= 6.5),
        learned(ramsey, cool),
        fresh(ramsey, cool),
        verdict(learned(cool, triangles) < 1.0),
        learned(cool, triangles),
        fresh(cool, triangles),
    );
    let leaks = |method: &str| {
        let places: Vec<_> = shape.joints.iter().filter(|j| j.method == method).collect();
        let (lost, rays) =
            places.iter().fold((0, 0), |(l, r), j| (l + j.leaks + j.doubles, r + j.rays));
        100.0 * lost as f64 / rays.max(1) as f64
    };
    let (own_sum, cool_sum) = (summary(shape, own.method)?, summary(shape, cool.method)?);
    let _ = write!(
        html,
        "<p>The claim was made for a graphics processor, where the published code keeps all in single precision. The error it \
         buys its time with: {} % of the rays aimed at shared edges and vertices leak or hit twice, and t is off by up to {} units \
         of 2⁻²⁴ t. {} takes {:.2} times the time of Cool Patches ({:.2} on unseen rays), with {} % and {} units.</p>",
        short(leaks(cool.method)),
        short(cool_sum.t.1),
        escape(own.method),
        learned(own, cool),
        fresh(own, cool),
        short(leaks(own.method)),
        short(own_sum.t.1),
    );
    Some(html)
}

fn spheres_and_points(shape: &ShapeResult) -> Option<String> {
    let own = shape.summaries().into_iter().find(|(_, s)| s.own)?.0;
    let (own, point, textbook) =
        (shape.timing(own)?, shape.timing("vanilla point")?, shape.timing("textbook")?);
    let (own_sum, point_sum, textbook_sum) = (
        summary(shape, own.method)?,
        summary(shape, point.method)?,
        summary(shape, textbook.method)?,
    );
    let ratio =
        |a: &Timing, b: &Timing| (a.mixed.median / b.mixed.median, a.fresh.median / b.fresh.median);
    let (dearer, dearer_fresh) = ratio(own, point);
    let (book, book_fresh) = ratio(textbook, point);
    let wrong = |s: &Summary| {
        let count = s.false_misses + s.false_hits + s.wrong_roots + s.invalid;
        short(100.0 * count as f64 / (s.true_hits + s.true_misses).max(1) as f64)
    };
    Some(format!(
        "<h3>An earlier study of points and spheres</h3><blockquote>Rendering points as spheres is dearer and less accurate \
         than rendering them as points.</blockquote><p><b>Dearer: {}</b>: {} takes {:.1} ns against {:.1} ns of the vanilla point, {dearer:.2} \
         times as much ({dearer_fresh:.2} on rays that the processor has not seen); the textbook's sphere takes {book:.2} times as much \
         ({book_fresh:.2}). <b>Less accurate: {}</b>. Of the surface that both stand for, the point gives {} % of the rays of the hard \
         families a wrong hit, miss or root and the textbook's sphere {} %; {} gives {} %, a position within {} units of 2⁻²⁴ max(|p|, r) of \
         the sphere and a normal within {} degrees. What was measured as the inaccuracy of spheres is that of one formula.</p>",
        verdict(dearer > 1.05),
        escape(own.method),
        own.mixed.median,
        point.mixed.median,
        verdict(own_sum.position.1 > point_sum.position.1),
        wrong(&point_sum),
        wrong(&textbook_sum),
        escape(own.method),
        wrong(&own_sum),
        short(own_sum.position.1),
        short(own_sum.normal.1),
    ))
}
