//! Reader of OBJ files: `v` with or without a colour, `vt`, `vn`, the elements `f`, `l` and `p`,
//! and the materials that `mtllib` and `usemtl` name. Other statements are skipped, with a warning.
//!
//! Available libraries convert polylines to triangles or skip points.

mod corners;
pub(super) mod mtl;

use super::{
    colors::Scale,
    error::LoadProblem,
    far, file,
    mesh::{Look, Mesh, MeshMaterial, NO_MATERIAL, listed},
};
use corners::Corners;
use glam::{DVec3, Vec2, Vec3, Vec4};
use rotund_image::linear_from_srgb;
use std::collections::{BTreeMap, HashMap};

/// Reads all objects of a file into one mesh.
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, LoadProblem> {
    let text = String::from_utf8_lossy(file::text(bytes)?);
    let mut reader = Reader::default();
    let mut begun = String::new();
    // The empty line ends a last line with a continuation mark.
    for (number, line) in file::lines(&text).chain([""]).enumerate() {
        if let Some(part) = line.strip_suffix('\\') {
            begun.extend([part, " "]);
            continue;
        }
        let number = number + 1;
        let whole = if begun.is_empty() { line } else { &format!("{begun}{line}") };
        reader
            .line(number, whole)
            .map_err(|problem| LoadProblem::ObjLine { line: number, problem })?;
        begun.clear();
    }
    reader.finish()
}

#[derive(Default)]
struct Reader {
    positions: Vec<DVec3>,
    /// Colours of the positions, not yet linear; empty or as many.
    colors: Vec<Vec4>,
    /// Colours that ZBrush writes in comments, of all vertices in their order.
    of_comments: Vec<Vec4>,
    texcoords: Vec<Vec2>,
    normals: Vec<Vec3>,
    mesh: Mesh,
    corners: Corners,
    /// The material of the faces and lines that follow.
    material: Option<u32>,
    materials: HashMap<String, u32>,
    /// The number of lines of fewer than two vertices.
    short_lines: usize,
    /// How often each statement occurs that is not understood.
    unknown: BTreeMap<String, usize>,
}

impl Reader {
    fn line(&mut self, line_number: usize, line: &str) -> Result<(), String> {
        let line = line.trim_ascii();
        if let Some(hex) = line.strip_prefix("#MRGB ") {
            self.of_comments.extend(hex.trim_ascii().as_bytes().chunks(8).map_while(masked_color));
        }
        let said = line.split('#').next().unwrap_or_default();
        let mut words = said.split_ascii_whitespace();
        let keyword = words.next().unwrap_or_default();
        // Names may have blanks and number signs.
        let name = || line[keyword.len()..].trim_ascii();
        match keyword {
            "v" => self.vertex(words)?,
            "vn" => {
                let ([x, y, z], _) = numbers(words, 3)?;
                self.normals.push(DVec3::new(x, y, z).as_vec3());
            }
            "vt" => {
                let ([u, v], _) = numbers(words, 1)?;
                self.texcoords.push(Vec2::new(u as f32, (1.0 - v) as f32));
            }
            "f" | "l" | "p" => self.element(line_number, keyword, words)?,
            "usemtl" => {
                self.material = Some(name()).filter(|n| !n.is_empty()).map(|n| self.material(n));
            }
            "mtllib" => self.mesh.libraries.push(name().trim_matches('"').to_owned()),
            // Names of groups, smoothing of normals that the file does not have, and display.
            "" | "o" | "g" | "s" | "mg" | "lod" | "bevel" | "c_interp" | "d_interp" => {}
            other => *self.unknown.entry(other.chars().take(24).collect()).or_default() += 1,
        }
        Ok(())
    }

