//! The report: one HTML file that opens offline.

mod answers;
mod heat;
mod shape;

use std::fmt::Write as _;

use anyhow::Result;
use rotund_geometry::{BilinearPatch, RoundedCone, Sphere};

use super::{
    study::{Options, Study},
    targets::{Verdict, short},
    timing::unsteady,
};
use crate::truth::Exact;
use rotund_report::html::{self, escape};

/// Writes the page.
pub(super) fn page(study: &Study, verdicts: &[Verdict], options: &Options) -> Result<String> {
    let mut body = String::new();
    let met = verdicts.iter().filter(|v| v.met).count();
    let links: String = study
        .shapes
        .iter()
        .map(|s| format!("<a href=\"#{0}\">{1}</a>", s.shape, heading(s.shape)))
        .collect();
    let _ = write!(
        body,
        "<h1>Speed against error</h1><p class=\"soft\">Ray intersection of a sphere, a rounded cone and a bilinear \
         patch: Rotund {}, the usual approximations, and published methods. Seed {}, {} rays for each family \
         and level. Target: {}.</p><nav><a href=\"#targets\">Targets: {met} of {} met</a>{links}\
         <a href=\"#answers\">Two published statements</a><a href=\"#how\">How it is measured</a></nav>",
        env!("CARGO_PKG_VERSION"),
        study.seed,
        study.rays,
        target_processor(),
        verdicts.len(),
    );
    if study.shapes.iter().any(|shape| unsteady(&shape.timings)) {
        body.push_str(
            "<p class=\"bad\">The times of this run are unsteady: something else was running. Do not compare them.</p>",
        );
    }
    targets(&mut body, verdicts);
    for result in &study.shapes {
        let _ = write!(body, "<h2 id=\"{}\">{}</h2>", result.shape, heading(result.shape));
        shape::section(&mut body, result);
        match result.shape {
            Sphere::NAME => shape::heat_maps::<Sphere>(&mut body, options)?,
            RoundedCone::NAME => shape::heat_maps::<RoundedCone>(&mut body, options)?,
            _ => shape::heat_maps::<BilinearPatch>(&mut body, options)?,
        }
        shape::details(&mut body, result, study);
    }
    answers::section(&mut body, study);
    body += include_str!("how.html");
    Ok(html::page("Rotund: speed against error", "", &body))
}

fn heading(shape: &str) -> &'static str {
    match shape {
        Sphere::NAME => "Sphere",
        RoundedCone::NAME => "Rounded cone",
        _ => "Bilinear patch",
    }
}

/// Names the target of the build, which decides about fused multiply-add and wide registers.
fn target_processor() -> String {
    let features = [
        ("AVX-512", cfg!(target_feature = "avx512f")),
        ("AVX2", cfg!(target_feature = "avx2")),
        ("FMA", cfg!(target_feature = "fma")),
    ];
    let features: Vec<&str> = features.iter().filter(|(_, has)| *has).map(|(f, _)| *f).collect();
    let with = if features.is_empty() {
        "baseline".to_owned()
    } else {
        format!("with {}", features.join(", "))
    };
    format!("{} on {}, {with}", std::env::consts::ARCH, std::env::consts::OS)
}

fn targets(body: &mut String, verdicts: &[Verdict]) {
    let _ = write!(
        body,
        "<h2 id=\"targets\">Targets of the library's own methods</h2><div class=\"scroll\"><table><tr>\
         <th>shape</th><th class=\"left\">target</th><th>limit</th><th>worst row</th><th>met</th><th class=\"left\">rows that miss it</th></tr>"
    );
    for verdict in verdicts {
        let what = if verdict.limit.ends_with('x') {
            format!("time against {}", verdict.what)
        } else {
            verdict.what.to_owned()
        };
        let (class, word) = if verdict.met { ("good", "yes") } else { ("bad", "no") };
        let _ = write!(
            body,
            "<tr><td>{}</td><td class=\"left\">{}</td><td>{}</td><td>{}</td><td class=\"{class}\">{word}</td>\
             <td class=\"left wide\">{}</td></tr>",
            verdict.shape,
            escape(&what),
            escape(&verdict.limit),
            short(verdict.worst),
            escape(&verdict.misses.join("; ")),
        );
    }
    body.push_str("</table></div>");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::{progress::Progress, study, targets::verdicts};

    #[test]
    fn a_report_is_one_page_with_charts_maps_and_cases_that_replay() {
        let options = Options {
            shapes: vec!["sphere".into()],
            families: vec!["distance".into(), "grazing".into()],
            methods: vec![],
            rays: 20,
            seed: 1,
            timing: false,
        };
        let study = study::run(&options, &Progress::hidden());
        let html = page(&study, &verdicts(&study), &options).expect("a page");
        assert!(!html.contains("http://") && !html.contains("https://"), "it needs no network");
        // The text between the pictures, whose letters are arbitrary.
        let text: String =
            html.split("base64,").map(|part| part.split_once('"').map_or(part, |p| p.1)).collect();
        assert!(!text.contains("NaN"), "no number is missing");
        assert!(html.matches("<svg").count() >= 8, "curves over distance and grazing");
        assert!(html.matches("data:image/png").count() >= 10, "two maps for each method");
        let case =
            html.split("\"case\"><code>").nth(1).and_then(|c| c.split('<').next()).expect("a case");
        assert!(case.parse::<crate::accuracy::case::Case>().is_ok(), "{case}");
        for tag in ["table", "tr", "td", "svg", "figure", "details", "div", "p"] {
            let open = html.matches(&format!("<{tag}>")).count()
                + html.matches(&format!("<{tag} ")).count();
            assert_eq!(open, html.matches(&format!("</{tag}>")).count(), "<{tag}> is closed");
        }
    }
}
