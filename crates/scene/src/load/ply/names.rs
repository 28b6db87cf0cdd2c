//! The names of elements and properties that programs use, and those that are not used here.

use super::header::{Element, Property};

/// What the lists of vertices of an element are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Faces,
    /// Triangles that share edges with their neighbours; -1 begins a new strip.
    Strips,
    Lines,
    Points,
}

/// Returns the kind of an element by its name.
pub(super) fn kind(element: &Element) -> Option<Kind> {
    Some(match element.name.to_ascii_lowercase().as_str() {
        "face" | "faces" | "polygon" | "polygons" | "triangle" | "triangles" => Kind::Faces,
        "tristrip" | "tristrips" => Kind::Strips,
        "line" | "lines" | "edge" | "edges" | "polyline" | "polylines" => Kind::Lines,
        "point" | "points" => Kind::Points,
        _ => return None,
    })
}

/// Returns the index of the property that lists vertices: by its name, or the only list of
/// integers.
pub(super) fn vertex_list(element: &Element) -> Option<usize> {
    const NAMES: [&str; 6] =
        ["vertex_indices", "vertex_index", "vertex_indexes", "vertices", "vertex", "indices"];
    let properties = &element.properties;
    let named = |p: &Property| p.count.is_some() && NAMES.contains(&plain(&p.name).as_str());
    if let Some(found) = properties.iter().position(named) {
        return Some(found);
    }
    let may_be = |p: &Property| p.count.is_some() && p.item.is_integer();
    let mut lists = (0..properties.len()).filter(|&i| may_be(&properties[i]));
    lists.next().filter(|_| lists.next().is_none())
}

/// Returns the indices of the two properties that are the ends of an edge.
pub(super) fn ends(element: &Element) -> Option<[usize; 2]> {
    const NAMES: [[&str; 2]; 5] = [
        ["vertex1", "vertex2"],
        ["vertex_1", "vertex_2"],
        ["vertex0", "vertex1"],
        ["v1", "v2"],
        ["start", "end"],
    ];
    let find = |name: &str| {
        element.properties.iter().position(|p| p.count.is_none() && plain(&p.name) == name)
    };
    NAMES.iter().find_map(|&[first, second]| Some([find(first)?, find(second)?]))
}

/// Returns a name in lower case, without the prefix that CloudCompare gives to scalar fields.
pub(super) fn plain(name: &str) -> String {
    let name = name.to_ascii_lowercase();
    name.strip_prefix("scalar_").map(str::to_owned).unwrap_or(name)
}

/// Returns the warning about the properties of an element that are not used; `None` if all are.
pub(super) fn not_used(element: &Element, is_used: impl Fn(usize) -> bool) -> Option<String> {
    if element.count == 0 {
        return None;
    }
    let unused = (0..element.properties.len()).filter(|&i| !is_used(i));
    let names: Vec<&str> = unused.map(|i| element.properties[i].name.as_str()).collect();
    let names = crate::load::mesh::listed(&in_short(&names));
    (!names.is_empty()).then(|| format!("not used of element {}: {names}", element.name))
}

/// Joins names that differ by a number at the end, as in `f_rest_0 to f_rest_44`.
fn in_short(names: &[&str]) -> Vec<String> {
    let stem = |name: &str| name.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    let runs = names.chunk_by(|a, b| {
        let (of_a, of_b) = (stem(a), stem(b));
        of_a < a.len() && of_b < b.len() && a[..of_a] == b[..of_b]
    });
    runs.map(|run| match run {
        [first, _, .., last] => format!("{first} to {last}"),
        run => run.join(", "),
    })
    .collect()
}