    /// Adds a vertex: three coordinates, and after them a weight, a colour, or both.
    fn vertex<'w>(&mut self, words: impl Iterator<Item = &'w str>) -> Result<(), String> {
        let ([x, y, z, a, b, c, d], count) = numbers(words, 3)?;
        let color = match count {
            6 => Some([a, b, c, 1.0]),
            7 => Some([a, b, c, d]),
            _ => None,
        };
        if let Some(color) = color {
            self.colors.resize(self.positions.len(), Vec4::ONE);
            self.colors.push(Vec4::from_array(color.map(|c| c as f32)));
        } else if !self.colors.is_empty() {
            self.colors.push(Vec4::ONE);
        }
        self.positions.push(DVec3::new(x, y, z));
        Ok(())
    }

    fn element<'w>(
        &mut self,
        line_number: usize,
        keyword: &str,
        words: impl Iterator<Item = &'w str>,
    ) -> Result<(), String> {
        let counts = [self.positions.len(), self.texcoords.len(), self.normals.len()];
        let vertices = words
            .map(|word| self.corners.number(word, counts, line_number))
            .collect::<Result<Vec<u32>, String>>()?;
        match keyword {
            "f" => {
                let material = self.material.unwrap_or(NO_MATERIAL);
                self.mesh.faces.push_polygon(&vertices, Look { material, ..Look::default() });
            }
            "l" => {
                self.short_lines += usize::from(vertices.len() < 2);
                let mesh = &mut self.mesh;
                mesh.lines.extend(vertices.windows(2).map(|pair| [pair[0], pair[1]]));
                let material = self.material.unwrap_or(NO_MATERIAL);
                mesh.line_materials.resize(mesh.lines.len(), material);
            }
            _ => self.mesh.points.extend(vertices),
        }
        Ok(())
    }

    fn material(&mut self, name: &str) -> u32 {
        if let Some(&index) = self.materials.get(name) {
            return index;
        }
        let index = self.mesh.materials.len() as u32;
        self.mesh.materials.push(MeshMaterial { name: name.to_owned(), ..MeshMaterial::default() });
        self.materials.insert(name.to_owned(), index);
        index
    }

    fn finish(mut self) -> Result<Mesh, LoadProblem> {
        let mut mesh = self.mesh;
        if self.short_lines > 0 {
            let count = self.short_lines;
            mesh.warnings.push(format!("{count} lines have fewer than two vertices; left out"));
        }
        if !self.unknown.is_empty() {
            let names: Vec<String> =
                self.unknown.iter().map(|(name, count)| format!("{name} ({count})")).collect();
            mesh.warnings.push(format!("statements that are not used: {}", listed(&names)));
        }
        if self.colors.is_empty() && !self.of_comments.is_empty() {
            let (count, vertices) = (self.of_comments.len(), self.positions.len());
            if count == vertices {
                self.colors = self.of_comments;
            } else {
                mesh.warnings.push(format!(
                    "the colours of #MRGB are not used: there are {count} for {vertices} vertices"
                ));
            }
        }
        mesh.warnings.extend(settle_colors(&mut self.colors));
        (mesh.positions, mesh.offset) = far::to_single(&self.positions);
        mesh.colors = self.colors;
        // Vertices without any elements are a point cloud.
        self.corners.become_vertices(&mut mesh, &self.texcoords, &self.normals)?;
        Ok(mesh)
    }
}

/// Parses a mask and the channels of a colour, two hexadecimal digits each, as in `ff8040c0`.
fn masked_color(digits: &[u8]) -> Option<Vec4> {
    let number = u32::from_str_radix(str::from_utf8(digits).ok()?, 16).ok()?;
    let [_, r, g, b] = number.to_be_bytes().map(|byte| f32::from(byte) / 255.0);
    (digits.len() == 8).then_some(Vec4::new(r, g, b, 1.0))
}

/// Converts colours, which programs write as in images, to linear ones; returns a warning about
/// those beyond 1.
fn settle_colors(colors: &mut [Vec4]) -> Option<String> {
    let scale = Scale::of(colors.iter().map(|color| [color.x, color.y, color.z]));
    if scale.is_of_bytes() {
        return scale.settle(colors);
    }
    for color in &mut *colors {
        let [r, g, b] = [color.x, color.y, color.z].map(linear_from_srgb);
        *color = Vec4::new(r, g, b, color.w);
    }
    scale.settle(colors)
}

/// Parses up to `N` numbers of a line, the others being zero, and returns how many there are.
/// Refuses fewer than `least`.
fn numbers<'w, const N: usize>(
    words: impl Iterator<Item = &'w str>,
    least: usize,
) -> Result<([f64; N], usize), String> {
    let mut numbers = [0.0; N];
    let mut count = 0;
    for (number, word) in numbers.iter_mut().zip(words) {
        *number = match word.parse() {
            Ok(number) => number,
            Err(_) if count >= least => break,
            Err(_) => return Err(format!("{word:?} is not a number")),
        };
        count += 1;
    }
    if count < least {
        return Err(format!("expected {least} numbers"));
    }
    Ok((numbers, count))
}
