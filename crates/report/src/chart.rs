//! Charts in SVG with logarithmic axes, direct labels, and one color for each series.

use crate::html::escape;
use std::fmt::Write as _;

/// Colors that are distinct for any color vision, after M. Okabe and K. Ito. The first is for the
/// library's own methods.
const COLORS: [&str; 8] =
    ["#0072b2", "#8a8f98", "#e69f00", "#cc79a7", "#009e73", "#d55e00", "#56b4e9", "#b8a900"];

/// Returns the color of the series at `index`; the colors repeat after the eighth.
#[must_use]
pub fn color(index: usize) -> &'static str {
    COLORS[index % COLORS.len()]
}

/// A named curve, or the points of a method in a scatter chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Color in CSS, see [`color`].
    pub color: &'static str,
    /// True for a method that solves an approximate problem: it is drawn dashed or hollow.
    pub approximate: bool,
    /// Abscissas and ordinates, which must be positive to be visible on logarithmic axes.
    pub points: Vec<(f64, f64)>,
}

/// Title and axis labels of a chart.
#[derive(Clone, Copy, Debug)]
pub struct Labels<'a> {
    /// Title above the chart.
    pub title: &'a str,
    /// Label of the horizontal axis.
    pub x: &'a str,
    /// Label of the vertical axis.
    pub y: &'a str,
}

/// The inner area of the drawing.
struct Frame {
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
    x: (f64, f64),
    y: (f64, f64),
}

/// Distance in pixels up to which a tick counts as the floor of the chart, whose label is 0.
const FLOOR_ROOM: f64 = 0.9;

impl Frame {
    fn px(&self, x: f64) -> f64 {
        let (from, to, x) = (self.x.0.log10(), self.x.1.log10(), x.log10());
        self.left + (x - from) / (to - from) * (self.right - self.left)
    }

    fn py(&self, y: f64) -> f64 {
        let (from, to) = (self.y.0.log10(), self.y.1.log10());
        let y = if y.is_nan() { self.y.1 } else { y.clamp(self.y.0, self.y.1) };
        self.bottom - (y.log10() - from) / (to - from) * (self.bottom - self.top)
    }
}

/// Draws a chart with one line for each series. Values at or below `floor` are drawn on the floor,
/// whose label is 0.
#[must_use]
pub fn curves(labels: &Labels<'_>, series: &[Series], floor: Option<f64>) -> String {
    let (width, height) = (325.0, 250.0);
    let frame = Frame {
        left: 54.0,
        top: 30.0,
        right: width - 12.0,
        bottom: height - 40.0,
        x: range(series.iter().flat_map(|s| &s.points).map(|p| p.0), None),
        y: range(series.iter().flat_map(|s| &s.points).map(|p| p.1), floor),
    };
    let mut svg = open(labels, width, height);
    axes(&mut svg, &frame, labels, floor.is_some());
    for s in series.iter().rev() {
        let path: Vec<String> = s
            .points
            .iter()
            .map(|&(x, y)| format!("{:.1},{:.1}", frame.px(x), frame.py(y)))
            .collect();
        let dash = if s.approximate { " stroke-dasharray=\"4 3\"" } else { "" };
        let wide = if s.color == COLORS[0] { 3 } else { 2 };
        let _ = write!(
            svg,
            "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{wide}\"{dash} points=\"{}\">\
             <title>{}</title></polyline>",
            s.color,
            path.join(" "),
            escape(&s.name)
        );
    }
    svg + "</svg>"
}

