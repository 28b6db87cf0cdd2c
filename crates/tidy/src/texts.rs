//! Sizes of files and lines, and leftovers of work.

use std::path::Path;

/// A longer file has two concepts.
const MOST_LINES: usize = 500;
/// `ARCHITECTURE.md` is to be read in one go.
const MOST_LINES_OF_MAP: usize = 150;
/// As in `rustfmt.toml`, which does not apply to comments.
const MOST_COLUMNS: usize = 100;

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
pub(crate) fn check(path: &Path, text: &str) -> Vec<String> {
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
        let columns = line.chars().count();
        if is_rust && columns > MOST_COLUMNS && !cannot_be_broken(line) {
            find(format!("{columns} columns, {MOST_COLUMNS} are the most"));
        }
    }
    findings
}

/// Whether a line holds an address, a row of a table, or, outside of comments, a piece of a string.
fn cannot_be_broken(line: &str) -> bool {
    let text = line.trim_start();
    let comment = ["///", "//!", "//"].iter().find_map(|mark| text.strip_prefix(mark));
    line.contains("://")
        || match comment {
            Some(comment) => comment.trim_start().starts_with('|'),
            None => line.contains('"') || line.ends_with('\\'),
        }
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

    #[test]
    fn long_lines_are_found_unless_they_cannot_be_broken() {
        let words = "word ".repeat(20);
        let table = [
            ("100 columns", format!("// {}", &words[..97]), 0),
            ("101 characters of a comment", format!("// é{}", &words[..97]), 1),
            ("a comment with a quote", format!("// \"{words}\""), 1),
            ("an address", format!("// https://example.org/{}", words.replace(' ', "-")), 0),
            ("a row of a table", format!("/// | {words}|"), 0),
            ("a string", format!("    say(\"{words}\");"), 0),
            ("code", format!("    {}", words.replace(' ', "+")), 1),
        ];
        for (why, line, count) in table {
            assert_eq!(found("a.rs", &line).len(), count, "{why}");
        }
        assert!(found("a.md", &words.repeat(2)).is_empty());
    }
}
