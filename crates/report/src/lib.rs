//! Pages, charts and tables about renders and measurements, which the commands of Rotund share.
//!
//! A page is one HTML file that opens offline: images are embedded as data URIs, and neither
//! scripts nor style sheets are loaded. The crate knows images and numbers, but no scene and no
//! renderer.
//!
//! - [`html`]: the skeleton of a page, its style sheet, and [`html::escape`];
//! - [`chart`]: logarithmic charts in SVG;
//! - [`embed`]: images as data URIs;
//! - [`console`]: text and tables on standard output;
//! - [`compare`]: the page about two renders of a scene.

pub mod chart;
pub mod compare;
pub mod console;
pub mod embed;
pub mod html;
