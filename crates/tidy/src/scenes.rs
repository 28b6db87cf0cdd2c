//! Scenes that nobody can load, nobody mentions, or whose files nobody names.

use crate::files::walk;
use anyhow::{Context, Result};
use rotund_scene::LoadOptions;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Checks the scenes for people and those of the golden pictures.
pub(crate) fn check(root: &Path, texts: &[(PathBuf, String)]) -> Result<Vec<String>> {
    let mut findings = Vec::new();
    for folder in ["scenes", "tests/golden"] {
        let files = walk(&root.join(folder))?;
        let mut named = BTreeSet::new();
        for path in files.iter().filter(|path| is_scene(path)) {
            let shown = path.strip_prefix(root)?.display();
            match rotund_scene::load(path, &LoadOptions::default()) {
                Ok(loaded) => findings.extend(loaded.warnings),
                Err(error) => findings.push(format!("{shown} cannot be loaded: {error}")),
            }
            let text = std::fs::read_to_string(path)?;
            let scene = serde_json::from_str(&text).with_context(|| format!("{shown}"))?;
            let place = path.parent().unwrap_or(root);
            named.extend(names_of_files(&scene).iter().map(|name| place.join(name)));
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            // All golden scenes are used: each makes a picture.
            if folder == "scenes" && !is_mentioned(&stem, texts) {
                findings.push(format!("{shown} is mentioned in no README and no test"));
            }
        }
        let belongs = |path: &PathBuf| {
            let extension = path.extension().unwrap_or_default();
            extension == "json" || extension == "md" || named.contains(path)
                // References have their own check: those without a scene fail the golden one.
                || (folder == "tests/golden" && extension == "exr")
        };
        for path in files.iter().filter(|path| !belongs(path)) {
            findings.push(format!("{} belongs to no scene", path.strip_prefix(root)?.display()));
        }
    }
    Ok(findings)
}

fn is_scene(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "json")
}

/// The values of all fields `uri`.
fn names_of_files(scene: &serde_json::Value) -> Vec<String> {
    match scene {
        serde_json::Value::Object(fields) => fields
            .iter()
            .flat_map(|(field, value)| match value.as_str() {
                Some(text) if field == "uri" => vec![text.to_owned()],
                _ => names_of_files(value),
            })
            .collect(),
        serde_json::Value::Array(items) => items.iter().flat_map(names_of_files).collect(),
        _ => Vec::new(),
    }
}

/// Whether a page or a test has the name as a word of its own.
fn is_mentioned(name: &str, texts: &[(PathBuf, String)]) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    texts
        .iter()
        .filter(|(path, _)| {
            path.extension().is_some_and(|e| e == "md") || path.iter().any(|part| part == "tests")
        })
        .any(|(_, text)| text.split(|c| !is_part(c)).any(|word| word == name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_are_found_at_any_depth() {
        let scene =
            serde_json::json!({"shapes": [{"uri": "a.ply"}], "textures": {"b": {"uri": "b.png"}}});
        assert_eq!(names_of_files(&scene), ["a.ply", "b.png"]);
    }

    #[test]
    fn a_name_is_mentioned_only_as_a_whole_word() {
        let mentions = |text: &str| is_mentioned("glass", &[("README.md".into(), text.into())]);
        assert!(mentions("| `glass` | tubes |"));
        assert!(!mentions("glasses and glass-tubes"));
        assert!(!is_mentioned("glass", &[("src/main.rs".into(), "glass".into())]));
    }
}
