//! The content of a page.

use super::{EqualTime, Pair, Report, Timing, fill, page};
use rotund_image::{Difference, Image};

fn example(scene: &str) -> String {
    let picture = |bright: f32| {
        Image::from_fn(200, 100, |x, _| [if (50..70).contains(&x) { bright } else { 0.2 }; 4])
    };
    let (vanilla, enhanced) = (picture(0.2), picture(0.9));
    page(&Report {
        scene,
        settings: "camera front, 200 x 100",
        pair: &Pair::METHODS,
        pictures: [&vanilla, &enhanced],
        difference: &Difference::between(&enhanced, &vanilla).unwrap(),
        equal_time: Some(EqualTime {
            faster: "vanilla",
            picture: &vanilla,
            samples: [64, 96],
            seconds: [3.0, 3.01],
            metrics: Difference::between(&enhanced, &vanilla).unwrap().metrics,
        }),
        timings: &[Timing { label: "render, s", values: [2.0, 3.0], digits: 2 }],
    })
    .unwrap()
}

#[test]
fn a_page_is_complete_and_loads_nothing() {
    let html = example("shapes4");
    assert!(html.starts_with("<!doctype html>") && html.trim_end().ends_with("</html>"));
    for wrong in ["http:", "https:", "src=\"/", "@import", "url(", "<link", "{{"] {
        assert!(!html.contains(wrong), "{wrong}");
    }
    let images = html.matches("<img ").count();
    assert_eq!(html.matches("src=\"data:image/").count(), images);
    assert!(images >= 3 + 3 + 2, "{images} images");
    assert!(html.contains("enhanced 64 samples in 3.0 s, vanilla 96 in 3.0 s"));
    assert_eq!(html.matches("<svg ").count(), 2);
    assert!(html.contains("<td>2.00</td><td>3.00</td><td>1.50</td>"));
}

#[test]
fn text_cannot_break_out_of_a_page() {
    assert!(example("<script>{{style}}").contains("<h1>&lt;script&gt;{{style}}</h1>"));
    assert_eq!(fill("{{a}}-{{b}}", &[("a", "{{b}}"), ("b", "x")]), "{{b}}-x");
}
