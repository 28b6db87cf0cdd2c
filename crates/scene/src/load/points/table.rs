//! Tables of points: a row `x y z` for each, with intensity, colour, normal or radius beside it.

use super::{
    columns::{self, Columns, Role},
    number,
};
use crate::load::{
    colors::greys,
    error::LoadProblem,
    far,
    file::lines,
    mesh::{Mesh, listed},
};
use glam::{DVec3, Vec3, Vec4};
use rotund_image::linear_from_srgb;

/// What is between the values of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Separator {
    /// One character, also before and after nothing.
    Character(char),
    Blanks,
    /// Blanks, commas and semicolons in any number.
    Any,
}

impl Separator {
    fn split(self, row: &str) -> impl Iterator<Item = &str> {
        let is_between = move |c: char| match self {
            Self::Character(own) => c == own,
            Self::Blanks => c.is_whitespace(),
            Self::Any => c.is_whitespace() || matches!(c, ',' | ';'),
        };
        let keeps_empty = matches!(self, Self::Character(_));
        row.split(is_between)
            .map(|word| word.trim().trim_matches('"').trim())
            .filter(move |word| keeps_empty || !word.is_empty())
    }

    fn numbers(self, row: &str) -> Vec<Option<f64>> {
        self.split(row).map(number).collect()
    }
}

/// How the rows of a table are written.
struct Layout {
    separator: Separator,
    columns: Columns,
}

/// Reads the points of a table; `is_pts` says that an intensity comes before a colour.
pub(super) fn read(text: &str, is_pts: bool) -> Result<Mesh, LoadProblem> {
    let layout = layout(text, is_pts)?;
    let mut table = Table::default();
    for (line, row) in (1..).zip(lines(text)) {
        if !is_comment(row) {
            table.add(line, row, &layout);
        }
    }
    table.into_mesh(&layout.columns)
}

fn is_comment(row: &str) -> bool {
    let row = row.trim_start();
    row.is_empty() || ["#", "//", "%", "!"].iter().any(|mark| row.starts_with(mark))
}

/// Finds separator and columns by the first rows of numbers and the names above them.
fn layout(text: &str, is_pts: bool) -> Result<Layout, LoadProblem> {
    // Enough to see what columns hold.
    const SAMPLE: usize = 256;
    let mut names = None;
    let mut first_text: Option<(usize, &str)> = None;
    let mut found: Option<(Separator, usize)> = None;
    // Values of a few rows, and how many the first has.
    let (mut rows, mut width): (Vec<Vec<f64>>, usize) = (Vec::new(), 0);
    let value = |number: &Option<f64>| number.unwrap_or(f64::NAN);
    for (line, row) in (1..).zip(lines(text)) {
        if let Some((separator, _)) = found {
            if rows.len() == SAMPLE {
                break;
            }
            if !is_comment(row) {
                rows.push(separator.numbers(row).iter().map(value).collect());
            }
            continue;
        }
        if row.trim().is_empty() {
            continue;
        }
        if !is_comment(row) {
            if let Some(columns) = names.and_then(|names| named(names, row)) {
                return Ok(columns);
            }
            found = unnamed(row);
            if let Some((separator, _)) = found {
                let numbers = separator.numbers(row);
                width = numbers.iter().rposition(Option::is_some).map_or(0, |last| last + 1);
                rows.push(numbers.iter().map(value).collect());
                continue;
            }
            first_text = first_text.or(Some((line, row)));
        }
        // The last line before the numbers, a comment or not, may name the columns. A number alone
        // is a count.
        if row.trim().parse::<u64>().is_err() {
            names = Some(row);
        }
    }
    let Some((separator, start)) = found else {
        let Some((line, row)) = first_text else { return Err(LoadProblem::EmptyShape) };
        let row: String = row.chars().take(40).collect();
        let problem = format!("{row:?} is not a row of numbers x y z, nor is any other line");
        return Err(LoadProblem::PointsLine { line, problem });
    };
    // Rows that are cut say nothing about the columns.
    rows.retain(|row| row.len() >= width);
    rows.iter_mut().for_each(|row| row.truncate(width));
    Ok(Layout { separator, columns: columns::by_values(&rows, start, is_pts) })
}

/// Returns the layout of a row whose columns have names, if these are x, y and z among others.
fn named(names: &str, row: &str) -> Option<Layout> {
    let names = names.trim_start().trim_start_matches(['#', '/', '%', '!']);
    separators().find_map(|separator| {
        let of_row = separator.numbers(row);
        // A comma in the names may be a blank in the rows.
        [separator, Separator::Any].into_iter().find_map(|of_names| {
            let names: Vec<&str> = of_names.split(names).collect();
            let mut columns = columns::by_name(&names)?;
            let behind = (names.len()..of_row.len()).filter(|&column| of_row[column].is_some());
            columns.unused.extend(behind.map(|column| format!("column {}", column + 1)));
            let is_number = |role| {
                let column = columns.roles.iter().position(|r| *r == Some(role));
                column.is_some_and(|column| matches!(of_row.get(column), Some(Some(_))))
            };
            Role::POSITION.into_iter().all(is_number).then_some(Layout { separator, columns })
        })
    })
}

