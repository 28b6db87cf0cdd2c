//! The meaning of the columns of a table, by their names or by their values.

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    X,
    Y,
    Z,
    Red,
    Green,
    Blue,
    Alpha,
    Intensity,
    Radius,
    Diameter,
    NormalX,
    NormalY,
    NormalZ,
}

impl Role {
    pub(super) const COUNT: usize = 13;
    pub(super) const POSITION: [Self; 3] = [Self::X, Self::Y, Self::Z];
    pub(super) const COLOR: [Self; 3] = [Self::Red, Self::Green, Self::Blue];
    pub(super) const NORMAL: [Self; 3] = [Self::NormalX, Self::NormalY, Self::NormalZ];
}

/// The columns of a table.
#[derive(Debug, PartialEq)]
pub(super) struct Columns {
    /// The role of each column that has one.
    pub roles: Vec<Option<Role>>,
    /// Names of columns that are not used.
    pub unused: Vec<String>,
}

impl Columns {
    pub(super) fn has(&self, role: Role) -> bool {
        self.roles.contains(&Some(role))
    }
}

/// Returns the columns of these names; `None` without x, y and z.
pub(super) fn by_name(names: &[&str]) -> Option<Columns> {
    let plain: Vec<String> = names.iter().map(|name| plain(name)).collect();
    let mut roles: Vec<Option<Role>> = plain.iter().map(|name| role(name)).collect();
    // Of several columns of one meaning, the first counts.
    for i in 0..roles.len() {
        if roles[i].is_some() && roles[..i].contains(&roles[i]) {
            roles[i] = None;
        }
    }
    let has_all = |wanted: [Role; 3], roles: &[Option<Role>]| {
        wanted.iter().all(|r| roles.contains(&Some(*r)))
    };
    if !has_all(Role::COLOR, &roles) {
        // A lone r is a radius.
        let lone = |i: usize| plain[i] == "r" && !roles.contains(&Some(Role::Radius));
        let radius = (0..plain.len()).find(|&i| lone(i));
        roles.iter_mut().filter(|r| r.is_some_and(|r| Role::COLOR.contains(&r))).for_each(|r| {
            *r = None;
        });
        if let Some(i) = radius {
            roles[i] = Some(Role::Radius);
        }
    }
    if !has_all(Role::NORMAL, &roles) {
        let is_normal = |r: &Option<Role>| r.is_some_and(|r| Role::NORMAL.contains(&r));
        roles.iter_mut().filter(|r| is_normal(r)).for_each(|r| *r = None);
    }
    if roles.contains(&Some(Role::Red)) {
        roles.iter_mut().filter(|r| **r == Some(Role::Intensity)).for_each(|r| *r = None);
    }
    if !has_all(Role::POSITION, &roles) {
        return None;
    }
    let named = names.iter().zip(&roles).filter(|(name, role)| role.is_none() && !name.is_empty());
    let unused = named.map(|(name, _)| (*name).to_owned()).collect();
    Some(Columns { roles, unused })
}

/// Returns a name in lower case without its unit and the usual prefixes.
fn plain(name: &str) -> String {
    let name = name.trim_matches(|c: char| c == '"' || c == '\'' || c.is_whitespace());
    let name = name.split(['(', '[', '{']).next().unwrap_or_default().trim();
    let name = name.to_ascii_lowercase().replace([' ', '-', '_', ':', '.'], "");
    let prefixes = ["scalar", "//", "#", "points", "position", "pos", "coord"];
    let without = prefixes.iter().find_map(|prefix| name.strip_prefix(prefix));
    let without = without.filter(|rest| !rest.is_empty()).unwrap_or(&name);
    ["coordinate", "coord"]
        .iter()
        .find_map(|end| without.strip_suffix(end))
        .unwrap_or(without)
        .into()
}

