//! Sizes of files and lines, and leftovers of work.

use std::path::Path;

/// A longer file has two concepts.
const MOST_LINES: usize = 500;
/// `ARCHITECTURE.md` is to be read in one go.
const MOST_LINES_OF_MAP: usize = 150;

/// What is not to stay, and why. Each is in two pieces, so that this list does not find itself.
const LEFTOVERS: [(&str, &str, &str); 12] = [
    ("to", "do!(", "is unfinished"),
    ("unimplement", "ed!(", "is unfinished"),
    ("TO", "DO", "is unfinished"),
    ("FIX", "ME", "is unfinished"),
    ("db", "g!(", "is for debugging"),
    ("#[ign", "ore", "is a test that does not run"),
    ("<<<<", "<<<", "is half a merge"),
    (">>>>", ">>>", "is half a merge"),
    ("/ho", "me/", "is a path of one machine"),
    ("/Us", "ers/", "is a path of one machine"),
    ("/wo", "rk/", "is a path of one machine"),
    ("C:", "\\", "is a path of one machine"),
];

/// Checks one file.
pub(super) fn check(path: &Path, text: &str) -> Vec<String> {
    let mut findings = Vec::new();
    let lines = text.lines().count();
    let is_rust = path.extension().is_some_and(|extension| extension == "rs");
    let most = match is_rust {
        true => MOST_LINES,
        false if path.ends_with("ARCHITECTURE.md") => MOST_LINES_OF_MAP,
        false => usize::MAX,
    };
    if lines > most {
        findings.push(format!("{}: {lines} lines, {most} are the most", path.display()));
    }
    for (number, line) in text.lines().enumerate() {
        let mut find = |what: String| {
            findings.push(format!("{}:{}: {what}", path.display(), number + 1));
        };
        for (start, end, why) in LEFTOVERS {
            let leftover = format!("{start}{end}");
            if line.contains(&leftover) {
                find(format!("{leftover} {why}"));
            }
        }
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::check;
    use std::path::Path;

    fn found(path: &str, text: &str) -> Vec<String> {
        check(Path::new(path), text)
    }

    #[test]
    fn leftovers_and_long_files_are_found_with_their_lines() {
        let marker = ["to", "do!("].concat();
        let leftover = found("a.rs", &format!("fn a() {{\n    {marker})\n}}\n"));
        assert_eq!(leftover.len(), 1);
        assert!(leftover[0].starts_with("a.rs:2: "), "{leftover:?}");
        assert!(found("a.rs", &"\n".repeat(500)).is_empty());
        assert_eq!(found("a.rs", &"\n".repeat(501)).len(), 1);
        assert!(found("a.json", &"\n".repeat(501)).is_empty());
        assert_eq!(found("ARCHITECTURE.md", &"\n".repeat(151)).len(), 1);
    }
}
