//! Reader of TRK files, version 1 and 2.
//!
//! A header of 1000 bytes, whose last number gives away the byte order, and for each streamline the
//! number of its points, the points, each with scalars, and properties. Coordinates count in
//! millimeters from the corner of the first voxel. Version 2 adds the transform of voxels to the
//! space of the scanner.
//!
//! Source: the documentation of TrackVis, "File Format"; the order of axes is understood as by
//! NiBabel.

use super::{Bundle, byte_order::ByteOrder, orientation::Orientation};
use crate::load::{
    error::LoadProblem,
    mesh::{Mesh, listed},
};
use glam::{DAffine3, DMat3, DVec3};

/// Reads all streamlines of a file.
///
/// Memory is bounded by the bytes read, not by the counts in the file.
pub(crate) fn read(bytes: &[u8]) -> Result<Mesh, LoadProblem> {
    let header = Header::parse(bytes).map_err(|problem| LoadProblem::TracksHeader { problem })?;
    let mut bundle = Bundle::default();
    let mut rest = bytes.get(SIZE..).unwrap_or_default();
    // A count of 0 means that it is not known.
    while if header.count == 0 { !rest.is_empty() } else { bundle.count < header.count } {
        if rest.is_empty() {
            return Err(LoadProblem::TracksHeader {
                problem: format!(
                    "n_count is {}, but the file ends after {} streamlines; it is cut, copy it \
                     again",
                    header.count, bundle.count
                ),
            });
        }
        rest = streamline(&header, rest, &mut bundle)?;
    }
    let found = bundle.count;
    let mut mesh = bundle.finish();
    if !rest.is_empty() {
        mesh.warnings.push(format!(
            "{} bytes after the {found} streamlines that n_count tells of are not read",
            rest.len()
        ));
    }
    mesh.warnings.extend(header.warnings);
    Ok(mesh)
}

/// Reads a streamline; returns what follows it.
fn streamline<'a>(
    header: &Header,
    bytes: &'a [u8],
    bundle: &mut Bundle,
) -> Result<&'a [u8], LoadProblem> {
    let Some((count, rest)) = bytes.split_first_chunk() else {
        let problem = "the file ends within the number of its points; it is cut, copy it again";
        return Err(bundle.refuse(problem.to_owned()));
    };
    let count = header.order.i32(*count);
    let Ok(point_count) = usize::try_from(count) else {
        return Err(bundle.refuse(format!(
            "the number of points is {count}, expected one that is not negative; the file is \
             damaged, or n_scalars and n_properties of the header are wrong"
        )));
    };
    let size = point_count.checked_mul(header.point_size);
    let size = size.and_then(|size| size.checked_add(header.properties_size));
    let Some((whole, rest)) = size.and_then(|size| rest.split_at_checked(size)) else {
        return Err(bundle.refuse(format!(
            "the number of points is {count}, but the file ends after {}; it is cut, or n_scalars \
             and n_properties of the header are wrong",
            rest.len() / header.point_size
        )));
    };
    let (points, _) = whole.split_at(point_count * header.point_size);
    for point in points.chunks_exact(header.point_size) {
        let Some(point) = point.first_chunk() else { continue };
        bundle.push(header.space_from_file.transform_point3(header.order.point_f32(point)))?;
    }
    bundle.end()?;
    Ok(rest)
}

/// The size of the header.
const SIZE: usize = 1000;

struct Header {
    order: ByteOrder,
    /// Bytes of a point with its scalars.
    point_size: usize,
    /// Bytes of the properties of a streamline.
    properties_size: usize,
    /// The number of streamlines; 0 if it is not known.
    count: u64,
    space_from_file: DAffine3,
    warnings: Vec<String>,
}

impl Header {
    fn parse(bytes: &[u8]) -> Result<Self, String> {
        if !bytes.starts_with(b"TRACK") {
            return Err("does not begin with \"TRACK\"; is it a TRK file?".to_owned());
        }
        let Some(bytes) = bytes.first_chunk::<SIZE>() else {
            let length = bytes.len();
            return Err(format!("has {length} bytes, expected {SIZE}; it is cut, copy it again"));
        };
        let orders = [ByteOrder::Little, ByteOrder::Big];
        let hdr_size = |order: &ByteOrder| order.i32(array(bytes, 996)) == SIZE as i32;
        let Some(order) = orders.into_iter().find(hdr_size) else {
            let found = ByteOrder::Little.i32(array(bytes, 996));
            return Err(format!("hdr_size is {found}, expected {SIZE} in either byte order"));
        };
        let sizes = [("n_scalars", 36), ("n_properties", 238)].map(|(name, at)| {
            let count = order.i16(array(bytes, at));
            let refused = |_| format!("{name} is {count}, expected a number that is not negative");
            usize::try_from(count).map(|count| 4 * count).map_err(refused)
        });
        let [scalars_size, properties_size] = sizes;
        let (scalars_size, properties_size) = (scalars_size?, properties_size?);
        let more = not_used(bytes, scalars_size / 4, properties_size / 4);
        let count = order.i32(array(bytes, 988));
        let refused = |_| format!("n_count is {count}, expected 0, for unknown, or more");
        let (space_from_file, warning) = space_from_file(bytes, order)?;
        Ok(Self {
            order,
            point_size: 12 + scalars_size,
            properties_size,
            count: u64::try_from(count).map_err(refused)?,
            space_from_file,
            warnings: warning.into_iter().chain(more).collect(),
        })
    }
}

