//! Circles between the files of a crate.
//!
//! A file depends on the file that defines what it names, also through re-exports. A module and
//! what lies below it are front and rooms: they may name each other. Among the modules of one
//! parent, each with all that lies below it, nothing may lead back to where it started.

use crate::modules::Modules;
use anyhow::Result;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::{Path, PathBuf};

/// What one file takes from another.
#[derive(Clone, Debug)]
struct Need {
    from: PathBuf,
    name: String,
    to: PathBuf,
}

/// For each parent, which of its modules needs which other one, and what for.
type Needs = BTreeMap<usize, BTreeMap<usize, BTreeMap<usize, Need>>>;

/// Finds the circles of every crate among the files.
pub(crate) fn check(files: &[(PathBuf, String)]) -> Result<Vec<String>> {
    let table: BTreeMap<&Path, &str> = files.iter().map(|(p, t)| (&**p, &**t)).collect();
    let is_root = |path: &&&Path| path.ends_with("src/lib.rs") || path.ends_with("src/main.rs");
    let mut findings = Vec::new();
    for root in table.keys().filter(is_root) {
        let needs = needs(&Modules::read(root, &table)?);
        findings.extend(needs.values().flat_map(circles).map(|circle| describe(&circle)));
    }
    Ok(findings)
}

fn needs(modules: &Modules) -> Needs {
    let mut needs = Needs::new();
    for (scope, module) in modules.0.iter().enumerate() {
        for path in &module.paths {
            let Some(target) = modules.resolve(scope, path) else { continue };
            let (above, above_target) = (ancestry(modules, scope), ancestry(modules, target));
            let apart = above.iter().zip(&above_target).position(|(a, b)| a != b);
            // Without a difference one lies below the other. At 0 is the root, so none differs
            // there.
            let Some(apart) = apart else { continue };
            let to = &modules.0[target].file;
            if module.file != *to {
                needs
                    .entry(above[apart - 1])
                    .or_default()
                    .entry(above[apart])
                    .or_default()
                    .entry(above_target[apart])
                    .or_insert_with(|| Need {
                        from: module.file.clone(),
                        name: path.last().cloned().unwrap_or_default(),
                        to: to.clone(),
                    });
            }
        }
    }
    needs
}

/// The modules from the root down to `module`.
fn ancestry(modules: &Modules, module: usize) -> Vec<usize> {
    let mut above: Vec<usize> =
        std::iter::successors(Some(module), |&at| modules.0[at].parent).collect();
    above.reverse();
    above
}

/// The shortest circle through each module that is in none of those found before.
fn circles(needs: &BTreeMap<usize, BTreeMap<usize, Need>>) -> Vec<Vec<Need>> {
    let mut seen = BTreeSet::new();
    let mut circles = Vec::new();
    for &start in needs.keys() {
        let circle = if seen.contains(&start) { None } else { way_back(needs, start) };
        if let Some(circle) = circle {
            seen.extend(circle.iter().map(|(module, _)| *module));
            circles.push(circle.into_iter().map(|(_, need)| need).collect());
        }
    }
    circles
}

/// The shortest way from a module back to itself, if there is one.
fn way_back(
    needs: &BTreeMap<usize, BTreeMap<usize, Need>>,
    start: usize,
) -> Option<Vec<(usize, Need)>> {
    let mut ways = VecDeque::from([(start, Vec::new())]);
    let mut reached = BTreeSet::new();
    while let Some((at, way)) = ways.pop_front() {
        for (&to, need) in needs.get(&at).into_iter().flatten() {
            let mut longer = way.clone();
            longer.push((at, need.clone()));
            if to == start {
                return Some(longer);
            }
            if reached.insert(to) {
                ways.push_back((to, longer));
            }
        }
    }
    None
}

fn describe(circle: &[Need]) -> String {
    let steps: Vec<String> = circle
        .iter()
        .map(|Need { from, name, to }| {
            format!("{} uses {name} of {}", from.display(), to.display())
        })
        .collect();
    format!("circle: {}", steps.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(files: &[(&str, &str)]) -> Vec<String> {
        let files: Vec<(PathBuf, String)> = files
            .iter()
            .map(|(path, text)| (["c/src/", path].concat().into(), (*text).into()))
            .collect();
        check(&files).expect("the files are Rust")
    }

    #[test]
    fn a_planted_circle_is_found_with_the_names_taken() {
        let table = [
            ("by use", "use crate::b::B; pub struct A;", "use super::a::A; pub struct B;"),
            ("by a tree of use", "use crate::{b::{self, B}}; pub struct A;", "use crate::a::*;"),
            ("by paths", "fn a() { super::b::b() }", "pub fn b() { crate::a::a() }"),
            ("through re-exports", "use crate::B; pub struct A;", "use crate::A; pub struct B;"),
            (
                "in a block",
                "mod inner { use crate::b::B; } pub struct A;",
                "use crate::A; pub struct B;",
            ),
            ("in a macro", "m! { crate::b::B } pub struct A;", "use crate::A; pub struct B;"),
        ];
        for (why, a, b) in table {
            let lib = "mod a; mod b; pub use a::A; pub use b::B;";
            let found = found(&[("lib.rs", lib), ("a.rs", a), ("b.rs", b)]);
            assert_eq!(found.len(), 1, "{why}: {found:?}");
            assert!(found[0].starts_with("circle: c/src/a.rs uses "), "{why}: {found:?}");
            assert!(found[0].contains("; c/src/b.rs uses "), "{why}: {found:?}");
        }
    }

    #[test]
    fn circles_of_three_files_and_of_folders_are_found() {
        let lib = ("lib.rs", "mod a; mod b; mod c;");
        let three =
            [lib, ("a.rs", "use crate::b;"), ("b.rs", "use crate::c;"), ("c.rs", "use crate::a;")];
        assert_eq!(found(&three).len(), 1);
        // No file is in a circle with another one, but the folder b is with the file a.
        let folders = [
            lib,
            ("a.rs", "use crate::b::x::X; pub struct A;"),
            ("b/mod.rs", "pub mod x; mod y;"),
            ("b/x.rs", "pub struct X;"),
            ("b/y.rs", "use crate::a::A;"),
            ("c.rs", ""),
        ];
        assert_eq!(
            found(&folders),
            ["circle: c/src/a.rs uses X of c/src/b/x.rs; c/src/b/y.rs uses A of c/src/a.rs"]
        );
    }

    #[test]
    fn fronts_tests_and_comments_make_no_circle() {
        let files = [
            ("lib.rs", "mod a; mod b; pub use a::A; pub fn f() { a::g() }"),
            ("a/mod.rs", "mod room; use room::R; pub struct A; pub fn g() {}"),
            ("a/room.rs", "use super::A; use crate::f; pub struct R;"),
            (
                "b.rs",
                "// crate::a::A uses crate::b\nuse crate::a::A; const S: &str = \"crate::b\";",
            ),
            ("main.rs", "fn main() {}"),
        ];
        assert_eq!(found(&files), [""; 0]);
        let files = [
            ("lib.rs", "mod a; mod b;"),
            ("a.rs", "pub struct A; #[cfg(test)] mod tests { use crate::b::B; }"),
            ("b.rs", "use crate::a::A; pub struct B;"),
        ];
        assert_eq!(found(&files), [""; 0]);
    }
}
