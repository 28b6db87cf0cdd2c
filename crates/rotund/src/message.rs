//! One line about a failure.

/// Joins the messages of an error and of its causes by colons.
///
/// Some errors quote their cause in their own message and return it as a source as well; such a
/// cause is left out, so that each appears once. Line breaks inside a message become spaces.
pub(crate) fn one_line(error: &anyhow::Error) -> String {
    let mut line = String::new();
    for cause in error.chain().map(ToString::to_string) {
        let cause: Vec<&str> = cause.lines().map(str::trim).filter(|l| !l.is_empty()).collect();
        let cause = cause.join(" ");
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
        let plain = Err::<(), _>(error()).context("cannot read a.ply").unwrap_err();
        assert_eq!(one_line(&plain), "cannot read a.ply: no such file");
        let quoting = Err::<(), _>(error()).context("cannot read a.ply: no such file").unwrap_err();
        assert_eq!(one_line(&quoting), "cannot read a.ply: no such file");
    }
}
