//! Pages, charts and tables that several commands share.

pub mod chart;
pub mod compare;
pub mod console;
pub mod embed;
pub mod html;
