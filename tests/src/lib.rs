//! Tests of the whole pipeline live beside this file, in `tests/`; those of the examples on the pages of
//! the workspace and of its crates are here.

#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;

#[cfg(doctest)]
#[doc = include_str!("../../crates/geometry/README.md")]
struct Geometry;

#[cfg(doctest)]
#[doc = include_str!("../../crates/bvh/README.md")]
struct Bvh;

#[cfg(doctest)]
#[doc = include_str!("../../crates/scene/README.md")]
struct Scene;

#[cfg(doctest)]
#[doc = include_str!("../../crates/trace/README.md")]
struct Trace;

#[cfg(doctest)]
#[doc = include_str!("../../crates/image/README.md")]
struct Image;

#[cfg(doctest)]
#[doc = include_str!("../../crates/golden/README.md")]
struct Golden;

#[cfg(doctest)]
#[doc = include_str!("../../crates/report/README.md")]
struct Report;
