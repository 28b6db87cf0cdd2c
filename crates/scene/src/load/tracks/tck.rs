//! Reader of TCK files.
//!
//! A header in text, of lines `key: value` up to the line `END`, names the type of the numbers and
//! where they begin. Then follow points, a triplet of NaN after each streamline, and one of
//! infinities at the end. Coordinates are in millimeters of the scanner.
//!
//! Source: the documentation of MRtrix3, "Tracks file format (.tck)".

use super::{Bundle, byte_order::ByteOrder};
use crate::load::{error::LoadProblem, mesh::Mesh};
use glam::DVec3;

/// Reads all streamlines of a file.
pub(crate) fn read(bytes: &[u8]) -> Result<Mesh, LoadProblem> {
    let header = header(bytes).map_err(|problem| LoadProblem::TracksHeader { problem })?;
    let Header { data, order, is_double, count } = header;
    let mut bundle = Bundle::default();
    let is_whole = if is_double {
        let (points, _) = data.as_chunks();
        fill(&mut bundle, points.iter().map(|point| order.point_f64(point)))?
    } else {
        let (points, _) = data.as_chunks();
        fill(&mut bundle, points.iter().map(|point| order.point_f32(point)))?
    };
    if !is_whole {
        return Err(bundle.refuse(
            "the file ends before the three infinities that mark the end; it is cut, copy it again"
                .to_owned(),
        ));
    }
    // Programs write this count last, so that it is wrong in files of those that were stopped.
    let found = bundle.count;
    let mut mesh = bundle.finish();
    if let Some(count) = count.filter(|&count| count != found) {
        mesh.warnings.push(format!("the header counts {count} streamlines, but there are {found}"));
    }
    Ok(mesh)
}

/// Adds streamlines up to the mark of the end; returns false if there is none.
fn fill(bundle: &mut Bundle, points: impl Iterator<Item = DVec3>) -> Result<bool, LoadProblem> {
    for point in points {
        let components = point.to_array();
        if components.iter().all(|x| x.is_nan()) {
            bundle.end()?;
        } else if components.iter().all(|x| x.is_infinite()) {
            if bundle.mesh.positions.len() > bundle.start {
                bundle.end()?;
            }
            return Ok(true);
        } else {
            bundle.push(point)?;
        }
    }
    Ok(false)
}

struct Header<'a> {
    data: &'a [u8],
    order: ByteOrder,
    is_double: bool,
    count: Option<u64>,
}

fn header(bytes: &[u8]) -> Result<Header<'_>, String> {
    let mut rest = bytes;
    let mut line = || {
        // Between a carriage return and a line feed there is an empty line, which is skipped.
        let end = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r'))?;
        let (line, after) = (&rest[..end], &rest[end + 1..]);
        rest = after;
        Some((String::from_utf8_lossy(line).trim().to_owned(), bytes.len() - after.len()))
    };
    if line().is_none_or(|(first, _)| first != "mrtrix tracks") {
        return Err("does not begin with the line \"mrtrix tracks\"; is it a TCK file?".to_owned());
    }
    let (mut datatype, mut place, mut count) = (None, None, None);
    let end = loop {
        let Some((line, end)) = line() else {
            return Err("has no line \"END\"; it is cut, copy the file again".to_owned());
        };
        if line == "END" {
            break end;
        }
        // MRtrix skips lines without a key too.
        let Some((key, value)) = line.split_once(':') else { continue };
        match key.trim() {
            "datatype" => datatype = Some(value.trim().to_owned()),
            "file" => place = Some(value.trim().to_owned()),
            "count" => count = value.trim().parse().ok(),
            _ => {}
        }
    };
    let datatype = datatype.unwrap_or_default();
    let (order, is_double) = match datatype.to_ascii_lowercase().as_str() {
        "float32le" => (ByteOrder::Little, false),
        "float32be" => (ByteOrder::Big, false),
        "float64le" => (ByteOrder::Little, true),
        "float64be" => (ByteOrder::Big, true),
        _ => {
            return Err(format!(
                "\"datatype\" is {datatype:?}, expected Float32LE, Float32BE, Float64LE or \
                 Float64BE; convert the file with tckconvert"
            ));
        }
    };
    let place = place.unwrap_or_default();
    let offset = place.strip_prefix('.').and_then(|offset| offset.trim().parse::<usize>().ok());
    let Some(offset) = offset.filter(|offset| (end..=bytes.len()).contains(offset)) else {
        return Err(format!(
            "\"file\" is {place:?}, expected a dot and the place of the data, from {end}, where \
             the header ends, to {}, where the file does",
            bytes.len()
        ));
    };
    Ok(Header { data: &bytes[offset..], order, is_double, count })
}
