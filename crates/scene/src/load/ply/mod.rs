//! Reader of PLY files, ASCII or binary of either byte order.
//!
//! Available libraries create a value for each element, by name and one property at a time, and
//! only then can the values be moved to arrays, which takes more than twice the memory of the
//! arrays. This reader decodes blocks of rows on all threads directly into the arrays of a
//! [`Mesh`], as clouds of ten million points require.
//!
//! Source: G. Turk, "The PLY polygon file format", 1994, with the property names that yocto-gl
//! writes.

mod columns;
mod elements;
mod frames;
mod header;
mod input;
mod names;
mod rows;
mod vertices;

pub(super) use frames::read_frames;

use super::{
    error::LoadProblem,
    mesh::{Mesh, MeshMaterial},
};
use elements::Corners;
use header::{Element, Encoding, Header};
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
    mesh.materials.extend(header.textures.iter().map(|texture| MeshMaterial {
        name: texture.clone(),
        texture: Some(texture.clone()),
        ..MeshMaterial::default()
    }));
    let vertices = vertex_element(&header)?;
    let count = vertices.map_or(0, |place| header.elements[place].count);
    let mut corners = Corners::default();
    for (place, element) in header.elements.iter().enumerate() {
        check_size(&input, element, header.encoding)?;
        let rows = &mut Rows::new(&mut input, element, header.encoding, count);
        if vertices == Some(place) {
            vertices::read(rows, &mut mesh)?;
        } else {
            elements::read(rows, &mut mesh, &mut corners)?;
        }
    }
    corners.become_vertices(&mut mesh)?;
    Ok(mesh)
}

/// Returns the index of the element of vertices: by its name, or the first one with a position.
fn vertex_element(header: &Header) -> Result<Option<usize>, LoadProblem> {
    let named = |name: &str| header.elements.iter().filter(move |e| e.name == name).count();
    if named("vertex") > 1 {
        return Err(LoadProblem::PlyHeader {
            line: 1,
            problem: "more than one element is called vertex".to_owned(),
        });
    }
    let has = |element: &Element, name: &str| element.properties.iter().any(|p| p.name == name);
    let by_name = header.elements.iter().position(|element| element.name == "vertex");
    let by_position =
        || header.elements.iter().position(|e| ["x", "y", "z"].iter().all(|name| has(e, name)));
    Ok(by_name.or_else(by_position))
}

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