/// Returns the warning about numbers beside the points, by the names that the header has for the
/// first ten of each kind.
fn not_used(bytes: &[u8; SIZE], scalars: usize, properties: usize) -> Option<String> {
    let name = |what: &str, at: usize, i: usize| {
        let field = bytes[at..at + 200].chunks(20).nth(i).unwrap_or_default();
        // NiBabel writes a name, a zero and the number of values into a field.
        let text = field.split(|&byte| byte == 0).next().unwrap_or_default();
        match String::from_utf8_lossy(text).trim() {
            "" => format!("{what} {}", i + 1),
            name => format!("{what} {name}"),
        }
    };
    let of_points = (0..scalars).map(|i| name("scalar", 38, i));
    let of_lines = (0..properties).map(|i| name("property", 240, i));
    let names: Vec<String> = of_points.chain(of_lines).collect();
    (!names.is_empty()).then(|| format!("not used of the streamlines: {}", listed(&names)))
}

/// Returns the transform of coordinates in the file to those of the scanner, with the text of a
/// warning if the order of the axes is not known.
fn space_from_file(
    bytes: &[u8; SIZE],
    order: ByteOrder,
) -> Result<(DAffine3, Option<String>), String> {
    let float = |at: usize| f64::from(order.f32(array(bytes, at)));
    let entry = |row: usize, column: usize| float(440 + 16 * row + 4 * column);
    let letters: Vec<u8> = bytes[948..952].iter().copied().filter(u8::is_ascii_graphic).collect();
    let parsed = Orientation::parse(&letters);
    let has_transform = order.i32(array(bytes, 992)) >= 2 && entry(3, 3) != 0.0;
    let warning = (parsed.is_none() && !letters.is_empty()).then(|| {
        let letters = String::from_utf8_lossy(&letters).into_owned();
        format!("voxel_order is {letters:?}, expected three letters as in RAS; the axes are kept")
    });
    if !has_transform {
        // Nobody knows where the image was, but its axes have directions.
        let matrix = parsed.map_or(DMat3::IDENTITY, Orientation::matrix);
        return Ok((DAffine3::from_mat3(matrix), warning));
    }
    let column = |column| DVec3::new(entry(0, column), entry(1, column), entry(2, column));
    let space_from_voxel = DAffine3::from_cols(column(0), column(1), column(2), column(3));
    let determinant = space_from_voxel.matrix3.determinant();
    if !space_from_voxel.is_finite() || determinant == 0.0 || !determinant.is_finite() {
        let matrix = space_from_voxel.to_cols_array();
        return Err(format!(
            "vox_to_ras has the columns {matrix:?}, expected a transform that has an inverse; \
             write 0 as its last number if it is not known"
        ));
    }
    let voxel_size = DVec3::new(float(12), float(16), float(20));
    if !(voxel_size.is_finite() && voxel_size.min_element() > 0.0) {
        return Err(format!("voxel_size is {voxel_size}, expected three positive numbers"));
    }
    let dimensions = [6, 8, 10].map(|at| f64::from(order.i16(array(bytes, at)).max(1)));
    // Files without an order are by TrackVis itself; one that is not known is the order of the
    // transform.
    let of_transform = Orientation::nearest(space_from_voxel.matrix3);
    let of_file = match parsed {
        Some(orientation) => orientation,
        None if letters.is_empty() => Orientation::LPS,
        None => of_transform,
    };
    let voxel_from_file = DAffine3 {
        matrix3: DMat3::from_diagonal(voxel_size.recip()),
        translation: DVec3::splat(-0.5),
    };
    let reordered = of_file.to(of_transform, DVec3::from(dimensions));
    Ok((space_from_voxel * reordered * voxel_from_file, warning))
}

/// Returns the bytes at a place of the header, which ends after them.
fn array<const N: usize>(bytes: &[u8; SIZE], at: usize) -> [u8; N] {
    let mut array = [0; N];
    array.copy_from_slice(&bytes[at..at + N]);
    array
}