/// Draws a scatter chart of time against error, with the Pareto front: the points that no other
/// point beats in both. Errors at or below `floor` are drawn on the floor, whose label is 0.
#[must_use]
pub fn scatter(labels: &Labels<'_>, series: &[Series], floor: f64) -> String {
    let (width, height) = (660.0, 360.0);
    let points: Vec<(f64, f64)> = series.iter().flat_map(|s| s.points.clone()).collect();
    let frame = Frame {
        left: 60.0,
        top: 30.0,
        right: width - 110.0,
        bottom: height - 44.0,
        x: around(points.iter().map(|p| p.0)),
        y: range(points.iter().map(|p| p.1), Some(floor)),
    };
    let mut svg = open(labels, width, height);
    axes(&mut svg, &frame, labels, true);
    let front: String = front(&points)
        .iter()
        .scan(None::<f64>, |above, &(x, y)| {
            // A step: the lower error of a point is available from its time on.
            let step = above.map(|y| format!("{:.1},{:.1} ", frame.px(x), frame.py(y)));
            *above = Some(y);
            Some(format!("{}{:.1},{:.1} ", step.unwrap_or_default(), frame.px(x), frame.py(y)))
        })
        .collect();
    let _ = write!(svg, "<polyline class=\"front\" points=\"{front}\"/>");
    let dots: Vec<(f64, f64)> = points.iter().map(|&(x, y)| (frame.px(x), frame.py(y))).collect();
    let mut labels: Vec<Area> = dots.iter().map(|&(x, y)| Area::around(x, y)).collect();
    for (s, &(x, y)) in series.iter().flat_map(|s| s.points.iter().map(move |p| (s, p))) {
        let (px, py) = (frame.px(x), frame.py(y));
        let fill = if s.approximate { "none" } else { s.color };
        let _ = write!(
            svg,
            "<circle cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"6\" fill=\"{fill}\" stroke=\"{}\" \
             stroke-width=\"2\"><title>{}: {x:.1} ns, {y:.3e}</title></circle>",
            s.color,
            escape(&s.name)
        );
        // The label takes the first free place. Without one, only the legend names the point.
        let length = 5.8 * s.name.chars().count() as f64;
        let places =
            [(10.0, 4.0), (-10.0 - length, 4.0), (-0.5 * length, -11.0), (-0.5 * length, 20.0)];
        let free =
            places.into_iter().map(|(x, y)| Area::text(px + x, py + y, length)).find(|area| {
                area.left > frame.left && !labels.iter().any(|taken| taken.overlaps(area))
            });
        if let Some(area) = free {
            let (x, y, name) = (area.left, area.bottom - 2.0, escape(&s.name));
            let _ = write!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" class=\"label\">{name}</text>");
            labels.push(area);
        }
    }
    svg + "</svg>"
}

/// A rectangle of the drawing that is taken by a dot or a label.
struct Area {
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

impl Area {
    fn around(x: f64, y: f64) -> Self {
        Self { left: x - 8.0, top: y - 8.0, right: x + 8.0, bottom: y + 8.0 }
    }

