//! The command line of `rotund render` that makes a picture of the viewer.

use crate::kinds::Kind;
use rotund_trace::{Options, Sequence, View};
use rotund_viewer::{CameraText, OverlapChoice, Settings, Snapshot};

/// Returns the kinds that are traced exactly.
pub(super) fn kinds(settings: &Settings) -> Vec<Kind> {
    let Settings { points, lines, quads, .. } = *settings;
    let all = [(points, Kind::Points), (lines, Kind::Lines), (quads, Kind::Quads)];
    all.into_iter().filter_map(|(exact, kind)| exact.then_some(kind)).collect()
}

/// Returns the options that make this picture, quoted for a shell; those that are the default are
/// left out. `is_lone`: the scene is the file of a shape by itself, whose floor is shown.
pub(super) fn arguments(snapshot: &Snapshot, is_lone: bool) -> String {
    let Snapshot { ref options, ref settings, .. } = *snapshot;
    let Options { width, height, bounces, seed, ref sequence, view, clamp, transparent, .. } =
        *options;
    let usual = Options::default();
    let camera = serde_json::to_string(&CameraText::from(&snapshot.camera));
    let camera = camera.expect("a camera has a JSON form");
    let mut words = vec![format!("--camera {}", quote(&camera))];
    let mut add = |is_needed: bool, text: String| words.extend(is_needed.then_some(text));
    add(true, format!("--resolution {}", width.max(height)));
    add(true, format!("--samples {}", settings.samples));
    add(bounces != usual.bounces, format!("--bounces {bounces}"));
    add(seed != usual.seed, format!("--seed {seed}"));
    add(*sequence == Sequence::Independent, "--sampler independent".to_owned());
    if let Some(clamp) = clamp {
        add(true, format!("--clamp {clamp}"));
    }
    let names: Vec<_> = kinds(settings).into_iter().map(Kind::name).collect();
    match names.len() {
        0 => add(true, "--mode vanilla".to_owned()),
        count => add(count < 3, format!("--kinds {}", names.join(","))),
    }
    match settings.overlap {
        OverlapChoice::Scene => {}
        OverlapChoice::Union => add(true, "--overlap union".to_owned()),
        OverlapChoice::Separate => add(true, "--overlap separate".to_owned()),
    }
    add(view != View::default(), format!("--view {view}"));
    add(transparent, "--transparent".to_owned());
    add(transparent && is_lone, "--floor".to_owned());
    add(settings.denoise, "--denoise".to_owned());
    words.join(" ")
}

/// Quotes a word for a POSIX shell, if it needs that.
pub(super) fn quote(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::quote;

    #[test]
    fn a_shell_reads_a_quoted_word_as_it_was() {
        let table = [
            ("plain", "--samples", "--samples"),
            ("a space", "my scene.json", "'my scene.json'"),
            ("JSON", r#"{"lens": 1}"#, r#"'{"lens": 1}'"#),
            ("a quote", "it's", r"'it'\''s'"),
            ("a substitution", "$(touch x)", "'$(touch x)'"),
            ("nothing", "", "''"),
        ];
        for (why, word, expected) in table {
            assert_eq!(quote(word), expected, "{why}");
        }
    }
}
