//! The rows of an SWC file.

use crate::load::{error::LoadProblem, file};
use glam::DVec3;
use std::str::FromStr;

/// A row: a node, and the node that it continues.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Row {
    /// Number of its line, for messages.
    pub line: usize,
    pub id: u64,
    pub structure: Structure,
    pub position: DVec3,
    /// Zero if it was not measured.
    pub radius: f32,
    /// `None` for a root.
    pub parent: Option<u64>,
}

/// The part of a cell that a node belongs to, by the type of its row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Structure {
    Soma,
    Axon,
    BasalDendrite,
    ApicalDendrite,
    /// Undefined, glia, and the types of each laboratory.
    Other,
}

/// Reads all rows. Values stand between blanks or commas, and those after the seventh are skipped.
pub(super) fn read(bytes: &[u8]) -> Result<Vec<Row>, LoadProblem> {
    let text = String::from_utf8_lossy(file::text(bytes)?);
    let mut rows = Vec::new();
    let mut words = Vec::new();
    for (line, content) in (1..).zip(file::lines(&text)) {
        let said = content.split('#').next().unwrap_or_default().trim();
        if said.is_empty() {
            continue;
        }
        split(said, &mut words);
        rows.push(row(line, &words).map_err(|problem| LoadProblem::SwcLine { line, problem })?);
    }
    Ok(rows)
}

/// Splits a row into its values. Between two commas there may be nothing.
fn split<'a>(said: &'a str, words: &mut Vec<&'a str>) {
    words.clear();
    if !said.contains(',') {
        words.extend(said.split_whitespace());
        return;
    }
    for part in said.split(',') {
        match part.trim() {
            "" => words.push(""),
            part => words.extend(part.split_whitespace()),
        }
    }
}

fn row(line: usize, words: &[&str]) -> Result<Row, String> {
    let &[id, structure, x, y, z, radius, parent, ..] = words else {
        let expected = "id, type, x, y, z, radius and parent";
        return Err(format!("has {} values, expected 7: {expected}", words.len()));
    };
    let structure = match integer("type", structure)? {
        1 => Structure::Soma,
        2 => Structure::Axon,
        3 => Structure::BasalDendrite,
        4 => Structure::ApicalDendrite,
        _ => Structure::Other,
    };
    Ok(Row {
        line,
        id: u64::try_from(integer("id", id)?)
            .map_err(|_| format!("id is {id}, expected an integer that is not negative"))?,
        structure,
        position: DVec3::new(coordinate("x", x)?, coordinate("y", y)?, coordinate("z", z)?),
        radius: measured(radius)?,
        // Any negative number marks a root, but -1 is the one to write.
        parent: u64::try_from(integer("parent", parent)?).ok(),
    })
}

fn number<T: FromStr>(name: &str, word: &str) -> Result<T, String> {
    let hint = "a comment begins with #";
    word.parse().map_err(|_| format!("{name} is {word:?}, expected a number; {hint}"))
}

fn coordinate(name: &str, word: &str) -> Result<f64, String> {
    let value: f64 = number(name, word)?;
    let refused = || format!("{name} is {word}, expected a finite number; correct or remove it");
    // It becomes single.
    (value as f32).is_finite().then_some(value).ok_or_else(refused)
}

/// Parses a radius; zero for one that was not measured, as some programs write it.
fn measured(word: &str) -> Result<f32, String> {
    if ["", "na", "nan"].contains(&word.to_ascii_lowercase().as_str()) {
        return Ok(0.0);
    }
    let radius: f32 = number("radius", word)?;
    let refused = || {
        let expected = "a finite number that is not negative";
        format!("radius is {radius}, expected {expected}; write 0 if it was not measured")
    };
    (radius.is_finite() && radius >= 0.0).then_some(radius).ok_or_else(refused)
}

/// Parses an integer, also one that is written as `3.0` or `3e0`.
fn integer(name: &str, word: &str) -> Result<i64, String> {
    // Larger integers are not exact.
    const LARGEST: f64 = 9_007_199_254_740_992.0;
    if let Ok(value) = word.parse() {
        return Ok(value);
    }
    let value: Option<f64> = word.parse().ok();
    match value.filter(|value| value.fract() == 0.0 && value.abs() <= LARGEST) {
        Some(value) => Ok(value as i64),
        None => Err(format!("{name} is {word:?}, expected an integer; a comment begins with #")),
    }
}