    /// Returns the area of a label whose baseline starts at `x`, `y`.
    fn text(x: f64, y: f64, length: f64) -> Self {
        Self { left: x, top: y - 9.0, right: x + length, bottom: y + 2.0 }
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }
}

/// Returns the points that no other point beats in both coordinates, sorted by the first.
fn front(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut best = f64::INFINITY;
    sorted.retain(|p| {
        let better = p.1 < best;
        best = best.min(p.1);
        better
    });
    sorted
}

/// Returns the legend: the color and name of each series.
#[must_use]
pub fn legend(series: &[Series]) -> String {
    let mut html = "<p class=\"legend\">".to_owned();
    for s in series {
        let style = if s.approximate { "dashed" } else { "solid" };
        let _ = write!(
            html,
            "<span><i style=\"border-top:3px {style} {}\"></i>{}</span>",
            s.color,
            escape(&s.name)
        );
    }
    html + "</p>"
}

fn open(labels: &Labels<'_>, width: f64, height: f64) -> String {
    format!(
        "<svg viewBox=\"0 0 {width} {height}\" width=\"{width}\" role=\"img\" \
         aria-label=\"{0}\"><text x=\"8\" y=\"17\" class=\"title\">{0}</text>",
        escape(labels.title)
    )
}

/// Returns the decades that hold the values. With a floor, the axis starts there.
fn range(values: impl Iterator<Item = f64>, floor: Option<f64>) -> (f64, f64) {
    let values: Vec<f64> = values.filter(|v| *v > 0.0 && v.is_finite()).collect();
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(floor.unwrap_or(0.0), f64::max);
    if !most.is_finite() || most <= 0.0 {
        return (0.1, 10.0);
    }
    let low = floor.unwrap_or(10f64.powf((least.log10() + 1e-9).floor()));
    let high = 10f64.powf((most.log10() - 1e-9).ceil());
    (low, high.max(low * 10.0))
}

fn axes(svg: &mut String, frame: &Frame, labels: &Labels<'_>, from_zero: bool) {
    let Frame { left, top, right, bottom, .. } = *frame;
    let decades = |from: f64, to: f64| {
        let (from, to) = (from.log10().round() as i32, to.log10().round() as i32);
        let step = ((to - from) / 7 + 1) as usize;
        (from..=to).step_by(step)
    };
    for power in decades(frame.y.0, frame.y.1) {
        let y = frame.py(10f64.powi(power));
        let zero = from_zero && (y - bottom).abs() < FLOOR_ROOM;
        let text = if zero { "0".to_owned() } else { power_of_ten(power) };
        let _ = write!(
            svg,
            "<line x1=\"{left}\" x2=\"{right}\" y1=\"{y:.1}\" y2=\"{y:.1}\" class=\"grid\"/>\
             <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{text}</text>",
            left - 6.0,
            y + 4.0
        );
    }
    let span = (frame.x.1 / frame.x.0).log10();
    let x_ticks: Vec<(f64, String)> = if span > 2.5 {
        decades(frame.x.0, frame.x.1).map(|p| (10f64.powi(p), power_of_ten(p))).collect()
    } else {
        (-2..6)
            .flat_map(|p| [1.0, 1.5, 2.0, 3.0, 5.0, 7.0].map(|digit| digit * 10f64.powi(p)))
            .filter(|x| (frame.x.0..=frame.x.1).contains(x))
            .map(|x| (x, format!("{x}")))
            .collect()
    };
    for (x, text) in x_ticks {
        let x = frame.px(x);
        let _ = write!(
            svg,
            "<line x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{top}\" y2=\"{bottom}\" class=\"grid\"/>\
             <text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{text}</text>",
            bottom + 16.0
        );
    }
    let _ = write!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\
         <text transform=\"translate(13,{:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        0.5 * (left + right),
        bottom + 33.0,
        escape(labels.x),
        0.5 * (top + bottom),
        escape(labels.y)
    );
}

/// Returns a range that is a little wider than that of the values.
fn around(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let least = values.clone().fold(f64::INFINITY, f64::min);
    let most = values.fold(0.0, f64::max);
    if least > 0.0 && most < f64::INFINITY && least <= most {
        (least / 1.25, most * 1.25)
    } else {
        (1.0, 10.0)
    }
}

fn power_of_ten(power: i32) -> String {
    match power {
        -2..=3 => format!("{}", 10f64.powi(power)),
        _ => format!("10<tspan dy=\"-4\" font-size=\"8\">{power}</tspan>"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_holds_the_points_that_none_beats_in_both() {
        let points = [(3.0, 1.0), (1.0, 5.0), (2.0, 6.0), (4.0, 1.0), (2.5, 2.0), (1.0, 7.0)];
        assert_eq!(front(&points), [(1.0, 5.0), (2.5, 2.0), (3.0, 1.0)]);
        assert!(front(&[]).is_empty());
    }

    #[test]
    fn an_axis_covers_its_values_in_decades() {
        assert_eq!(range([3.0, 40.0].into_iter(), None), (1.0, 100.0));
        assert_eq!(range([0.0, 3e5].into_iter(), Some(0.1)), (0.1, 1e6));
        assert_eq!(range([0.0].into_iter(), Some(0.1)), (0.1, 1.0));
    }

    #[test]
    fn a_chart_names_its_methods_and_draws_no_nan() {
        let series = [Series {
            name: "<a & b>".into(),
            color: color(0),
            approximate: false,
            points: vec![(1.0, 0.0), (10.0, 1e3), (100.0, f64::INFINITY)],
        }];
        let labels = Labels { title: "t", x: "x", y: "y" };
        let charts = [
            (curves(&labels, &series, Some(0.1)), true),
            (curves(&labels, &series, None), false),
            (scatter(&labels, &series, 0.1), true),
        ];
        for (svg, from_zero) in charts {
            assert!(svg.contains("&lt;a &amp; b&gt;") && !svg.contains("NaN"), "{svg}");
            assert_eq!(svg.contains("text-anchor=\"end\">0</text>"), from_zero, "{svg}");
        }
    }
}
