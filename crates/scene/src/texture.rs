//! Images on surfaces.

/// An image of RGBA pixels, row 0 at `v = 0`.
#[derive(Clone, Debug)]
pub struct Texture {
    /// For messages.
    pub name: String,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row by row.
    pub pixels: Pixels,
}

/// Pixels as they are stored in files of each kind.
#[derive(Clone, Debug)]
pub enum Pixels {
    /// 8 bits a channel: sRGB where a colour is meant, else read as it is.
    Bytes(Vec<[u8; 4]>),
    /// Linear.
    Floats(Vec<[f32; 4]>),
}