fn role(name: &str) -> Option<Role> {
    Some(match name {
        "x" | "0" | "easting" | "east" | "e" => Role::X,
        "y" | "1" | "northing" | "north" | "n" => Role::Y,
        "z" | "2" | "elevation" | "elev" | "height" | "altitude" | "h" => Role::Z,
        "red" | "r" | "rf" | "diffusered" | "colorr" | "rgb0" | "colors0" => Role::Red,
        "green" | "g" | "gf" | "diffusegreen" | "colorg" | "rgb1" | "colors1" => Role::Green,
        "blue" | "b" | "bf" | "diffuseblue" | "colorb" | "rgb2" | "colors2" => Role::Blue,
        "alpha" | "a" | "af" => Role::Alpha,
        "intensity" | "i" | "reflectance" | "reflectivity" | "amplitude" | "grey" | "gray" => {
            Role::Intensity
        }
        "radius" | "pscale" => Role::Radius,
        "diameter" | "size" | "width" => Role::Diameter,
        "nx" | "normalx" | "normals0" | "normal0" => Role::NormalX,
        "ny" | "normaly" | "normals1" | "normal1" => Role::NormalY,
        "nz" | "normalz" | "normals2" | "normal2" => Role::NormalZ,
        _ => return None,
    })
}

/// Returns the columns of a table without names: x, y and z from column `start`, and what these
/// rows show of the others. `is_pts` says that an intensity comes before a colour.
pub(super) fn by_values(rows: &[Vec<f64>], start: usize, is_pts: bool) -> Columns {
    let count = rows.iter().map(Vec::len).min().unwrap_or(0);
    if start == 0 && are_numbered(rows) {
        let mut columns = by_values(rows, 1, is_pts);
        columns.unused.insert(0, "column 1, which counts the rows".to_owned());
        return columns;
    }
    let mut roles = vec![None; count.max(start + 3)];
    let three =
        |at: usize, row: &[f64]| [row[start + 3 + at], row[start + 4 + at], row[start + 5 + at]];
    let all =
        |at: usize, test: &dyn Fn([f64; 3]) -> bool| rows.iter().all(|row| test(three(at, row)));
    let is_color = |at: usize| {
        all(at, &|c| c.iter().all(|x| (0.0..=255.0).contains(x) && x.fract() == 0.0))
            || all(at, &|c| c.iter().all(|x| (0.0..=1.0).contains(x)))
    };
    let is_wide_color = |at: usize| {
        all(at, &|c| c.iter().all(|x| (0.0..=65_535.0).contains(x) && x.fract() == 0.0))
    };
    let is_normal = |at: usize| {
        all(at, &|n| {
            let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
            length == 0.0 || (length - 1.0).abs() < 0.02
        }) && !all(at, &|n| n.iter().all(|x| *x == 0.0))
    };
    // Black, white and pure colours have length 0 or 1 too.
    let is_normal = |at: usize| is_normal(at) && !all(at, &|n| n.iter().all(|x| x.fract() == 0.0));
    let is_constant = |at: usize| {
        let value = |row: &Vec<f64>| row[start + 3 + at];
        rows.iter().all(|row| value(row) == value(&rows[0]) && matches!(value(row), 1.0 | 255.0))
    };
    let mut set = |at: usize, new: &[Role]| {
        for (i, role) in new.iter().enumerate() {
            roles[start + at + i] = Some(*role);
        }
    };
    set(0, &Role::POSITION);
    match count.saturating_sub(start + 3) {
        1 => set(3, &[Role::Intensity]),
        3 if is_normal(0) => set(3, &Role::NORMAL),
        3 if is_color(0) || is_wide_color(0) => set(3, &Role::COLOR),
        // Colour and alpha, or colour and intensity.
        4 if !is_pts && is_color(0) && is_constant(3) => {
            set(3, &Role::COLOR);
            set(6, &[Role::Alpha]);
        }
        4 if !is_pts && is_color(0) && !is_color(1) => set(3, &Role::COLOR),
        4 | 5 if is_color(1) || is_wide_color(1) => set(4, &Role::COLOR),
        6 if is_color(0) && is_normal(3) => {
            set(3, &Role::COLOR);
            set(6, &Role::NORMAL);
        }
        6 if is_normal(0) && is_color(3) => {
            set(3, &Role::NORMAL);
            set(6, &Role::COLOR);
        }
        7 if is_color(1) && is_normal(4) => {
            set(4, &Role::COLOR);
            set(7, &Role::NORMAL);
        }
        rest if rest > 2 && is_color(0) => set(3, &Role::COLOR),
        _ => {}
    }
    let unused = roles.iter().enumerate().skip(start).filter(|(_, role)| role.is_none());
    let unused = unused.map(|(i, _)| format!("column {}", i + 1)).collect();
    Columns { roles, unused }
}

