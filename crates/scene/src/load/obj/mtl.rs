//! Reader of MTL files, the materials of OBJ: `newmtl`, `Kd` and `map_Kd`.

use crate::load::{
    error::LoadProblem,
    file,
    mesh::{MeshMaterial, listed},
};
use glam::Vec3;
use std::collections::BTreeSet;

/// Reads the materials of a file; returns them with warnings.
pub(crate) fn read(bytes: &[u8]) -> Result<(Vec<MeshMaterial>, Vec<String>), LoadProblem> {
    let text = String::from_utf8_lossy(file::text(bytes)?);
    let mut materials: Vec<MeshMaterial> = Vec::new();
    let mut warnings = Vec::new();
    let mut unused = BTreeSet::new();
    let mut bad_lines = Vec::new();
    for (number, line) in (1..).zip(file::lines(&text)) {
        let said = line.trim_ascii();
        if said.starts_with('#') {
            continue;
        }
        let (keyword, rest) =
            said.split_once(|c: char| c.is_ascii_whitespace()).unwrap_or((said, ""));
        let rest = rest.trim();
        if keyword.eq_ignore_ascii_case("newmtl") {
            materials.push(MeshMaterial { name: rest.to_owned(), ..MeshMaterial::default() });
            continue;
        }
        let Some(material) = materials.last_mut() else { continue };
        match keyword.to_ascii_lowercase().as_str() {
            "kd" => match color(rest) {
                Some(color) => material.color = Some(color),
                None => bad_lines.push(number.to_string()),
            },
            "map_kd" => {
                let (options, name) = texture(rest);
                material.texture = name;
                unused.extend(options.iter().map(|option| format!("{option} of map_Kd")));
            }
            "" | "ka" | "ni" | "ns" | "illum" | "tf" | "sharpness" => {}
            _ if is_neutral(keyword, rest) => {}
            _ => drop(unused.insert(keyword.to_owned())),
        }
    }
    if !unused.is_empty() {
        let names: Vec<String> = unused.into_iter().collect();
        warnings.push(format!("not used of the materials: {}", listed(&names)));
    }
    if !bad_lines.is_empty() {
        warnings
            .push(format!("Kd is not three numbers in line {}; taken as grey", listed(&bad_lines)));
    }
    Ok((materials, warnings))
}

/// Returns true for statements that change nothing: full opacity, no emission.
fn is_neutral(keyword: &str, rest: &str) -> bool {
    let usual = match keyword.to_ascii_lowercase().as_str() {
        "d" => 1.0,
        "tr" | "ke" | "ks" | "pr" | "pm" | "ps" | "pc" | "pcr" | "aniso" | "anisor" => 0.0,
        _ => return false,
    };
    rest.split_ascii_whitespace().all(|word| word.parse() == Ok(usual))
}

/// Parses a colour: three numbers, or one for all channels.
fn color(rest: &str) -> Option<Vec3> {
    let numbers: Vec<f32> =
        rest.split_ascii_whitespace().map_while(|word| word.parse().ok()).collect();
    let color = match numbers[..] {
        [r, g, b, ..] => Vec3::new(r, g, b),
        [grey] => Vec3::splat(grey),
        _ => return None,
    };
    (color.is_finite() && color.min_element() >= 0.0).then_some(color)
}

/// Returns the name of a file, which may have blanks, after options such as `-s 2 2 1`, and those
/// options that would change what is seen.
fn texture(rest: &str) -> (Vec<&str>, Option<String>) {
    let mut options = Vec::new();
    let mut rest = rest;
    while rest.starts_with('-') {
        let Some((option, after)) = rest.split_once(|c: char| c.is_ascii_whitespace()) else {
            return (options, None);
        };
        rest = after.trim_start();
        let mut changes = false;
        let words = match option {
            "-o" | "-s" | "-t" => 3,
            "-mm" => 2,
            _ => 1,
        };
        for k in 0..words {
            let Some((word, after)) = rest.split_once(|c: char| c.is_ascii_whitespace()) else {
                return (options, None);
            };
            // Of three numbers, the second and third may be left out.
            let number = word.parse::<f32>();
            if k > 0 && number.is_err() {
                break;
            }
            changes |= match option {
                "-s" => number != Ok(1.0),
                "-o" | "-t" => number != Ok(0.0),
                "-mm" => number != Ok(k as f32),
                "-clamp" | "-cc" => word == "on",
                "-imfchan" | "-type" => true,
                _ => false,
            };
            rest = after.trim_start();
        }
        if changes {
            options.push(option);
        }
    }
    (options, (!rest.is_empty()).then(|| rest.trim_matches('"').to_owned()))
}