/// Returns the separator of a row that starts with three numbers, or with a label before them, and
/// the column of the first.
fn unnamed(row: &str) -> Option<(Separator, usize)> {
    separators().find_map(|separator| {
        let numbers = separator.numbers(row);
        match numbers[..] {
            [Some(_), Some(_), Some(_), ..] => Some((separator, 0)),
            [None, Some(_), Some(_), Some(_), ..] => Some((separator, 1)),
            _ => None,
        }
    })
}

fn separators() -> impl Iterator<Item = Separator> {
    let characters = [';', '|', '\t', ','].map(Separator::Character);
    characters.into_iter().chain([Separator::Blanks, Separator::Any])
}

#[derive(Default)]
struct Table {
    positions: Vec<DVec3>,
    normals: Vec<Vec3>,
    /// Numbers of the file.
    colors: Vec<Vec4>,
    intensities: Vec<f32>,
    radii: Vec<f32>,
    /// The sum of the counts in the file, and whether there are any.
    announced: Option<u64>,
    bad_count: u64,
    first_bad: Option<(usize, String)>,
}

impl Table {
    fn add(&mut self, line: usize, row: &str, layout: &Layout) {
        let mut values = [f64::NAN; Role::COUNT];
        let mut has_position = 0;
        for (word, role) in layout.separator.split(row).zip(&layout.columns.roles) {
            let Some(role) = role else { continue };
            if let Some(value) = number(word) {
                values[*role as usize] = value;
                has_position += u32::from(Role::POSITION.contains(role));
            }
        }
        if has_position < 3 {
            if let Ok(count) = row.trim().parse::<u64>() {
                self.announced = Some(self.announced.unwrap_or(0).saturating_add(count));
            } else if !self.positions.is_empty() {
                self.bad_count += 1;
                let start = || (line, row.chars().take(40).collect());
                self.first_bad.get_or_insert_with(start);
            }
            return;
        }
        let three = |roles: [Role; 3]| roles.map(|role| values[role as usize]);
        self.positions.push(three(Role::POSITION).into());
        let columns = &layout.columns;
        if columns.has(Role::NormalX) {
            self.normals.push(DVec3::from(three(Role::NORMAL)).as_vec3());
        }
        if columns.has(Role::Red) {
            let color = DVec3::from(three(Role::COLOR)).as_vec3();
            let alpha = if columns.has(Role::Alpha) { values[Role::Alpha as usize] } else { 1.0 };
            self.colors.push(color.extend(alpha as f32));
        }
        if columns.has(Role::Intensity) {
            self.intensities.push(values[Role::Intensity as usize] as f32);
        }
        if columns.has(Role::Radius) {
            self.radii.push(values[Role::Radius as usize] as f32);
        } else if columns.has(Role::Diameter) {
            self.radii.push(0.5 * values[Role::Diameter as usize] as f32);
        }
    }

    fn into_mesh(self, columns: &Columns) -> Result<Mesh, LoadProblem> {
        let rows = self.positions.len() as u64;
        let mut warnings = Vec::new();
        if let Some((line, text)) = self.first_bad {
            // A file of something else has more lines of it.
            if self.bad_count > rows {
                let problem = format!("{text:?} is not a row of numbers x y z, nor are most lines");
                return Err(LoadProblem::PointsLine { line, problem });
            }
            warnings.push(format!(
                "{} lines are no rows of points, the first is line {line}; left out",
                self.bad_count
            ));
        }
        if let Some(announced) = self.announced.filter(|&count| count != rows + self.bad_count) {
            warnings.push(format!("has {rows} points, but announces {announced}"));
        }
        if !columns.unused.is_empty() {
            warnings.push(format!("not used of the columns: {}", listed(&columns.unused)));
        }
        let colors = match columns.has(Role::Red) {
            true => colors(self.colors),
            false => greys(&self.intensities),
        };
        let (positions, offset) = far::to_single(&self.positions);
        Ok(Mesh {
            positions,
            offset,
            normals: self.normals,
            colors,
            radii: self.radii,
            warnings,
            ..Mesh::default()
        })
    }
}

/// Converts colours from 0 to 1, 255 or 65,535, by the largest channel of all, to linear ones.
fn colors(mut colors: Vec<Vec4>) -> Vec<Vec4> {
    let finite = |x: f32| if x.is_finite() { x } else { 0.0 };
    let most = |most: Vec4, color: &Vec4| most.max(color.to_array().map(finite).into());
    let largest = colors.iter().fold(Vec4::ZERO, most);
    let one = |largest: f32| match largest {
        x if x <= 1.0 => 1.0,
        x if x <= 255.0 => 255.0,
        _ => 65_535.0,
    };
    let (white, opaque) = (one(largest.truncate().max_element()), one(largest.w));
    for color in &mut colors {
        let [r, g, b] = [color.x, color.y, color.z].map(|c| linear_from_srgb(c / white));
        *color = Vec4::new(r, g, b, color.w / opaque);
    }
    colors
}
