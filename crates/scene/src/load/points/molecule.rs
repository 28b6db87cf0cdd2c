//! Molecules: XYZ files, with the number of atoms, a comment, and a row `symbol x y z` for each
//! atom; and extended XYZ files, whose comment names the columns.
//!
//! Source of the extended format: the `extxyz` module of the Atomic Simulation Environment.

use super::{
    atoms::{self, Atom},
    number,
};
use crate::load::{
    error::LoadProblem,
    far,
    file::lines,
    mesh::{Mesh, listed},
};
use glam::{DVec3, Vec4};
use rotund_image::linear_from_srgb;

/// Where the values of an atom are in its row.
#[derive(Debug, PartialEq)]
pub(super) struct Layout {
    /// Lines before the atoms: none, or their number and a comment.
    has_header: bool,
    species: usize,
    position: usize,
    radius: Option<usize>,
    color: Option<usize>,
    /// Names of further columns.
    unused: Vec<String>,
}

/// Returns the layout of a molecule, and `None` if the text is none. In a file with the extension
/// `xyz`, the number of atoms may be missing, and atomic numbers may stand for symbols.
pub(super) fn layout(text: &str, is_xyz: bool) -> Option<Layout> {
    let mut first = lines(text).skip_while(|line| line.trim().is_empty());
    let (count, comment) = (first.next()?, first.next().unwrap_or_default());
    let plain = |has_header| Layout {
        has_header,
        species: 0,
        position: 1,
        radius: None,
        color: None,
        unused: Vec::new(),
    };
    if count.trim().parse::<u64>().is_err() {
        return (is_xyz && is_atom(count, false)).then(|| plain(false));
    }
    if let Some(properties) = properties(comment) {
        return extended(properties);
    }
    let row = first.next().unwrap_or_default();
    (is_atom(row, false) || is_xyz && !is_numbers(comment) && is_atom(row, true))
        .then(|| plain(true))
}

/// Returns true for a symbol or, if `by_number`, an atomic number before three numbers.
fn is_atom(row: &str, by_number: bool) -> bool {
    let mut words = row.split_whitespace();
    let is_species = |word: &str| {
        // `nan` is a number too.
        let is_number = number(word).is_some();
        is_number == by_number && word.starts_with(|c: char| c.is_ascii_alphanumeric())
    };
    let has_position = |words: &mut dyn Iterator<Item = &str>| {
        (0..3).all(|_| words.next().is_some_and(|word| number(word).is_some()))
    };
    words.next().is_some_and(is_species)
        && has_position(&mut words)
        // After an atomic number there may be anything else than the colour of a point.
        && (!by_number || words.next().is_none())
}

fn is_numbers(row: &str) -> bool {
    let mut words = row.split_whitespace();
    (0..3).all(|_| words.next().is_some_and(|word| number(word).is_some()))
}

/// Returns the value of the key `Properties` in a comment.
fn properties(comment: &str) -> Option<&str> {
    const KEY: &str = "properties=";
    let at = comment.to_ascii_lowercase().find(KEY)?;
    let value = comment[at + KEY.len()..].trim_start_matches('"');
    value.split(|c: char| c.is_whitespace() || c == '"').next()
}

/// Returns the layout that `name:type:columns:...` describes.
fn extended(properties: &str) -> Option<Layout> {
    let words: Vec<&str> = properties.split(':').collect();
    let (mut species, mut position, mut radius, mut color) = (None, None, None, None);
    let mut unused = Vec::new();
    let mut column = 0_usize;
    for property in words.chunks_exact(3) {
        let columns = property[2].parse::<u16>().ok()?;
        match (property[0].to_ascii_lowercase().as_str(), columns) {
            ("species" | "element" | "z" | "numbers", 1) if species.is_none() => {
                species = Some(column);
            }
            ("pos" | "position" | "positions", 3) => position = Some(column),
            ("radius", 1) => radius = Some(column),
            ("color" | "colour", 3) => color = Some(column),
            _ => unused.push(property[0].to_owned()),
        }
        column += usize::from(columns);
    }
    let (species, position) = (species?, position?);
    Some(Layout { has_header: true, species, position, radius, color, unused })
}

