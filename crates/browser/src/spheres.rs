//! A file of many spheres, for measurements.

use anyhow::Result;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

/// Writes a PLY file of `count` spheres at random places in a cube; returns its path.
pub(crate) fn write(folder: &Path, count: u32) -> Result<PathBuf> {
    let path = folder.join("spheres.ply");
    let mut file = BufWriter::new(std::fs::File::create(&path)?);
    write!(
        file,
        "ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty float x\n\
         property float y\nproperty float z\nproperty float radius\nend_header\n"
    )?;
    // Multiplicative congruence modulo 2^64 (L'Ecuyer 1999); its upper bits are good enough here.
    let mut state = 1_u64;
    let mut next = || {
        state = state.wrapping_mul(2_862_933_555_777_941_757).wrapping_add(1);
        (state >> 40) as f32 / (1 << 24) as f32
    };
    for _ in 0..count {
        for value in [next(), next(), next(), 0.002 + 0.004 * next()] {
            file.write_all(&value.to_le_bytes())?;
        }
    }
    file.flush()?;
    Ok(path)
}
