//! Rust source as tokens: without comments, and without what only tests compile.

use anyhow::{Result, anyhow};
use proc_macro2::{Group, TokenStream, TokenTree};

/// Returns the tokens of a file that a build without tests compiles.
pub(crate) fn tokens(text: &str) -> Result<TokenStream> {
    // A rustfmt-formatted file has no byte-order mark and no shebang, which the lexer refuses.
    let stream: TokenStream = text.parse().map_err(|error| anyhow!("not Rust: {error}"))?;
    Ok(without_tests(stream))
}

/// Drops each item, up to its `;` or block, that stands below `#[cfg(test)]`.
fn without_tests(stream: TokenStream) -> TokenStream {
    let mut kept = Vec::new();
    let mut tokens = stream.into_iter().peekable();
    while let Some(token) = tokens.next() {
        if is_punct(&token, '#')
            && matches!(tokens.peek(), Some(TokenTree::Group(group)) if is_test_only(group))
        {
            // The braces of `use a::{b, c};` are not the end of the item, its semicolon is.
            let mut in_use = false;
            for token in tokens.by_ref().skip(1) {
                in_use |= is_ident(&token, "use");
                if is_punct(&token, ';') || (!in_use && is_braced(&token)) {
                    break;
                }
            }
            continue;
        }
        kept.push(match token {
            TokenTree::Group(group) => {
                let mut inside = Group::new(group.delimiter(), without_tests(group.stream()));
                inside.set_span(group.span());
                TokenTree::Group(inside)
            }
            token => token,
        });
    }
    kept.into_iter().collect()
}

fn is_test_only(attribute: &Group) -> bool {
    let text = attribute.stream().to_string().replace(' ', "");
    let has_test = text.split(|c: char| !c.is_alphanumeric()).any(|word| word == "test");
    text.starts_with("cfg(") && has_test && !text.contains("not(test")
}

pub(crate) fn is_punct(token: &TokenTree, character: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == character)
}

pub(crate) fn is_ident(token: &TokenTree, name: &str) -> bool {
    matches!(token, TokenTree::Ident(ident) if ident == name)
}

fn is_braced(token: &TokenTree) -> bool {
    matches!(token, TokenTree::Group(group) if group.delimiter() == proc_macro2::Delimiter::Brace)
}

#[cfg(test)]
mod tests {
    use super::tokens;

    #[test]
    fn comments_and_test_only_items_are_left_out() {
        let text = "// crate::a\n\
            #[cfg(test)] mod tests { use crate::b; }\n\
            #[cfg(test)] use crate::{b, c};\n\
            #[cfg(not(test))] fn kept() {}\n\
            fn also() { #[cfg(all(test, unix))] dropped(); kept(); }";
        let left = tokens(text).expect("Rust").to_string();
        assert_eq!(left.matches("kept").count(), 2, "{left}");
        assert!(!left.contains("crate") && !left.contains("dropped"), "{left}");
    }
}
