//! The quantities that a picture can show.

use std::fmt;
use std::str::FromStr;

/// The quantity that a picture shows. All views but the first two show the first surface of a
/// camera ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum View {
    /// Radiance, by path tracing.
    #[default]
    Path,
    /// Radiance in a white furnace: every direction sends radiance 1 and nothing else emits.
    /// Surfaces that conserve energy are white, and none is brighter.
    Furnace,
    /// Surface colours lit by a lamp at the eye: a quick preview.
    Eyelight,
    /// Position relative to the bounds of the scene.
    Position,
    /// Geometric normal out of the solid, in world space; `-1.0..=1.0` is shown as `0.0..=1.0`.
    GeometricNormal,
    /// Shading normal, shown like the geometric normal.
    ShadingNormal,
    /// Parameters of the element as red and green.
    Uv,
    /// Fractional parts of the texture coordinates as red and green.
    Texcoord,
    /// A distinct colour for each element.
    Element,
    /// A distinct colour for each instance.
    Instance,
    /// Intersection method: blue for enhanced, orange for vanilla, grey for triangles, which have
    /// one.
    Method,
    /// A distinct colour for each material.
    Material,
    /// Error bound of the hit, in units of the roundoff of its largest coordinate: blue for none,
    /// green for 31, red for 1023 and more, on a logarithmic scale.
    Error,
}

impl View {
    /// All views, in the order of their declaration.
    pub const ALL: [Self; 13] = [
        Self::Path,
        Self::Furnace,
        Self::Eyelight,
        Self::Position,
        Self::GeometricNormal,
        Self::ShadingNormal,
        Self::Uv,
        Self::Texcoord,
        Self::Element,
        Self::Instance,
        Self::Method,
        Self::Material,
        Self::Error,
    ];

    /// Returns the name on a command line, which [`str::parse`] reads back: `geometric-normal`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Path => "path",
            Self::Furnace => "furnace",
            Self::Eyelight => "eyelight",
            Self::Position => "position",
            Self::GeometricNormal => "geometric-normal",
            Self::ShadingNormal => "shading-normal",
            Self::Uv => "uv",
            Self::Texcoord => "texcoord",
            Self::Element => "element",
            Self::Instance => "instance",
            Self::Method => "method",
            Self::Material => "material",
            Self::Error => "error",
        }
    }

    /// Returns one line of help.
    #[must_use]
    pub fn description(self) -> &'static str {
        match self {
            Self::Path => "Radiance, by path tracing",
            Self::Furnace => "Radiance in a white furnace: surfaces that conserve energy are white",
            Self::Eyelight => "Surface colours lit by a lamp at the eye: a quick preview",
            Self::Position => "Position relative to the bounds of the scene",
            Self::GeometricNormal => "Geometric normal",
            Self::ShadingNormal => "Shading normal",
            Self::Uv => "Parameters of the element as red and green",
            Self::Texcoord => "Texture coordinates as red and green",
            Self::Element => "A distinct colour for each element",
            Self::Instance => "A distinct colour for each instance",
            Self::Method => "Blue for enhanced, orange for vanilla, grey for triangles",
            Self::Material => "A distinct colour for each material",
            Self::Error => {
                "Error bound of the hit: blue for none, green for 31 roundoffs, red for 1023"
            }
        }
    }
}

impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The error of a name that no view has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no view {name:?}; the views are {}", View::ALL.map(View::name).join(", "))]
pub struct UnknownView {
    /// The name.
    pub name: String,
}

impl FromStr for View {
    type Err = UnknownView;

    fn from_str(name: &str) -> Result<Self, UnknownView> {
        let found = Self::ALL.into_iter().find(|view| view.name() == name);
        found.ok_or_else(|| UnknownView { name: name.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::View;

    #[test]
    fn every_name_is_read_back_and_others_are_refused() {
        for view in View::ALL {
            assert_eq!(view.to_string().parse(), Ok(view));
        }
        let error = "normals".parse::<View>().expect_err("no view").to_string();
        assert!(error.starts_with("there is no view \"normals\"; the views are path, "), "{error}");
    }
}
