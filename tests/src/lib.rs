//! Tests of the whole pipeline live beside this file, in `tests/`.
