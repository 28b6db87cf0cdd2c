//! Decoding of the elements of a PLY file that name vertices: faces, strips, lines and points.

use super::{
    header::{Element, Type},
    names::{self, Kind},
    rows::{ListRow, Rows, STRIP_END, Wanted, vertex_index},
};
use crate::load::{
    error::LoadProblem,
    mesh::{Look, Mesh, NO_MATERIAL, not_named},
};
use glam::{Vec2, Vec4};
use rotund_image::linear_from_srgb;
use std::{collections::HashMap, io::BufRead};

/// The texture coordinates of the corners of faces.
#[derive(Debug, Default)]
pub(super) struct Corners {
    /// The number of each distinct corner: a vertex and the bits of its texture coordinate.
    numbers: HashMap<(u32, [u32; 2]), u32>,
    /// Vertex and texture coordinate of each.
    corners: Vec<(u32, Vec2)>,
}

/// Reads an element that is not the vertices into `mesh`, or skips it with a warning.
pub(super) fn read<R: BufRead>(
    rows: &mut Rows<'_, R>,
    mesh: &mut Mesh,
    corners: &mut Corners,
) -> Result<(), LoadProblem> {
    let element = rows.element;
    let found = names::kind(element).zip(names::vertex_list(element));
    if let Some((kind, list)) = found {
        return read_lists(rows, kind, list, mesh, corners);
    }
    if let (Some(Kind::Lines), Some(ends)) = (names::kind(element), names::ends(element)) {
        return read_edges(rows, ends, mesh);
    }
    if element.count > 0 {
        mesh.warnings
            .push(format!("element {} is not used; its count is {}", element.name, element.count));
    }
    rows.skip()
}

/// Properties of a face or line beside its vertices, in the order of [`Wanted::numbers`].
const COLOR: usize = 0;
const ALPHA: usize = 3;
const TEXTURE: usize = 4;
/// The ends of an edge without a list.
const ENDS: usize = 5;

/// Returns which properties to read beside the vertices.
fn wanted(element: &Element, kind: Kind) -> Wanted {
    let mut wanted = Wanted::default();
    if matches!(kind, Kind::Strips | Kind::Points) {
        return wanted;
    }
    for (i, property) in element.properties.iter().enumerate() {
        let name = names::plain(&property.name);
        let is_list = property.count.is_some();
        match name.as_str() {
            "texcoord" | "texcoords" | "uv" | "uvs" if is_list && kind == Kind::Faces => {
                wanted.texcoords = Some(i);
            }
            _ if is_list => {}
            "red" | "r" | "diffuse_red" => wanted.numbers[COLOR] = Some(i),
            "green" | "g" | "diffuse_green" => wanted.numbers[COLOR + 1] = Some(i),
            "blue" | "b" | "diffuse_blue" => wanted.numbers[COLOR + 2] = Some(i),
            "alpha" | "a" => wanted.numbers[ALPHA] = Some(i),
            "texnumber" | "texture_number" if kind == Kind::Faces => {
                wanted.numbers[TEXTURE] = Some(i);
            }
            _ => {}
        }
    }
    if wanted.numbers[COLOR..ALPHA].iter().any(Option::is_none) {
        wanted.numbers[COLOR..=ALPHA].fill(None);
    }
    wanted
}

/// Returns the colour of a row, linear; white if the element has none.
fn color(element: &Element, wanted: &Wanted, numbers: &[f64]) -> Vec4 {
    let channel = |i: usize| {
        let item = wanted.numbers[COLOR + i].map_or(Type::F32, |p| element.properties[p].item);
        let value = numbers[COLOR + i] as f32 / item.one();
        if item.is_integer() && i < 3 { linear_from_srgb(value) } else { value }
    };
    if wanted.numbers[COLOR].is_none() {
        return Vec4::ONE;
    }
    let alpha = if wanted.numbers[ALPHA].is_some() { channel(ALPHA) } else { 1.0 };
    Vec4::new(channel(0), channel(1), channel(2), alpha)
}

