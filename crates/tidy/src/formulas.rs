//! Formulas of intersection and shading in `xtask`: they belong to a library.

use crate::source::{is_punct, tokens};
use anyhow::{Context, Result};
use proc_macro2::{Ident, TokenStream, TokenTree};
use std::path::Path;

/// Operations on vectors and the functions that roots and angles need.
const CALLS: [&str; 24] = [
    "dot",
    "cross",
    "length",
    "length_squared",
    "normalize",
    "reflect",
    "refract",
    "lerp",
    "sqrt",
    "cbrt",
    "powi",
    "powf",
    "hypot",
    "mul_add",
    "sin",
    "cos",
    "tan",
    "sin_cos",
    "asin",
    "acos",
    "atan",
    "atan2",
    "exp",
    "ln",
];
/// Names that only such formulas use.
const NAMES: [&str; 4] = ["discriminant", "glam", "PI", "TAU"];
/// Vector types of any precision and size, as `Vec3` and `DAffine3`.
const TYPES: [&str; 4] = ["Vec", "Mat", "Affine", "Quat"];

/// Finds formulas in a source file of `xtask`, outside of its tests.
pub(crate) fn check(path: &Path, text: &str) -> Result<Vec<String>> {
    let is_source = path.starts_with("xtask/src") && path.extension().is_some_and(|e| e == "rs");
    if !is_source {
        return Ok(Vec::new());
    }
    let mut found = Vec::new();
    search(tokens(text).with_context(|| path.display().to_string())?, &mut found);
    let finding = |(line, what)| {
        format!(
            "{}:{line}: {what} is part of a formula, which belongs to a library",
            path.display()
        )
    };
    Ok(found.into_iter().map(finding).collect())
}

fn search(stream: TokenStream, found: &mut Vec<(usize, String)>) {
    let tokens: Vec<TokenTree> = stream.into_iter().collect();
    for (at, token) in tokens.iter().enumerate() {
        match token {
            TokenTree::Group(group) => search(group.stream(), found),
            TokenTree::Ident(ident) => {
                let called = matches!(tokens.get(at + 1), Some(TokenTree::Group(_)));
                let method =
                    at > 0 && (is_punct(&tokens[at - 1], '.') || is_punct(&tokens[at - 1], ':'));
                if is_vector_word(ident) || (called && method && CALLS.iter().any(|c| ident == c)) {
                    found.push((ident.span().start().line, ident.to_string()));
                }
            }
            _ => {}
        }
    }
    sums_of_products(&tokens, found);
}

fn is_vector_word(ident: &Ident) -> bool {
    let name = ident.to_string();
    let size = |rest: &str| rest.starts_with(|c: char| c.is_ascii_digit());
    let short = name.strip_prefix(['D', 'I', 'U', 'B']).unwrap_or(&name);
    NAMES.contains(&&*name)
        || TYPES
            .iter()
            .any(|word| [&name, short].iter().any(|n| n.strip_prefix(word).is_some_and(size)))
}

/// Finds squares, and sums or differences of two products: `h * h`, `a * d - b * c`.
fn sums_of_products(tokens: &[TokenTree], found: &mut Vec<(usize, String)>) {
    // The factors of the current term, and whether the term before it is a product.
    let (mut factors, mut before): (Vec<String>, bool) = (vec![String::new()], false);
    for (at, token) in tokens.iter().enumerate() {
        let binary = at > 0 && ends_operand(&tokens[at - 1]);
        let line = token.span().start().line;
        match token {
            TokenTree::Punct(punct) => match punct.as_char() {
                '*' if binary => factors.push(String::new()),
                '+' | '-' if binary => {
                    before = factors.len() > 1;
                    factors = vec![String::new()];
                }
                '.' | ':' | '/' | '&' | '-' | '*' => {
                    factors.last_mut().expect("one").push(punct.as_char());
                }
                _ => (factors, before) = (vec![String::new()], false),
            },
            TokenTree::Ident(ident) if is_keyword(ident) => {
                (factors, before) = (vec![String::new()], false);
            }
            operand => factors.last_mut().expect("one").push_str(&operand.to_string()),
        }
        // Only when the next token does not continue the operand is the factor complete.
        let goes_on = tokens.get(at + 1).is_some_and(|next| {
            is_punct(next, '.') || is_punct(next, ':') || matches!(next, TokenTree::Group(_))
        });
        if goes_on || factors.len() < 2 || !ends_operand(token) {
            continue;
        }
        let [.., one, other] = &factors[..] else { continue };
        let is_square = one == other && one.parse::<f64>().is_err();
        if is_square || (before && factors.len() == 2) {
            found.push((line, factors.join(" * ")));
        }
    }
}

