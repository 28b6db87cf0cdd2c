//! The choice between the exact shapes and their usual approximations.

use core::{error, fmt, str::FromStr};

/// Selects the shapes that points, lines and quads stand for. Triangles are the same with both.
///
/// | method | point | line | quad |
/// | --- | --- | --- | --- |
/// | `Vanilla` | [`Point`] | [`Line`] | [`Quad`] |
/// | `Enhanced` | [`Sphere`] | [`RoundedCone`] | [`BilinearPatch`] |
///
/// [`Point`]: crate::vanilla::Point
/// [`Line`]: crate::vanilla::Line
/// [`Quad`]: crate::vanilla::Quad
/// [`Sphere`]: crate::Sphere
/// [`RoundedCone`]: crate::RoundedCone
/// [`BilinearPatch`]: crate::BilinearPatch
///
/// The name of a method, in lower case, is also its form in scene files, on the command line and
/// with the feature `serde`:
///
/// ```
/// use rotund_geometry::Method;
///
/// assert_eq!("vanilla".parse(), Ok(Method::Vanilla));
/// assert_eq!(Method::Enhanced.to_string(), "enhanced");
/// let error = "embree".parse::<Method>().unwrap_err();
/// assert_eq!(error.to_string(), r#"unknown method "embree": expected "vanilla" or "enhanced""#);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Method {
    /// The usual approximations: discs and ribbons that face the ray, and pairs of triangles.
    Vanilla,
    /// The exact shapes: spheres, rounded cones and bilinear patches.
    #[default]
    Enhanced,
}

impl Method {
    /// Both methods.
    pub const ALL: [Self; 2] = [Self::Vanilla, Self::Enhanced];

    /// Returns the name in lower case, which [`FromStr`] reads.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Vanilla => "vanilla",
            Self::Enhanced => "enhanced",
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        Self::ALL
            .into_iter()
            .find(|method| method.name() == name)
            .ok_or_else(|| UnknownMethod::new(name))
    }
}

/// Error of [`Method::from_str`]: the text is not the name of a method. The message names its first
/// 32 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownMethod {
    /// The start of the text, in UTF-8: this crate has no allocator.
    start: [u8; Self::CAPACITY],
    /// The bytes of `start` that are used; they end with a whole character.
    len: usize,
    is_cut: bool,
}

impl UnknownMethod {
    const CAPACITY: usize = 32;

    fn new(name: &str) -> Self {
        let fits = |&len: &usize| name.is_char_boundary(len);
        let len = (0..=name.len().min(Self::CAPACITY)).rev().find(fits).unwrap_or(0);
        let mut start = [0; Self::CAPACITY];
        start[..len].copy_from_slice(&name.as_bytes()[..len]);
        Self { start, len, is_cut: len < name.len() }
    }
}

impl fmt::Display for UnknownMethod {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, second] = Method::ALL;
        let start = core::str::from_utf8(&self.start[..self.len]).unwrap_or_default();
        let rest = if self.is_cut { "..." } else { "" };
        write!(formatter, "unknown method {start:?}{rest}: expected \"{first}\" or \"{second}\"")
    }
}

impl error::Error for UnknownMethod {}
