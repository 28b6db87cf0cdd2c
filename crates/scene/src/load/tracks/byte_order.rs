//! Numbers of either byte order.

use glam::DVec3;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ByteOrder {
    Little,
    Big,
}

impl ByteOrder {
    pub(super) fn i16(self, bytes: [u8; 2]) -> i16 {
        match self {
            Self::Little => i16::from_le_bytes(bytes),
            Self::Big => i16::from_be_bytes(bytes),
        }
    }

    pub(super) fn i32(self, bytes: [u8; 4]) -> i32 {
        match self {
            Self::Little => i32::from_le_bytes(bytes),
            Self::Big => i32::from_be_bytes(bytes),
        }
    }

    pub(super) fn f32(self, bytes: [u8; 4]) -> f32 {
        match self {
            Self::Little => f32::from_le_bytes(bytes),
            Self::Big => f32::from_be_bytes(bytes),
        }
    }

    pub(super) fn f64(self, bytes: [u8; 8]) -> f64 {
        match self {
            Self::Little => f64::from_le_bytes(bytes),
            Self::Big => f64::from_be_bytes(bytes),
        }
    }

    /// Decodes three numbers of four bytes each.
    pub(super) fn point_f32(self, bytes: &[u8; 12]) -> DVec3 {
        let (words, _) = bytes.as_chunks();
        DVec3::new(
            f64::from(self.f32(words[0])),
            f64::from(self.f32(words[1])),
            f64::from(self.f32(words[2])),
        )
    }

    /// Decodes three numbers of eight bytes each.
    pub(super) fn point_f64(self, bytes: &[u8; 24]) -> DVec3 {
        let (words, _) = bytes.as_chunks();
        DVec3::new(self.f64(words[0]), self.f64(words[1]), self.f64(words[2]))
    }
}