/// Whether an operator after the token has it as its left operand.
fn ends_operand(token: &TokenTree) -> bool {
    match token {
        TokenTree::Ident(ident) => !is_keyword(ident),
        TokenTree::Literal(_) => true,
        TokenTree::Group(group) => group.delimiter() != proc_macro2::Delimiter::Brace,
        TokenTree::Punct(_) => false,
    }
}

fn is_keyword(ident: &Ident) -> bool {
    let words = ["let", "mut", "if", "else", "return", "in", "as", "match", "move", "ref", "const"];
    words.iter().any(|word| ident == word)
}

#[cfg(test)]
mod tests {
    use super::check;
    use std::path::Path;

    fn count(path: &str, text: &str) -> usize {
        check(Path::new(path), text).expect("Rust").len()
    }

    #[test]
    fn a_planted_formula_is_found() {
        let table = [
            ("a discriminant", "fn f() { let d = b * b - a * c; }"),
            ("one of unit directions", "fn f() { let d = h * h - c; }"),
            ("a textbook one", "fn f() { let d = b*b-4.0*a*c; }"),
            ("of fields", "fn f() { let d = q.b * q.b - c; }"),
            ("a determinant", "fn f() { if a * d - b * c > 0.0 {} }"),
            ("a dot product", "fn f() { x[0] * y[0] + x[1] * y[1] }"),
            ("a vector", "use glam_like::Vec3;"),
            ("a wide vector", "fn f(d: DVec3) {}"),
            ("a transform", "fn f(d: DAffine3) {}"),
            ("a root", "fn f() { g(x.sqrt()) }"),
            ("a root by path", "fn f() { f64::sqrt(x) }"),
            ("a product of vectors", "fn f() { n.dot(d) }"),
            ("an angle", "const A: f32 = std::f32::consts::PI / 4.0;"),
            ("in a macro", "fn f() { say!(n.cross(d)) }"),
        ];
        for (why, text) in table {
            assert!(count("xtask/src/moved.rs", text) > 0, "{why}");
        }
    }

    #[test]
    fn other_arithmetic_tests_and_libraries_are_left_alone() {
        let table = [
            (
                "a table",
                "fn f() { let x = 100.0 * count as f64 / of; g(a + b * c, *d - 1, &a * 2) }",
            ),
            ("a vector of words", "fn f(v: Vec<&str>, w: Vec<f64>) -> usize { v.len() }"),
            ("a comment", "// b * b - a * c and Vec3\nfn f() {}"),
            ("a string", "const S: &str = \"Vec3 b * b\";"),
            ("a test", "#[cfg(test)]\nmod tests { use glam::Vec3; fn f() { a * a; } }"),
            ("dereferences", "fn f() { (*a, *b, *a - *b) }"),
        ];
        for (why, text) in table {
            assert_eq!(count("xtask/src/moved.rs", text), 0, "{why}");
        }
        assert_eq!(count("crates/geometry/src/sphere.rs", "use glam::Vec3;"), 0);
        assert_eq!(count("xtask/README.md", "Vec3"), 0);
    }
}
