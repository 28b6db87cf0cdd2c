//! Tests of the whole pipeline live beside this file, in `tests/`; those of the README's examples
//! are here.

#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
