//! Reader of PLY files, ASCII or binary of either byte order.
//!
//! Available libraries create a value for each element, by name and one property at a time, and
//! only then can the values be moved to arrays, which takes more than twice the memory of the
//! arrays. This reader decodes blocks of rows on all threads directly into the arrays of a
//! [`Mesh`], as clouds of ten million points require.
//!
//! Source: G. Turk, "The PLY polygon file format", 1994, with the property names that yocto-gl
//! writes.

mod frames;
mod header;
mod input;
mod rows;
mod vertices;

pub(super) use frames::read_frames;

use super::{error::LoadProblem, mesh::Mesh};
use header::{Element, Encoding};
use input::Input;
use rows::Rows;
use std::io::BufRead;

/// Reads a mesh from `reader`, which holds `length` bytes.
///
/// Memory is bounded by the bytes read, not by the counts in the header.
pub(crate) fn read<R: BufRead + Send>(reader: R, length: u64) -> Result<Mesh, LoadProblem> {
    let mut input = Input::new(reader, length);
    let header = header::read(&mut input)?;
    let mut mesh = Mesh::default();
    let is_vertex = |element: &&Element| element.name == "vertex";
    let vertices = header.elements.iter().find(is_vertex).map_or(0, |element| element.count);
    if header.elements.iter().filter(is_vertex).count() > 1 {
        return Err(LoadProblem::PlyHeader {
            line: 1,
            problem: "more than one element is called vertex".to_owned(),
        });
    }
    for element in &header.elements {
        check_size(&input, element, header.encoding)?;
        let rows = &mut Rows::new(&mut input, element, header.encoding, vertices);
        match element.name.as_str() {
            "vertex" => vertices::read(rows, &mut mesh)?,
            "face" => rows.for_each_list(VERTICES, 3, |list| mesh.faces.push_polygon(list))?,
            "line" => rows.for_each_list(VERTICES, 2, |list| {
                mesh.lines.extend(list.windows(2).map(|pair| [pair[0], pair[1]]));
            })?,
            "point" => {
                rows.for_each_list(VERTICES, 0, |list| mesh.points.extend_from_slice(list))?;
            }
            _ => rows.skip()?,
        }
    }
    Ok(mesh)
}

/// The names of the list of vertices in use.
const VERTICES: &[&str] = &["vertex_indices", "vertex_index"];

/// Refuses counts that the rest of the file cannot hold, before any allocation.
fn check_size<R>(
    input: &Input<R>,
    element: &Element,
    encoding: Encoding,
) -> Result<(), LoadProblem> {
    let least = element.least_size(encoding);
    // The last word of an ASCII file needs no separator.
    let available = input.remaining + u64::from(encoding == Encoding::Ascii);
    if least > 0 && element.count > available / least {
        return Err(LoadProblem::Truncated {
            element: element.name.clone(),
            index: available / least,
            count: element.count,
        });
    }
    Ok(())
}
