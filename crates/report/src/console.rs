//! Text on standard output, and aligned tables.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::{self, Write as _};

/// Returns the text with each control character but line breaks, and each that reverses the
/// direction of writing, as an escape like `\u001b`. Names come from files, and may hold what moves
/// the cursor or colours the terminal. In JSON the escape stands for the same character.
#[must_use]
pub fn printable(text: &str) -> Cow<'_, str> {
    let is_odd = |c: char| {
        let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}')
            || matches!(c, '\u{2066}'..='\u{2069}');
        c != '\n' && (c.is_control() || turns)
    };
    if !text.contains(is_odd) {
        return Cow::Borrowed(text);
    }
    let escape = |c| if is_odd(c) { format!("\\u{:04x}", u32::from(c)) } else { c.to_string() };
    Cow::Owned(text.chars().map(escape).collect())
}

/// Prints `text`, with escapes for what [`printable`] replaces, and a line break to standard
/// output.
///
/// Unlike `println!`, it does not panic if the reader has closed the pipe.
///
/// # Errors
///
/// If standard output cannot be written to; a closed pipe is [`io::ErrorKind::BrokenPipe`].
pub fn say(text: impl AsRef<str>) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(printable(text.as_ref()).as_bytes())?;
    out.write_all(b"\n")?;
    out.flush()?;
    Ok(())
}

/// Columns of a terminal that a table keeps to.
const TERMINAL_COLUMNS: usize = 80;

/// Rows of text under a heading. The first column is aligned left, the others right. `Display`
/// writes the table.
///
/// A table is at most 80 characters wide, if the columns after the first leave room for the first
/// one. A first cell that is too long stands on lines of its own, of 80 characters, above the rest
/// of its row.
#[derive(Clone, Debug)]
pub struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Makes a table with these column headings.
    #[must_use]
    pub fn new(headings: &[&str]) -> Self {
        Self { rows: vec![headings.iter().map(|&heading| heading.to_owned()).collect()] }
    }

    /// Appends a row, which may be shorter than the heading.
    pub fn row(&mut self, cells: impl IntoIterator<Item = impl Into<String>>) {
        let one_line = |cell: String| printable(&cell).replace('\n', "\\u000a");
        self.rows.push(cells.into_iter().map(|cell| one_line(cell.into())).collect());
    }

    /// Returns the width of each column; that of the first is cut to the room beside the others.
    fn widths(&self) -> Vec<usize> {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |column: usize| {
            let cells = self.rows.iter().filter_map(|row| row.get(column));
            cells.map(|cell: &String| cell.chars().count()).max().unwrap_or(0)
        };
        let mut widths: Vec<usize> = (0..columns).map(width).collect();
        if let Some((first, others)) = widths.split_first_mut() {
            let taken: usize = others.iter().map(|width| width + 2).sum();
            *first = (*first).min(TERMINAL_COLUMNS.saturating_sub(taken));
        }
        widths
    }
}

impl std::fmt::Display for Table {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let widths = self.widths();
        for (index, row) in self.rows.iter().enumerate() {
            let mut line = String::new();
            for (column, cell) in row.iter().enumerate() {
                let width = widths[column];
                if column > 0 {
                    write!(line, "  {cell:>width$}")?;
                } else if cell.chars().count() <= width {
                    write!(line, "{cell:<width$}")?;
                } else {
                    for (at, letter) in cell.chars().enumerate() {
                        if at > 0 && at % TERMINAL_COLUMNS == 0 {
                            f.write_str("\n")?;
                        }
                        f.write_char(letter)?;
                    }
                    // The rest of the row follows on the next line.
                    write!(line, "\n{:width$}", "")?;
                }
            }
            if index + 1 < self.rows.len() {
                writeln!(f, "{}", line.trim_end())?;
            } else {
                f.write_str(line.trim_end())?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{Table, printable};

    #[test]
    fn what_would_control_a_terminal_is_escaped() {
        let table = [
            ("plain text\nof two lines, ä and 漢", "plain text\nof two lines, ä and 漢"),
            ("\u{1b}[31mred\u{7}", "\\u001b[31mred\\u0007"),
            ("\r\t\u{7f}\u{9b}2J", "\\u000d\\u0009\\u007f\\u009b2J"),
            ("gnp.\u{202e}exe", "gnp.\\u202eexe"),
        ];
        for (text, expected) in table {
            assert_eq!(printable(text), expected);
        }
        let mut rows = Table::new(&["name"]);
        rows.row(["two\nlines"]);
        assert_eq!(rows.to_string(), "name\ntwo\\u000alines");
    }

    #[test]
    fn a_table_aligns_the_first_column_left_and_numbers_right() {
        let mut table = Table::new(&["method", "ns"]);
        table.row(["sphere", "6.4"]);
        table.row(["cone", "20.4"]);
        assert_eq!(table.to_string(), "method    ns\nsphere   6.4\ncone    20.4");
    }

    #[test]
    fn a_long_name_stands_above_its_numbers_so_that_80_columns_are_enough() {
        let mut table = Table::new(&["picture", &"n".repeat(40)]);
        let (fits, long, longest) = ("a".repeat(38), "b".repeat(39), "c".repeat(81));
        table.row([fits.as_str(), "1"]);
        table.row([long.as_str(), "2"]);
        table.row([longest.as_str(), "3"]);
        let text = table.to_string();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines.iter().all(|line| line.len() <= 80), "{text}");
        assert_eq!(lines[1], format!("{fits}{:>42}", 1));
        assert_eq!(lines[2..4], [long, format!("{:>80}", 2)]);
        assert_eq!(lines[4..], ["c".repeat(80), "c".to_owned(), format!("{:>80}", 3)]);
    }
}
