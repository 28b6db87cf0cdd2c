//! The two pictures of a comparison.

use serde::Serialize;

/// Which of two pictures that are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// By the methods of the settings.
    Chosen,
    /// All kinds vanilla.
    Vanilla,
}

impl Side {
    /// Both sides, in the order of their indices.
    pub(crate) const ALL: [Self; 2] = [Self::Chosen, Self::Vanilla];
}
