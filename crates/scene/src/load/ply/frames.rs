//! Reader of frames of instances in PLY files.

use super::{header, input::Input, rows::Rows};
use crate::load::error::LoadProblem;
use glam::DAffine3;
use std::io::BufRead;

/// The properties of a frame: x, y and z axes and the origin.
const COLUMNS: [&str; 12] =
    ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz", "ox", "oy", "oz"];

/// Reads the frames, elements `instance` of twelve numbers.
pub(in crate::load) fn read_frames<R: BufRead>(
    reader: R,
    length: u64,
) -> Result<Vec<DAffine3>, LoadProblem> {
    let mut input = Input::new(reader, length);
    let header = header::read(&mut input)?;
    let mut frames = Vec::new();
    let mut found = false;
    for element in &header.elements {
        super::check_size(&input, element, header.encoding)?;
        let mut rows = Rows::new(&mut input, element, header.encoding, 0);
        let column = |name: &str| COLUMNS.iter().position(|column| *column == name);
        let columns: Vec<_> = element.properties.iter().map(|p| column(&p.name)).collect();
        let complete = (0..COLUMNS.len()).all(|column| columns.contains(&Some(column)));
        if element.name == "instance" && complete {
            found = true;
            rows.for_each_row::<12>(&columns, |row| frames.push(DAffine3::from_cols_array(row)))?;
        } else {
            rows.skip()?;
        }
    }
    if found {
        return Ok(frames);
    }
    Err(LoadProblem::PlyHeader {
        line: 1,
        problem: format!("no element instance with the properties {}", COLUMNS.join(" ")),
    })
}