/// Returns true if the first of four or more columns counts the rows and others do not.
fn are_numbered(rows: &[Vec<f64>]) -> bool {
    let counts = |pair: &[Vec<f64>]| pair[1][0] == pair[0][0] + 1.0;
    let starts = |row: &Vec<f64>| row.len() > 3 && matches!(row[0], 0.0 | 1.0);
    rows.len() > 2
        && starts(&rows[0])
        && rows.windows(2).all(counts)
        && rows.iter().any(|row| row[1..4].iter().all(|x| x.fract() != 0.0))
}

#[cfg(test)]
mod tests {
    use super::{Role, by_name, by_values};
    use Role::*;

    #[test]
    fn names_of_any_program_are_understood() {
        type Row<'a> = (&'a str, &'a [Option<Role>], &'a [&'a str]);
        let table: [Row<'_>; 9] = [
            ("x y z", &[Some(X), Some(Y), Some(Z)], &[]),
            ("\"Z\" 'Y' X(m)", &[Some(Z), Some(Y), Some(X)], &[]),
            ("id Easting Northing Elevation", &[None, Some(X), Some(Y), Some(Z)], &["id"]),
            ("Points:0 Points:1 Points:2", &[Some(X), Some(Y), Some(Z)], &[]),
            ("x y z r", &[Some(X), Some(Y), Some(Z), Some(Radius)], &[]),
            ("x y z r g", &[Some(X), Some(Y), Some(Z), Some(Radius), None], &["g"]),
            (
                "x_coord y_coord z_coord nx ny",
                &[Some(X), Some(Y), Some(Z), None, None],
                &["nx", "ny"],
            ),
            (
                "X Y Z Rf Gf Bf scalar_Intensity",
                &[Some(X), Some(Y), Some(Z), Some(Red), Some(Green), Some(Blue), None],
                &["scalar_Intensity"],
            ),
            (
                "x y z radius r g b",
                &[Some(X), Some(Y), Some(Z), Some(Radius), Some(Red), Some(Green), Some(Blue)],
                &[],
            ),
        ];
        for (names, roles, unused) in table {
            let columns = by_name(&names.split(' ').collect::<Vec<_>>()).expect(names);
            assert_eq!(columns.roles, roles, "{names}");
            assert_eq!(columns.unused, unused, "{names}");
        }
        assert_eq!(by_name(&["x", "y", "time"]), None);
    }

    #[test]
    fn values_tell_colours_intensities_and_normals_apart() {
        let position: &[Option<Role>] = &[Some(X), Some(Y), Some(Z)];
        type Row<'a> = (&'a str, &'a [&'a [f64]], bool, &'a [Option<Role>]);
        let table: [Row<'_>; 9] = [
            ("nothing", &[&[]], false, &[]),
            ("intensity", &[&[-1200.0]], false, &[Some(Intensity)]),
            ("bytes", &[&[255.0, 0.0, 7.0]], false, &[Some(Red), Some(Green), Some(Blue)]),
            ("words", &[&[65_535.0, 0.0, 7.0]], false, &[Some(Red), Some(Green), Some(Blue)]),
            ("shares", &[&[0.5, 0.25, 1.0]], false, &[Some(Red), Some(Green), Some(Blue)]),
            (
                "normals",
                &[&[0.6, 0.0, -0.8], &[0.0, 0.0, 1.0]],
                false,
                &[Some(NormalX), Some(NormalY), Some(NormalZ)],
            ),
            ("pts", &[&[9.0, 1.0, 2.0, 3.0]], true, &[None, Some(Red), Some(Green), Some(Blue)]),
            (
                "opaque",
                &[&[9.0, 1.0, 2.0, 255.0], &[9.0, 5.0, 2.0, 255.0]],
                false,
                &[Some(Red), Some(Green), Some(Blue), Some(Alpha)],
            ),
            (
                "colours and normals",
                &[&[9.0, 1.0, 2.0, 0.6, 0.8, 0.0]],
                false,
                &[Some(Red), Some(Green), Some(Blue), Some(NormalX), Some(NormalY), Some(NormalZ)],
            ),
        ];
        for (why, rows, is_pts, roles) in table {
            let rows: Vec<Vec<f64>> =
                rows.iter().map(|row| [&[-1.0, 500.0, 3.5], *row].concat()).collect();
            assert_eq!(by_values(&rows, 0, is_pts).roles, [position, roles].concat(), "{why}");
        }
    }
}
