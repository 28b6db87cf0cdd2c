//! Readers of points as text: tables of numbers, as scanners and spreadsheets write them, and
//! molecules.

mod atoms;
mod columns;
mod molecule;
mod table;

use super::{error::LoadProblem, file, mesh::Mesh};

/// The extensions of files of points.
pub(super) const EXTENSIONS: [&str; 5] = ["xyz", "txt", "csv", "pts", "asc"];

/// Reads a table or a molecule; the content decides, and where it leaves a choice the extension.
pub(super) fn read(bytes: &[u8], extension: &str) -> Result<Mesh, LoadProblem> {
    let text = String::from_utf8_lossy(file::text(bytes)?);
    match molecule::layout(&text, extension == "xyz") {
        Some(layout) => molecule::read(&text, &layout),
        None => table::read(&text, extension == "pts"),
    }
}

/// Returns a number; a decimal comma is a point, and `D` the exponent of Fortran.
fn number(word: &str) -> Option<f64> {
    word.parse().ok().or_else(|| {
        let is_foreign = |c: char| matches!(c, ',' | 'd' | 'D');
        if !word.contains(is_foreign) || !word.contains(|c: char| c.is_ascii_digit()) {
            return None;
        }
        word.replace(',', ".").replace(['d', 'D'], "e").parse().ok()
    })
}
