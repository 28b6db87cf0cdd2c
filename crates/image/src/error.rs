//! Why two images cannot be compared.

use crate::Image;

/// Why two images cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say it")]
pub enum CompareError {
    #[error("the images differ in size: {} x {} and {} x {}", a[0], a[1], b[0], b[1])]
    Size { a: [u32; 2], b: [u32; 2] },
    #[error("the images have no pixel that is finite in both")]
    NothingFinite,
    #[error("an image of {width} x {height} holds {count} pixels")]
    PixelCount { width: u32, height: u32, count: usize },
}

/// Checks that two images can be compared pixel by pixel.
pub(crate) fn same_size(a: &Image, b: &Image) -> Result<(), CompareError> {
    for &Image { width, height, ref pixels } in [a, b] {
        if pixels.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(CompareError::PixelCount { width, height, count: pixels.len() });
        }
    }
    if (a.width, a.height) != (b.width, b.height) {
        return Err(CompareError::Size { a: [a.width, a.height], b: [b.width, b.height] });
    }
    Ok(())
}
