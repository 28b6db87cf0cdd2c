//! Pages, charts and tables that several commands share.

pub mod chart;
pub mod compare;
pub mod console;
pub mod embed;

/// The style sheet of pages with charts.
pub const STYLE: &str = include_str!("style.css");