/// Reads the first frame of a molecule.
pub(super) fn read(text: &str, layout: &Layout) -> Result<Mesh, LoadProblem> {
    let is_filled = |(_, line): &(usize, &str)| !line.trim().is_empty();
    let mut rows = (1..).zip(lines(text)).skip_while(|row| !is_filled(row));
    let mut count = u64::MAX;
    if layout.has_header {
        let of_atoms = rows.next().and_then(|(_, line)| line.trim().parse().ok());
        count = of_atoms.unwrap_or(0);
        rows.next();
    }
    let mut rows = rows.filter(is_filled);
    let mut atoms = Atoms::default();
    while (atoms.positions.len() as u64) < count {
        let Some((line, row)) = rows.next() else {
            if !layout.has_header {
                break;
            }
            let index = atoms.positions.len() as u64;
            return Err(LoadProblem::Truncated { element: "atom".to_owned(), index, count });
        };
        atoms.add(row, layout).map_err(|problem| LoadProblem::PointsLine { line, problem })?;
    }
    let next = rows.next();
    let more = rows.count();
    let mut mesh = atoms.into_mesh();
    if !layout.unused.is_empty() {
        mesh.warnings.push(format!("not used of the properties: {}", listed(&layout.unused)));
    }
    if let Some((line, next)) = next {
        mesh.warnings.push(if next.trim().parse::<u64>().is_ok() {
            format!(
                "has more than one frame (the second starts in line {line}); the first is taken"
            )
        } else {
            format!("{} lines after the {count} atoms, from line {line}, are left out", more + 1)
        });
    }
    Ok(mesh)
}

#[derive(Default)]
struct Atoms {
    positions: Vec<DVec3>,
    colors: Vec<Vec4>,
    radii: Vec<f32>,
    /// Names that stand for an element by their first letter, and those of none.
    guessed: Vec<String>,
    unknown: Vec<String>,
}

impl Atoms {
    fn add(&mut self, row: &str, layout: &Layout) -> Result<(), String> {
        let words: Vec<&str> = row.split_whitespace().collect();
        let value = |column: usize, what: &str| match words.get(column) {
            Some(word) => number(word).ok_or_else(|| format!("{what} is {word:?}, not a number")),
            None => Err(format!("has no {what}, expected a symbol and x y z")),
        };
        let position = [(0, "x"), (1, "y"), (2, "z")];
        let [x, y, z] = position.map(|(axis, what)| value(layout.position + axis, what));
        self.positions.push(DVec3::new(x?, y?, z?));
        let symbol = words.get(layout.species).copied().unwrap_or_default();
        let atom = self.find(symbol);
        self.radii.push(match layout.radius {
            Some(column) => value(column, "radius")? as f32,
            None => atom.radius,
        });
        self.colors.push(match layout.color {
            Some(column) => {
                let [r, g, b] = [0, 1, 2].map(|i| value(column + i, "color"));
                let [r, g, b] = [r?, g?, b?].map(|srgb| linear_from_srgb(srgb as f32));
                Vec4::new(r, g, b, 1.0)
            }
            None => atom.color(),
        });
        Ok(())
    }

    fn find(&mut self, symbol: &str) -> Atom {
        atoms::find(symbol).unwrap_or_else(|| {
            let guess = atoms::find_by_first_letter(symbol);
            let names = if guess.is_some() { &mut self.guessed } else { &mut self.unknown };
            // Many names are no symbols of elements but labels.
            const MOST: usize = 64;
            if names.len() < MOST && !names.iter().any(|name| name == symbol) {
                names.push(symbol.to_owned());
            }
            guess.unwrap_or(Atom::UNKNOWN)
        })
    }

    fn into_mesh(self) -> Mesh {
        let (positions, offset) = far::to_single(&self.positions);
        let mut mesh =
            Mesh { positions, offset, colors: self.colors, radii: self.radii, ..Mesh::default() };
        if !self.guessed.is_empty() {
            mesh.warnings.push(format!(
                "atoms are named {}; taken for the elements of their first letter",
                listed(&self.guessed)
            ));
        }
        if !self.unknown.is_empty() {
            let names = listed(&self.unknown);
            mesh.warnings.push(format!("no element is named {names}; shown in pink"));
        }
        mesh
    }
}

#[cfg(test)]
mod tests {
    use super::layout;

    #[test]
    fn a_molecule_is_told_from_a_table() {
        for (text, is_xyz, expected) in [
            ("2\nwater\nO 0 0 0\nH 1 0 0\n", false, true),
            ("\n1\n\nCl -0.5 1e-3 2.\n", false, true),
            ("1\n\n8 0 0 0\n", true, true),
            ("C 0 0 0\n", true, true),
            ("P1 0 0 0\n", false, false),
            ("1\nProperties=pos:R:3:species:S:1\n0 0 0 O\n", true, true),
            ("1 2 3\n4 5 6\n", true, false),
            ("2\n1 2 3 9\n4 5 6 9\n", true, false),
            ("2\n1 2 3 9\n4 5 6 9\n", false, false),
            ("x y z\n4 5 6\n", true, false),
            ("nan nan nan 1 2 3\n", true, false),
            ("", true, false),
        ] {
            assert_eq!(layout(text, is_xyz).is_some(), expected, "{text:?}");
        }
    }
}
