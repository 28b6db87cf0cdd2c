//! Words that belong in few places: unsafe code, files, arguments, threads, JSON.

use std::path::{Path, PathBuf};

/// A word that the code in a folder must not contain, except for a few files.
struct Rule {
    folder: &'static str,
    word: &'static str,
    except: &'static [&'static str],
    why: &'static str,
}

/// The part of `ARCHITECTURE.md` that a search for words can check.
const RULES: [Rule; 8] = [
    Rule {
        folder: "crates",
        word: "unsafe_code",
        except: &[
            "crates/bvh/src/huge_pages.rs",
            "crates/bvh/src/simd/x86.rs",
            "crates/bvh/src/stack.rs",
            "crates/bvh/src/traverse.rs",
            "crates/denoise/src/library.rs",
            "crates/geometry/src/f64x2.rs",
            "crates/geometry/src/next_float.rs",
        ],
        why: "unsafe code stays in few small modules",
    },
    Rule {
        folder: "crates",
        word: "fs::",
        except: &[
            "crates/browser/src/",
            "crates/golden/src/case.rs",
            "crates/golden/src/suite.rs",
            "crates/image/src/codec/file.rs",
            "crates/image/src/codec/replace.rs",
            "crates/rotund/src/built_in.rs",
            "crates/rotund/src/cancel.rs",
            "crates/rotund/src/golden.rs",
            "crates/rotund/src/info.rs",
            "crates/rotund/src/memory.rs",
            "crates/rotund/src/output.rs",
            "crates/scene/src/load/",
            "crates/study/src/accuracy/mod.rs",
            "crates/study/src/rays/memory.rs",
            "crates/tidy/src/files.rs",
            "crates/tidy/src/scenes.rs",
            "crates/trace/src/output/checkpoint.rs",
            "crates/viewer/src/watch.rs",
        ],
        why: "only loaders, writers and commands touch files",
    },
    Rule {
        folder: "crates",
        word: "env::args",
        except: &["crates/rotund/src/main.rs"],
        why: "only programs read arguments",
    },
    Rule {
        folder: "crates",
        word: "process::exit",
        except: &["crates/rotund/src/cancel.rs"],
        why: "only programs exit",
    },
    Rule {
        folder: "crates/geometry",
        word: "Vec<",
        except: &[],
        why: "geometry allocates nothing",
    },
    Rule {
        folder: "crates/geometry",
        word: "rayon",
        except: &[],
        why: "geometry knows no threads",
    },
    Rule { folder: "crates/bvh", word: "rotund_scene", except: &[], why: "a tree knows no scene" },
    Rule { folder: "crates/trace", word: "serde_json", except: &[], why: "only scene reads JSON" },
];

/// Checks one file. Comments and the tests at the end may contain anything.
pub(crate) fn check(path: &Path, text: &str) -> Vec<String> {
    let name: PathBuf = path.iter().collect();
    let name = name.to_string_lossy().replace('\\', "/");
    // The table of rules has every word in it.
    let is_table = name == "crates/tidy/src/places.rs";
    if !name.ends_with(".rs") || !name.contains("/src/") || is_table {
        return Vec::new();
    }
    let code = text.split("\nmod tests {").next().unwrap_or_default();
    let mut findings = Vec::new();
    for Rule { folder, word, except, why } in &RULES {
        let inside = name.starts_with(&format!("{folder}/"));
        if !inside || except.iter().any(|place| name.starts_with(place)) {
            continue;
        }
        for (number, line) in code.lines().enumerate() {
            if line.contains(word) && !line.trim_start().starts_with("//") {
                findings.push(format!("{name}:{}: {word} has no place here: {why}", number + 1));
            }
        }
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::check;
    use std::path::Path;

    #[test]
    fn words_are_found_where_they_do_not_belong() {
        let table = [
            ("in its place", "crates/scene/src/load/file.rs", "use std::fs::File;", 0),
            ("elsewhere", "crates/scene/src/scene.rs", "use std::fs::File;", 1),
            ("in a comment", "crates/scene/src/scene.rs", "// not fs::File", 0),
            (
                "in a test",
                "crates/geometry/src/ray.rs",
                "a\n#[cfg(test)]\nmod tests {\nVec<f32>",
                0,
            ),
            ("where anything goes", "xtask/src/lib.rs", "fs::write(); process::exit(1)", 0),
            ("unsafe code", "crates/trace/src/path.rs", "#[expect(unsafe_code)]", 1),
        ];
        for (why, path, text, count) in table {
            assert_eq!(check(Path::new(path), text).len(), count, "{why}");
        }
    }
}
