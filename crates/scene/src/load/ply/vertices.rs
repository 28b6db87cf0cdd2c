//! The vertices of a PLY file.

use super::{header::Type, rows::Rows};
use crate::{LoadError, load::mesh::Mesh, texture::linear_from_srgb};
use glam::{Vec2, Vec3, Vec4};
use std::io::BufRead;

/// Where the numbers of a vertex go, by all names in use.
const COLUMNS: [&[&str]; 13] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx"],
    &["ny"],
    &["nz"],
    &["u", "s", "texture_u"],
    &["v", "t", "texture_v"],
    &["red", "r", "diffuse_red"],
    &["green", "g", "diffuse_green"],
    &["blue", "b", "diffuse_blue"],
    &["alpha", "a"],
    &["radius"],
];
const POSITION: usize = 0;
const NORMAL: usize = 3;
const TEXCOORD: usize = 6;
const COLOR: usize = 8;
const ALPHA: usize = 11;
const RADIUS: usize = 12;

/// Reads positions and whatever else of the above there is; other properties are passed over.
///
/// Colours in integers are sRGB, as in images, of which the largest integer stands for 1; colours
/// in floating point are linear.
pub(super) fn read<R: BufRead>(rows: &mut Rows<'_, R>, mesh: &mut Mesh) -> Result<(), LoadError> {
    let mut types = [None; COLUMNS.len()];
    let mut columns = Vec::new();
    for property in &rows.element.properties {
        let named = COLUMNS.iter().position(|names| names.contains(&property.name.as_str()));
        // The first of two properties with one meaning counts.
        let column = named.filter(|&i| property.count.is_none() && types[i].is_none());
        if let Some(i) = column {
            types[i] = Some(property.item);
        }
        columns.push(column);
    }
    let has = |first: usize, count: usize| types[first..first + count].iter().all(Option::is_some);
    let (normals, texcoords) = (has(NORMAL, 3), has(TEXCOORD, 2));
    let (colors, alpha, radii) = (has(COLOR, 3), has(ALPHA, 1), has(RADIUS, 1));
    if !has(POSITION, 3) {
        return Err(LoadError::PlyHeader {
            path: rows.input.path.clone(),
            line: 1,
            problem: "the vertices have no properties x, y and z".to_owned(),
        });
    }
    // The file was found long enough for this many.
    let count = rows.element.count as usize;
    mesh.positions.reserve_exact(count);
    if radii {
        mesh.radii.reserve_exact(count);
    }
    let channel = |row: &[f32; COLUMNS.len()], i: usize| match types[i] {
        Some(Type::F32 | Type::F64) | None => row[i],
        Some(integer) if i == ALPHA => row[i] / integer.one(),
        Some(integer) => linear_from_srgb(row[i] / integer.one()),
    };
    rows.for_each_row(&columns, |row| {
        mesh.positions.push(Vec3::from_slice(&row[POSITION..]));
        if normals {
            mesh.normals.push(Vec3::from_slice(&row[NORMAL..]));
        }
        if texcoords {
            mesh.texcoords.push(Vec2::new(row[TEXCOORD], 1.0 - row[TEXCOORD + 1]));
        }
        if colors {
            let [r, g, b] = [0, 1, 2].map(|i| channel(row, COLOR + i));
            mesh.colors.push(Vec4::new(r, g, b, if alpha { channel(row, ALPHA) } else { 1.0 }));
        }
        if radii {
            mesh.radii.push(row[RADIUS]);
        }
    })
}