fn read_lists<R: BufRead>(
    rows: &mut Rows<'_, R>,
    kind: Kind,
    list: usize,
    mesh: &mut Mesh,
    corners: &mut Corners,
) -> Result<(), LoadProblem> {
    let element = rows.element;
    let mut wanted = wanted(element, kind);
    wanted.vertices = list;
    wanted.with_ends_of_strips = kind == Kind::Strips;
    let is_used = |i| i == list || wanted.texcoords == Some(i) || wanted.numbers.contains(&Some(i));
    mesh.warnings.extend(names::not_used(element, is_used));
    let textures = mesh.materials.len() as u32;
    let mut odd_texcoords = 0_u64;
    let mut short_lines = 0_u64;
    let mut own = Vec::new();
    rows.for_each_list(&wanted, |row: ListRow<'_>| match kind {
        Kind::Faces => {
            let material = match wanted.numbers[TEXTURE] {
                // The cast saturates; a number without a texture is no material.
                Some(_) if row.numbers[TEXTURE] >= 0.0 => row.numbers[TEXTURE] as u32,
                Some(_) => NO_MATERIAL,
                None => 0,
            };
            let material = if material < textures { material } else { NO_MATERIAL };
            let look = Look { color: color(element, &wanted, row.numbers), material };
            let mut polygon = row.vertices;
            if wanted.texcoords.is_some() {
                let (texcoords, _) = row.texcoords.as_chunks::<2>();
                if texcoords.len() != polygon.len() && !row.texcoords.is_empty() {
                    odd_texcoords += 1;
                }
                own.clear();
                own.extend(polygon.iter().enumerate().map(|(i, &vertex)| {
                    // In PLY files v runs up.
                    let texcoord =
                        texcoords.get(i).map_or(Vec2::ZERO, |t| Vec2::new(t[0], 1.0 - t[1]));
                    corners.number(vertex, texcoord)
                }));
                polygon = &own;
            }
            mesh.faces.push_polygon(polygon, look);
        }
        Kind::Strips => row.vertices.split(|&v| v == STRIP_END).for_each(|strip| {
            for (i, corner) in strip.windows(3).enumerate() {
                // Every second triangle of a strip runs the other way round.
                let [a, b] = if i % 2 == 0 { [0, 1] } else { [1, 0] };
                let triangle = [corner[a], corner[b], corner[2]];
                mesh.faces.push_polygon(&triangle, Look::default());
            }
        }),
        Kind::Lines => {
            short_lines += u64::from(row.vertices.len() < 2);
            let lines = row.vertices.windows(2).map(|pair| [pair[0], pair[1]]);
            push_lines(mesh, lines, color(element, &wanted, row.numbers));
        }
        Kind::Points => mesh.points.extend_from_slice(row.vertices),
    })?;
    if odd_texcoords > 0 {
        mesh.warnings.push(format!(
            "{odd_texcoords} faces have another number of texture coordinates than of vertices; \
             missing ones are taken as zero"
        ));
    }
    if short_lines > 0 {
        mesh.warnings.push(format!("{short_lines} lines have fewer than two vertices; left out"));
    }
    Ok(())
}

fn read_edges<R: BufRead>(
    rows: &mut Rows<'_, R>,
    ends: [usize; 2],
    mesh: &mut Mesh,
) -> Result<(), LoadProblem> {
    let element = rows.element;
    let wanted = wanted(element, Kind::Lines);
    let place = |i: usize| {
        let of_color = wanted.numbers.iter().position(|number| *number == Some(i));
        ends.iter().position(|end| *end == i).map(|end| ENDS + end).or(of_color)
    };
    let columns: Vec<_> = (0..element.properties.len()).map(place).collect();
    mesh.warnings.extend(names::not_used(element, |i| columns[i].is_some()));
    let vertices = rows.vertices;
    let mut bad = None;
    let mut index = 0;
    rows.for_each_row::<{ ENDS + 2 }>(&columns, |row| {
        let edge = [row[ENDS], row[ENDS + 1]];
        match edge.map(vertex_index) {
            [Some(a), Some(b)] => {
                push_lines(mesh, std::iter::once([a, b]), color(element, &wanted, row));
            }
            _ => bad = bad.or(Some((index, edge))),
        }
        index += 1;
    })?;
    match bad {
        None => Ok(()),
        Some((index, edge)) => Err(LoadProblem::VertexOutOfRange {
            element: element.name.clone(),
            index,
            vertex: edge.into_iter().find(|end| vertex_index(*end).is_none()).unwrap_or(0.0) as i64,
            count: vertices as usize,
        }),
    }
}

/// Adds lines of this colour. The array of colours stays empty while all are white.
fn push_lines(mesh: &mut Mesh, lines: impl Iterator<Item = [u32; 2]>, color: Vec4) {
    let before = mesh.lines.len();
    mesh.lines.extend(lines);
    if color != Vec4::ONE || !mesh.line_colors.is_empty() {
        mesh.line_colors.resize(before, Vec4::ONE);
        mesh.line_colors.resize(mesh.lines.len(), color);
    }
}

impl Corners {
    /// Returns the number of a corner.
    fn number(&mut self, vertex: u32, texcoord: Vec2) -> u32 {
        // More corners than `u32` counts are refused later.
        let next = self.corners.len() as u32;
        let key = (vertex, texcoord.to_array().map(f32::to_bits));
        let number = *self.numbers.entry(key).or_insert(next);
        if number == next {
            self.corners.push((vertex, texcoord));
        }
        number
    }

    /// Makes the corners the vertices of the mesh, if there are any. Their vertices exist, which
    /// has been checked.
    pub(super) fn become_vertices(mut self, mesh: &mut Mesh) -> Result<(), LoadProblem> {
        if self.corners.is_empty() {
            return Ok(());
        }
        mesh.check_lines_and_points()?;
        let ends = mesh.lines.as_flattened_mut().iter_mut();
        ends.chain(&mut mesh.points).for_each(|vertex| *vertex = self.number(*vertex, Vec2::ZERO));
        let vertices: Vec<u32> = self.corners.iter().map(|(vertex, _)| *vertex).collect();
        mesh.warnings.extend(not_named(&mesh.positions, vertices.iter().copied()));
        mesh.gather(&vertices);
        mesh.texcoords = self.corners.into_iter().map(|(_, texcoord)| texcoord).collect();
        // The new vertices have not been checked.
        mesh.sound = false;
        Ok(())
    }
}
