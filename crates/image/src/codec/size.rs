//! Bounds on the size of an image, by the length of its file.

/// Upper bound on the compression ratio of all formats. Deflate, in PNG and EXR, reaches 1032. In
/// JPEG, a block of 64 samples takes at least one bit, and chroma subsampled four-fold makes that
/// 1365 bytes from one.
const MAX_COMPRESSION: u64 = 1400;

/// Largest number of pixels: 16,384 x 16,384.
pub(super) const MAX_PIXELS: u64 = 1 << 28;

/// Refuses sizes that no file of this length can hold, before anything is allocated for them.
pub(super) fn check_size(
    width: u64,
    height: u64,
    bits_per_pixel: u64,
    bytes: &[u8],
) -> Result<(), String> {
    let pixels = width.saturating_mul(height);
    if pixels > MAX_PIXELS {
        return Err(format!("{width} x {height} pixels are more than the {MAX_PIXELS} supported"));
    }
    if pixels.saturating_mul(bits_per_pixel) / 8 > bytes.len() as u64 * MAX_COMPRESSION {
        return Err(format!("{width} x {height} pixels cannot come from a file of this size"));
    }
    Ok(())
}
