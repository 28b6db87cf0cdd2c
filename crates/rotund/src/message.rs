//! One line about a failure, or a warning, on standard error.

use rotund_report::console::printable;

/// Prints a note on one line.
#[expect(clippy::print_stderr, reason = "notes are for the person, not for a pipe")]
pub(crate) fn note(text: impl AsRef<str>) {
    eprintln!("{}", on_one_line(text.as_ref()));
}

/// Prints a warning on one line.
pub(crate) fn warn(text: impl AsRef<str>) {
    note(format!("warning: {}", text.as_ref()));
}

/// Returns the text with spaces for line breaks, and escapes for other control characters.
pub(crate) fn on_one_line(text: &str) -> String {
    let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    printable(&lines.join(" ")).into_owned()
}

/// Joins the messages of an error and of its causes by colons.
///
/// Some errors quote their cause in their own message and return it as a source as well; such a
/// cause is left out, so that each appears once.
pub(crate) fn one_line(error: &anyhow::Error) -> String {
    let mut line = String::new();
    for cause in error.chain().map(ToString::to_string) {
        let cause = on_one_line(&cause);
        if line.is_empty() {
            line = cause;
        } else if !line.contains(&cause) {
            line = format!("{line}: {cause}");
        }
    }
    line
}

#[cfg(test)]
mod tests {
    use super::one_line;
    use anyhow::Context as _;

    #[test]
    fn each_cause_is_printed_once() {
        let error = || anyhow::anyhow!("no such file");
        assert_eq!(one_line(&error()), "no such file");
        assert_eq!(one_line(&anyhow::anyhow!("two\n lines\n\n")), "two lines");
        assert_eq!(one_line(&anyhow::anyhow!("no \u{1b}[2J.ply")), "no \\u001b[2J.ply");
        let plain = Err::<(), _>(error()).context("cannot read a.ply").unwrap_err();
        assert_eq!(one_line(&plain), "cannot read a.ply: no such file");
        let quoting = Err::<(), _>(error()).context("cannot read a.ply: no such file").unwrap_err();
        assert_eq!(one_line(&quoting), "cannot read a.ply: no such file");
    }
}
