//! An image as a renderer makes it.

/// Linear RGB and coverage, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue and alpha.
    pub pixels: Vec<[f32; 4]>,
}
