//! Reader of OBJ files: `v`, `vt`, `vn`, and the elements `f`, `l` and `p`. Other statements are
//! skipped.
//!
//! Available libraries convert polylines to triangles or skip points.

use super::{error::LoadProblem, file, mesh::Mesh};
use glam::{Vec2, Vec3};
use std::collections::HashMap;

/// Reads all objects of a file into one mesh.
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, LoadProblem> {
    let text = String::from_utf8_lossy(file::text(bytes)?);
    let mut reader = Reader::default();
    let mut begun = String::new();
    // The empty line ends a last line with a continuation mark.
    for (number, line) in text.lines().chain([""]).enumerate() {
        if let Some(part) = line.strip_suffix('\\') {
            begun.extend([part, " "]);
            continue;
        }
        reader.line_number = number + 1;
        let whole = if begun.is_empty() { line } else { &format!("{begun}{line}") };
        reader.line(whole).map_err(|problem| LoadProblem::ObjLine { line: number + 1, problem })?;
        begun.clear();
    }
    Ok(reader.finish())
}

/// Indices of a position, a texture coordinate and a normal.
type Corner = (u32, Option<u32>, Option<u32>);

#[derive(Default)]
struct Reader {
    /// Number of the current line, for messages.
    line_number: usize,
    positions: Vec<Vec3>,
    texcoords: Vec<Vec2>,
    normals: Vec<Vec3>,
    mesh: Mesh,
    /// The vertex of each corner so far.
    vertices: HashMap<Corner, u32>,
    corners: Vec<Corner>,
}

impl Reader {
    fn line(&mut self, line: &str) -> Result<(), String> {
        let said = line.split('#').next().unwrap_or_default();
        let mut words = said.split_ascii_whitespace();
        let keyword = words.next().unwrap_or_default();
        match keyword {
            "v" => self.positions.push(Vec3::from(numbers(words)?)),
            "vn" => self.normals.push(Vec3::from(numbers(words)?)),
            "vt" => {
                let [u, v] = numbers(words)?;
                self.texcoords.push(Vec2::new(u, 1.0 - v));
            }
            "f" | "l" | "p" => {
                let vertices =
                    words.map(|word| self.vertex(word)).collect::<Result<Vec<u32>, String>>()?;
                let least = match keyword {
                    "f" => 3,
                    "l" => 2,
                    _ => 1,
                };
                if vertices.len() < least {
                    let found = vertices.len();
                    return Err(format!(
                        "\"{keyword}\" names {found} vertices, expected {least} or more"
                    ));
                }
                match keyword {
                    "f" => self.mesh.faces.push_polygon(&vertices),
                    "l" => {
                        self.mesh.lines.extend(vertices.windows(2).map(|pair| [pair[0], pair[1]]));
                    }
                    _ => self.mesh.points.extend(vertices),
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Returns the vertex for a word such as `1`, `1/2`, `1//3` or `1/2/3`. A missing normal is a
    /// warning and no error, since versions of yocto-gl have written such files.
    fn vertex(&mut self, word: &str) -> Result<u32, String> {
        let mut parts = word.split('/');
        let mut index = |count: usize, what: &str| match parts.next() {
            None | Some("") => Ok(None),
            // Indices count from 1, or backwards from -1, the last one so far.
            Some(part) => part
                .parse::<i64>()
                .ok()
                .and_then(|i| if i < 0 { (count as i64).checked_add(i) } else { i.checked_sub(1) })
                .filter(|i| (0..count as i64).contains(i))
                .and_then(|i| u32::try_from(i).ok())
                .map(Some)
                .ok_or_else(|| {
                    format!("{word:?} names {what} {part}, but there are {count} so far")
                }),
        };
        let position = index(self.positions.len(), "vertex")?
            .ok_or_else(|| format!("{word:?} names no vertex"))?;
        let texcoord = index(self.texcoords.len(), "texture coordinate")?;
        let normal = index(self.normals.len(), "normal").unwrap_or_else(|problem| {
            let line = self.line_number;
            if self.mesh.warnings.is_empty() {
                let warning = format!("line {line}: {problem}; no normals are taken from the file");
                self.mesh.warnings.push(warning);
            }
            None
        });
        let corner = (position, texcoord, normal);
        let next = self.corners.len() as u32;
        let vertex = *self.vertices.entry(corner).or_insert(next);
        if vertex == next {
            self.corners.push(corner);
        }
        Ok(vertex)
    }

    fn finish(self) -> Mesh {
        let mut mesh = self.mesh;
        // Vertices without any elements are a point cloud.
        if self.corners.is_empty() {
            mesh.positions = self.positions;
            return mesh;
        }
        for &(position, _, _) in &self.corners {
            mesh.positions.push(self.positions[position as usize]);
        }
        if self.corners.iter().all(|corner| corner.1.is_some()) {
            let texcoords = self.corners.iter().filter_map(|corner| corner.1);
            mesh.texcoords = texcoords.map(|i| self.texcoords[i as usize]).collect();
        }
        if self.corners.iter().all(|corner| corner.2.is_some()) {
            let normals = self.corners.iter().filter_map(|corner| corner.2);
            mesh.normals = normals.map(|i| self.normals[i as usize]).collect();
        }
        mesh
    }
}

/// Parses the first `N` numbers of a line.
fn numbers<'a, const N: usize>(
    mut words: impl Iterator<Item = &'a str>,
) -> Result<[f32; N], String> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        let word = words.next().ok_or_else(|| format!("expected {N} numbers"))?;
        *number = word.parse().map_err(|_| format!("{word:?} is not a number"))?;
    }
    Ok(numbers)
}
