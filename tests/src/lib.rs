//! Runs the examples on the pages of the workspace and of its crates as tests. The tests of the
//! whole pipeline are in `tests/`.

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
#[doc = include_str!("../../crates/denoise/README.md")]
struct Denoise;

#[cfg(doctest)]
#[doc = include_str!("../../crates/report/README.md")]
struct Report;

#[cfg(doctest)]
#[doc = include_str!("../../docs/golden-pictures.md")]
struct GoldenPictures;
